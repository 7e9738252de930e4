//! Trains the networks of all regions side by side: the costliest first, so that none is left alone at the end. Reports how
//! far they are, stops when asked to, and keeps what is needed to go on after a cook was cut short.

use super::Settled;
use crate::solve::solving::columns;
use crate::values::{RegionNetwork, TrainingRecord};
use face_math::data::{Curves, Region, RegionFeatures};
use graph_core::node::{Context, NodeError};
use learn::{Architecture, Checkpoint, EpochReport, Matrix, Network, Observer, Samples, TrainError, Training};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use wire::{Decoder, Encoder};

/// One network to train.
pub(in crate::solve) struct Job<'a> {
    pub region: &'a Region,
    pub features: &'a RegionFeatures,
    /// Channels that condition it; empty where none do.
    pub conditions: Vec<String>,
    pub architecture: Architecture,
    pub training: Training,
}

impl<'a> Job<'a> {
    /// A job under the settings `settled`; `shared` holds what is the same for all regions.
    pub fn new(
        region: &'a Region,
        features: &'a RegionFeatures,
        conditions: Vec<String>,
        settled: &Settled,
        shared: (&Training, learn::Activation),
    ) -> Self {
        let architecture = Architecture {
            conditions: conditions.len(),
            dropout: settled.dropout,
            activation: shared.1,
            ..Architecture::new(features.width, region.channels.len(), settled.width, settled.blocks)
        };
        let training = Training {
            learning_rate: settled.learning_rate,
            weight_decay: settled.weight_decay,
            batch: settled.batch,
            epochs: settled.epochs,
            ..shared.0.clone()
        };
        Self { region, features, conditions, architecture, training }
    }

    /// Bytes that training takes: parameters, their gradients and two moments of Adam; features as they come and scaled.
    fn bytes(&self) -> usize {
        let numbers = 4 * self.architecture.parameter_count() + 2 * self.features.values.len();
        numbers * size_of::<f32>()
    }

    /// What an epoch costs, roughly: trained numbers times samples.
    fn epoch_cost(&self) -> f64 {
        let samples = self.features.values.len() / self.features.width.max(1);
        self.architecture.parameter_count() as f64 * samples as f64
    }
}

/// Trains all `jobs` on `curves`, frame for frame beside their features. The networks come in the order of the jobs.
///
/// # Errors
/// That of the first region in that order that cannot be trained, or cancellation.
pub(in crate::solve) fn train_all(
    context: &Context<'_>,
    curves: &Curves,
    jobs: &[Job<'_>],
    checkpoint_every: Duration,
) -> Result<Vec<RegionNetwork>, NodeError> {
    let hall = Hall {
        context,
        curves,
        jobs,
        checkpoint_every,
        stop: AtomicBool::new(false),
        board: Mutex::new(jobs.iter().map(|_| Standing::default()).collect()),
    };
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    let whole = |job: &Job<'_>| job.epoch_cost() * job.training.epochs as f64;
    order.sort_by(|a, b| whole(&jobs[*b]).total_cmp(&whole(&jobs[*a])));
    let done: Vec<Mutex<Option<Result<RegionNetwork, NodeError>>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    rayon::scope_fifo(|scope| {
        for index in order {
            let (hall, done) = (&hall, &done);
            scope.spawn_fifo(move |_| {
                let outcome = hall.train(index);
                if outcome.is_err() {
                    hall.stop.store(true, Ordering::Relaxed);
                }
                *locked(&done[index]) = Some(outcome);
            });
        }
    });
    let mut networks = Vec::with_capacity(jobs.len());
    let mut cancelled = false;
    for slot in done {
        match slot.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(Ok(network)) => networks.push(network),
            // Where one region fails, the others are cancelled: that one is told.
            Some(Err(NodeError::Cancelled)) | None => cancelled = true,
            Some(Err(error)) => return Err(error),
        }
    }
    if cancelled { Err(NodeError::Cancelled) } else { Ok(networks) }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What all jobs share while they run.
struct Hall<'a> {
    context: &'a Context<'a>,
    curves: &'a Curves,
    jobs: &'a [Job<'a>],
    checkpoint_every: Duration,
    /// Set when a region has failed: the others need not go on.
    stop: AtomicBool,
    board: Mutex<Vec<Standing>>,
}

/// How far a region is.
#[derive(Default)]
struct Standing {
    epochs: usize,
    loss: Option<f64>,
}

impl Hall<'_> {
    fn train(&self, index: usize) -> Result<RegionNetwork, NodeError> {
        self.context.go_on()?;
        let job = &self.jobs[index];
        self.context.claim("width", job.bytes())?;
        if let Some(done) = self.finished(job) {
            self.report(index, done.training.losses.len(), done.training.losses.last().copied());
            return Ok(done);
        }
        let wrong = |error: &dyn std::fmt::Display| NodeError::failed(format!("region `{}`: {error}", job.region.name));
        let rows = self.curves.frames();
        let inputs =
            Matrix::new(rows, job.features.width, job.features.values.clone()).map_err(|error| wrong(&error))?;
        let targets = columns(self.curves, &job.region.channels).map_err(|error| wrong(&error))?;
        let conditions = columns(self.curves, &job.conditions).map_err(|error| wrong(&error))?;
        let conditions = (!job.conditions.is_empty()).then_some(&conditions);
        let samples = Samples { conditions, ..Samples::new(&inputs, &targets) };
        let watch = Watch { hall: self, index, losses: Mutex::new(Vec::new()), saved: Mutex::new(Instant::now()) };
        let network = watch.train(&samples).map_err(|error| match error {
            TrainError::Cancelled { .. } => NodeError::Cancelled,
            other => wrong(&other),
        })?;
        let network = RegionNetwork {
            region: job.region.name.clone(),
            markers: job.features.markers.clone(),
            sets: job.features.sets.clone(),
            channels: job.region.channels.clone(),
            conditions: job.conditions.clone(),
            network,
            training: TrainingRecord {
                samples: rows,
                losses: watch.losses.into_inner().unwrap_or_else(PoisonError::into_inner),
            },
        };
        let mut state = Encoder::default();
        state.record(&(&job.training, &network));
        self.context.save_checkpoint(&finished_name(job), &state.finish());
        Ok(network)
    }

    /// The network of a region that was finished before the cook was cut short.
    fn finished(&self, job: &Job<'_>) -> Option<RegionNetwork> {
        let state = self.context.checkpoint(&finished_name(job))?;
        let (training, network): (Training, RegionNetwork) = Decoder::new(&state).record().ok()?;
        let same = training == job.training
            && network.network.architecture() == &job.architecture
            && network.markers == job.features.markers
            && network.sets == job.features.sets
            && network.channels == job.region.channels
            && network.conditions == job.conditions
            && network.training.samples == self.curves.frames();
        same.then_some(network)
    }

    /// Tells how far all regions are together, with their losses.
    fn report(&self, index: usize, epochs: usize, loss: Option<f64>) {
        let mut board = locked(&self.board);
        board[index] = Standing { epochs, loss };
        let (mut done, mut whole, mut losses, mut weight) = (0.0, 0.0, 0.0, 0.0);
        for (job, standing) in self.jobs.iter().zip(&*board) {
            done += job.epoch_cost() * standing.epochs as f64;
            whole += job.epoch_cost() * job.training.epochs as f64;
            if let Some(loss) = standing.loss {
                losses += loss * job.region.channels.len() as f64;
                weight += job.region.channels.len() as f64;
            }
        }
        let mut numbers = vec![("loss", losses / f64::max(weight, 1.0))];
        numbers
            .extend(self.jobs.iter().zip(&*board).filter_map(|(job, own)| Some((job.region.name.as_str(), own.loss?))));
        self.context.progress(done / whole, &numbers);
    }
}

fn finished_name(job: &Job<'_>) -> String {
    format!("{}.done", job.region.name)
}

/// Follows the training of one region.
struct Watch<'a> {
    hall: &'a Hall<'a>,
    index: usize,
    losses: Mutex<Vec<f64>>,
    saved: Mutex<Instant>,
}

impl Watch<'_> {
    fn job(&self) -> &Job<'_> {
        &self.hall.jobs[self.index]
    }

    /// Goes on from a checkpoint where there is a good one, else begins.
    fn train(&self, samples: &Samples<'_>) -> Result<Network, TrainError> {
        let job = self.job();
        if let Some((losses, checkpoint)) = self.begun() {
            *locked(&self.losses) = losses;
            match learn::resume(&checkpoint, samples, self) {
                Err(TrainError::Checkpoint { .. }) => locked(&self.losses).clear(),
                outcome => return outcome,
            }
        }
        learn::train(&job.architecture, &job.training, samples, self)
    }

    /// The state from which an earlier cook of this very node can go on.
    fn begun(&self) -> Option<(Vec<f64>, Checkpoint)> {
        let job = self.job();
        let state = self.hall.context.checkpoint(&job.region.name)?;
        let (losses, checkpoint): (Vec<f64>, Checkpoint) = Decoder::new(&state).record().ok()?;
        let same = checkpoint.architecture() == &job.architecture
            && checkpoint.training() == &job.training
            && checkpoint.epochs_done() == losses.len();
        same.then_some((losses, checkpoint))
    }
}

impl Observer for Watch<'_> {
    fn epoch(&self, report: &EpochReport) {
        locked(&self.losses).push(report.loss);
        self.hall.report(self.index, report.epoch, Some(report.loss));
    }

    fn cancelled(&self) -> bool {
        self.hall.context.cancelled() || self.hall.stop.load(Ordering::Relaxed)
    }

    fn wants_checkpoint(&self, _: &EpochReport) -> bool {
        locked(&self.saved).elapsed() >= self.hall.checkpoint_every
    }

    fn checkpoint(&self, checkpoint: &Checkpoint) {
        let mut state = Encoder::default();
        state.record(&(&*locked(&self.losses), checkpoint));
        self.hall.context.save_checkpoint(&self.job().region.name, &state.finish());
        *locked(&self.saved) = Instant::now();
    }
}
