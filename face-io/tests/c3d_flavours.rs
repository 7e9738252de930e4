//! C3D files of every flavour, written here as many systems write them, and held against what was put in.
#![allow(clippy::float_cmp, reason = "what is written is read back to the bit")]
#![allow(clippy::format_collect, reason = "short tables, made once")]
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::forge::{Counts, Forge, Gap, Order};
use face_io::c3d::{self, C3dError, Processor, Storage};
use face_io::{LengthUnit, ReadError, markers};
use proptest::prelude::*;

const PROCESSORS: [Processor; 3] = [Processor::Intel, Processor::Dec, Processor::Mips];

fn any_forge() -> impl Strategy<Value = (Forge, LengthUnit)> {
    let units = prop::sample::select(vec![
        (Some("mm"), LengthUnit::Millimetre),
        (Some("mm      "), LengthUnit::Millimetre),
        (Some("cm"), LengthUnit::Centimetre),
        (Some("M"), LengthUnit::Metre),
        (Some("meters"), LengthUnit::Metre),
        (Some("in"), LengthUnit::Inch),
        (Some("ft"), LengthUnit::Foot),
        (Some(""), LengthUnit::Millimetre),
        (None, LengthUnit::Millimetre),
    ]);
    let counts = prop::sample::select(vec![
        Counts::HeaderOnly,
        Counts::FloatFrames,
        Counts::LongFrames,
        Counts::TrialWords,
        Counts::TrialFloats,
    ]);
    let order = prop::sample::select(vec![Order::GroupsFirst, Order::GroupsLast, Order::Backwards]);
    let gap = prop::sample::select(vec![Gap::Residual, Gap::NotANumber]);
    let shape = (1..9_usize, 1..30_usize, (0..5_u16, 1..5_u16), 1..300_u32, 2..6_u8, 1..6_usize);
    let switches = (any::<bool>(), any::<bool>(), any::<bool>());
    let processor = prop::sample::select(PROCESSORS.to_vec());
    let points = prop::collection::vec(prop::option::weighted(0.9, prop::array::uniform3(-900.0_f32..900.0)), 240);
    (shape, switches, units, counts, order, gap, processor, points).prop_map(
        |(shape, (integer, locked, padded), (units, unit), counts, order, gap, processor, points)| {
            let (markers, frames, analog, first_frame, parameter_block, labels_a_parameter) = shape;
            let names = (0..markers).map(|index| format!("subject:m{index}")).collect();
            let mut forge = Forge::new(names, points[..(markers * frames).min(240)].to_vec());
            forge.points.truncate(forge.points.len() / markers * markers);
            forge.processor = processor;
            forge.scale = integer.then_some(0.0625);
            (forge.units, forge.counts, forge.order, forge.gap) = (units, counts, order, gap);
            (forge.analog, forge.first_frame, forge.rate_hz) = (analog, first_frame, 119.88);
            (forge.parameter_block, forge.labels_a_parameter) = (parameter_block, labels_a_parameter);
            (forge.locked, forge.padded) = (locked, padded);
            (forge, unit)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn every_flavour_reads_as_what_was_put_in((forge, unit) in any_forge()) {
        let bytes = forge.bytes();
        let take = c3d::read_take(&bytes).unwrap();
        let axis = take.markers.frame_axis();
        prop_assert_eq!((axis.first, axis.count), (i64::from(forge.first_frame), forge.frames()));
        prop_assert!((axis.rate_hz - 119.88).abs() < 1e-4);
        prop_assert_eq!(take.markers.names(), &forge.names);
        prop_assert_eq!((take.processor, take.unit), (forge.processor, unit));
        prop_assert_eq!(matches!(take.storage, Storage::Integer { .. }), forge.scale.is_some());
        prop_assert_eq!(take.unit_assumed, forge.units.is_none_or(str::is_empty));
        for (read, put) in take.markers.positions().iter().zip(forge.metres(unit.metres())) {
            match put {
                None => prop_assert!(read.is_nan()),
                Some(put) => prop_assert_eq!(read.to_array(), put.map(|metres| metres as f32)),
            }
        }
        let file = markers::open("no_ending", &bytes).unwrap();
        prop_assert_eq!(&file.names, &forge.names);
    }

    #[test]
    fn a_file_cut_anywhere_says_where((forge, _) in any_forge(), at in 0.0..1.0_f64) {
        let bytes = forge.bytes();
        let end = (bytes.len() as f64 * at) as usize;
        // Padding may be cut.
        if let Err(error) = c3d::read(&bytes[..end]) {
            let text = error.to_string();
            prop_assert!(text.contains("byte") || text.contains("empty"), "{}", text);
        } else {
            prop_assert!(forge.padded && bytes.len() - end < 512);
        }
    }
}

#[test]
fn long_takes_count_in_every_place() {
    for counts in [Counts::FloatFrames, Counts::LongFrames, Counts::TrialWords, Counts::TrialFloats] {
        for processor in PROCESSORS {
            let points = (0..70_001).map(|t| Some([t as f32, 1.0, 2.0])).collect();
            let mut forge = Forge::new(vec!["chin".into()], points);
            (forge.counts, forge.processor, forge.first_frame) = (counts, processor, 5);
            let markers = c3d::read(&forge.bytes()).unwrap();
            assert_eq!((markers.frames(), markers.frame_axis().first), (70_001, 5), "{counts:?} {processor:?}");
            assert!((markers.frame(70_000)[0].x - 70.0).abs() < 1e-5);
        }
    }
}

#[test]
fn a_data_start_left_behind_is_outvoted() {
    let points = (0..60).map(|t| Some([t as f32, 1.0, 2.0])).collect();
    let mut forge = Forge::new(vec!["chin".into(), "brow".into()], points);
    forge.padded = false;
    let whole = c3d::read(&forge.bytes()).unwrap();
    for stale in [4_u16, 9] {
        let mut bytes = forge.bytes();
        bytes[16..18].copy_from_slice(&stale.to_le_bytes());
        assert_eq!(c3d::read(&bytes).unwrap(), whole, "header says {stale}");
    }
}

#[test]
fn counts_that_nothing_bears_out_are_refused_before_memory_is_asked_for() {
    let mut forge = Forge::new(vec!["chin".into()], vec![Some([1.0; 3]); 4]);
    forge.counts = Counts::LongFrames;
    let whole = forge.bytes();
    let value = |name: &[u8], ahead: usize| {
        whole.windows(name.len()).position(|window| window == name).unwrap() + name.len() + ahead
    };
    // Distance, type, number of dimensions and the dimension stand before the value.
    let at = value(b"LONG_FRAMES", 5);
    let mut bytes = whole.clone();
    bytes[at..at + 4].copy_from_slice(&4.0e9_f32.to_le_bytes());
    // The header knows better, as long as the length of the file bears it out.
    assert_eq!(c3d::read(&bytes).unwrap().frames(), 4);
    bytes.extend([0; 5000]);
    let error = c3d::read(&bytes).unwrap_err().to_string();
    assert!(error.contains("of 4000000000 begins at byte"), "{error}");
    for frames in [0, 4] {
        let mut claimed = Forge::new(vec!["chin".into()], vec![Some([1.0; 3]); frames]);
        claimed.claimed_points = Some(4.0e9);
        let mut bytes = claimed.bytes();
        // The header claims none, so that only the parameter speaks.
        bytes[2..4].copy_from_slice(&0_u16.to_le_bytes());
        match c3d::read(&bytes) {
            Err(error) => assert!(error.to_string().contains("byte"), "{error}"),
            Ok(markers) => assert!(markers.names().len() < 2, "{} names", markers.names().len()),
        }
    }
}

#[test]
fn wrong_values_name_their_byte() {
    let forge = Forge::new(vec!["chin".into()], vec![Some([1.0; 3]); 4]);
    let bytes = |change: &dyn Fn(&mut Forge)| {
        let mut forge = forge.clone();
        change(&mut forge);
        c3d::read(&forge.bytes()).unwrap_err()
    };
    let unit = bytes(&|forge| forge.units = Some("deg"));
    let ReadError::C3d(C3dError::Unit { at, .. }) = &unit else { panic!("{unit}") };
    assert!(*at > 512 && unit.to_string().starts_with(&format!("C3D: byte {at}: POINT:UNITS is `deg`")), "{unit}");
    let rate = bytes(&|forge| forge.rate_hz = 0.0).to_string();
    assert!(rate.contains("byte ") && rate.contains("POINT:RATE is 0"), "{rate}");
    let scale = bytes(&|forge| forge.scale = Some(0.0)).to_string();
    assert!(scale.contains("byte ") && scale.contains("POINT:SCALE is 0"), "{scale}");
}
