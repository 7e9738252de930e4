//! The training loop: epochs, batches, reports, checkpoints. It drives a `model` and ends in a `network`.

use crate::architecture::Architecture;
use crate::checkpoint::Checkpoint;
use crate::error::TrainError;
use crate::model::{Model, Part, initial_parameters};
use crate::network::{Network, Parameter, Scalings};
use crate::observe::{EpochReport, Observer};
use crate::random::{Stream, Use};
use crate::samples::Samples;
use crate::scaling::Scaling;
use crate::training::Training;
use dfdx::tensor::CpuError;

/// Steps after which memory that was let go is given back: rare enough to cost nothing, often enough to keep the hoard
/// below a hundred megabytes.
const STEPS_BETWEEN_TIDYING: usize = 32;

/// Trains a new network.
///
/// Runs on the calling thread alone. The same arguments give the same bits; train several networks in parallel by calling
/// this from several threads.
///
/// # Errors
/// See [`TrainError`]: settings out of range, tables that do not fit, values that are not finite, a loss that diverged,
/// cancellation, lack of memory.
pub fn train(
    architecture: &Architecture,
    training: &Training,
    samples: &Samples<'_>,
    observer: &dyn Observer,
) -> Result<Network, TrainError> {
    architecture.check()?;
    training.check()?;
    samples.check(architecture)?;
    Run::new(architecture, training, samples, observer).go(None)
}

/// Goes on with a training run from a checkpoint, with the samples it was begun with. The network has the same bits as
/// that of an uninterrupted run on this machine.
///
/// # Errors
/// [`TrainError::Checkpoint`] when the samples are others or the checkpoint is damaged, else as [`train`].
pub fn resume(checkpoint: &Checkpoint, samples: &Samples<'_>, observer: &dyn Observer) -> Result<Network, TrainError> {
    checkpoint.architecture.check()?;
    checkpoint.training.check()?;
    samples.check(&checkpoint.architecture)?;
    checkpoint.check(samples.fingerprint())?;
    Run::new(&checkpoint.architecture, &checkpoint.training, samples, observer).go(Some(checkpoint))
}

/// One multiplication and addition each: what is done between two looks at the observer, about 50 ms of work.
const WORK_BETWEEN_LOOKS: usize = 2_500_000_000;

/// A training run: what is trained, on what, and the samples standardised.
struct Run<'a> {
    architecture: &'a Architecture,
    training: &'a Training,
    samples: &'a Samples<'a>,
    observer: &'a dyn Observer,
    scalings: Scalings,
    inputs: Vec<f32>,
    conditions: Vec<f32>,
    targets: Vec<f32>,
}

impl<'a> Run<'a> {
    fn new(
        architecture: &'a Architecture,
        training: &'a Training,
        samples: &'a Samples<'a>,
        observer: &'a dyn Observer,
    ) -> Self {
        let conditions = samples.conditions;
        let features = |matrix, floors| Scaling::of_features(matrix, training.input_floor, floors);
        let scalings = Scalings {
            inputs: features(samples.inputs, samples.input_floors),
            conditions: conditions.map_or_else(Scaling::default, |matrix| features(matrix, None)),
            targets: Scaling::of_targets(samples.targets, training.target_scale),
        };
        Self {
            architecture,
            training,
            samples,
            observer,
            inputs: scalings.inputs.standardise_all(samples.inputs),
            conditions: conditions.map_or_else(Vec::new, |matrix| scalings.conditions.standardise_all(matrix)),
            targets: scalings.targets.standardise_all(samples.targets),
            scalings,
        }
    }

    /// How many batches an epoch has.
    fn batches(&self) -> usize {
        self.samples.inputs.rows().div_ceil(self.training.batch)
    }

    /// Rows that are computed between two looks at the observer: the whole batch unless the network is very large.
    fn part_rows(&self) -> usize {
        let work = 3 * self.architecture.parameter_count();
        (WORK_BETWEEN_LOOKS / work).clamp(8, self.training.batch.max(8))
    }

    /// Trains, from the checkpoint if there is one.
    fn go(&self, from: Option<&Checkpoint>) -> Result<Network, TrainError> {
        let mut model = self.model(from)?;
        let epochs = self.training.epochs;
        let mut order: Vec<usize> = (0..self.samples.inputs.rows()).collect();
        for epoch in from.map_or(0, Checkpoint::epochs_done)..epochs {
            order.sort_unstable();
            Stream::new(self.training.seed, Use::Order, epoch).shuffle(&mut order);
            let mut sum = 0.0;
            for (batch, rows) in order.chunks(self.training.batch).enumerate() {
                sum += self.batch(&mut model, epoch, batch, rows)?;
            }
            let last = (epoch + 1) * self.batches() - 1;
            let report = EpochReport {
                epoch: epoch + 1,
                epochs,
                loss: sum / self.targets.len() as f64,
                learning_rate: self.training.step(last, epochs * self.batches()).learning_rate,
            };
            self.observer.epoch(&report);
            if report.epoch < epochs && self.observer.wants_checkpoint(&report) {
                self.observer.checkpoint(&self.checkpoint(&model, report.epoch));
            }
        }
        let parameters = model.parameters();
        self.refuse_broken(&parameters)?;
        Ok(Network::trained(self.architecture.clone(), self.scalings.clone(), parameters))
    }

    /// A model at the start or at the checkpoint.
    fn model(&self, from: Option<&Checkpoint>) -> Result<Model, TrainError> {
        let model = match from {
            None => {
                let parameters = initial_parameters(self.architecture, self.training.seed);
                Model::new(self.architecture, &parameters, None)
            }
            Some(checkpoint) => Model::new(self.architecture, &checkpoint.parameters, Some(&checkpoint.moments)),
        };
        model.map_err(|error| self.tensor_error(error))
    }

    /// One step: the gradient of the batch's mean loss, then Adam. Gives the sum of the loss over the batch's values.
    fn batch(&self, model: &mut Model, epoch: usize, batch: usize, rows: &[usize]) -> Result<f64, TrainError> {
        let epochs = self.training.epochs;
        let index = epoch * self.batches() + batch;
        let step = self.training.step(index, epochs * self.batches());
        let cancelled = TrainError::Cancelled { epoch: epoch + 1, epochs };
        let tensor_error = |error| self.tensor_error(error);

        let mut dropout = Stream::new(self.training.seed, Use::Dropout, index);
        let values = (rows.len() * self.architecture.outputs) as f32;
        let mut sum = 0.0;
        for (place, part) in rows.chunks(self.part_rows()).enumerate() {
            if self.observer.cancelled() {
                return Err(cancelled);
            }
            let loss = (self.training.loss, 1.0 / values);
            sum += model.accumulate(self.part(part), place > 0, Some(&mut dropout), loss).map_err(tensor_error)?;
        }
        if !sum.is_finite() {
            let loss = sum / f64::from(values);
            let learning_rate = step.learning_rate;
            return Err(TrainError::Diverged { epoch: epoch + 1, batch: batch + 1, loss, learning_rate });
        }
        let settings = (index + 1, self.training.weight_decay);
        if !model.update(step, settings, || self.observer.cancelled()) {
            return Err(cancelled);
        }
        if index.is_multiple_of(STEPS_BETWEEN_TIDYING) {
            model.free_spare_memory().map_err(tensor_error)?;
        }
        Ok(sum)
    }

    /// The standardised samples of some rows.
    fn part(&self, rows: &[usize]) -> Part {
        let gather = |values: &[f32], columns: usize| {
            let mut gathered = Vec::with_capacity(rows.len() * columns);
            for row in rows {
                gathered.extend_from_slice(&values[row * columns..(row + 1) * columns]);
            }
            gathered
        };
        Part {
            rows: rows.len(),
            inputs: gather(&self.inputs, self.architecture.inputs),
            conditions: gather(&self.conditions, self.architecture.conditions),
            targets: gather(&self.targets, self.architecture.outputs),
        }
    }

    fn checkpoint(&self, model: &Model, epochs_done: usize) -> Checkpoint {
        Checkpoint {
            architecture: self.architecture.clone(),
            training: self.training.clone(),
            epochs_done,
            samples: self.samples.fingerprint(),
            parameters: model.parameters(),
            moments: model.moments(),
        }
    }

    /// The last step of all is seen by no later loss, so the parameters are looked at.
    fn refuse_broken(&self, parameters: &[Parameter]) -> Result<(), TrainError> {
        let broken = parameters.iter().flat_map(|parameter| &parameter.values).find(|value| !value.is_finite());
        broken.map_or(Ok(()), |value| {
            let (epoch, batch) = (self.training.epochs, self.batches());
            let learning_rate = self.training.step(epoch * batch - 1, epoch * batch).learning_rate;
            Err(TrainError::Diverged { epoch, batch, loss: f64::from(*value), learning_rate })
        })
    }

    /// The sizes of all tensors are checked before, so dfdx has but one way to fail.
    fn tensor_error(&self, error: CpuError) -> TrainError {
        match error {
            CpuError::OutOfMemory | CpuError::WrongNumElements => {
                TrainError::OutOfMemory { parameters: self.architecture.parameter_count(), batch: self.training.batch }
            }
        }
    }
}
