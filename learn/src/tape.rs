//! The network's operations on dfdx's tape: each computes forward and notes how its gradient flows back.
//!
//! dfdx holds what passes through the network and its slopes. Weights and biases are held here, in the panels of `product`,
//! since dfdx gives no access to a tensor's numbers but by copying its raw storage. Everything between two products is fused
//! into one operation over the small table of a batch, since dfdx's broadcasting operations walk element by element.
//!
//! That storage is copied in whatever order it lies. So every tensor that is read here must be contiguous; all that this
//! file makes are, and no permuted one leaves it.

use crate::architecture::Activation;
use crate::product::{self, PanelRow};
use crate::training::Loss;
use dfdx::shapes::{HasShape, Rank0};
use dfdx::tensor::{Cpu, CpuError, NoneTape, OwnedTape, PutTape, SplitTape, Tape, Tensor, TensorFromVec, ZerosTensor};
use pulp::Arch;
use std::cell::RefCell;
use std::rc::Rc;

/// A table on dfdx's device, with or without a tape.
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

/// A weight or (with one input) a bias, and its gradient. Clones share the numbers.
#[derive(Clone)]
pub(crate) struct Table {
    pub inputs: usize,
    pub outputs: usize,
    /// The numbers in panels. A bias in panels is a plain row, with some 0 behind it.
    pub values: Rc<Vec<PanelRow>>,
    /// As they lie.
    pub gradient: Rc<RefCell<Vec<PanelRow>>>,
}

impl Table {
    /// A table from `inputs` × `outputs` numbers, row after row.
    pub fn new(inputs: usize, outputs: usize, values: &[f32]) -> Self {
        let values = product::into_panels(values, outputs);
        let gradient = Rc::new(RefCell::new(vec![[0.0; _]; values.len()]));
        Self { inputs, outputs, values: Rc::new(values), gradient }
    }

    fn size(&self) -> (usize, usize) {
        (self.inputs, self.outputs)
    }
}

/// How gradients of weights and biases come in: put in their place by the first part of a batch, added by later ones.
#[derive(Clone, Copy)]
pub(crate) struct Way {
    pub arch: Arch,
    pub again: bool,
}

/// x W, with a gradient for W but none for x: the first layer's inputs are given, and their gradient would cost as much as
/// the product itself. The tape starts here.
pub(crate) fn enter(inputs: &Rows, weight: &Table, tape: OwnedTape<f32, Cpu>, way: Way) -> Result<Traced, CpuError> {
    times(inputs, weight, tape, way, false)
}

/// x W with gradients for both.
pub(crate) fn multiply(inputs: Traced, weight: &Table, way: Way) -> Result<Traced, CpuError> {
    let (inputs, tape) = inputs.split_tape();
    times(&inputs, weight, tape, way, true)
}

fn times(
    inputs: &Rows,
    weight: &Table,
    mut tape: OwnedTape<f32, Cpu>,
    way: Way,
    further: bool,
) -> Result<Traced, CpuError> {
    let (rows, _) = *inputs.shape();
    let x = read(inputs);
    let out = product::forward(way.arch, &x, &weight.values, weight.size());
    let out = inputs.device().try_tensor_from_vec(out, (rows, weight.outputs))?;
    let (out_ghost, inputs_ghost, weight) = (out.ghost(), inputs.ghost(), weight.clone());
    tape.add_backward_op(move |gradients| {
        let upstream = gradients.get_or_alloc_mut(&out_ghost)?.to_vec();
        product::gradient(way.arch, &x, &upstream, weight.size(), way.again, &mut weight.gradient.borrow_mut());
        if further {
            let slopes = product::back(way.arch, &upstream, &weight.values, weight.size());
            add(gradients.get_or_alloc_mut(&inputs_ghost)?, &slopes);
        }
        Ok(())
    });
    Ok(out.put_tape(tape))
}

/// What follows a product: out = D(a(product + bias + skip)), with the bias added to every row.
pub(crate) struct Finish<'a> {
    /// One row.
    pub bias: &'a Table,
    pub way: Way,
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
        let (product_ghost, own, again) = (product.ghost(), self.bias.clone(), self.way.again);
        let skip_ghost = self.skip.as_ref().map(Tensor::ghost);

        let mut values = read(&product);
        for row in values.chunks_exact_mut(columns) {
            add(row, self.bias.values.as_flattened());
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
            let mut bias = own.gradient.borrow_mut();
            if !again {
                bias.as_flattened_mut().fill(0.0);
            }
            for row in upstream.chunks_exact(columns) {
                add(bias.as_flattened_mut(), row);
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
