//! What every fuzz target holds a reader to, beyond that it does not panic.

pub mod kinds;

use face_io::ReadError;
use face_io::markers::MarkerFile;

/// How many points a byte of a file may stand for at most.
const POINTS_A_BYTE: usize = 16;

/// Checks that what was read fits together, is no more than the bytes are worth, and that errors say something.
///
/// # Panics
/// Where it does not; the fuzzer keeps the bytes then.
pub fn hold(read: Result<MarkerFile, ReadError>, bytes: &[u8]) {
    match read {
        Err(error) => assert!(!error.to_string().is_empty()),
        Ok(file) => {
            assert_eq!(file.positions.len(), file.names.len() * file.frames);
            assert!(file.positions.len() <= POINTS_A_BYTE * bytes.len());
            assert!(file.positions.iter().all(|point| point.is_finite() || point.is_nan()));
            assert!(file.rate_hz.is_none_or(|rate| rate.is_finite() && rate > 0.0));
        }
    }
}
