//! Tests of the bounded minimiser: known optima, the conditions of an optimum, and a plain method run for long.

use super::{Metric, MinimiseError, MinimiseOptions, Minimum, Stop, minimise};
use crate::rig::toy::Dice;

const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn tight() -> MinimiseOptions {
    MinimiseOptions { gradient_tolerance: 1e-10, max_steps: 2000, memory: 8 }
}

fn rosenbrock(x: &[f64], gradient: &mut [f64]) -> f64 {
    let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
    gradient[0] = -2.0 * a - 400.0 * x[0] * b;
    gradient[1] = 200.0 * b;
    a * a + 100.0 * b * b
}

fn close(found: &[f64], known: &[f64], by: f64) {
    for (found, known) in found.iter().zip(known) {
        assert!((found - known).abs() <= by, "{found} for {known}");
    }
}

/// A convex quadratic ½ xᵀ A x − bᵀ x with A = Gᵀ G + hold I.
struct Quadratic {
    size: usize,
    matrix: Vec<f64>,
    linear: Vec<f64>,
}

impl Quadratic {
    fn rolled(seed: u64, size: usize, rows: usize, hold: f64) -> Self {
        let mut dice = Dice(seed);
        let g: Vec<f64> = (0..rows * size).map(|_| f64::from(dice.roll())).collect();
        let mut matrix = vec![0.0; size * size];
        for i in 0..size {
            for j in 0..size {
                matrix[i * size + j] = (0..rows).map(|r| g[r * size + i] * g[r * size + j]).sum();
            }
            matrix[i * size + i] += hold;
        }
        let linear = (0..size).map(|_| 3.0 * f64::from(dice.roll())).collect();
        Self { size, matrix, linear }
    }

    fn at(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let mut value = 0.0;
        for i in 0..self.size {
            let row: f64 = (0..self.size).map(|j| self.matrix[i * self.size + j] * x[j]).sum();
            gradient[i] = row - self.linear[i];
            value += x[i] * (0.5 * row - self.linear[i]);
        }
        value
    }

    /// Projected gradient steps of length 1/L, run until they stand still.
    fn plain(&self, bounds: &[(f64, f64)]) -> Vec<f64> {
        let most = (0..self.size)
            .map(|i| self.matrix[i * self.size..(i + 1) * self.size].iter().map(|a| a.abs()).sum::<f64>())
            .fold(0.0, f64::max);
        let mut x = vec![0.0; self.size];
        let mut gradient = vec![0.0; self.size];
        for _ in 0..200_000 {
            self.at(&x, &mut gradient);
            for i in 0..self.size {
                x[i] = (x[i] - gradient[i] / most).clamp(bounds[i].0, bounds[i].1);
            }
        }
        x
    }
}

#[test]
fn rosenbrock_is_solved_free_and_in_boxes() {
    let solve = |bounds: &[(f64, f64)]| minimise(rosenbrock, &[-1.2, 1.0], bounds, &Metric::Unknown, &tight()).unwrap();
    let free = solve(&[FREE, FREE]);
    assert_eq!(free.stop, Stop::Converged);
    assert!(free.evaluations < 100, "{}", free.evaluations);
    close(&free.x, &[1.0, 1.0], 1e-8);
    // With x₀ ≤ ½ the minimum slides along the valley floor to (½, ¼).
    close(&solve(&[(-2.0, 0.5), FREE]).x, &[0.5, 0.25], 1e-8);
    // With x₀ ≥ 1.5 likewise, and with x₁ ≤ ½ it is where the derivative along the bound vanishes.
    close(&solve(&[(1.5, 3.0), (-5.0, 5.0)]).x, &[1.5, 2.25], 1e-8);
    let low = solve(&[(0.0, 2.0), (-1.0, 0.5)]);
    assert!((low.x[1] - 0.5).abs() < 1e-15);
    let mut gradient = [0.0; 2];
    rosenbrock(&low.x, &mut gradient);
    assert!(gradient[0].abs() < 1e-8 && gradient[1] < 0.0);
}

#[test]
fn quadratics_in_boxes_meet_the_plain_method_and_the_conditions_of_an_optimum() {
    for seed in 0..20 {
        let size = 12;
        let problem = Quadratic::rolled(seed, size, 20, 0.1);
        let bounds = vec![(0.0, 0.4); size];
        let plain = problem.plain(&bounds);
        let diagonal = (0..size).map(|i| problem.matrix[i * size + i]).collect();
        let mut held = 0;
        for metric in [Metric::Unknown, Metric::Diagonal(diagonal), Metric::Dense(problem.matrix.clone())] {
            let found = minimise(|x, g| problem.at(x, g), &vec![0.2; size], &bounds, &metric, &tight()).unwrap();
            assert!(found.stop != Stop::StepsSpent, "{found:?}");
            assert!(found.projected_gradient < 1e-8, "{found:?}");
            close(&found.x, &plain, 1e-7);
            let mut gradient = vec![0.0; size];
            problem.at(&found.x, &mut gradient);
            for (x, g) in found.x.iter().zip(&gradient) {
                let fits = if *x <= 0.0 {
                    *g >= 0.0
                } else if *x >= 0.4 {
                    *g <= 0.0
                } else {
                    g.abs() < 1e-8
                };
                assert!(fits, "x = {x}, g = {g}");
                held += usize::from(*x <= 0.0 || *x >= 0.4);
            }
        }
        assert!(held > 0, "a test without held variables tests little");
    }
}

#[test]
fn a_known_hessian_takes_few_steps() {
    let size = 30;
    let problem = Quadratic::rolled(3, size, 40, 0.01);
    let solve = |metric: &Metric| -> Minimum {
        minimise(|x, g| problem.at(x, g), &vec![0.5; size], &vec![(0.0, 1.0); size], metric, &tight()).unwrap()
    };
    let (known, unknown) = (solve(&Metric::Dense(problem.matrix.clone())), solve(&Metric::Unknown));
    close(&known.x, &unknown.x, 1e-7);
    assert!(known.steps < 25 && known.steps < unknown.steps, "{} and {}", known.steps, unknown.steps);
}

#[test]
fn a_start_outside_is_moved_in_and_equal_bounds_freeze() {
    let problem = Quadratic::rolled(5, 4, 8, 0.1);
    let bounds = [(0.0, 1.0), (0.3, 0.3), (0.0, 1.0), (-1.0, 0.0)];
    let found = minimise(|x, g| problem.at(x, g), &[9.0, 9.0, -9.0, 9.0], &bounds, &Metric::Unknown, &tight()).unwrap();
    close(&found.x, &problem.plain(&bounds), 1e-7);
    assert!((found.x[1] - 0.3).abs() < 1e-15);
}

#[test]
fn an_optimum_at_the_start_costs_one_evaluation() {
    let found = minimise(rosenbrock, &[1.0, 1.0], &[FREE, FREE], &Metric::Unknown, &tight()).unwrap();
    assert_eq!((found.evaluations, found.steps, found.stop), (1, 0, Stop::Converged));
}

#[test]
fn bad_problems_are_refused() {
    let solve = |bounds: &[(f64, f64)], metric: &Metric| {
        minimise(rosenbrock, &[0.0, 0.0], bounds, metric, &tight()).unwrap_err()
    };
    assert!(matches!(solve(&[FREE], &Metric::Unknown), MinimiseError::Size { what: "bounds", .. }));
    assert!(matches!(solve(&[FREE, (1.0, 0.0)], &Metric::Unknown), MinimiseError::Bounds { variable: 1, .. }));
    let flat = Metric::Dense(vec![1.0, 1.0, 1.0, 1.0]);
    assert_eq!(solve(&[FREE, FREE], &flat), MinimiseError::Metric { variable: 1 });
    let nan = minimise(|_, _| f64::NAN, &[0.0], &[FREE], &Metric::Unknown, &tight()).unwrap_err();
    assert_eq!(nan, MinimiseError::NotFinite);
}
