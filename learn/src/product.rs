//! The matrix products of training and Adam's step, on weights that lie in panels; called by `tape` and `model`.
//!
//! With x (rows × inputs) what enters a layer, W (inputs × outputs) its weights and s (rows × outputs) the slopes of the loss
//! by what comes out:
//!
//! ```text
//! forward     y = x W
//! back        slopes by x = s Wᵀ
//! gradient    slopes by W = xᵀ s
//! ```
//!
//! Weights, their gradients and their moments lie in panels of [`COLUMNS`] outputs, as `kernel` has them for predictions:
//! panel after panel, in a panel for each input one row. All three products read them so, and nothing large is packed
//! anew in a step. Every sum adds its products one by one in rising order, each with one rounding, so that the bits do
//! not depend on the machine's vectors, nor on how many threads share a product: each sum is the work of one.

use crate::kernel::{COLUMNS, Lane, ROWS, pair, sums};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Fused products below which a thread is not worth waking: some tens of microseconds of one.
const WORTH_A_THREAD: usize = 1 << 22;
/// Numbers of a table below which Adam's step is made by one thread.
const ADAM_PART: usize = 1 << 16;

/// How many of `units` one thread takes, where all of them make `products`.
fn share(units: usize, products: usize) -> usize {
    let threads = rayon::current_num_threads().min(products / WORTH_A_THREAD).max(1);
    units.div_ceil(threads).max(1)
}

/// A row-major table of `columns` cut between columns: for each part, its piece of every row.
fn cut(table: &mut [f32], columns: usize, part: usize) -> Vec<Vec<&mut [f32]>> {
    let rows = table.len() / columns;
    let mut parts: Vec<Vec<_>> = (0..columns.div_ceil(part)).map(|_| Vec::with_capacity(rows)).collect();
    for row in table.chunks_exact_mut(columns) {
        for (own, piece) in parts.iter_mut().zip(row.chunks_mut(part)) {
            own.push(piece);
        }
    }
    parts
}

/// A row of a panel.
pub(crate) type PanelRow = [f32; COLUMNS];

/// Panels of a row-major table of `columns`; places behind the last column hold 0.
pub(crate) fn into_panels(values: &[f32], columns: usize) -> Vec<PanelRow> {
    let rows = values.len() / columns;
    let mut panels = vec![[0.0; COLUMNS]; columns.div_ceil(COLUMNS) * rows];
    for (place, row) in values.chunks_exact(columns).enumerate() {
        for (panel, own) in row.chunks(COLUMNS).enumerate() {
            panels[panel * rows + place][..own.len()].copy_from_slice(own);
        }
    }
    panels
}

/// The row-major table of `rows` × `columns` that lies in panels.
pub(crate) fn from_panels(panels: &[PanelRow], rows: usize, columns: usize) -> Vec<f32> {
    let mut values = vec![0.0; rows * columns];
    for (place, row) in values.chunks_exact_mut(columns).enumerate() {
        for (panel, own) in row.chunks_mut(COLUMNS).enumerate() {
            let count = own.len();
            own.copy_from_slice(&panels[panel * rows + place][..count]);
        }
    }
    values
}

/// Tiles of [`ROWS`] rows: in a tile, for each column one value of each row; missing rows are 0.
fn into_tiles(values: &[f32], columns: usize) -> Vec<Lane> {
    let rows = values.len() / columns;
    let mut tiles = vec![[0.0; ROWS]; rows.div_ceil(ROWS) * columns];
    for (place, row) in values.chunks_exact(columns).enumerate() {
        for (lane, value) in tiles[place / ROWS * columns..][..columns].iter_mut().zip(row) {
            lane[place % ROWS] = *value;
        }
    }
    tiles
}

/// Groups of [`ROWS`] columns: in a group, one row after the other; missing columns are 0.
fn into_groups(values: &[f32], columns: usize) -> Vec<Lane> {
    let rows = values.len() / columns;
    let mut groups = vec![[0.0; ROWS]; columns.div_ceil(ROWS) * rows];
    for (place, row) in values.chunks_exact(columns).enumerate() {
        for (group, own) in row.chunks(ROWS).enumerate() {
            groups[group * rows + place][..own.len()].copy_from_slice(own);
        }
    }
    groups
}

/// Panels of [`COLUMNS`] rows of the turned table: in a panel, for each column one value of each row; missing rows are 0.
fn into_turned_panels(values: &[f32], columns: usize) -> Vec<PanelRow> {
    let rows = values.len() / columns;
    let mut panels = vec![[0.0; COLUMNS]; rows.div_ceil(COLUMNS) * columns];
    for (place, row) in values.chunks_exact(columns).enumerate() {
        for (own, value) in panels[place / COLUMNS * columns..][..columns].iter_mut().zip(row) {
            own[place % COLUMNS] = *value;
        }
    }
    panels
}

/// y = x W for row-major `x`.
pub(crate) fn forward(arch: Arch, x: &[f32], weights: &[PanelRow], (inputs, outputs): (usize, usize)) -> Vec<f32> {
    let tiles = into_tiles(x, inputs);
    let mut out = vec![0.0; x.len() / inputs * outputs];
    let panels = share(outputs.div_ceil(COLUMNS), x.len() * outputs);
    let parts = cut(&mut out, outputs, panels * COLUMNS);
    parts.into_par_iter().zip(weights.par_chunks(panels * inputs)).for_each(|(mut out, weights)| {
        arch.dispatch(Forward { tiles: &tiles, weights, inputs, out: &mut out });
    });
    out
}

/// Some panels, and the outputs of every row that are theirs.
struct Forward<'a, 'b> {
    tiles: &'a [Lane],
    weights: &'a [PanelRow],
    inputs: usize,
    out: &'a mut [&'b mut [f32]],
}

impl WithSimd for Forward<'_, '_> {
    type Output = ();

    #[allow(
        clippy::inline_always,
        reason = "compiled into one function for each instruction set; a call would lose the set"
    )]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (index, panel) in self.weights.chunks_exact(self.inputs).enumerate() {
            let first = index * COLUMNS;
            let tiles = self.tiles.chunks_exact(self.inputs).zip(self.out.chunks_mut(ROWS));
            for (tile, out) in tiles {
                let sums = sums(simd, tile, panel, &[0.0; COLUMNS]);
                for (row, sums) in out.iter_mut().zip(&sums) {
                    let count = COLUMNS.min(row.len() - first);
                    row[first..first + count].copy_from_slice(&sums[..count]);
                }
            }
        }
    }
}

/// s Wᵀ for row-major `slopes`; gives rows × inputs.
pub(crate) fn back(arch: Arch, slopes: &[f32], weights: &[PanelRow], (inputs, outputs): (usize, usize)) -> Vec<f32> {
    let turned = into_turned_panels(slopes, outputs);
    let mut out = vec![0.0; slopes.len() / outputs * inputs];
    let part = share(inputs.div_ceil(ROWS), slopes.len() * inputs) * ROWS;
    cut(&mut out, inputs, part).into_par_iter().enumerate().for_each(|(index, mut out)| {
        arch.dispatch(Back { turned: &turned, weights, inputs, outputs, first: index * part, out: &mut out });
    });
    out
}

/// Some inputs, from `first` on, of every row.
struct Back<'a, 'b> {
    turned: &'a [PanelRow],
    weights: &'a [PanelRow],
    inputs: usize,
    outputs: usize,
    first: usize,
    out: &'a mut [&'b mut [f32]],
}

impl WithSimd for Back<'_, '_> {
    type Output = ();

    #[allow(
        clippy::inline_always,
        reason = "compiled into one function for each instruction set; a call would lose the set"
    )]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let inputs = self.out.first().map_or(0, |row| row.len());
        for place in (0..inputs).step_by(ROWS) {
            let count = ROWS.min(inputs - place);
            let rows = self.turned.chunks_exact(self.outputs).zip(self.out.chunks_mut(COLUMNS));
            for (turned, out) in rows {
                let sums = sums_back(simd, (self.weights, self.inputs), self.first + place, turned);
                for (row, own) in out.iter_mut().enumerate() {
                    for (value, sums) in own[place..place + count].iter_mut().zip(&sums) {
                        *value = sums[row];
                    }
                }
            }
        }
    }
}

/// For [`ROWS`] inputs from `first` on, the sums over all outputs for one panel of rows.
#[allow(
    clippy::inline_always,
    reason = "compiled into one function for each instruction set; a call would lose the set"
)]
#[inline(always)]
fn sums_back<S: Simd>(
    simd: S,
    (weights, inputs): (&[PanelRow], usize),
    first: usize,
    turned: &[PanelRow],
) -> [PanelRow; ROWS] {
    let mut sums = [[0.0; COLUMNS]; ROWS];
    for part in (0..COLUMNS).step_by(2 * S::F32_LANES) {
        let mut vectors = [[simd.splat_f32s(0.0); 2]; ROWS];
        for (panel, slopes) in weights.chunks_exact(inputs).zip(turned.chunks(COLUMNS)) {
            // Behind the last input the last one stands again, for sums that nobody reads.
            let own: [&PanelRow; ROWS] = std::array::from_fn(|input| &panel[(first + input).min(inputs - 1)]);
            for (column, slopes) in (0..COLUMNS).zip(slopes) {
                let slopes = pair::<S>(slopes, part);
                for (vector, weights) in vectors.iter_mut().zip(&own) {
                    let weight = simd.splat_f32s(weights[column]);
                    vector[0] = simd.mul_add_f32s(weight, slopes[0], vector[0]);
                    vector[1] = simd.mul_add_f32s(weight, slopes[1], vector[1]);
                }
            }
        }
        for (sums, vector) in sums.iter_mut().zip(vectors) {
            let (places, _) = S::as_mut_simd_f32s(&mut sums[part..part + 2 * S::F32_LANES]);
            places.copy_from_slice(&vector);
        }
    }
    sums
}

/// xᵀ s for row-major `x` and `slopes`, put into `sum`, or added to it where `again` says so.
pub(crate) fn gradient(
    arch: Arch,
    x: &[f32],
    slopes: &[f32],
    (inputs, outputs): (usize, usize),
    again: bool,
    sum: &mut [PanelRow],
) {
    let (groups, panels) = (into_groups(x, inputs), into_panels(slopes, outputs));
    let rows = slopes.len() / outputs;
    let part = share(outputs.div_ceil(COLUMNS), x.len() * outputs);
    panels.par_chunks(part * rows).zip(sum.par_chunks_mut(part * inputs)).for_each(|(panels, sum)| {
        arch.dispatch(Gradient { groups: &groups, panels, rows, inputs, again, sum });
    });
}

struct Gradient<'a> {
    groups: &'a [Lane],
    panels: &'a [PanelRow],
    rows: usize,
    inputs: usize,
    again: bool,
    sum: &'a mut [PanelRow],
}

impl WithSimd for Gradient<'_> {
    type Output = ();

    #[allow(
        clippy::inline_always,
        reason = "compiled into one function for each instruction set; a call would lose the set"
    )]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (panel, sum) in self.panels.chunks_exact(self.rows).zip(self.sum.chunks_exact_mut(self.inputs)) {
            for (group, sum) in self.groups.chunks_exact(self.rows).zip(sum.chunks_mut(ROWS)) {
                let found = sums(simd, group, panel, &[0.0; COLUMNS]);
                for (sum, found) in sum.iter_mut().zip(&found) {
                    if self.again {
                        for (sum, found) in sum.iter_mut().zip(found) {
                            *sum += found;
                        }
                    } else {
                        *sum = *found;
                    }
                }
            }
        }
    }
}

/// One step of Adam (Kingma and Ba 2015, algorithm 1) on one table, with the decay in the gradient:
///
/// ```text
/// g = gradient + w p,   m = β₁ m + (1 − β₁) g,   v = β₂ v + (1 − β₂) g²
/// p = p − η (m / (1 − β₁ᵗ)) / (√(v / (1 − β₂ᵗ)) + ε)
/// ```
pub(crate) struct Adam<'a> {
    /// η.
    pub rate: f32,
    /// β₁ and β₂.
    pub betas: [f32; 2],
    /// 1 − β₁ and 1 − β₂.
    pub rests: [f32; 2],
    /// 1 / (1 − β₁ᵗ) and 1 / (1 − β₂ᵗ).
    pub corrections: [f32; 2],
    /// ε.
    pub epsilon: f32,
    /// w.
    pub decay: f32,
    /// p.
    pub values: &'a mut [f32],
    /// m and v.
    pub moments: [&'a mut [f32]; 2],
    /// The gradient.
    pub gradient: &'a [f32],
}

impl Adam<'_> {
    /// Makes the step.
    pub fn run(self, arch: Arch) {
        let Self { rate, betas, rests, corrections, epsilon, decay, values, moments: [first, second], gradient } = self;
        let part = values.len().div_ceil(rayon::current_num_threads()).max(ADAM_PART);
        let values = values.par_chunks_mut(part).zip(first.par_chunks_mut(part));
        values.zip(second.par_chunks_mut(part)).zip(gradient.par_chunks(part)).for_each(
            |(((values, first), second), gradient)| {
                let moments = [first, second];
                arch.dispatch(Adam { rate, betas, rests, corrections, epsilon, decay, values, moments, gradient });
            },
        );
    }
}

impl WithSimd for Adam<'_> {
    type Output = ();

    #[allow(
        clippy::inline_always,
        reason = "compiled into one function for each instruction set; a call would lose the set"
    )]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { rate, betas, rests, corrections, epsilon, decay, values, moments: [first, second], gradient } = self;
        for (((p, m), v), g) in values.iter_mut().zip(first).zip(second).zip(gradient) {
            let g = g + decay * *p;
            *m = *m * betas[0] + g * rests[0];
            *v = *v * betas[1] + g * g * rests[1];
            *p -= rate * (*m * corrections[0]) / ((*v * corrections[1]).sqrt() + epsilon);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Stream, Use};

    fn values(count: usize, seed: u64) -> Vec<f32> {
        let mut stream = Stream::new(seed, Use::Weights, 0);
        (0..count).map(|_| stream.unit() - 0.5).collect()
    }

    fn same(found: &[f32], expected: impl IntoIterator<Item = f32>) {
        let expected: Vec<f32> = expected.into_iter().collect();
        assert_eq!(found.len(), expected.len());
        assert!(found.iter().zip(&expected).all(|(a, b)| a.to_bits() == b.to_bits()));
    }

    /// The sum over `count` products, one by one.
    fn sum(count: usize, product: impl Fn(usize) -> (f32, f32)) -> f32 {
        (0..count).map(product).fold(0.0, |sum, (a, b)| a.mul_add(b, sum))
    }

    #[test]
    fn products_are_sums_of_fused_products_in_order() {
        for (rows, inputs, outputs) in [(1, 1, 1), (5, 4, 3), (64, 37, 45), (34, 6, 32), (13, 100, 65)] {
            let (x, weight, slopes) =
                (values(rows * inputs, 1), values(inputs * outputs, 2), values(rows * outputs, 3));
            let (arch, size, panels) = (Arch::new(), (inputs, outputs), into_panels(&weight, outputs));
            same(&from_panels(&panels, inputs, outputs), weight.clone());
            let place = |at: usize, columns: usize| (at / columns, at % columns);
            same(
                &forward(arch, &x, &panels, size),
                (0..rows * outputs).map(|at| {
                    let (row, output) = place(at, outputs);
                    sum(inputs, |k| (x[row * inputs + k], weight[k * outputs + output]))
                }),
            );
            same(
                &back(arch, &slopes, &panels, size),
                (0..rows * inputs).map(|at| {
                    let (row, input) = place(at, inputs);
                    sum(outputs, |n| (weight[input * outputs + n], slopes[row * outputs + n]))
                }),
            );
            let mut found = into_panels(&values(inputs * outputs, 4), outputs);
            gradient(arch, &x, &slopes, size, false, &mut found);
            let once: Vec<f32> = (0..inputs * outputs)
                .map(|at| {
                    let (input, output) = place(at, outputs);
                    sum(rows, |row| (x[row * inputs + input], slopes[row * outputs + output]))
                })
                .collect();
            same(&from_panels(&found, inputs, outputs), once.clone());
            gradient(arch, &x, &slopes, size, true, &mut found);
            same(&from_panels(&found, inputs, outputs), once.iter().map(|value| value + value));
        }
    }
}
