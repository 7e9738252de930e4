//! Any bytes as an FBX rig: an error or a rig, never a crash.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = face_io::fbx::read(bytes, "fuzzed");
});
