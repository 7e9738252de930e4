//! Fuzzes the reader of vicon files.

#![no_main]

use fuzz::hold;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    hold(face_io::markers::vicon::open(bytes), bytes);
});
