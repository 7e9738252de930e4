//! The state of a training run between two epochs: all that is needed to go on as if it had never stopped.

use crate::architecture::Architecture;
use crate::error::TrainError;
use crate::network::Parameter;
use crate::training::Training;
use serde::{Deserialize, Serialize};

/// A training run after some whole epochs. [`crate::resume`] goes on from it, to the same bits that an uninterrupted run
/// gives on this machine. The samples are not kept; the same ones must be given again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    pub(crate) architecture: Architecture,
    pub(crate) training: Training,
    pub(crate) epochs_done: usize,
    /// [`crate::samples::Samples::fingerprint`] of the samples it was made with.
    pub(crate) samples: u64,
    pub(crate) parameters: Vec<Parameter>,
    /// Adam's running mean of the gradient and of its square, for each parameter in order.
    pub(crate) moments: Vec<[Vec<f32>; 2]>,
}

impl Checkpoint {
    /// Epochs that are done.
    pub fn epochs_done(&self) -> usize {
        self.epochs_done
    }

    /// What is being trained.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// How it is trained.
    pub fn training(&self) -> &Training {
        &self.training
    }

    /// Tells whether the parts fit each other and the samples with this fingerprint.
    pub(crate) fn check(&self, samples: u64) -> Result<(), TrainError> {
        let refuse = |reason: String| Err(TrainError::Checkpoint { reason });
        if samples != self.samples {
            return refuse("it was made with other samples".into());
        }
        if self.epochs_done > self.training.epochs {
            return refuse(format!("it says {} of {} epochs are done", self.epochs_done, self.training.epochs));
        }
        if let Err(error) = crate::network::check_parameters(&self.architecture, &self.parameters) {
            return refuse(error.to_string());
        }
        if self.moments.len() != self.parameters.len() {
            return refuse(format!(
                "it has moments for {} of {} parameters",
                self.moments.len(),
                self.parameters.len()
            ));
        }
        for (parameter, moments) in self.parameters.iter().zip(&self.moments) {
            let good = |moment: &Vec<f32>| {
                moment.len() == parameter.values.len() && moment.iter().all(|value| value.is_finite())
            };
            if !moments.iter().all(good) {
                return refuse(format!("the moments of parameter {} are damaged", parameter.name));
            }
        }
        Ok(())
    }
}
