//! A probe node that has every kind of parameter, described.

use super::{KindDescription, describe, first_sentence};
use crate::node::{Card, Context, Inputs, Kind, Node, NodeError, Outputs};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How steps grow.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Growth {
    /// They stay as they are.
    #[default]
    Constant,
    /// They grow to a peak and shrink again.
    Peak {
        /// The largest step.
        #[schemars(range(min = 0.0))]
        top: f64,
    },
}

#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
struct Inner {
    /// Second by name, first as declared.
    weight: f32,
    /// First by name.
    angle: Option<f64>,
}

/// Tries everything that a parameter can be. It is
/// a test.
///
/// Its second paragraph.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct DescribedProbe {
    /// The file.
    path: String,
    /// Cut-off.
    #[schemars(range(min = 0.1, max = 120.0))]
    cutoff_hz: f64,
    /// The growth here.
    growth: Growth,
    /// Things within.
    inner: Inner,
    /// Names.
    names: Vec<String>,
    /// Others by name.
    by_name: BTreeMap<String, Inner>,
}

impl Default for DescribedProbe {
    fn default() -> Self {
        let inner = Inner { weight: 0.1, angle: None };
        let names = vec!["a".to_owned()];
        Self {
            path: String::new(),
            cutoff_hz: 6.0,
            growth: Growth::Peak { top: 2.5 },
            inner,
            names,
            by_name: BTreeMap::new(),
        }
    }
}

#[typetag::serde(name = "described_probe")]
impl Node for DescribedProbe {
    fn card(&self) -> Card {
        Card::new("load").reads("path").per_frame(2).version(3)
    }

    fn compute(&self, _: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        Err(NodeError::failed("only described"))
    }
}

fn described() -> KindDescription {
    describe(&Kind::of::<DescribedProbe>())
}

#[test]
fn the_card_is_told() {
    let of = described();
    assert_eq!((of.name.as_str(), of.folder.as_str(), of.version), ("described_probe", "load", 3));
    assert_eq!(of.time, "per frame, with 2 frames on either side");
    assert_eq!(of.doc, "Tries everything that a parameter can be. It is\na test.\n\nIts second paragraph.");
    assert_eq!(first_sentence(&of.doc), "Tries everything that a parameter can be.");
    assert_eq!(first_sentence("Reads files (e.g. c3d. no) of\nall kinds"), "Reads files (e.g. c3d. no) of all kinds");
}

#[test]
fn parameters_stand_in_their_order_with_defaults_as_written() {
    let of = described();
    let told: Vec<_> = of.parameters.iter().map(|one| (one.name.as_str(), one.default.as_deref())).collect();
    let inner = "(weight: 0.1, angle: None)";
    let expected = [
        ("path", None),
        ("cutoff_hz", Some("6.0")),
        ("growth", Some("peak(top: 2.5)")),
        ("inner", Some(inner)),
        ("names", Some("[\"a\"]")),
        ("by_name", Some("{}")),
    ];
    assert_eq!(told, expected);
    let path = &of.parameters[0];
    assert!(path.required && path.file == Some("reads"));
    assert_eq!(path.type_text, "the path of a file, or a pattern of several");
}

#[test]
fn ranges_choices_and_fields_are_told() {
    let of = described();
    let [_, cutoff, growth, inner, _, by_name] = of.parameters.as_slice() else { panic!("{:?}", of.parameters) };
    assert_eq!((cutoff.least, cutoff.most), (Some(0.1), Some(120.0)));
    assert_eq!((cutoff.type_text.as_str(), cutoff.doc.as_str()), ("a number between 0.1 and 120 Hz", "Cut-off."));
    assert_eq!(growth.doc, "The growth here.");
    let choices: Vec<_> = growth.choices.iter().map(|one| (one.name.as_str(), one.doc.as_str())).collect();
    let expected = [("constant", "They stay as they are."), ("peak(…)", "They grow to a peak and shrink again.")];
    assert_eq!(choices, expected);
    assert_eq!(growth.choices[1].fields[0].doc, "The largest step.");
    let fields: Vec<_> = inner.fields.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(fields, ["weight", "angle"]);
    assert_eq!(by_name.fields.len(), 2, "those of the map's values");
    assert!(growth.fields.is_empty() && inner.choices.is_empty());
}
