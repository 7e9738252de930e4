//! The network's operations on dfdx's tape: each computes forward and notes how its gradient flows back.
//!
//! Products with weights are dfdx's own (its matrix product reads the weights in place). Everything between two products is
//! fused here into one operation over the small table of a batch, since dfdx's broadcasting operations walk element by
//! element.
//!
//! dfdx gives no access to a tensor's numbers but by copying its raw storage, in whatever order that lies. So every tensor
//! that is read here must be contiguous; all that this file and dfdx's product make are, and no permuted one leaves it.

use crate::architecture::Activation;
use crate::training::Loss;
use dfdx::shapes::{Axes2, HasShape, Rank0};
use dfdx::tensor::{Cpu, CpuError, NoneTape, OwnedTape, PutTape, SplitTape, Tape, Tensor, TensorFromVec, ZerosTensor};
use dfdx::tensor_ops::{PermuteTo, TryMatMul};

/// A table on dfdx's device, with or without a tape. Biases are tables of one row.
pub(crate) type Rows<T = NoneTape> = Tensor<(usize, usize), f32, Cpu, T>;
/// A table that carries the tape.
pub(crate) type Traced = Rows<OwnedTape<f32, Cpu>>;

/// A single number that carries the tape: where the way back begins.
pub(crate) type End = Tensor<Rank0, f32, Cpu, OwnedTape<f32, Cpu>>;

/// A copy of a contiguous tensor's numbers, row after row.
pub(crate) fn read<T>(tensor: &Rows<T>) -> Vec<f32> {
    let (rows, columns) = *tensor.shape();
    let mut values = vec![0.0; rows * columns];
    tensor.copy_into(&mut values);
    values
}

/// x W, with a gradient for W but none for x: the first layer's inputs are given, and their gradient would cost as much as
/// the product itself. The tape starts here. `again` tells that W already has a gradient, from an earlier part of the batch.
pub(crate) fn enter(inputs: Rows, weight: &Rows, tape: OwnedTape<f32, Cpu>, again: bool) -> Result<Traced, CpuError> {
    let product = inputs.clone().try_matmul(weight.clone())?;
    let (product_ghost, weight_ghost, shape) = (product.ghost(), weight.ghost(), *product.shape());
    let mut tape = tape;
    tape.add_backward_op(move |gradients| {
        let device = inputs.device().clone();
        let upstream = gradients.get_or_alloc_mut(&product_ghost)?.to_vec();
        let upstream = device.try_tensor_from_vec(upstream, shape)?;
        let gradient: Rows = inputs.try_permute::<_, Axes2<1, 0>>()?.try_matmul(upstream)?;
        let slot = gradients.get_or_alloc_mut(&weight_ghost)?;
        if again {
            add(slot, &read(&gradient));
        } else {
            gradient.copy_into(slot);
        }
        Ok(())
    });
    Ok(product.put_tape(tape))
}

/// x W with gradients for both.
pub(crate) fn multiply(inputs: Traced, weight: &Rows) -> Result<Traced, CpuError> {
    inputs.try_matmul(weight.clone())
}

/// What follows a product: out = D(a(product + bias + skip)), with the bias added to every row.
pub(crate) struct Finish<'a> {
    /// One row.
    pub bias: &'a Rows,
    /// What the residual connection adds.
    pub skip: Option<Rows>,
    /// `None` leaves the values as they are.
    pub activation: Option<Activation>,
    /// Factors of the dropout, one a value.
    pub dropout: Option<Vec<f32>>,
}

impl Finish<'_> {
    /// Runs the operation. The derivative of a is taken at the sign of its argument, 0 counting as negative.
    pub fn run(self, product: Traced) -> Result<Traced, CpuError> {
        let (product, mut tape) = product.split_tape();
        let (rows, columns) = *product.shape();
        let (product_ghost, bias_ghost) = (product.ghost(), self.bias.ghost());
        let skip_ghost = self.skip.as_ref().map(Tensor::ghost);

        let mut values = read(&product);
        let bias = read(self.bias);
        for row in values.chunks_exact_mut(columns) {
            add(row, &bias);
        }
        if let Some(skip) = &self.skip {
            add(&mut values, &read(skip));
        }
        let slopes = self.activate(&mut values);

        let out = product.device().try_tensor_from_vec(values, (rows, columns))?;
        let out_ghost = out.ghost();
        tape.add_backward_op(move |gradients| {
            let mut upstream = gradients.get_or_alloc_mut(&out_ghost)?.to_vec();
            for (value, slope) in upstream.iter_mut().zip(&slopes) {
                *value *= slope;
            }
            add(gradients.get_or_alloc_mut(&product_ghost)?, &upstream);
            if let Some(skip_ghost) = skip_ghost {
                add(gradients.get_or_alloc_mut(&skip_ghost)?, &upstream);
            }
            let bias = gradients.get_or_alloc_mut(&bias_ghost)?;
            for row in upstream.chunks_exact(columns) {
                add(bias, row);
            }
            Ok(())
        });
        Ok(out.put_tape(tape))
    }

    /// Applies activation and dropout in place; gives the derivative for each value (none where it is 1 everywhere).
    fn activate(&self, values: &mut [f32]) -> Vec<f32> {
        let Some(activation) = self.activation else { return Vec::new() };
        let negative = activation.negative_slope();
        let mut slopes: Vec<f32> = values.iter().map(|value| if *value > 0.0 { 1.0 } else { negative }).collect();
        if let Some(factors) = &self.dropout {
            for (slope, factor) in slopes.iter_mut().zip(factors) {
                *slope *= factor;
            }
        }
        for (value, slope) in values.iter_mut().zip(&slopes) {
            *value *= slope;
        }
        slopes
    }
}

/// [h; c]: the conditions beside each row. They get no gradient.
pub(crate) fn concatenate(hidden: Traced, conditions: &[f32]) -> Result<Traced, CpuError> {
    let (hidden, mut tape) = hidden.split_tape();
    let (rows, width) = *hidden.shape();
    let added = conditions.len() / rows;
    let mut values = Vec::with_capacity(rows * (width + added));
    for (left, right) in read(&hidden).chunks_exact(width).zip(conditions.chunks_exact(added)) {
        values.extend_from_slice(left);
        values.extend_from_slice(right);
    }
    let out = hidden.device().try_tensor_from_vec(values, (rows, width + added))?;
    let (hidden_ghost, out_ghost) = (hidden.ghost(), out.ghost());
    tape.add_backward_op(move |gradients| {
        let upstream = gradients.get_or_alloc_mut(&out_ghost)?.to_vec();
        let slot = gradients.get_or_alloc_mut(&hidden_ghost)?;
        for (slot, row) in slot.chunks_exact_mut(width).zip(upstream.chunks_exact(width + added)) {
            add(slot, &row[..width]);
        }
        Ok(())
    });
    Ok(out.put_tape(tape))
}

/// The sum of the loss over all values of the outputs, and a tensor to run backwards from: it stands for
/// `weight` times that sum.
pub(crate) fn compare(outputs: Traced, targets: &[f32], loss: Loss, weight: f32) -> Result<(f64, End), CpuError> {
    let (outputs, mut tape) = outputs.split_tape();
    let mut sum = 0.0;
    let mut slopes = read(&outputs);
    for (value, target) in slopes.iter_mut().zip(targets) {
        let (own, slope) = loss.of(*value - target);
        sum += f64::from(own);
        *value = slope * weight;
    }
    let ghost = outputs.ghost();
    tape.add_backward_op(move |gradients| {
        add(gradients.get_or_alloc_mut(&ghost)?, &slopes);
        Ok(())
    });
    let scalar: Tensor<Rank0, f32, Cpu> = outputs.device().try_zeros()?;
    Ok((sum, scalar.put_tape(tape)))
}

/// Adds element by element.
fn add(sum: &mut [f32], values: &[f32]) {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum += value;
    }
}
