//! Fuzzes the reader of marker_csv files.

#![no_main]

use fuzz::hold;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    hold(face_io::marker_csv::open(bytes), bytes);
});
