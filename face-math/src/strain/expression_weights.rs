//! How much a vertex tells of the jaw: little where expressions move it, so that lips and cheeks do not pull the jaw along with a
//! smile.

use super::error::StrainError;
use super::solve_strains::strain_channels;
use crate::data::{Curves, Driver, Rig};
use glam::DVec3;

/// How little a vertex counts that strains move: 1 / (1 + e² / σ²), e by the given curves of strains; σ in metres.
///
/// # Errors
/// Where the strains are not those of the rig.
pub fn expression_weights(rig: &Rig, strains: &Curves, noise_m: f64) -> Result<Vec<f64>, StrainError> {
    let names = strain_channels(rig)?;
    let arranged = strains.arrange(&names, None)?;
    let mut squares = vec![0.0; rig.neutral.len()];
    let mut offsets = vec![DVec3::ZERO; rig.neutral.len()];
    let shapes: Vec<_> = rig
        .shapes
        .iter()
        .filter_map(|shape| match shape.driver {
            Driver::Channel(channel) => {
                Some((names.iter().position(|name| *name == rig.channels[channel as usize])?, shape))
            }
            _ => None,
        })
        .collect();
    // A hundred frames tell the spread well enough.
    let step = arranged.frames().div_ceil(100).max(1);
    let looked_at = (0..arranged.frames()).step_by(step);
    let count = looked_at.len().max(1) as f64;
    for frame in looked_at {
        offsets.fill(DVec3::ZERO);
        for (column, shape) in &shapes {
            let weight = f64::from(arranged.frame(frame)[*column]);
            for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
                offsets[*vertex as usize] += weight * delta.as_dvec3();
            }
        }
        squares.iter_mut().zip(&offsets).for_each(|(sum, offset)| *sum += offset.length_squared() / count);
    }
    Ok(squares.iter().map(|square| 1.0 / (1.0 + square / (noise_m * noise_m))).collect())
}
