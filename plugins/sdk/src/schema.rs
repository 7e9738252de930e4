//! Schemas, part by part.

use crate::bindings::grimace::node::types as wit;
use std::ops::RangeInclusive;

/// What a node says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Schema(pub(crate) wit::NodeSchema);

impl Schema {
    /// A node called `name` (`snake_case`) that works whole; `doc` is its manual.
    #[must_use]
    pub fn new(name: &str, doc: &str) -> Self {
        Self(wit::NodeSchema {
            name: name.to_owned(),
            doc: doc.to_owned(),
            version: 1,
            time: wit::Time::Whole,
            inputs: Vec::new(),
            outputs: Vec::new(),
            parameters: Vec::new(),
        })
    }

    /// Adds an input of a type of the engine: `Curves`, `Markers`, `Meshes`, `Image`, `Number`, `Text`, `Tensor` …
    #[must_use]
    pub fn takes(mut self, name: &str, type_name: &str, doc: &str) -> Self {
        self.0.inputs.push(port(name, type_name, doc));
        self
    }

    /// Says that the input added last may be left open.
    #[must_use]
    pub fn optional(mut self) -> Self {
        self.last_input().optional = true;
        self
    }

    /// Says that the input added last gathers a list.
    #[must_use]
    pub fn many(mut self) -> Self {
        self.last_input().many = true;
        self
    }

    /// Says that the input added last is given whole, though the node works per frame.
    #[must_use]
    pub fn still(mut self) -> Self {
        self.last_input().still = true;
        self
    }

    fn last_input(&mut self) -> &mut wit::PortSchema {
        self.0.inputs.last_mut().expect("an input was added before")
    }

    /// Adds an output.
    #[must_use]
    pub fn gives(mut self, name: &str, type_name: &str, doc: &str) -> Self {
        self.0.outputs.push(port(name, type_name, doc));
        self
    }

    /// Adds an output that is a list of named values.
    #[must_use]
    pub fn gives_list(mut self, name: &str, type_name: &str, doc: &str) -> Self {
        self.0.outputs.push(wit::PortSchema { many: true, ..port(name, type_name, doc) });
        self
    }

    /// Adds a number with its default and range. A unit is the last word of its name: `cutoff_hz`, `reach_mm`.
    #[must_use]
    pub fn number(self, name: &str, default: f64, range: RangeInclusive<f64>, doc: &str) -> Self {
        self.parameter(name, wit::Setting::Number(default), Some((*range.start(), *range.end())), doc)
    }

    /// Adds a whole number with its default and range.
    #[must_use]
    pub fn integer(self, name: &str, default: i64, range: RangeInclusive<i64>, doc: &str) -> Self {
        let range = (*range.start() as f64, *range.end() as f64);
        self.parameter(name, wit::Setting::Integer(default), Some(range), doc)
    }

    /// Adds a switch with its default.
    #[must_use]
    pub fn flag(self, name: &str, default: bool, doc: &str) -> Self {
        self.parameter(name, wit::Setting::Flag(default), None, doc)
    }

    /// Adds a text with its default.
    #[must_use]
    pub fn text(self, name: &str, default: &str, doc: &str) -> Self {
        self.parameter(name, wit::Setting::Text(default.to_owned()), None, doc)
    }

    /// Adds a list of numbers with its default and the range of each.
    #[must_use]
    pub fn numbers(self, name: &str, default: &[f64], range: RangeInclusive<f64>, doc: &str) -> Self {
        self.parameter(name, wit::Setting::Numbers(default.to_vec()), Some((*range.start(), *range.end())), doc)
    }

    /// Adds a choice between names, each with what it means; the first is the default.
    #[must_use]
    pub fn choice(mut self, name: &str, choices: &[(&str, &str)], doc: &str) -> Self {
        let default = choices.first().map_or("", |(name, _)| name);
        self = self.parameter(name, wit::Setting::Text(default.to_owned()), None, doc);
        if let Some(parameter) = self.0.parameters.last_mut() {
            let choice = |(name, doc): &(&str, &str)| wit::Choice { name: (*name).to_owned(), doc: (*doc).to_owned() };
            parameter.choices = choices.iter().map(choice).collect();
        }
        self
    }

    fn parameter(mut self, name: &str, default: wit::Setting, range: Option<(f64, f64)>, doc: &str) -> Self {
        self.0.parameters.push(wit::ParameterSchema {
            name: name.to_owned(),
            doc: doc.to_owned(),
            default,
            least: range.map(|range| range.0).filter(|bound| bound.is_finite()),
            most: range.map(|range| range.1).filter(|bound| bound.is_finite()),
            choices: Vec::new(),
        });
        self
    }

    /// Frame t of the outputs needs frames t − `halo` to t + `halo` of the inputs: the engine then works block by block, and
    /// after an edit of one frame on that block alone.
    #[must_use]
    pub fn per_frame(mut self, halo: u32) -> Self {
        self.0.time = wit::Time::PerFrame(halo);
        self
    }

    /// The same; the halo is the value of the integer parameter `parameter`.
    #[must_use]
    pub fn per_frame_by(mut self, parameter: &str) -> Self {
        self.0.time = wit::Time::PerFrameBy(parameter.to_owned());
        self
    }
}

fn port(name: &str, type_name: &str, doc: &str) -> wit::PortSchema {
    wit::PortSchema {
        name: name.to_owned(),
        type_name: type_name.to_owned(),
        doc: doc.to_owned(),
        optional: false,
        many: false,
        still: false,
    }
}
