//! Where the frames of a C3D file lie: what header and parameters say, weighed against the bytes there are.

use super::C3dError;
use super::numbers::Source;
use super::parameters::{Parameters, shortest_decimal};
use crate::units::LengthUnit;

/// Files come in blocks of this many bytes.
pub(super) const BLOCK: usize = 512;

/// The largest count of frames that 16 bits hold: it stands in files that have more.
const CLIPPED: u64 = 65_535;

/// Where words of the header stand that parameters refine.
const POINTS_AT: usize = 2;
const FRAMES_AT: usize = 6;
const SCALE_AT: usize = 12;
const DATA_AT: usize = 16;
const RATE_AT: usize = 20;

/// How coordinates are stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Storage {
    /// 16-bit integers, to be multiplied with the scale.
    Integer {
        /// `POINT:SCALE`, units of length a step.
        scale: f64,
    },
    /// 32-bit floats in units of length.
    Real,
}

impl Storage {
    pub(super) const fn word(self) -> usize {
        match self {
            Self::Integer { .. } => 2,
            Self::Real => 4,
        }
    }

    /// Its name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Integer { .. } => "integer",
            Self::Real => "real",
        }
    }
}

/// Where and how the points are stored.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    pub storage: Storage,
    pub points: usize,
    pub frames: usize,
    pub first_frame: i64,
    pub rate_hz: f64,
    pub data_at: usize,
    pub frame_length: usize,
    pub unit: LengthUnit,
    pub unit_assumed: bool,
}

/// A count of frames and the field that gives it.
#[derive(Clone, Copy)]
struct Count {
    frames: u64,
    said_by: &'static str,
}

impl Layout {
    /// Reads the 12 words of the header and the parameters that refine them.
    pub fn read(source: &Source<'_>, parameters: &Parameters) -> Result<Self, C3dError> {
        let word = |index: usize| source.u16(2 * (index - 1), "the header");
        let header_float = |index: usize| source.f32(2 * (index - 1), "the header").map(shortest_decimal);
        let rate_hz = match parameters.number("POINT:RATE")? {
            Some(rate) if rate.is_finite() && rate > 0.0 => rate,
            _ => header_float(11)?,
        };
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            let what = "frames a second must be above 0, here and in the header";
            let at = parameters.place("POINT:RATE", RATE_AT);
            return Err(C3dError::Value { at, name: "POINT:RATE", value: rate_hz.to_string(), what });
        }
        let (unit, unit_assumed) = unit(parameters)?;
        let data = data_places(word(9)?, parameters)?;
        let first_frame = match field(parameters, "TRIAL:ACTUAL_START_FIELD")? {
            Some(first) => first.cast_signed(),
            None => i64::from(word(4)?),
        };
        let statements = Statements::read(source, parameters)?;
        let Fit { data_at, storage, points, frames, frame_length } = statements.fit(&data, source.bytes.len())?;
        if frames == 0 && points > usize::from(u16::MAX) {
            // Nothing in the file bears witness to so many.
            let what = "more points than a header can count, and no frame";
            let at = parameters.place("POINT:USED", POINTS_AT);
            return Err(C3dError::Value { at, name: "POINT:USED", value: points.to_string(), what });
        }
        Ok(Self { storage, points, frames, first_frame, rate_hz, data_at, frame_length, unit, unit_assumed })
    }
}

/// Where the frames may begin, the most trusted place first: the header says, and `POINT:DATA_START`.
fn data_places(header: u16, parameters: &Parameters) -> Result<Vec<usize>, C3dError> {
    let stated = parameters.number("POINT:DATA_START")?;
    let blocks = [Some(f64::from(header)), stated];
    let mut places = Vec::with_capacity(2);
    for block in blocks.into_iter().flatten().filter(|block| (2.0..=f64::from(u16::MAX)).contains(block)) {
        let place = (block as usize - 1) * BLOCK;
        if !places.contains(&place) {
            places.push(place);
        }
    }
    if places.is_empty() {
        let what = "frames cannot begin inside the header";
        let (at, value) = (parameters.place("POINT:DATA_START", DATA_AT), stated.unwrap_or(f64::from(header)));
        return Err(C3dError::Value { at, name: "POINT:DATA_START", value: value.to_string(), what });
    }
    Ok(places)
}

fn unit(parameters: &Parameters) -> Result<(LengthUnit, bool), C3dError> {
    let texts = parameters.texts("POINT:UNITS")?;
    match texts.first().map(String::as_str) {
        None | Some("") => Ok((LengthUnit::Millimetre, true)),
        Some(text) => match LengthUnit::from_text(text) {
            Some(unit) => Ok((unit, false)),
            None => Err(C3dError::Unit { at: parameters.place("POINT:UNITS", 0), unit: text.to_owned() }),
        },
    }
}

/// A count that a parameter stores as some number.
fn whole(parameters: &Parameters, name: &'static str, number: f64) -> Result<u64, C3dError> {
    if number.is_finite() && (0.0..=f64::from(u32::MAX)).contains(&number) {
        Ok(number as u64)
    } else {
        let at = parameters.place(name, 0);
        Err(C3dError::Value { at, name, value: number.to_string(), what: "it must be a count" })
    }
}

/// A frame number of the TRIAL group: one number, or the low and the high 16 bits of one.
fn field(parameters: &Parameters, name: &'static str) -> Result<Option<u64>, C3dError> {
    Ok(match parameters.numbers(name)? {
        [] => None,
        [one] => Some(whole(parameters, name, *one)?),
        [low, high, ..] => Some(whole(parameters, name, *low)? + (whole(parameters, name, *high)? << 16)),
    })
}

/// What the file says about its frames, in each list the most trusted statement first. Parameters come before the
/// header, whose fields some writers leave behind.
struct Statements {
    storages: Vec<Storage>,
    points: Vec<usize>,
    /// Analog samples a frame.
    samples: Vec<usize>,
    counts: Vec<Count>,
    /// Where the parameters `POINT:USED`, `POINT:SCALE` and that of the first count stand.
    places: [usize; 3],
}

/// How the frames lie in the file.
struct Fit {
    data_at: usize,
    storage: Storage,
    points: usize,
    frames: usize,
    frame_length: usize,
}

impl Statements {
    fn read(source: &Source<'_>, parameters: &Parameters) -> Result<Self, C3dError> {
        let header_points = usize::from(source.u16(2, "the header")?);
        let mut points = match parameters.number("POINT:USED")? {
            Some(used) => vec![whole(parameters, "POINT:USED", used)? as usize, header_points],
            None => vec![header_points],
        };
        points.dedup();
        let scales = [parameters.number("POINT:SCALE")?, Some(shortest_decimal(source.f32(12, "the header")?))];
        let mut storages: Vec<Storage> = Vec::new();
        for scale in scales.into_iter().flatten().filter(|scale| scale.is_finite() && *scale != 0.0) {
            let storage = if scale > 0.0 { Storage::Integer { scale } } else { Storage::Real };
            if storages.iter().all(|other| other.word() != storage.word()) {
                storages.push(storage);
            }
        }
        if storages.is_empty() {
            if points.iter().any(|points| *points > 0) {
                let what = "it must be positive (integer data) or negative (real data), here or in the header";
                let value = scales[0].unwrap_or_default().to_string();
                let at = parameters.place("POINT:SCALE", SCALE_AT);
                return Err(C3dError::Value { at, name: "POINT:SCALE", value, what });
            }
            storages.push(Storage::Real);
        }
        let counts = counts(source, parameters)?;
        let count_at = counts.first().map_or(FRAMES_AT, |count| parameters.place(count.said_by, FRAMES_AT));
        let places = [parameters.place("POINT:USED", POINTS_AT), parameters.place("POINT:SCALE", SCALE_AT), count_at];
        Ok(Self { storages, points, samples: samples(source, parameters)?, counts, places })
    }

    /// What fits the file.
    ///
    /// The first combination of statements that accounts for the file up to its last block holds. Where none does,
    /// the most trusted ones hold if the file has room for them and nothing contradicts what a frame looks like;
    /// otherwise frames would be cut at the wrong places and every coordinate be wrong.
    fn fit(&self, data: &[usize], have: usize) -> Result<Fit, C3dError> {
        for count in &self.counts {
            for storage in &self.storages {
                for points in &self.points {
                    for samples in &self.samples {
                        for data_at in data {
                            let fit = Fit::of(*data_at, *storage, *points, *samples, *count);
                            let need = count.frames.saturating_mul(fit.frame_length as u64);
                            let rest =
                                (have as u64).checked_sub(*data_at as u64).and_then(|room| room.checked_sub(need));
                            let explained = rest.is_some_and(|rest| rest < BLOCK as u64);
                            if explained && (fit.frame_length > 0 || count.frames == 0) {
                                return Ok(fit);
                            }
                        }
                    }
                }
            }
        }
        // No list is empty: each ends with what the header says.
        let first = self.counts[0];
        let data_at = data[0];
        let room = have.saturating_sub(data_at) as u64;
        let [used_at, scale_at, count_at] = self.places;
        let fit = Fit::of(data_at, self.storages[0], self.points[0], self.samples[0], first);
        if fit.frame_length == 0 {
            // Neither points nor analog samples: nothing is stored for any frame.
            return Ok(Fit { frames: 0, ..fit });
        }
        let length = fit.frame_length as u64;
        let need = first.frames.saturating_mul(length);
        if need > room {
            let frame = room / length;
            return Err(C3dError::ShortFrames {
                frame: frame + 1,
                frames: first.frames,
                source_of_count: first.said_by,
                begins: data_at as u64 + frame * length,
                length,
                have,
            });
        }
        if first.frames == CLIPPED {
            let what = "the largest number it holds, and the file goes on; state the count in POINT:LONG_FRAMES";
            return Err(C3dError::Value { at: count_at, name: first.said_by, value: CLIPPED.to_string(), what });
        }
        let contradiction =
            |at, name, value: String, header: String| C3dError::Contradiction { at, name, value, header };
        match (self.points.as_slice(), self.storages.as_slice()) {
            ([used, header], _) => Err(contradiction(used_at, "POINT:USED", used.to_string(), header.to_string())),
            (_, [one, other]) => {
                Err(contradiction(scale_at, "POINT:SCALE", one.name().to_owned(), other.name().to_owned()))
            }
            _ => Ok(fit),
        }
    }
}

impl Fit {
    fn of(data_at: usize, storage: Storage, points: usize, samples: usize, count: Count) -> Self {
        let frame_length = (4 * points + samples) * storage.word();
        Self { data_at, storage, points, frames: count.frames as usize, frame_length }
    }
}

/// How many analog samples a frame may have: the header says, or ANALOG:USED times the ratio of ANALOG:RATE to
/// POINT:RATE.
fn samples(source: &Source<'_>, parameters: &Parameters) -> Result<Vec<usize>, C3dError> {
    let mut samples = vec![usize::from(source.u16(4, "the header")?)];
    let used = parameters.number("ANALOG:USED")?.unwrap_or(0.0);
    let by_rate = match (parameters.number("ANALOG:RATE")?, parameters.number("POINT:RATE")?) {
        (Some(analog), Some(points)) if points > 0.0 && analog > 0.0 => used * (analog / points).round(),
        _ => used,
    };
    if (0.0..=65_535.0).contains(&by_rate) && !samples.contains(&(by_rate as usize)) {
        samples.push(by_rate as usize);
    }
    Ok(samples)
}

/// How many frames there may be, the most trusted statement first.
fn counts(source: &Source<'_>, parameters: &Parameters) -> Result<Vec<Count>, C3dError> {
    let mut counts = Vec::new();
    let start = field(parameters, "TRIAL:ACTUAL_START_FIELD")?;
    let end = field(parameters, "TRIAL:ACTUAL_END_FIELD")?;
    if let (Some(start), Some(end)) = (start, end)
        && end >= start
    {
        counts.push(Count { frames: end - start + 1, said_by: "TRIAL:ACTUAL_END_FIELD" });
    }
    if let Some(long) = parameters.number("POINT:LONG_FRAMES")? {
        counts.push(Count { frames: whole(parameters, "POINT:LONG_FRAMES", long)?, said_by: "POINT:LONG_FRAMES" });
    }
    if let Some(frames) = parameters.number("POINT:FRAMES")? {
        counts.push(Count { frames: whole(parameters, "POINT:FRAMES", frames)?, said_by: "POINT:FRAMES" });
    }
    let (first, last) = (u64::from(source.u16(6, "the header")?), u64::from(source.u16(8, "the header")?));
    counts.push(Count { frames: (last + 1).saturating_sub(first), said_by: "the header" });
    Ok(counts)
}
