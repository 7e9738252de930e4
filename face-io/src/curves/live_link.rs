//! Recordings of Live Link Face: `Timecode`, `BlendshapeCount`, 52 `ARKit` shapes, and the rotations of head and eyes.

use super::CurveTable;
use super::clock::{Clock, Gap, Timing};
use super::timecode::Timecode;
use crate::WriteError;
use crate::csv::{CsvError, Row, Table, column_error};
use face_math::data::{Curves, nearest_name};
use std::fmt::Write;

const FORMAT: &str = "Live Link Face CSV";

/// The shapes of `ARKit`, in the order of the columns of a recording.
const SHAPES: [&str; 52] = [
    "EyeBlinkLeft",
    "EyeLookDownLeft",
    "EyeLookInLeft",
    "EyeLookOutLeft",
    "EyeLookUpLeft",
    "EyeSquintLeft",
    "EyeWideLeft",
    "EyeBlinkRight",
    "EyeLookDownRight",
    "EyeLookInRight",
    "EyeLookOutRight",
    "EyeLookUpRight",
    "EyeSquintRight",
    "EyeWideRight",
    "JawForward",
    "JawRight",
    "JawLeft",
    "JawOpen",
    "MouthClose",
    "MouthFunnel",
    "MouthPucker",
    "MouthRight",
    "MouthLeft",
    "MouthSmileLeft",
    "MouthSmileRight",
    "MouthFrownLeft",
    "MouthFrownRight",
    "MouthDimpleLeft",
    "MouthDimpleRight",
    "MouthStretchLeft",
    "MouthStretchRight",
    "MouthRollLower",
    "MouthRollUpper",
    "MouthShrugLower",
    "MouthShrugUpper",
    "MouthPressLeft",
    "MouthPressRight",
    "MouthLowerDownLeft",
    "MouthLowerDownRight",
    "MouthUpperUpLeft",
    "MouthUpperUpRight",
    "BrowDownLeft",
    "BrowDownRight",
    "BrowInnerUp",
    "BrowOuterUpLeft",
    "BrowOuterUpRight",
    "CheekPuff",
    "CheekSquintLeft",
    "CheekSquintRight",
    "NoseSneerLeft",
    "NoseSneerRight",
    "TongueOut",
];

/// Rotations that a recording holds after the shapes. They move head and eyes, not the face, and are kept apart.
const POSE: [&str; 9] = [
    "HeadYaw",
    "HeadPitch",
    "HeadRoll",
    "LeftEyeYaw",
    "LeftEyePitch",
    "LeftEyeRoll",
    "RightEyeYaw",
    "RightEyePitch",
    "RightEyeRoll",
];

/// What a recording of Live Link Face holds beside the channels.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveLink {
    /// The first timecode, as it stands in the file.
    pub first_timecode: String,
    /// Names of the rotations of head and eyes in the file.
    pub pose_names: Vec<String>,
    /// Their values as the file has them, `frames × pose_names`.
    pub pose: Vec<f32>,
    /// Columns that are neither shapes nor rotations; they are not read.
    pub unmapped: Vec<String>,
    /// Frames that were interpolated where the recording lost rows.
    pub filled_frames: usize,
    /// Rows that repeat the time of another one.
    pub repeated_rows: usize,
    /// Where rows were lost, in their order.
    pub gaps: Vec<Gap>,
}

pub(super) fn detect(table: &Table<'_>) -> bool {
    table.names.cells.len() > 2
        && table.name(0).eq_ignore_ascii_case("timecode")
        && table.name(1).eq_ignore_ascii_case("blendshapecount")
}

/// The channels that a shape drives: `EyeBlinkLeft` is `eyeBlink_L`; `BrowInnerUp` and `CheekPuff` drive both sides;
/// `JawLeft` and its like are directions, not sides.
fn channels_of(shape: &str) -> Vec<String> {
    let mut letters = shape.chars();
    let plain: String = letters.next().into_iter().flat_map(char::to_lowercase).chain(letters).collect();
    match shape {
        "BrowInnerUp" | "CheekPuff" => vec![format!("{plain}_L"), format!("{plain}_R")],
        "JawLeft" | "JawRight" | "MouthLeft" | "MouthRight" => vec![plain],
        _ => vec![match (plain.strip_suffix("Left"), plain.strip_suffix("Right")) {
            (Some(stem), _) => format!("{stem}_L"),
            (_, Some(stem)) => format!("{stem}_R"),
            _ => plain,
        }],
    }
}

pub(super) fn read(table: &Table<'_>, timing: Timing) -> Result<CurveTable, CsvError> {
    let (mut channels, mut columns) = (Vec::new(), Vec::new());
    let (mut pose_names, mut pose_columns, mut unmapped) = (Vec::new(), Vec::new(), Vec::new());
    for (column, cell) in table.names.cells.iter().enumerate().skip(2) {
        let find = |names: &[&'static str]| names.iter().copied().find(|name| name.eq_ignore_ascii_case(&cell.text));
        if let Some(shape) = find(&SHAPES) {
            for channel in channels_of(shape) {
                channels.push(channel);
                columns.push(column);
            }
        } else if let Some(pose) = find(&POSE) {
            pose_names.push(pose.to_owned());
            pose_columns.push(column);
        } else {
            unmapped.push(cell.text.to_string());
        }
    }
    if channels.is_empty() {
        let cell = &table.names.cells[2];
        let near = nearest_name(&cell.text, SHAPES).map_or(String::new(), |near| format!("; did you mean `{near}`?"));
        return Err(column_error(&table.names, cell, format!("no column is one of the 52 ARKit shapes{near}")));
    }
    for row in &table.rows {
        if !row.cells[1].text.parse::<usize>().is_ok_and(|count| count > 0) {
            return Err(table.cell_error(
                row,
                1,
                "a count of shapes above 0; the face was lost in this row, cut it off",
            ));
        }
    }
    let clock = Clock::read(table, 0, timing)?;
    let values = resampled(table, &clock, &columns)?;
    let pose = resampled(table, &clock, &pose_columns)?;
    let first_timecode = table.rows.first().map_or(String::new(), |row: &Row<'_>| row.cells[0].text.to_string());
    Ok(CurveTable {
        channels,
        first_frame: 0,
        frames: clock.frames.len(),
        rate_hz: clock.rate_hz,
        values,
        live_link: Some(LiveLink {
            first_timecode,
            pose_names,
            pose,
            unmapped,
            filled_frames: clock.filled,
            repeated_rows: clock.repeated,
            gaps: clock.gaps,
        }),
    })
}

/// The numbers in some columns at the times of the clock's frames, between rows on the straight line.
fn resampled(table: &Table<'_>, clock: &Clock, columns: &[usize]) -> Result<Vec<f32>, CsvError> {
    let mut rows = Vec::with_capacity(table.rows.len() * columns.len());
    for row in &table.rows {
        for column in columns {
            rows.push(table.number(row, *column)?);
        }
    }
    let value = |row: usize, column: usize| rows[row * columns.len() + column];
    Ok(clock
        .frames
        .iter()
        .flat_map(|(row, share)| {
            (0..columns.len()).map(move |column| {
                let here = value(*row, column);
                if *share == 0.0 { here } else { here + (value(row + 1, column) - here) * *share as f32 }
            })
        })
        .collect())
}

pub(super) fn write(curves: &Curves, first: Timecode) -> Result<Vec<u8>, WriteError> {
    let known: Vec<Vec<String>> = SHAPES.iter().map(|shape| channels_of(shape)).collect();
    if let Some(name) = curves.channels().iter().find(|name| !known.iter().flatten().any(|channel| channel == *name)) {
        let problem = "is none of the channels that Live Link Face records";
        return Err(WriteError::Name { format: FORMAT, name: name.clone(), problem });
    }
    // Rigs without a tongue are common; what else is absent would be read back as a face that never moves there.
    let columns: Vec<Vec<usize>> =
        known.iter().map(|channels| channels.iter().filter_map(|channel| curves.index(channel)).collect()).collect();
    if let Some(at) = (0..SHAPES.len()).find(|at| columns[*at].is_empty() && SHAPES[*at] != "TongueOut") {
        let problem = "is absent, but Live Link Face records it";
        return Err(WriteError::Name { format: FORMAT, name: known[at][0].clone(), problem });
    }
    let axis = curves.frame_axis();
    let (base, first_frame) = count_from(first, axis.rate_hz)?;
    let mut out = format!("Timecode,BlendshapeCount,{}\n", SHAPES.join(","));
    for frame in 0..curves.frames() {
        let code = Timecode::of_frames(first_frame + frame as u64, base, first.drop_frame);
        let _ = write!(out, "{code},{}", SHAPES.len());
        for columns in &columns {
            let values = curves.frame(frame);
            let value = match columns.as_slice() {
                [] => 0.0,
                [one] => values[*one],
                many => many.iter().map(|column| values[*column]).sum::<f32>() / many.len() as f32,
            };
            if !value.is_finite() {
                let what = format!("channel `{}`", curves.channels()[columns[0]]);
                let frame = axis.first + frame.cast_signed() as i64;
                return Err(WriteError::NotFinite { format: FORMAT, what, frame, value });
            }
            let _ = write!(out, ",{value}");
        }
        out.push('\n');
    }
    Ok(out.into_bytes())
}

/// Frames counted a second at `rate_hz`, and the number since midnight of the frame at `first`.
fn count_from(first: Timecode, rate_hz: f64) -> Result<(u32, u64), WriteError> {
    let out_of = |value: f64, what: &str, low: f64, high: f64| WriteError::Range {
        format: FORMAT,
        what: what.to_owned(),
        value,
        low,
        high,
    };
    let base = rate_hz.round();
    if !(1.0..=1000.0).contains(&base) {
        return Err(out_of(rate_hz, "frame rate", 1.0, 1000.0));
    }
    let wrong = |problem| WriteError::Name { format: FORMAT, name: first.to_string(), problem };
    let drops = (base as u32).is_multiple_of(30) && (rate_hz - Timecode::rate_hz(base, true)).abs() < 0.01;
    if first.drop_frame && !drops {
        return Err(wrong("is a drop-frame timecode, which needs curves at 29.97, 59.94 or 119.88 Hz"));
    }
    if first.frame.fract() != 0.0 || first.frame >= base {
        return Err(wrong("does not name a whole frame of this rate"));
    }
    if first.is_left_out(base) {
        return Err(wrong("does not exist, since drop-frame counting leaves it out"));
    }
    Ok((base as u32, first.frames(base) as u64))
}
