//! A small dense Cholesky factor of the chosen rows and columns of a matrix, kept until the choice changes. Called by
//! [`BoundedQuadratic`](super::BoundedQuadratic), whose choice changes seldom from frame to frame.
//!
//! L Lᵀ = A, column by column from the left: Lⱼⱼ = √(Aⱼⱼ − Σ Lⱼₖ²), Lᵢⱼ = (Aᵢⱼ − Σ Lᵢₖ Lⱼₖ) / Lⱼⱼ (Golub and Van Loan,
//! "Matrix Computations", section 4.2). Kept as Lᵀ's rows, so that the inner loops run along memory.

/// The factor of a block of a matrix.
#[derive(Debug, Clone, Default)]
pub(super) struct Cholesky {
    chosen: Vec<usize>,
    /// Lᵀ, row after row: the row k holds Lᵢₖ for i from 0.
    rows: Vec<f64>,
    made: bool,
}

impl Cholesky {
    /// The rows and columns of the block, in rising order.
    pub fn chosen(&self) -> &[usize] {
        &self.chosen
    }

    /// Factors the rows and columns of `matrix` (`size × size`, positive definite, always the same) that `choose` picks;
    /// the last factor is kept where that is the same choice.
    pub fn of_block(&mut self, matrix: &[f64], size: usize, choose: impl Fn(usize) -> bool) {
        let same = self.made && (0..size).filter(|i| choose(*i)).eq(self.chosen.iter().copied());
        if same {
            return;
        }
        self.made = true;
        self.chosen.clear();
        self.chosen.extend((0..size).filter(|i| choose(*i)));
        let n = self.chosen.len();
        self.rows.clear();
        self.rows.resize(n * n, 0.0);
        for (k, i) in self.chosen.iter().enumerate() {
            for (place, j) in self.chosen.iter().enumerate().skip(k) {
                self.rows[k * n + place] = matrix[i * size + j];
            }
        }
        for k in 0..n {
            let (above, below) = self.rows.split_at_mut((k + 1) * n);
            let row = &mut above[k * n..];
            // A pivot that rounding has taken all of belongs to an unknown that others stand for; it is held still.
            let pivot = if row[k] > f64::MIN_POSITIVE { row[k].sqrt() } else { f64::INFINITY };
            for entry in &mut row[k..] {
                *entry /= pivot;
            }
            row[k] = pivot;
            for (next, other) in below.chunks_exact_mut(n).enumerate() {
                let place = k + 1 + next;
                let factor = row[place];
                if factor != 0.0 {
                    for (entry, own) in other[place..].iter_mut().zip(&row[place..]) {
                        *entry -= factor * own;
                    }
                }
            }
        }
    }

    /// Solves A x = b in place, b in the order of the chosen.
    pub fn solve(&self, b: &mut [f64]) {
        let n = self.chosen.len();
        for k in 0..n {
            let row = &self.rows[k * n..(k + 1) * n];
            b[k] /= row[k];
            let known = b[k];
            for (entry, factor) in b[k + 1..].iter_mut().zip(&row[k + 1..]) {
                *entry -= factor * known;
            }
        }
        for k in (0..n).rev() {
            let row = &self.rows[k * n..(k + 1) * n];
            let rest: f64 = row[k + 1..].iter().zip(&b[k + 1..]).map(|(factor, known)| factor * known).sum();
            b[k] = (b[k] - rest) / row[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    #[test]
    fn the_chosen_block_is_solved_and_kept() {
        let (size, mut dice) = (9, Dice(6));
        let roots: Vec<f64> = (0..size * size).map(|_| f64::from(dice.roll())).collect();
        let entry = |i: usize, j: usize| (0..size).map(|k| roots[i * size + k] * roots[j * size + k]).sum::<f64>();
        let matrix: Vec<f64> = (0..size * size)
            .map(|at| entry(at / size, at % size) + f64::from(u8::from(at / size == at % size)))
            .collect();
        let mut factor = Cholesky::default();
        for odd in [false, true, true] {
            factor.of_block(&matrix, size, |i| (i % 3 != 0) == odd);
            let chosen = factor.chosen().to_vec();
            let known: Vec<f64> = chosen.iter().map(|_| f64::from(dice.roll())).collect();
            let row = |i: &usize| chosen.iter().zip(&known).map(|(j, x)| matrix[i * size + j] * x).sum::<f64>();
            let mut b: Vec<f64> = chosen.iter().map(row).collect();
            factor.solve(&mut b);
            assert!(b.iter().zip(&known).all(|(a, b)| (a - b).abs() < 1e-12));
        }
        factor.of_block(&matrix, size, |_| false);
        factor.solve(&mut []);
    }
}
