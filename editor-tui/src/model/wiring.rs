//! What may be wired to what, and why not.

use super::State;
use super::board::{PortBox, Role};
use super::catalogue::KindFacts;

/// A port that something is to be wired to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fit {
    /// The card.
    pub card: String,
    /// Whether the port is an input of it.
    pub input: bool,
    /// The port.
    pub port: PortBox,
}

/// A port at the other end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    /// The card.
    pub card: String,
    /// The port.
    pub port: PortBox,
    /// Why it cannot be wired; none where it can.
    pub against: Option<String>,
}

impl Fit {
    /// Whether a new node of a kind could be wired here.
    pub fn takes(&self, kind: &KindFacts) -> bool {
        let ports = if self.input { &kind.outputs } else { &kind.inputs };
        self.port.type_name.is_empty() || ports.iter().any(|port| port.kind.name == self.port.type_name)
    }
}

impl State {
    /// The port that wiring begins from: the selected one, else the first open input, else the first output.
    pub fn fit(&self) -> Option<Fit> {
        let card = self.card()?;
        let found = match self.level().port {
            Some(port) => {
                let ports = if port.input { &card.inputs } else { &card.outputs };
                ports.get(port.at).map(|found| (port.input, found))
            }
            None => None,
        };
        let open = || card.inputs.iter().find(|port| !port.wired && !port.optional).map(|port| (true, port));
        let first = || card.outputs.first().map(|port| (false, port));
        let any = || card.inputs.first().map(|port| (true, port));
        let (input, port) = found.or_else(open).or_else(first).or_else(any)?;
        Some(Fit { card: card.name.clone(), input, port: port.clone() })
    }

    /// Everything at the other end of a wire from `fit`: what can be wired first, nearest first.
    pub fn choices(&self, fit: &Fit) -> Vec<Choice> {
        let level = self.level();
        let Some(own) = level.board.find(&fit.card) else { return Vec::new() };
        let mut choices = Vec::new();
        for (at, card) in level.board.cards.iter().enumerate() {
            let ports = if fit.input { &card.outputs } else { &card.inputs };
            for port in ports {
                let against = self.against(own, fit, at, port);
                let far = level.layout.places.get(at).zip(level.layout.places.get(own));
                let far = far.map_or(0, |(one, other)| (one.x - other.x).abs() + (one.y - other.y).abs());
                choices.push((against.is_some(), far, Choice { card: card.name.clone(), port: port.clone(), against }));
            }
        }
        choices.sort_by(|a, b| (a.0, a.1, &a.2.card).cmp(&(b.0, b.1, &b.2.card)));
        choices.into_iter().map(|(_, _, choice)| choice).collect()
    }

    /// Why `fit` cannot be wired to `port` of the card at `other`.
    fn against(&self, own: usize, fit: &Fit, other: usize, port: &PortBox) -> Option<String> {
        let level = self.level();
        let (from, to) = if fit.input { (port, &fit.port) } else { (&fit.port, port) };
        let (giver, taker) = if fit.input { (other, own) } else { (own, other) };
        if giver == taker {
            return Some("a node cannot take from itself".to_owned());
        }
        if from.type_name != to.type_name && !from.type_name.is_empty() && !to.type_name.is_empty() {
            return Some(format!("gives {}, and `{}` takes {}", from.type_name, to.name, to.type_name));
        }
        if matches!(level.board.cards[taker].role, Role::Outputs) {
            return Some("what the graph gives is written in `outputs` of the file".to_owned());
        }
        if level.board.needs(giver, taker) {
            let (giver, taker) = (&level.board.cards[giver].name, &level.board.cards[taker].name);
            return Some(format!("`{giver}` needs `{taker}`: that would be a circle"));
        }
        None
    }

    /// How the file names an output: `node`, `node.port`, or the graph's own input.
    pub fn source_text(&self, card: &str, port: &str) -> String {
        let board = &self.level().board;
        match board.find(card).map(|at| &board.cards[at]) {
            Some(card) if card.role == Role::Inputs => port.to_owned(),
            Some(card) if card.outputs.len() > 1 => format!("{}.{port}", card.name),
            _ => card.to_owned(),
        }
    }
}
