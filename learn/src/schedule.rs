//! How the step size of the optimiser, and with it the first decay rate, change over a training run.

use crate::training::Rule;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// How the step size changes from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Schedule {
    /// It stays what it is.
    #[default]
    Constant,
    /// A straight rise, then half a cosine down.
    Cosine {
        /// The part of all steps that the rise takes; 0 or more, below 1.
        #[serde(default = "usual::warm_up")]
        warm_up: f64,
        /// The step size at the end, as a fraction of the peak; 0 to 1.
        #[serde(default = "usual::last")]
        last: f64,
    },
    /// Half a cosine up, half a cosine down to almost nothing (`OneCycleLR` of `PyTorch`; Smith and Topin 2018).
    OneCycle {
        /// The part of all steps that the rise takes; above 0 and below 1. `PyTorch`: 0.3.
        #[serde(default = "usual::rise")]
        rise: f64,
        /// The first step size is the peak divided by this; 1 or more. `PyTorch`: 25.
        #[serde(default = "usual::start_divisor")]
        start_divisor: f64,
        /// The last step size is the first divided by this; 1 or more. `PyTorch`: 10,000.
        #[serde(default = "usual::end_divisor")]
        end_divisor: f64,
        /// Whether beta1 of Adam falls from 0.95 to 0.85 while the step size rises, and rises again while it falls.
        #[serde(default = "usual::cycle_momentum")]
        cycle_momentum: bool,
    },
}

/// What the fields of a schedule are where they are left out.
mod usual {
    pub fn warm_up() -> f64 {
        0.05
    }
    pub fn last() -> f64 {
        0.01
    }
    pub fn rise() -> f64 {
        0.3
    }
    pub fn start_divisor() -> f64 {
        25.0
    }
    pub fn end_divisor() -> f64 {
        1e4
    }
    pub fn cycle_momentum() -> bool {
        true
    }
}

/// Adam's first decay rate where it is not cycled, and its range where it is.
const BETA1: f64 = 0.9;
const BETA1_RANGE: (f64, f64) = (0.85, 0.95);

/// What Adam takes in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Step {
    pub learning_rate: f64,
    pub beta1: f64,
}

/// From `start` (at fraction 0) to `end` (at 1) along half a cosine.
fn cosine(start: f64, end: f64, fraction: f64) -> f64 {
    end + (start - end) * 0.5 * (1.0 + (PI * fraction).cos())
}

impl Schedule {
    /// A rise over the first twentieth of all steps, then half a cosine down to a hundredth of the peak.
    pub fn cosine() -> Self {
        Self::Cosine { warm_up: usual::warm_up(), last: usual::last() }
    }

    /// One cycle with `PyTorch`'s settings.
    pub fn one_cycle() -> Self {
        Self::OneCycle {
            rise: usual::rise(),
            start_divisor: usual::start_divisor(),
            end_divisor: usual::end_divisor(),
            cycle_momentum: usual::cycle_momentum(),
        }
    }

    /// Step size and beta1 of step `step` (from 0) of `steps`; `peak` is the largest step size.
    pub(crate) fn step(self, peak: f64, step: usize, steps: usize) -> Step {
        let (now, last) = (step as f64, steps.saturating_sub(1) as f64);
        match self {
            Self::Constant => Step { learning_rate: peak, beta1: BETA1 },
            Self::Cosine { warm_up, last: fraction } => {
                let rise = (warm_up * steps as f64).floor();
                let learning_rate = if now < rise {
                    peak * (now + 1.0) / (rise + 1.0)
                } else {
                    cosine(peak, peak * fraction, (now - rise) / (last - rise).max(1.0))
                };
                Step { learning_rate, beta1: BETA1 }
            }
            Self::OneCycle { rise, start_divisor, end_divisor, cycle_momentum } => {
                let first = peak / start_divisor;
                let top = (rise * steps as f64 - 1.0).clamp(0.0, last);
                let (fraction, rising) = if now <= top && top > 0.0 {
                    (now / top, true)
                } else {
                    ((now - top) / (last - top).max(1.0), false)
                };
                let (low, high) = if cycle_momentum { BETA1_RANGE } else { (BETA1, BETA1) };
                if rising {
                    Step { learning_rate: cosine(first, peak, fraction), beta1: cosine(high, low, fraction) }
                } else {
                    let learning_rate = cosine(peak, first / end_divisor, fraction);
                    Step { learning_rate, beta1: cosine(low, high, fraction) }
                }
            }
        }
    }

    /// The rules that its fields must obey.
    pub(crate) fn rules(self) -> Vec<Rule> {
        match self {
            Self::Constant => Vec::new(),
            Self::Cosine { warm_up, last } => vec![
                ("schedule.warm_up", warm_up, (0.0..1.0).contains(&warm_up), "0 or more and below 1"),
                ("schedule.last", last, (0.0..=1.0).contains(&last), "from 0 to 1"),
            ],
            Self::OneCycle { rise, start_divisor, end_divisor, .. } => vec![
                ("schedule.rise", rise, rise > 0.0 && rise < 1.0, "above 0 and below 1"),
                ("schedule.start_divisor", start_divisor, start_divisor >= 1.0, "1 or more"),
                ("schedule.end_divisor", end_divisor, end_divisor >= 1.0, "1 or more"),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates(schedule: Schedule, steps: usize) -> Vec<f64> {
        (0..steps).map(|step| schedule.step(1e-3, step, steps).learning_rate).collect()
    }

    #[test]
    fn one_cycle_is_that_of_pytorch() {
        // torch.optim.lr_scheduler.OneCycleLR(max_lr=1e-3, total_steps=10) ends its phases at steps 2 and 9:
        // step 0 is 1e-3 / 25, step 2 is 1e-3, step 9 is 1e-3 / 25 / 1e4, with half cosines between.
        let rates = rates(Schedule::one_cycle(), 10);
        let half = |from: f64, to: f64, part: f64| to + (from - to) / 2.0 * (1.0 + (PI * part).cos());
        let expected: Vec<f64> = (0..10)
            .map(|step| match step {
                0..=2 => half(4e-5, 1e-3, f64::from(step) / 2.0),
                _ => half(1e-3, 4e-9, (f64::from(step) - 2.0) / 7.0),
            })
            .collect();
        for (rate, expected) in rates.iter().zip(&expected) {
            assert!((rate - expected).abs() < 1e-15, "{rates:?} is not {expected:?}");
        }
        assert!((rates[0] - 4e-5).abs() < 1e-12 && (rates[2] - 1e-3).abs() < 1e-12 && (rates[9] - 4e-9).abs() < 1e-15);
    }

    #[test]
    fn momentum_runs_against_the_rate() {
        let beta1 = |step| Schedule::one_cycle().step(1e-4, step, 100).beta1;
        assert!((beta1(0) - 0.95).abs() < 1e-12);
        assert!((beta1(29) - 0.85).abs() < 1e-12);
        assert!((beta1(99) - 0.95).abs() < 1e-12);
    }

    #[test]
    fn cosine_rises_and_falls() {
        let rates = rates(Schedule::Cosine { warm_up: 0.1, last: 0.01 }, 100);
        assert!(rates[..11].windows(2).all(|pair| pair[0] < pair[1]));
        assert!(rates[10..].windows(2).all(|pair| pair[0] > pair[1]));
        assert!((rates[10] - 1e-3).abs() < 1e-12 && (rates[99] - 1e-5).abs() < 1e-12);
    }

    #[test]
    fn shortest_trainings_have_finite_rates() {
        for schedule in [Schedule::one_cycle(), Schedule::Cosine { warm_up: 0.9, last: 0.0 }, Schedule::Constant] {
            for steps in 1..5 {
                let rates = rates(schedule, steps);
                assert!(
                    rates.iter().all(|rate| rate.is_finite() && *rate >= 0.0 && *rate <= 1e-3 + 1e-12),
                    "{rates:?}"
                );
            }
        }
    }
}
