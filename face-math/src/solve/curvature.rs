//! What L-BFGS knows of the curvature: the pairs of its last steps, and the metric given beforehand. [`super::minimise()`]
//! says how the two make a direction.

use super::minimise::{Metric, MinimiseError};
use std::collections::VecDeque;

/// The last steps and what the gradient did over them.
pub(super) struct Memory {
    pairs: VecDeque<(Vec<f64>, Vec<f64>)>,
    capacity: usize,
}

impl Memory {
    pub(super) fn new(capacity: usize) -> Self {
        Self { pairs: VecDeque::new(), capacity }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    pub(super) fn forget(&mut self) {
        self.pairs.clear();
    }

    /// Keeps the pair of a step, where f curves upwards along it.
    pub(super) fn remember(&mut self, x: &[f64], next: &[f64], gradient: &[f64], next_gradient: &[f64]) {
        let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>();
        let (s, y) = (difference(next, x), difference(next_gradient, gradient));
        if self.capacity > 0 && dot(&s, &y) > 1e-10 * (dot(&s, &s) * dot(&y, &y)).sqrt() {
            if self.pairs.len() == self.capacity {
                self.pairs.pop_front();
            }
            self.pairs.push_back((s, y));
        }
    }

    /// −H g on the free variables, −g / diag B₀ on the held ones.
    pub(super) fn direction(&self, gradient: &[f64], inner: &Inner<'_>, direction: &mut [f64]) {
        let free = &inner.free;
        let over_free = |a: &[f64], b: &[f64]| -> f64 {
            a.iter().zip(b).zip(free).filter(|(_, free)| **free).map(|((a, b), _)| a * b).sum()
        };
        for i in 0..gradient.len() {
            direction[i] = if free[i] { gradient[i] } else { 0.0 };
        }
        let curved = |(s, y): &(Vec<f64>, Vec<f64>)| {
            let sy = over_free(s, y);
            (sy > 1e-10 * (over_free(s, s) * over_free(y, y)).sqrt()).then_some(sy)
        };
        let mut passed = Vec::with_capacity(self.pairs.len());
        for pair in self.pairs.iter().rev() {
            let Some(sy) = curved(pair) else { continue };
            let along = over_free(&pair.0, direction) / sy;
            for i in 0..direction.len() {
                direction[i] -= if free[i] { along * pair.1[i] } else { 0.0 };
            }
            passed.push((pair, sy, along));
        }
        inner.solve(direction);
        if let Some(((_, y), sy, _)) = passed.first() {
            let mut scaled = y.clone();
            inner.solve(&mut scaled);
            let gamma = sy / over_free(y, &scaled);
            for d in direction.iter_mut() {
                *d *= gamma;
            }
        }
        for ((s, y), sy, along) in passed.iter().rev() {
            let back = along - over_free(y, direction) / sy;
            for i in 0..direction.len() {
                direction[i] += if free[i] { back * s[i] } else { 0.0 };
            }
        }
        for i in 0..gradient.len() {
            direction[i] = if free[i] { -direction[i] } else { -gradient[i] / inner.diagonal(i) };
        }
    }
}

/// B₀ on the free variables.
pub(super) struct Inner<'m> {
    metric: &'m Metric,
    pub(super) free: Vec<bool>,
    /// Cholesky factor of a dense metric's free rows and columns, for the current free variables.
    factor: Option<Factor>,
}

struct Factor {
    rows: Vec<usize>,
    lower: Vec<f64>,
}

impl<'m> Inner<'m> {
    pub(super) fn new(metric: &'m Metric, size: usize) -> Self {
        Self { metric, free: vec![true; size], factor: None }
    }

    /// Sets who is free, and factors the metric for them where that changed.
    pub(super) fn hold(&mut self, is_free: impl Fn(usize) -> bool) -> Result<(), MinimiseError> {
        let mut changed = false;
        for (i, free) in self.free.iter_mut().enumerate() {
            let now = is_free(i);
            changed |= *free != now;
            *free = now;
        }
        let Metric::Dense(matrix) = self.metric else { return Ok(()) };
        if !changed && self.factor.is_some() {
            return Ok(());
        }
        let size = self.free.len();
        let rows: Vec<usize> = (0..size).filter(|i| self.free[*i]).collect();
        let count = rows.len();
        let mut lower = vec![0.0; count * count];
        for i in 0..count {
            for j in 0..=i {
                let entry = matrix[rows[i] * size + rows[j]];
                let rest = entry - dot(&lower[i * count..i * count + j], &lower[j * count..j * count + j]);
                lower[i * count + j] = if i > j {
                    rest / lower[j * count + j]
                } else if rest > 0.0 && rest.is_finite() {
                    rest.sqrt()
                } else {
                    return Err(MinimiseError::Metric { variable: rows[i] });
                };
            }
        }
        self.factor = Some(Factor { rows, lower });
        Ok(())
    }

    /// The diagonal of B₀.
    pub(super) fn diagonal(&self, i: usize) -> f64 {
        match self.metric {
            Metric::Unknown => 1.0,
            Metric::Diagonal(diagonal) => diagonal[i],
            Metric::Dense(matrix) => matrix[i * self.free.len() + i],
        }
    }

    /// Replaces v by B₀⁻¹ v on the free variables; the others become 0.
    fn solve(&self, v: &mut [f64]) {
        for (v, free) in v.iter_mut().zip(&self.free) {
            *v = if *free { *v } else { 0.0 };
        }
        match (self.metric, &self.factor) {
            (Metric::Diagonal(diagonal), _) => v.iter_mut().zip(diagonal).for_each(|(v, d)| *v /= d),
            (_, Some(Factor { rows, lower })) => {
                let count = rows.len();
                let mut packed: Vec<f64> = rows.iter().map(|row| v[*row]).collect();
                for i in 0..count {
                    let rest = packed[i] - dot(&lower[i * count..i * count + i], &packed[..i]);
                    packed[i] = rest / lower[i * count + i];
                }
                for i in (0..count).rev() {
                    packed[i] /= lower[i * count + i];
                    let settled = packed[i];
                    for j in 0..i {
                        packed[j] -= lower[i * count + j] * settled;
                    }
                }
                rows.iter().zip(packed).for_each(|(row, solved)| v[*row] = solved);
            }
            _ => {}
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
