//! The frame axis of a time-varying value: which frames it holds, and how fast they pass.

use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Consecutive frames `first .. first + count`, `rate_hz` of them a second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameAxis {
    /// Number of the first frame, as the source counts them.
    pub first: i64,
    /// How many frames there are.
    pub count: usize,
    /// Frames a second.
    pub rate_hz: f64,
}

/// Why two time-varying values do not fit together.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AxisError {
    /// The two hold different numbers of frames.
    #[error("{left} frames beside {right} frames: both must hold the same frames")]
    Count {
        /// Frames of the first value.
        left: usize,
        /// Frames of the second value.
        right: usize,
    },
    /// The two run at different rates.
    #[error("{left_hz} Hz beside {right_hz} Hz: resample one of them first")]
    Rate {
        /// Rate of the first value in hertz.
        left_hz: f64,
        /// Rate of the second value in hertz.
        right_hz: f64,
    },
}

impl FrameAxis {
    /// An axis of `count` frames from frame 0.
    pub fn new(count: usize, rate_hz: f64) -> Self {
        Self { first: 0, count, rate_hz }
    }

    /// The axis of the frames at positions `range` (counted from 0) of this one.
    #[must_use]
    pub fn slice(&self, range: &Range<usize>) -> Self {
        let first = self.first.saturating_add_unsigned(range.start as u64);
        Self { first, count: range.len(), rate_hz: self.rate_hz }
    }

    /// Whether a value on `other` can be used frame for frame beside one on `self`.
    ///
    /// # Errors
    /// Different counts, or rates that differ by more than a thousandth. First frames may differ, since sources
    /// number their frames from 0 or 1.
    pub fn matches(&self, other: &Self) -> Result<(), AxisError> {
        if self.count != other.count {
            return Err(AxisError::Count { left: self.count, right: other.count });
        }
        if (self.rate_hz - other.rate_hz).abs() > 1e-3 * self.rate_hz.abs() {
            return Err(AxisError::Rate { left_hz: self.rate_hz, right_hz: other.rate_hz });
        }
        Ok(())
    }

    /// Length in seconds.
    pub fn seconds(&self) -> f64 {
        self.count as f64 / self.rate_hz
    }
}
