//! Any bytes as an animated glTF file: an error or curves, never a crash.
#![no_main]

use face_io::{gltf, no_sibling};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = gltf::read_animation(bytes, None, None, &mut no_sibling);
    let _ = gltf::read_animation(bytes, None, Some(30.0), &mut no_sibling);
});
