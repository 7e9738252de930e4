//! `skin_jaw`: makes the jaw of a rig a joint, so that lips and chin turn with it instead of sliding.

use crate::patterns::Patterns;
use face_math::data::Rig;
use face_math::rig::{SkinJawOptions, skin_jaw};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "a head whose shapes hold the whole deformation, the jaw's motion included");
const SKINNED: Port<Rig> =
    Port::new("rig", "the same head with the jaw as a joint; its shapes hold what is left (\"de-skinned\" offsets)");

/// Splits the jaw's motion off a rig whose shapes hold the whole deformation.
///
/// The motion of the lower teeth under each jaw channel gives the jaw's rotation and translation there; the shapes keep
/// what is left. At each shape's full weight the head looks as before; in between, and where jaw channels mix with
/// others, the jaw now turns on its joint, as real jaws do.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SkinJaw {
    /// The part that only the jaw moves.
    part: String,
    /// The channels that move the jaw, as patterns: `jaw*`. Found by what they do to the part where empty.
    channels: Vec<String>,
    /// A shape moves the jaw where it moves the part by at least this, in millimetres (root mean square).
    #[schemars(range(min = 0.0, max = 100.0))]
    min_motion_mm: f64,
    /// … and where the rigid fit leaves at most this share of the motion.
    #[schemars(range(min = 0.0, max = 1.0))]
    max_residual_share: f64,
    /// Whether to take each vertex' share in the jaw from the rig's own skin, where it has one. Otherwise the shares are
    /// found from the motion of the jaw channels.
    own_skin: bool,
}

impl Default for SkinJaw {
    fn default() -> Self {
        let usual = SkinJawOptions::default();
        Self {
            part: usual.part,
            channels: usual.channels,
            min_motion_mm: 0.5,
            max_residual_share: usual.max_residual_share,
            own_skin: usual.own_skin,
        }
    }
}

graph_core::register!(SkinJaw);

#[typetag::serde(name = "skin_jaw")]
impl Node for SkinJaw {
    fn card(&self) -> Card {
        Card::new("rig").takes(&RIG).gives(&SKINNED)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let rig = inputs.get(&RIG)?;
        let channels = if self.channels.is_empty() {
            Vec::new()
        } else {
            Patterns { parameter: "channels", what: "channel", names: &rig.channels }.chosen(&self.channels)?
        };
        let options = SkinJawOptions {
            part: self.part.clone(),
            channels,
            min_motion_m: self.min_motion_mm / 1000.0,
            max_residual_share: self.max_residual_share,
            own_skin: self.own_skin,
        };
        let skinned = skin_jaw(rig, &options).map_err(|error| NodeError::input(RIG.name(), error))?;
        let count = skinned.fits.len().max(1) as f64;
        let mean = |of: &dyn Fn(&face_math::rig::JawFit) -> f64| skinned.fits.iter().map(of).sum::<f64>() / count;
        context.progress(
            1.0,
            &[
                ("jaw shapes", skinned.fits.len() as f64),
                ("mean motion mm", 1000.0 * mean(&|fit| fit.motion_rms_m)),
                ("mean residual mm", 1000.0 * mean(&|fit| fit.residual_rms_m)),
            ],
        );
        Ok(Outputs::default().with(&SKINNED, skinned.rig))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made, test_data};
    use face_math::rig::Puppet;
    use serde_json::json;

    fn skin(parameters: serde_json::Value, rig: &Rig) -> Result<Rig, String> {
        let node: SkinJaw = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&RIG, rig.clone()));
        outputs.map(|outputs| outputs.get(&SKINNED).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_real_head_keeps_its_shapes_and_gains_a_joint() {
        let Some(path) = test_data("actors/ict_actor_a/ict_actor_a.glb") else { return };
        let rig = face_io::gltf::read(&std::fs::read(path).unwrap(), "actor", &mut face_io::no_sibling).unwrap();
        let skinned = skin(json!({}), &rig).unwrap();
        let motions = &skinned.jaw.as_ref().unwrap().motions;
        let moved: Vec<&str> = motions.iter().map(|motion| rig.shapes[motion.shape as usize].name.as_str()).collect();
        for channel in ["jawOpen", "jawForward", "jawLeft", "jawRight"] {
            assert!(moved.contains(&channel), "{moved:?}");
        }
        let mut weights = vec![0.0; rig.channels.len()];
        weights[rig.channel("jawOpen").unwrap()] = 1.0;
        let (whole, split) = (Puppet::new(&rig).unwrap(), Puppet::new(&skinned).unwrap());
        for (a, b) in whole.vertices(&weights).unwrap().iter().zip(split.vertices(&weights).unwrap()) {
            assert!(a.abs_diff_eq(b, 2e-6), "{a} {b}");
        }
        let named = skin(json!({"channels": ["jaw*"]}), &rig).unwrap();
        assert!(named.jaw.unwrap().motions.len() >= 4);
        assert!(skin(json!({}), &skinned).unwrap_err().contains("a joint already"));
    }

    #[test]
    fn a_head_without_lower_teeth_says_so() {
        let error = skin(json!({}), &crate::rig::toy::rig()).unwrap_err();
        assert!(error.contains("`rig`") && error.contains("teeth_lower"), "{error}");
        let error = skin(json!({"channels": ["jawOpn"]}), &crate::rig::toy::rig()).unwrap_err();
        assert!(error.contains("did you mean `jawOpen`?"), "{error}");
    }
}
