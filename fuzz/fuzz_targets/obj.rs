//! Any bytes as an OBJ face: an error or a head, never a crash.
#![no_main]

use face_io::{LengthUnit, obj};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(face) = obj::open(bytes) {
        let _ = face.head("fuzzed", LengthUnit::Metre);
        let _ = face.sculpted("fuzzed", LengthUnit::Metre, "fuzzed.obj", ("shape", &face));
    }
});
