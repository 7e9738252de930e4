//! A kind of node with a parameter of every shape, for graphs to name.

use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wire::{Data, DecodeError, Decoder, Encoder, Value, ValueKind};

/// Makes the kinds part of the program that calls it.
pub fn link() {
    assert!(graph_core::node::kind("many").is_some());
}

#[derive(Debug)]
struct Text(String);

impl Value for Text {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.text(&self.0);
    }

    fn summary(&self) -> String {
        self.0.clone()
    }

    fn size(&self) -> usize {
        self.0.len()
    }
}

impl Data for Text {
    const NAME: &'static str = "Text";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        input.text().map(Self)
    }
}

const FIRST: Port<Text> = Port::new("first", "a text");
const ALL: Port<Text> = Port::new("all", "texts");
const OUT: Port<Text> = Port::new("out", "a text");
const LIST: Port<Text> = Port::new("list", "texts");

#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Way {
    #[default]
    Plain,
    Wide(f64),
    Named {
        /// How long.
        #[schemars(range(min = 1, max = 9))]
        length: u8,
    },
}

#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Pose {
    frame: usize,
    weights: BTreeMap<String, f64>,
}

/// Has parameters of many shapes.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Many {
    /// A number.
    #[schemars(range(min = 0.0, max = 10.0))]
    number: f64,
    /// A whole number.
    count: i64,
    flag: bool,
    text: String,
    path: Option<String>,
    way: Way,
    poses: BTreeMap<String, Vec<Pose>>,
    pair: (f64, u32),
    triple: [f32; 3],
}

graph_core::register!(Many);

#[typetag::serde(name = "many")]
impl Node for Many {
    fn card(&self) -> Card {
        Card::new("work").may_take(&FIRST).may_gather(&ALL).gives(&OUT).gives_list(&LIST)
    }

    fn compute(&self, _: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        Err(NodeError::failed("it is never computed"))
    }
}
