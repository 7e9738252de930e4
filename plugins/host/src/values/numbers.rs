//! Numbers of one of five types, as tensors hold them.

use std::ops::Range;
use wire::{DecodeError, Decoder, Encoder};

/// Numbers of one type.
#[derive(Debug, Clone, PartialEq)]
pub enum Numbers {
    /// 32-bit floats.
    F32(Vec<f32>),
    /// 64-bit floats.
    F64(Vec<f64>),
    /// Signed 32-bit integers.
    I32(Vec<i32>),
    /// Unsigned 32-bit integers.
    U32(Vec<u32>),
    /// Bytes.
    U8(Vec<u8>),
}

impl Numbers {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(numbers) => numbers.len(),
            Self::F64(numbers) => numbers.len(),
            Self::I32(numbers) => numbers.len(),
            Self::U32(numbers) => numbers.len(),
            Self::U8(numbers) => numbers.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Name of their type.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::F32(_) => "f32",
            Self::F64(_) => "f64",
            Self::I32(_) => "i32",
            Self::U32(_) => "u32",
            Self::U8(_) => "u8",
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        match self {
            Self::F64(numbers) => numbers.len() * 8,
            Self::U8(numbers) => numbers.len(),
            other => other.len() * 4,
        }
    }

    /// The number at `index` as a float.
    pub fn at(&self, index: usize) -> f64 {
        match self {
            Self::F32(numbers) => f64::from(numbers[index]),
            Self::F64(numbers) => numbers[index],
            Self::I32(numbers) => f64::from(numbers[index]),
            Self::U32(numbers) => f64::from(numbers[index]),
            Self::U8(numbers) => f64::from(numbers[index]),
        }
    }

    pub(super) fn slice(&self, range: Range<usize>) -> Self {
        match self {
            Self::F32(numbers) => Self::F32(numbers[range].to_vec()),
            Self::F64(numbers) => Self::F64(numbers[range].to_vec()),
            Self::I32(numbers) => Self::I32(numbers[range].to_vec()),
            Self::U32(numbers) => Self::U32(numbers[range].to_vec()),
            Self::U8(numbers) => Self::U8(numbers[range].to_vec()),
        }
    }

    /// Appends numbers of the same type; false where they are of another.
    pub(super) fn append(&mut self, other: &Self) -> bool {
        match (self, other) {
            (Self::F32(all), Self::F32(more)) => all.extend_from_slice(more),
            (Self::F64(all), Self::F64(more)) => all.extend_from_slice(more),
            (Self::I32(all), Self::I32(more)) => all.extend_from_slice(more),
            (Self::U32(all), Self::U32(more)) => all.extend_from_slice(more),
            (Self::U8(all), Self::U8(more)) => all.extend_from_slice(more),
            _ => return false,
        }
        true
    }

    pub(super) fn encode(&self, out: &mut Encoder) {
        out.text(self.type_name());
        match self {
            Self::F32(numbers) => out.f32s(numbers),
            Self::F64(numbers) => out.f64s(numbers),
            Self::I32(numbers) => out.u32s(bytemuck::cast_slice(numbers)),
            Self::U32(numbers) => out.u32s(numbers),
            Self::U8(numbers) => out.blob(numbers),
        }
    }

    pub(super) fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Ok(match input.text()?.as_str() {
            "f32" => Self::F32(input.f32s()?),
            "f64" => Self::F64(input.f64s()?),
            "i32" => Self::I32(input.u32s()?.into_iter().map(|number| number as i32).collect()),
            "u32" => Self::U32(input.u32s()?),
            "u8" => Self::U8(input.blob()?.to_vec()),
            other => return Err(DecodeError::Invalid { what: format!("type of numbers: {other}") }),
        })
    }
}
