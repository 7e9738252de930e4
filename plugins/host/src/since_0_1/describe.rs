//! Schemas of interface 0.1 as the host knows them.

use super::bindings::grimace::node::types as wit;
use crate::schema::{NodeSchema, ParameterSchema, PortSchema, Setting, TimeUse};

/// A node as its plugin describes it.
pub fn node(node: wit::NodeSchema) -> NodeSchema {
    NodeSchema {
        name: node.name,
        doc: node.doc,
        version: node.version,
        time: match node.time {
            wit::Time::Whole => TimeUse::Whole,
            wit::Time::PerFrame(halo) => TimeUse::PerFrame(halo),
            wit::Time::PerFrameBy(parameter) => TimeUse::PerFrameBy(parameter),
        },
        inputs: node.inputs.into_iter().map(port).collect(),
        outputs: node.outputs.into_iter().map(port).collect(),
        parameters: node.parameters.into_iter().map(parameter).collect(),
    }
}

fn port(port: wit::PortSchema) -> PortSchema {
    let wit::PortSchema { name, type_name, doc, optional, many, still } = port;
    PortSchema { name, type_name, doc, optional, many, still }
}

fn parameter(parameter: wit::ParameterSchema) -> ParameterSchema {
    ParameterSchema {
        name: parameter.name,
        doc: parameter.doc,
        default: match parameter.default {
            wit::SettingResult::Flag(flag) => Setting::Flag(flag),
            wit::SettingResult::Integer(number) => Setting::Integer(number),
            wit::SettingResult::Number(number) => Setting::Number(number),
            wit::SettingResult::Text(text) => Setting::Text(text),
            wit::SettingResult::Numbers(numbers) => Setting::Numbers(numbers),
        },
        least: parameter.least,
        most: parameter.most,
        choices: parameter.choices.into_iter().map(|choice| (choice.name, choice.doc)).collect(),
    }
}
