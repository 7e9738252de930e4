//! Which training samples are worth keeping: salient sample selection (section 4.2 of FDLS).
//!
//! The rule, Eq. 3 of FDLS: sample i stays where its mean similarity to the samples is below a threshold,
//!
//! ```text
//! sᵢ = (1/N) Σⱼ k(xᵢ, xⱼ) < σ,    k(x, y) = exp(−‖x − y‖² / 2h²)
//! ```
//!
//! x a sample's coordinates (metres), h the bandwidth (metres), k and σ unitless, 0 to 1. The paper applies it
//! "sequentially". Read as one sweep over the whole set, the rule would drop *every* frame of a frequent pose and leave
//! none of it; read as a comparison with the samples kept so far, its outcome hangs on their order. Here it is applied one
//! sample at a time to the samples that are *still there*: the one with the largest mean goes, the others' means are taken
//! anew over what is left, and so on until the rule holds for all (or one sample is left). So σ is the largest share of
//! the set that one pose may have, and h says what counts as one pose. A frequent pose is thinned until it no longer
//! dominates, never lost; samples that all look alike come down to one, as the paper says of its extreme case; σ = 1 keeps
//! all that are not identical. The order of the samples does not matter, save that of equals the later goes first.
//!
//! A σ below the mean similarity of samples drawn at random leaves little: the paper, too, finds small values harmful. By
//! default h is a share of the samples' own typical distance from each other, so that σ means the same whatever the face or
//! the number of markers.

use rayon::prelude::*;

/// How to select.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SalienceOptions {
    /// σ: samples whose mean similarity reaches it are dropped; 0 to 1. More keeps more.
    pub threshold: f64,
    /// h, in the unit of the samples; by default [`DEFAULT_BANDWIDTH_SHARE`] times the root mean square distance between samples.
    pub bandwidth: Option<f64>,
}

impl Default for SalienceOptions {
    fn default() -> Self {
        Self { threshold: 0.3, bandwidth: None }
    }
}

/// The share of the root mean square distance between samples that is the bandwidth where none is given.
pub const DEFAULT_BANDWIDTH_SHARE: f64 = 0.25;

/// What was selected.
#[derive(Debug, Clone, PartialEq)]
pub struct Salience {
    /// Positions of the samples that stay, ascending; never empty.
    pub kept: Vec<usize>,
    /// Mean similarity of every sample to all samples, before any is dropped: the sᵢ of Eq. 3.
    pub means: Vec<f64>,
    /// The bandwidth h.
    pub bandwidth: f64,
}

/// Why samples cannot be selected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SalienceError {
    /// There is no sample.
    #[error("no samples to select from; give at least one frame")]
    Empty,
    /// The numbers are not a whole number of samples.
    #[error("{found} numbers do not make samples of {width}; give every sample all its coordinates")]
    Width {
        /// Numbers a sample.
        width: usize,
        /// Numbers given.
        found: usize,
    },
    /// A sample holds a missing value.
    #[error("sample {sample} holds a missing value at coordinate {coordinate}; fill the gaps first")]
    Missing {
        /// Position of the sample.
        sample: usize,
        /// Position within it.
        coordinate: usize,
    },
    /// A threshold outside 0 to 1, or a bandwidth that is not positive.
    #[error("{what} is {value}; {cure}")]
    Option {
        /// Which option.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it should be.
        cure: &'static str,
    },
}

/// Selects among `samples`, which hold `width` numbers each, sample after sample.
///
/// Takes of the order of N² × `width` multiplications: a few seconds for 5,000 samples of 300 numbers.
///
/// # Errors
/// Where there is no sample, a number is missing, or an option is out of range.
pub fn select_salient(samples: &[f32], width: usize, options: &SalienceOptions) -> Result<Salience, SalienceError> {
    let count = check(samples, width, options)?;
    let bandwidth = match options.bandwidth {
        Some(bandwidth) => bandwidth,
        // Where all samples are one, any bandwidth says so.
        None => {
            Some(DEFAULT_BANDWIDTH_SHARE * typical_distance(samples, width, count)).filter(|h| *h > 0.0).unwrap_or(1.0)
        }
    };
    let exponent = -0.5 / (bandwidth * bandwidth);
    let similarity = |i: usize, j: usize| {
        (exponent
            * f64::from(distance_squared(&samples[i * width..(i + 1) * width], &samples[j * width..(j + 1) * width])))
        .exp()
    };
    // Each sum runs over j in order, so that its bits do not depend on how the rows are shared out.
    let mut sums: Vec<f64> = (0..count).into_par_iter().map(|i| (0..count).map(|j| similarity(i, j)).sum()).collect();
    let means = sums.iter().map(|sum| sum / count as f64).collect();
    let mut kept: Vec<usize> = (0..count).collect();
    while kept.len() > 1 {
        let (place, most) = most_alike(&kept, &sums);
        if most / (kept.len() as f64) < options.threshold {
            break;
        }
        let dropped = kept.remove(place);
        let lost: Vec<f64> = kept.par_iter().map(|i| similarity(*i, dropped)).collect();
        for (i, lost) in kept.iter().zip(lost) {
            sums[*i] -= lost;
        }
    }
    Ok(Salience { kept, means, bandwidth })
}

/// Where in `kept` the sample with the largest sum stands, and that sum; of equals the last.
fn most_alike(kept: &[usize], sums: &[f64]) -> (usize, f64) {
    let mut best = (0, f64::NEG_INFINITY);
    for (place, sample) in kept.iter().enumerate() {
        if sums[*sample] >= best.1 {
            best = (place, sums[*sample]);
        }
    }
    best
}

fn check(samples: &[f32], width: usize, options: &SalienceOptions) -> Result<usize, SalienceError> {
    if samples.is_empty() {
        return Err(SalienceError::Empty);
    }
    if width == 0 || !samples.len().is_multiple_of(width) {
        return Err(SalienceError::Width { width, found: samples.len() });
    }
    if let Some(place) = samples.iter().position(|value| !value.is_finite()) {
        return Err(SalienceError::Missing { sample: place / width, coordinate: place % width });
    }
    if !(0.0..=1.0).contains(&options.threshold) {
        let (value, cure) = (options.threshold, "give a share between 0 and 1");
        return Err(SalienceError::Option { what: "the threshold", value, cure });
    }
    if let Some(value) = options.bandwidth.filter(|h| !(*h > 0.0 && h.is_finite())) {
        return Err(SalienceError::Option { what: "the bandwidth", value, cure: "give a positive distance" });
    }
    Ok(samples.len() / width)
}

/// Root mean square distance between two samples drawn at random: √(2 Σ variance), without comparing any two.
fn typical_distance(samples: &[f32], width: usize, count: usize) -> f64 {
    let mut mean = vec![0.0_f64; width];
    for sample in samples.chunks_exact(width) {
        mean.iter_mut().zip(sample).for_each(|(mean, value)| *mean += f64::from(*value) / count as f64);
    }
    let squares: f64 = samples
        .chunks_exact(width)
        .map(|sample| sample.iter().zip(&mean).map(|(value, mean)| (f64::from(*value) - mean).powi(2)).sum::<f64>())
        .sum();
    (2.0 * squares / count as f64).sqrt()
}

/// ‖a − b‖², in eight running sums that a compiler turns into vector instructions.
fn distance_squared(a: &[f32], b: &[f32]) -> f32 {
    let (head_a, tail_a) = a.as_chunks::<8>();
    let (head_b, tail_b) = b.as_chunks::<8>();
    let mut sums = [0.0_f32; 8];
    for (a, b) in head_a.iter().zip(head_b) {
        for lane in 0..8 {
            let apart = a[lane] - b[lane];
            sums[lane] += apart * apart;
        }
    }
    let rest: f32 = tail_a.iter().zip(tail_b).map(|(a, b)| (a - b) * (a - b)).sum();
    sums.iter().sum::<f32>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    fn rolled(count: usize, width: usize) -> Vec<f32> {
        let mut dice = Dice(53);
        (0..count * width).map(|_| dice.roll()).collect()
    }

    fn select(samples: &[f32], width: usize, threshold: f64, bandwidth: Option<f64>) -> Salience {
        select_salient(samples, width, &SalienceOptions { threshold, bandwidth }).unwrap()
    }

    /// A tight cloud of `common` samples, then `rare` ones far from it and from each other.
    fn unbalanced(common: usize, rare: usize) -> Vec<f32> {
        let mut samples: Vec<f32> = rolled(common, 6).iter().map(|value| value * 1e-3).collect();
        samples.extend(rolled(rare, 6).iter().map(|value| value * 10.0));
        samples
    }

    #[test]
    fn samples_that_are_all_one_come_down_to_one() {
        for threshold in [0.1, 0.5, 1.0] {
            assert_eq!(select(&[0.25; 60], 6, threshold, None).kept, [0]);
        }
    }

    #[test]
    fn a_threshold_of_one_keeps_all_that_differ() {
        let samples = rolled(40, 6);
        assert_eq!(select(&samples, 6, 1.0, None).kept.len(), 40);
        assert_eq!(select(&samples, 6, 0.0, None).kept.len(), 1);
    }

    #[test]
    fn a_frequent_pose_is_thinned_and_rare_ones_stay() {
        let samples = unbalanced(80, 20);
        let chosen = select(&samples, 6, 0.3, Some(0.1));
        let rare = chosen.kept.iter().filter(|sample| **sample >= 80).count();
        let common = chosen.kept.len() - rare;
        assert_eq!(rare, 20);
        // The rule holds for those that stay: c of c + 20 samples are alike, and c / (c + 20) < 0.3.
        assert_eq!(common, 8);
        assert!(chosen.means[..80].iter().all(|mean| (mean - 0.8).abs() < 1e-3));
    }

    #[test]
    fn a_larger_threshold_keeps_more() {
        let samples = unbalanced(60, 40);
        let counts = [0.05, 0.1, 0.3, 0.5, 0.9].map(|threshold| select(&samples, 6, threshold, None).kept.len());
        assert!(counts.is_sorted() && counts[0] < counts[4], "{counts:?}");
    }

    #[test]
    fn the_rule_holds_for_what_is_kept_and_the_unit_does_not_matter() {
        let samples = rolled(50, 7);
        let chosen = select(&samples, 7, 0.1, Some(0.8));
        let row = |i: usize| &samples[i * 7..(i + 1) * 7];
        assert!(chosen.kept.len() > 1 && chosen.kept.len() < 50);
        for i in &chosen.kept {
            let sum: f64 =
                chosen.kept.iter().map(|j| (-f64::from(distance_squared(row(*i), row(*j))) / (2.0 * 0.64)).exp()).sum();
            assert!(sum / (chosen.kept.len() as f64) < 0.1 + 1e-12);
        }
        let in_millimetres: Vec<f32> = samples.iter().map(|value| value * 1024.0).collect();
        assert_eq!(select(&samples, 7, 0.1, None).kept, select(&in_millimetres, 7, 0.1, None).kept);
    }

    #[test]
    fn the_number_of_threads_does_not_matter() {
        let samples = rolled(200, 9);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| select(&samples, 9, 0.2, Some(0.9)))
        };
        assert_eq!(run(1), run(4));
    }

    #[test]
    fn bad_input_is_named() {
        let fault = |samples: &[f32], threshold, bandwidth| {
            select_salient(samples, 3, &SalienceOptions { threshold, bandwidth }).unwrap_err()
        };
        assert_eq!(fault(&[], 0.3, None), SalienceError::Empty);
        assert_eq!(fault(&[0.0; 4], 0.3, None), SalienceError::Width { width: 3, found: 4 });
        let lost = [0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0];
        assert_eq!(fault(&lost, 0.3, None), SalienceError::Missing { sample: 1, coordinate: 1 });
        assert!(fault(&[0.0; 3], 1.5, None).to_string().contains("the threshold is 1.5"));
        assert!(fault(&[0.0; 3], 0.5, Some(0.0)).to_string().contains("the bandwidth is 0"));
    }
}
