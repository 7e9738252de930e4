//! One head's rig on another: its shapes, carried as [`Transfer`] carries meshes; between two heads at rest and a character's rig.
//!
//! A shape s has its peak at channel weights `w_s`: 1 for a channel, 1 for each channel of a combination, its place for an
//! in-between. With M the actor's mesh there and T(M) what the transfer makes of it (metres, less the character's rest),
//!
//! ```text
//! D_s = T(M(w_s)) − Σ_{r before s} a_r(w_s) D_r
//! ```
//!
//! `a_r` the weights of other shapes there; channels come first, then in-betweens, then combinations by their number of
//! channels. So the character's rig meets the transfer at the peak of every shape. The jaw's motion is in the shapes, as it is
//! in files of rigs; `skin_jaw` splits it off again.

use super::error::StrainError;
use super::pose_shapes::sparse;
use super::transfer::Transfer;
use crate::data::{Driver, Rig, Shape};
use crate::rig::{Puppet, ShapeDrivers};
use glam::DVec3;

impl Transfer<'_> {
    /// The character with the channels and shapes of `actor`, the rig at whose rest the heads were brought together.
    ///
    /// # Errors
    /// Where the actor is another head, or has shapes that joints drive: those are no peaks of channels.
    pub fn rig(&self, actor: &Rig) -> Result<Rig, StrainError> {
        super::error::same("vertices of the actor", self.actor_vertices(), actor.neutral.len())?;
        let turned = |shape: &&Shape| matches!(shape.driver, Driver::Turn { .. });
        if let Some(shape) = actor.shapes.iter().find(turned) {
            return Err(StrainError::DrivenByJoint { rig: actor.name.clone(), shape: shape.name.clone() });
        }
        let character = self.character();
        let mut shapes: Vec<Shape> = actor.shapes.iter().map(bare).collect();
        let driven = Rig { shapes: shapes.clone(), jaw: None, joints: Vec::new(), skin: Vec::new(), ..actor.clone() };
        let (drivers, puppet) = (ShapeDrivers::new(&driven)?, Puppet::new(actor)?);
        let mut order: Vec<usize> = (0..shapes.len()).collect();
        order.sort_by_key(|shape| rank(&shapes[*shape].driver));
        let mut known: Vec<(usize, Vec<DVec3>)> = Vec::with_capacity(order.len());
        let mut active = Vec::new();
        for shape in order {
            let peak = peak(&shapes[shape].driver, actor.channels.len());
            let mut offsets = self.offsets(&puppet.vertices(&peak)?);
            drivers.weights_into(&peak.iter().map(|weight| f64::from(*weight)).collect::<Vec<_>>(), &mut active);
            for (other, own) in known.iter().filter(|(other, _)| active[*other] != 0.0) {
                for (offset, own) in offsets.iter_mut().zip(own) {
                    *offset -= active[*other] * *own;
                }
            }
            let deltas = offsets
                .iter()
                .map(|offset| if offset.length() > STILL_M { offset.as_vec3() } else { glam::Vec3::ZERO });
            (shapes[shape].vertices, shapes[shape].deltas) = sparse(deltas);
            known.push((shape, offsets));
        }
        let skin = if character.skin.is_empty() && !actor.skin.is_empty() {
            self.carried(&actor.skin)
        } else {
            character.skin.clone()
        };
        let pivot = character.jaw_pivot_m.or_else(|| actor.jaw_pivot_m.map(|pivot| self.warped(pivot)));
        let rig = Rig {
            name: character.name.clone(),
            parts: character.parts.clone(),
            neutral: character.neutral.clone(),
            channels: actor.channels.clone(),
            shapes,
            skin,
            jaw_pivot_m: pivot,
            jaw: None,
            joints: Vec::new(),
        };
        Ok(rig.checked()?)
    }
}

/// Shorter displacements than this (metres) are rounding.
const STILL_M: f64 = 1e-7;

/// A shape that moves nothing yet.
fn bare(shape: &Shape) -> Shape {
    Shape { name: shape.name.clone(), driver: shape.driver.clone(), vertices: Vec::new(), deltas: Vec::new() }
}

/// Before which shapes a shape comes.
fn rank(driver: &Driver) -> usize {
    match driver {
        Driver::Channel(_) => 0,
        Driver::InBetween { .. } | Driver::Turn { .. } => 1,
        Driver::Combination(channels) => 2 + channels.len(),
    }
}

/// The weights of all channels at which a shape is whole.
fn peak(driver: &Driver, channels: usize) -> Vec<f32> {
    let mut weights = vec![0.0; channels];
    match driver {
        Driver::Channel(channel) => weights[*channel as usize] = 1.0,
        Driver::InBetween { channel, peak } => weights[*channel as usize] = *peak,
        Driver::Combination(all) => all.iter().for_each(|channel| weights[*channel as usize] = 1.0),
        Driver::Turn { .. } => {}
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Attachment, SurfacePoint};
    use crate::rig::toy::Dice;
    use crate::strain::{TransferOptions, toy};
    use glam::Vec3;

    /// A head with three channels, a combination and an in-between.
    fn actor() -> Rig {
        let mut rig = toy::with_shapes(&toy::bare_head(), 5, 0.01);
        rig.channels.truncate(3);
        (rig.shapes[3].name, rig.shapes[3].driver) = ("s0+s2".into(), Driver::Combination(vec![0, 2]));
        (rig.shapes[4].name, rig.shapes[4].driver) = ("s1@0.5".into(), Driver::InBetween { channel: 1, peak: 0.5 });
        rig.checked().unwrap()
    }

    fn marks() -> Attachment {
        let point = |vertex: u32| SurfacePoint {
            name: format!("mark_{vertex}"),
            vertices: [vertex, 0, 1],
            weights: [1.0, 0.0, 0.0],
            distance_m: 0.0,
        };
        Attachment { points: (0..64).step_by(9).chain([7, 56]).map(point).collect() }
    }

    fn carried(actor: &Rig, character: &Rig) -> Rig {
        let marks = marks();
        let parts: Vec<_> = actor.parts.iter().collect();
        let options = TransferOptions { smoothing_m: 0.0 };
        Transfer::new(actor, character, &parts, (&marks, &marks), None, &options).unwrap().rig(actor).unwrap()
    }

    #[test]
    fn a_head_of_another_size_moves_alike_at_all_weights() {
        let actor = actor();
        let mut bare = toy::bare_head();
        let grown = |point: Vec3| point * Vec3::new(1.3, 0.9, 1.1) + Vec3::new(0.0, 0.2, 0.0);
        bare.neutral.iter_mut().for_each(|point| *point = grown(*point));
        let rig = carried(&actor, &bare);
        assert_eq!((&rig.channels, rig.shapes.len()), (&actor.channels, 5));
        let (own, other) = (Puppet::new(&actor).unwrap(), Puppet::new(&rig).unwrap());
        let mut dice = Dice(77);
        for _ in 0..10 {
            let weights: Vec<f32> = (0..3).map(|_| dice.roll()).collect();
            let pairs = own.vertices(&weights).unwrap().into_iter().zip(other.vertices(&weights).unwrap());
            // Points of the teeth and the eyeball ride on their one triangle.
            assert!(pairs.take(64).all(|(a, b)| grown(a).abs_diff_eq(b, 1e-6)));
        }
    }

    #[test]
    fn a_bent_head_meets_the_transfer_at_every_peak() {
        let actor = actor();
        let mut bent = toy::bare_head();
        bent.neutral.iter_mut().for_each(|point| point.z += 3.0 * point.x * point.y);
        let rig = carried(&actor, &bent);
        let marks = marks();
        let parts: Vec<_> = actor.parts.iter().collect();
        let transfer =
            Transfer::new(&actor, &bent, &parts, (&marks, &marks), None, &TransferOptions { smoothing_m: 0.0 })
                .unwrap();
        let (own, other) = (Puppet::new(&actor).unwrap(), Puppet::new(&rig).unwrap());
        for shape in &actor.shapes {
            let weights = peak(&shape.driver, 3);
            let offsets = transfer.offsets(&own.vertices(&weights).unwrap());
            for ((rest, by), found) in bent.neutral.iter().zip(offsets).zip(other.vertices(&weights).unwrap()) {
                assert!((rest.as_dvec3() + by).as_vec3().abs_diff_eq(found, 1e-6), "{}", shape.name);
            }
        }
    }

    #[test]
    fn skin_and_pivot_come_along_where_the_character_has_none_and_joints_are_refused() {
        let actor = actor();
        let mut bare = toy::bare_head();
        let rig = carried(&actor, &bare);
        assert_eq!((&rig.skin, rig.jaw_pivot_m), (&bare.skin, bare.jaw_pivot_m));
        (bare.skin, bare.jaw_pivot_m) = (Vec::new(), None);
        let rig = carried(&actor, &bare);
        assert!(rig.skin.iter().zip(&actor.skin).take(64).all(|(a, b)| (a - b).abs() < 1e-5));
        assert!(rig.jaw_pivot_m.unwrap().abs_diff_eq(toy::JAW, 1e-6));

        let mut posed = toy::jointed_head();
        let driver = Driver::Turn { joint: 0, row: 0, column: 1 };
        posed.shapes.push(Shape { name: "jaw_pose_01".into(), driver, vertices: Vec::new(), deltas: Vec::new() });
        let (marks, parts) = (marks(), posed.parts.iter().collect::<Vec<_>>());
        let options = TransferOptions { smoothing_m: 0.0 };
        let transfer = Transfer::new(&posed, &bare, &parts, (&marks, &marks), None, &options).unwrap();
        assert!(transfer.rig(&posed).unwrap_err().to_string().contains("`jaw_pose_01`"));
    }
}
