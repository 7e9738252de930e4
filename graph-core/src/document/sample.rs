//! Three small kinds of nodes, and short ways to make and print things, for the tests of this folder.

use super::{
    Body, Diagnostic, Diagnostics, Graph, Override, Scope, Source, apply_overrides, build_node, node_parameters, read,
    render,
};
use crate::node::{Card, Context, Inputs, Node, NodeError, Outputs};
use crate::register;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// How the strength changes over time.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Schedule {
    /// It stays.
    #[default]
    Constant,
    /// It falls evenly.
    Linear,
    /// It rises to a peak and falls.
    OneCycle {
        /// Highest strength.
        #[schemars(range(min = 0.0, max = 1.0))]
        peak: f64,
        /// Part of the time in which it rises.
        #[serde(default)]
        warmup: f64,
    },
    /// It falls at these frames.
    Steps(Vec<u32>),
}

/// A box.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Least.
    pub least_mm: f64,
    /// Most.
    pub most_mm: f64,
}

/// Calms curves.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CalmCurves {
    /// Cut-off.
    #[schemars(range(min = 0.1, max = 120.0))]
    pub cutoff_hz: f64,
    /// Order of the filter.
    #[schemars(range(min = 1, max = 8))]
    pub order: u32,
    /// Whether ends are padded.
    pub padded: bool,
    /// Schedule.
    pub schedule: Schedule,
    /// Schedule of the second pass.
    pub second: Option<Schedule>,
    /// Limits.
    pub limits: Option<Limits>,
    /// Weights of three axes.
    pub axes: [f64; 3],
    /// Strength by channel.
    pub strength: BTreeMap<String, f64>,
    /// Channels.
    pub channels: Vec<String>,
    /// A note.
    pub note: String,
    /// A frame rate where it is not that of the curves.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rate_hz: Option<f64>,
}

impl Default for CalmCurves {
    fn default() -> Self {
        Self {
            cutoff_hz: 6.0,
            order: 4,
            padded: true,
            schedule: Schedule::Constant,
            second: None,
            limits: None,
            axes: [1.0; 3],
            strength: BTreeMap::new(),
            channels: Vec::new(),
            note: String::new(),
            rate_hz: None,
        }
    }
}

#[typetag::serde(name = "calm_curves")]
impl Node for CalmCurves {
    fn card(&self) -> Card {
        Card::new("clean")
    }

    fn compute(&self, _: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        Ok(Outputs::default())
    }
}

/// Reads curves.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FetchCurves {
    /// The file.
    #[schemars(length(min = 1))]
    pub path: String,
    /// First frame.
    #[serde(default)]
    pub first: i64,
}

#[typetag::serde(name = "fetch_curves")]
impl Node for FetchCurves {
    fn card(&self) -> Card {
        Card::new("load").reads("path")
    }

    fn compute(&self, _: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        Ok(Outputs::default())
    }
}

/// Refuses what its schema allows.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fussy {
    /// Any name.
    pub name: String,
    /// An even number.
    #[serde(deserialize_with = "even")]
    pub even: i64,
}

fn even<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<i64, D::Error> {
    let number = i64::deserialize(deserializer)?;
    if number % 2 == 0 { Ok(number) } else { Err(serde::de::Error::custom(format!("{number} is odd"))) }
}

#[typetag::serde(name = "fussy")]
impl Node for Fussy {
    fn card(&self) -> Card {
        Card::new("clean")
    }

    fn compute(&self, _: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        Ok(Outputs::default())
    }
}

register!(CalmCurves);
register!(Fussy);
register!(FetchCurves);

/// A file `graph.ron` in the folder `show`.
pub fn source(text: &str) -> Arc<Source> {
    Arc::new(Source::new("show/graph.ron", text))
}

/// The graph in `text`, which has no mistakes.
pub fn graph(text: &str) -> Graph {
    let (graph, mistakes) = read(source(text));
    assert!(mistakes.is_empty(), "{}", rendered(mistakes));
    graph.expect("a graph without mistakes")
}

/// Diagnostics as they are printed, without colours.
pub fn rendered(mistakes: Vec<Diagnostic>) -> String {
    let text = render(&Diagnostics(mistakes), false, 100);
    text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

/// Diagnostics one a line: `code line:column message | label | help`.
pub fn told(mistakes: &[Diagnostic]) -> Vec<String> {
    let line = |mistake: &Diagnostic| {
        let (place, label) = match &mistake.place {
            Some((place, label)) => {
                let (line, column) = place.source.line_column(place.span.start);
                (format!("{line}:{column}"), label.as_str())
            }
            None => ("-".to_owned(), ""),
        };
        let facts = [&format!("{} {place} {}", mistake.code, mistake.message), label];
        let facts = facts.into_iter().chain(mistake.help.as_deref()).filter(|fact| !fact.is_empty());
        facts.collect::<Vec<_>>().join(" | ")
    };
    mistakes.iter().map(line).collect()
}

/// The node called `node` of the graph in `text`, with `--set` texts, or all mistakes on the way.
pub fn made(text: &str, node: &str, sets: &[&str]) -> Result<Box<dyn Node>, Vec<Diagnostic>> {
    let overrides = sets.iter().map(|text| Override::parse(text).map_err(|mistake| vec![mistake]));
    let overrides = overrides.collect::<Result<Vec<_>, _>>()?;
    let graph = graph(text);
    let (scope, mistakes) = apply_overrides(&graph, &overrides, &Arc::default());
    if mistakes.is_empty() { made_in(&graph, node, &scope, &overrides) } else { Err(mistakes) }
}

/// The node called `node` of `graph`.
pub fn made_in(
    graph: &Graph,
    node: &str,
    scope: &Scope,
    overrides: &[Override],
) -> Result<Box<dyn Node>, Vec<Diagnostic>> {
    let entry = &graph.nodes[node];
    let Body::Kind(kind) = &entry.body else { panic!("`{node}` is a nested graph") };
    let given = node_parameters(graph, entry, scope, None, overrides, node)?;
    build_node(&crate::node::Kinds::default(), kind, &given.parameters, &graph.source)
}
