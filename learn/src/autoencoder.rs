//! An autoencoder that keeps rest exactly at rest, trained with LAMB (section A.4 of Animatomy); plain numbers, no tape.
//!
//! With g a network of two narrowing and two widening layers, γ the values (strains), θ conditions (the jaw's pose), both 0
//! at rest:
//!
//! ```text
//! AE(γ, θ) = g(γ, θ) − g(0, 0)          L = mean over samples and values of ((AE(γ, θ) − γ) / s)²
//! ```
//!
//! so that AE(0, 0) = 0 whatever the weights. s is the root mean square of all values. g is h₁ = tanh(W₁ [γ/s; θ/c] + b₁),
//! z = W₂ h₁ + b₂ (the latent), h₂ = tanh(W₃ z + b₃), g = s (W₄ h₂ + b₄).
//!
//! LAMB (You et al. 2020, algorithm 2), for each layer's weights x with Adam's moments m̂ and v̂:
//!
//! ```text
//! r = m̂ / (√v̂ + ε) + λ x,      x ← x − η · φ(‖x‖) / ‖r‖ · r,      φ(n) = n within 0.05 … 10
//! ```

use crate::error::TrainError;
use crate::matrix::Matrix;
use crate::random::{Stream, Use};
use crate::schedule::Schedule;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How an autoencoder is built and trained.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AutoencoderTraining {
    /// Nodes of the layers before and after the latent.
    #[schemars(range(min = 1, max = 4096))]
    pub hidden: usize,
    /// Numbers that a face is squeezed into.
    #[schemars(range(min = 1, max = 4096))]
    pub latent: usize,
    /// How often every sample is seen.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub epochs: usize,
    /// Samples a step.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub batch: usize,
    /// The peak step size of LAMB: the share of a layer's size by which a step changes it.
    #[schemars(range(min = 1e-9, max = 1.0))]
    pub learning_rate: f64,
    /// Draws weights towards 0.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub weight_decay: f64,
    /// Where all random numbers come from.
    pub seed: u64,
}

impl Default for AutoencoderTraining {
    fn default() -> Self {
        Self { hidden: 128, latent: 32, epochs: 200, batch: 64, learning_rate: 0.01, weight_decay: 1e-4, seed: 0 }
    }
}

/// A fully connected layer: `weights` is inputs × outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Dense {
    inputs: usize,
    outputs: usize,
    weights: Vec<f64>,
    bias: Vec<f64>,
}

/// A trained autoencoder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Autoencoder {
    values: usize,
    conditions: usize,
    scale: f64,
    condition_scales: Vec<f64>,
    layers: Vec<Dense>,
}

impl Dense {
    fn new(inputs: usize, outputs: usize, random: &mut Stream) -> Self {
        let reach = (6.0 / (inputs + outputs) as f64).sqrt();
        let weights = (0..inputs * outputs).map(|_| reach * (2.0 * f64::from(random.unit()) - 1.0)).collect();
        Self { inputs, outputs, weights, bias: vec![0.0; outputs] }
    }

    fn forward(&self, rows: &[f64]) -> Vec<f64> {
        let mut out = Vec::with_capacity(rows.len() / self.inputs * self.outputs);
        for row in rows.chunks_exact(self.inputs) {
            let first = out.len();
            out.extend_from_slice(&self.bias);
            let own = &mut out[first..];
            for (value, weights) in row.iter().zip(self.weights.chunks_exact(self.outputs)) {
                for (sum, weight) in own.iter_mut().zip(weights) {
                    *sum += value * weight;
                }
            }
        }
        out
    }

    /// The gradient by the inputs, from that by the outputs.
    fn back(&self, slopes: &[f64]) -> Vec<f64> {
        let rows = slopes.chunks_exact(self.outputs);
        rows.flat_map(|slope| {
            self.weights
                .chunks_exact(self.outputs)
                .map(move |weights| weights.iter().zip(slope).map(|(w, s)| w * s).sum::<f64>())
        })
        .collect()
    }

    /// Adds the gradient by weights and bias.
    fn gradient(&self, inputs: &[f64], slopes: &[f64], weights: &mut [f64], bias: &mut [f64]) {
        for (row, slope) in inputs.chunks_exact(self.inputs).zip(slopes.chunks_exact(self.outputs)) {
            for (value, weights) in row.iter().zip(weights.chunks_exact_mut(self.outputs)) {
                for (sum, slope) in weights.iter_mut().zip(slope) {
                    *sum += value * slope;
                }
            }
            bias.iter_mut().zip(slope).for_each(|(sum, slope)| *sum += slope);
        }
    }
}

/// Whether a layer is followed by tanh.
const BENT: [bool; 4] = [true, false, true, false];

impl Autoencoder {
    /// Values a sample: what goes in and comes out.
    pub fn values(&self) -> usize {
        self.values
    }

    /// How many trained numbers it has.
    pub fn parameter_count(&self) -> usize {
        self.layers.iter().map(|layer| layer.weights.len() + layer.bias.len()).sum()
    }

    /// Conditions a sample.
    pub fn conditions(&self) -> usize {
        self.conditions
    }

    /// Inputs of g, standardised, with a row of rest behind.
    fn inputs(&self, values: &[f64], conditions: &[f64]) -> Vec<f64> {
        let rows = values.len() / self.values;
        let mut inputs = Vec::with_capacity((rows + 1) * (self.values + self.conditions));
        for row in 0..rows {
            inputs.extend(values[row * self.values..(row + 1) * self.values].iter().map(|value| value / self.scale));
            let own = &conditions[row * self.conditions..(row + 1) * self.conditions];
            inputs.extend(own.iter().zip(&self.condition_scales).map(|(value, scale)| value / scale));
        }
        inputs.resize(inputs.len() + self.values + self.conditions, 0.0);
        inputs
    }

    /// What goes into each layer, and what comes out of the last.
    fn forward(&self, inputs: Vec<f64>) -> Vec<Vec<f64>> {
        let mut all = vec![inputs];
        for (layer, bent) in self.layers.iter().zip(BENT) {
            let mut out = layer.forward(&all[all.len() - 1]);
            if bent {
                for value in &mut out {
                    *value = value.tanh();
                }
            }
            all.push(out);
        }
        all
    }

    /// AE for rows of values and conditions, laid one after the other.
    ///
    /// # Panics
    /// Where the rows do not have the sizes of this network.
    pub fn reconstruct(&self, values: &[f64], conditions: &[f64]) -> Vec<f64> {
        let all = self.forward(self.inputs(values, conditions));
        let out = &all[all.len() - 1];
        let (rows, rest) = out.split_at(values.len());
        rows.chunks_exact(self.values).flat_map(|row| row.iter().zip(rest).map(|(a, b)| self.scale * (a - b))).collect()
    }

    /// The gradient by the values of Σ `by` · AE.
    ///
    /// # Panics
    /// Where the rows do not have the sizes of this network.
    pub fn pull_back(&self, values: &[f64], conditions: &[f64], by: &[f64]) -> Vec<f64> {
        let all = self.forward(self.inputs(values, conditions));
        // Rest does not move with the values.
        let mut slopes: Vec<f64> = by.iter().map(|slope| self.scale * slope).collect();
        slopes.resize(by.len() + self.values, 0.0);
        for at in (0..self.layers.len()).rev() {
            bend(BENT[at], &all[at + 1], &mut slopes);
            slopes = self.layers[at].back(&slopes);
        }
        let rows = slopes.chunks_exact(self.values + self.conditions).take(by.len() / self.values);
        rows.flat_map(|row| row[..self.values].iter().map(|slope| slope / self.scale)).collect()
    }
}

/// Takes slopes back through tanh, whose outputs are `out`.
fn bend(bent: bool, out: &[f64], slopes: &mut [f64]) {
    if bent {
        slopes.iter_mut().zip(out).for_each(|(slope, out)| *slope *= 1.0 - out * out);
    }
}

/// One tensor under LAMB.
struct Lamb {
    first: Vec<f64>,
    second: Vec<f64>,
}

impl Lamb {
    fn step(&mut self, tensor: &mut [f64], gradient: &[f64], (rate, decay, count): (f64, f64, i32)) {
        const BETA: [f64; 2] = [0.9, 0.999];
        let correct = BETA.map(|beta| 1.0 - beta.powi(count));
        let mut direction = Vec::with_capacity(tensor.len());
        for (((m, v), slope), x) in self.first.iter_mut().zip(&mut self.second).zip(gradient).zip(tensor.iter()) {
            *m = BETA[0] * *m + (1.0 - BETA[0]) * slope;
            *v = BETA[1] * *v + (1.0 - BETA[1]) * slope * slope;
            direction.push(*m / correct[0] / ((*v / correct[1]).sqrt() + 1e-8) + decay * x);
        }
        let norm = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>().sqrt();
        let length = norm(&direction);
        let trust = if length > 0.0 { norm(tensor).clamp(0.05, 10.0) / length } else { 0.0 };
        tensor.iter_mut().zip(direction).for_each(|(x, r)| *x -= rate * trust * r);
    }
}

/// Trains an autoencoder on rows of values under conditions. After each epoch `go_on` is told its number and the loss
/// (1 is what giving 0 for everything would have) and says whether to train on.
///
/// # Errors
/// Where a table is empty, rows differ in number, something is not finite, or `go_on` says no.
pub fn train_autoencoder(
    training: &AutoencoderTraining,
    values: &Matrix,
    conditions: &Matrix,
    mut go_on: impl FnMut(usize, f64) -> bool,
) -> Result<(Autoencoder, Vec<f64>), TrainError> {
    let wrong =
        |setting: &'static str, value: f64, allowed: &'static str| TrainError::Setting { setting, value, allowed };
    if values.rows() == 0 || values.columns() == 0 {
        return Err(wrong("the number of samples", values.rows() as f64, "1 or more, of 1 value or more"));
    }
    if conditions.rows() != values.rows() {
        return Err(wrong("the number of rows of conditions", conditions.rows() as f64, "that of the values"));
    }
    if let Some((row, ..)) = values.first_non_finite().or(conditions.first_non_finite()) {
        return Err(wrong("the row of a value that is not finite", row as f64, "finite"));
    }
    for (setting, value) in [
        ("hidden", training.hidden),
        ("latent", training.latent),
        ("epochs", training.epochs),
        ("batch", training.batch),
    ] {
        if value == 0 {
            return Err(wrong(setting, 0.0, "1 or more"));
        }
    }
    let rms = |values: &mut dyn Iterator<Item = f32>| {
        let (mut sum, mut count) = (0.0, 0.0_f64);
        values.for_each(|value| (sum, count) = (sum + f64::from(value).powi(2), count + 1.0));
        let rms = (sum / count.max(1.0)).sqrt();
        if rms > 0.0 { rms } else { 1.0 }
    };
    let mut random = Stream::new(training.seed, Use::Weights, 0);
    let ends = values.columns() + conditions.columns();
    let widths = [ends, training.hidden, training.latent, training.hidden, values.columns()];
    let mut network = Autoencoder {
        values: values.columns(),
        conditions: conditions.columns(),
        scale: rms(&mut values.values().iter().copied()),
        condition_scales: (0..conditions.columns())
            .map(|column| rms(&mut conditions.iter_rows().map(|row| row[column])))
            .collect(),
        layers: widths.windows(2).map(|pair| Dense::new(pair[0], pair[1], &mut random)).collect(),
    };
    let moments = |size: usize| Lamb { first: vec![0.0; size], second: vec![0.0; size] };
    let mut lambs: Vec<[Lamb; 2]> =
        network.layers.iter().map(|layer| [moments(layer.weights.len()), moments(layer.bias.len())]).collect();
    let (mut order, mut losses, mut count) = ((0..values.rows()).collect::<Vec<_>>(), Vec::new(), 0);
    let steps = training.epochs * values.rows().div_ceil(training.batch);
    for epoch in 0..training.epochs {
        Stream::new(training.seed, Use::Order, epoch).shuffle(&mut order);
        let mut sum = 0.0;
        for batch in order.chunks(training.batch) {
            let rows = |matrix: &Matrix| -> Vec<f64> {
                batch.iter().flat_map(|row| matrix.row(*row)).map(|value| f64::from(*value)).collect()
            };
            let rate = Schedule::cosine().step(training.learning_rate, count, steps).learning_rate;
            count += 1;
            sum +=
                network.step(&mut lambs, &rows(values), &rows(conditions), (rate, training.weight_decay, count as i32));
        }
        losses.push(sum / values.values().len() as f64);
        if !go_on(epoch, losses[epoch]) {
            return Err(TrainError::Cancelled { epoch: epoch + 1, epochs: training.epochs });
        }
    }
    Ok((network, losses))
}

/// The gradients by a layer's weights and by its bias.
type LayerGradient = (Vec<f64>, Vec<f64>);

impl Autoencoder {
    /// One step of LAMB on a batch; gives the sum of squared standardised differences before it.
    fn step(&mut self, lambs: &mut [[Lamb; 2]], values: &[f64], conditions: &[f64], how: (f64, f64, i32)) -> f64 {
        let (loss, gradients) = self.gradients(values, conditions);
        for ((layer, lambs), (weights, bias)) in self.layers.iter_mut().zip(lambs).zip(gradients) {
            lambs[0].step(&mut layer.weights, &weights, how);
            lambs[1].step(&mut layer.bias, &bias, (how.0, 0.0, how.2));
        }
        loss
    }

    /// The sum of squared standardised differences, and the gradients of their mean by each layer's weights and bias.
    fn gradients(&self, values: &[f64], conditions: &[f64]) -> (f64, Vec<LayerGradient>) {
        let all = self.forward(self.inputs(values, conditions));
        let (rows, rest) = all[4].split_at(values.len());
        let mut slopes = Vec::with_capacity(all[4].len());
        let mut at_rest = vec![0.0; self.values];
        let (mut loss, mean) = (0.0, 2.0 / values.len() as f64);
        for (row, known) in rows.chunks_exact(self.values).zip(values.chunks_exact(self.values)) {
            for (place, ((out, rest), known)) in row.iter().zip(rest).zip(known).enumerate() {
                let difference = out - rest - known / self.scale;
                loss += difference * difference;
                slopes.push(mean * difference);
                at_rest[place] -= mean * difference;
            }
        }
        slopes.extend(at_rest);
        let mut gradients = Vec::new();
        for at in (0..self.layers.len()).rev() {
            bend(BENT[at], &all[at + 1], &mut slopes);
            let layer = &self.layers[at];
            let (mut weights, mut bias) = (vec![0.0; layer.weights.len()], vec![0.0; layer.bias.len()]);
            layer.gradient(&all[at], &slopes, &mut weights, &mut bias);
            gradients.push((weights, bias));
            slopes = layer.back(&slopes);
        }
        gradients.reverse();
        (loss, gradients)
    }
}

#[cfg(test)]
#[path = "autoencoder_tests.rs"]
mod tests;
