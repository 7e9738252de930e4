//! Fuzzes the reader of motive files.

#![no_main]

use fuzz::hold;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    hold(face_io::markers::motive::open(bytes), bytes);
});
