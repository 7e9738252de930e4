//! Splits the jaw off a rig whose shapes hold the whole deformation (section 6 of the deepfake capture paper).
//!
//! Every jaw shape Sᵢ (metres, whole deformation at weight 1) becomes a motion of the jaw joint and a "de-skinned" offset:
//!
//! ```text
//! Sᵢ = (M Rᵢ + (1 − M) I) (N + Dᵢ) + M Tᵢ      so      Dᵢ = (M Rᵢ + (1 − M) I)⁻¹ (Sᵢ − M Tᵢ) − N
//! ```
//!
//! Rᵢ and Tᵢ are the rigid motion that fits a part which only the jaw moves, the lower teeth. A shape is a jaw shape
//! where it moves that part by more than a threshold, and nearly rigidly.
//!
//! M is the rig's own skin where it has one. Otherwise each vertex' displacements under all jaw channels are projected
//! on what the rigid motions would do to it, M = clamp(Σᵢ sᵢ·rᵢ / Σᵢ rᵢ·rᵢ, 0, 1) with sᵢ = Sᵢ − N and
//! rᵢ = Rᵢ N + Tᵢ − N; several jaw channels together keep the axis of one of them from leaving M open.
//!
//! Shapes that do not move the jaw keep their offsets: they now ride on the jaw, so that an open mouth turns a smile
//! along. That holds for correctives of a jaw channel with others too (`jawOpen+mouthSmile_L`). A corrective whose
//! channels all move the jaw (`jawOpen+jawLeft`, `jawOpen@0.5`), and any that moves the lower teeth itself, is made so
//! that the split rig is exactly the old one at the corrective's corner (its channels at 1, or at the peak): the jaw's
//! motion there is fitted anew, and the corrective carries what differs from the sum of its channels' motions.

use super::RigError;
use super::jaw_split::Split;
use crate::data::{DataError, Rig, nearest_name};

/// How to split.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinJawOptions {
    /// The part that only the jaw moves.
    pub part: String,
    /// The channels that move the jaw; found by their motion where empty.
    pub channels: Vec<String>,
    /// A shape moves the jaw where it moves the part by at least this root mean square distance, in metres.
    pub min_motion_m: f64,
    /// … and where the rigid fit leaves at most this share of it (0 to 1).
    pub max_residual_share: f64,
    /// Whether M is the rig's own skin, where it has one; otherwise M is found from the motion.
    pub own_skin: bool,
}

impl Default for SkinJawOptions {
    fn default() -> Self {
        Self {
            part: "teeth_lower".to_owned(),
            channels: Vec::new(),
            min_motion_m: 0.0005,
            max_residual_share: 0.2,
            own_skin: true,
        }
    }
}

/// How one shape moves the jaw.
#[derive(Debug, Clone, PartialEq)]
pub struct JawFit {
    /// Name of the shape.
    pub shape: String,
    /// Root mean square distance by which the shape (with its channels, for a corrective) moves the part, in metres.
    pub motion_rms_m: f64,
    /// Root mean square distance that the rigid fit leaves, in metres.
    pub residual_rms_m: f64,
    /// Angle of the jaw's turn, in radians.
    pub angle_rad: f64,
}

/// The outcome of [`skin_jaw`].
#[derive(Debug, Clone, PartialEq)]
pub struct SkinnedJaw {
    /// The rig with its jaw as a joint.
    pub rig: Rig,
    /// How the jaw shapes were fitted, channels first.
    pub fits: Vec<JawFit>,
}

/// Splits the jaw off `rig`.
///
/// # Errors
/// Where the jaw is a joint already, the part or a channel is not there, no channel moves the part (enough, or as a
/// rigid body), or the jaw turns so far that skinning cannot be undone.
pub fn skin_jaw(rig: &Rig, options: &SkinJawOptions) -> Result<SkinnedJaw, RigError> {
    if rig.jaw.is_some() {
        return Err(RigError::AlreadySplit { rig: rig.name.clone() });
    }
    let part = rig.part(&options.part).ok_or_else(|| DataError::Missing {
        what: "part",
        name: options.part.clone(),
        near: nearest_name(&options.part, rig.parts.iter().map(|part| part.name.as_str())),
    })?;
    let teeth = part.vertices.start as usize..part.vertices.end as usize;
    let mut split = Split::new(rig, options, teeth)?;
    split.find_channels()?;
    let shares = split.shares();
    split.deskin_channels(&shares)?;
    for shape in split.correctives() {
        split.deskin_corrective(shape, &shares)?;
    }
    Ok(split.finish(shares))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Driver, Part};
    use crate::rig::{Puppet, toy};
    use glam::{DMat3, Vec3};

    /// A jawed toy whose first row of vertices are lower teeth, moved by the jaw alone; correctives of the jaw are in it.
    fn source() -> Rig {
        let mut rig = toy::jawed(6, 4);
        rig.parts[0].vertices = 6..36;
        let teeth = rig.parts[0].clone();
        rig.parts.push(Part { name: "teeth_lower".into(), vertices: 0..6, triangles: Vec::new(), ..teeth });
        for shape in &mut rig.shapes {
            for (vertex, delta) in shape.vertices.iter().zip(&mut shape.deltas) {
                if *vertex < 6 {
                    *delta = Vec3::ZERO;
                }
            }
        }
        rig.jaw.as_mut().unwrap().weights[..6].fill(1.0);
        rig
    }

    /// The same head with the jaw's motion held in its shapes, as such rigs arrive: equal at every shape's corner.
    fn baked(source: &Rig) -> Rig {
        let puppet = Puppet::new(source).unwrap();
        let mut rig = source.clone();
        let jaw = rig.jaw.take().unwrap();
        rig.skin = jaw.weights;
        let corner = |driver: &Driver| {
            let mut weights = vec![0.0; rig.channels.len()];
            match driver {
                Driver::Channel(channel) => weights[*channel as usize] = 1.0,
                Driver::Combination(all) => all.iter().for_each(|channel| weights[*channel as usize] = 1.0),
                Driver::InBetween { channel, peak } => weights[*channel as usize] = *peak,
                Driver::Turn { .. } => {}
            }
            weights
        };
        for index in 0..source.shapes.len() {
            let weights = corner(&source.shapes[index].driver);
            let whole = puppet.vertices(&weights).unwrap();
            rig.shapes[index].vertices.clear();
            rig.shapes[index].deltas.clear();
            let so_far = Puppet::new(&rig).unwrap().vertices(&weights).unwrap();
            rig.shapes[index].vertices = (0..whole.len() as u32).collect();
            rig.shapes[index].deltas = whole.iter().zip(so_far).map(|(whole, so_far)| *whole - so_far).collect();
        }
        rig
    }

    #[test]
    fn splitting_what_was_baked_gives_the_source_back() {
        let source = source();
        let split = skin_jaw(&baked(&source), &SkinJawOptions::default()).unwrap();
        let (found, known) = (split.rig.jaw.as_ref().unwrap(), source.jaw.as_ref().unwrap());
        assert_eq!(found.weights, known.weights);
        assert_eq!(found.motions.len(), known.motions.len());
        for (found, known) in found.motions.iter().zip(&known.motions) {
            assert_eq!(found.shape, known.shape);
            assert!(found.euler_rad.abs_diff_eq(known.euler_rad, 2e-5), "{found:?} {known:?}");
            assert!(found.translation_m.abs_diff_eq(known.translation_m, 2e-6), "{found:?} {known:?}");
        }
        for fit in &split.fits {
            assert!(fit.residual_rms_m < 1e-6 && fit.motion_rms_m > 1e-3, "{fit:?}");
        }
        let (puppet, expected) = (Puppet::new(&split.rig).unwrap(), Puppet::new(&source).unwrap());
        for weights in [[0.3, 0.8, 0.5, 0.2], [1.0, 1.0, 0.0, 0.7], [0.5, 0.0, 1.0, 1.0]] {
            let (a, b) = (puppet.vertices(&weights).unwrap(), expected.vertices(&weights).unwrap());
            for (a, b) in a.iter().zip(&b) {
                assert!(a.abs_diff_eq(*b, 5e-6), "{a} {b}");
            }
        }
    }

    #[test]
    fn every_jaw_shape_is_reproduced_at_its_corner_even_where_the_teeth_bend() {
        let mut rig = baked(&source());
        let mut dice = toy::Dice(31);
        for shape in &mut rig.shapes {
            shape.deltas.iter_mut().for_each(|delta| *delta += dice.point() * 5e-4);
        }
        let split = skin_jaw(&rig, &SkinJawOptions::default()).unwrap();
        assert!(split.fits.iter().all(|fit| fit.residual_rms_m > 1e-5));
        let (puppet, expected) = (Puppet::new(&split.rig).unwrap(), Puppet::new(&rig).unwrap());
        for weights in [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0]] {
            for (a, b) in puppet.vertices(&weights).unwrap().iter().zip(expected.vertices(&weights).unwrap()) {
                assert!(a.abs_diff_eq(b, 1e-6), "{weights:?}: {a} {b}");
            }
        }
    }

    #[test]
    fn a_smile_rides_on_the_open_jaw() {
        let source = source();
        let baked = baked(&source);
        let split = skin_jaw(&baked, &SkinJawOptions::default()).unwrap();
        assert_eq!(split.rig.shapes[2], baked.shapes[2]);
        let jaw = split.rig.jaw.as_ref().unwrap();
        let open = jaw.without_weights();
        let turn = crate::rig::JawPose::at(&open, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).rotation;
        let puppet = Puppet::new(&split.rig).unwrap();
        let (smile, calm) =
            (puppet.vertices(&[1.0, 0.0, 1.0, 0.0]).unwrap(), puppet.vertices(&[1.0, 0.0, 0.0, 0.0]).unwrap());
        for (vertex, delta) in split.rig.shapes[2].vertices.iter().zip(&split.rig.shapes[2].deltas) {
            let share = f64::from(jaw.weights[*vertex as usize]);
            let expected = (share * turn + (1.0 - share) * DMat3::IDENTITY) * delta.as_dvec3();
            let moved = smile[*vertex as usize] - calm[*vertex as usize];
            assert!(moved.abs_diff_eq(expected.as_vec3(), 1e-7));
        }
    }

    #[test]
    fn without_a_skin_the_shares_come_from_the_motion() {
        let mut source = source();
        source.shapes.iter_mut().for_each(|shape| shape.deltas.fill(Vec3::ZERO));
        let mut baked = baked(&source);
        let known = std::mem::take(&mut baked.skin);
        let split = skin_jaw(&baked, &SkinJawOptions::default()).unwrap();
        for (found, known) in split.rig.jaw.unwrap().weights.iter().zip(known) {
            assert!((found - known).abs() < 1e-3, "{found} {known}");
        }
    }

    #[test]
    fn bad_input_is_named() {
        let baked = baked(&source());
        let options = |part: &str, channels: &[&str]| SkinJawOptions {
            part: part.to_owned(),
            channels: channels.iter().map(|channel| (*channel).to_owned()).collect(),
            ..SkinJawOptions::default()
        };
        let message = |rig: &Rig, options: &SkinJawOptions| skin_jaw(rig, options).unwrap_err().to_string();
        assert!(message(&baked, &options("teeth_lowre", &[])).contains("did you mean `teeth_lower`"));
        assert!(message(&baked, &options("teeth_lower", &["c9"])).contains("no channel `c9`"));
        assert!(
            message(&baked, &options("teeth_lower", &["c2"])).contains("`c2` moves part `teeth_lower` by 0.000 mm")
        );
        let split = skin_jaw(&baked, &options("teeth_lower", &[])).unwrap().rig;
        assert_eq!(
            skin_jaw(&split, &options("teeth_lower", &[])).unwrap_err(),
            RigError::AlreadySplit { rig: "toy".into() }
        );
        let mut still = baked.clone();
        still.shapes.iter_mut().for_each(|shape| shape.deltas.fill(Vec3::ZERO));
        assert!(message(&still, &options("teeth_lower", &[])).contains("none moves it at all"));
    }

    #[test]
    fn half_a_turn_is_refused() {
        let mut source = source();
        let jaw = source.jaw.as_mut().unwrap();
        jaw.motions.truncate(1);
        jaw.motions[0].euler_rad = Vec3::new(std::f32::consts::PI, 0.0, 0.0);
        jaw.weights[20] = 0.5;
        let error = skin_jaw(&baked(&source), &SkinJawOptions::default()).unwrap_err();
        assert!(matches!(error, RigError::Flat { .. }), "{error}");
        assert!(error.to_string().contains("180.0 degrees"), "{error}");
    }
}
