//! The stable binary encoding: little-endian, length-prefixed, the same bytes on every machine.
//!
//! Large arrays go through [`Encoder::f32s`] and its like; small structured heads through
//! [`Encoder::record`] (postcard, whose format is stable).

use glam::Vec3;
use serde::{Serialize, de::DeserializeOwned};

/// Why bytes could not be read back as a value.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// The bytes end inside a field.
    #[error("the stored bytes end at {have} where {need} are needed")]
    Short {
        /// Bytes that the field needs to end at.
        need: usize,
        /// Bytes there are.
        have: usize,
    },
    /// The bytes hold something that the type does not allow.
    #[error("the stored bytes are not a valid {what}")]
    Invalid {
        /// What was being read.
        what: String,
    },
}

/// Collects the encoding of one value.
#[derive(Debug, Default)]
pub struct Encoder {
    bytes: Vec<u8>,
}

impl Encoder {
    /// Writes over the memory of `bytes`, whose content is dropped.
    pub fn over(mut bytes: Vec<u8>) -> Self {
        bytes.clear();
        Self { bytes }
    }

    /// The bytes written so far.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }

    /// Writes a count or index.
    pub fn count(&mut self, number: usize) {
        self.bytes.extend_from_slice(&(number as u64).to_le_bytes());
    }

    /// Writes raw bytes with their length.
    pub fn blob(&mut self, bytes: &[u8]) {
        self.count(bytes.len());
        self.bytes.extend_from_slice(bytes);
    }

    /// Writes a text with its length.
    pub fn text(&mut self, text: &str) {
        self.blob(text.as_bytes());
    }

    /// Writes a small structured record.
    ///
    /// # Panics
    /// Where the record's own `Serialize` fails; records of plain data, which is what values have, never do.
    pub fn record<T: Serialize>(&mut self, record: &T) {
        let bytes = postcard::to_stdvec(record).expect("records of plain data serialise into memory");
        self.blob(&bytes);
    }

    /// Writes words of `N` bytes end to end after their number.
    fn words<const N: usize, T>(&mut self, items: &[T], write: impl Fn(&T) -> [u8; N]) {
        self.count(items.len());
        let start = self.bytes.len();
        self.bytes.resize(start + items.len() * N, 0);
        for (place, item) in self.bytes[start..].chunks_exact_mut(N).zip(items) {
            place.copy_from_slice(&write(item));
        }
    }

    /// Writes 32-bit floats, bit for bit except that every NaN is written as the one quiet NaN.
    pub fn f32s(&mut self, numbers: &[f32]) {
        self.words(numbers, |number| canonical(*number).to_le_bytes());
    }

    /// Writes 64-bit floats, NaN as in [`Encoder::f32s`].
    pub fn f64s(&mut self, numbers: &[f64]) {
        self.words(numbers, |number| if number.is_nan() { f64::NAN } else { *number }.to_le_bytes());
    }

    /// Writes points or directions as x, y, z triples.
    pub fn points(&mut self, points: &[Vec3]) {
        self.words(points, |point| {
            let [x, y, z] = point.to_array().map(|number| canonical(number).to_le_bytes());
            [x[0], x[1], x[2], x[3], y[0], y[1], y[2], y[3], z[0], z[1], z[2], z[3]]
        });
    }

    /// Writes 32-bit indices.
    pub fn u32s(&mut self, numbers: &[u32]) {
        self.words(numbers, |number| number.to_le_bytes());
    }
}

/// The number, with every NaN as the one quiet NaN.
fn canonical(number: f32) -> f32 {
    if number.is_nan() { f32::NAN } else { number }
}

/// Reads an encoding back, in the order in which it was written.
#[derive(Debug)]
pub struct Decoder<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Decoder<'a> {
    /// Starts at the first of `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    fn take(&mut self, length: usize) -> Result<&'a [u8], DecodeError> {
        let end = self.at.saturating_add(length);
        let part = self.bytes.get(self.at..end).ok_or(DecodeError::Short { need: end, have: self.bytes.len() })?;
        self.at = end;
        Ok(part)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], DecodeError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    /// Reads a count or index.
    ///
    /// # Errors
    /// Where the bytes end too soon.
    pub fn count(&mut self) -> Result<usize, DecodeError> {
        let number = u64::from_le_bytes(self.array()?);
        usize::try_from(number).map_err(|_| DecodeError::Invalid { what: "count".into() })
    }

    /// Reads raw bytes.
    ///
    /// # Errors
    /// Where the bytes end too soon.
    pub fn blob(&mut self) -> Result<&'a [u8], DecodeError> {
        let length = self.count()?;
        self.take(length)
    }

    /// Reads a text.
    ///
    /// # Errors
    /// Where the bytes end too soon or are not UTF-8.
    pub fn text(&mut self) -> Result<String, DecodeError> {
        String::from_utf8(self.blob()?.to_vec()).map_err(|_| DecodeError::Invalid { what: "UTF-8 text".into() })
    }

    /// Reads a structured record.
    ///
    /// # Errors
    /// Where the bytes end too soon or hold another record.
    pub fn record<T: DeserializeOwned>(&mut self) -> Result<T, DecodeError> {
        postcard::from_bytes(self.blob()?).map_err(|_| DecodeError::Invalid { what: std::any::type_name::<T>().into() })
    }

    fn words<const N: usize, T>(&mut self, read: impl Fn([u8; N]) -> T) -> Result<Vec<T>, DecodeError> {
        let count = self.count()?;
        let bytes = self.take(count.saturating_mul(N))?;
        Ok(bytes
            .chunks_exact(N)
            .map(|chunk| {
                let mut word = [0; N];
                word.copy_from_slice(chunk);
                read(word)
            })
            .collect())
    }

    /// Reads 32-bit floats.
    ///
    /// # Errors
    /// Where the bytes end too soon.
    pub fn f32s(&mut self) -> Result<Vec<f32>, DecodeError> {
        self.words(f32::from_le_bytes)
    }

    /// Reads 64-bit floats.
    ///
    /// # Errors
    /// Where the bytes end too soon.
    pub fn f64s(&mut self) -> Result<Vec<f64>, DecodeError> {
        self.words(f64::from_le_bytes)
    }

    /// Reads points or directions.
    ///
    /// # Errors
    /// Where the bytes end too soon.
    pub fn points(&mut self) -> Result<Vec<Vec3>, DecodeError> {
        let float = |b: &[u8; 12], at: usize| f32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]]);
        self.words(|b: [u8; 12]| Vec3::new(float(&b, 0), float(&b, 4), float(&b, 8)))
    }

    /// Reads 32-bit indices.
    ///
    /// # Errors
    /// Where the bytes end too soon.
    pub fn u32s(&mut self) -> Result<Vec<u32>, DecodeError> {
        self.words(u32::from_le_bytes)
    }

    /// Ends the reading.
    ///
    /// # Errors
    /// Where bytes are left over.
    pub fn finish(self, what: &str) -> Result<(), DecodeError> {
        if self.at == self.bytes.len() { Ok(()) } else { Err(DecodeError::Invalid { what: what.into() }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_round_trips_and_every_cut_is_noticed() {
        let mut encoder = Encoder::default();
        encoder.text("brow");
        encoder.record(&(3_u32, Some("x".to_owned())));
        encoder.f32s(&[1.0, f32::NAN, -0.0]);
        encoder.f64s(&[0.1]);
        encoder.points(&[Vec3::new(1.0, 2.0, 3.0)]);
        encoder.u32s(&[7]);
        let bytes = encoder.finish();
        let read = |bytes: &[u8]| -> Result<(), DecodeError> {
            let mut decoder = Decoder::new(bytes);
            assert_eq!(decoder.text()?, "brow");
            assert_eq!(decoder.record::<(u32, Option<String>)>()?, (3, Some("x".into())));
            let floats = decoder.f32s()?;
            assert!(floats[1].is_nan() && floats[2].is_sign_negative());
            assert_eq!(decoder.f64s()?, [0.1]);
            assert_eq!(decoder.points()?, [Vec3::new(1.0, 2.0, 3.0)]);
            assert_eq!(decoder.u32s()?, [7]);
            decoder.finish("test")
        };
        read(&bytes).unwrap();
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end]).is_err(), "cut at {end}");
        }
    }
}
