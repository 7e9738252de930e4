//! A graph file as a board: cards with ports, and the wires between them.

use super::catalogue::Catalogue;
use super::texts::Texts;
use graph_core::document::{Body, Graph};
use graph_core::plan::tidy;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A port of a card.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortBox {
    /// Its name.
    pub name: String,
    /// The type of its values; empty where that cannot be known.
    pub type_name: String,
    /// Whether it carries a list.
    pub list: bool,
    /// Whether it may be left open.
    pub optional: bool,
    /// Whether a wire ends here.
    pub wired: bool,
}

/// What a card stands for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Role {
    /// A node of a kind.
    Kind(String),
    /// A nested graph: what the file calls it, and the file where it can be told.
    Nested(String, Option<PathBuf>),
    /// What a nested graph takes.
    Inputs,
    /// What a nested graph gives.
    Outputs,
}

/// A node as it stands on the board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CardBox {
    /// Its name in the file.
    pub name: String,
    /// What it is.
    pub role: Role,
    /// The list it is cooked for.
    pub for_each: Option<String>,
    /// Its inputs.
    pub inputs: Vec<PortBox>,
    /// Its outputs.
    pub outputs: Vec<PortBox>,
}

/// A wire from an output to an input; cards and ports by their position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wire {
    /// The card and output it comes from.
    pub from: (usize, usize),
    /// The card and input it goes to.
    pub to: (usize, usize),
}

/// A file's cards and wires.
#[derive(Debug, Clone, Default)]
pub struct Board {
    /// The cards; nodes come in the order of their names.
    pub cards: Vec<CardBox>,
    /// Positions of cards by name; those of inputs and outputs are not among them.
    pub index: HashMap<String, usize>,
    /// The wires.
    pub wires: Vec<Wire>,
}

/// Names that the cards of a nested graph's own ports have; no node can be called so.
pub const INPUTS: &str = "[inputs]";
/// See [`INPUTS`].
pub const OUTPUTS: &str = "[outputs]";

impl Board {
    /// The board of the file at `path`.
    pub fn of(path: &Path, texts: &Texts, catalogue: &Catalogue) -> Self {
        let Some(graph) = texts.get(path).and_then(|text| text.graph.clone()) else { return Self::default() };
        let mut board = Self::default();
        for (name, entry) in &graph.nodes {
            let (role, inputs, outputs) = match &entry.body {
                Body::Kind(kind) => {
                    let (inputs, outputs) = kind_ports(&kind.value, catalogue);
                    (Role::Kind(kind.value.clone()), inputs, outputs)
                }
                Body::Graph(file) => {
                    let nested = nested_file(path, &file.value);
                    let ports = nested.as_ref().and_then(|nested| graph_ports(nested, texts, catalogue));
                    let (inputs, outputs) = ports.unwrap_or_default();
                    (Role::Nested(file.value.clone(), nested), inputs, outputs)
                }
            };
            let for_each = entry.for_each.as_ref().map(|list| list.value.clone());
            board.index.insert(name.clone(), board.cards.len());
            board.cards.push(CardBox { name: name.clone(), role, for_each, inputs, outputs });
        }
        board.own_ports(&graph, path, texts, catalogue);
        board.wire(&graph);
        board
    }

    fn own_ports(&mut self, graph: &Graph, path: &Path, texts: &Texts, catalogue: &Catalogue) {
        if graph.inputs.is_empty() && graph.outputs.is_empty() {
            return;
        }
        let (inputs, outputs) = graph_ports(path, texts, catalogue).unwrap_or_default();
        let card = |name: &str, role, inputs, outputs| CardBox {
            name: name.to_owned(),
            role,
            for_each: None,
            inputs,
            outputs,
        };
        self.cards.push(card(INPUTS, Role::Inputs, Vec::new(), inputs));
        self.cards.push(card(OUTPUTS, Role::Outputs, outputs, Vec::new()));
    }

    fn wire(&mut self, graph: &Graph) {
        let (inputs, outputs) = (self.cards.len().wrapping_sub(2), self.cards.len().wrapping_sub(1));
        for (name, entry) in &graph.nodes {
            let Some(&to) = self.index.get(name) else { continue };
            // The list that a nested graph is cooked for comes in at the one input that is left open.
            if let (Some(list), Body::Graph(_)) = (&entry.for_each, &entry.body) {
                let open = |port: &PortBox| !port.optional && !entry.inputs.contains_key(&port.name);
                if let Some(at) = self.cards[to].inputs.iter().position(open) {
                    self.join(graph, inputs, &list.value, (to, at));
                }
            }
            for (port, input) in &entry.inputs {
                let at = position(&mut self.cards[to].inputs, port);
                for source in &input.sources {
                    self.join(graph, inputs, &source.value, (to, at));
                }
            }
        }
        for (port, source) in &graph.outputs {
            let at = position(&mut self.cards[outputs].inputs, port);
            self.join(graph, inputs, &source.value, (outputs, at));
        }
    }

    fn join(&mut self, graph: &Graph, inputs: usize, source: &str, to: (usize, usize)) {
        let (name, port) = match source.rsplit_once('.') {
            _ if self.index.contains_key(source) || graph.inputs.contains_key(source) => (source, None),
            Some((name, port)) => (name, Some(port)),
            None => (source, None),
        };
        let from = match self.index.get(name) {
            Some(&card) => {
                let outputs = &mut self.cards[card].outputs;
                let at = match port {
                    Some(port) => position(outputs, port),
                    None if outputs.is_empty() => position(outputs, ""),
                    None => 0,
                };
                (card, at)
            }
            None if graph.inputs.contains_key(name) => (inputs, position(&mut self.cards[inputs].outputs, name)),
            None => return,
        };
        self.cards[from.0].outputs[from.1].wired = true;
        self.cards[to.0].inputs[to.1].wired = true;
        self.wires.push(Wire { from, to });
    }

    /// The card called `name`, those of the graph's own ports included.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied().or_else(|| self.cards.iter().position(|card| card.name == name))
    }

    /// Cards that `card` takes from, by its inputs.
    pub fn before(&self, card: usize) -> impl Iterator<Item = &Wire> {
        self.wires.iter().filter(move |wire| wire.to.0 == card)
    }

    /// Cards that take from `card`.
    pub fn after(&self, card: usize) -> impl Iterator<Item = &Wire> {
        self.wires.iter().filter(move |wire| wire.from.0 == card)
    }

    /// Whether `card` needs `other`, over any number of wires.
    pub fn needs(&self, card: usize, other: usize) -> bool {
        let mut takes: HashMap<usize, Vec<usize>> = HashMap::new();
        for wire in &self.wires {
            takes.entry(wire.to.0).or_default().push(wire.from.0);
        }
        let (mut open, mut seen) = (vec![card], vec![false; self.cards.len()]);
        while let Some(next) = open.pop() {
            if next == other {
                return true;
            }
            if !std::mem::replace(&mut seen[next], true) {
                open.extend(takes.get(&next).into_iter().flatten());
            }
        }
        false
    }
}

/// Where `name` is among `ports`; a port that the kind does not have is shown all the same.
fn position(ports: &mut Vec<PortBox>, name: &str) -> usize {
    ports.iter().position(|port| port.name == name).unwrap_or_else(|| {
        let (name, type_name) = (name.to_owned(), String::new());
        ports.push(PortBox { name, type_name, list: false, optional: false, wired: false });
        ports.len() - 1
    })
}

fn kind_ports(kind: &str, catalogue: &Catalogue) -> (Vec<PortBox>, Vec<PortBox>) {
    let Some(facts) = catalogue.get(kind) else { return Default::default() };
    let port = |port: &graph_core::node::PortFacts| PortBox {
        name: port.name.to_owned(),
        type_name: port.kind.name.to_owned(),
        list: port.list,
        optional: port.optional,
        wired: false,
    };
    (facts.inputs.iter().map(port).collect(), facts.outputs.iter().map(port).collect())
}

/// The file that a nested graph's text means; `None` where parameters make up its name.
pub fn nested_file(from: &Path, text: &str) -> Option<PathBuf> {
    (!text.contains("${") && !text.starts_with('~')).then(|| tidy(&from.parent().unwrap_or(Path::new("")).join(text)))
}

/// What the graph at `path` takes and gives.
fn graph_ports(path: &Path, texts: &Texts, catalogue: &Catalogue) -> Option<(Vec<PortBox>, Vec<PortBox>)> {
    let graph = texts.get(path)?.graph.clone()?;
    let inputs = graph.inputs.iter().map(|(name, input)| PortBox {
        name: name.clone(),
        type_name: input.type_name.clone(),
        list: input.list,
        optional: input.optional,
        wired: false,
    });
    let outputs = graph.outputs.iter().map(|(name, source)| {
        let (type_name, list) = source_type(path, &graph, &source.value, texts, catalogue, 0).unwrap_or_default();
        PortBox { name: name.clone(), type_name, list, optional: false, wired: false }
    });
    Some((inputs.collect(), outputs.collect()))
}

/// The type of what `source` names in `graph`, followed through nested graphs.
fn source_type(
    path: &Path,
    graph: &Graph,
    source: &str,
    texts: &Texts,
    catalogue: &Catalogue,
    depth: usize,
) -> Option<(String, bool)> {
    if let Some(input) = graph.inputs.get(source) {
        return Some((input.type_name.clone(), input.list));
    }
    let (name, port) = source.rsplit_once('.').map_or((source, None), |(name, port)| (name, Some(port)));
    match &graph.nodes.get(name)?.body {
        Body::Kind(kind) => {
            let facts = catalogue.get(&kind.value)?;
            let output = facts.outputs.iter().find(|output| port.is_none_or(|port| port == output.name))?;
            Some((output.kind.name.to_owned(), output.list))
        }
        Body::Graph(_) if depth > 16 => None,
        Body::Graph(file) => {
            let nested = nested_file(path, &file.value)?;
            let inner = texts.get(&nested)?.graph.clone()?;
            let (_, source) = inner.outputs.iter().find(|(name, _)| port.is_none_or(|port| port == *name))?;
            source_type(&nested, &inner, &source.value, texts, catalogue, depth + 1)
        }
    }
}
