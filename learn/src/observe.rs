//! How a training run speaks with its caller: progress out, cancellation in, checkpoints out.

use crate::checkpoint::Checkpoint;

/// What is known at the end of an epoch.
#[derive(Clone, Debug, PartialEq)]
pub struct EpochReport {
    /// Epochs done, so from 1.
    pub epoch: usize,
    /// Epochs asked for.
    pub epochs: usize,
    /// The mean loss over the epoch's samples, with dropout, as the parameters were when each batch came. It is that of
    /// standardised targets: with the mean squared loss, 1 is what a network that gives the targets' means would have.
    pub loss: f64,
    /// The step size of the last batch.
    pub learning_rate: f64,
}

/// Follows a training run. All methods are called from the one thread that trains, the caller's.
/// `()` is an observer that asks for nothing.
pub trait Observer: Sync {
    /// Called at the end of every epoch.
    fn epoch(&self, _report: &EpochReport) {}

    /// Asked before every batch, and within large ones: whether to stop. Then [`crate::train()`] returns
    /// [`crate::TrainError::Cancelled`].
    fn cancelled(&self) -> bool {
        false
    }

    /// Asked at the end of every epoch but the last: whether a checkpoint is wanted now. One costs a copy of three times
    /// the network's size.
    fn wants_checkpoint(&self, _report: &EpochReport) -> bool {
        false
    }

    /// Gives the checkpoint that was wanted.
    fn checkpoint(&self, _checkpoint: &Checkpoint) {}
}

impl Observer for () {}
