//! Every reader of markers on damaged files, synthetic and real: never a panic, never more memory than the file is
//! worth, and an error that names a place.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::forge::{Counts, Forge, Order};
use common::harm::{Harm, harms};
use common::tables::Tables;
use common::{bytes, data, files};
use face_io::c3d::Processor;
use face_io::markers::{self, motive, openface, trc, vicon};
use face_io::{ReadError, c3d, inspect, marker_csv, no_sibling};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::sync::LazyLock;

/// How many points a byte may stand for at most.
const POINTS_A_BYTE: usize = 16;

fn check(bytes: &[u8]) -> Result<(), TestCaseError> {
    let readers = [c3d::open, trc::open, motive::open, vicon::open, openface::open, marker_csv::open];
    let named = |bytes: &[u8]| markers::open("take.csv", bytes);
    for read in readers.into_iter().chain([named as fn(&[u8]) -> Result<_, ReadError>]) {
        match read(bytes) {
            Err(error) => prop_assert!(!error.to_string().is_empty()),
            Ok(file) => {
                prop_assert_eq!(file.positions.len(), file.names.len() * file.frames);
                prop_assert!(file.positions.len() <= POINTS_A_BYTE * bytes.len());
                prop_assert!(file.names.len() <= bytes.len().max(65_535));
                prop_assert_eq!(file.names.iter().collect::<BTreeSet<_>>().len(), file.names.len());
                prop_assert!(file.positions.iter().all(|point| point.is_finite() || point.is_nan()));
                prop_assert!(file.rate_hz.is_none_or(|rate| rate.is_finite() && rate > 0.0));
            }
        }
    }
    let _ = inspect("take.csv", bytes, &mut no_sibling);
    Ok(())
}

/// A file of each kind and flavour.
static SOUND: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let points: Vec<_> = (0..48).map(|i| (i % 7 != 6).then_some([i as f32, 0.5, -1.25])).collect();
    let names = ["anna:chin", "anna:lip_1", "brow"].map(str::to_owned).to_vec();
    let mut sound = Vec::new();
    for (index, processor) in [Processor::Intel, Processor::Dec, Processor::Mips].into_iter().enumerate() {
        let mut forge = Forge::new(names.clone(), points.clone());
        (forge.processor, forge.analog, forge.labels_a_parameter) = (processor, (2, 3), 2);
        forge.counts = [Counts::TrialWords, Counts::LongFrames, Counts::TrialFloats][index];
        forge.order = [Order::GroupsFirst, Order::GroupsLast, Order::Backwards][index];
        sound.push(forge.bytes());
        forge.scale = Some(0.1);
        sound.push(forge.bytes());
    }
    let tables = Tables::new(names, points);
    sound.push(tables.trc(true, true));
    sound.push(Tables { trimmed: true, line_end: "\r\n", ..tables.clone() }.trc(false, false));
    sound.push(tables.motive("1.21", 4));
    sound.push(tables.motive("1.24", 3));
    sound.push(tables.vicon(",", true, false));
    sound.push(tables.vicon("\t", false, true));
    sound.push(tables.openface(false, true));
    let take = markers::read("a", &sound[0], None).unwrap();
    sound.push(marker_csv::write(&take, face_io::LengthUnit::Millimetre).unwrap());
    sound
});

/// Real files, cut to a length at which thousands of readings pass in seconds.
static REAL: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let Some(data) = data() else { return Vec::new() };
    let mut real: Vec<_> = files(&data.join("mocap"), ".c3d").iter().map(bytes).collect();
    for path in ["mocap/csv/sample_optitrack_take.csv", "mocap/csv/markers.csv", "mocap/trc/Gait.trc"] {
        real.push(bytes(data.join(path)));
    }
    for bytes in &mut real {
        bytes.truncate(90_000);
    }
    real
});

fn harmed(sound: &[u8], harms: &[Harm]) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for harm in harms {
        harm.apply(&mut bytes);
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn no_damage_to_a_synthetic_file_panics(which in any::<prop::sample::Index>(), harms in harms()) {
        check(&harmed(&SOUND[which.index(SOUND.len())], &harms))?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn no_damage_to_a_real_file_panics(which in any::<prop::sample::Index>(), harms in harms()) {
        if !REAL.is_empty() {
            check(&harmed(&REAL[which.index(REAL.len())], &harms))?;
        }
    }

    #[test]
    fn no_noise_panics(noise in prop::collection::vec(any::<u8>(), 0..2000)) {
        check(&noise)?;
    }
}

#[test]
fn every_byte_of_a_small_file_may_be_any_extreme() {
    for sound in SOUND.iter() {
        for at in 0..sound.len().min(900) {
            for value in [0, 0xff, 0x7f, 0x80, b'9', b'-', b'"'] {
                let mut bytes = sound.clone();
                bytes[at] = value;
                let _ = markers::open("take", &bytes);
            }
        }
    }
}
