//! Trying a plugin out: each node on made-up values, twice, in blocks and whole, and with inputs that nobody expects.

mod samples;

use crate::component::Plugin;
use crate::fault::RunError;
use crate::schema::{NodeSchema, Setting, TimeUse};
use graph_core::node::{Inputs, Outputs, PortValue};
use samples::Case;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;
use wire::Value;

/// What was found of one node.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The node.
    pub node: String,
    /// Every check: what it is about, and what came of it.
    pub checks: Vec<Check>,
    /// Seconds that the first run took, its store included.
    pub seconds: f64,
    /// The most memory that a run had, in bytes.
    pub memory_bytes: usize,
}

/// One check.
#[derive(Debug, Clone)]
pub struct Check {
    /// What it is about.
    pub what: &'static str,
    /// What was found.
    pub found: Result<String, String>,
}

/// Frames in a block.
const BLOCK: usize = 32;

/// Tries every node of `plugin`.
pub fn trial(plugin: &Plugin) -> Vec<Trial> {
    plugin.nodes.iter().map(|node| Bench { plugin, node, memory_bytes: 0, seconds: 0.0 }.all()).collect()
}

struct Bench<'a> {
    plugin: &'a Plugin,
    node: &'a NodeSchema,
    memory_bytes: usize,
    seconds: f64,
}

/// What stands on the outputs, encoded.
type Encoded = BTreeMap<String, Vec<u8>>;

impl Bench<'_> {
    fn all(mut self) -> Trial {
        let mut checks = Vec::new();
        match samples::inputs(self.node, Case::Usual) {
            Err(problem) => checks.push(Check { what: "made-up values", found: Err(problem) }),
            Ok(inputs) => {
                let start = Instant::now();
                let first = self.run(&inputs);
                self.seconds = start.elapsed().as_secs_f64();
                let told = |error: &RunError| {
                    if is_told(error) { Ok(format!("it refuses them: {error}")) } else { Err(error.to_string()) }
                };
                let found = first.as_ref().map_or_else(told, |outputs| Ok(summary(outputs)));
                checks.push(Check { what: "made-up values", found });
                checks.push(Check { what: "the same twice", found: self.twice(&inputs, &first) });
                if let (Some(halo), Ok(whole)) = (self.halo(), &first) {
                    checks.push(Check { what: "blocks and whole", found: self.blocks(&inputs, halo, whole) });
                }
            }
        }
        for case in Case::HOSTILE {
            if let Ok(inputs) = samples::inputs(self.node, case) {
                let found = match self.run(&inputs) {
                    Ok(outputs) => Ok(summary(&outputs)),
                    Err(error) if is_told(&error) => Ok(format!("it refuses: {error}")),
                    Err(error) => Err(error.to_string()),
                };
                checks.push(Check { what: case.name(), found });
            }
        }
        Trial { node: self.node.name.clone(), checks, seconds: self.seconds, memory_bytes: self.memory_bytes }
    }

    fn settings(&self) -> BTreeMap<String, Setting> {
        self.node.parameters.iter().map(|parameter| (parameter.name.clone(), parameter.default.clone())).collect()
    }

    fn halo(&self) -> Option<usize> {
        match &self.node.time {
            TimeUse::Whole => None,
            TimeUse::PerFrame(halo) => Some(*halo as usize),
            TimeUse::PerFrameBy(name) => match self.settings().get(name) {
                Some(Setting::Integer(halo)) => usize::try_from(*halo).ok(),
                _ => None,
            },
        }
    }

    fn run(&mut self, inputs: &Inputs) -> Result<BTreeMap<String, PortValue>, RunError> {
        let (outputs, notes) = self.plugin.evaluate(self.node, &self.settings(), None, inputs);
        self.memory_bytes = self.memory_bytes.max(notes.memory_bytes);
        let mut outputs: Outputs = outputs?;
        let ports = self.node.outputs.iter();
        Ok(ports.filter_map(|port| Some((port.name.clone(), outputs.take(&port.name)?))).collect())
    }

    fn twice(
        &mut self,
        inputs: &Inputs,
        first: &Result<BTreeMap<String, PortValue>, RunError>,
    ) -> Result<String, String> {
        match (first, self.run(inputs)) {
            (Ok(first), Ok(second)) if encoded(first) == encoded(&second) => Ok("equal to the last bit".to_owned()),
            (Err(first), Err(second)) if *first == second => Ok("the same refusal".to_owned()),
            _ => Err("a second run gave something else: results must follow from the inputs alone".to_owned()),
        }
    }

    fn blocks(&mut self, inputs: &Inputs, halo: usize, whole: &BTreeMap<String, PortValue>) -> Result<String, String> {
        let frames = samples::FRAMES;
        let mut parts: BTreeMap<String, Vec<Arc<dyn Value>>> = BTreeMap::new();
        let mut blocks = 0;
        for start in (0..frames).step_by(BLOCK) {
            let own = start..(start + BLOCK).min(frames);
            let seen = own.start.saturating_sub(halo)..(own.end + halo).min(frames);
            let outputs =
                self.run(&self.slice(inputs, &seen)).map_err(|error| format!("frames {seen:?} alone: {error}"))?;
            for (port, value) in outputs {
                let PortValue::One(value) = value else { continue };
                if value.axis().map(|axis| axis.count) != Some(seen.len()) {
                    return Err(format!(
                        "output `{port}` does not have the frames that came in, as per-frame outputs must"
                    ));
                }
                let part = value.slice(own.start - seen.start..own.end - seen.start);
                parts.entry(port).or_default().extend(part);
            }
            blocks += 1;
        }
        let joined = parts.into_iter().map(|(port, parts)| {
            let joined = parts.first().map(|first| (first.kind().join)(&parts));
            match joined {
                Some(Ok(value)) => Ok((port, PortValue::One(value))),
                Some(Err(problem)) => Err(problem.to_string()),
                None => Err(format!("nothing on `{port}`")),
            }
        });
        let joined = joined.collect::<Result<BTreeMap<_, _>, String>>()?;
        if encoded(&joined) == encoded(whole) {
            return Ok(format!("{blocks} blocks with {halo} frames on either side are equal to the whole"));
        }
        Err(format!(
            "blocks differ from the whole: it looks at more than the {halo} frames on either side that its schema says"
        ))
    }

    fn slice(&self, inputs: &Inputs, frames: &Range<usize>) -> Inputs {
        let mut sliced = Inputs::default();
        for (name, value) in inputs.ports() {
            let still = self.node.inputs.iter().any(|port| port.name == name && port.still);
            let cut = |value: &Arc<dyn Value>| value.slice(frames.clone()).unwrap_or_else(|| Arc::clone(value));
            let value = match value {
                _ if still => value.clone(),
                PortValue::One(value) => PortValue::One(cut(value)),
                PortValue::List(items) => {
                    PortValue::List(items.iter().map(|(name, value)| (name.clone(), cut(value))).collect())
                }
            };
            sliced.set(name.to_owned(), value);
        }
        sliced
    }
}

/// Whether the plugin itself told what is wrong.
fn is_told(error: &RunError) -> bool {
    matches!(error, RunError::Input { .. } | RunError::Parameter { .. } | RunError::Failed { .. })
}

fn encoded(outputs: &BTreeMap<String, PortValue>) -> Encoded {
    let mut all = Encoded::new();
    for (port, value) in outputs {
        match value {
            PortValue::One(value) => drop(all.insert(port.clone(), value.encoded())),
            PortValue::List(items) => {
                all.extend(items.iter().map(|(name, value)| (format!("{port}@{name}"), value.encoded())));
            }
        }
    }
    all
}

fn summary(outputs: &BTreeMap<String, PortValue>) -> String {
    let one = |(port, value): (&String, &PortValue)| match value {
        PortValue::One(value) => format!("{port}: {}", value.summary()),
        PortValue::List(items) => format!("{port}: {} items", items.len()),
    };
    outputs.iter().map(one).collect::<Vec<_>>().join("; ")
}
