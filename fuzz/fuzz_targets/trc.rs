//! Fuzzes the reader of trc files.

#![no_main]

use fuzz::hold;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    hold(face_io::markers::trc::open(bytes), bytes);
});
