//! Writes markers as a C3D file: Intel, real data, no analog samples.

use super::layout::BLOCK;
use crate::WriteError;
use crate::units::LengthUnit;
use face_math::data::Markers;

/// Labels in one parameter: more than this many bytes of them are split into LABELS2, LABELS3 …, so that the distance
/// to the next parameter stays within the 16 signed bits that all readers understand.
const LABEL_BYTES: usize = 32_000;

/// Writes markers as C3D with coordinates in `unit`. Missing points are zeros with residual -1.
///
/// Markers that were read from a file in the same unit (or any, written in metres) read back bit for bit.
///
/// # Errors
/// Where names, counts or the rate do not fit the format.
pub fn write(markers: &Markers, unit: LengthUnit) -> Result<Vec<u8>, WriteError> {
    let axis = markers.frame_axis();
    let points = range("number of markers", markers.names().len() as f64, 0.0, 65_535.0)? as u16;
    let limit = f64::from(u32::MAX - 1);
    let first = range("first frame", axis.first as f64, 0.0, limit)? as u32;
    let last = range("last frame", f64::from(first) + axis.count as f64 - 1.0, -1.0, limit)?;
    let rate = range("frame rate", axis.rate_hz, f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX))? as f32;
    let parameters = parameters(markers, unit, first, last, rate)?;
    let parameter_blocks = (4 + parameters.len()).div_ceil(BLOCK);
    let data_block =
        range("block of the first frame", (2 + parameter_blocks) as f64, 0.0, 32_767.0).map(|block| block as u16)?;

    let mut bytes = vec![0; BLOCK];
    bytes[0] = 2;
    bytes[1] = 0x50;
    let clipped = |number: f64| number.clamp(0.0, 65_535.0) as u16;
    let words: [(usize, u16); 5] =
        [(2, points), (4, clipped(f64::from(first))), (5, clipped(last)), (6, 10), (9, data_block)];
    for (index, word) in words {
        bytes[2 * (index - 1)..2 * index].copy_from_slice(&word.to_le_bytes());
    }
    bytes[12..16].copy_from_slice(&(-1.0_f32).to_le_bytes());
    bytes[20..24].copy_from_slice(&rate.to_le_bytes());

    // A section of more than 255 blocks is found by its end at the data.
    bytes.extend([1, 0x50, parameter_blocks.min(255) as u8, 84]);
    bytes.extend(&parameters);
    patch_data_start(&mut bytes, data_block);
    bytes.resize((usize::from(data_block) - 1) * BLOCK, 0);
    bytes.reserve(markers.positions().len() * 16 + BLOCK);
    for point in markers.positions() {
        let (coordinates, residual) = if point.is_nan() {
            ([0.0; 3], -1.0_f32)
        } else {
            (point.to_array().map(|coordinate| unit.from_metres(coordinate)), 0.0)
        };
        for number in [coordinates[0], coordinates[1], coordinates[2], residual] {
            bytes.extend(number.to_le_bytes());
        }
    }
    bytes.resize(bytes.len().div_ceil(BLOCK) * BLOCK, 0);
    Ok(bytes)
}

fn range(what: &str, value: f64, low: f64, high: f64) -> Result<f64, WriteError> {
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(WriteError::Range { format: "C3D", what: what.to_owned(), value, low, high })
    }
}

/// `POINT:DATA_START` is the last parameter; after its word come its empty description and the two closing zeros.
fn patch_data_start(bytes: &mut [u8], data_block: u16) {
    let at = bytes.len() - 5;
    bytes[at..at + 2].copy_from_slice(&data_block.to_le_bytes());
}

fn parameters(markers: &Markers, unit: LengthUnit, first: u32, last: f64, rate: f32) -> Result<Vec<u8>, WriteError> {
    const POINT: i8 = 1;
    const TRIAL: i8 = 2;
    let frames = markers.frames();
    let last = last.max(0.0) as u32;
    let mut out = Vec::new();
    group(&mut out, POINT, "POINT");
    group(&mut out, TRIAL, "TRIAL");
    let halves = |number: u32| [(number & 0xffff) as u16, (number >> 16) as u16].map(u16::to_le_bytes).concat();
    let short = |number: usize| (number.min(65_535) as u16).to_le_bytes();
    if frames > 0 {
        record(&mut out, TRIAL, "ACTUAL_START_FIELD", 2, &[2], &halves(first));
        record(&mut out, TRIAL, "ACTUAL_END_FIELD", 2, &[2], &halves(last));
    }
    record(&mut out, POINT, "USED", 2, &[], &short(markers.names().len()));
    record(&mut out, POINT, "FRAMES", 2, &[], &short(frames));
    if frames > 65_535 {
        record(&mut out, POINT, "LONG_FRAMES", 4, &[], &(frames as f32).to_le_bytes());
    }
    record(&mut out, POINT, "SCALE", 4, &[], &(-1.0_f32).to_le_bytes());
    record(&mut out, POINT, "RATE", 4, &[], &rate.to_le_bytes());
    let symbol = unit.symbol().as_bytes();
    record(&mut out, POINT, "UNITS", -1, &[symbol.len() as u8], symbol);
    labels(&mut out, POINT, markers.names())?;
    record(&mut out, POINT, "DATA_START", 2, &[], &[0; 2]);
    // A name of length 0 ends the list.
    out.extend([0, 0]);
    Ok(out)
}

fn labels(out: &mut Vec<u8>, group: i8, names: &[String]) -> Result<(), WriteError> {
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
        let name = if index == 0 { "LABELS".to_owned() } else { format!("LABELS{}", index + 1) };
        let mut bytes = Vec::with_capacity(width * chunk.len());
        for label in chunk {
            bytes.extend(label.bytes().chain(std::iter::repeat(b' ')).take(width));
        }
        record(out, group, &name, -1, &[width as u8, chunk.len() as u8], &bytes);
    }
    Ok(())
}

fn group(out: &mut Vec<u8>, number: i8, name: &str) {
    out.extend([name.len() as u8, (-number).cast_unsigned()]);
    out.extend(name.bytes());
    // Distance to the next record, and the length of the (empty) description.
    out.extend([3, 0, 0]);
}

fn record(out: &mut Vec<u8>, group: i8, name: &str, kind: i8, dimensions: &[u8], values: &[u8]) {
    out.extend([name.len() as u8, group.cast_unsigned()]);
    out.extend(name.bytes());
    let distance = (2 + 2 + dimensions.len() + values.len() + 1) as u16;
    out.extend(distance.to_le_bytes());
    out.extend([kind.cast_unsigned(), dimensions.len() as u8]);
    out.extend(dimensions);
    out.extend(values);
    out.push(0);
}
