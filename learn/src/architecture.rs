//! The shape of a network: how wide, how deep, where the conditions enter. `model` builds it, `network` evaluates it.

use crate::error::TrainError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A fully-connected residual network as in section 8 and Fig. 4 of the FDLS supplement.
///
/// With a the activation, D the dropout (in training only), x the standardised inputs, c the standardised conditions:
///
/// ```text
/// h0      = a(W x + b)                                  input layer, `width` nodes
/// h(i+1)  = a(h(i) + W2 D(a(W1 h(i) + b1)) + b2)        `blocks` residual blocks
/// g       = a(W [h; c] + b)                             first hidden layer after the blocks, `width` nodes
/// y       = W g + b                                     `outputs`
/// ```
///
/// The conditions join the last block's output and pass one non-linear layer together with it, so that their effect is not
/// merely added to the outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Architecture {
    /// Columns of the inputs; at least 1.
    #[schemars(range(min = 1))]
    pub inputs: usize,
    /// Columns of the targets; at least 1.
    #[schemars(range(min = 1))]
    pub outputs: usize,
    /// Nodes of every hidden layer; at least 1.
    #[schemars(range(min = 1))]
    pub width: usize,
    /// Residual blocks of two layers each; may be 0.
    pub blocks: usize,
    /// Conditioning values that join the hidden layer after the blocks; 0 = none.
    pub conditions: usize,
    /// Chance of a hidden node inside a block to be silenced for one sample in training; 0 or more, below 1.
    #[schemars(range(min = 0.0, max = 0.99))]
    pub dropout: f32,
    /// The non-linear function of the hidden layers.
    pub activation: Activation,
}

/// The non-linear function of a hidden node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// max(x, 0).
    #[default]
    Relu,
    /// x where x > 0, else 0.01 x: no node can die.
    LeakyRelu,
}

impl Activation {
    /// The slope for values of 0 and below.
    pub(crate) fn negative_slope(self) -> f32 {
        match self {
            Self::Relu => 0.0,
            Self::LeakyRelu => 0.01,
        }
    }
}

/// Trained numbers of the largest network that may be built: 4 GiB, and 16 while it is trained.
const MOST_PARAMETERS: usize = 1 << 30;

/// One fully-connected layer: its place in the network and its size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layer {
    pub name: String,
    pub role: Role,
    pub inputs: usize,
    pub outputs: usize,
}

/// What a layer does with the numbers that come out of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Activation.
    Input,
    /// Activation, then dropout; the layer's input is kept for the layer that closes the block.
    OpenBlock,
    /// Adds what entered the block, then activation.
    CloseBlock,
    /// Takes the conditions beside its input; activation.
    Head,
    /// Nothing.
    Output,
}

impl Architecture {
    /// An unconditioned network without dropout.
    pub fn new(inputs: usize, outputs: usize, width: usize, blocks: usize) -> Self {
        Self { inputs, outputs, width, blocks, conditions: 0, dropout: 0.0, activation: Activation::Relu }
    }

    /// The layers in forward order. Each has a weight of `inputs` x `outputs` and a bias of `outputs`.
    pub(crate) fn layers(&self) -> Vec<Layer> {
        let layer = |name: String, role, inputs, outputs| Layer { name, role, inputs, outputs };
        let mut layers = vec![layer("input".into(), Role::Input, self.inputs, self.width)];
        for block in 0..self.blocks {
            layers.push(layer(format!("block{block}.open"), Role::OpenBlock, self.width, self.width));
            layers.push(layer(format!("block{block}.close"), Role::CloseBlock, self.width, self.width));
        }
        layers.push(layer("head".into(), Role::Head, self.width + self.conditions, self.width));
        layers.push(layer("output".into(), Role::Output, self.width, self.outputs));
        layers
    }

    /// How many trained numbers a network of this architecture has.
    pub fn parameter_count(&self) -> usize {
        self.layers().iter().map(|layer| (layer.inputs + 1) * layer.outputs).sum()
    }

    /// Tells whether every field holds what it may.
    ///
    /// # Errors
    /// [`TrainError::Setting`] with the first field that does not.
    pub fn check(&self) -> Result<(), TrainError> {
        let counts = [
            ("architecture.inputs", self.inputs, 1),
            ("architecture.outputs", self.outputs, 1),
            ("architecture.width", self.width, 1),
            ("architecture.blocks", self.blocks, 0),
            ("architecture.conditions", self.conditions, 0),
        ];
        for (setting, value, least) in counts {
            if value < least {
                return Err(TrainError::Setting { setting, value: value as f64, allowed: "1 or more" });
            }
            if value > 1 << 20 {
                return Err(TrainError::Setting { setting, value: value as f64, allowed: "1,048,576 or less" });
            }
        }
        let hidden = self.blocks.saturating_mul(2).saturating_add(1).saturating_mul((self.width + 1) * self.width);
        let edges = (self.inputs + 1) * self.width + self.conditions * self.width + (self.width + 1) * self.outputs;
        let count = hidden.saturating_add(edges);
        if count > MOST_PARAMETERS {
            let (setting, value) = ("the number of parameters that the architecture makes", count as f64);
            return Err(TrainError::Setting { setting, value, allowed: "1,073,741,824 or less; lower the width" });
        }
        if !(0.0..1.0).contains(&self.dropout) {
            let value = f64::from(self.dropout);
            return Err(TrainError::Setting {
                setting: "architecture.dropout",
                value,
                allowed: "0 or more and below 1",
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_chain_and_count() {
        let architecture = Architecture { conditions: 4, ..Architecture::new(1161, 14, 800, 3) };
        let layers = architecture.layers();
        assert_eq!(layers.len(), 1 + 6 + 2);
        assert_eq!(layers[7].inputs, 804);
        let expected = 1162 * 800 + 6 * 801 * 800 + 805 * 800 + 801 * 14;
        assert_eq!(architecture.parameter_count(), expected);
    }

    #[test]
    fn impossible_shapes_are_named() {
        let none = Architecture::new(3, 0, 8, 1).check().unwrap_err();
        assert!(none.to_string().contains("architecture.outputs is 0"), "{none}");
        let all = Architecture { dropout: 1.0, ..Architecture::new(3, 1, 8, 1) }.check().unwrap_err();
        assert!(all.to_string().contains("dropout"), "{all}");
        let vast = Architecture::new(1 << 20, 1 << 20, 1 << 20, 1 << 20).check().unwrap_err();
        assert!(vast.to_string().contains("number of parameters"), "{vast}");
        assert!(Architecture { dropout: f32::NAN, ..Architecture::new(3, 1, 8, 1) }.check().is_err());
    }
}
