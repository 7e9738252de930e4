//! `load_edits`: keys and anchor poses that an artist set by hand, from their file. `pick_edits` takes those of one take.

use face_io::edits;
use face_math::data::Edits;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const EDITS: Port<Edits> = Port::new("edits", "keys and anchor poses of each take that has any");

/// Loads edits from RON, written by hand or by `grimace edit-key`.
///
/// The file holds, for each take, keys by channel and poses that anchor the take:
/// `(takes: {"day1_161": (anchors: [(frame: 52)], keys: {"jawOpen": [(frame: 120, value: 0.4, falloff_frames: 8)]})})`.
/// A key has a `value` (this weight exactly) or an `offset` (so much more than was solved); its change fades over
/// `falloff_frames` (8 unless given) on either side, or passes into the next key's where the two meet; its `curve` is `smooth`,
/// `linear` or `hold`. Frames are counted as the take counts them.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadEdits {
    /// The file.
    path: String,
}

graph_core::register!(LoadEdits);

#[typetag::serde(name = "load_edits")]
impl Node for LoadEdits {
    fn card(&self) -> Card {
        Card::new("load").reads("path").gives(&EDITS)
    }

    fn compute(&self, context: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        let source = context.source()?;
        let edits = edits::read(&source.bytes).map_err(|error| NodeError::file(&source.name, error))?;
        Ok(Outputs::default().with(&EDITS, edits))
    }
}
