//! What can go wrong, with the facts that are needed to mend it. Used by every other file of the crate.

use std::fmt;
use thiserror::Error;

/// Which of the tables of a call an error speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// The features that enter the first layer.
    Inputs,
    /// The values that are concatenated after the residual blocks.
    Conditions,
    /// The values that the network shall give.
    Targets,
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Inputs => "inputs",
            Self::Conditions => "conditions",
            Self::Targets => "targets",
        })
    }
}

/// A matrix whose size and values do not fit.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MatrixError {
    /// The number of values is not the number of places.
    #[error("a matrix of {rows} x {columns} cannot be made of {values} values; give exactly rows times columns")]
    Size {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        columns: usize,
        /// Values given.
        values: usize,
    },
    /// Rows of different length.
    #[error("row {row} has {found} values where row 0 has {expected}; make all rows equally long")]
    Ragged {
        /// The first row that differs, counted from 0.
        row: usize,
        /// Its length.
        found: usize,
        /// The length of row 0.
        expected: usize,
    },
}

/// Why no network was trained.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TrainError {
    /// A setting outside what it may be.
    #[error("{setting} is {value}, which cannot be used: it must be {allowed}")]
    Setting {
        /// The field's name, such as `training.batch`.
        setting: &'static str,
        /// What it holds.
        value: f64,
        /// What it may hold.
        allowed: &'static str,
    },
    /// A table with a number of columns that the architecture does not have.
    #[error("the {table} have {found} columns but the architecture has {expected}; make the two agree")]
    Columns {
        /// Which table.
        table: Table,
        /// Its columns.
        found: usize,
        /// The architecture's.
        expected: usize,
    },
    /// Tables with different numbers of rows.
    #[error(
        "the {table} have {found} rows but the inputs have {expected}; each row must be the same sample in all tables"
    )]
    Rows {
        /// Which table.
        table: Table,
        /// Its rows.
        found: usize,
        /// Rows of the inputs.
        expected: usize,
    },
    /// Nothing to learn from.
    #[error("there are no samples to train on; give at least one row")]
    NoSamples,
    /// NaN or infinity in a table.
    #[error("row {row}, column {column} of the {table} is {value}; fill or drop that sample before training")]
    NonFinite {
        /// Which table.
        table: Table,
        /// Row from 0.
        row: usize,
        /// Column from 0.
        column: usize,
        /// The value.
        value: f32,
    },
    /// The smallest meaningful spreads of the inputs are not one positive number a column.
    #[error(
        "the smallest spreads of the inputs must be {expected} finite numbers of 0 or more, one a column; there are {found}{}",
        column.map_or(String::new(), |column| format!(" and number {column} is not one"))
    )]
    InputFloors {
        /// How many were given.
        found: usize,
        /// Columns of the inputs.
        expected: usize,
        /// The first bad one, if the count is right.
        column: Option<usize>,
    },
    /// The loss left the finite numbers.
    #[error(
        "training diverged: the loss is {loss} in epoch {epoch}, batch {batch} (learning rate {learning_rate:.3e}); \
         lower the learning rate, or rise to it slowly with a schedule that warms up"
    )]
    Diverged {
        /// Epoch from 1.
        epoch: usize,
        /// Batch within it, from 1.
        batch: usize,
        /// The loss: NaN or infinite (or finite, when the last update made a parameter non-finite).
        loss: f64,
        /// The learning rate of that batch.
        learning_rate: f64,
    },
    /// The observer asked to stop.
    #[error("training was cancelled in epoch {epoch} of {epochs}")]
    Cancelled {
        /// The epoch that was under way, from 1.
        epoch: usize,
        /// Epochs asked for.
        epochs: usize,
    },
    /// A checkpoint that does not belong to these samples, or is damaged.
    #[error("the checkpoint cannot be resumed: {reason}; train from the start instead")]
    Checkpoint {
        /// What does not fit.
        reason: String,
    },
    /// The tensors did not fit in memory.
    #[error(
        "out of memory while training a network of {parameters} parameters with batches of {batch}; lower the width or the batch"
    )]
    OutOfMemory {
        /// Parameters of the network.
        parameters: usize,
        /// Rows of a batch.
        batch: usize,
    },
}

/// Why a network gave no prediction.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PredictError {
    /// A table with a number of columns that the network was not trained for.
    #[error(
        "the {table} have {found} columns but the network was trained with {expected}; give it the features it was trained on"
    )]
    Columns {
        /// Which table.
        table: Table,
        /// Its columns (0 when it is missing).
        found: usize,
        /// The network's.
        expected: usize,
    },
    /// Inputs and conditions with different numbers of rows.
    #[error(
        "the conditions have {found} rows but the inputs have {expected}; each row must be the same sample in both"
    )]
    Rows {
        /// Rows of the conditions.
        found: usize,
        /// Rows of the inputs.
        expected: usize,
    },
    /// NaN or infinity in a table.
    #[error("row {row}, column {column} of the {table} is {value}; fill that sample before predicting")]
    NonFinite {
        /// Which table.
        table: Table,
        /// Row from 0.
        row: usize,
        /// Column from 0.
        column: usize,
        /// The value.
        value: f32,
    },
    /// An input so far from all that was seen in training that the numbers overflowed.
    #[error(
        "the prediction for row {row}, output {column} is {value}: the inputs of that row lie far outside what the network was \
         trained on; check their units"
    )]
    Overflow {
        /// Row from 0.
        row: usize,
        /// Column of the output from 0.
        column: usize,
        /// The value.
        value: f32,
    },
}

/// Why stored parts do not make a network.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NetworkError {
    /// The architecture itself cannot be.
    #[error("the stored architecture is not valid: {0}")]
    Architecture(TrainError),
    /// A parameter is missing, misnamed or of another shape.
    #[error(
        "parameter {index} is {found} where the architecture needs {expected}; the stored network is damaged or of another version"
    )]
    Parameter {
        /// Which, from 0, in forward order.
        index: usize,
        /// Name and shape found.
        found: String,
        /// Name and shape needed.
        expected: String,
    },
    /// A parameter holds NaN or infinity.
    #[error("value {index} of parameter {name} is {value}; the stored network is damaged")]
    NonFinite {
        /// The parameter.
        name: String,
        /// Which value, from 0.
        index: usize,
        /// The value.
        value: f32,
    },
    /// A standardisation that does not fit the architecture.
    #[error(
        "the standardisation of the {table} has {found} columns where the architecture has {expected}, or a scale that is not positive"
    )]
    Scaling {
        /// Which table.
        table: Table,
        /// Columns found.
        found: usize,
        /// Columns needed.
        expected: usize,
    },
}
