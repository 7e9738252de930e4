//! The trivial node: a number from numbers.

use crate::shape::mix;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wire::{Data, DecodeError, Decoder, Encoder, Value, ValueKind};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number(pub u64);

impl Value for Number {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.count(self.0 as usize);
    }

    fn summary(&self) -> String {
        self.0.to_string()
    }

    fn size(&self) -> usize {
        8
    }
}

impl Data for Number {
    const NAME: &'static str = "Number";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        input.count().map(|number| Self(number as u64))
    }
}

const ONE: Port<Number> = Port::new("one", "a number");
const OTHER: Port<Number> = Port::new("other", "another number");
const MIXED: Port<Number> = Port::new("mixed", "both, mixed");

/// Mixes up to two numbers.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Mix {
    pub salt: u64,
}

graph_core::register!(Mix);

#[typetag::serde(name = "mix")]
impl Node for Mix {
    fn card(&self) -> Card {
        Card::new("work").may_take(&ONE).may_take(&OTHER).gives(&MIXED)
    }

    fn compute(&self, _: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let numbers = [inputs.may_get(&ONE)?, inputs.may_get(&OTHER)?];
        let mixed = mix(self.salt, numbers.into_iter().flatten().map(|number| number.0));
        Ok(Outputs::default().with(&MIXED, Number(mixed)))
    }
}
