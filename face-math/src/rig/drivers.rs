//! Channel weights to shape weights: the first step of posing a rig.
//!
//! A channel's own shape weighs as much as its channel, whatever in-betweens it has: deltas of in-betweens are *added
//! on top of* the straight path of the main shape. A combination corrective weighs as much as the product of its
//! channels. An in-between is a tent over its channel's weight,
//!
//! ```text
//! t(w) = (w − b) / (p − b)   for b ≤ w ≤ p,
//!        (a − w) / (a − p)   for p ≤ w ≤ a,
//!        0                   elsewhere,
//! ```
//!
//! with p its peak and b, a the peaks of the neighbouring in-betweens of the same channel below and above, or 0 and 1
//! where there is none. So at a peak only its own in-between counts. All weights are unitless.
//!
//! A pose corrective weighs as much as an entry of its joint's rotation has changed, `R_rc(θ(w)) − δ_rc`, where the angles
//! θ(w) = Σ wᵢ θᵢ are those of the channels that turn the joint (section A.2 of Animatomy).

use super::{JawPose, RigError};
use crate::data::{Driver, Rig};
use glam::DVec3;

/// The drivers of a rig's shapes, ready to be evaluated and differentiated.
#[derive(Debug, Clone)]
pub struct ShapeDrivers {
    channels: usize,
    drivers: Vec<Compiled>,
}

#[derive(Debug, Clone)]
enum Compiled {
    Channel(usize),
    Product(Vec<usize>),
    Tent { channel: usize, below: f64, peak: f64, above: f64 },
    Turn { angles: Vec<(usize, DVec3)>, row: usize, column: usize },
}

impl ShapeDrivers {
    /// Prepares the drivers of `rig`.
    ///
    /// # Errors
    /// Where an in-between does not peak strictly between 0 and 1.
    pub fn new(rig: &Rig) -> Result<Self, RigError> {
        let mut drivers = Vec::with_capacity(rig.shapes.len());
        for shape in &rig.shapes {
            drivers.push(match &shape.driver {
                Driver::Channel(channel) => Compiled::Channel(*channel as usize),
                Driver::Combination(channels) => {
                    Compiled::Product(channels.iter().map(|channel| *channel as usize).collect())
                }
                Driver::InBetween { channel, peak } => {
                    if !(*peak > 0.0 && *peak < 1.0) {
                        return Err(RigError::Peak { shape: shape.name.clone(), peak: *peak });
                    }
                    let (below, above) = neighbours(rig, *channel, *peak);
                    Compiled::Tent {
                        channel: *channel as usize,
                        below: below.into(),
                        peak: (*peak).into(),
                        above: above.into(),
                    }
                }
                Driver::Turn { joint, row, column } => Compiled::Turn {
                    angles: turning(rig, *joint, &shape.name)?,
                    row: *row as usize,
                    column: *column as usize,
                },
            });
        }
        Ok(Self { channels: rig.channels.len(), drivers })
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Number of shapes.
    pub fn shapes(&self) -> usize {
        self.drivers.len()
    }

    /// Writes the weight of every shape at the given channel weights.
    pub fn weights_into(&self, channels: &[f64], shapes: &mut Vec<f64>) {
        shapes.clear();
        shapes.extend(self.drivers.iter().map(|driver| driver.weight(channels)));
    }

    /// Calls `each(channel, ∂weight/∂channel)` for every channel that drives `shape`. At the kinks of a tent it is the
    /// slope on the side towards 1.
    pub fn derivatives(&self, shape: usize, channels: &[f64], mut each: impl FnMut(usize, f64)) {
        match &self.drivers[shape] {
            Compiled::Channel(channel) => each(*channel, 1.0),
            Compiled::Product(factors) => {
                for (position, channel) in factors.iter().enumerate() {
                    let others = factors.iter().enumerate().filter(|(other, _)| *other != position);
                    each(*channel, others.map(|(_, other)| channels[*other]).product());
                }
            }
            Compiled::Tent { channel, below, peak, above } => {
                let w = channels[*channel];
                if w >= *below && w < *peak {
                    each(*channel, 1.0 / (peak - below));
                } else if w >= *peak && w < *above {
                    each(*channel, -1.0 / (above - peak));
                }
            }
            Compiled::Turn { angles, row, column } => {
                let pose = JawPose::of(angles_rad(angles, channels), DVec3::ZERO);
                let slopes = DVec3::from_array(pose.turns.map(|turn| turn.col(*column)[*row]));
                for (channel, angle) in angles {
                    each(*channel, slopes.dot(*angle));
                }
            }
        }
    }

    /// The chain rule: adds to `channel_gradient` what `shape_gradient`, the derivatives of a number by the shape
    /// weights, means for the channels.
    pub fn pull_back(&self, channels: &[f64], shape_gradient: &[f64], channel_gradient: &mut [f64]) {
        for (shape, force) in shape_gradient.iter().enumerate() {
            self.derivatives(shape, channels, |channel, slope| channel_gradient[channel] += force * slope);
        }
    }
}

impl Compiled {
    fn weight(&self, channels: &[f64]) -> f64 {
        match self {
            Self::Channel(channel) => channels[*channel],
            Self::Product(factors) => factors.iter().map(|channel| channels[*channel]).product(),
            Self::Tent { channel, below, peak, above } => {
                let w = channels[*channel];
                let rising = (w - below) / (peak - below);
                let falling = (above - w) / (above - peak);
                rising.min(falling).max(0.0)
            }
            Self::Turn { angles, row, column } => {
                let rotation = JawPose::of(angles_rad(angles, channels), DVec3::ZERO).rotation;
                rotation.col(*column)[*row] - f64::from(u8::from(row == column))
            }
        }
    }
}

fn angles_rad(angles: &[(usize, DVec3)], channels: &[f64]) -> DVec3 {
    angles.iter().map(|(channel, angle)| channels[*channel] * *angle).sum()
}

/// The channels that turn a joint, and by how much each does.
fn turning(rig: &Rig, joint: u32, shape: &str) -> Result<Vec<(usize, DVec3)>, RigError> {
    let motions = rig.joint(joint).map_or(&[][..], |joint| &joint.motions);
    let angle = |motion: &crate::data::JawMotion| match rig.shapes[motion.shape as usize].driver {
        Driver::Channel(channel) => Ok((channel as usize, motion.euler_rad.as_dvec3())),
        _ => Err(RigError::Turned { shape: shape.to_owned(), by: rig.shapes[motion.shape as usize].name.clone() }),
    };
    let mut angles = motions.iter().map(angle).collect::<Result<Vec<_>, _>>()?;
    angles.retain(|(_, angle)| *angle != DVec3::ZERO);
    Ok(angles)
}

/// The peaks next to `peak` among the in-betweens of `channel`, or 0 and 1.
fn neighbours(rig: &Rig, channel: u32, peak: f32) -> (f32, f32) {
    let (mut below, mut above) = (0.0_f32, 1.0_f32);
    for shape in &rig.shapes {
        match shape.driver {
            Driver::InBetween { channel: own, peak: other } if own == channel => {
                if other < peak {
                    below = below.max(other);
                } else if other > peak {
                    above = above.min(other);
                }
            }
            _ => {}
        }
    }
    (below, above)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;

    fn at(drivers: &ShapeDrivers, channels: &[f64]) -> Vec<f64> {
        let mut shapes = Vec::new();
        drivers.weights_into(channels, &mut shapes);
        shapes
    }

    fn rig_of(drivers: &[(&str, Driver)]) -> Rig {
        let mut rig = toy::rig(4, 3);
        rig.shapes = drivers
            .iter()
            .map(|(name, driver)| crate::data::Shape {
                name: (*name).to_owned(),
                driver: driver.clone(),
                vertices: Vec::new(),
                deltas: Vec::new(),
            })
            .collect();
        rig
    }

    #[test]
    fn a_lone_in_between_spans_the_channel_and_the_main_shape_stays_linear() {
        let rig = rig_of(&[("a", Driver::Channel(0)), ("a@0.25", Driver::InBetween { channel: 0, peak: 0.25 })]);
        let drivers = ShapeDrivers::new(&rig).unwrap();
        for (w, tent) in [(-0.5, 0.0), (0.0, 0.0), (0.125, 0.5), (0.25, 1.0), (0.625, 0.5), (1.0, 0.0), (1.5, 0.0)] {
            assert_eq!(at(&drivers, &[w, 0.0, 0.0]), [w, tent], "at {w}");
        }
    }

    #[test]
    fn neighbouring_in_betweens_are_zero_at_each_others_peaks() {
        let peaks = [0.25_f32, 0.5, 0.75];
        let names = ["a@0.25", "a@0.5", "a@0.75"];
        let shapes: Vec<_> =
            names.iter().zip(peaks).map(|(name, peak)| (*name, Driver::InBetween { channel: 0, peak })).collect();
        let drivers = ShapeDrivers::new(&rig_of(&shapes)).unwrap();
        for (own, peak) in peaks.iter().enumerate() {
            let weights = at(&drivers, &[f64::from(*peak), 0.0, 0.0]);
            let expected: Vec<_> = (0..3).map(|shape| f64::from(u8::from(shape == own))).collect();
            assert_eq!(weights, expected);
        }
        assert_eq!(at(&drivers, &[0.375, 0.0, 0.0]), [0.5, 0.5, 0.0]);
    }

    #[test]
    fn a_combination_is_the_product() {
        let drivers = ShapeDrivers::new(&rig_of(&[("a+b+c", Driver::Combination(vec![0, 1, 2]))])).unwrap();
        assert_eq!(at(&drivers, &[0.5, 0.25, 0.5]), [0.0625]);
        assert_eq!(at(&drivers, &[0.5, 0.0, 1.0]), [0.0]);
    }

    #[test]
    fn slopes_equal_finite_differences() {
        let rig = toy::rig(5, 4);
        let drivers = ShapeDrivers::new(&rig).unwrap();
        let w = [0.31, 0.62, 0.13, 0.87];
        let step = 1e-6;
        for shape in 0..drivers.shapes() {
            let mut slopes = [0.0; 4];
            drivers.derivatives(shape, &w, |channel, slope| slopes[channel] += slope);
            for channel in 0..4 {
                let (mut up, mut down) = (w, w);
                up[channel] += step;
                down[channel] -= step;
                let slope = (at(&drivers, &up)[shape] - at(&drivers, &down)[shape]) / (2.0 * step);
                assert!((slope - slopes[channel]).abs() < 1e-8, "shape {shape}, channel {channel}");
            }
        }
    }

    #[test]
    fn a_peak_at_the_end_is_refused() {
        let rig = rig_of(&[("a@1", Driver::InBetween { channel: 0, peak: 1.0 })]);
        assert_eq!(ShapeDrivers::new(&rig).unwrap_err(), RigError::Peak { shape: "a@1".into(), peak: 1.0 });
    }
}
