//! Schemas: what a plugin says of its nodes, whichever version of the interface it speaks, and whether it may be so.

use crate::values::{Blob, FrameTensor, Number, Tensor, Text};
use face_math::data::{Curves, Features, Image, Markers, Meshes, Views};
use graph_core::document::did_you_mean;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;
use wire::ValueKind;

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Setting {
    /// True or false.
    Flag(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// A text, or one of the choices.
    Text(String),
    /// Numbers.
    Numbers(Vec<f64>),
}

/// A parameter of a node; its type is that of its default.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterSchema {
    /// Its name.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// Its default.
    pub default: Setting,
    /// The least that a number may be.
    pub least: Option<f64>,
    /// The most that a number may be.
    pub most: Option<f64>,
    /// All that a text may be, with what each means; empty where any text will do.
    pub choices: Vec<(String, String)>,
}

/// A port of a node.
#[derive(Debug, Clone, PartialEq)]
pub struct PortSchema {
    /// Its name.
    pub name: String,
    /// The type of its values.
    pub type_name: String,
    /// What a value on it is.
    pub doc: String,
    /// Whether the node works without it.
    pub optional: bool,
    /// Whether it carries a list.
    pub many: bool,
    /// Whether it is given whole to a node that works per frame.
    pub still: bool,
}

/// How a node uses time.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeUse {
    /// As a whole.
    Whole,
    /// Per frame with so many frames on either side.
    PerFrame(u32),
    /// Per frame with as many frames on either side as this parameter says.
    PerFrameBy(String),
}

/// A node of a plugin.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeSchema {
    /// Its name within the plugin.
    pub name: String,
    /// What it does.
    pub doc: String,
    /// Version of its computation.
    pub version: u32,
    /// How it uses time.
    pub time: TimeUse,
    /// Inputs.
    pub inputs: Vec<PortSchema>,
    /// Outputs.
    pub outputs: Vec<PortSchema>,
    /// Parameters.
    pub parameters: Vec<ParameterSchema>,
}

/// What is wrong with a schema.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("its node `{node}`: {problem}")]
pub struct SchemaError {
    /// The node.
    pub node: String,
    /// What is wrong, and with which part.
    pub problem: String,
}

/// Nodes that a plugin may have, and ports and parameters that a node may have.
const MOST: usize = 100;
/// Letters of a description.
const DOC: usize = 10_000;
/// Frames that a halo may have.
const HALO: u32 = 10_000;

/// The types that may stand on ports: those that cross as they are, and all others of the linked nodes, whose encodings cross.
static TYPES: LazyLock<BTreeMap<&'static str, ValueKind>> = LazyLock::new(|| {
    let linked = graph_core::node::kinds().flat_map(|(_, kind)| {
        let card = kind.card();
        card.inputs.into_iter().chain(card.outputs).map(|port| port.kind).collect::<Vec<_>>()
    });
    let own = [
        ValueKind::of::<Number>(),
        ValueKind::of::<Text>(),
        ValueKind::of::<Tensor>(),
        ValueKind::of::<FrameTensor>(),
        ValueKind::of::<Blob>(),
        ValueKind::of::<Markers>(),
        ValueKind::of::<Curves>(),
        ValueKind::of::<Views>(),
        ValueKind::of::<Features>(),
        ValueKind::of::<Meshes>(),
        ValueKind::of::<Image>(),
    ];
    linked.chain(own).map(|kind| (kind.name, kind)).collect()
});

/// The type called `name`.
pub(crate) fn kind_of(name: &str) -> Option<ValueKind> {
    TYPES.get(name).copied()
}

/// Whether what a plugin says of its nodes may be so.
pub(crate) fn check(nodes: &[NodeSchema]) -> Result<(), SchemaError> {
    let wrong = |node: &str, problem: String| Err(SchemaError { node: node.chars().take(80).collect(), problem });
    if nodes.is_empty() || nodes.len() > MOST {
        return wrong("", format!("it has {} nodes; a plugin has 1 to {MOST}", nodes.len()));
    }
    let mut names = BTreeSet::new();
    for node in nodes {
        if let Err(problem) = of_node(node) {
            return wrong(&node.name, problem);
        }
        if !names.insert(&node.name) {
            return wrong(&node.name, "two nodes have this name".to_owned());
        }
    }
    Ok(())
}

fn of_node(node: &NodeSchema) -> Result<(), String> {
    name("its name", &node.name)?;
    doc("its description", &node.doc)?;
    for (what, count) in
        [("inputs", node.inputs.len()), ("outputs", node.outputs.len()), ("parameters", node.parameters.len())]
    {
        if count > MOST {
            return Err(format!("it has {count} {what}; a node has at most {MOST}"));
        }
    }
    if node.outputs.is_empty() {
        return Err("it has no outputs".to_owned());
    }
    for (what, ports) in [("input", &node.inputs), ("output", &node.outputs)] {
        unique(what, ports.iter().map(|port| port.name.as_str()))?;
        for port in ports {
            of_port(what, port)?;
        }
    }
    if let Some(port) = node.outputs.iter().find(|port| port.optional || port.still) {
        return Err(format!("its output `{}` is optional or still, which only inputs may be", port.name));
    }
    unique("parameter", node.parameters.iter().map(|parameter| parameter.name.as_str()))?;
    for parameter in &node.parameters {
        of_parameter(parameter).map_err(|problem| format!("its parameter `{}` {problem}", parameter.name))?;
    }
    of_time(node)
}

fn name(what: &str, text: &str) -> Result<(), String> {
    let letters = text.chars().all(|letter| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_');
    if letters && text.starts_with(|letter: char| letter.is_ascii_lowercase()) && text.len() <= 64 {
        return Ok(());
    }
    let shown: String = text.chars().take(80).collect();
    Err(format!("{what} {shown:?} must be small letters, digits and `_`, at most 64, the first a letter"))
}

fn doc(what: &str, text: &str) -> Result<(), String> {
    match text.len() {
        0 => Err(format!("{what} is empty: say what it is, for the manual")),
        long if long > DOC => Err(format!("{what} has {long} bytes; at most {DOC} are shown")),
        _ => Ok(()),
    }
}

fn unique<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> Result<(), String> {
    let mut seen = BTreeSet::new();
    for text in names {
        name(&format!("the name of its {what}"), text)?;
        if !seen.insert(text) {
            return Err(format!("two {what}s are called `{text}`"));
        }
    }
    Ok(())
}

fn of_port(what: &str, port: &PortSchema) -> Result<(), String> {
    doc(&format!("the description of its {what} `{}`", port.name), &port.doc)?;
    if kind_of(&port.type_name).is_some() {
        return Ok(());
    }
    let shown: String = port.type_name.chars().take(80).collect();
    let near = did_you_mean(&shown, TYPES.keys().copied());
    let types = || TYPES.keys().copied().collect::<Vec<_>>().join(", ");
    let cure = near.map_or_else(|| format!("the types are {}", types()), |near| format!("did you mean `{near}`?"));
    Err(format!("its {what} `{}` is of the type `{shown}`, which there is not; {cure}", port.name))
}

fn of_parameter(parameter: &ParameterSchema) -> Result<(), String> {
    doc("has a description that", &parameter.doc)?;
    let bound = |bound: Option<f64>| bound.is_none_or(f64::is_finite);
    let is_number = matches!(parameter.default, Setting::Integer(_) | Setting::Number(_) | Setting::Numbers(_));
    match (parameter.least, parameter.most) {
        (None, None) => {}
        _ if !is_number => return Err("has a range, and is no number".to_owned()),
        (least, most) if !bound(least) || !bound(most) => return Err("has a range that is not finite".to_owned()),
        (Some(least), Some(most)) if least > most => return Err(format!("has a range from {least} to {most}")),
        _ => {}
    }
    let fits = |number: f64| {
        number.is_finite()
            && parameter.least.is_none_or(|least| number >= least)
            && parameter.most.is_none_or(|most| number <= most)
    };
    let sound = match &parameter.default {
        Setting::Flag(_) => true,
        Setting::Integer(number) => fits(*number as f64),
        Setting::Number(number) => fits(*number),
        Setting::Numbers(numbers) => numbers.iter().copied().all(fits),
        Setting::Text(text) => {
            parameter.choices.is_empty() || parameter.choices.iter().any(|(choice, _)| choice == text)
        }
    };
    if !sound {
        return Err("has a default that is none of the values it may have".to_owned());
    }
    if parameter.choices.is_empty() {
        return Ok(());
    }
    if !matches!(parameter.default, Setting::Text(_)) {
        return Err("has choices, and is no text".to_owned());
    }
    if parameter.choices.len() > MOST {
        return Err(format!("has {} choices; at most {MOST}", parameter.choices.len()));
    }
    unique("choice", parameter.choices.iter().map(|(choice, _)| choice.as_str()))
}

fn of_time(node: &NodeSchema) -> Result<(), String> {
    let halo = match &node.time {
        TimeUse::Whole => return Ok(()),
        TimeUse::PerFrame(halo) => f64::from(*halo),
        TimeUse::PerFrameBy(name) => {
            let found = node.parameters.iter().find(|parameter| parameter.name == *name);
            match found.map(|parameter| (&parameter.default, parameter.least, parameter.most)) {
                Some((Setting::Integer(_), Some(least), Some(most))) if least >= 0.0 => most,
                _ => {
                    return Err(format!(
                        "its halo is said to be the parameter `{name}`, which must be an integer with a range from 0 or more"
                    ));
                }
            }
        }
    };
    if halo > f64::from(HALO) {
        return Err(format!("it may need {halo} frames on either side; with more than {HALO}, work whole"));
    }
    let framed = |port: &PortSchema| kind_of(&port.type_name).is_some_and(|kind| kind.framed);
    if !node.inputs.iter().any(|port| framed(port) && !port.still) {
        return Err("it works per frame, and no input of it varies over time".to_owned());
    }
    match node.outputs.iter().find(|port| !framed(port) || port.many) {
        Some(port) => {
            Err(format!("it works per frame, and its output `{}` does not vary over time, or is a list", port.name))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
