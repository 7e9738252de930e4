//! How many frames a second the keys of an animation show.

/// Rates at which animation is made, in hertz, the lowest first.
const USUAL_HZ: [f64; 16] = [
    24_000.0 / 1001.0,
    24.0,
    25.0,
    30_000.0 / 1001.0,
    30.0,
    48.0,
    50.0,
    60_000.0 / 1001.0,
    60.0,
    72.0,
    75.0,
    90.0,
    100.0,
    120.0,
    200.0,
    240.0,
];

/// Even keys further apart than this are poses to move between, not frames, in hertz.
const SLOWEST_HZ: f64 = 10.0;

/// Frames with numbers beyond this come of damaged times.
const FARTHEST: f64 = 1e9;

/// Frames of an animation: frame n is at the time n / rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Clock {
    pub rate_hz: f64,
}

impl Clock {
    /// The clock of `rate_hz`, or the one that the key times of all tracks show.
    pub fn of(tracks: &[&[f32]], rate_hz: Option<f64>) -> Result<Self, String> {
        if let Some(rate_hz) = rate_hz {
            return Ok(Self { rate_hz });
        }
        let even = tracks.iter().all(|times| even_step_s(times).is_some() && times.first() == tracks[0].first());
        let step_s = tracks.iter().filter_map(|times| even_step_s(times)).fold(f64::INFINITY, f64::min);
        let alike = tracks.iter().all(|times| even_step_s(times).is_some_and(|own| (own / step_s - 1.0).abs() < 1e-4));
        if even && alike && step_s.recip() >= SLOWEST_HZ {
            return Ok(Self { rate_hz: snapped(step_s.recip()) });
        }
        let on_frames =
            |rate: f64, within: f64| tracks.iter().copied().flatten().all(|time| is_frame(*time, rate, within));
        let moves = tracks.iter().any(|times| times.len() > 1);
        // Times are often written with few decimal places; a fiftieth of a frame is seen by no one.
        let strict = USUAL_HZ.into_iter().find(|rate| on_frames(*rate, 0.001));
        let found = strict.or_else(|| USUAL_HZ.into_iter().find(|rate| on_frames(*rate, 0.02)));
        found.filter(|_| moves).map(|rate_hz| Self { rate_hz }).ok_or_else(|| {
            let keys = tracks.iter().map(|times| times.len()).max().unwrap_or_default();
            format!("its {keys} keys show no frame rate; say how many frames a second are wanted (`rate_hz`)")
        })
    }

    /// The first frame and the number of frames between the first key and the last; nothing where no performance lasts
    /// so long.
    pub fn frames(self, tracks: &[&[f32]]) -> Option<(i64, usize)> {
        let all = || tracks.iter().copied().flatten().map(|time| f64::from(*time) * self.rate_hz);
        let (begin, end) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)));
        let slack = slack(end / self.rate_hz, self.rate_hz);
        let first = (begin - slack).ceil();
        let last = (end + slack).floor().max(first);
        (first.abs().max(last.abs()) < FARTHEST).then(|| (first as i64, (last - first) as usize + 1))
    }

    /// When a frame is, in seconds.
    pub fn time_s(self, frame: i64) -> f64 {
        frame as f64 / self.rate_hz
    }

    /// How near to a key a frame must be to be that key, in seconds.
    pub fn tolerance_s(self) -> f64 {
        0.001 / self.rate_hz
    }
}

/// How far a key may lie beside its frame, in frames: a thousandth, or what 32 bits leave of a late time.
fn slack(time_s: f64, rate_hz: f64) -> f64 {
    (time_s.abs() * 2.0 * f64::from(f32::EPSILON) * rate_hz).max(0.001)
}

fn is_frame(time: f32, rate_hz: f64, within: f64) -> bool {
    let frame = f64::from(time) * rate_hz;
    (frame - frame.round()).abs() < slack(time.into(), rate_hz).max(within)
}

/// The step between even keys, in seconds.
fn even_step_s(times: &[f32]) -> Option<f64> {
    let (first, last) = (f64::from(*times.first()?), f64::from(*times.last()?));
    let step = (last - first) / (times.len() - 1).max(1) as f64;
    let near = |(index, time): (usize, &f32)| {
        let expected = first + index as f64 * step;
        (f64::from(*time) - expected).abs() * step.recip() < slack(f64::from(*time), step.recip()).max(0.02)
    };
    (times.len() > 1 && step > 0.0 && times.iter().enumerate().all(near)).then_some(step)
}

/// A measured rate, or the usual one (or whole or half number) that it is but for rounding.
fn snapped(rate_hz: f64) -> f64 {
    let near = |usual: &f64| (rate_hz / usual - 1.0).abs() < 1e-4;
    USUAL_HZ.into_iter().find(near).or_else(|| Some((rate_hz * 2.0).round() / 2.0).filter(near)).unwrap_or(rate_hz)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(rate: f64, frames: impl IntoIterator<Item = u16>) -> Vec<f32> {
        frames.into_iter().map(|frame| (f64::from(frame) / rate) as f32).collect()
    }

    #[test]
    fn even_keys_show_their_rate() {
        for rate in [24.0, 30_000.0 / 1001.0, 30.0, 60_000.0 / 1001.0, 60.0, 37.0, 12.5] {
            let times = at(rate, 3..2000);
            let clock = Clock::of(&[&times], None).unwrap();
            assert!((clock.rate_hz / rate - 1.0).abs() < 1e-9, "{rate} {}", clock.rate_hz);
            assert_eq!(clock.frames(&[&times]), Some((3, 1997)), "{rate}");
        }
    }

    #[test]
    fn uneven_keys_lie_on_frames_of_a_usual_rate() {
        let (a, b) = (at(30.0, [0, 7, 31]), at(30.0, [2, 3]));
        let clock = Clock::of(&[&a, &b], None).unwrap();
        assert_eq!((clock.rate_hz.to_bits(), clock.frames(&[&a, &b])), (30.0_f64.to_bits(), Some((0, 32))));
        assert!((Clock::of(&[&[0.0, 2.0]], None).unwrap().rate_hz - 24.0).abs() < 1e-9);
        assert!(Clock::of(&[&[0.0, 0.0137, 1.7771]], None).unwrap_err().contains("rate_hz"));
        assert!(Clock::of(&[&[0.5]], None).is_err());
        assert_eq!(Clock { rate_hz: 10.0 }.frames(&[&[0.05, 0.96]]), Some((1, 9)));
    }
}
