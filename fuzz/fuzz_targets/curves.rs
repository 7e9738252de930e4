//! Any bytes as a table of curves, plain or of Live Link Face: an error or curves, never a crash.
#![no_main]

use face_io::curves::{Timing, open_with};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = open_with(bytes, Timing::default());
    let _ = open_with(bytes, Timing { exact: true, rate_hz: Some(60.0) });
});
