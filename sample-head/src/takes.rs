//! Takes: the head performs, its markers are captured with a little noise, and the weights are known.

use crate::numbers::Random;
use crate::performance::take;
use crate::{SampleHead, SampleHeadError};
use face_math::data::{Curves, Markers};
use face_math::rig::{MarkerRig, SkinJawOptions, skin_jaw};
use glam::Vec3;

/// A captured performance.
#[derive(Debug, Clone, PartialEq)]
pub struct Take {
    /// Name of the take.
    pub name: String,
    /// Captured markers in metres, 60 frames a second.
    pub markers: Markers,
    /// The weights that drove the head.
    pub truth: Curves,
}

/// Deviation of the noise at the brow and at the chin, in metres: cameras see the chin worse.
const NOISE_BROW_M: f32 = 0.000_05;
const NOISE_CHIN_M: f32 = 0.000_15;

/// Performs `count` takes of `frames` frames, each from its own seed (`seed`, `seed` + 1 …).
///
/// Markers are those of the head with its jaw as a joint, as real faces move, so that solving them on the plain
/// blendshapes leaves an error; noise grows from brow to chin. Head markers stand still.
///
/// # Errors
/// Where the head has been changed so that it cannot be posed.
pub fn takes(head: &SampleHead, count: usize, frames: usize, seed: u64) -> Result<Vec<Take>, SampleHeadError> {
    let jawed = skin_jaw(&head.rig, &SkinJawOptions::default())?.rig;
    let rig = MarkerRig::of_vertices(&jawed, &head.marker_vertices)?;
    let rest = head.neutral_markers.frame(0);
    let height = |name: &str, other: f32| head.neutral_markers.index(name).map_or(other, |marker| rest[marker].y);
    let (brow, chin) = (height("brow_L_2", 0.06), height("jawline_08", -0.08));
    (0..count as u64)
        .map(|index| {
            let truth = take(frames, 1000 + seed + index)?;
            let exact = rig.drive(&truth)?;
            let mut random = Random::new(0x7A6E_5000 + seed + index);
            let noisy = exact.positions().iter().enumerate().map(|(place, point)| {
                let down = ((brow - rest[place % rest.len()].y) / (brow - chin)).clamp(0.0, 1.0);
                let deviation = NOISE_BROW_M + (NOISE_CHIN_M - NOISE_BROW_M) * down;
                *point + Vec3::new(random.normal(), random.normal(), random.normal()) * deviation
            });
            let positions = noisy.collect();
            let names = head.neutral_markers.names().to_vec();
            let markers = Markers::new(truth.frame_axis(), names, positions)?;
            Ok(Take { name: format!("take_{:02}", seed + index), markers, truth })
        })
        .collect()
}
