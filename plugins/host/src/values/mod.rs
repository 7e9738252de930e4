//! Values that only plugins make: plain numbers, texts, tensors and bytes. Those of faces are in `face-math`.

mod numbers;
mod plain;
mod tensor;

pub use numbers::Numbers;
pub use plain::{Blob, Number, Text};
pub use tensor::{FrameTensor, Tensor};
