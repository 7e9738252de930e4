//! Fuzzes any file of markers, told apart by content, and what `inspect` says of it.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = face_io::markers::open("take.csv", bytes);
    let _ = face_io::inspect("take.csv", bytes, &mut face_io::no_sibling);
});
