//! Smoothing over time, without lag: kernels that are alike before and after. Called by the node that calms curves.
//!
//! A smoothed value is yₜ = Σₖ wₖ xₜ₊ₖ / Σₖ wₖ over the frames k from −K to K that are there; at the ends of a take, and
//! beside gaps, the rest of the kernel is scaled up.
//!
//! Gaussian: wₖ = exp(−k² / 2 σ²), K = 4 σ. Savitzky-Golay ("Smoothing and differentiation of data by simplified least
//! squares procedures", 1964): wₖ such that y is the middle of the polynomial of degree d that fits the 2 K + 1 values
//! best; with Aₖⱼ = kʲ, w = A (AᵀA)⁻¹ e₀.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// How to smooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Smoothing {
    /// A mean weighted by a Gaussian of standard deviation σ.
    Gaussian {
        /// σ in frames; 0 changes nothing.
        sigma_frames: f64,
    },
    /// The middle of a polynomial fitted to the frames around.
    SavitzkyGolay {
        /// K: frames on either side.
        reach_frames: usize,
        /// d: degree of the polynomial, at most 2 K.
        degree: usize,
    },
}

impl Smoothing {
    /// K: frames on either side that count.
    pub fn reach(&self) -> usize {
        match self {
            Self::Gaussian { sigma_frames } => (4.0 * sigma_frames).ceil() as usize,
            Self::SavitzkyGolay { reach_frames, .. } => *reach_frames,
        }
    }
}

/// Why there is no such kernel.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SmoothingError {
    /// A polynomial of that degree is not fixed by so few frames.
    #[error("{frames} frames do not fix a polynomial of degree {degree}; reach farther, or lower the degree")]
    Degree {
        /// Frames.
        frames: usize,
        /// The degree.
        degree: usize,
    },
    /// σ is no number of 0 or more.
    #[error("the Gaussian's standard deviation is {sigma_frames} frames; give 0 or more")]
    Sigma {
        /// σ.
        sigma_frames: f64,
    },
}

/// The weights w of −K to K.
///
/// # Errors
/// Where σ is negative, or the frames do not fix the polynomial.
pub fn kernel(smoothing: Smoothing) -> Result<Vec<f64>, SmoothingError> {
    let reach = smoothing.reach();
    let places = -(reach as i64)..=reach as i64;
    match smoothing {
        Smoothing::Gaussian { sigma_frames } if !(sigma_frames >= 0.0 && sigma_frames.is_finite()) => {
            Err(SmoothingError::Sigma { sigma_frames })
        }
        Smoothing::Gaussian { sigma_frames } => {
            Ok(places.map(|k| if k == 0 { 1.0 } else { (-0.5 * (k as f64 / sigma_frames).powi(2)).exp() }).collect())
        }
        Smoothing::SavitzkyGolay { degree, .. } => {
            let wrong = SmoothingError::Degree { frames: 2 * reach + 1, degree };
            if degree > 2 * reach {
                return Err(wrong);
            }
            // Places as shares of the reach keep the powers near 1.
            let power =
                |row: usize, order: usize| ((row as f64 - reach as f64) / reach.max(1) as f64).powi(order as i32);
            let powers = Mat::from_fn(2 * reach + 1, degree + 1, power);
            let normal = powers.transpose() * &powers;
            let factor = normal.llt(Side::Lower).map_err(|_| wrong)?;
            let first = Mat::from_fn(degree + 1, 1, |row, _| f64::from(u8::from(row == 0)));
            let weights = &powers * factor.solve(first);
            Ok((0..=2 * reach).map(|row| weights[(row, 0)]).collect())
        }
    }
}

/// The values smoothed by a kernel of odd length. Values that are NaN are gaps: they stay, and do not count.
pub fn smoothed(values: &[f64], kernel: &[f64]) -> Vec<f64> {
    let reach = kernel.len() / 2;
    let one = |place: usize| {
        if values[place].is_nan() {
            return f64::NAN;
        }
        let (mut sum, mut total) = (0.0, 0.0);
        for other in place.saturating_sub(reach)..(place + reach + 1).min(values.len()) {
            if !values[other].is_nan() {
                let weight = kernel[other + reach - place];
                sum += weight * values[other];
                total += weight;
            }
        }
        // Where gaps leave little but the negative lobes of a polynomial's kernel, the value stays as it is.
        if total > 0.25 * kernel.iter().sum::<f64>() { sum / total } else { values[place] }
    };
    (0..values.len()).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_passes_through_savitzky_and_golay_unchanged() {
        for (reach_frames, degree) in [(2, 2), (4, 3), (7, 4), (3, 0)] {
            let kernel = kernel(Smoothing::SavitzkyGolay { reach_frames, degree }).unwrap();
            assert!((kernel.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let line: Vec<f64> = (0..40).map(|t| (f64::from(t) / 20.0 - 1.0).powi(degree as i32)).collect();
            let calm = smoothed(&line, &kernel);
            for place in reach_frames..40 - reach_frames {
                assert!((calm[place] - line[place]).abs() < 1e-10, "{reach_frames} {degree} {place}");
            }
        }
        // The table of the paper: −3, 12, 17, 12, −3 over 35.
        let known = [-3.0, 12.0, 17.0, 12.0, -3.0].map(|weight: f64| weight / 35.0);
        let found = kernel(Smoothing::SavitzkyGolay { reach_frames: 2, degree: 2 }).unwrap();
        assert!(found.iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn constants_pass_gaps_stay_and_noise_falls() {
        let kernel = kernel(Smoothing::Gaussian { sigma_frames: 1.5 }).unwrap();
        let mut line = vec![0.7; 30];
        line[4] = f64::NAN;
        let calm = smoothed(&line, &kernel);
        assert!(calm[4].is_nan() && calm.iter().enumerate().all(|(at, y)| at == 4 || (y - 0.7).abs() < 1e-12));
        let flicker: Vec<f64> = (0..30).map(|t| if t % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert!(smoothed(&flicker, &kernel)[10..20].iter().all(|y| y.abs() < 0.01));
    }

    #[test]
    fn impossible_kernels_are_refused() {
        assert!(kernel(Smoothing::SavitzkyGolay { reach_frames: 1, degree: 3 }).is_err());
        assert!(kernel(Smoothing::Gaussian { sigma_frames: -1.0 }).is_err());
        assert_eq!(kernel(Smoothing::Gaussian { sigma_frames: 0.0 }).unwrap(), [1.0]);
    }
}
