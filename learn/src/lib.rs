//! Run-time configured residual networks: trained on dfdx's tensors and tape, evaluated by an own kernel.
//!
//! The flow through the crate: [`Samples`] (matrices of numbers) are checked and standardised (`scaling`), a network of
//! the given [`Architecture`] is built on dfdx tensors (`model`, with the operations of `tape`), the training loop (`train`)
//! runs it under the settings of [`Training`], and what comes out is a [`Network`]: plain numbers that can be stored,
//! compared and evaluated without dfdx (`predict`, `kernel`).
//!
//! No type of dfdx appears in the public interface, so the tensor package can be replaced behind it. The crate knows
//! neither faces nor graphs: a row is a sample, a column is a feature.
//!
//! Everything is a function of its inputs and the seed. One network trains on one thread and gives the same bits whatever
//! the size of the machine's thread pools; callers that train several networks run them in parallel.
//!
//! ```
//! use learn::{Architecture, Matrix, Samples, Training, train};
//!
//! let inputs = Matrix::from_fn(64, 2, |row, column| (row * (column + 1)) as f32 / 64.0);
//! let targets = Matrix::from_fn(64, 1, |row, _| (row as f32 / 64.0).powi(2));
//! let training = Training { learning_rate: 1e-2, epochs: 50, batch: 16, ..Training::default() };
//! let network = train(&Architecture::new(2, 1, 16, 1), &training, &Samples::new(&inputs, &targets), &())?;
//! let found = network.predict(&inputs, None)?;
//! assert!((found.row(32)[0] - 0.25).abs() < 0.05);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod architecture;
mod autoencoder;
mod checkpoint;
mod error;
#[cfg(test)]
mod gradient_check;
mod kernel;
mod matrix;
mod model;
mod network;
mod observe;
mod predict;
mod product;
mod random;
mod samples;
mod scaling;
mod schedule;
mod tape;
mod train;
mod training;

pub use architecture::{Activation, Architecture};
pub use autoencoder::{Autoencoder, AutoencoderTraining, train_autoencoder};
pub use checkpoint::Checkpoint;
pub use error::{MatrixError, NetworkError, PredictError, Table, TrainError};
pub use matrix::Matrix;
pub use network::{Network, Parameter};
pub use observe::{EpochReport, Observer};
pub use samples::Samples;
pub use scaling::Scaling;
pub use schedule::Schedule;
pub use train::{resume, train};
pub use training::{Loss, TargetScale, Training};
