//! SMPTE timecodes, `HH:MM:SS:FF` with fractions of a frame where devices give them, drop-frame (`HH:MM:SS;FF`) too.
//!
//! Drop-frame counting keeps 29.97 and 59.94 Hz beside the wall clock: of the numbers of frames, the first two (four at
//! 59.94 Hz) of each minute are left out, but for minutes that ten divides (SMPTE ST 12-1). No frame is lost by it.

use std::fmt;

/// A point in time as a device or a person writes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timecode {
    /// Whole seconds since midnight, as the code counts them.
    pub seconds: u32,
    /// Frames within the second, with fractions.
    pub frame: f64,
    /// Whether numbers of frames are left out.
    pub drop_frame: bool,
}

const SECONDS_A_DAY: u32 = 86_400;

impl Timecode {
    /// Midnight.
    pub const ZERO: Self = Self { seconds: 0, frame: 0.0, drop_frame: false };

    /// Reads `18:45:19:48.451`; a `;` before the frames says that it is drop-frame.
    pub fn from_text(text: &str) -> Option<Self> {
        let mut parts = text.split([':', ';']);
        let mut next = || parts.next().map(str::trim);
        let (hours, minutes, seconds, frame) = (next()?, next()?, next()?, next()?);
        let whole = |text: &str, below: u32| text.parse::<u32>().ok().filter(|number| *number < below);
        let frame = frame.parse::<f64>().ok().filter(|frame| (0.0..1000.0).contains(frame))?;
        let seconds = whole(hours, 24)? * 3600 + whole(minutes, 60)? * 60 + whole(seconds, 60)?;
        parts.next().is_none().then_some(Self { seconds, frame, drop_frame: text.contains(';') })
    }

    /// Numbers of frames left out in each minute but the tenth ones.
    fn dropped_a_minute(base: f64) -> f64 {
        2.0 * (base / 30.0).round().max(1.0)
    }

    /// Whether drop-frame counting leaves this very number out.
    pub fn is_left_out(&self, base: f64) -> bool {
        let minute = self.seconds / 60;
        self.drop_frame
            && self.seconds.is_multiple_of(60)
            && !minute.is_multiple_of(10)
            && self.frame.floor() < Self::dropped_a_minute(base)
    }

    /// Frames since midnight, where `base` of them are counted a second.
    pub fn frames(&self, base: f64) -> f64 {
        let counted = f64::from(self.seconds) * base + self.frame;
        if !self.drop_frame {
            return counted;
        }
        let minutes = self.seconds / 60;
        counted - Self::dropped_a_minute(base) * f64::from(minutes - minutes / 10)
    }

    /// Frames that a day has.
    pub fn frames_a_day(base: f64, drop_frame: bool) -> f64 {
        let left_out = if drop_frame { Self::dropped_a_minute(base) * (1440.0 - 144.0) } else { 0.0 };
        f64::from(SECONDS_A_DAY) * base - left_out
    }

    /// The timecode of frame `frames` since midnight (days are left aside), where `base` of them are counted a second.
    pub fn of_frames(frames: u64, base: u32, drop_frame: bool) -> Self {
        let day = Self::frames_a_day(base.into(), drop_frame) as u64;
        let mut count = frames % day.max(1);
        let base = u64::from(base);
        if drop_frame {
            let dropped = Self::dropped_a_minute(base as f64) as u64;
            let (minute, ten) = (60 * base - dropped, 600 * base - 9 * dropped);
            let (tens, within) = (count / ten, count % ten);
            // The first minute of ten is whole; the others begin after the numbers left out.
            let minutes = if within < 60 * base { 0 } else { (within - 60 * base) / minute + 1 };
            count += dropped * (9 * tens + minutes);
        }
        Self { seconds: (count / base) as u32, frame: (count % base) as f64, drop_frame }
    }

    /// The rate in hertz at which `base` frames are counted a second: drop-frame, 1000/1001 of it, as in colour
    /// television.
    pub fn rate_hz(base: f64, drop_frame: bool) -> f64 {
        if drop_frame { base * 1000.0 / 1001.0 } else { base }
    }
}

impl fmt::Display for Timecode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seconds, frame, drop_frame } = self;
        let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
        let mark = if *drop_frame { ';' } else { ':' };
        write!(f, "{hours:02}:{minutes:02}:{seconds:02}{mark}{frame:06.3}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_and_written() {
        let code = Timecode::from_text("18:45:19:48.451").unwrap();
        assert_eq!((code.seconds, code.drop_frame, code.to_string().as_str()), (67_519, false, "18:45:19:48.451"));
        assert_eq!(Timecode::from_text("01;02;03;04").unwrap().to_string(), "01:02:03;04.000");
        for wrong in ["1:2:3", "1:2:60:0", "24:0:0:0", "1:2:3:4:5", "1:2:3:-1", "1:2:3:nan", ""] {
            assert_eq!(Timecode::from_text(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn frames_and_codes_are_one_to_one() {
        for (base, drop_frame) in [(24, false), (30, false), (30, true), (60, true), (120, true)] {
            let day = Timecode::frames_a_day(base.into(), drop_frame) as u64;
            let mut before: Option<String> = None;
            for frames in (0..40_000).chain(day / 2 - 10..day / 2 + 10).chain(day - 5..day) {
                let code = Timecode::of_frames(frames, base, drop_frame);
                assert!((code.frames(base.into()) - frames as f64).abs() < 1e-9, "{base} {frames} {code}");
                assert!(!code.is_left_out(base.into()), "{code}");
                let text = code.to_string();
                assert!(before.replace(text.clone()) != Some(text));
            }
        }
    }

    #[test]
    fn known_drop_frame_codes() {
        // An hour of 29.97 Hz holds 107,892 frames, and the counted hour is nearly the real one.
        assert_eq!(Timecode::of_frames(107_892, 30, true).to_string(), "01:00:00;00.000");
        assert_eq!(Timecode::of_frames(1800, 30, true).to_string(), "00:01:00;02.000");
        assert_eq!(Timecode::of_frames(17_982, 30, true).to_string(), "00:10:00;00.000");
        assert!(Timecode::from_text("00:01:00;01").unwrap().is_left_out(30.0));
        assert!(!Timecode::from_text("00:10:00;01").unwrap().is_left_out(30.0));
        assert!((107_892.0 / Timecode::rate_hz(30.0, true) - 3600.0).abs() < 0.004);
    }
}
