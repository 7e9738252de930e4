//! The program with nodes that are wrong on purpose, for tests that a check notices them.

use face_math::data::Curves;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use std::time::{SystemTime, UNIX_EPOCH};

const CURVES: Port<Curves> = Port::new("curves", "curves");
const SAME: Port<Curves> = Port::new("same", "the same curves");

/// Passes curves on. Its key may change from cook to cook, as that of a node would that mixes what time it is into its parameters.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PassCurves {
    /// Whether the key is not that of the last cook.
    #[serde(serialize_with = "restless")]
    restless: f64,
}

/// 0 stays; anything else is the time of day.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn restless<S: Serializer>(restless: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64());
    serializer.serialize_f64(if *restless == 0.0 { 0.0 } else { now })
}

graph_core::register!(PassCurves);

#[typetag::serde(name = "pass_curves")]
impl Node for PassCurves {
    fn card(&self) -> Card {
        Card::new("clean").takes(&CURVES).gives(&SAME)
    }

    fn compute(&self, _: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        Ok(Outputs::default().with(&SAME, inputs.get(&CURVES)?.clone()))
    }
}

fn main() -> std::process::ExitCode {
    grimace::main()
}
