//! A trained network: plain numbers that can be stored, compared and evaluated. The end of the crate's flow.

use crate::architecture::{Architecture, Layer};
use crate::error::{NetworkError, PredictError, Table};
use crate::matrix::Matrix;
use crate::predict::Prepared;
use crate::scaling::Scaling;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// One trained table of numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// The layer's name and `weight` or `bias`: `input.weight`, `block0.open.bias`, `head.weight`, `output.bias`.
    pub name: String,
    /// Inputs of the layer; 1 for a bias.
    pub rows: usize,
    /// Outputs of the layer.
    pub columns: usize,
    /// `rows * columns` values, row after row.
    pub values: Vec<f32>,
}

impl Parameter {
    /// A layer's weight from `inputs` x `outputs` values.
    pub(crate) fn weight(layer: &Layer, values: Vec<f32>) -> Self {
        Self { name: format!("{}.weight", layer.name), rows: layer.inputs, columns: layer.outputs, values }
    }

    /// A layer's bias.
    pub(crate) fn bias(layer: &Layer, values: Vec<f32>) -> Self {
        Self { name: format!("{}.bias", layer.name), rows: 1, columns: layer.outputs, values }
    }

    /// Name and shape for people.
    fn describe(&self) -> String {
        format!("{} ({} x {}, {} values)", self.name, self.rows, self.columns, self.values.len())
    }
}

/// The standardisations of the three tables.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Scalings {
    pub inputs: Scaling,
    pub conditions: Scaling,
    pub targets: Scaling,
}

/// A trained network: architecture, standardisation and parameters. Equal networks have equal bits; what is derived for
/// speed is not stored and not compared.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Parts")]
pub struct Network {
    architecture: Architecture,
    scalings: Scalings,
    parameters: Vec<Parameter>,
    #[serde(skip)]
    prepared: OnceLock<Prepared>,
}

/// A stored network before it is checked.
#[derive(Deserialize)]
struct Parts {
    architecture: Architecture,
    scalings: Scalings,
    parameters: Vec<Parameter>,
}

impl TryFrom<Parts> for Network {
    type Error = NetworkError;

    fn try_from(parts: Parts) -> Result<Self, NetworkError> {
        let Parts { architecture, scalings, parameters } = parts;
        architecture.check().map_err(NetworkError::Architecture)?;
        let tables = [
            (Table::Inputs, &scalings.inputs, architecture.inputs),
            (Table::Conditions, &scalings.conditions, architecture.conditions),
            (Table::Targets, &scalings.targets, architecture.outputs),
        ];
        for (table, scaling, expected) in tables {
            if !scaling.fits(expected) {
                return Err(NetworkError::Scaling { table, found: scaling.mean.len(), expected });
            }
        }
        check_parameters(&architecture, &parameters)?;
        Ok(Self::trained(architecture, scalings, parameters))
    }
}

/// Tells whether the parameters are those of the architecture, in order, and finite.
pub(crate) fn check_parameters(architecture: &Architecture, parameters: &[Parameter]) -> Result<(), NetworkError> {
    let layers = architecture.layers();
    let wanted: Vec<Parameter> = layers
        .iter()
        .flat_map(|layer| [Parameter::weight(layer, Vec::new()), Parameter::bias(layer, Vec::new())])
        .collect();
    for index in 0..wanted.len().max(parameters.len()) {
        let shape = |parameter: &Parameter| (parameter.name.clone(), parameter.rows, parameter.columns);
        let (found, expected) = (parameters.get(index), wanted.get(index));
        let fits = found.is_some_and(|found| found.values.len() == found.rows * found.columns);
        if !fits || found.map(shape) != expected.map(shape) {
            let found = found.map_or("missing".into(), Parameter::describe);
            let expected = expected
                .map_or("nothing".into(), |wanted| format!("{} ({} x {})", wanted.name, wanted.rows, wanted.columns));
            return Err(NetworkError::Parameter { index, found, expected });
        }
    }
    for parameter in parameters {
        if let Some(index) = parameter.values.iter().position(|value| !value.is_finite()) {
            let value = parameter.values[index];
            return Err(NetworkError::NonFinite { name: parameter.name.clone(), index, value });
        }
    }
    Ok(())
}

impl PartialEq for Network {
    fn eq(&self, other: &Self) -> bool {
        self.architecture == other.architecture
            && self.scalings == other.scalings
            && self.parameters == other.parameters
    }
}

impl Network {
    /// A network from parts that are known to fit.
    pub(crate) fn trained(architecture: Architecture, scalings: Scalings, parameters: Vec<Parameter>) -> Self {
        Self { architecture, scalings, parameters, prepared: OnceLock::new() }
    }

    /// The network's shape.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// The trained numbers in forward order: weight and bias of each layer.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// How a table's columns are standardised; empty for conditions where there are none.
    pub fn scaling(&self, table: Table) -> &Scaling {
        match table {
            Table::Inputs => &self.scalings.inputs,
            Table::Conditions => &self.scalings.conditions,
            Table::Targets => &self.scalings.targets,
        }
    }

    /// The outputs for each row of `inputs`, in the unit of the training targets: rows x `Architecture::outputs`.
    ///
    /// Dropout is not applied. Runs on the calling thread; a row's result has the same bits whatever other rows are
    /// predicted with it, so a take may be cut into blocks at will.
    ///
    /// # Errors
    /// See [`PredictError`]: tables that do not fit, values that are not finite or overflow.
    pub fn predict(&self, inputs: &Matrix, conditions: Option<&Matrix>) -> Result<Matrix, PredictError> {
        self.check(inputs, conditions)?;
        let prepared = self.prepared.get_or_init(|| Prepared::new(&self.architecture, &self.parameters));
        let matrix = prepared.predict(&self.scalings, inputs, conditions);
        match matrix.first_non_finite() {
            Some((row, column, value)) => Err(PredictError::Overflow { row, column, value }),
            None => Ok(matrix),
        }
    }

    /// Tells whether the tables have the network's columns, equal rows and finite numbers only.
    fn check(&self, inputs: &Matrix, conditions: Option<&Matrix>) -> Result<(), PredictError> {
        let tables = [
            (Table::Inputs, Some(inputs), self.architecture.inputs),
            (Table::Conditions, conditions, self.architecture.conditions),
        ];
        for (table, matrix, expected) in tables {
            let found = matrix.map_or(0, Matrix::columns);
            if found != expected {
                return Err(PredictError::Columns { table, found, expected });
            }
            let Some(matrix) = matrix else { continue };
            if matrix.rows() != inputs.rows() {
                return Err(PredictError::Rows { found: matrix.rows(), expected: inputs.rows() });
            }
            if let Some((row, column, value)) = matrix.first_non_finite() {
                return Err(PredictError::NonFinite { table, row, column, value });
            }
        }
        Ok(())
    }
}
