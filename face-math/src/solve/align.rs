//! Moves a take's markers towards the puppet by anchor poses (section 4.4.2 of FDLS): for masks that sit a little off, and
//! faces that changed since the puppet was made.
//!
//! An artist poses the puppet, weights wₐ, to match the take at frame a. Eq. 5 of FDLS, for every marker:
//!
//! ```text
//! dₐ = xₐ − g(wₐ)
//! x̃_f = x_f − q_fa dₐ,      q_fa = exp(−‖xₐ − x_f‖² / r²)
//! ```
//!
//! x the captured markers (metres), g(w) the puppet's. The first anchor applies to all frames alike (q = 1). Each further
//! one is measured on the markers as its predecessors left them and counts by likeness of pose, so that it corrects what is
//! special to that pose and leaves the rest: at the anchor itself q = 1, and the markers meet the puppet exactly.
//!
//! The paper gives the exponent no unit and a norm that grows with the number of markers. Here the norm is the root mean
//! square distance over the markers seen in both, in millimetres, and r, the falloff, is in millimetres too: at r
//! millimetres of mean difference an anchor counts 37 %.
//!
//! Every frame depends on itself and the anchors alone.

use crate::data::{DataError, Markers};
use glam::Vec3;

/// How to align.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignOptions {
    /// r: the root mean square distance between poses at which a further anchor counts 37 %, in millimetres.
    pub falloff_mm: f64,
}

impl Default for AlignOptions {
    fn default() -> Self {
        Self { falloff_mm: 3.0 }
    }
}

/// The outcome of [`align_anchors`].
#[derive(Debug, Clone, PartialEq)]
pub struct Aligned {
    /// The take's markers, moved.
    pub markers: Markers,
    /// Markers without an offset of some anchor, as (position of the anchor, name): missing in its frame, or not the
    /// puppet's.
    pub without_offset: Vec<(usize, String)>,
}

/// Why a take cannot be aligned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AlignError {
    /// No anchor is given.
    #[error("no anchor pose to align by; give at least one frame and the weights that match it")]
    NoAnchor,
    /// As many puppet poses are needed as anchor frames.
    #[error("{captured} captured anchor frames beside {posed} poses of the puppet; give each anchor its weights")]
    Anchors {
        /// Frames of the captured anchors.
        captured: usize,
        /// Frames of the puppet.
        posed: usize,
    },
    /// The anchors' markers are not those of the take.
    #[error("anchor poses: {0}; take them from the take itself")]
    Markers(DataError),
    /// No marker of an anchor has a place on the puppet.
    #[error(
        "anchor {anchor} (frame {frame}) shares no marker with the puppet; choose a frame in which markers are seen"
    )]
    Blind {
        /// Position of the anchor.
        anchor: usize,
        /// Number of its frame, as its source counts.
        frame: i64,
    },
    /// The falloff is not positive.
    #[error("a falloff of {falloff_mm} mm; give a positive distance")]
    Falloff {
        /// The falloff.
        falloff_mm: f64,
    },
}

/// Aligns `take`. Each frame of `anchors` holds the captured markers at one anchor (all markers of the take), the same
/// frame of `puppet` the puppet's markers at that anchor's weights; the anchors apply in that order.
///
/// # Errors
/// Where there is no anchor, the two do not pair up, an anchor lacks a marker of the take, or shares none with the puppet.
pub fn align_anchors(
    take: &Markers,
    anchors: &Markers,
    puppet: &Markers,
    options: &AlignOptions,
) -> Result<Aligned, AlignError> {
    if !(options.falloff_mm > 0.0 && options.falloff_mm.is_finite()) {
        return Err(AlignError::Falloff { falloff_mm: options.falloff_mm });
    }
    if anchors.frames() == 0 {
        return Err(AlignError::NoAnchor);
    }
    if anchors.frames() != puppet.frames() {
        return Err(AlignError::Anchors { captured: anchors.frames(), posed: puppet.frames() });
    }
    let anchors = anchors.pick(take.names()).map_err(AlignError::Markers)?;
    let columns: Vec<_> = take.names().iter().map(|name| puppet.index(name)).collect();

    let mut steps: Vec<Step> = Vec::with_capacity(anchors.frames());
    let mut without_offset = Vec::new();
    for anchor in 0..anchors.frames() {
        let mut pose = anchors.frame(anchor).to_vec();
        for step in &steps {
            step.apply(&mut pose);
        }
        let target = puppet.frame(anchor);
        let offsets: Vec<Option<Vec3>> = pose
            .iter()
            .zip(&columns)
            .map(|(captured, column)| column.map(|column| *captured - target[column]).filter(|d| d.is_finite()))
            .collect();
        if offsets.iter().all(Option::is_none) {
            let frame = anchors.frame_axis().slice(&(anchor..anchor + 1)).first;
            return Err(AlignError::Blind { anchor, frame });
        }
        let without = take.names().iter().zip(&offsets).filter(|(_, offset)| offset.is_none());
        without_offset.extend(without.map(|(name, _)| (anchor, name.clone())));
        let falloff_m = (anchor > 0).then_some(options.falloff_mm / 1000.0);
        steps.push(Step { pose, offsets, falloff_m });
    }
    let mut positions = take.positions().to_vec();
    for frame in positions.chunks_mut(take.names().len().max(1)) {
        for step in &steps {
            step.apply(frame);
        }
    }
    let markers = take.with_positions(positions).map_err(AlignError::Markers)?;
    Ok(Aligned { markers, without_offset })
}

/// One anchor, ready to be applied.
struct Step {
    /// xₐ, as the anchors before it left it (metres).
    pose: Vec<Vec3>,
    /// dₐ (metres).
    offsets: Vec<Option<Vec3>>,
    /// r in metres; none for the first anchor, which applies everywhere.
    falloff_m: Option<f64>,
}

impl Step {
    fn apply(&self, frame: &mut [Vec3]) {
        let share = self.falloff_m.map_or(1.0, |falloff| self.likeness(frame, falloff));
        for (point, offset) in frame.iter_mut().zip(&self.offsets) {
            if let Some(offset) = offset {
                *point -= share as f32 * *offset;
            }
        }
    }

    /// q: exp(−(root mean square distance / r)²); nothing seen in both is nothing alike.
    fn likeness(&self, frame: &[Vec3], falloff_m: f64) -> f64 {
        let (mut squares, mut seen) = (0.0, 0_usize);
        for (own, other) in self.pose.iter().zip(frame) {
            let apart = f64::from(own.distance_squared(*other));
            if apart.is_finite() {
                squares += apart;
                seen += 1;
            }
        }
        if seen == 0 { 0.0 } else { (-squares / seen as f64 / (falloff_m * falloff_m)).exp() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;
    use wire::{FrameAxis, Value};

    fn markers(seed: u64, frames: usize, names: &[&str]) -> Markers {
        let mut dice = Dice(seed);
        let names: Vec<_> = names.iter().map(|name| (*name).to_owned()).collect();
        let positions = (0..frames * names.len()).map(|_| dice.point() * 0.01).collect();
        Markers::new(FrameAxis::new(frames, 60.0), names, positions).unwrap()
    }

    const NAMES: [&str; 4] = ["a", "b", "c", "head"];

    fn frame_of(take: &Markers, frame: usize) -> Markers {
        take.slice(frame..frame + 1).unwrap().downcast_ref::<Markers>().unwrap().clone()
    }

    fn joined(parts: &[&Markers]) -> Markers {
        let positions: Vec<_> = parts.iter().flat_map(|part| part.positions().iter().copied()).collect();
        Markers::new(FrameAxis::new(parts.len(), 60.0), parts[0].names().to_vec(), positions).unwrap()
    }

    #[test]
    fn the_first_anchor_moves_all_frames_alike_onto_the_puppet() {
        let (take, puppet) = (markers(1, 5, &NAMES), markers(2, 1, &NAMES[..3]));
        let aligned = align_anchors(&take, &frame_of(&take, 2), &puppet, &AlignOptions::default()).unwrap();
        assert_eq!(aligned.without_offset, [(0, "head".to_owned())]);
        for marker in 0..3 {
            assert!(aligned.markers.frame(2)[marker].abs_diff_eq(puppet.frame(0)[marker], 1e-8));
            let offset = take.frame(2)[marker] - puppet.frame(0)[marker];
            for frame in 0..5 {
                let expected = take.frame(frame)[marker] - offset;
                assert!(aligned.markers.frame(frame)[marker].abs_diff_eq(expected, 1e-8));
            }
        }
        assert_eq!(aligned.markers.frame(1)[3], take.frame(1)[3]);
    }

    #[test]
    fn a_further_anchor_is_met_exactly_and_fades_with_the_pose() {
        let (take, puppet) = (markers(3, 6, &NAMES), markers(4, 2, &NAMES));
        let anchors = joined(&[&frame_of(&take, 0), &frame_of(&take, 4)]);
        let one = align_anchors(&take, &frame_of(&take, 0), &frame_of(&puppet, 0), &AlignOptions::default()).unwrap();
        let options = AlignOptions { falloff_mm: 6.0 };
        let two = align_anchors(&take, &anchors, &puppet, &options).unwrap();
        for marker in 0..4 {
            assert!(two.markers.frame(4)[marker].abs_diff_eq(puppet.frame(1)[marker], 1e-8));
        }
        // Elsewhere the second offset counts by the Gaussian of the distance between poses.
        let (pose, other) = (one.markers.frame(4), one.markers.frame(1));
        let mean: f64 = pose.iter().zip(other).map(|(a, b)| f64::from(a.distance_squared(*b)) * 1e6).sum::<f64>() / 4.0;
        let share = (-mean / 36.0).exp() as f32;
        for marker in 0..4 {
            let offset = pose[marker] - puppet.frame(1)[marker];
            assert!(two.markers.frame(1)[marker].abs_diff_eq(other[marker] - share * offset, 1e-8));
        }
        // A narrow falloff leaves other poses as the first anchor had them.
        let narrow = align_anchors(&take, &anchors, &puppet, &AlignOptions { falloff_mm: 0.1 }).unwrap();
        assert_eq!(narrow.markers.frame(1), one.markers.frame(1));
    }

    #[test]
    fn missing_markers_get_no_offset_and_stay_missing() {
        let (take, puppet) = (markers(5, 3, &NAMES), markers(6, 1, &NAMES));
        let mut positions = take.positions().to_vec();
        positions[1] = Vec3::NAN;
        positions[4] = Vec3::NAN;
        let take = take.with_positions(positions).unwrap();
        let aligned = align_anchors(&take, &frame_of(&take, 0), &puppet, &AlignOptions::default()).unwrap();
        assert_eq!(aligned.without_offset, [(0, "b".to_owned())]);
        assert_eq!(aligned.markers.frame(2)[1], take.frame(2)[1]);
        assert!(aligned.markers.frame(1)[0].is_nan());
        assert!(aligned.markers.frame(0)[0].abs_diff_eq(puppet.frame(0)[0], 1e-8));
    }

    #[test]
    fn blocks_equal_the_whole() {
        let (take, puppet) = (markers(7, 9, &NAMES), markers(8, 2, &NAMES));
        let anchors = joined(&[&frame_of(&take, 1), &frame_of(&take, 7)]);
        let align = |take: &Markers| align_anchors(take, &anchors, &puppet, &AlignOptions::default()).unwrap().markers;
        let block = take.slice(2..6).unwrap();
        let block = align(block.downcast_ref::<Markers>().unwrap());
        assert_eq!(align(&take).slice(2..6).unwrap().encoded(), (&block as &dyn Value).encoded());
    }

    #[test]
    fn bad_input_is_named() {
        let (take, puppet) = (markers(9, 3, &NAMES), markers(10, 1, &["x", "y"]));
        let align = |anchors: &Markers, puppet: &Markers, falloff_mm| {
            align_anchors(&take, anchors, puppet, &AlignOptions { falloff_mm }).unwrap_err()
        };
        let anchor = frame_of(&take, 1);
        assert_eq!(align(&markers(1, 0, &NAMES), &puppet, 3.0), AlignError::NoAnchor);
        assert_eq!(align(&take, &puppet, 3.0), AlignError::Anchors { captured: 3, posed: 1 });
        assert_eq!(align(&anchor, &puppet, 3.0), AlignError::Blind { anchor: 0, frame: 1 });
        assert_eq!(align(&anchor, &puppet, 0.0), AlignError::Falloff { falloff_mm: 0.0 });
        assert!(matches!(align(&puppet, &puppet, 3.0), AlignError::Markers(DataError::Missing { .. })));
    }
}
