//! Tensors: numbers in rows of any shape, of one moment or over frames.

use super::Numbers;
use std::ops::Range;
use std::sync::Arc;
use wire::{Data, DecodeError, Decoder, Encoder, FrameAxis, JoinError, Rows, Table, Tolerance, Value, ValueKind};

/// Numbers in rows; the last dimension runs fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensor {
    shape: Vec<u32>,
    numbers: Numbers,
}

/// Numbers in rows for each frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameTensor {
    axis: FrameAxis,
    shape: Vec<u32>,
    numbers: Numbers,
}

/// The product of dimensions; `None` where it is too large to count.
fn product(shape: &[u32]) -> Option<usize> {
    shape.iter().try_fold(1_usize, |all, size| all.checked_mul(*size as usize))
}

fn check(shape: &[u32], frames: usize, numbers: &Numbers) -> Result<(), String> {
    let wanted = product(shape).and_then(|row| row.checked_mul(frames));
    if wanted == Some(numbers.len()) {
        return Ok(());
    }
    Err(format!("{} numbers for the shape {}", numbers.len(), shown(shape, Some(frames).filter(|count| *count != 1))))
}

fn shown(shape: &[u32], frames: Option<usize>) -> String {
    let frames = frames.map(|count| count.to_string()).into_iter();
    let all: Vec<String> = frames.chain(shape.iter().map(u32::to_string)).collect();
    all.join(" x ")
}

fn tables(rows: Rows, numbers: &Numbers) -> Vec<Table<'_>> {
    let columns = numbers.len().checked_div(rows.count()).unwrap_or_default();
    vec![Table {
        what: "numbers",
        unit: "",
        tolerance: Tolerance { absolute: 1e-6, relative: 1e-5 },
        rows,
        columns: (0..columns).map(|column| column.to_string()).collect(),
        number: Box::new(move |row, column| numbers.at(row * columns + column)),
    }]
}

impl Tensor {
    /// Numbers in the given shape.
    ///
    /// # Errors
    /// Where the shape asks for another number of numbers.
    pub fn new(shape: Vec<u32>, numbers: Numbers) -> Result<Self, String> {
        check(&shape, 1, &numbers)?;
        Ok(Self { shape, numbers })
    }

    /// Size of each dimension.
    pub fn shape(&self) -> &[u32] {
        &self.shape
    }

    /// The numbers.
    pub fn numbers(&self) -> &Numbers {
        &self.numbers
    }
}

impl FrameTensor {
    /// Numbers in the given shape for each frame of `axis`.
    ///
    /// # Errors
    /// Where the shape and the frames ask for another number of numbers.
    pub fn new(axis: FrameAxis, shape: Vec<u32>, numbers: Numbers) -> Result<Self, String> {
        check(&shape, axis.count, &numbers)?;
        Ok(Self { axis, shape, numbers })
    }

    /// Size of each dimension of one frame.
    pub fn shape(&self) -> &[u32] {
        &self.shape
    }

    /// The numbers, frame after frame.
    pub fn numbers(&self) -> &Numbers {
        &self.numbers
    }

    /// The frames.
    pub fn frame_axis(&self) -> FrameAxis {
        self.axis
    }
}

impl Value for Tensor {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.u32s(&self.shape);
        self.numbers.encode(out);
    }

    fn summary(&self) -> String {
        format!("{} of {}", shown(&self.shape, None), self.numbers.type_name())
    }

    fn size(&self) -> usize {
        self.numbers.bytes() + 64
    }

    fn tables(&self) -> Vec<Table<'_>> {
        let rows = self.shape.first().map_or(1, |first| *first as usize);
        tables(Rows::Counted("row", rows), &self.numbers)
    }
}

impl Data for Tensor {
    const NAME: &'static str = "Tensor";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (shape, numbers) = (input.u32s()?, Numbers::decode(input)?);
        Self::new(shape, numbers).map_err(|what| DecodeError::Invalid { what })
    }
}

impl Value for FrameTensor {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&self.axis);
        out.u32s(&self.shape);
        self.numbers.encode(out);
    }

    fn summary(&self) -> String {
        let frame = shown(&self.shape, None);
        format!("{frame} of {}, {} frames at {} Hz", self.numbers.type_name(), self.axis.count, self.axis.rate_hz)
    }

    fn size(&self) -> usize {
        self.numbers.bytes() + 64
    }

    fn axis(&self) -> Option<FrameAxis> {
        Some(self.axis)
    }

    fn slice(&self, frames: Range<usize>) -> Option<Arc<dyn Value>> {
        let row = product(&self.shape)?;
        let numbers = self.numbers.slice(frames.start * row..frames.end * row);
        Some(Arc::new(Self { axis: self.axis.slice(&frames), shape: self.shape.clone(), numbers }))
    }

    fn tables(&self) -> Vec<Table<'_>> {
        tables(Rows::Frames(self.axis), &self.numbers)
    }
}

impl Data for FrameTensor {
    const NAME: &'static str = "FrameTensor";
    const VERSION: u32 = 1;
    const FRAMED: bool = true;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (axis, shape, numbers) = (input.record()?, input.u32s()?, Numbers::decode(input)?);
        Self::new(axis, shape, numbers).map_err(|what| DecodeError::Invalid { what })
    }

    fn join(slices: &[&Self]) -> Result<Self, JoinError> {
        let differs = |index, what| JoinError::Differs { kind: Self::NAME, index, what };
        let (first, more) = slices.split_first().ok_or(JoinError::Empty(Self::NAME))?;
        let mut all = (*first).clone();
        for (index, slice) in more.iter().enumerate() {
            if slice.shape != all.shape {
                return Err(differs(index + 1, "shape"));
            }
            if slice.axis.rate_hz.to_bits() != all.axis.rate_hz.to_bits() {
                return Err(differs(index + 1, "frame rate"));
            }
            if !all.numbers.append(&slice.numbers) {
                return Err(differs(index + 1, "type of numbers"));
            }
            all.axis.count += slice.axis.count;
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_round_trip_and_slices_join_to_the_whole() {
        let axis = FrameAxis { first: 7, count: 4, rate_hz: 24.0 };
        let all = [
            Numbers::F32(vec![1.5, -2.0, 0.0, 3.0, 4.0, 5.0, 6.0, 7.0]),
            Numbers::F64((0..8).map(f64::from).collect()),
            Numbers::I32((-4..4).collect()),
            Numbers::U32((0..8).collect()),
            Numbers::U8((0..8).collect()),
        ];
        for numbers in all {
            let tensor = FrameTensor::new(axis, vec![2], numbers.clone()).unwrap();
            let read = (tensor.kind().decode)(&(&tensor as &dyn Value).encoded()).unwrap();
            assert_eq!(read.downcast_ref::<FrameTensor>(), Some(&tensor));
            let parts = [tensor.slice(0..1).unwrap(), tensor.slice(1..4).unwrap()];
            let joined = (tensor.kind().join)(&parts).unwrap();
            assert_eq!(joined.downcast_ref::<FrameTensor>(), Some(&tensor));
            let still = Tensor::new(vec![4, 2], numbers).unwrap();
            let read = (still.kind().decode)(&(&still as &dyn Value).encoded()).unwrap();
            assert_eq!(read.downcast_ref::<Tensor>(), Some(&still));
            assert_eq!((still.tables()[0].number)(3, 1).to_bits(), (tensor.tables()[0].number)(3, 1).to_bits());
        }
        assert!(Tensor::new(vec![3], Numbers::U8(vec![1, 2])).is_err());
        assert!(Tensor::new(vec![u32::MAX; 4], Numbers::U8(Vec::new())).is_err());
    }
}
