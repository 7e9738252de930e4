//! The settings of one region's network: those of the FDLS supplement, those of the graph, and which goes before which.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings of one region. What is left out stays what it is otherwise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct RegionSettings {
    /// Nodes of every hidden layer.
    #[schemars(range(min = 1, max = 100_000))]
    pub width: Option<usize>,
    /// Residual blocks.
    #[schemars(range(max = 1000))]
    pub blocks: Option<usize>,
    /// Whether the jaw's weights join the network.
    pub jaw_conditioned: Option<bool>,
    /// Chance of a hidden node to be silenced in training.
    #[schemars(range(min = 0.0, max = 0.99))]
    pub dropout: Option<f32>,
    /// Step size of Adam at its peak.
    #[schemars(range(min = 1e-12, max = 10.0))]
    pub learning_rate: Option<f64>,
    /// L2 coefficient of weights and biases.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub weight_decay: Option<f64>,
    /// Samples a step.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub batch: Option<usize>,
    /// How often every sample is seen.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub epochs: Option<usize>,
}

impl RegionSettings {
    /// These settings, and `others` where these say nothing.
    pub fn before(&self, others: &Self) -> Self {
        Self {
            width: self.width.or(others.width),
            blocks: self.blocks.or(others.blocks),
            jaw_conditioned: self.jaw_conditioned.or(others.jaw_conditioned),
            dropout: self.dropout.or(others.dropout),
            learning_rate: self.learning_rate.or(others.learning_rate),
            weight_decay: self.weight_decay.or(others.weight_decay),
            batch: self.batch.or(others.batch),
            epochs: self.epochs.or(others.epochs),
        }
    }
}

/// All settings of one region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settled {
    pub width: usize,
    pub blocks: usize,
    pub jaw_conditioned: bool,
    pub dropout: f32,
    pub learning_rate: f64,
    pub weight_decay: f64,
    pub batch: usize,
    pub epochs: usize,
}

/// The two tables of section 8 of the FDLS supplement: width, residual blocks, jaw conditioning, learning rate, dropout,
/// epochs. Batch and L2 coefficient are the same for all.
const PAPER: [(&str, usize, usize, bool, f64, f32, usize); 8] = [
    ("lower-face", 800, 3, true, 1e-4, 0.01, 450),
    ("upper-face", 300, 3, false, 5e-4, 0.01, 300),
    ("cheek", 500, 2, true, 1e-4, 0.01, 300),
    ("eyelids", 300, 2, false, 2e-4, 0.0, 300),
    ("eyeballs", 150, 2, false, 1e-4, 0.0, 250),
    ("eyeball", 150, 2, false, 1e-4, 0.0, 250),
    ("jaw", 800, 2, false, 1e-4, 0.01, 300),
    ("lips", 600, 3, true, 1e-4, 0.01, 450),
];

/// What regions that the paper does not know are like: its cheek, without the jaw.
const OTHER: (&str, usize, usize, bool, f64, f32, usize) = ("", 500, 2, false, 1e-4, 0.01, 300);

impl Settled {
    /// Whether the paper knows a region of this name.
    pub fn is_known(region: &str) -> bool {
        PAPER.iter().any(|row| row.0 == region)
    }

    /// The settings of `region`: `asked`, and where that says nothing the paper's.
    pub fn new(region: &str, asked: &RegionSettings) -> Self {
        let row = PAPER.iter().find(|row| row.0 == region).unwrap_or(&OTHER);
        let (_, width, blocks, jaw_conditioned, learning_rate, dropout, epochs) = *row;
        Self {
            width: asked.width.unwrap_or(width),
            blocks: asked.blocks.unwrap_or(blocks),
            jaw_conditioned: asked.jaw_conditioned.unwrap_or(jaw_conditioned),
            dropout: asked.dropout.unwrap_or(dropout),
            learning_rate: asked.learning_rate.unwrap_or(learning_rate),
            weight_decay: asked.weight_decay.unwrap_or(1e-5),
            batch: asked.batch.unwrap_or(64),
            epochs: asked.epochs.unwrap_or(epochs),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_is_overridden_by_what_is_asked_for() {
        let paper = Settled::new("lips", &RegionSettings::default());
        assert_eq!((paper.width, paper.blocks, paper.jaw_conditioned, paper.epochs), (600, 3, true, 450));
        let asked = RegionSettings { epochs: Some(24), ..RegionSettings::default() };
        let own = RegionSettings { epochs: Some(7), dropout: Some(0.5), ..RegionSettings::default() };
        let settled = Settled::new("lips", &own.before(&asked));
        assert_eq!((settled.epochs, settled.width), (7, 600));
        assert!((settled.dropout - 0.5).abs() < 1e-9);
        assert!(!Settled::is_known("neck") && Settled::is_known("eyeballs"));
        assert_eq!(Settled::new("neck", &asked).epochs, 24);
    }
}
