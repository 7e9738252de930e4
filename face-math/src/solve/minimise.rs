//! The bounded minimiser behind every fit: L-BFGS in a box.
//!
//! Minimise f(x) subject to lᵢ ≤ xᵢ ≤ uᵢ, with an exact gradient g. Each step:
//!
//! 1. **Who is held.** Variable i is held at its bound where it lies within εᵢ of it and the gradient pushes it there:
//!    the ε-active set of Bertsekas, "Projected Newton methods for optimization problems with simple constraints", SIAM J.
//!    Control Optim. 20 (1982), with εᵢ = min(10⁻³ (uᵢ − lᵢ), ‖x − P(x − g / diag B₀)‖).
//! 2. **Where to.** On the free variables the direction is −H g, with H the limited-memory inverse Hessian of Liu and
//!    Nocedal (1989): the two-loop recursion over the last pairs s = x⁺ − x, y = g⁺ − g, restricted to the free variables,
//!    around H₀ = γ B₀⁻¹, γ = sᵀy / yᵀB₀⁻¹y (Nocedal and Wright, Eq. 7.20, for B₀ = I). B₀ is what is known of the
//!    Hessian beforehand: nothing, a diagonal, or a whole matrix. Held variables take the gradient step −gᵢ / B₀ᵢᵢ, so
//!    that H is diagonal across the two sets: that makes the projected direction one of descent (ibid.).
//! 3. **How far.** Along the bent path x(α) = P(x + α d), α shrinks until f falls by at least
//!    10⁻⁴ (−α Σ gᵢ dᵢ over the free + Σ gᵢ (xᵢ − xᵢ(α)) over the held ones), Armijo's rule as
//!    Bertsekas bends it.
//!
//! It ends where the projected gradient ‖x − P(x − g)‖∞ falls below a tolerance: the Karush-Kuhn-Tucker conditions of
//! the box.

use super::curvature::{Inner, Memory};

/// What is known of the Hessian before the first step: the metric in which the first step is steepest.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Metric {
    /// Nothing: the identity.
    #[default]
    Unknown,
    /// Its diagonal; all entries positive.
    Diagonal(Vec<f64>),
    /// All of it, row after row, symmetric and positive definite, as `JᵀJ` of a least-squares problem.
    Dense(Vec<f64>),
}

/// When to stop, and how much to remember.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MinimiseOptions {
    /// Stop where no entry of the projected gradient is larger (in units of f a unit of x).
    pub gradient_tolerance: f64,
    /// Stop after so many steps.
    pub max_steps: usize,
    /// Pairs (s, y) to remember.
    pub memory: usize,
}

impl Default for MinimiseOptions {
    fn default() -> Self {
        Self { gradient_tolerance: 1e-8, max_steps: 200, memory: 8 }
    }
}

/// Why the minimiser stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The projected gradient is below the tolerance.
    Converged,
    /// No step lowers f any more: rounding hides the rest of the descent, or x sits on a kink of f.
    NoDescent,
    /// The steps ran out.
    StepsSpent,
}

/// The outcome of [`minimise`].
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// The best x found, within its bounds.
    pub x: Vec<f64>,
    /// f there.
    pub value: f64,
    /// ‖x − P(x − g)‖∞ there.
    pub projected_gradient: f64,
    /// Steps taken.
    pub steps: usize,
    /// How often f and g were evaluated.
    pub evaluations: usize,
    /// Why it stopped.
    pub stop: Stop,
}

/// Why a problem cannot be minimised.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MinimiseError {
    /// Start, bounds and metric differ in size.
    #[error("{what} of {found} numbers for {expected} variables; give one a variable")]
    Size {
        /// Which table.
        what: &'static str,
        /// Numbers needed.
        expected: usize,
        /// Numbers given.
        found: usize,
    },
    /// A lower bound above the upper one, or one that is not a number.
    #[error("variable {variable} is bounded by {low} below and {high} above; lower the first or raise the second")]
    Bounds {
        /// The variable.
        variable: usize,
        /// Its lower bound.
        low: f64,
        /// Its upper bound.
        high: f64,
    },
    /// The metric is not positive definite.
    #[error("the metric is not positive definite at variable {variable}; add to its diagonal (a hold)")]
    Metric {
        /// The variable at which factoring fails.
        variable: usize,
    },
    /// f or its gradient is not a number at the start.
    #[error("the function is not a number at the start; look for missing values in what it is made of")]
    NotFinite,
}

/// The share of f below which its changes are taken for rounding: residuals of some micrometres, as differences of positions
/// of some decimetres, carry about that much.
const ROUNDING: f64 = 1e-10;
/// So many steps in a row below rounding end the descent: x sits on a kink.
const IDLE_STEPS: usize = 20;

/// Minimises `function` from `start` (moved into the box first). `function(x, gradient)` returns f and writes g.
///
/// # Errors
/// Where sizes do not fit, a bound or the metric is unusable, or f is not a number at the start.
pub fn minimise(
    function: impl FnMut(&[f64], &mut [f64]) -> f64,
    start: &[f64],
    bounds: &[(f64, f64)],
    metric: &Metric,
    options: &MinimiseOptions,
) -> Result<Minimum, MinimiseError> {
    check(start, bounds, metric)?;
    let size = start.len();
    let mut descent = Descent {
        function,
        bounds,
        x: start.iter().zip(bounds).map(|(x, (low, high))| x.clamp(*low, *high)).collect(),
        gradient: vec![0.0; size],
        value: 0.0,
        next: vec![0.0; size],
        next_gradient: vec![0.0; size],
        evaluations: 1,
    };
    descent.value = (descent.function)(&descent.x, &mut descent.gradient);
    if !descent.value.is_finite() || descent.gradient.iter().any(|g| !g.is_finite()) {
        return Err(MinimiseError::NotFinite);
    }
    let mut memory = Memory::new(options.memory);
    let mut inner = Inner::new(metric, size);
    let mut direction = vec![0.0; size];
    let (mut steps, mut idle) = (0, 0);
    let (stop, projected_gradient) = loop {
        let projected_gradient = (0..size).map(|i| descent.shift(i, 1.0)).fold(0.0, f64::max);
        if projected_gradient <= options.gradient_tolerance {
            break (Stop::Converged, projected_gradient);
        }
        if steps == options.max_steps {
            break (Stop::StepsSpent, projected_gradient);
        }
        steps += 1;
        let reach = (0..size).map(|i| descent.shift(i, inner.diagonal(i)).powi(2)).sum::<f64>().sqrt();
        inner.hold(|i| !descent.is_pushed(i, reach))?;
        memory.direction(&descent.gradient, &inner, &mut direction);
        if descent.slope(&direction, &inner.free).is_nan() || descent.slope(&direction, &inner.free) > 0.0 {
            memory.forget();
            memory.direction(&descent.gradient, &inner, &mut direction);
        }
        // The first step of an unknown metric has no scale: let it move x by 1 at the most.
        let longest = direction.iter().fold(0.0_f64, |longest, d| longest.max(d.abs()));
        let unscaled = memory.is_empty() && *metric == Metric::Unknown;
        let first = if unscaled { (1.0 / longest).min(1.0) } else { 1.0 };
        let before = descent.value;
        if descent.search(&direction, &inner.free, first, 1e-16 / longest) {
            memory.remember(&descent.next, &descent.x, &descent.next_gradient, &descent.gradient);
            idle = if before - descent.value > ROUNDING * before.abs() { 0 } else { idle + 1 };
            if idle == IDLE_STEPS {
                break (Stop::NoDescent, projected_gradient);
            }
        } else if memory.is_empty() {
            break (Stop::NoDescent, projected_gradient);
        } else {
            // Old curvature may mislead: try once more from what is known beforehand.
            memory.forget();
        }
    };
    let Descent { x, value, evaluations, .. } = descent;
    Ok(Minimum { x, value, projected_gradient, steps, evaluations, stop })
}

/// Where the descent stands, and the point it came from or tries.
struct Descent<'b, F> {
    function: F,
    bounds: &'b [(f64, f64)],
    x: Vec<f64>,
    gradient: Vec<f64>,
    value: f64,
    next: Vec<f64>,
    next_gradient: Vec<f64>,
    evaluations: usize,
}

impl<F: FnMut(&[f64], &mut [f64]) -> f64> Descent<'_, F> {
    /// |x − P(x − g / b)| of one variable.
    fn shift(&self, i: usize, b: f64) -> f64 {
        let (low, high) = self.bounds[i];
        (self.x[i] - (self.x[i] - self.gradient[i] / b).clamp(low, high)).abs()
    }

    /// Whether variable i is in the ε-active set.
    fn is_pushed(&self, i: usize, reach: f64) -> bool {
        let (low, high) = self.bounds[i];
        let near = reach.min(1e-3 * (high - low));
        (self.x[i] <= low + near && self.gradient[i] > 0.0) || (self.x[i] >= high - near && self.gradient[i] < 0.0)
    }

    /// Σ gᵢ dᵢ over the free variables.
    fn slope(&self, direction: &[f64], free: &[bool]) -> f64 {
        let of_free = self.gradient.iter().zip(direction).zip(free).filter(|(_, free)| **free);
        of_free.map(|((g, d), _)| g * d).sum()
    }

    /// Near the minimum f changes less than its rounding, and only slopes tell a fall: Armijo's rule put in terms of the
    /// slope at the far end, φ′(α) ≤ −(1 − 2·10⁻⁴) φ′(0). Hager and Zhang, "A new conjugate gradient method with guaranteed
    /// descent and an efficient line search", SIAM J. Optim. 16 (2005), the approximate Wolfe conditions.
    fn falls_below_rounding(&self, value: f64) -> bool {
        let (mut before, mut after) = (0.0, 0.0);
        for i in 0..self.x.len() {
            let step = self.next[i] - self.x[i];
            before += self.gradient[i] * step;
            after += self.next_gradient[i] * step;
        }
        value <= self.value + ROUNDING * self.value.abs() && before < 0.0 && after <= (2e-4 - 1.0) * before
    }

    /// Moves x along the bent path until f falls enough; afterwards `next` is where it came from. False where no step
    /// longer than `least` lowers f.
    fn search(&mut self, direction: &[f64], free: &[bool], first: f64, least: f64) -> bool {
        let slope = self.slope(direction, free);
        let mut alpha = first;
        while alpha > least {
            let mut promised = -alpha * slope;
            for i in 0..self.x.len() {
                let (low, high) = self.bounds[i];
                self.next[i] = (self.x[i] + alpha * direction[i]).clamp(low, high);
                if !free[i] {
                    promised += self.gradient[i] * (self.x[i] - self.next[i]);
                }
            }
            if self.next == self.x {
                return false;
            }
            let value = (self.function)(&self.next, &mut self.next_gradient);
            self.evaluations += 1;
            let falls = value <= self.value - 1e-4 * promised || self.falls_below_rounding(value);
            if falls && self.next_gradient.iter().all(|g| g.is_finite()) {
                self.value = value;
                std::mem::swap(&mut self.x, &mut self.next);
                std::mem::swap(&mut self.gradient, &mut self.next_gradient);
                return true;
            }
            // The minimum of the parabola through f(x), its slope and f(x(α)), kept within reason.
            let parabola = 0.5 * alpha * promised / (value - self.value + promised);
            alpha = if parabola.is_finite() { parabola.clamp(0.1 * alpha, 0.5 * alpha) } else { 0.1 * alpha };
        }
        false
    }
}

fn check(start: &[f64], bounds: &[(f64, f64)], metric: &Metric) -> Result<(), MinimiseError> {
    let expected = start.len();
    let sized = |what, found, expected| {
        if found == expected { Ok(()) } else { Err(MinimiseError::Size { what, expected, found }) }
    };
    sized("bounds", bounds.len(), expected)?;
    match metric {
        Metric::Unknown => {}
        Metric::Diagonal(diagonal) => {
            sized("a diagonal metric", diagonal.len(), expected)?;
            if let Some(variable) = diagonal.iter().position(|entry| !(*entry > 0.0 && entry.is_finite())) {
                return Err(MinimiseError::Metric { variable });
            }
        }
        Metric::Dense(matrix) => sized("a dense metric", matrix.len(), expected * expected)?,
    }
    match bounds.iter().position(|(low, high)| low.is_nan() || high.is_nan() || low > high) {
        None => Ok(()),
        Some(variable) => {
            let (low, high) = bounds[variable];
            Err(MinimiseError::Bounds { variable, low, high })
        }
    }
}
