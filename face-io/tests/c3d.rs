//! C3D files of real systems, damaged ones, and the writer.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::{bytes, data, files};
use face_io::c3d::{self, C3dError, Processor, Storage};
use face_io::{LengthUnit, ReadError};
use face_math::data::Markers;
use glam::Vec3;
use proptest::prelude::*;
use wire::FrameAxis;

#[test]
fn six_flavours_of_one_take_decode_alike() {
    let Some(data) = data() else { return };
    let takes: Vec<_> = files(&data.join("mocap/c3d_formats"), ".c3d")
        .iter()
        .map(|path| c3d::read_take(&bytes(path)).unwrap())
        .collect();
    assert_eq!(takes.len(), 6);
    for processor in [Processor::Intel, Processor::Dec, Processor::Mips] {
        assert_eq!(takes.iter().filter(|take| take.processor == processor).count(), 2);
    }
    assert_eq!(takes.iter().filter(|take| take.storage == Storage::Real).count(), 3);
    let first = &takes[0].markers;
    assert_eq!((first.frames(), first.names().len()), (89, 36));
    assert_eq!(first.frame_axis(), FrameAxis { first: 1, count: 89, rate_hz: 50.0 });
    assert_eq!(first.names()[..3], ["RFT1", "RFT2", "RFT3"]);
    assert!(first.missing() > 0 && first.missing() < first.positions().len());
    for take in &takes[1..] {
        assert_eq!(take.markers.names(), first.names());
        assert_eq!(take.markers.missing(), first.missing());
        for (a, b) in take.markers.positions().iter().zip(first.positions()) {
            assert_eq!(a.is_nan(), b.is_nan());
            assert!(a.is_nan() || (*a - *b).abs().max_element() <= 0.3e-3, "{a} beside {b}");
        }
    }
}

#[test]
fn face_takes_hold_their_markers_in_metres() {
    let Some(data) = data() else { return };
    let jaw = c3d::read(&bytes(data.join("mocap/animface/JawMoCap.c3d"))).unwrap();
    assert_eq!((jaw.names().len(), jaw.frames()), (41, 1590));
    assert_eq!(jaw.frame_axis().rate_hz.to_bits(), 60.0_f64.to_bits());
    let day1 = c3d::read(&bytes(data.join("actors/ict_actor_a/takes/day1_161.c3d"))).unwrap();
    assert_eq!((day1.names().len(), day1.frames(), day1.missing()), (102, 1846, 0));
    assert!(day1.positions().iter().all(|point| point.length() < 0.3));
    let day2 = c3d::read(&bytes(data.join("actors/ict_actor_a/takes/day2_167.c3d"))).unwrap();
    assert!(day2.missing() > 0);
    let walk = c3d::read(&bytes(data.join("mocap/c3d_other/shd01.c3d"))).unwrap();
    assert_eq!(walk.frame_axis(), FrameAxis { first: 91, count: 237, rate_hz: 250.0 });
    assert_eq!(walk.names()[0], "AbcdeFghijk:RASI");
}

#[test]
fn real_takes_write_back_bit_for_bit() {
    let Some(data) = data() else { return };
    for path in
        ["actors/ict_actor_a/takes/day2_167.c3d", "mocap/animface/JawMoCap.c3d", "mocap/c3d_formats/DEC_INT.C3D"]
    {
        let markers = c3d::read(&bytes(data.join(path))).unwrap();
        for unit in [LengthUnit::Millimetre, LengthUnit::Metre] {
            if unit == LengthUnit::Millimetre && path.ends_with("INT.C3D") {
                continue;
            }
            let again = c3d::read(&c3d::write(&markers, unit, c3d::Flavour::PLAIN).unwrap()).unwrap();
            assert_eq!(again.names(), markers.names());
            assert_eq!(again.frame_axis(), markers.frame_axis());
            assert!(bits(&again) == bits(&markers), "{path} in {unit}");
        }
    }
}

#[test]
fn damage_is_named_with_its_place() {
    assert!(matches!(c3d::read(&[]), Err(ReadError::C3d(C3dError::Empty))));
    assert!(matches!(c3d::read(b"not a C3D file"), Err(ReadError::C3d(C3dError::NoC3d { found: b'o' }))));
    let whole = c3d::write(&sample(30), LengthUnit::Millimetre, c3d::Flavour::PLAIN).unwrap();
    let cut = c3d::read(&whole[..1100]).unwrap_err();
    let ReadError::C3d(C3dError::ShortFrames { frame, frames, begins, have, .. }) = &cut else { panic!("{cut}") };
    assert_eq!((*frame, *frames, *begins, *have), (3, 30, 1088, 1100));
    assert!(cut.to_string().contains("ends at byte 1100, but frame 3 of 30 begins at byte 1088"), "{cut}");
    let mut unit = whole;
    let at = unit.windows(5).position(|window| window == b"UNITS").unwrap() + 10;
    unit[at..at + 2].copy_from_slice(b"dg");
    assert!(c3d::read(&unit).unwrap_err().to_string().contains("POINT:UNITS is `dg`"));
}

#[test]
fn takes_longer_than_16_bits_count_keep_all_frames() {
    let axis = FrameAxis { first: 70_000, count: 66_000, rate_hz: 119.88 };
    let points = (0..66_000).map(|t| Vec3::new(0.0, t as f32 * 1e-3, 1.0)).collect();
    let long = Markers::new(axis, vec!["chin".into()], points).unwrap();
    let bytes = c3d::write(&long, LengthUnit::Metre, c3d::Flavour::PLAIN).unwrap();
    let again = c3d::read(&bytes).unwrap();
    assert_eq!(again.frame_axis(), axis);
    assert!(bits(&again) == bits(&long));
    // Without the TRIAL group, LONG_FRAMES counts; without either, the clipped count is not believed.
    let hide = |bytes: &mut [u8], name: &[u8]| {
        let at = bytes.windows(name.len()).position(|window| window == name).unwrap();
        bytes[at] = b'X';
    };
    let mut bytes = bytes;
    hide(&mut bytes, b"ACTUAL_END_FIELD");
    assert_eq!(c3d::read(&bytes).unwrap().frames(), 66_000);
    hide(&mut bytes, b"LONG_FRAMES");
    assert!(c3d::read(&bytes).unwrap_err().to_string().contains("LONG_FRAMES"));
}

#[test]
fn a_field_left_behind_is_outvoted_or_refused() {
    let markers = sample(50);
    let whole = c3d::write(&markers, LengthUnit::Metre, c3d::Flavour::PLAIN).unwrap();
    let value = |name: &[u8], ahead: usize| {
        whole.windows(name.len()).position(|window| window == name).unwrap() + name.len() + ahead
    };
    // Distance, type and number of dimensions stand between the name and the value.
    for (field, at, bytes) in [
        ("POINT:USED", value(b"USED", 4), [1, 0]),
        ("points in the header", 2, [1, 0]),
        ("POINT:FRAMES", value(b"\x01FRAMES", 4), [20, 0]),
        ("TRIAL:ACTUAL_END_FIELD", value(b"ACTUAL_END_FIELD", 5), [7, 0]),
        ("last frame in the header", 8, [3, 0]),
        ("sign of POINT:SCALE", value(b"SCALE", 6), [0x80, 0x3f]),
        ("sign of the scale in the header", 14, [0x80, 0x3f]),
    ] {
        let mut damaged = whole.clone();
        damaged[at..at + 2].copy_from_slice(&bytes);
        assert!(damaged != whole, "{field}");
        let read = c3d::read(&damaged).unwrap_or_else(|error| panic!("{field}: {error}"));
        assert!(read == markers, "{field}");
        // With something behind the frames, the length of the file tells nothing any more.
        damaged.extend([0; 5000]);
        match c3d::read(&damaged) {
            Err(error) => assert!(error.to_string().contains("neither explains"), "{field}: {error}"),
            Ok(read) => assert!(read.names() == markers.names() && read.frames() <= 50, "{field}"),
        }
    }
}

#[test]
fn many_labels_missing_points_and_no_points_round_trip() {
    let names: Vec<String> = (0..700).map(|index| format!("marker_{index:03}")).collect();
    let points = (0..1400).map(|i| if i % 7 == 0 { Vec3::NAN } else { Vec3::splat(i as f32) }).collect();
    let many = Markers::new(FrameAxis { first: 1, count: 2, rate_hz: 60.0 }, names, points).unwrap();
    let again = c3d::read(&c3d::write(&many, LengthUnit::Centimetre, c3d::Flavour::PLAIN).unwrap()).unwrap();
    assert_eq!((again.names(), again.missing()), (many.names(), 200));
    let none = Markers::new(FrameAxis { first: 1, count: 0, rate_hz: 60.0 }, Vec::new(), Vec::new()).unwrap();
    let again = c3d::read(&c3d::write(&none, LengthUnit::Metre, c3d::Flavour::PLAIN).unwrap()).unwrap();
    assert_eq!((again.names().len(), again.frames()), (0, 0));
}

fn flavours() -> impl Iterator<Item = c3d::Flavour> {
    [Processor::Intel, Processor::Dec, Processor::Mips]
        .into_iter()
        .flat_map(|processor| [false, true].map(|integers| c3d::Flavour { processor, integers }))
}

#[test]
fn a_coordinate_that_a_flavour_cannot_hold_is_refused() {
    let far = Markers::new(FrameAxis::new(1, 60.0), vec!["chin".into()], vec![Vec3::splat(3e38)]).unwrap();
    for flavour in flavours() {
        let written = c3d::write(&far, LengthUnit::Metre, flavour);
        match flavour {
            c3d::Flavour { processor: Processor::Dec, integers: false } => {
                assert!(written.unwrap_err().to_string().contains("coordinate"));
            }
            _ => assert_eq!(c3d::read(&written.unwrap()).unwrap().missing(), 0, "{flavour:?}"),
        }
    }
}

fn bits(markers: &Markers) -> Vec<[u32; 3]> {
    let canonical = |number: f32| if number.is_nan() { u32::MAX } else { number.to_bits() };
    markers.positions().iter().map(|point| point.to_array().map(canonical)).collect()
}

fn sample(frames: usize) -> Markers {
    let names = vec!["brow".to_owned(), "chin".to_owned()];
    let points = (0..2 * frames).map(|i| Vec3::new(i as f32, 0.5, -1.0)).collect();
    Markers::new(FrameAxis { first: 1, count: frames, rate_hz: 60.0 }, names, points).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_damage_panics(at in 0_usize..2000, value: u8, end in 0_usize..2000) {
        let mut bytes = c3d::write(&sample(20), LengthUnit::Millimetre, c3d::Flavour::PLAIN).unwrap();
        let length = bytes.len();
        bytes[at % length] = value;
        let _ = c3d::read(&bytes);
        let _ = c3d::read(&bytes[..end % length]);
    }

    #[test]
    fn no_parameter_section_panics(noise in proptest::collection::vec(any::<u8>(), 600), processor in 84_u8..87) {
        let mut bytes = c3d::write(&sample(4), LengthUnit::Millimetre, c3d::Flavour::PLAIN).unwrap();
        let end = bytes.len().min(516 + noise.len());
        bytes[516..end].copy_from_slice(&noise[..end - 516]);
        bytes[515] = processor;
        let _ = c3d::read(&bytes);
    }

    #[test]
    fn any_markers_round_trip_in_metres(
        points in proptest::collection::vec((-5.0_f32..5.0, -5.0_f32..5.0, -5.0_f32..5.0, any::<bool>()), 1..60),
        first in 0_i64..100_000,
    ) {
        let positions: Vec<_> =
            points.iter().map(|(x, y, z, there)| if *there { Vec3::new(*x, *y, *z) } else { Vec3::NAN }).collect();
        let axis = FrameAxis { first, count: positions.len(), rate_hz: 59.94 };
        let markers = Markers::new(axis, vec!["a".into()], positions).unwrap();
        let again = c3d::read(&c3d::write(&markers, LengthUnit::Metre, c3d::Flavour::PLAIN).unwrap()).unwrap();
        prop_assert_eq!(again.frame_axis(), axis);
        prop_assert_eq!(bits(&again), bits(&markers));
    }

    #[test]
    fn every_flavour_writes_what_it_says_and_reads_back(
        points in proptest::collection::vec((-2.0_f32..2.0, -2.0_f32..2.0, -2.0_f32..2.0, any::<bool>()), 2..60),
        first in 0_i64..100_000,
        rate_hz in 1.0_f32..500.0,
    ) {
        let positions: Vec<_> =
            points.iter().map(|(x, y, z, there)| if *there { Vec3::new(*x, *y, *z) } else { Vec3::NAN }).collect();
        let axis = FrameAxis { first, count: positions.len(), rate_hz: f64::from(rate_hz) };
        let markers = Markers::new(axis, vec!["chin".into()], positions).unwrap();
        let largest = markers.positions().iter().filter(|point| !point.is_nan()).map(|point| point.abs().max_element());
        let step = largest.fold(0.0, f32::max) / 32_767.0;
        for flavour in flavours() {
            let take = c3d::read_take(&c3d::write(&markers, LengthUnit::Metre, flavour).unwrap()).unwrap();
            prop_assert_eq!(take.processor, flavour.processor);
            prop_assert_eq!(matches!(take.storage, Storage::Integer { .. }), flavour.integers);
            prop_assert_eq!((take.markers.names(), take.unit), (markers.names(), LengthUnit::Metre));
            let read = take.markers.frame_axis();
            prop_assert_eq!((read.first, read.count, read.rate_hz as f32), (axis.first, axis.count, rate_hz));
            if flavour.integers {
                for (a, b) in take.markers.positions().iter().zip(markers.positions()) {
                    prop_assert_eq!(a.is_nan(), b.is_nan());
                    prop_assert!(a.is_nan() || (*a - *b).abs().max_element() <= 0.51 * step);
                }
            } else {
                prop_assert_eq!(bits(&take.markers), bits(&markers));
            }
        }
    }
}
