//! Symmetric banded systems: what coupling over time makes of a solve, in time that grows with the number of frames alone.
//!
//! L Lᵀ = A with `width` diagonals below the main one: Lⱼⱼ = √(Aⱼⱼ − Σ Lⱼₖ²), Lᵢⱼ = (Aᵢⱼ − Σ Lᵢₖ Lⱼₖ) / Lⱼⱼ over the k within the
//! band (Golub and Van Loan, "Matrix Computations", section 4.3.5): n · width² operations, and n · width a right side.

use super::error::StrainError;

/// A symmetric matrix of which only a band is not 0, by rows: entry `(i, i − d)` at `i · (width + 1) + d`.
#[derive(Debug, Clone)]
pub(super) struct Banded {
    width: usize,
    entries: Vec<f64>,
}

impl Banded {
    /// Zeros, `size × size` with `width` diagonals below the main one.
    pub fn zeros(size: usize, width: usize) -> Self {
        Self { width, entries: vec![0.0; size * (width + 1)] }
    }

    /// Adds to the entries (i, j) and (j, i), once where they are one. `|i − j|` is at most the width.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        let (row, column) = (i.max(j), i.min(j));
        self.entries[row * (self.width + 1) + row - column] += value;
    }

    /// The factor L in place of the matrix.
    ///
    /// # Errors
    /// Where it is not positive definite.
    pub fn factored(mut self) -> Result<Factor, StrainError> {
        let (step, width) = (self.width + 1, self.width);
        for i in 0..self.entries.len() / step {
            for d in (0..=width.min(i)).rev() {
                let j = i - d;
                let reach = (width - d).min(j);
                let (own, other) = (&self.entries[i * step..], &self.entries[j * step..]);
                let known: f64 = (1..=reach).map(|k| own[d + k] * other[k]).sum();
                let rest = own[d] - known;
                self.entries[i * step + d] = if d > 0 {
                    rest / self.entries[j * step]
                } else if rest > 0.0 {
                    rest.sqrt()
                } else {
                    return Err(StrainError::Decomposition { what: "the coupling of frames" });
                };
            }
        }
        Ok(Factor { width, entries: self.entries })
    }
}

/// The factor of a banded matrix.
#[derive(Debug, Clone)]
pub(super) struct Factor {
    width: usize,
    entries: Vec<f64>,
}

impl Factor {
    /// Solves A x = b in place.
    pub fn solve(&self, b: &mut [f64]) {
        let (step, width) = (self.width + 1, self.width);
        for i in 0..b.len() {
            let known: f64 = (1..=width.min(i)).map(|d| self.entries[i * step + d] * b[i - d]).sum();
            b[i] = (b[i] - known) / self.entries[i * step];
        }
        for i in (0..b.len()).rev() {
            b[i] /= self.entries[i * step];
            let own = b[i];
            for d in 1..=width.min(i) {
                b[i - d] -= self.entries[i * step + d] * own;
            }
        }
    }
}

/// Calls `each(t, s, factor)` for the entries of `D2ᵀ D2`, where D2 takes the second differences x(t−1) − 2 x(t) + x(t+1) of
/// `frames` frames of which the first and the last are repeated at the ends (section B.2 of Animatomy); each pair once.
pub(super) fn acceleration(frames: usize, mut each: impl FnMut(usize, usize, f64)) {
    for t in 0..frames {
        let mut row: Vec<(usize, f64)> = vec![(t, -2.0)];
        for neighbour in [t.saturating_sub(1), (t + 1).min(frames - 1)] {
            match row.iter_mut().find(|(place, _)| *place == neighbour) {
                Some((_, factor)) => *factor += 1.0,
                None => row.push((neighbour, 1.0)),
            }
        }
        for (i, (a, x)) in row.iter().enumerate() {
            for (b, y) in &row[i..] {
                each(*a, *b, x * y);
            }
        }
    }
}

/// Σ over frames of the squared second differences of `values` (frames × `count`), ends repeated.
pub(super) fn acceleration_loss(values: &[f64], count: usize) -> f64 {
    let frames = values.len() / count.max(1);
    let at = |frame: usize, index: usize| values[frame * count + index];
    let second = |t: usize, i: usize| at(t.saturating_sub(1), i) - 2.0 * at(t, i) + at((t + 1).min(frames - 1), i);
    (0..frames).flat_map(|t| (0..count).map(move |i| (t, i))).map(|(t, i)| second(t, i).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    #[test]
    fn a_banded_system_is_solved() {
        let (size, width, mut dice) = (23, 4, Dice(61));
        let mut band = Banded::zeros(size, width);
        let mut dense = vec![0.0; size * size];
        for i in 0..size {
            for j in i.saturating_sub(width)..=i {
                let value = f64::from(dice.roll()) + if i == j { 9.0 } else { 0.0 };
                band.add(i, j, value);
                dense[i * size + j] = value;
                dense[j * size + i] = value;
            }
        }
        let known: Vec<f64> = (0..size).map(|_| f64::from(dice.roll())).collect();
        let mut b: Vec<f64> =
            dense.chunks_exact(size).map(|row| row.iter().zip(&known).map(|(a, x)| a * x).sum()).collect();
        band.factored().unwrap().solve(&mut b);
        assert!(b.iter().zip(&known).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(Banded::zeros(3, 1).factored().is_err());
    }

    #[test]
    fn the_matrix_of_accelerations_gives_their_loss() {
        for frames in [1, 2, 3, 9] {
            let mut dice = Dice(62);
            let values: Vec<f64> = (0..frames).map(|_| f64::from(dice.roll())).collect();
            let mut sum = 0.0;
            acceleration(frames, |a, b, factor| {
                sum += factor * values[a] * values[b] * if a == b { 1.0 } else { 2.0 };
            });
            assert!((sum - acceleration_loss(&values, 1)).abs() < 1e-12, "{frames}: {sum}");
        }
        assert!(acceleration_loss(&[3.0, 3.0, 3.0], 1) == 0.0);
    }
}
