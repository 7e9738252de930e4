//! A network while it is being trained: its parameters in panels, Adam's moments, one step at a time.

use crate::architecture::{Architecture, Layer, Role};
use crate::network::Parameter;
use crate::product::{Adam, PanelRow, from_panels, into_panels};
use crate::random::{Stream, Use};
use crate::schedule::Step;
use crate::tape::{self, Finish, Rows, Table, Traced, Way};
use crate::training::Loss;
use dfdx::tensor::{Cache, Cpu, CpuError, Gradients, OwnedTape, PutTape, SplitTape, TensorFromVec, Trace};
use dfdx::tensor_ops::Backward;
use pulp::Arch;
use std::rc::Rc;

/// Adam's second decay rate and the number that keeps it from dividing by 0.
const BETA2: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// Trained numbers and what Adam remembers of them.
struct Trained {
    name: String,
    table: Table,
    /// As the table's numbers lie.
    moments: [Vec<PanelRow>; 2],
}

/// A network under training. It lives on one thread, as dfdx's tapes do.
pub(crate) struct Model {
    device: Cpu,
    arch: Arch,
    layers: Vec<Layer>,
    architecture: Architecture,
    /// Weight and bias of each layer in turn.
    trained: Vec<Trained>,
}

/// A part of a batch, standardised, row after row.
pub(crate) struct Part {
    pub rows: usize,
    pub inputs: Vec<f32>,
    pub conditions: Vec<f32>,
    pub targets: Vec<f32>,
}

/// Frees the memory that dfdx keeps for reuse, which it would otherwise leak.
impl Drop for Model {
    fn drop(&mut self) {
        // Fails only if another thread died while it held the lock; this model has one thread.
        let _ = self.device.try_disable_cache();
    }
}

/// The weights of a new network, row-major inputs x outputs, from the seed.
///
/// Each is even in [-l, l] with l = sqrt(3 g / n), where n is the number of inputs of the layer and g the gain: the variance
/// is then g / n. g = 2 before a rectifier (He et al. 2015, Eq. 10); for the layer that closes a block it is divided by the
/// number of blocks, so that depth does not make the sum grow; g = 1 for the outputs. Biases are 0.
pub(crate) fn initial_parameters(architecture: &Architecture, seed: u64) -> Vec<Parameter> {
    let mut parameters = Vec::new();
    for (index, layer) in architecture.layers().into_iter().enumerate() {
        let gain = match layer.role {
            Role::Input | Role::OpenBlock | Role::Head => 2.0,
            Role::CloseBlock => 2.0 / architecture.blocks as f32,
            Role::Output => 1.0,
        };
        let limit = (3.0 * gain / layer.inputs as f32).sqrt();
        let mut stream = Stream::new(seed, Use::Weights, index);
        let values = (0..layer.inputs * layer.outputs).map(|_| limit * (2.0 * stream.unit() - 1.0)).collect();
        parameters.push(Parameter::weight(&layer, values));
        parameters.push(Parameter::bias(&layer, vec![0.0; layer.outputs]));
    }
    parameters
}

impl Model {
    /// A model with the given parameters, and with Adam's moments where training goes on.
    pub fn new(
        architecture: &Architecture,
        parameters: &[Parameter],
        moments: Option<&[[Vec<f32>; 2]]>,
    ) -> Result<Self, CpuError> {
        let device = Cpu::default();
        device.try_enable_cache()?;
        let mut trained = Vec::new();
        for (index, parameter) in parameters.iter().enumerate() {
            let table = Table::new(parameter.rows, parameter.columns, &parameter.values);
            let moments = match moments {
                Some(moments) => [0, 1].map(|which| into_panels(&moments[index][which], parameter.columns)),
                None => [0, 1].map(|_| vec![[0.0; _]; table.values.len()]),
            };
            trained.push(Trained { name: parameter.name.clone(), table, moments });
        }
        let (layers, architecture) = (architecture.layers(), architecture.clone());
        Ok(Self { layers, architecture, trained, device, arch: Arch::new() })
    }

    /// Gives back the memory that dfdx keeps for reuse. Every batch comes in as memory of its own and is kept when it is
    /// let go, so without this the hoard grows by a batch a step.
    pub fn free_spare_memory(&self) -> Result<(), CpuError> {
        self.device.try_empty_cache()
    }

    /// The parameters as plain numbers.
    pub fn parameters(&self) -> Vec<Parameter> {
        let plain = |trained: &Trained| {
            let (rows, columns) = (trained.table.inputs, trained.table.outputs);
            let values = from_panels(&trained.table.values, rows, columns);
            Parameter { name: trained.name.clone(), rows, columns, values }
        };
        self.trained.iter().map(plain).collect()
    }

    /// Adam's moments as plain numbers, for each parameter in order.
    pub fn moments(&self) -> Vec<[Vec<f32>; 2]> {
        let plain = |trained: &Trained| {
            trained.moments.each_ref().map(|own| from_panels(own, trained.table.inputs, trained.table.outputs))
        };
        self.trained.iter().map(plain).collect()
    }

    /// The outputs for a part of a batch, on a tape; `again` tells that earlier parts have left their gradients.
    fn forward(&self, part: &mut Part, mut dropout: Option<&mut Stream>, again: bool) -> Result<Traced, CpuError> {
        let inputs = std::mem::take(&mut part.inputs);
        let inputs = self.device.try_tensor_from_vec(inputs, (part.rows, self.architecture.inputs))?;
        // Gradients of passing tensors pile up in "leaky" gradients, so each part starts with new ones.
        let (inputs, start): (Rows, OwnedTape<f32, Cpu>) = inputs.traced(Gradients::leaky()).split_tape();
        let activation = Some(self.architecture.activation);
        let way = Way { arch: self.arch, again };
        let mut hidden = tape::enter(&inputs, &self.trained[0].table, start, way)?;
        let mut skip = None;
        for (layer, own) in self.layers.iter().zip(self.trained.chunks_exact(2)) {
            let mut finish = Finish { bias: &own[1].table, way, skip: None, activation, dropout: None };
            match layer.role {
                Role::OpenBlock => {
                    let (kept, tape) = hidden.split_tape();
                    skip = Some(kept.clone());
                    hidden = kept.put_tape(tape);
                    let rate = self.architecture.dropout;
                    finish.dropout = dropout
                        .as_mut()
                        .filter(|_| rate > 0.0)
                        .map(|stream| stream.dropout(rate, part.rows * layer.outputs));
                }
                Role::CloseBlock => finish.skip = skip.take(),
                Role::Head if self.architecture.conditions > 0 => {
                    hidden = tape::concatenate(hidden, &part.conditions)?;
                }
                Role::Input | Role::Head => {}
                Role::Output => finish.activation = None,
            }
            if layer.role != Role::Input {
                hidden = tape::multiply(hidden, &own[0].table, way)?;
            }
            hidden = finish.run(hidden)?;
        }
        Ok(hidden)
    }

    /// Takes up the gradient of `weight` times the summed loss of a part of a batch, beside those of earlier parts where
    /// `again` says that there were some; gives that sum.
    pub fn accumulate(
        &mut self,
        mut part: Part,
        again: bool,
        dropout: Option<&mut Stream>,
        (loss, weight): (Loss, f32),
    ) -> Result<f64, CpuError> {
        let outputs = self.forward(&mut part, dropout, again)?;
        let (sum, end) = tape::compare(outputs, &part.targets, loss, weight)?;
        end.try_backward()?;
        Ok(sum)
    }

    /// The gradient of each parameter in order.
    #[cfg(test)]
    pub fn gradients(&self) -> Vec<Vec<f32>> {
        let plain = |trained: &Trained| {
            from_panels(&trained.table.gradient.borrow(), trained.table.inputs, trained.table.outputs)
        };
        self.trained.iter().map(plain).collect()
    }

    /// One step of Adam; `count` steps, this one included, have been made. Stops early, with `false`, when `stop` says so.
    pub fn update(&mut self, step: Step, (count, weight_decay): (usize, f64), stop: impl Fn() -> bool) -> bool {
        let count = i32::try_from(count).unwrap_or(i32::MAX);
        // In single precision throughout, as dfdx's Adam: networks stay what they were but for rounding.
        let betas = [step.beta1, BETA2].map(|beta| beta as f32);
        for Trained { table, moments: [first, second], .. } in &mut self.trained {
            if stop() {
                return false;
            }
            let gradient = table.gradient.borrow();
            let adam = Adam {
                rate: step.learning_rate as f32,
                betas,
                rests: betas.map(|beta| 1.0 - beta),
                corrections: betas.map(|beta| (1.0 - beta.powi(count)).recip()),
                epsilon: EPSILON as f32,
                decay: weight_decay as f32,
                // No tape is left that shares them, so this copies nothing.
                values: Rc::make_mut(&mut table.values).as_flattened_mut(),
                moments: [first.as_flattened_mut(), second.as_flattened_mut()],
                gradient: gradient.as_flattened(),
            };
            adam.run(self.arch);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// m = b1 m + (1 - b1) g, v = b2 v + (1 - b2) g^2, p -= rate (m / (1 - b1^t)) / (sqrt(v / (1 - b2^t)) + epsilon), with
    /// g the gradient plus w p (Kingma and Ba 2015, algorithm 1, with the L2 term in the gradient).
    #[test]
    fn a_step_is_adam_with_coupled_decay() {
        let architecture = Architecture::new(3, 2, 4, 1);
        let parameters = initial_parameters(&architecture, 1);
        let mut model = Model::new(&architecture, &parameters, None).unwrap();
        let double = |values: &Vec<f32>| values.iter().map(|value| f64::from(*value)).collect::<Vec<_>>();
        let mut values: Vec<Vec<f64>> = parameters.iter().map(|parameter| double(&parameter.values)).collect();
        let mut moments: Vec<[Vec<f64>; 2]> =
            values.iter().map(|own| [own, own].map(|own| vec![0.0; own.len()])).collect();
        let (rate, beta1, decay) = (0.01, 0.9, 0.1);
        for count in 1u8..=5 {
            let inputs = vec![0.1 * f32::from(count), -0.7, 0.4, 0.9, 0.2, -0.3];
            let part = Part { rows: 2, inputs, conditions: Vec::new(), targets: vec![1.0, -1.0, 0.5, 0.2] };
            model.accumulate(part, false, None, (Loss::MeanSquared, 0.25)).unwrap();
            let found = model.gradients();
            let step = Step { learning_rate: rate, beta1 };
            assert!(model.update(step, (count.into(), decay), || false));
            for ((own, [first, second]), gradient) in values.iter_mut().zip(&mut moments).zip(&found) {
                for place in 0..own.len() {
                    let g = f64::from(gradient[place]) + decay * own[place];
                    first[place] = beta1 * first[place] + (1.0 - beta1) * g;
                    second[place] = BETA2 * second[place] + (1.0 - BETA2) * g * g;
                    let m = first[place] / (1.0 - beta1.powi(count.into()));
                    let v = second[place] / (1.0 - BETA2.powi(count.into()));
                    own[place] -= rate * m / (v.sqrt() + EPSILON);
                }
            }
        }
        for (parameter, expected) in model.parameters().iter().zip(&values) {
            for (found, expected) in parameter.values.iter().zip(expected) {
                assert!((f64::from(*found) - expected).abs() < 2e-5, "{} {found} {expected}", parameter.name);
            }
        }
    }

    #[test]
    fn first_weights_have_the_variance_of_he() {
        let parameters = initial_parameters(&Architecture::new(400, 10, 300, 2), 3);
        let variance = |index: usize| {
            let values = &parameters[index].values;
            values.iter().map(|value| f64::from(*value).powi(2)).sum::<f64>() / values.len() as f64
        };
        // Input, opening and closing layer of a block (of two), head, output; biases between.
        for (index, expected) in
            [(0, 2.0 / 400.0), (2, 2.0 / 300.0), (4, 1.0 / 300.0), (10, 2.0 / 300.0), (12, 1.0 / 300.0)]
        {
            let ratio = variance(index) / expected;
            assert!((ratio - 1.0).abs() < 0.06, "{}: {ratio}", parameters[index].name);
            assert!(parameters[index + 1].values.iter().all(|bias| *bias == 0.0));
        }
    }
}
