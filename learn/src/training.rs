//! How a network is trained: step sizes and how they change, batches, epochs, what is made small.

use crate::error::TrainError;
use crate::schedule::{Schedule, Step};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

/// A setting's name, its value, whether it may be that, and what it may be.
pub(crate) type Rule = (&'static str, f64, bool, &'static str);

impl Training {
    /// Step size and beta1 of step `step` (from 0) of `steps`.
    pub(crate) fn step(&self, step: usize, steps: usize) -> Step {
        self.schedule.step(self.learning_rate, step, steps)
    }

    /// Tells whether every field holds what it may.
    ///
    /// # Errors
    /// [`TrainError::Setting`] with the first field that does not.
    pub fn check(&self) -> Result<(), TrainError> {
        let finite = |value: f64| value.is_finite();
        let mut rules: Vec<Rule> = vec![
            ("training.learning_rate", self.learning_rate, self.learning_rate > 0.0, "above 0"),
            ("training.weight_decay", self.weight_decay, self.weight_decay >= 0.0, "0 or more"),
            ("training.batch", self.batch as f64, self.batch >= 1, "1 or more"),
            ("training.epochs", self.epochs as f64, self.epochs >= 1, "1 or more"),
            ("training.input_floor", f64::from(self.input_floor), self.input_floor >= 0.0, "0 or more"),
        ];
        rules.extend(self.schedule.rules());
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
