//! A fully-connected layer for predictions: fast on one core, and each row's result independent of the rows beside it.
//!
//! Weights are packed into panels of [`COLUMNS`] outputs and rows into tiles of [`ROWS`] samples, so that the innermost loop
//! reads both in the order they lie. Every sum starts from the bias and adds its products one by one in the order of the
//! inputs, each with one rounding (a fused multiply-add), whatever the vector width of the machine. A tile is always
//! computed whole, empty places as zeros. So a row has the same bits in any company.

use pulp::{Arch, Simd, WithSimd};

/// Samples of a tile.
pub(crate) const ROWS: usize = 6;
/// Outputs of a panel: two vectors of the widest kind.
pub(crate) const COLUMNS: usize = 32;

/// One value of each sample of a tile.
pub(crate) type Lane = [f32; ROWS];

/// A layer's weights, packed.
#[derive(Clone, Debug)]
pub(crate) struct Packed {
    inputs: usize,
    outputs: usize,
    /// Panel after panel; in a panel, for each input the weights to [`COLUMNS`] outputs.
    panels: Vec<[f32; COLUMNS]>,
    /// One entry a panel.
    bias: Vec<[f32; COLUMNS]>,
}

impl Packed {
    /// Packs weights of `inputs` x `outputs`, row-major, and a bias of `outputs`.
    pub fn new(inputs: usize, outputs: usize, weight: &[f32], bias: &[f32]) -> Self {
        let panel_count = outputs.div_ceil(COLUMNS);
        let mut panels = vec![[0.0; COLUMNS]; panel_count * inputs];
        let mut packed_bias = vec![[0.0; COLUMNS]; panel_count];
        for (panel, (rows, bias_out)) in panels.chunks_exact_mut(inputs).zip(&mut packed_bias).enumerate() {
            let first = panel * COLUMNS;
            let count = COLUMNS.min(outputs - first);
            for (row, weights) in rows.iter_mut().zip(weight.chunks_exact(outputs)) {
                row[..count].copy_from_slice(&weights[first..first + count]);
            }
            bias_out[..count].copy_from_slice(&bias[first..first + count]);
        }
        Self { inputs, outputs, panels, bias: packed_bias }
    }

    /// Values that a row has on entering the layer.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// y = x W + b for some tiles. `tiles` holds, tile after tile, one [`Lane`] an input; `out` gets, tile after tile,
    /// one an output.
    pub fn apply(&self, arch: Arch, tiles: &[Lane], out: &mut [Lane]) {
        arch.dispatch(Product { layer: self, tiles, out });
    }
}

/// The product, for pulp to compile once for each instruction set.
struct Product<'a> {
    layer: &'a Packed,
    tiles: &'a [Lane],
    out: &'a mut [Lane],
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[allow(
        clippy::inline_always,
        reason = "compiled into one function for each instruction set; a call would lose the set"
    )]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Packed { inputs, outputs, panels, bias } = self.layer;
        for (index, (panel, bias)) in panels.chunks_exact(*inputs).zip(bias).enumerate() {
            let first = index * COLUMNS;
            let count = COLUMNS.min(outputs - first);
            let tiles = self.tiles.chunks_exact(*inputs).zip(self.out.chunks_exact_mut(*outputs));
            for (tile, out) in tiles {
                let sums = sums(simd, tile, panel, bias);
                for (column, lane) in out[first..first + count].iter_mut().enumerate() {
                    *lane = std::array::from_fn(|row| sums[row][column]);
                }
            }
        }
    }
}

/// The sums of one tile and one panel, two vectors of outputs at a time so that they stay in registers.
#[allow(
    clippy::inline_always,
    reason = "compiled into one function for each instruction set; a call would lose the set"
)]
#[inline(always)]
pub(crate) fn sums<S: Simd>(
    simd: S,
    tile: &[Lane],
    panel: &[[f32; COLUMNS]],
    bias: &[f32; COLUMNS],
) -> [[f32; COLUMNS]; ROWS] {
    let mut sums = [[0.0; COLUMNS]; ROWS];
    for first in (0..COLUMNS).step_by(2 * S::F32_LANES) {
        let mut vectors = [pair::<S>(bias, first); ROWS];
        for (lane, weights) in tile.iter().zip(panel) {
            let weights = pair::<S>(weights, first);
            for (vector, value) in vectors.iter_mut().zip(lane) {
                let value = simd.splat_f32s(*value);
                vector[0] = simd.mul_add_f32s(value, weights[0], vector[0]);
                vector[1] = simd.mul_add_f32s(value, weights[1], vector[1]);
            }
        }
        for (sums, vector) in sums.iter_mut().zip(vectors) {
            let (places, _) = S::as_mut_simd_f32s(&mut sums[first..first + 2 * S::F32_LANES]);
            places.copy_from_slice(&vector);
        }
    }
    sums
}

/// Two neighbouring vectors of a row of outputs.
#[allow(
    clippy::inline_always,
    reason = "compiled into one function for each instruction set; a call would lose the set"
)]
#[inline(always)]
pub(crate) fn pair<S: Simd>(row: &[f32; COLUMNS], first: usize) -> [S::f32s; 2] {
    let (vectors, _) = S::as_simd_f32s(&row[first..first + 2 * S::F32_LANES]);
    [vectors[0], vectors[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Stream, Use};

    #[test]
    fn the_product_is_the_sum_of_fused_products_in_order() {
        let (inputs, outputs, tiles) = (37, 45, 3);
        let mut stream = Stream::new(1, Use::Weights, 0);
        let mut values = |count: usize| -> Vec<f32> { (0..count).map(|_| stream.unit() - 0.5).collect() };
        let (weight, bias, rows) = (values(inputs * outputs), values(outputs), values(tiles * inputs * ROWS));
        let lanes: Vec<Lane> = rows.chunks_exact(ROWS).map(|lane| lane.try_into().unwrap()).collect();
        let mut out = vec![[0.0; ROWS]; tiles * outputs];
        Packed::new(inputs, outputs, &weight, &bias).apply(Arch::new(), &lanes, &mut out);
        for tile in 0..tiles {
            for row in 0..ROWS {
                for column in 0..outputs {
                    let mut sum = bias[column];
                    for input in 0..inputs {
                        sum = lanes[tile * inputs + input][row].mul_add(weight[input * outputs + column], sum);
                    }
                    let found = out[tile * outputs + column][row];
                    assert_eq!(found.to_bits(), sum.to_bits(), "tile {tile}, row {row}, column {column}");
                }
            }
        }
    }
}
