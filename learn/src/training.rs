//! How a network is trained: step sizes and how they change, batches, epochs, what is made small.

use crate::error::TrainError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The settings of a training run. The defaults are those of the FDLS supplement (section 8) for the jaw.
///
/// The optimiser is Adam (Kingma and Ba 2015) with beta1 = 0.9, beta2 = 0.999 and epsilon = 1e-8. The last batch of an
/// epoch holds what is left; it may be smaller than the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Training {
    /// The step size of Adam where the schedule has its peak; positive.
    #[schemars(range(min = 1e-12, max = 10.0))]
    pub learning_rate: f64,
    /// How the step size changes over the training.
    pub schedule: Schedule,
    /// The L2 coefficient w: w times each parameter is added to its gradient before Adam's moments are formed (coupled, as
    /// `weight_decay` of `PyTorch`'s Adam, not `AdamW`). It holds for weights and biases alike. 0 = none.
    #[schemars(range(min = 0.0))]
    pub weight_decay: f64,
    /// Samples a step; at least 1.
    #[schemars(range(min = 1))]
    pub batch: usize,
    /// How often every sample is seen; at least 1.
    #[schemars(range(min = 1))]
    pub epochs: usize,
    /// Where all random numbers come from: initial weights, the order of samples, dropout.
    pub seed: u64,
    /// What is made small.
    pub loss: Loss,
    /// How targets are standardised, and so how their columns weigh against each other in the loss.
    pub target_scale: TargetScale,
    /// The smallest scale of an input column, as a fraction of the root mean square of all columns' standard deviations.
    /// Columns that vary less than that are not blown up to unit variance. 0 or more.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub input_floor: f32,
}

impl Default for Training {
    fn default() -> Self {
        Self {
            learning_rate: 1e-4,
            schedule: Schedule::Constant,
            weight_decay: 1e-5,
            batch: 64,
            epochs: 300,
            seed: 0,
            loss: Loss::MeanSquared,
            target_scale: TargetScale::Common,
            input_floor: 0.01,
        }
    }
}

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
}

/// What is made small, over all values of a batch. e is the difference of a standardised prediction and target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Loss {
    /// The mean of e^2.
    #[default]
    MeanSquared,
    /// The mean of |e|: less drawn by outliers.
    MeanAbsolute,
    /// The mean of e^2 / 2 where |e| is at most `delta`, else of delta (|e| - delta / 2) (Huber 1964).
    Huber {
        /// Where the square becomes a line, in standard deviations of the targets; positive.
        delta: f32,
    },
}

impl Loss {
    /// The loss of one difference and its derivative.
    pub(crate) fn of(self, difference: f32) -> (f32, f32) {
        let size = difference.abs();
        match self {
            Self::MeanSquared => (difference * difference, 2.0 * difference),
            Self::MeanAbsolute if size == 0.0 => (0.0, 0.0),
            Self::MeanAbsolute => (size, difference.signum()),
            Self::Huber { delta } if size <= delta => (0.5 * difference * difference, difference),
            Self::Huber { delta } => (delta * (size - 0.5 * delta), delta * difference.signum()),
        }
    }
}

/// What the columns of the targets are divided by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TargetScale {
    /// One number for all: an error counts the same in every column, as in the plain regression loss of FDLS.
    #[default]
    Common,
    /// Each its own standard deviation: a column that moves little weighs as much as one that moves a lot.
    PerColumn,
}

/// Adam's second decay rate and the number that keeps it from dividing by 0.
pub(crate) const BETA2: f64 = 0.999;
pub(crate) const EPSILON: f64 = 1e-8;
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

impl Training {
    /// Step size and beta1 of step `step` (from 0) of `steps`.
    pub(crate) fn step(&self, step: usize, steps: usize) -> Step {
        let peak = self.learning_rate;
        let (now, last) = (step as f64, steps.saturating_sub(1) as f64);
        match self.schedule {
            Schedule::Constant => Step { learning_rate: peak, beta1: BETA1 },
            Schedule::Cosine { warm_up, last: fraction } => {
                let rise = (warm_up * steps as f64).floor();
                let learning_rate = if now < rise {
                    peak * (now + 1.0) / (rise + 1.0)
                } else {
                    cosine(peak, peak * fraction, (now - rise) / (last - rise).max(1.0))
                };
                Step { learning_rate, beta1: BETA1 }
            }
            Schedule::OneCycle { rise, start_divisor, end_divisor, cycle_momentum } => {
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

    /// Tells whether every field holds what it may.
    ///
    /// # Errors
    /// [`TrainError::Setting`] with the first field that does not.
    pub fn check(&self) -> Result<(), TrainError> {
        let finite = |value: f64| value.is_finite();
        let mut rules = vec![
            ("training.learning_rate", self.learning_rate, self.learning_rate > 0.0, "above 0"),
            ("training.weight_decay", self.weight_decay, self.weight_decay >= 0.0, "0 or more"),
            ("training.batch", self.batch as f64, self.batch >= 1, "1 or more"),
            ("training.epochs", self.epochs as f64, self.epochs >= 1, "1 or more"),
            ("training.input_floor", f64::from(self.input_floor), self.input_floor >= 0.0, "0 or more"),
        ];
        match self.schedule {
            Schedule::Constant => {}
            Schedule::Cosine { warm_up, last } => {
                rules.push(("schedule.warm_up", warm_up, (0.0..1.0).contains(&warm_up), "0 or more and below 1"));
                rules.push(("schedule.last", last, (0.0..=1.0).contains(&last), "from 0 to 1"));
            }
            Schedule::OneCycle { rise, start_divisor, end_divisor, .. } => {
                rules.push(("schedule.rise", rise, rise > 0.0 && rise < 1.0, "above 0 and below 1"));
                rules.push(("schedule.start_divisor", start_divisor, start_divisor >= 1.0, "1 or more"));
                rules.push(("schedule.end_divisor", end_divisor, end_divisor >= 1.0, "1 or more"));
            }
        }
        if let Loss::Huber { delta } = self.loss {
            rules.push(("loss.delta", f64::from(delta), delta > 0.0, "above 0"));
        }
        let broken = rules.into_iter().find(|(_, value, holds, _)| !holds || !finite(*value));
        broken.map_or(Ok(()), |(setting, value, _, allowed)| Err(TrainError::Setting { setting, value, allowed }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates(schedule: Schedule, steps: usize) -> Vec<f64> {
        let training = Training { learning_rate: 1e-3, schedule, ..Training::default() };
        (0..steps).map(|step| training.step(step, steps).learning_rate).collect()
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
        let training = Training { schedule: Schedule::one_cycle(), ..Training::default() };
        assert!((training.step(0, 100).beta1 - 0.95).abs() < 1e-12);
        assert!((training.step(29, 100).beta1 - 0.85).abs() < 1e-12);
        assert!((training.step(99, 100).beta1 - 0.95).abs() < 1e-12);
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

    #[test]
    fn losses_have_their_slopes() {
        for loss in [Loss::MeanSquared, Loss::MeanAbsolute, Loss::Huber { delta: 0.5 }] {
            for difference in [-2.0f32, -0.3, 0.2, 1.7] {
                let step = 1e-3;
                let numeric = (loss.of(difference + step).0 - loss.of(difference - step).0) / (2.0 * step);
                assert!((numeric - loss.of(difference).1).abs() < 1e-3, "{loss:?} at {difference}");
            }
        }
    }

    #[test]
    fn fields_left_out_are_the_usual_ones() {
        let read = |text: &str| serde_json::from_str::<Training>(text).unwrap();
        assert_eq!(read("{}"), Training::default());
        assert_eq!(read(r#"{"schedule":{"one_cycle":{}}}"#).schedule, Schedule::one_cycle());
        assert_eq!(read(r#"{"schedule":{"cosine":{}}}"#).schedule, Schedule::cosine());
        assert!(serde_json::from_str::<Training>(r#"{"epoch":3}"#).is_err(), "a misspelt field must not pass");
    }

    #[test]
    fn settings_out_of_range_are_named() {
        let error = Training { batch: 0, ..Training::default() }.check().unwrap_err();
        assert_eq!(error.to_string(), "training.batch is 0, which cannot be used: it must be 1 or more");
        let error = Training { learning_rate: f64::NAN, ..Training::default() }.check().unwrap_err();
        assert!(error.to_string().contains("learning_rate"), "{error}");
        let schedule = Schedule::OneCycle { rise: 1.0, start_divisor: 25.0, end_divisor: 1e4, cycle_momentum: false };
        assert!(Training { schedule, ..Training::default() }.check().is_err());
    }
}
