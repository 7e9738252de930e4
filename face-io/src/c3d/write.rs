//! Writes markers as a C3D file, for the number formats of any processor; without analog samples.

use super::fields::Fields;
use super::layout::BLOCK;
use super::numbers::Processor;
use crate::WriteError;
use crate::units::LengthUnit;
use face_math::data::Markers;
use glam::Vec3;

/// In which of its flavours a C3D file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Flavour {
    /// Whose number formats it has.
    pub processor: Processor,
    /// Whether coordinates are stored as 16-bit integers, in steps of the largest one / 32,767, in place of reals.
    pub integers: bool,
}

impl Flavour {
    /// What every reader understands, and what keeps every bit: PC numbers, real.
    pub const PLAIN: Self = Self { processor: Processor::Intel, integers: false };
}

/// Writes markers as C3D with coordinates in `unit`. Missing points are zeros with residual -1.
///
/// In real flavours of PC and MIPS, markers that were read from a file in the same unit (or any, written in metres) read back bit
/// for bit; in that of DEC, those from 2⁻¹²⁸ up.
///
/// # Errors
/// Where names, counts, the rate or a coordinate do not fit the format.
pub fn write(markers: &Markers, unit: LengthUnit, flavour: Flavour) -> Result<Vec<u8>, WriteError> {
    let axis = markers.frame_axis();
    let points = range("number of markers", markers.names().len() as f64, 0.0, 65_535.0)? as u16;
    let limit = f64::from(u32::MAX - 1);
    let first = range("first frame", axis.first as f64, 0.0, limit)? as u32;
    let last = range("last frame", f64::from(first) + axis.count as f64 - 1.0, -1.0, limit)?;
    let rate = range("frame rate", axis.rate_hz, f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX))? as f32;
    let scale = if flavour.integers { step(markers, unit)? } else { -1.0 };

    let number = |number: f32| flavour.processor.f32_bytes(number).ok_or_else(|| too_large(number));
    let (rate_bytes, scale_bytes) = (number(rate)?, number(scale)?);
    let fields = Fields { markers, unit, first, last: last.max(0.0) as u32, rate: rate_bytes, scale: scale_bytes };
    let (parameters, data_start_at) = fields.bytes(flavour.processor)?;
    let parameter_blocks = (4 + parameters.len()).div_ceil(BLOCK);
    let data_block = range("block of the first frame", (2 + parameter_blocks) as f64, 0.0, 32_767.0)? as u16;

    let mut bytes = vec![0; BLOCK];
    bytes[0] = 2;
    bytes[1] = 0x50;
    let word = |number: u16| flavour.processor.u16_bytes(number);
    let clipped = |number: f64| number.clamp(0.0, 65_535.0) as u16;
    // Points, first and last frame, the longest gap that was filled, where the frames begin, analog samples a frame and channel.
    for (index, number) in
        [(2, points), (4, clipped(f64::from(first))), (5, clipped(last)), (6, 10), (9, data_block), (10, 1)]
    {
        bytes[2 * (index - 1)..2 * index].copy_from_slice(&word(number));
    }
    bytes[12..16].copy_from_slice(&scale_bytes);
    bytes[20..24].copy_from_slice(&rate_bytes);

    // A section of more than 255 blocks is found by its end at the data.
    bytes.extend([1, 0x50, parameter_blocks.min(255) as u8, flavour.processor.byte()]);
    let data_start_at = bytes.len() + data_start_at;
    bytes.extend(&parameters);
    bytes[data_start_at..data_start_at + 2].copy_from_slice(&word(data_block));
    bytes.resize((usize::from(data_block) - 1) * BLOCK, 0);

    bytes.reserve(markers.positions().len() * 16 + BLOCK);
    for point in markers.positions() {
        if flavour.integers {
            let steps = |coordinate: f32| (unit.from_metres(coordinate) / scale).round() as i16;
            let words = if point.is_nan() { [0, 0, 0, -1] } else { integers(*point, steps) };
            bytes.extend(words.into_iter().flat_map(|number| word(number.cast_unsigned())));
        } else {
            for real in if point.is_nan() { [0.0, 0.0, 0.0, -1.0] } else { reals(*point, unit) } {
                bytes.extend(number(real)?);
            }
        }
    }
    bytes.resize(bytes.len().div_ceil(BLOCK) * BLOCK, 0);
    Ok(bytes)
}

/// A point that is there, with a residual of 0.
fn reals(point: Vec3, unit: LengthUnit) -> [f32; 4] {
    let [x, y, z] = point.to_array().map(|coordinate| unit.from_metres(coordinate));
    [x, y, z, 0.0]
}

fn integers(point: Vec3, steps: impl Fn(f32) -> i16) -> [i16; 4] {
    let [x, y, z] = point.to_array().map(steps);
    [x, y, z, 0]
}

/// The length of one step of integer coordinates: the least with which the largest of them fits.
fn step(markers: &Markers, unit: LengthUnit) -> Result<f32, WriteError> {
    let there = markers.positions().iter().filter(|point| !point.is_nan());
    let largest = there.map(|point| point.abs().max_element()).fold(0.0, f32::max);
    let largest = unit.from_metres(largest);
    if !largest.is_finite() {
        return Err(too_large(largest));
    }
    // Rounded up, so that the largest is not a step too many.
    let step = (largest / f32::from(i16::MAX)).next_up().max(f32::MIN_POSITIVE);
    Ok(if largest > 0.0 { step } else { 1.0 })
}

fn too_large(value: f32) -> WriteError {
    let limit = 126.0_f64.exp2();
    WriteError::Range { format: "C3D", what: "coordinate".into(), value: f64::from(value), low: -limit, high: limit }
}

fn range(what: &str, value: f64, low: f64, high: f64) -> Result<f64, WriteError> {
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(WriteError::Range { format: "C3D", what: what.to_owned(), value, low, high })
    }
}
