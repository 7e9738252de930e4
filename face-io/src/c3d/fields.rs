//! The parameters of a C3D file that is written: the groups that the user guide asks of every file, those of what is not in it
//! (analog samples, force plates) with counts of zero.

use super::numbers::Processor;
use crate::WriteError;
use crate::units::LengthUnit;
use face_math::data::Markers;

/// Labels in one parameter: more than this many bytes of them are split into LABELS2, LABELS3 …, so that the distance
/// to the next parameter stays within the 16 signed bits that all readers understand.
const LABEL_BYTES: usize = 32_000;

const POINT: i8 = 1;
const TRIAL: i8 = 2;
const ANALOG: i8 = 3;
const FORCE_PLATFORM: i8 = 4;

/// What the parameters say.
pub(super) struct Fields<'a> {
    pub markers: &'a Markers,
    pub unit: LengthUnit,
    /// Numbers of the first and the last frame.
    pub first: u32,
    pub last: u32,
    /// Frames a second, as the file holds it.
    pub rate: [u8; 4],
    /// The step of integer coordinates, or a negative number, as the file holds it.
    pub scale: [u8; 4],
}

impl Fields<'_> {
    /// The bytes of the parameters, and where in them the word stands that says where the frames begin.
    pub fn bytes(&self, processor: Processor) -> Result<(Vec<u8>, usize), WriteError> {
        let mut out = Records { processor, bytes: Vec::new() };
        for (number, name) in
            [(POINT, "POINT"), (TRIAL, "TRIAL"), (ANALOG, "ANALOG"), (FORCE_PLATFORM, "FORCE_PLATFORM")]
        {
            out.group(number, name);
        }
        let frames = self.markers.frames();
        let low = |number: u32| (number & 0xffff) as u16;
        let high = |number: u32| (number >> 16) as u16;
        if frames > 0 {
            out.integers(TRIAL, "ACTUAL_START_FIELD", &[2], &[low(self.first), high(self.first)]);
            out.integers(TRIAL, "ACTUAL_END_FIELD", &[2], &[low(self.last), high(self.last)]);
        }
        let names = self.markers.names();
        out.integers(POINT, "USED", &[], &[clipped(names.len())]);
        out.integers(POINT, "FRAMES", &[], &[clipped(frames)]);
        if frames > 65_535 {
            // A count of frames is a whole number far below 2^127, which every processor's format holds.
            out.reals(POINT, "LONG_FRAMES", &[], &processor.f32_bytes(frames as f32).unwrap_or_default());
        }
        out.reals(POINT, "SCALE", &[], &self.scale);
        out.reals(POINT, "RATE", &[], &self.rate);
        out.text(POINT, "UNITS", self.unit.symbol());
        out.labels(POINT, names)?;

        out.integers(ANALOG, "USED", &[], &[0]);
        out.reals(ANALOG, "RATE", &[], &self.rate);
        out.reals(ANALOG, "GEN_SCALE", &[], &processor.f32_bytes(1.0).unwrap_or_default());
        out.reals(ANALOG, "SCALE", &[0], &[]);
        out.integers(ANALOG, "OFFSET", &[0], &[]);
        for name in ["LABELS", "DESCRIPTIONS", "UNITS"] {
            out.record(ANALOG, name, TEXT, &[1, 0], &[]);
        }
        out.integers(FORCE_PLATFORM, "USED", &[], &[0]);
        out.integers(FORCE_PLATFORM, "TYPE", &[0], &[]);
        out.integers(FORCE_PLATFORM, "ZERO", &[2], &[1, 0]);
        out.reals(FORCE_PLATFORM, "CORNERS", &[3, 4, 0], &[]);
        out.reals(FORCE_PLATFORM, "ORIGIN", &[3, 0], &[]);
        out.integers(FORCE_PLATFORM, "CHANNEL", &[6, 0], &[]);

        let data_start_at = out.integers(POINT, "DATA_START", &[], &[0]);
        // A name of length 0 ends the list.
        out.bytes.extend([0, 0]);
        Ok((out.bytes, data_start_at))
    }
}

fn clipped(number: usize) -> u16 {
    number.min(65_535) as u16
}

/// Types of values, as their records say.
const TEXT: i8 = -1;
const INTEGER: i8 = 2;
const REAL: i8 = 4;

/// Records of groups and parameters, one after the other.
struct Records {
    processor: Processor,
    bytes: Vec<u8>,
}

impl Records {
    fn group(&mut self, number: i8, name: &str) {
        self.bytes.extend([name.len() as u8, (-number).cast_unsigned()]);
        self.bytes.extend(name.bytes());
        // Distance to the next record, and the length of the (empty) description.
        self.bytes.extend(self.processor.u16_bytes(3));
        self.bytes.push(0);
    }

    /// Adds a parameter; where its values begin.
    fn record(&mut self, group: i8, name: &str, kind: i8, dimensions: &[u8], values: &[u8]) -> usize {
        self.bytes.extend([name.len() as u8, group.cast_unsigned()]);
        self.bytes.extend(name.bytes());
        let distance = (2 + 2 + dimensions.len() + values.len() + 1) as u16;
        self.bytes.extend(self.processor.u16_bytes(distance));
        self.bytes.extend([kind.cast_unsigned(), dimensions.len() as u8]);
        self.bytes.extend(dimensions);
        let at = self.bytes.len();
        self.bytes.extend(values);
        self.bytes.push(0);
        at
    }

    fn integers(&mut self, group: i8, name: &str, dimensions: &[u8], values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| self.processor.u16_bytes(*value)).collect();
        self.record(group, name, INTEGER, dimensions, &bytes)
    }

    fn reals(&mut self, group: i8, name: &str, dimensions: &[u8], values: &[u8]) {
        self.record(group, name, REAL, dimensions, values);
    }

    fn text(&mut self, group: i8, name: &str, text: &str) {
        self.record(group, name, TEXT, &[text.len() as u8], text.as_bytes());
    }

    /// The names of points, and an empty description of each.
    fn labels(&mut self, group: i8, names: &[String]) -> Result<(), WriteError> {
        let wrong = |name: &String, problem| WriteError::Name { format: "C3D", name: name.clone(), problem };
        for name in names {
            if name.len() > 255 {
                return Err(wrong(name, "is longer than 255 bytes"));
            }
            if name.trim() != name || name.is_empty() || name.contains('\0') {
                return Err(wrong(name, "is empty, or begins or ends with a blank"));
            }
        }
        let width = names.iter().map(String::len).max().unwrap_or(1);
        let per_parameter = (LABEL_BYTES / width).min(255);
        for (index, chunk) in names.chunks(per_parameter).enumerate() {
            let number = if index == 0 { String::new() } else { (index + 1).to_string() };
            let mut bytes = Vec::with_capacity(width * chunk.len());
            for label in chunk {
                bytes.extend(label.bytes().chain(std::iter::repeat(b' ')).take(width));
            }
            let count = chunk.len() as u8;
            self.record(group, &format!("LABELS{number}"), TEXT, &[width as u8, count], &bytes);
            self.record(group, &format!("DESCRIPTIONS{number}"), TEXT, &[1, count], &vec![b' '; chunk.len()]);
        }
        Ok(())
    }
}
