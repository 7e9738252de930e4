//! Timecodes of Live Link Face (`HH:MM:SS:FF.sub`): what they say about the rate, and about rows that are missing.

use crate::csv::{CsvError, Table};

/// Rates that cameras and timecode generators run at, in hertz.
const USUAL_HZ: [f64; 12] = [24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 72.0, 75.0, 90.0, 96.0, 100.0, 120.0];

/// How far a measured rate may lie from a usual one to be taken for it (devices run a little slow), as a fraction.
const SNAP: f64 = 0.01;

const SECONDS_A_DAY: u32 = 86_400;

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
}

#[derive(Clone, Copy)]
struct Code {
    seconds: u32,
    frame: f64,
}

fn parse(text: &str) -> Option<Code> {
    let mut parts = text.split([':', ';']);
    let mut next = || parts.next().map(str::trim);
    let (hours, minutes, seconds, frame) = (next()?, next()?, next()?, next()?);
    let whole = |text: &str, below: u32| text.parse::<u32>().ok().filter(|number| *number < below);
    let frame = frame.parse::<f64>().ok().filter(|frame| (0.0..1000.0).contains(frame))?;
    let seconds = whole(hours, 24)? * 3600 + whole(minutes, 60)? * 60 + whole(seconds, 60)?;
    parts.next().is_none().then_some(Code { seconds, frame })
}

impl Clock {
    /// Reads the timecodes in a column.
    ///
    /// The timecode's own base (frames a second that FF counts to) shows where FF starts anew: base = last FF before
    /// − first FF after + step, with the step from row to row. The recording's rate is base / step. All by medians,
    /// so that lost rows do not matter. A rate within 1 % of a usual one is taken for it; rates such as 29.97 cannot
    /// be told from 30, because timecode counts whole frames.
    pub fn read(table: &Table<'_>, column: usize) -> Result<Self, CsvError> {
        let mut codes = Vec::with_capacity(table.rows.len());
        for row in &table.rows {
            let code = parse(&row.cells[column].text)
                .ok_or_else(|| table.cell_error(row, column, "a timecode such as 18:45:19:48.451"))?;
            codes.push(code);
        }
        let pairs = || codes.iter().zip(codes.iter().skip(1));
        let steps =
            pairs().filter(|(a, b)| a.seconds == b.seconds && b.frame > a.frame).map(|(a, b)| b.frame - a.frame);
        let step = median(steps.collect());
        let base = step.and_then(|step| {
            let turns = pairs().filter(|(a, b)| (a.seconds + 1) % SECONDS_A_DAY == b.seconds);
            median(turns.map(|(a, b)| a.frame - b.frame + step).collect())
        });
        let (Some(step), Some(base)) = (step, base.map(snap)) else {
            let frames = (0..codes.len()).map(|row| (row, 0.0)).collect();
            return Ok(Self { rate_hz: None, frames, filled: 0, repeated: 0 });
        };

        let mut times: Vec<f64> = Vec::with_capacity(codes.len());
        let mut days = 0.0;
        for (index, code) in codes.iter().enumerate() {
            if index > 0 && codes[index - 1].seconds > code.seconds + SECONDS_A_DAY / 2 {
                days += 1.0;
            }
            let time = (f64::from(code.seconds) + days * f64::from(SECONDS_A_DAY)) * base + code.frame;
            if times.last().is_some_and(|before| time < before - 1e-6) {
                let text = |index: usize| table.rows[index].cells[column].text.to_string();
                let line = table.rows[index].line;
                return Err(CsvError::Backwards { line, before: text(index - 1), found: text(index) });
            }
            times.push(time);
        }
        let rate_hz = snap(base / step);
        // What is interpolated must not be more than what was recorded (a few seconds in short files aside).
        let frames = (times[times.len() - 1] - times[0]) / step;
        if frames > (2 * times.len()) as f64 + 10.0 * rate_hz {
            let gap = |pair: &[f64]| pair[1] - pair[0];
            let longest = times.windows(2).enumerate().max_by(|a, b| gap(a.1).total_cmp(&gap(b.1)));
            let (index, seconds) = longest.map_or((0, 0.0), |(index, pair)| (index + 1, gap(pair) / base));
            return Err(CsvError::Gap { line: table.rows[index].line, seconds: seconds as u64 });
        }
        Ok(Self { rate_hz: Some(rate_hz), ..steady(&times, step) })
    }
}

/// Lays frames `step` apart over rows at `times`. Rows that come at steady times are the frames themselves.
fn steady(times: &[f64], step: f64) -> Clock {
    let regular = |pair: &[f64]| ((pair[1] - pair[0]) / step - 1.0).abs() < 0.5;
    if times.windows(2).all(regular) {
        let frames = (0..times.len()).map(|row| (row, 0.0)).collect();
        return Clock { rate_hz: None, frames, filled: 0, repeated: 0 };
    }
    let (first, last) = (times[0], times[times.len() - 1]);
    let count = ((last - first) / step).round() as usize + 1;
    let (mut frames, mut row, mut filled) = (Vec::new(), 0, 0);
    for frame in 0..count {
        let time = (first + frame as f64 * step).min(last);
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
    Clock { rate_hz: None, frames, filled, repeated }
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
        Clock::read(&Table::read(&text).unwrap(), 0)
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
        assert!(parse("1:2:3").is_none() && parse("1:2:60:0").is_none() && parse("1:2:3:4:5").is_none());
    }
}
