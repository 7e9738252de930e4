//! Bounded least squares, exactly: the quadratic programme of Eq. 2 of FDLS, fast enough for every frame of a take. Called
//! by [`match_markers`](super::match_markers()).
//!
//! Minimise ½ wᵀ H w − cᵀ w over l ≤ w ≤ u, with H = Bᵀ B symmetric and positive definite. At the optimum the slope
//! g = H w − c is 0 where w lies between its bounds, not negative where w = l, not positive where w = u (the conditions of
//! Karush, Kuhn and Tucker).
//!
//! Which weights lie at a bound is guessed, from the frame before; the free ones follow from the linear system
//! `H_FF w_F = c_F − H_FB w_B`. All whose sign is wrong then change sides at once, as long as their number falls (block
//! principal pivoting: Portugal, Júdice and Vicente, "A comparison of block pivoting and interior-point algorithms for
//! linear least squares problems with nonnegative variables", Math. Comp. 63, 1994; Júdice and Pires 1994 for two bounds).
//! Three times it may rise; after that only the last wrong one changes, which always comes to an end (Murty's rule).
//! A warm start is mostly right but for a weight or two.

use super::cholesky::Cholesky;

/// Where a weight lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Low,
    Free,
    High,
}

/// The quadratic programmes of one matrix H, whatever c is.
#[derive(Debug, Clone)]
pub struct BoundedQuadratic {
    size: usize,
    matrix: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
}

/// Where the weights lay last, and what was computed there: a start for the next frame.
#[derive(Debug, Clone)]
pub struct WarmStart {
    sides: Vec<Side>,
    factor: Cholesky,
    weights: Vec<f64>,
    slope: Vec<f64>,
    right: Vec<f64>,
}

/// Why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum BoundedError {
    /// H is not symmetric with the right size, or holds numbers that are not finite.
    #[error(
        "the matrix of {size} unknowns has {numbers} finite numbers, or bounds of other sizes or in the wrong order"
    )]
    Shape {
        /// Unknowns.
        size: usize,
        /// Finite numbers of the matrix.
        numbers: usize,
    },
    /// The right side holds numbers that are not finite, or is of another size.
    #[error("the right side of {size} unknowns is not {size} finite numbers")]
    Right {
        /// Unknowns.
        size: usize,
    },
    /// The signs went on changing.
    #[error("no answer after {steps} changes of sides; the unknowns depend on each other too closely")]
    Unfinished {
        /// Changes made.
        steps: usize,
    },
}

/// Weights nearer to a bound than this lie on it, so that the answer does not depend on where the search began.
const ON_BOUND: f64 = 1e-10;

/// Added to H's diagonal, as a share of its greatest entry: unknowns that nothing depends on stay as near to 0 as they can.
const RIDGE: f64 = 1e-13;

/// The slope may be wrong by this share of the greatest of c.
const SLOPE_TOLERANCE: f64 = 1e-11;

impl BoundedQuadratic {
    /// Takes H (`size × size`, symmetric, row after row) and the bounds.
    ///
    /// # Errors
    /// Where sizes do not fit, a number is not finite, or a lower bound lies above its upper one.
    pub fn new(mut matrix: Vec<f64>, low: Vec<f64>, high: Vec<f64>) -> Result<Self, BoundedError> {
        let size = low.len();
        let finite = matrix.iter().filter(|number| number.is_finite()).count();
        let ordered = low.iter().zip(&high).all(|(low, high)| low <= high && low.is_finite() && high.is_finite());
        if finite != size * size || matrix.len() != size * size || high.len() != size || !ordered {
            return Err(BoundedError::Shape { size, numbers: finite });
        }
        let largest = (0..size).map(|i| matrix[i * size + i]).fold(f64::MIN_POSITIVE, f64::max);
        for i in 0..size {
            matrix[i * size + i] += RIDGE * largest;
        }
        Ok(Self { size, matrix, low, high })
    }

    /// A start that knows nothing: all weights free.
    pub fn cold(&self) -> WarmStart {
        WarmStart {
            sides: vec![Side::Free; self.size],
            factor: Cholesky::default(),
            weights: vec![0.0; self.size],
            slope: vec![0.0; self.size],
            right: Vec::new(),
        }
    }

    /// The best weights for the right side c, from where `start` left off, which is brought up to date.
    ///
    /// # Errors
    /// Where c is not usable, or the search does not end.
    pub fn solve<'s>(&self, right: &[f64], start: &'s mut WarmStart) -> Result<&'s [f64], BoundedError> {
        if right.len() != self.size || start.sides.len() != self.size || right.iter().any(|c| !c.is_finite()) {
            return Err(BoundedError::Right { size: self.size });
        }
        let scale = right.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
        let tolerance = SLOPE_TOLERANCE * scale;
        let (mut fewest, mut chances, mut steps) = (usize::MAX, 3, 0);
        let most_steps = 200 + 20 * self.size;
        loop {
            self.settle(right, start);
            let wrong = (0..self.size).filter(|i| self.wanted(*i, start, tolerance) != start.sides[*i]).count();
            if wrong == 0 {
                break;
            }
            steps += 1;
            if steps > most_steps {
                return Err(BoundedError::Unfinished { steps });
            }
            let all = if wrong < fewest {
                (fewest, chances) = (wrong, 3);
                true
            } else if chances > 0 {
                chances -= 1;
                true
            } else {
                false
            };
            for i in (0..self.size).rev() {
                let wanted = self.wanted(i, start, tolerance);
                if wanted != start.sides[i] {
                    start.sides[i] = wanted;
                    if !all {
                        break;
                    }
                }
            }
        }
        self.tidy(right, start);
        Ok(&start.weights)
    }

    /// The side on which weight i belongs, as the weights and slopes stand.
    fn wanted(&self, i: usize, now: &WarmStart, tolerance: f64) -> Side {
        match now.sides[i] {
            Side::Free if now.weights[i] < self.low[i] - 0.5 * ON_BOUND => Side::Low,
            Side::Free if now.weights[i] > self.high[i] + 0.5 * ON_BOUND => Side::High,
            Side::Low if now.slope[i] < -tolerance && self.low[i] < self.high[i] => Side::Free,
            Side::High if now.slope[i] > tolerance && self.low[i] < self.high[i] => Side::Free,
            side => side,
        }
    }

    /// Solves for the free weights with the others at their bounds, and computes all slopes.
    fn settle(&self, right: &[f64], now: &mut WarmStart) {
        let size = self.size;
        for (i, side) in now.sides.iter().enumerate() {
            match side {
                Side::Low => now.weights[i] = self.low[i],
                Side::High => now.weights[i] = self.high[i],
                Side::Free => now.weights[i] = 0.0,
            }
        }
        now.slope.clear();
        now.slope.extend(right.iter().map(|c| -c));
        self.add_columns(&now.sides, false, &now.weights, &mut now.slope);
        now.factor.of_block(&self.matrix, size, |i| now.sides[i] == Side::Free);
        // Twice: the second round takes back what rounding did to the first.
        for _ in 0..2 {
            let free = now.factor.chosen();
            now.right.clear();
            now.right.extend(free.iter().map(|i| -now.slope[*i]));
            now.factor.solve(&mut now.right);
            for (place, i) in now.factor.chosen().iter().enumerate() {
                let step = now.right[place];
                now.weights[*i] += step;
                if step != 0.0 {
                    add_row(&self.matrix[i * size..(i + 1) * size], step, &mut now.slope);
                }
            }
        }
    }

    /// slope += H w over the columns that are free, or those that are not.
    fn add_columns(&self, sides: &[Side], free: bool, weights: &[f64], slope: &mut [f64]) {
        for (i, side) in sides.iter().enumerate() {
            if (*side == Side::Free) == free && weights[i] != 0.0 {
                add_row(&self.matrix[i * self.size..(i + 1) * self.size], weights[i], slope);
            }
        }
    }

    /// Puts weights that all but lie on a bound there, and solves for the rest once more.
    fn tidy(&self, right: &[f64], now: &mut WarmStart) {
        let mut changed = false;
        for i in 0..self.size {
            if now.sides[i] == Side::Free {
                let side = if now.weights[i] < self.low[i] + ON_BOUND {
                    Side::Low
                } else if now.weights[i] > self.high[i] - ON_BOUND {
                    Side::High
                } else {
                    continue;
                };
                now.sides[i] = side;
                changed = true;
            }
        }
        if changed {
            self.settle(right, now);
        }
        for (weight, (low, high)) in now.weights.iter_mut().zip(self.low.iter().zip(&self.high)) {
            *weight = weight.clamp(*low, *high);
        }
    }

    /// By how much `weights` fail the conditions of the optimum: the greatest slope that points the wrong way, over the
    /// greatest of c.
    pub fn violation(&self, right: &[f64], weights: &[f64]) -> f64 {
        let mut slope: Vec<f64> = right.iter().map(|c| -c).collect();
        for (i, weight) in weights.iter().enumerate() {
            add_row(&self.matrix[i * self.size..(i + 1) * self.size], *weight, &mut slope);
        }
        let scale = right.iter().fold(f64::MIN_POSITIVE, |most, c| most.max(c.abs()));
        let wrong = |i: usize| match weights[i] {
            weight if weight <= self.low[i] => (-slope[i]).max(0.0),
            weight if weight >= self.high[i] => slope[i].max(0.0),
            _ => slope[i].abs(),
        };
        (0..self.size).map(wrong).fold(0.0, f64::max) / scale
    }
}

/// sum += factor × row.
fn add_row(row: &[f64], factor: f64, sum: &mut [f64]) {
    for (sum, entry) in sum.iter_mut().zip(row) {
        *sum += factor * entry;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    /// B of `rows × size`, and Bᵀ B.
    fn problem(rows: usize, size: usize, dice: &mut Dice) -> (Vec<f64>, Vec<f64>) {
        let b: Vec<f64> = (0..rows * size).map(|_| f64::from(dice.roll())).collect();
        let mut gram = vec![0.0; size * size];
        for row in b.chunks_exact(size) {
            for i in 0..size {
                add_row(row, row[i], &mut gram[i * size..(i + 1) * size]);
            }
        }
        (b, gram)
    }

    fn unit(size: usize, gram: Vec<f64>) -> BoundedQuadratic {
        BoundedQuadratic::new(gram, vec![0.0; size], vec![1.0; size]).unwrap()
    }

    fn value(gram: &[f64], c: &[f64], w: &[f64]) -> f64 {
        let size = c.len();
        let mut product = vec![0.0; size];
        for i in 0..size {
            add_row(&gram[i * size..(i + 1) * size], w[i], &mut product);
        }
        (0..size).map(|i| w[i] * (0.5 * product[i] - c[i])).sum()
    }

    #[test]
    fn the_conditions_of_the_optimum_hold_for_any_problem() {
        let mut dice = Dice(1);
        for round in 0..300 {
            let size = 1 + round % 40;
            let (_, gram) = problem(size + 3 + round % 7, size, &mut dice);
            let c: Vec<f64> = (0..size).map(|_| 3.0 * f64::from(dice.roll())).collect();
            let solver = unit(size, gram);
            let mut start = solver.cold();
            let weights = solver.solve(&c, &mut start).unwrap().to_vec();
            assert!(weights.iter().all(|weight| (0.0..=1.0).contains(weight)));
            assert!(solver.violation(&c, &weights) < 1e-9, "round {round}: {}", solver.violation(&c, &weights));
        }
    }

    #[test]
    fn no_other_weights_are_better() {
        let mut dice = Dice(2);
        for _ in 0..40 {
            let (_, gram) = problem(20, 9, &mut dice);
            let c: Vec<f64> = (0..9).map(|_| 4.0 * f64::from(dice.roll())).collect();
            let solver = unit(9, gram.clone());
            let best = solver.solve(&c, &mut solver.cold()).unwrap().to_vec();
            let least = value(&gram, &c, &best);
            for _ in 0..200 {
                let size = if dice.roll() > 0.0 { 1.0 } else { 1e-3 };
                let other: Vec<f64> =
                    best.iter().map(|weight| (weight + size * f64::from(dice.roll())).clamp(0.0, 1.0)).collect();
                assert!(value(&gram, &c, &other) >= least - 1e-12);
            }
        }
    }

    #[test]
    fn known_weights_within_and_at_the_bounds_come_back() {
        let mut dice = Dice(3);
        let (_, gram) = problem(60, 12, &mut dice);
        let known: Vec<f64> = (0..12).map(|i| [0.0, 1.0, 0.3][i % 3]).collect();
        let mut c = vec![0.0; 12];
        for i in 0..12 {
            add_row(&gram[i * 12..(i + 1) * 12], known[i], &mut c);
        }
        let solver = unit(12, gram);
        let found = solver.solve(&c, &mut solver.cold()).unwrap().to_vec();
        assert!(found.iter().zip(&known).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    }

    #[test]
    fn the_answer_does_not_depend_on_where_the_search_began() {
        let mut dice = Dice(4);
        let (_, gram) = problem(30, 20, &mut dice);
        let solver = unit(20, gram);
        let mut warm = solver.cold();
        for _ in 0..100 {
            let c: Vec<f64> = (0..20).map(|_| 5.0 * f64::from(dice.roll())).collect();
            let from_warm = solver.solve(&c, &mut warm).unwrap().to_vec();
            let from_cold = solver.solve(&c, &mut solver.cold()).unwrap().to_vec();
            assert_eq!(from_warm, from_cold);
        }
    }

    #[test]
    fn unknowns_that_nothing_depends_on_stay_at_rest_and_twins_share() {
        // The second unknown moves nothing, the third does just what the first does.
        let solver = unit(3, vec![2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 2.0]);
        let found = solver.solve(&[1.2, 0.0, 1.2], &mut solver.cold()).unwrap().to_vec();
        assert!(found[1].abs() < 1e-9 && (found[0] + found[2] - 0.6).abs() < 1e-9, "{found:?}");
        let fixed = BoundedQuadratic::new(vec![1.0], vec![0.4], vec![0.4]).unwrap();
        assert_eq!(fixed.solve(&[9.0], &mut fixed.cold()).unwrap(), [0.4]);
    }

    #[test]
    fn misfits_are_refused() {
        assert!(BoundedQuadratic::new(vec![1.0; 3], vec![0.0; 2], vec![1.0; 2]).is_err());
        assert!(BoundedQuadratic::new(vec![1.0], vec![1.0], vec![0.0]).is_err());
        assert!(BoundedQuadratic::new(vec![f64::NAN], vec![0.0], vec![1.0]).is_err());
        let solver = unit(1, vec![1.0]);
        assert_eq!(solver.solve(&[f64::NAN], &mut solver.cold()), Err(BoundedError::Right { size: 1 }));
    }
}
