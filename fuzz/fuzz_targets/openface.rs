//! Fuzzes the reader of openface files.

#![no_main]

use fuzz::hold;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    hold(face_io::markers::openface::open(bytes), bytes);
});
