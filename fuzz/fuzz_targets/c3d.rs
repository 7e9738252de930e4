//! Fuzzes the reader of c3d files.

#![no_main]

use fuzz::hold;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    hold(face_io::c3d::open(bytes), bytes);
});
