//! A track of weights: its keys, and what it is worth between them.

use super::super::GltfError;
use super::super::accessor::Array;
use super::super::container::File;
use gltf_json::animation::{Interpolation, Sampler};
use gltf_json::validation::Checked;

/// Keys over time, a weight for each morph target.
#[derive(Debug)]
pub(super) struct Track {
    interpolation: Interpolation,
    times_s: Vec<f32>,
    targets: usize,
    /// `keys × targets`; for splines `keys × 3 × targets`: arriving tangents, values, leaving tangents.
    values: Vec<f32>,
}

impl Track {
    pub fn read(file: &File, sampler: &Sampler, targets: usize, place: &str) -> Result<Self, GltfError> {
        let Checked::Valid(interpolation) = sampler.interpolation else {
            return Err(GltfError::Mesh { place: place.to_owned(), problem: "its interpolation is unknown".into() });
        };
        let at = format!("{place}, times of the keys");
        let input = Array::open(file, sampler.input, &at)?;
        let times_s: Vec<f32> = input.floats::<1>()?.into_iter().flatten().collect();
        if times_s.is_empty() {
            return Err(input.wrong("there are no keys".into()));
        }
        if let Some(key) = times_s.windows(2).position(|pair| pair[1] <= pair[0]) {
            let (before, after) = (times_s[key], times_s[key + 1]);
            return Err(input.wrong(format!("key {} at {after} s does not come after {before} s", key + 1)));
        }
        let at = format!("{place}, values of the keys");
        let output = Array::open(file, sampler.output, &at)?;
        let values: Vec<f32> = output.floats::<1>()?.into_iter().flatten().collect();
        let each = if interpolation == Interpolation::CubicSpline { 3 * targets } else { targets };
        if times_s.len().checked_mul(each) != Some(values.len()) {
            let (keys, found) = (times_s.len(), values.len());
            return Err(output.wrong(format!("{found} values where {keys} keys of {targets} targets need {each} each")));
        }
        Ok(Self { interpolation, times_s, targets, values })
    }

    /// When its keys are, in seconds.
    pub fn times(&self) -> &[f32] {
        &self.times_s
    }

    /// Writes the weights at `time_s`. A key within `tolerance_s` is taken as it is; before the first and after the
    /// last key the track stands still.
    pub fn at(&self, time_s: f64, tolerance_s: f64, weights: &mut [f32]) {
        let time_of = |key: usize| f64::from(self.times_s[key]);
        let after = self.times_s.partition_point(|time| f64::from(*time) <= time_s);
        let tolerance_s = tolerance_s.max(time_s.abs() * 2.0 * f64::from(f32::EPSILON));
        let near = |key: &usize| *key < self.times_s.len() && (time_of(*key) - time_s).abs() <= tolerance_s;
        let key = [after, after.wrapping_sub(1)].into_iter().find(near);
        let key = key.or(if after == 0 { Some(0) } else { None }).or((after == self.times_s.len()).then(|| after - 1));
        if let Some(key) = key {
            weights.copy_from_slice(self.value(key));
            return;
        }
        let key = after - 1;
        let span_s = time_of(after) - time_of(key);
        let t = (time_s - time_of(key)) / span_s;
        match self.interpolation {
            Interpolation::Step => weights.copy_from_slice(self.value(key)),
            Interpolation::Linear => {
                for (weight, (a, b)) in weights.iter_mut().zip(self.value(key).iter().zip(self.value(after))) {
                    *weight = (f64::from(*a) + (f64::from(*b) - f64::from(*a)) * t) as f32;
                }
            }
            Interpolation::CubicSpline => {
                // v(t) = (2t³ − 3t² + 1) v + d (t³ − 2t² + t) b + (−2t³ + 3t²) v' + d (t³ − t²) a'
                // v, v' the values (unitless) at both keys, b the leaving and a' the arriving tangent (1/s), d the
                // span (s), t from 0 to 1. Appendix C.5 of glTF 2.0.
                let (t2, t3) = (t * t, t * t * t);
                let terms = [
                    (2.0 * t3 - 3.0 * t2 + 1.0, self.value(key)),
                    (span_s * (t3 - 2.0 * t2 + t), self.tangent(key, 2)),
                    (-2.0 * t3 + 3.0 * t2, self.value(after)),
                    (span_s * (t3 - t2), self.tangent(after, 0)),
                ];
                for (target, weight) in weights.iter_mut().enumerate() {
                    *weight = terms.iter().map(|(factor, row)| factor * f64::from(row[target])).sum::<f64>() as f32;
                }
            }
        }
    }

    fn value(&self, key: usize) -> &[f32] {
        match self.interpolation {
            Interpolation::CubicSpline => self.tangent(key, 1),
            _ => &self.values[key * self.targets..(key + 1) * self.targets],
        }
    }

    /// Row 0, 1 or 2 of a spline's key: arriving tangent, value, leaving tangent.
    fn tangent(&self, key: usize, row: usize) -> &[f32] {
        let begin = (3 * key + row) * self.targets;
        &self.values[begin..begin + self.targets]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(interpolation: Interpolation, times_s: &[f32], values: &[f32], targets: usize) -> Track {
        Track { interpolation, times_s: times_s.to_vec(), targets, values: values.to_vec() }
    }

    fn at(track: &Track, time_s: f64) -> Vec<f32> {
        let mut weights = vec![0.0; track.targets];
        track.at(time_s, 1e-5, &mut weights);
        weights
    }

    #[test]
    fn lines_and_steps_hold_beyond_their_ends() {
        let line = track(Interpolation::Linear, &[1.0, 3.0], &[0.0, 1.0, 1.0, 0.5], 2);
        assert_eq!(at(&line, 0.0), [0.0, 1.0]);
        assert_eq!(at(&line, 1.5), [0.25, 0.875]);
        assert_eq!(at(&line, 9.0), [1.0, 0.5]);
        let step = track(Interpolation::Step, &[1.0, 3.0], &[0.25, 0.75], 1);
        assert_eq!((at(&step, 2.9), at(&step, 2.999_995), at(&step, 3.0)), (vec![0.25], vec![0.75], vec![0.75]));
    }

    #[test]
    fn splines_follow_a_cubic_exactly() {
        // f(x) = x³ − 2x² + 3, f'(x) = 3x² − 4x, with keys at −1, 0.5 and 2 s.
        let f = |x: f64| x.powi(3) - 2.0 * x * x + 3.0;
        let slope = |x: f64| 3.0 * x * x - 4.0 * x;
        let keys = [-1.0_f64, 0.5, 2.0];
        let values: Vec<f32> = keys.iter().flat_map(|x| [slope(*x), f(*x), slope(*x)].map(|v| v as f32)).collect();
        let spline = track(Interpolation::CubicSpline, &keys.map(|x| x as f32), &values, 1);
        for time in [-1.0, -0.7, 0.0, 0.5, 1.1, 1.99, 2.0] {
            assert!((f64::from(at(&spline, time)[0]) - f(time)).abs() < 1e-5, "{time}");
        }
    }
}
