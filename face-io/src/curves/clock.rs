//! When the rows of a recording were taken, and which frames they make: rate, lost rows, repeated rows, gaps.

use super::timecode::Timecode;
use crate::csv::{CsvError, Table};

/// Rates that cameras and timecode generators count at, in hertz.
const USUAL_HZ: [f64; 12] = [24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 72.0, 75.0, 90.0, 96.0, 100.0, 120.0];

/// How far a measured rate may lie from a usual one to be taken for it (devices run a little slow), as a fraction.
const SNAP: f64 = 0.01;

const SECONDS_A_DAY: u32 = 86_400;

/// A run of frames of which the recording has no row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Line of the first row after it.
    pub line: usize,
    /// How many frames were lost.
    pub frames: usize,
    /// How long it lasts between the rows around it, in seconds.
    pub seconds: f64,
}

/// How rows become frames.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Timing {
    /// Lays frames exactly where timecodes say that time passes, at `rate_hz` or else at the rate of the timecode.
    /// Otherwise rows that come at a steady pace are the frames themselves, whatever the device's clock says.
    pub exact: bool,
    /// Frames a second, in place of what the timecodes show.
    pub rate_hz: Option<f64>,
}

/// When the rows of a recording were taken.
pub(super) struct Clock {
    /// Frames a second of the recording; nothing where it is too short to tell.
    pub rate_hz: Option<f64>,
    /// For each frame of the recording at a steady rate the row at or before it, and how far on the way to the next
    /// one it lies (0 to 1).
    pub frames: Vec<(usize, f64)>,
    /// Frames that stand for rows that are missing, or lie between rows that came at odd times.
    pub filled: usize,
    /// Rows that repeat the time of another one.
    pub repeated: usize,
    /// Where rows are missing.
    pub gaps: Vec<Gap>,
}

impl Clock {
    /// Reads the timecodes in a column.
    ///
    /// The timecode's own base (frames a second that FF counts to) shows where FF starts anew: base = last FF before
    /// − first FF after + step, with the step from row to row. The recording's rate is base / step. All by medians,
    /// so that lost rows do not matter. A rate within 1 % of a usual one is taken for it. Drop-frame timecodes run at
    /// 1000/1001 of their base; without them 29.97 cannot be told from 30, because timecode counts whole frames.
    pub fn read(table: &Table<'_>, column: usize, timing: Timing) -> Result<Self, CsvError> {
        let mut codes = Vec::with_capacity(table.rows.len());
        for row in &table.rows {
            let code = Timecode::from_text(&row.cells[column].text)
                .ok_or_else(|| table.cell_error(row, column, "a timecode such as 18:45:19:48.451"))?;
            codes.push(code);
        }
        refuse_backwards(table, column, &codes)?;
        let pairs = || codes.iter().zip(codes.iter().skip(1));
        let steps =
            pairs().filter(|(a, b)| a.seconds == b.seconds && b.frame > a.frame).map(|(a, b)| b.frame - a.frame);
        let step = median(steps.collect());
        let base = step.and_then(|step| {
            let turns = pairs().filter(|(a, b)| (a.seconds + 1) % SECONDS_A_DAY == b.seconds);
            median(turns.map(|(a, b)| a.frame - b.frame + step).collect())
        });
        let (Some(step), Some(base)) = (step, base.map(snap).filter(|base| *base > 0.0)) else {
            let frames = (0..codes.len()).map(|row| (row, 0.0)).collect();
            return Ok(Self { rate_hz: None, frames, filled: 0, repeated: 0, gaps: Vec::new() });
        };
        let times = times(table, column, &codes, base)?;
        let drop_frame = codes.iter().any(|code| code.drop_frame);
        let base_hz = Timecode::rate_hz(base, drop_frame);
        let shown_hz = Timecode::rate_hz(snap(base / step), drop_frame);
        let rate_hz = timing.rate_hz.unwrap_or(shown_hz);
        // What is interpolated must not be more than what was recorded (a few seconds in short files aside).
        let frames = (times[times.len() - 1] - times[0]) / step;
        if frames > (2 * times.len()) as f64 + 10.0 * base / step {
            let gap = |pair: &[f64]| pair[1] - pair[0];
            let longest = times.windows(2).enumerate().max_by(|a, b| gap(a.1).total_cmp(&gap(b.1)));
            let (index, seconds) = longest.map_or((0, 0.0), |(index, pair)| (index + 1, gap(pair) / base_hz));
            return Err(CsvError::Gap { line: table.rows[index].line, seconds: seconds as u64 });
        }
        let lost = |(row, pair): (usize, &[f64])| {
            let steps = (pair[1] - pair[0]) / step;
            let seconds = (pair[1] - pair[0]) / base_hz;
            (steps > 1.5).then(|| Gap { line: table.rows[row + 1].line, frames: steps.round() as usize - 1, seconds })
        };
        let gaps = times.windows(2).enumerate().filter_map(lost).collect();
        // Frames of timecode from one frame to the next.
        let (wanted, by_rows) = if timing.exact { (base_hz / rate_hz, false) } else { (step, true) };
        if timing.exact && (times[times.len() - 1] - times[0]) / wanted > MOST_FRAMES {
            return Err(CsvError::Rate { line: table.names.line, text: format!("{rate_hz} Hz makes too many frames") });
        }
        Ok(Self { rate_hz: Some(rate_hz), gaps, ..laid(&times, step, wanted, by_rows) })
    }
}

/// More frames than this are no recording of a face.
const MOST_FRAMES: f64 = 1e7;

/// Refuses timecodes that go backwards other than at midnight.
fn refuse_backwards(table: &Table<'_>, column: usize, codes: &[Timecode]) -> Result<(), CsvError> {
    let turns_back = |pair: &[Timecode]| {
        let midnight = pair[0].seconds > pair[1].seconds + SECONDS_A_DAY / 2;
        !midnight && (pair[1].seconds, pair[1].frame + 1e-6) < (pair[0].seconds, pair[0].frame)
    };
    let Some(index) = codes.windows(2).position(turns_back) else { return Ok(()) };
    let text = |index: usize| table.rows[index].cells[column].text.to_string();
    Err(CsvError::Backwards { line: table.rows[index + 1].line, before: text(index), found: text(index + 1) })
}

/// When each row was taken, in frames of timecode since midnight before the first.
fn times(table: &Table<'_>, column: usize, codes: &[Timecode], base: f64) -> Result<Vec<f64>, CsvError> {
    let mut times: Vec<f64> = Vec::with_capacity(codes.len());
    let mut midnights = 0.0;
    for (index, code) in codes.iter().enumerate() {
        if code.is_left_out(base) {
            let wanted = "a timecode that exists: drop-frame counting leaves this number out";
            return Err(table.cell_error(&table.rows[index], column, wanted));
        }
        if index > 0 && codes[index - 1].seconds > code.seconds + SECONDS_A_DAY / 2 {
            midnights += Timecode::frames_a_day(base, code.drop_frame);
        }
        times.push(midnights + code.frames(base));
    }
    Ok(times)
}

/// Lays frames `wanted` apart over rows at `times` that come `step` apart. Where `by_rows` is set, rows that come at
/// steady times are the frames themselves.
fn laid(times: &[f64], step: f64, wanted: f64, by_rows: bool) -> Clock {
    let regular = |pair: &[f64]| ((pair[1] - pair[0]) / step - 1.0).abs() < 0.5;
    if by_rows && times.windows(2).all(regular) {
        let frames = (0..times.len()).map(|row| (row, 0.0)).collect();
        return Clock { rate_hz: None, frames, filled: 0, repeated: 0, gaps: Vec::new() };
    }
    let (first, last) = (times[0], times[times.len() - 1]);
    let steps = (last - first) / wanted;
    // Rows alone may round their last frame up; exact times end with the last one that was recorded.
    let count = if by_rows { steps.round() } else { (steps + 1e-6).floor() } as usize + 1;
    let (mut frames, mut row, mut filled) = (Vec::new(), 0, 0);
    for frame in 0..count {
        let time = (first + frame as f64 * wanted).min(last);
        while row + 1 < times.len() && times[row + 1] <= time {
            row += 1;
        }
        let share = match times.get(row + 1) {
            Some(next) => (time - times[row]) / (next - times[row]),
            None => 0.0,
        };
        let near = |row: usize| times.get(row).is_some_and(|other| (other - time).abs() < 0.5 * step);
        filled += usize::from(!near(row) && !near(row + 1));
        frames.push((row, share));
    }
    let repeated = times.windows(2).filter(|pair| pair[1] - pair[0] < 0.5 * step).count();
    Clock { rate_hz: None, frames, filled, repeated, gaps: Vec::new() }
}

fn snap(rate: f64) -> f64 {
    let usual = USUAL_HZ.into_iter().find(|usual| (rate / usual - 1.0).abs() < SNAP);
    usual.unwrap_or(rate)
}

fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;

    /// A table of timecodes at the given times in frames of `base` a second.
    fn clock(base: u32, times: &[f64]) -> Result<Clock, CsvError> {
        let mut text = "Timecode\n".to_owned();
        for time in times {
            let seconds = (time / f64::from(base)).floor();
            let whole = seconds as u32 % SECONDS_A_DAY;
            let frame = time - seconds * f64::from(base);
            writeln!(text, "{:02}:{:02}:{:02}:{frame:06.3}", whole / 3600, whole / 60 % 60, whole % 60).unwrap();
        }
        Clock::read(&Table::read(&text).unwrap(), 0, Timing::default())
    }

    #[test]
    fn rates_come_from_the_timecodes_alone() {
        let run = |base: u32, step: f64| {
            let times: Vec<_> = (0..400).map(|row| 17.2 + f64::from(row) * step).collect();
            let clock = clock(base, &times).unwrap();
            assert_eq!((clock.frames.len(), clock.filled, clock.repeated), (400, 0, 0));
            clock.rate_hz.unwrap()
        };
        for (base, step, rate) in [(60, 1.0016, 60.0), (60, 2.0, 30.0), (30, 1.0, 30.0), (24, 0.4, 60.0)] {
            assert!((run(base, step) - rate).abs() < 1e-9, "{base} {step}");
        }
        assert!((run(60, 1.5) - 40.0).abs() < 0.05);
        let short: Vec<_> = (0..20).map(f64::from).collect();
        assert_eq!(clock(60, &short).unwrap().rate_hz, None);
    }

    #[test]
    fn lost_and_repeated_rows_keep_their_time() {
        let mut times: Vec<_> = (0..200).map(f64::from).collect();
        times.remove(100);
        times.remove(100);
        times.insert(50, 50.0);
        let clock = clock(60, &times).unwrap();
        assert_eq!((clock.frames.len(), clock.filled, clock.repeated), (200, 2, 1));
        let at = |frame: usize| {
            let (row, share) = clock.frames[frame];
            times[row] + if share > 0.0 { share * (times[row + 1] - times[row]) } else { 0.0 }
        };
        assert!((0..200).all(|frame| (at(frame) - frame as f64).abs() < 1e-6));
    }

    #[test]
    fn midnight_passes_and_time_does_not_turn_back() {
        let day = f64::from(SECONDS_A_DAY) * 60.0;
        let times: Vec<_> = (0..200).map(|row| day - 100.0 + f64::from(row)).collect();
        assert_eq!(clock(60, &times).unwrap().filled, 0);
        assert!(matches!(clock(60, &[0.0, 1.0, 70.0, 69.0, 130.0]), Err(CsvError::Backwards { line: 5, .. })));
        let apart: Vec<_> = (0..100).map(|row| f64::from(row) + if row < 70 { 0.0 } else { 60_000.0 }).collect();
        assert!(matches!(clock(60, &apart), Err(CsvError::Gap { line: 72, seconds: 1000 })));
    }
    /// A table of the drop-frame timecodes of the given frames.
    fn dropping(base: u32, frames: impl IntoIterator<Item = u64>, timing: Timing) -> Result<Clock, CsvError> {
        let mut text = "Timecode\n".to_owned();
        for frame in frames {
            writeln!(text, "{}", Timecode::of_frames(frame, base, true)).unwrap();
        }
        Clock::read(&Table::read(&text).unwrap(), 0, timing)
    }

    #[test]
    fn drop_frame_timecodes_lose_no_frames() {
        for (base, rate) in [(30, 30_000.0 / 1001.0), (60, 60_000.0 / 1001.0)] {
            let minutes = u64::from(base) * 60;
            let clock = dropping(base, 5..3 * minutes, Timing::default()).unwrap();
            assert!((clock.rate_hz.unwrap() - rate).abs() < 1e-9);
            assert_eq!((clock.frames.len() as u64, clock.filled, clock.gaps.len()), (3 * minutes - 5, 0, 0));
            // Every second frame, as a camera at half the rate gives them.
            let clock = dropping(base, (0..2 * minutes).step_by(2), Timing::default()).unwrap();
            assert!((clock.rate_hz.unwrap() - rate / 2.0).abs() < 1e-9 && clock.gaps.is_empty());
        }
        let mut table = "Timecode\n".to_owned();
        for code in ["00:00:59;28", "00:00:59;29", "00:01:00;01", "00:01:00;02", "00:01:00;03"] {
            writeln!(table, "{code}").unwrap();
        }
        let error = Clock::read(&Table::read(&table).unwrap(), 0, Timing::default()).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains("4:1: `00:01:00;01`"), "{error}");
    }

    #[test]
    fn gaps_are_found_with_their_line() {
        let times: Vec<_> = (0..300).map(f64::from).filter(|time| !(100.0..160.0).contains(time)).collect();
        let clock = clock(60, &times).unwrap();
        assert_eq!((clock.frames.len(), clock.filled), (300, 60));
        assert_eq!(clock.gaps, [Gap { line: 102, frames: 60, seconds: 61.0 / 60.0 }]);
    }

    #[test]
    fn exact_times_follow_the_clock_and_not_the_rows() {
        // A device that runs at 59.9 Hz beside a timecode of 60: after 500 s its rows are 50 frames behind.
        let times: Vec<_> = (0..30_000).map(|row| f64::from(row) * 60.0 / 59.9).collect();
        let mut text = "Timecode\n".to_owned();
        for time in &times {
            let (seconds, frame) = ((time / 60.0).floor(), time % 60.0);
            writeln!(text, "00:{:02}:{:02}:{frame:06.3}", seconds as u32 / 60, seconds as u32 % 60).unwrap();
        }
        let table = Table::read(&text).unwrap();
        let by_rows = Clock::read(&table, 0, Timing::default()).unwrap();
        assert_eq!((by_rows.frames.len(), by_rows.rate_hz), (30_000, Some(60.0)));
        for rate_hz in [60.0, 24.0, 59.94] {
            let exact = Clock::read(&table, 0, Timing { exact: true, rate_hz: Some(rate_hz) }).unwrap();
            assert_eq!(exact.frames.len(), (29_999.0 / 59.9 * rate_hz) as usize + 1);
            for (frame, (row, share)) in exact.frames.iter().enumerate() {
                let time = times[*row] + if *share > 0.0 { share * (times[row + 1] - times[*row]) } else { 0.0 };
                assert!((time - frame as f64 * 60.0 / rate_hz).abs() < 2e-3, "{rate_hz} {frame}");
            }
            assert!(exact.gaps.is_empty());
        }
    }
}
