//! Symmetric systems of a few hundred unknowns, one after the other by the thousand: L Lᵀ = A, with three right sides.
//!
//! The lower half lies in panels of eight columns, so that a row of a panel is one vector. Panel J is made from those before it,
//! `C_iJ` = `A_iJ` − `Σ_Q` `L_iQ` `L_JQᵀ`, eight by eight at a time; then `L_JJ` by hand, and `L_iJ` = `C_iJ` `L_JJ`⁻ᵀ (Golub and Van Loan,
//! "Matrix Computations", section 4.2). Right sides are rows below the last one: what comes out of them is L⁻¹ b.

use pulp::{Arch, Simd, WithSimd};
use std::array::from_fn;

const WIDTH: usize = 8;

type Row = [f64; WIDTH];

/// Right sides of a system: the three coordinates of a vertex.
pub(super) const SIDES: usize = 3;

/// Room for a system, to be used again and again.
pub(super) struct Cholesky {
    arch: Arch,
    /// Panel after panel, the rows from its first column on, then the right sides.
    panels: Vec<Row>,
    /// `L_JJ`⁻¹, transposed, of every panel.
    inverses: Vec<[Row; WIDTH]>,
    size: usize,
}

impl Cholesky {
    pub fn new() -> Self {
        Self { arch: Arch::new(), panels: Vec::new(), inverses: Vec::new(), size: 0 }
    }

    /// Solves A x = b for three b. `entry(row, column)` is asked for the lower half of A, `right(side, row)` for b; the answer is
    /// told as `(side, row, value)`. False where A is not positive definite.
    pub fn solve(
        &mut self,
        size: usize,
        entry: impl Fn(usize, usize) -> f64,
        right: impl Fn(usize, usize) -> f64,
        mut tell: impl FnMut(usize, usize, f64),
    ) -> bool {
        self.size = size;
        let panels = size.div_ceil(WIDTH);
        self.panels.clear();
        self.inverses.clear();
        for panel in 0..panels {
            let first = panel * WIDTH;
            for row in first..panels * WIDTH {
                // Rows and columns beyond the last are those of the identity.
                self.panels.push(from_fn(|lane| match first + lane {
                    column if row < size && column <= row => entry(row, column),
                    column => f64::from(u8::from(row == column)),
                }));
            }
            for side in 0..SIDES {
                self.panels.push(from_fn(|lane| if first + lane < size { right(side, first + lane) } else { 0.0 }));
            }
        }
        let arch = self.arch;
        if !arch.dispatch(Factor { own: self, panels }) {
            return false;
        }
        for panel in 0..panels {
            let sides = start(panels, panel + 1) - SIDES;
            for side in 0..SIDES {
                for lane in 0..WIDTH.min(size - panel * WIDTH) {
                    tell(side, panel * WIDTH + lane, self.panels[sides + side][lane]);
                }
            }
        }
        true
    }
}

/// Factor and solution of a system, for pulp to compile once for each instruction set.
struct Factor<'a> {
    own: &'a mut Cholesky,
    panels: usize,
}

impl WithSimd for Factor<'_> {
    type Output = bool;

    #[allow(
        clippy::inline_always,
        reason = "compiled into one function for each instruction set; a call would lose the set"
    )]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let (rows, inverses, panels) = (&mut self.own.panels[..], &mut self.own.inverses, self.panels);
        for panel in 0..panels {
            let (before, own) = rows.split_at_mut(start(panels, panel));
            let own = &mut own[..length(panels, panel)];
            for other in 0..panel {
                // The rows of the earlier panel that stand beside ours.
                let beside = &before[start(panels, other) + (panel - other) * WIDTH..start(panels, other + 1)];
                let tile: [Row; WIDTH] = from_fn(|column| from_fn(|row| -beside[row][column]));
                for (row, left) in own.iter_mut().zip(beside) {
                    add_product(simd, row, left, &tile);
                }
            }
            let Some(inverse) = corner(&mut own[..WIDTH]) else { return false };
            for row in &mut own[WIDTH..] {
                let left = std::mem::take(row);
                add_product(simd, row, &left, &inverse);
            }
            inverses.push(inverse);
        }
        // Lᵀ x = y, from the last panel to the first; x in place of the right sides.
        for panel in (0..panels).rev() {
            let (before, after) = rows.split_at_mut(start(panels, panel + 1));
            let (own, sides) = before[start(panels, panel)..].split_at_mut(length(panels, panel) - SIDES);
            for below in panel + 1..panels {
                let solved = start(panels, below + 1) - SIDES - start(panels, panel + 1);
                let tile: [Row; WIDTH] = from_fn(|row| own[(below - panel) * WIDTH + row]);
                for (side, known) in sides.iter_mut().zip(&after[solved..]) {
                    add_product(simd, side, &known.map(|value| -value), &tile);
                }
            }
            let inverse: [Row; WIDTH] = from_fn(|row| from_fn(|column| inverses[panel][column][row]));
            for side in sides {
                let left = std::mem::take(side);
                add_product(simd, side, &left, &inverse);
            }
        }
        true
    }
}

/// Rows of a panel, the right sides with them.
fn length(panels: usize, panel: usize) -> usize {
    (panels - panel) * WIDTH + SIDES
}

/// Where a panel begins.
fn start(panels: usize, panel: usize) -> usize {
    WIDTH * (panel * panels - panel * panel.saturating_sub(1) / 2) + SIDES * panel
}

/// row += left · tile.
#[allow(clippy::inline_always, reason = "part of a function that is compiled for each instruction set")]
#[inline(always)]
fn add_product<S: Simd>(simd: S, row: &mut Row, left: &Row, tile: &[Row; WIDTH]) {
    for (lanes, sum) in S::as_mut_simd_f64s(row).0.iter_mut().enumerate() {
        for (value, other) in left.iter().zip(tile) {
            *sum = simd.mul_add_f64s(simd.splat_f64s(*value), S::as_simd_f64s(other).0[lanes], *sum);
        }
    }
}

/// L of a corner in its place, and L⁻ᵀ by rows; nothing where it is not positive definite.
fn corner(tile: &mut [Row]) -> Option<[Row; WIDTH]> {
    for j in 0..WIDTH {
        for i in j..WIDTH {
            let rest = tile[i][j] - (0..j).map(|k| tile[i][k] * tile[j][k]).sum::<f64>();
            tile[i][j] = if i > j {
                rest / tile[j][j]
            } else if rest > 0.0 {
                rest.sqrt()
            } else {
                return None;
            };
        }
    }
    // Column j of L⁻¹ is row j of L⁻ᵀ.
    let mut inverse = [[0.0; WIDTH]; WIDTH];
    for (j, column) in inverse.iter_mut().enumerate() {
        for i in j..WIDTH {
            let known: f64 = (j..i).map(|k| tile[i][k] * column[k]).sum();
            column[i] = (f64::from(u8::from(i == j)) - known) / tile[i][i];
        }
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    #[test]
    fn systems_of_any_size_are_solved() {
        let mut own = Cholesky::new();
        for size in [1, 7, 8, 9, 16, 40, 61] {
            let mut dice = Dice(71);
            let roots: Vec<f64> = (0..size * size).map(|_| f64::from(dice.roll())).collect();
            let entry = |i: usize, j: usize| {
                (0..size).map(|k| roots[i * size + k] * roots[j * size + k]).sum::<f64>() + f64::from(u8::from(i == j))
            };
            let known: Vec<[f64; SIDES]> = (0..size).map(|_| from_fn(|_| f64::from(dice.roll()))).collect();
            let right = |side: usize, i: usize| (0..size).map(|j| entry(i, j) * known[j][side]).sum::<f64>();
            let mut told = 0;
            let solved = own.solve(size, entry, right, |side, row, value| {
                told += 1;
                assert!((value - known[row][side]).abs() < 1e-9, "{size}: {row} {value} {}", known[row][side]);
            });
            assert!(solved && told == SIDES * size);
        }
        assert!(!own.solve(9, |i, j| if i == j && i < 8 { 1.0 } else { 0.0 }, |_, _| 1.0, |_, _, _| ()));
        assert!(!own.solve(2, |_, _| f64::NAN, |_, _| 1.0, |_, _, _| ()));
    }
}
