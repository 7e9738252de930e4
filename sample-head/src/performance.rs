//! What the head performs: a range of motion, and takes of speech and expressions, as channel curves.
//!
//! A performance is made of gestures: a channel rises smoothly, holds and falls. Gestures on one channel join as
//! 1 − Π (1 − gesture), so that no weight passes 1, and all curves are smooth.

use crate::channels::CHANNELS;
use crate::gestures::{EXPRESSIONS, ISOLATIONS, Pose, VISEMES, VOWELS};
use crate::numbers::Random;
use face_math::data::{Curves, DataError};
use wire::FrameAxis;

/// Frames a second.
pub const RATE_HZ: f64 = 60.0;

/// When a gesture rises, holds and falls, in frames.
#[derive(Debug, Clone, Copy)]
struct Timing {
    start: f32,
    rise: f32,
    hold: f32,
    fall: f32,
}

impl Timing {
    /// 0 before and after, 1 on hold, between them 6t⁵ − 15t⁴ + 10t³, whose slope and bend are 0 at both ends.
    fn at(self, frame: f32) -> f32 {
        let ramp = |t: f32| {
            let t = t.clamp(0.0, 1.0);
            t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
        };
        let fall_start = self.start + self.rise + self.hold;
        ramp((frame - self.start) / self.rise) * (1.0 - ramp((frame - fall_start) / self.fall))
    }

    fn end(self) -> f32 {
        self.start + self.rise + self.hold + self.fall
    }
}

/// A performance being written.
struct Stage {
    frames: usize,
    values: Vec<f32>,
    random: Random,
}

impl Stage {
    fn new(frames: usize, seed: u64) -> Self {
        Self { frames, values: vec![0.0; frames * CHANNELS.len()], random: Random::new(seed) }
    }

    fn gesture(&mut self, channel: &str, timing: Timing, amount: f32) {
        let Some(column) = CHANNELS.iter().position(|own| *own == channel) else { return };
        let last = (timing.end().ceil().max(0.0) as usize).min(self.frames);
        for frame in timing.start.max(0.0) as usize..last {
            let value = &mut self.values[frame * CHANNELS.len() + column];
            let gesture = (amount * timing.at(frame as f32)).clamp(0.0, 1.0);
            *value = 1.0 - (1.0 - *value) * (1.0 - gesture);
        }
    }

    /// A pose; a name without side goes to both sides, a little unevenly, as faces do.
    fn pose(&mut self, pose: Pose, timing: Timing, amount: f32) {
        for (name, weight) in pose {
            if CHANNELS.contains(name) {
                let vary = self.random.between(0.88, 1.0);
                self.gesture(name, timing, weight * amount * vary);
                continue;
            }
            let tilt = self.random.between(-0.11, 0.11);
            for (side, sign) in [("_L", 1.0), ("_R", -1.0)] {
                let vary = self.random.between(0.9, 1.0);
                self.gesture(&format!("{name}{side}"), timing, weight * amount * (vary + sign * tilt).min(1.05));
            }
        }
    }

    /// Blinks every two to four seconds, single or double, sometimes half.
    fn blinks(&mut self, from: f32, to: f32) {
        let mut start = from + self.random.between(20.0, 90.0);
        while start < to - 16.0 {
            let depth = if self.random.chance(0.15) { self.random.between(0.4, 0.8) } else { 1.0 };
            let timing = Timing { start, rise: 4.0, hold: self.random.between(1.0, 3.0), fall: 7.0 };
            for side in ["_L", "_R"] {
                let amount = depth * self.random.between(0.97, 1.0);
                self.gesture(&format!("eyeBlink{side}"), timing, amount);
                self.gesture(&format!("browDown{side}"), timing, 0.04);
            }
            start += if self.random.chance(0.12) { 16.0 } else { self.random.between(110.0, 240.0) };
        }
    }

    /// The gaze jumps (in 3 to 6 frames) and rests; lids and brows go along with looks up.
    fn gaze(&mut self, from: f32, to: f32, reach: f32) {
        let mut start = from + self.random.between(5.0, 30.0);
        while start < to - 20.0 {
            let rise = self.random.between(3.0, 6.0);
            let hold = self.random.between(14.0, 60.0);
            let timing = Timing { start, rise, hold, fall: self.random.between(3.0, 6.0) };
            let aside = self.random.between(-1.0, 1.0) * reach;
            let up = self.random.between(-1.0, 0.8) * reach * 0.8;
            let (left, right) =
                if aside > 0.0 { ("eyeLookOut_L", "eyeLookIn_R") } else { ("eyeLookIn_L", "eyeLookOut_R") };
            let follow = self.random.between(0.94, 1.0);
            self.gesture(left, timing, aside.abs());
            self.gesture(right, timing, aside.abs() * follow);
            let vertical = if up > 0.0 { "eyeLookUp" } else { "eyeLookDown" };
            for side in ["_L", "_R"] {
                self.gesture(&format!("{vertical}{side}"), timing, up.abs());
                if up > 0.2 {
                    self.gesture(&format!("browOuterUp{side}"), timing, up * 0.2);
                    self.gesture(&format!("browInnerUp{side}"), timing, up * 0.25);
                }
            }
            start += rise + hold + self.random.between(0.0, 30.0);
        }
    }

    /// Speech: syllables of 8 to 16 frames, consonants over the edges of vowels, pauses between phrases, brows on
    /// stressed syllables.
    fn speech(&mut self, from: f32, to: f32) {
        let mut start = from;
        let mut left_in_phrase = 4 + self.random.below(7);
        while start < to - 18.0 {
            let length = self.random.between(8.0, 16.0);
            let loud = self.random.between(0.65, 1.1);
            let vowel = VISEMES[self.random.below(VOWELS)];
            let hold = length * 0.25;
            let timing = Timing { start: start - 3.0, rise: length * 0.5, hold, fall: length * 0.5 + 3.0 };
            self.pose(vowel, timing, loud);
            if self.random.chance(0.85) {
                let consonant = VISEMES[VOWELS + self.random.below(VISEMES.len() - VOWELS)];
                let timing = Timing { start: start - 5.0, rise: 4.5, hold: self.random.between(0.0, 2.0), fall: 5.0 };
                let amount = self.random.between(0.9, 1.0);
                self.pose(consonant, timing, amount);
            }
            if loud > 1.0 {
                let timing = Timing { start: start - 4.0, rise: 8.0, hold: 4.0, fall: 14.0 };
                let name = if self.random.chance(0.7) { "browInnerUp" } else { "browOuterUp" };
                let amount = self.random.between(0.15, 0.5);
                for side in ["_L", "_R"] {
                    self.gesture(&format!("{name}{side}"), timing, amount);
                }
            }
            start += length;
            left_in_phrase -= 1;
            if left_in_phrase == 0 {
                left_in_phrase = 4 + self.random.below(7);
                start += self.random.between(10.0, 34.0);
            }
        }
    }

    /// Small unrest in brows, cheeks and mouth: slow gestures of a few hundredths.
    fn unrest(&mut self, from: f32, to: f32) {
        const RESTLESS: [&str; 9] = [
            "browDown",
            "browInnerUp",
            "browOuterUp",
            "cheekSquint",
            "eyeSquint",
            "mouthDimple",
            "mouthFrown",
            "mouthPress",
            "noseSneer",
        ];
        let mut start = from - 20.0;
        while start < to {
            let name = RESTLESS[self.random.below(RESTLESS.len())];
            let (rise, hold) = (self.random.between(14.0, 40.0), self.random.between(0.0, 30.0));
            let timing = Timing { start, rise, hold, fall: self.random.between(14.0, 40.0) };
            let amount = self.random.between(0.02, 0.14);
            for side in ["_L", "_R"] {
                let amount = amount * self.random.between(0.6, 1.0);
                self.gesture(&format!("{name}{side}"), timing, amount);
            }
            start += self.random.between(6.0, 22.0);
        }
    }

    /// The curves, led in and out of neutral within a fifth of a second.
    fn curves(mut self) -> Result<Curves, DataError> {
        let lead = Timing { start: 0.0, rise: 12.0, hold: self.frames as f32 - 25.0, fall: 12.0 };
        for (frame, values) in self.values.chunks_exact_mut(CHANNELS.len()).enumerate() {
            let share = lead.at(frame as f32);
            for value in values {
                *value *= share;
            }
        }
        let names = CHANNELS.iter().map(|channel| (*channel).to_owned()).collect();
        Curves::new(FrameAxis::new(self.frames, RATE_HZ), names, self.values)
    }
}

/// A range of motion: every channel by itself, then expressions, then speech; starts and ends neutral.
///
/// # Errors
/// Never: the curves fit their channels by construction.
pub fn range_of_motion(frames: usize, seed: u64) -> Result<Curves, DataError> {
    let mut stage = Stage::new(frames, seed);
    let whole = frames as f32;
    let (alone, expressive) = (whole * 0.46, whole * 0.72);
    let step = (alone - 10.0) / ISOLATIONS.len() as f32;
    for (place, pose) in ISOLATIONS.iter().enumerate() {
        let start = 6.0 + step * place as f32;
        let timing = Timing { start, rise: step * 0.62, hold: step * 0.12, fall: step * 0.62 };
        stage.pose(pose, timing, 1.05);
    }
    let step = (expressive - alone) / EXPRESSIONS.len() as f32;
    for (place, pose) in EXPRESSIONS.iter().enumerate() {
        let start = alone + step * place as f32;
        let timing = Timing { start, rise: step * 0.55, hold: step * 0.25, fall: step * 0.55 };
        let amount = stage.random.between(0.85, 1.05);
        stage.pose(pose, timing, amount);
    }
    let last = whole - 24.0;
    stage.speech(expressive + 6.0, last);
    stage.blinks(alone, last);
    stage.gaze(alone, last, 0.8);
    stage.unrest(alone, last - 60.0);
    let mixed = whole * 0.86;
    for (place, pose) in EXPRESSIONS.iter().cycle().skip(seed as usize % 5).step_by(5).take(4).enumerate() {
        let start = mixed + place as f32 * (last - mixed) * 0.22;
        stage.pose(pose, Timing { start, rise: 14.0, hold: 12.0, fall: 18.0 }, 0.55);
    }
    stage.curves()
}

/// A take: speech with blinks, looks and a few expressions; starts and ends neutral.
///
/// # Errors
/// Never: the curves fit their channels by construction.
pub fn take(frames: usize, seed: u64) -> Result<Curves, DataError> {
    let mut stage = Stage::new(frames, seed);
    let whole = frames as f32;
    stage.unrest(0.0, whole);
    stage.blinks(0.0, whole);
    stage.gaze(0.0, whole, 0.7);
    let mut start = stage.random.between(8.0, 16.0);
    while start < whole - 40.0 {
        let length = stage.random.between(70.0, 150.0).min(whole - 10.0 - start);
        if stage.random.chance(0.7) {
            stage.speech(start, start + length);
        }
        if stage.random.chance(0.75) {
            let pose = EXPRESSIONS[stage.random.below(EXPRESSIONS.len())];
            let hold = stage.random.between(10.0, 50.0);
            let timing = Timing { start: start + length * 0.4, rise: 16.0, hold, fall: 22.0 };
            let amount = stage.random.between(0.45, 0.95);
            stage.pose(pose, timing, amount);
        }
        start += length + stage.random.between(4.0, 20.0);
    }
    stage.curves()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_stay_within_bounds_and_all_channels_act() {
        let curves = range_of_motion(1600, 1).unwrap();
        assert!(curves.values().iter().all(|weight| (0.0..=1.0).contains(weight)));
        for (column, channel) in curves.channels().iter().enumerate() {
            let peak = (0..curves.frames()).map(|t| curves.frame(t)[column]).fold(0.0, f32::max);
            assert!(peak > 0.6, "{channel} peaks at {peak}");
        }
        assert!(curves.frame(0).iter().all(|weight| *weight == 0.0));
        assert!(curves.frame(1599).iter().all(|weight| *weight == 0.0));
    }

    #[test]
    fn curves_are_smooth() {
        let curves = take(360, 3).unwrap();
        for t in 1..360 {
            for (column, (a, b)) in curves.frame(t - 1).iter().zip(curves.frame(t)).enumerate() {
                assert!((a - b).abs() < 0.5, "{} jumps from {a} to {b} at {t}", CHANNELS[column]);
            }
        }
    }

    #[test]
    fn performances_repeat_and_differ_by_seed() {
        assert_eq!(take(300, 1).unwrap(), take(300, 1).unwrap());
        assert_ne!(take(300, 1).unwrap(), take(300, 2).unwrap());
    }
}
