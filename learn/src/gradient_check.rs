//! Checks the gradient of the whole network against finite differences of an independent forward pass in double precision,
//! written out as plain loops from the equations of [`crate::Architecture`].

use crate::architecture::{Activation, Architecture, Role};
use crate::model::{Model, Part, initial_parameters};
use crate::network::Parameter;
use crate::random::{Stream, Use};
use crate::training::Loss;

const ROWS: usize = 5;
const SEED: u64 = 11;

/// One row through the network, in double precision; `factors` are those of the dropout, for each block in turn.
fn forward(
    architecture: &Architecture,
    parameters: &[Vec<f64>],
    inputs: &[f32],
    conditions: &[f32],
    factors: &[Vec<f64>],
) -> Vec<f64> {
    let negative = f64::from(architecture.activation.negative_slope());
    let mut hidden: Vec<f64> = inputs.iter().map(|value| f64::from(*value)).collect();
    let (mut skip, mut block) = (Vec::new(), 0);
    for (layer, own) in architecture.layers().iter().zip(parameters.chunks_exact(2)) {
        if layer.role == Role::OpenBlock {
            skip.clone_from(&hidden);
        }
        if layer.role == Role::Head {
            hidden.extend(conditions.iter().map(|value| f64::from(*value)));
        }
        let mut out = own[1].clone();
        for (input, value) in hidden.iter().enumerate() {
            for (output, sum) in out.iter_mut().enumerate() {
                *sum += value * own[0][input * layer.outputs + output];
            }
        }
        if layer.role == Role::CloseBlock {
            out.iter_mut().zip(&skip).for_each(|(value, skip)| *value += skip);
        }
        if layer.role != Role::Output {
            for value in &mut out {
                *value *= if *value > 0.0 { 1.0 } else { negative };
            }
        }
        if layer.role == Role::OpenBlock {
            out.iter_mut().zip(&factors[block]).for_each(|(value, factor)| *value *= factor);
            block += 1;
        }
        hidden = out;
    }
    hidden
}

/// The mean loss of all rows.
fn mean_loss(
    architecture: &Architecture,
    parameters: &[Vec<f64>],
    part: &Part,
    factors: &[Vec<f64>],
    loss: Loss,
) -> f64 {
    let width = architecture.width;
    let mut sum = 0.0;
    for row in 0..ROWS {
        let slice = |values: &[f32], columns: usize| values[row * columns..(row + 1) * columns].to_vec();
        let own: Vec<Vec<f64>> = factors.iter().map(|all| all[row * width..(row + 1) * width].to_vec()).collect();
        let inputs = slice(&part.inputs, architecture.inputs);
        let conditions = slice(&part.conditions, architecture.conditions);
        let outputs = forward(architecture, parameters, &inputs, &conditions, &own);
        for (output, target) in outputs.iter().zip(slice(&part.targets, architecture.outputs)) {
            let difference = output - f64::from(target);
            sum += match loss {
                Loss::MeanSquared => difference * difference,
                Loss::MeanAbsolute => difference.abs(),
                Loss::Huber { delta } if difference.abs() <= f64::from(delta) => 0.5 * difference * difference,
                Loss::Huber { delta } => f64::from(delta) * (difference.abs() - 0.5 * f64::from(delta)),
            };
        }
    }
    sum / (ROWS * architecture.outputs) as f64
}

fn part(architecture: &Architecture) -> Part {
    let mut stream = Stream::new(5, Use::Order, 0);
    let mut values = |columns: usize| (0..ROWS * columns).map(|_| 3.0 * stream.unit() - 1.5).collect();
    Part {
        rows: ROWS,
        inputs: values(architecture.inputs),
        conditions: values(architecture.conditions),
        targets: values(architecture.outputs),
    }
}

/// Biases that are not 0, so that their place in the sums shows.
fn parameters(architecture: &Architecture) -> Vec<Parameter> {
    let mut parameters = initial_parameters(architecture, SEED);
    let mut stream = Stream::new(6, Use::Order, 0);
    for parameter in parameters.iter_mut().filter(|parameter| parameter.rows == 1) {
        parameter.values.iter_mut().for_each(|value| *value = 0.4 * stream.unit() - 0.2);
    }
    parameters
}

/// The largest difference between the tape's gradient and the finite differences, relative to the largest entry of the
/// parameter's gradient; and between the two losses.
fn worst(architecture: &Architecture, loss: Loss, split: bool) -> (f64, f64) {
    let parameters = parameters(architecture);
    let mut model = Model::new(architecture, &parameters, None).unwrap();
    let dropout = || Stream::new(SEED, Use::Dropout, 0);
    let whole = part(architecture);
    let weight = 1.0 / (ROWS * architecture.outputs) as f32;
    let (mut sum, mut stream) = (0.0, dropout());
    let cuts = if split { &[0, 2, 3, ROWS][..] } else { &[0, ROWS] };
    for cut in cuts.windows(2).map(|pair| pair[0]..pair[1]) {
        let slice = |values: &[f32], columns: usize| values[cut.start * columns..cut.end * columns].to_vec();
        let piece = Part {
            rows: cut.len(),
            inputs: slice(&whole.inputs, architecture.inputs),
            conditions: slice(&whole.conditions, architecture.conditions),
            targets: slice(&whole.targets, architecture.outputs),
        };
        sum += model.accumulate(piece, cut.start > 0, Some(&mut stream), (loss, weight)).unwrap();
    }
    let gradients = model.gradients();

    let mut stream = dropout();
    let factors: Vec<Vec<f64>> = (0..architecture.blocks)
        .map(|_| {
            stream.dropout(architecture.dropout, ROWS * architecture.width).iter().map(|f| f64::from(*f)).collect()
        })
        .collect();
    let mut doubles: Vec<Vec<f64>> =
        parameters.iter().map(|parameter| parameter.values.iter().map(|value| f64::from(*value)).collect()).collect();
    let expected_loss = mean_loss(architecture, &doubles, &whole, &factors, loss);
    let loss_error = (sum * f64::from(weight) - expected_loss).abs();
    let mut worst = 0.0f64;
    for index in 0..doubles.len() {
        let step = 1e-6;
        let numeric: Vec<f64> = (0..doubles[index].len())
            .map(|place| {
                let value = doubles[index][place];
                doubles[index][place] = value + step;
                let above = mean_loss(architecture, &doubles, &whole, &factors, loss);
                doubles[index][place] = value - step;
                let below = mean_loss(architecture, &doubles, &whole, &factors, loss);
                doubles[index][place] = value;
                (above - below) / (2.0 * step)
            })
            .collect();
        let largest = numeric.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
        assert!(largest > 1e-4, "parameter {} has no gradient to compare", parameters[index].name);
        for (found, expected) in gradients[index].iter().zip(&numeric) {
            worst = worst.max((f64::from(*found) - expected).abs() / largest);
        }
    }
    (worst, loss_error)
}

/// A small network with conditions; it has every kind of layer.
fn small() -> Architecture {
    Architecture { conditions: 2, activation: Activation::LeakyRelu, ..Architecture::new(7, 3, 9, 2) }
}

#[test]
fn the_gradient_is_that_of_finite_differences() {
    for activation in [Activation::Relu, Activation::LeakyRelu] {
        for loss in [Loss::MeanSquared, Loss::MeanAbsolute, Loss::Huber { delta: 0.7 }] {
            for blocks in [0, 1, 3] {
                let architecture = Architecture { blocks, activation, ..small() };
                let (gradient, value) = worst(&architecture, loss, false);
                assert!(gradient < 3e-5 && value < 1e-5, "{activation:?} {loss:?} {blocks}: {gradient:e}, {value:e}");
            }
        }
    }
}

#[test]
fn it_is_so_without_conditions_and_with_dropout() {
    let plain = Architecture { conditions: 0, ..small() };
    let dropped = Architecture { dropout: 0.3, ..small() };
    for architecture in [plain, dropped] {
        let (gradient, value) = worst(&architecture, Loss::MeanSquared, false);
        assert!(gradient < 3e-5 && value < 1e-5, "{architecture:?}: {gradient:e}, {value:e}");
    }
}

#[test]
fn parts_of_a_batch_add_up_to_the_whole() {
    let (gradient, value) = worst(&small(), Loss::MeanSquared, true);
    assert!(gradient < 3e-5 && value < 1e-5, "{gradient:e}, {value:e}");
}
