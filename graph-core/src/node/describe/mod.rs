//! Descriptions of node kinds: ports and parameters as the manual, `grimace nodes` and the editor show them. All of it
//! is lifted from a kind's card and from the comments and ranges on its parameter fields.

mod keys;
mod written;

#[cfg(test)]
mod tests;

use super::{Card, Kind, PortFacts, Time};
use crate::document::Schema;
use keys::{Keys, declared};
use serde::Serialize;
use serde_json::Value;
use written::written;

/// Everything that a kind says of itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KindDescription {
    /// The tag under which graphs name it.
    pub name: String,
    /// Folder in which the node stands, in the order of the data's flow.
    pub folder: String,
    /// Version of its computation.
    pub version: u32,
    /// What it does.
    pub doc: String,
    /// How it uses time: `whole`, or `per frame` with the frames it needs on either side.
    pub time: String,
    /// Inputs, in the order of the card.
    pub inputs: Vec<PortDescription>,
    /// Outputs, in the order of the card.
    pub outputs: Vec<PortDescription>,
    /// Parameters, in the order in which they are declared.
    pub parameters: Vec<ParameterDescription>,
}

/// A port of a kind with its default parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PortDescription {
    /// The port's name.
    pub name: String,
    /// The type of its values: `Markers`, or `[Markers]` for a list.
    #[serde(rename = "type")]
    pub type_text: String,
    /// What a value on it is.
    pub meaning: String,
    /// Whether the node works without it.
    pub optional: bool,
}

/// A parameter, or a field within one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterDescription {
    /// The parameter's name.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// What may be given, in words: `a number between 0.1 and 120 Hz`.
    #[serde(rename = "type")]
    pub type_text: String,
    /// Whether it must be given.
    pub required: bool,
    /// Its default as a graph would write it; `None` where it must be given, or has none of its own.
    pub default: Option<String>,
    /// The least number allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// The greatest number allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// Whether it names the file that the node reads (`reads`) or writes (`writes`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<&'static str>,
    /// The variants, where it is a choice.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<ChoiceDescription>,
    /// The fields, where it is a structure or a list of structures.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<ParameterDescription>,
}

/// One variant of a choice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChoiceDescription {
    /// The variant as a graph writes it: `linear`, or `spline(…)` where it has content.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// The fields of its content.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<ParameterDescription>,
}

/// Structures within structures are followed so far; types that contain themselves end here.
const DEEPEST: usize = 6;

/// Describes a kind.
pub fn describe(kind: &Kind) -> KindDescription {
    let card = kind.card();
    let schema = kind.schema();
    let root = Schema::root(&schema);
    let mut parameters = fields(root, &declared(kind.default_node().as_ref()), 0);
    for parameter in &mut parameters {
        note_file(&card, parameter);
    }
    KindDescription {
        name: kind.name().to_owned(),
        folder: card.folder.to_owned(),
        version: card.version,
        doc: root.get("description").and_then(text).unwrap_or_default(),
        time: match card.time {
            Time::Whole => "whole".to_owned(),
            Time::PerFrame { halo: 0 } => "per frame".to_owned(),
            Time::PerFrame { halo: 1 } => "per frame, with 1 frame on either side".to_owned(),
            Time::PerFrame { halo } => format!("per frame, with {halo} frames on either side"),
        },
        inputs: card.inputs.iter().map(port).collect(),
        outputs: card.outputs.iter().map(port).collect(),
        parameters,
    }
}

/// The first sentence of a description.
pub fn first_sentence(doc: &str) -> String {
    let paragraph = doc.split("\n\n").next().unwrap_or_default();
    let line = paragraph.split_whitespace().collect::<Vec<_>>().join(" ");
    // A full stop within brackets or an abbreviation is followed by a small letter.
    let ends = line.match_indices(". ").find(|(at, _)| line[at + 2..].starts_with(char::is_uppercase));
    ends.map_or(line.clone(), |(at, _)| line[..=at].to_owned())
}

fn port(facts: &PortFacts) -> PortDescription {
    PortDescription {
        name: facts.name.to_owned(),
        type_text: facts.type_text(),
        meaning: facts.meaning.to_owned(),
        optional: facts.optional,
    }
}

/// A path that is empty by default must be given.
fn note_file(card: &Card, parameter: &mut ParameterDescription) {
    let is = |named: Option<&str>| named == Some(parameter.name.as_str());
    let (file, type_text) = if is(card.reads) {
        ("reads", "the path of a file, or a pattern of several")
    } else if is(card.writes) {
        ("writes", "the path of a file")
    } else {
        return;
    };
    parameter.file = Some(file);
    type_text.clone_into(&mut parameter.type_text);
    if matches!(parameter.default.as_deref(), None | Some("\"\"")) {
        parameter.required = true;
        parameter.default = None;
    }
}

fn text(value: &Value) -> Option<String> {
    value.as_str().map(|text| text.trim().to_owned())
}

/// The fields of a structure, in the order of `declared`.
fn fields(schema: Schema<'_>, declared: &Keys, depth: usize) -> Vec<ParameterDescription> {
    if depth > DEEPEST {
        return Vec::new();
    }
    let required: Vec<&str> = schema.required().collect();
    let mut properties = schema.properties();
    properties.sort_by_key(|(name, _)| declared.position(name));
    let described = properties.into_iter().map(|(name, property)| {
        // A reference is followed in `property`; what stands beside the reference is said of this field alone.
        let beside = schema.get("properties").and_then(|properties| properties.get(name)).unwrap_or(&Value::Null);
        let (least, most) = property.bounds();
        // An optional structure, or one in a list or map, shows its fields as a plain one does.
        let content = property.inner("items").or(property.inner("additionalProperties")).unwrap_or(property);
        let choices = choices(content, depth);
        let structure = content.alternatives().into_iter().find(|one| !one.properties().is_empty());
        let structure = structure.filter(|_| choices.is_empty()).unwrap_or(content);
        ParameterDescription {
            name: name.to_owned(),
            doc: beside.get("description").or(property.get("description")).and_then(text).unwrap_or_default(),
            type_text: property.expected(name),
            required: required.contains(&name),
            default: beside.get("default").map(|default| written(default, property, declared.of(name))),
            least: least.map(|(least, _)| least),
            most: most.map(|(most, _)| most),
            file: None,
            fields: if choices.is_empty() { fields(structure, declared.of(name), depth + 1) } else { Vec::new() },
            choices,
        }
    });
    described.collect()
}

/// The variants of a choice; none for anything else.
fn choices(schema: Schema<'_>, depth: usize) -> Vec<ChoiceDescription> {
    let several = schema.alternatives();
    let alternatives = if several.is_empty() { vec![schema] } else { several };
    let mut choices = Vec::new();
    for one in alternatives {
        let own_doc = one.get("description").and_then(text).unwrap_or_default();
        if !schema.alternatives().is_empty()
            && let Some((name, content)) = one.variant()
        {
            let fields = fields(content, Keys::none(), depth + 1);
            choices.push(ChoiceDescription { name: format!("{name}(…)"), doc: own_doc, fields });
            continue;
        }
        let alone = one.get("const").is_some();
        for name in one.names() {
            let doc = if alone { own_doc.clone() } else { String::new() };
            choices.push(ChoiceDescription { name: name.to_owned(), doc, fields: Vec::new() });
        }
    }
    choices
}
