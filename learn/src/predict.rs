//! The forward pass of a trained network over many rows, on the packed layers of `kernel`.

use crate::architecture::{Activation, Architecture, Role};
use crate::kernel::{Lane, Packed, ROWS};
use crate::matrix::Matrix;
use crate::network::{Parameter, Scalings};
use crate::scaling::Scaling;
use pulp::Arch;
use std::ops::Range;

/// Tiles that pass through the network together, so that their values stay in the core's own cache while the weights stream
/// past.
const TILES: usize = 16;

/// A network's layers, packed for evaluation.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    arch: Arch,
    activation: Activation,
    outputs: usize,
    layers: Vec<(Role, usize, Packed)>,
}

impl Prepared {
    /// Packs parameters that are known to be those of the architecture.
    pub fn new(architecture: &Architecture, parameters: &[Parameter]) -> Self {
        let layers = architecture.layers().into_iter().zip(parameters.chunks_exact(2));
        let pack = |(layer, own): (crate::architecture::Layer, &[Parameter])| {
            (layer.role, layer.outputs, Packed::new(layer.inputs, layer.outputs, &own[0].values, &own[1].values))
        };
        Self {
            arch: Arch::new(),
            activation: architecture.activation,
            outputs: architecture.outputs,
            layers: layers.map(pack).collect(),
        }
    }

    /// The outputs for each row, in the targets' units. The tables are known to fit.
    pub fn predict(&self, scalings: &Scalings, inputs: &Matrix, conditions: Option<&Matrix>) -> Matrix {
        let mut values = Vec::with_capacity(inputs.rows() * self.outputs);
        for first in (0..inputs.rows()).step_by(TILES * ROWS) {
            let rows = first..(first + TILES * ROWS).min(inputs.rows());
            let conditions = conditions.map(|matrix| tiles(&scalings.conditions, matrix, rows.clone()));
            let out = self.forward(tiles(&scalings.inputs, inputs, rows.clone()), conditions.as_deref());
            for row in 0..rows.len() {
                let tile = &out[row / ROWS * self.outputs..][..self.outputs];
                let restored = tile.iter().enumerate();
                values.extend(restored.map(|(column, lane)| scalings.targets.restore(column, lane[row % ROWS])));
            }
        }
        Matrix::of_known_size(inputs.rows(), self.outputs, values)
    }

    /// Standardised tiles through all layers.
    fn forward(&self, inputs: Vec<Lane>, conditions: Option<&[Lane]>) -> Vec<Lane> {
        let negative = self.activation.negative_slope();
        let mut hidden = inputs;
        let mut skip = Vec::new();
        for (role, outputs, layer) in &self.layers {
            if let (Role::Head, Some(conditions)) = (role, conditions) {
                hidden = join(&hidden, conditions, layer.inputs());
            }
            let tiles = hidden.len() / layer.inputs();
            let mut out = vec![[0.0; ROWS]; tiles * outputs];
            layer.apply(self.arch, &hidden, &mut out);
            if *role == Role::CloseBlock {
                for (lane, skip) in out.as_flattened_mut().iter_mut().zip(skip.as_flattened()) {
                    *lane += skip;
                }
            }
            if *role != Role::Output {
                for value in out.as_flattened_mut() {
                    *value = if *value > 0.0 { *value } else { *value * negative };
                }
            }
            let entered = std::mem::replace(&mut hidden, out);
            if *role == Role::OpenBlock {
                skip = entered;
            }
        }
        hidden
    }
}

/// Rows of a matrix, standardised and laid out as tiles: tile after tile one [`Lane`] a column; missing rows are zeros.
fn tiles(scaling: &Scaling, matrix: &Matrix, rows: Range<usize>) -> Vec<Lane> {
    let columns = matrix.columns();
    let mut lanes = vec![[0.0; ROWS]; rows.len().div_ceil(ROWS) * columns];
    for (place, row) in rows.enumerate() {
        let tile = &mut lanes[place / ROWS * columns..][..columns];
        for (lane, value) in tile.iter_mut().zip(scaling.standardise(matrix.row(row))) {
            lane[place % ROWS] = value;
        }
    }
    lanes
}

/// The conditions of each tile behind its hidden values, `joined` lanes a tile.
fn join(hidden: &[Lane], conditions: &[Lane], joined: usize) -> Vec<Lane> {
    let tiles = (hidden.len() + conditions.len()) / joined;
    let (width, added) = (hidden.len() / tiles, conditions.len() / tiles);
    let pairs = hidden.chunks_exact(width).zip(conditions.chunks_exact(added));
    pairs.flat_map(|(hidden, conditions)| hidden.iter().chain(conditions)).copied().collect()
}
