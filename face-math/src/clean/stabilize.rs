//! Holds the head still: removes the head's motion from a take, frame by frame, so that what is left is the face's. FDLS
//! requires it ("performance capture that has been stabilized to remove rigid motion of the skull", section 1).
//!
//! In each frame the rigid markers are where a rigid motion took them from their places at rest, x = R x₀ + t (metres);
//! [`steady`](super::steady) finds it, and every marker goes back by Rᵀ (x − t). R = Rz(rz) Ry(ry) Rx(rx), radians, as
//! everywhere here.

use super::calm_motion::{calm_motion, shrink_motion};
use super::steady::steady;
use crate::data::{Curves, DataError, Markers, nearest_name};
use crate::rig::Rigid;
use glam::{DMat3, DVec3, Vec3};

/// Channels of a head's motion: translation in metres, rotation in radians.
pub const MOTION_CHANNELS: [&str; 6] = ["tx", "ty", "tz", "rx", "ry", "rz"];

/// The outcome of [`stabilize`].
#[derive(Debug, Clone, PartialEq)]
pub struct Stabilized {
    /// The markers in the frame of the face at rest; all missing (NaN) in frames whose motion could not be told.
    pub markers: Markers,
    /// The motion that was removed: `tx`, `ty`, `tz` in metres, `rx`, `ry`, `rz` in radians; NaN where it could not be
    /// told.
    pub motion: Curves,
    /// `residual_mm`, the root mean square distance at which the rigid markers meet the motion, and `used`, how many of
    /// them it rests on.
    pub fit: Curves,
    /// How many frames have too few rigid markers that agree.
    pub lost_frames: usize,
}

/// Why a take cannot be stabilised.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StabilizeError {
    /// The face at rest has more than its one frame, or none.
    #[error("the face at rest has {frames} frames; give exactly one")]
    NeutralFrames {
        /// Its frames.
        frames: usize,
    },
    /// The posed face has other frames than the take.
    #[error("the posed face has {posed} frames, the take {take}; solve the same take")]
    PosedFrames {
        /// Its frames.
        posed: usize,
        /// Those of the take.
        take: usize,
    },
    /// A rigid marker has no place at rest, or none in the take.
    #[error("rigid marker `{marker}` {lacks}{}; choose markers that both have", near.as_ref().map(|near| format!(" (did you mean `{near}`?)")).unwrap_or_default())]
    Unplaced {
        /// The marker.
        marker: String,
        /// What lacks it.
        lacks: &'static str,
        /// The nearest name there is.
        near: Option<String>,
    },
    /// Too few rigid markers.
    #[error("{count} rigid markers; a motion needs at least three that are not on one line")]
    TooFew {
        /// The markers.
        count: usize,
    },
    /// The tolerance is no positive number.
    #[error("the tolerance is {value} m; give a positive number")]
    Tolerance {
        /// Its value.
        value: f64,
    },
    /// The results do not fit together.
    #[error(transparent)]
    Data(#[from] DataError),
}

/// How to stabilise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StabilizeOptions {
    /// Rigid markers farther than this from where the head's motion takes them do not count, in metres.
    pub tolerance_m: f64,
    /// The motion is calmed over so many frames ([`calm_motion`]); 0 for not at all.
    pub smoothing_frames: f64,
    /// Motions below this count as none ([`shrink_motion`]), in metres; 0 for none of them.
    pub least_motion_m: f64,
}

impl Default for StabilizeOptions {
    fn default() -> Self {
        Self { tolerance_m: 0.002, smoothing_frames: 0.0, least_motion_m: 0.0 }
    }
}

/// Stabilises `take` (metres) by the markers `rigid`, whose places at rest stand in the one frame of `neutral`. Where a solve of the
/// take is known, `posed` are the same markers as its puppet moves them, frame by frame: they then stand in for the places at
/// rest, so that markers that move with the face tell of the head too.
///
/// # Errors
/// Where `neutral` has not one frame or `posed` not those of the take, fewer than three rigid markers are given, one of them has
/// no place, or the tolerance is not positive.
pub fn stabilize(
    take: &Markers,
    neutral: &Markers,
    posed: Option<&Markers>,
    rigid: &[String],
    options: &StabilizeOptions,
) -> Result<Stabilized, StabilizeError> {
    if neutral.frames() != 1 {
        return Err(StabilizeError::NeutralFrames { frames: neutral.frames() });
    }
    let StabilizeOptions { tolerance_m, smoothing_frames, least_motion_m } = *options;
    if !(tolerance_m > 0.0 && tolerance_m.is_finite()) {
        return Err(StabilizeError::Tolerance { value: tolerance_m });
    }
    if rigid.len() < 3 {
        return Err(StabilizeError::TooFew { count: rigid.len() });
    }
    let places = rigid.iter().map(|name| placed(name, take, neutral)).collect::<Result<Vec<_>, _>>()?;
    let own_places = posed.map(|posed| posed_columns(posed, take, rigid)).transpose()?;
    let mut found = Vec::with_capacity(take.frames());
    for frame in 0..take.frames() {
        let points = take.frame(frame);
        let place = |index: usize| match (posed, &own_places) {
            (Some(posed), Some(columns)) => posed.frame(frame)[columns[index]].as_dvec3(),
            _ => places[index].1,
        };
        let pairs = places.iter().enumerate().map(|(index, (column, _))| (points[*column].as_dvec3(), place(index)));
        let (seen, rest): (Vec<DVec3>, Vec<DVec3>) =
            pairs.filter(|(seen, place)| seen.is_finite() && place.is_finite()).unzip();
        found.push(steady(&rest, &seen, tolerance_m));
    }
    let centre = places.iter().map(|(_, place)| *place).sum::<DVec3>() / places.len() as f64;
    let own: Vec<Option<Rigid>> = found.iter().map(|found| found.as_ref().map(|found| found.motion)).collect();
    let rest: Vec<DVec3> = places.iter().map(|(_, place)| *place).collect();
    let calm = calm_motion(&own, centre, smoothing_frames).into_iter();
    let calm = calm.map(|motion| Some(shrink_motion(&motion?, &rest, least_motion_m)));
    let mut positions = Vec::with_capacity(take.positions().len());
    let (mut motions, mut fits) = (Vec::new(), Vec::new());
    let mut lost_frames = 0;
    for (frame, (found, motion)) in found.iter().zip(calm).enumerate() {
        let points = take.frame(frame);
        if let (Some(found), Some(motion)) = (found, motion) {
            let back = motion.inverse();
            positions.extend(points.iter().map(|point| back.apply(point.as_dvec3()).as_vec3()));
            motions.extend(channels(&motion).map(|value| value as f32));
            let used = found.used.iter().filter(|used| **used).count();
            fits.extend([1000.0 * found.residual_m as f32, used as f32]);
        } else {
            lost_frames += 1;
            positions.extend(points.iter().map(|_| Vec3::NAN));
            motions.extend([f32::NAN; 6]);
            fits.extend([f32::NAN, 0.0]);
        }
    }
    let axis = take.frame_axis();
    let named = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    Ok(Stabilized {
        markers: take.with_positions(positions)?,
        motion: Curves::new(axis, named(&MOTION_CHANNELS), motions)?,
        fit: Curves::new(axis, named(&["residual_mm", "used"]), fits)?,
        lost_frames,
    })
}

/// Column in the take and place at rest of a rigid marker.
fn placed(name: &str, take: &Markers, neutral: &Markers) -> Result<(usize, DVec3), StabilizeError> {
    let missing = |lacks, markers: &Markers| {
        let near = nearest_name(name, markers.names().iter().map(String::as_str));
        StabilizeError::Unplaced { marker: name.to_owned(), lacks, near }
    };
    let column = take.index(name).ok_or_else(|| missing("is not in the take", take))?;
    let place = neutral.index(name).ok_or_else(|| missing("is not on the face at rest", neutral))?;
    let place = neutral.frame(0)[place].as_dvec3();
    if place.is_finite() {
        Ok((column, place))
    } else {
        let lacks = "is missing on the face at rest";
        Err(StabilizeError::Unplaced { marker: name.to_owned(), lacks, near: None })
    }
}

/// Columns of the rigid markers on the posed face.
fn posed_columns(posed: &Markers, take: &Markers, rigid: &[String]) -> Result<Vec<usize>, StabilizeError> {
    if posed.frames() != take.frames() {
        return Err(StabilizeError::PosedFrames { posed: posed.frames(), take: take.frames() });
    }
    let column = |name: &String| {
        posed.index(name).ok_or_else(|| StabilizeError::Unplaced {
            marker: name.clone(),
            lacks: "is not on the posed face",
            near: nearest_name(name, posed.names().iter().map(String::as_str)),
        })
    };
    rigid.iter().map(column).collect()
}

/// The six channels of a motion.
fn channels(motion: &Rigid) -> [f64; 6] {
    let r = motion.rotation.to_cols_array_2d();
    let t = motion.translation_m;
    // R = Rz Ry Rx has −sin ry below its first column's end, cos ry (cos rz, sin rz) above it.
    let rx = r[1][2].atan2(r[2][2]);
    let ry = (-r[0][2]).atan2(r[0][0].hypot(r[0][1]));
    let rz = r[0][1].atan2(r[0][0]);
    [t.x, t.y, t.z, rx, ry, rz]
}

/// The motion that six channels hold, in the order of [`MOTION_CHANNELS`] (metres, radians).
pub fn motion_of(channels: [f64; 6]) -> Rigid {
    let [tx, ty, tz, rx, ry, rz] = channels;
    let rotation = DMat3::from_rotation_z(rz) * DMat3::from_rotation_y(ry) * DMat3::from_rotation_x(rx);
    Rigid { rotation, translation_m: DVec3::new(tx, ty, tz) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;
    use wire::FrameAxis;

    fn neutral() -> Markers {
        let mut dice = Dice(31);
        let names = (0..12).map(|index| if index < 4 { format!("head_{index}") } else { format!("skin_{index}") });
        let positions = (0..12).map(|_| dice.point() * 0.1).collect();
        Markers::new(FrameAxis::new(1, 1.0), names.collect(), positions).unwrap()
    }

    fn tolerance(tolerance_m: f64) -> StabilizeOptions {
        StabilizeOptions { tolerance_m, ..StabilizeOptions::default() }
    }

    fn rigid() -> Vec<String> {
        (0..4).map(|index| format!("head_{index}")).collect()
    }

    fn motion(frame: usize) -> Rigid {
        let time = frame as f64 * 0.05;
        motion_of([0.1 * time, 1.5, 0.02 * time.sin(), 0.4 * time.sin(), 0.9 * time.cos(), 2.0 * time])
    }

    /// The face moves, then the head with it.
    fn take() -> (Markers, Markers) {
        let (neutral, frames) = (neutral(), 60);
        let (mut still, mut moved) = (Vec::new(), Vec::new());
        for frame in 0..frames {
            for (column, place) in neutral.frame(0).iter().enumerate() {
                let skin = if column < 4 { Vec3::ZERO } else { Vec3::Y * 0.01 * (frame as f32 * 0.3).sin() };
                still.push(*place + skin);
                moved.push(motion(frame).apply((*place + skin).as_dvec3()).as_vec3());
            }
        }
        let made = |positions| Markers::new(FrameAxis::new(frames, 60.0), neutral.names().to_vec(), positions).unwrap();
        (made(still), made(moved))
    }

    #[test]
    fn the_head_is_held_still_and_its_motion_told() {
        let (still, moved) = take();
        let found = stabilize(&moved, &neutral(), None, &rigid(), &tolerance(1e-3)).unwrap();
        for (a, b) in found.markers.positions().iter().zip(still.positions()) {
            assert!(a.distance(*b) < 1e-6, "{a} {b}");
        }
        for frame in 0..60 {
            let told = motion_of(std::array::from_fn(|channel| f64::from(found.motion.frame(frame)[channel])));
            assert!(told.rotation.abs_diff_eq(motion(frame).rotation, 1e-5), "frame {frame}");
            assert!(told.translation_m.abs_diff_eq(motion(frame).translation_m, 1e-5));
            assert_eq!(found.fit.frame(frame)[1] as usize, 4);
        }
        assert_eq!(found.lost_frames, 0);
    }

    #[test]
    fn a_slipped_rigid_marker_changes_nothing() {
        let (still, moved) = take();
        let mut positions = moved.positions().to_vec();
        for frame in 20..40 {
            positions[frame * 12 + frame % 4] += Vec3::new(0.02, -0.01, 0.03);
        }
        let found =
            stabilize(&moved.with_positions(positions).unwrap(), &neutral(), None, &rigid(), &tolerance(1e-3)).unwrap();
        for frame in 20..40 {
            assert_eq!(found.fit.frame(frame)[1] as usize, 3);
            for column in 4..12 {
                let apart = found.markers.frame(frame)[column].distance(still.frame(frame)[column]);
                assert!(apart < 1e-5, "frame {frame}: {apart} m");
            }
        }
    }

    #[test]
    fn a_posed_face_tells_of_the_head_by_markers_that_move() {
        let (still, moved) = take();
        let skin: Vec<String> = (4..12).map(|index| format!("skin_{index}")).collect();
        let options = tolerance(0.05);
        let apart = |posed| {
            let found = stabilize(&moved, &neutral(), posed, &skin, &options).unwrap();
            let pairs = found.markers.positions().iter().zip(still.positions());
            pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
        };
        assert!(apart(None) > 5e-3, "{}", apart(None));
        assert!(apart(Some(&still)) < 1e-6, "{}", apart(Some(&still)));
        let error = stabilize(&moved, &neutral(), Some(&neutral()), &skin, &options).unwrap_err().to_string();
        assert!(error.contains("the posed face has 1 frames, the take 60"), "{error}");
    }

    #[test]
    fn frames_without_three_rigid_markers_are_missing_and_counted() {
        let (_, moved) = take();
        let mut positions = moved.positions().to_vec();
        positions[5 * 12..5 * 12 + 2].fill(Vec3::NAN);
        let found =
            stabilize(&moved.with_positions(positions).unwrap(), &neutral(), None, &rigid(), &tolerance(1e-3)).unwrap();
        assert_eq!((found.lost_frames, found.markers.missing()), (1, 12));
        assert!(found.motion.frame(5).iter().all(|value| value.is_nan()));
    }

    #[test]
    fn mistakes_are_named() {
        let (_, moved) = take();
        let fault = |neutral: &Markers, rigid: &[&str], tolerance_m: f64| {
            let rigid: Vec<_> = rigid.iter().map(|name| (*name).to_owned()).collect();
            stabilize(&moved, neutral, None, &rigid, &tolerance(tolerance_m)).unwrap_err().to_string()
        };
        let at_rest = neutral();
        assert!(fault(&at_rest, &["head_0", "head_1", "haed_2"], 1e-3).contains("did you mean `head_2`?"));
        assert!(fault(&at_rest, &["head_0", "head_1"], 1e-3).contains("2 rigid markers"));
        assert!(fault(&at_rest, &["head_0", "head_1", "head_2"], 0.0).contains("tolerance"));
        assert!(fault(&moved, &["head_0", "head_1", "head_2"], 1e-3).contains("60 frames"));
    }
}
