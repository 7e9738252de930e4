//! `transfer_rig`: an actor's rig on another head, by landmarks and muscle curves; where a character without shapes begins.

use crate::strain::heads::{
    ACTOR, ACTOR_LANDMARKS, ACTOR_MUSCLES, CHARACTER, CHARACTER_LANDMARKS, CHARACTER_MUSCLES, bring_together,
};
use face_math::data::Rig;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new(
    "rig",
    "the character with the actor's channels and shapes; the shapes hold the whole deformation, the jaw's motion included",
);

/// Carries a rig from one head to another of any topology, so that one set of curves drives both.
///
/// The heads are brought together as by `transfer_meshes`, and every shape of the actor (channels, combinations, in-betweens) is
/// carried at its peak. Where the actor's jaw was split off, its motion is in the character's shapes again: `skin_jaw` splits it
/// off. A character that has shapes of its own loses them. Shapes that joints drive (strain rigs) cannot be carried one by one:
/// carry meshes, and fit a rig to them.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TransferRig {
    /// Parts of the actor that hold its skin, as patterns; the same parts of the character ride on them.
    parts: Vec<String>,
    /// How closely the warp keeps to landmarks and curves: 0 meets them exactly, more bends less.
    #[schemars(range(min = 0.0, max = 1000.0))]
    smoothing_mm: f64,
}

graph_core::register!(TransferRig);

#[typetag::serde(name = "transfer_rig")]
impl Node for TransferRig {
    fn card(&self) -> Card {
        Card::new("rig")
            .takes(&ACTOR)
            .takes(&CHARACTER)
            .takes(&ACTOR_LANDMARKS)
            .takes(&CHARACTER_LANDMARKS)
            .may_take(&ACTOR_MUSCLES)
            .may_take(&CHARACTER_MUSCLES)
            .gives(&RIG)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let actor = inputs.get(&ACTOR)?;
        let vertices = inputs.get(&CHARACTER)?.neutral.len();
        context.claim("actor", 24 * vertices * actor.shapes.len())?;
        let transfer = bring_together(inputs, &self.parts, self.smoothing_mm)?;
        let rig = transfer.rig(actor).map_err(|error| NodeError::input(ACTOR.name(), error))?;
        Ok(Outputs::default().with(&RIG, rig))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::compute;
    use face_math::data::{Curves, Driver, Shape};
    use glam::Vec3;
    use wire::FrameAxis;

    fn heads(character: Rig) -> Inputs {
        Inputs::default()
            .with(&ACTOR, toy::ACTOR.clone())
            .with(&CHARACTER, character)
            .with(&ACTOR_LANDMARKS, toy::landmarks())
            .with(&CHARACTER_LANDMARKS, toy::landmarks())
    }

    #[test]
    fn a_larger_head_without_shapes_makes_the_same_faces_larger() {
        let grown = |point: Vec3| point * 1.2 + Vec3::new(0.0, 0.1, 0.0);
        let mut character = toy::BASE.clone();
        (character.channels, character.shapes, character.jaw) = (Vec::new(), Vec::new(), None);
        character.joints.clear();
        character.neutral.iter_mut().for_each(|point| *point = grown(*point));
        let outputs = compute(&TransferRig::default(), &heads(character)).unwrap();
        let rig = outputs.get(&RIG).unwrap();
        let count = toy::ACTOR.channels.len();
        let one_hot = (0..count * count).map(|at| if at / count == at % count { 1.0 } else { 0.0 }).collect();
        let peaks = Curves::new(FrameAxis::new(count, 60.0), toy::ACTOR.channels.clone(), one_hot).unwrap();
        let (own, carried) = (toy::evaluated(&toy::ACTOR, &peaks), toy::evaluated(rig, &peaks));
        let face = toy::ACTOR.part("face").unwrap().vertices.end as usize;
        for frame in 0..peaks.frames() {
            for vertex in (0..face).step_by(20) {
                let (expected, found) = (grown(own.frame(frame)[vertex]), carried.frame(frame)[vertex]);
                assert!(found.distance(expected) < 5e-4, "{frame} {vertex}");
            }
        }
    }

    #[test]
    fn shapes_that_joints_drive_are_refused_with_the_way_out() {
        let mut inputs = heads(toy::BASE.clone());
        let mut posed = toy::BASE.clone();
        let driver = Driver::Turn { joint: 0, row: 1, column: 2 };
        let shape = Shape { name: "jaw_pose_12".into(), driver, vertices: vec![], deltas: vec![] };
        posed.shapes.push(shape);
        inputs = inputs.with(&ACTOR, posed);
        assert!(compute(&TransferRig::default(), &inputs).unwrap_err().to_string().contains("`transfer_meshes`"));
    }
}
