//! Curves and markers as tables: real ones, round trips, and what is refused.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::{bytes, data, files};
use face_io::{LengthUnit, c3d, curves, marker_csv};
use face_math::data::{Curves, Markers};
use glam::Vec3;
use proptest::prelude::*;
use wire::FrameAxis;

fn error(table: &str) -> String {
    curves::read(table.as_bytes(), Some(60.0)).unwrap_err().to_string()
}

fn marker_error(table: &str) -> String {
    marker_csv::read(table.as_bytes(), Some(60.0)).unwrap_err().to_string()
}

#[test]
fn weights_that_drove_real_takes_read_in_full() {
    let Some(data) = data() else { return };
    for path in files(&data.join("actors/ict_actor_a/truth"), ".csv") {
        let truth = curves::read(&bytes(&path), Some(60.0)).unwrap();
        assert_eq!(truth.channels().len(), 53);
        let take = data.join("actors/ict_actor_a/takes").join(path.file_stem().unwrap()).with_extension("c3d");
        assert_eq!(truth.frames(), c3d::read(&bytes(take)).unwrap().frames());
        assert!(truth.values().iter().all(|value| (0.0..=1.01).contains(value)));
        let again = curves::read(&curves::write(&truth, true).unwrap(), None).unwrap();
        assert!(again == truth);
        let again = curves::read(&curves::write(&truth, false).unwrap(), Some(60.0)).unwrap();
        assert!(again == truth);
    }
    let path = data.join("actors/ict_actor_a/truth/day1_161.csv");
    assert!(curves::read(&bytes(path), None).unwrap_err().to_string().contains("# rate_hz: 60"));
}

#[test]
fn phone_recordings_read_with_rate_and_both_sides() {
    let Some(data) = data() else { return };
    for (name, frames) in [("rom_162", 1830), ("rom_165", 1852)] {
        let bytes = bytes(data.join(format!("actors/ict_actor_a/rom/{name}.csv")));
        let table = curves::open(&bytes).unwrap();
        let live_link = table.live_link.clone().unwrap();
        assert_eq!((live_link.pose_names.len(), live_link.unmapped.len()), (9, 0));
        assert_eq!((live_link.filled_frames, live_link.repeated_rows), (0, 0));
        let curves = table.into_curves(None).unwrap();
        assert_eq!(curves.frame_axis(), FrameAxis::new(frames, 60.0));
        assert_eq!(curves.channels().len(), 54);
        let column = |name: &str| curves.index(name).unwrap();
        for t in 0..frames {
            let frame = curves.frame(t);
            assert_eq!(frame[column("browInnerUp_L")].to_bits(), frame[column("browInnerUp_R")].to_bits());
        }
        for name in ["eyeBlink_L", "jawLeft", "mouthRight", "mouthSmile_R", "cheekPuff_R", "tongueOut"] {
            column(name);
        }
        let again = curves::read(&curves::write_live_link(&curves, curves::Timecode::ZERO).unwrap(), None).unwrap();
        assert!(again == curves);
    }
}

#[test]
fn neutral_markers_read_in_metres() {
    let Some(data) = data() else { return };
    let neutral = marker_csv::read(&bytes(data.join("actors/ict_actor_a/neutral_markers.csv")), None).unwrap();
    assert_eq!((neutral.names().len(), neutral.frames(), neutral.names()[0].as_str()), (102, 1, "jawline_03"));
    assert!((neutral.frame(0)[0] - Vec3::new(-0.067_596, -0.025_611_5, 0.054_323_2)).length() < 1e-7);
    let again = marker_csv::write_neutral(&neutral, LengthUnit::Millimetre).unwrap();
    assert!(marker_csv::read(&again, None).unwrap() == neutral);
}

#[test]
fn real_takes_with_gaps_round_trip_as_tables() {
    let Some(data) = data() else { return };
    let take = c3d::read(&bytes(data.join("actors/ict_actor_a/takes/day2_167.c3d"))).unwrap();
    let again = marker_csv::read(&marker_csv::write(&take, LengthUnit::Millimetre).unwrap(), None).unwrap();
    assert_eq!((again.names(), again.frame_axis()), (take.names(), take.frame_axis()));
    let bits = |markers: &Markers| -> Vec<_> {
        markers.positions().iter().map(|p| if p.is_nan() { [0; 3] } else { p.to_array().map(f32::to_bits) }).collect()
    };
    assert!(bits(&again) == bits(&take));
}

#[test]
fn tables_of_any_editor_are_understood() {
    let table = "\u{feff}# rate_hz: 24\r\nFrame,\"a, left\",b\r\n# keyed by hand\r\n-1,0.5,1e-3\r\n0, .25 ,-0\r\n\r\n";
    let curves = curves::read(table.as_bytes(), Some(60.0)).unwrap();
    assert_eq!(curves.frame_axis(), FrameAxis { first: -1, count: 2, rate_hz: 24.0 });
    assert_eq!(curves.channels(), ["a, left", "b"]);
    assert_eq!(curves.values(), [0.5, 0.001, 0.25, 0.0]);
}

#[test]
fn mistakes_are_named_with_line_and_column() {
    assert!(error("frame,a\n0,0.5\n1,\n").contains("3:3: `` in column `a` is not a finite number"));
    assert!(error("frame,a\n0,nan\n").contains("2:3: `nan` in column `a`"));
    assert!(error("frame,a\n0,1\n2,1\n").contains("3:1: frame 2 follows frame 0"));
    assert!(error("frame,a\n0.5,1\n").contains("2:1: `0.5` in column `frame`"));
    assert!(error("time,a\n0,1\n").contains("1:1: column `time`: the first column must be `frame`"));
    assert!(error("frame,a\n").contains("no rows"));
    assert!(error("frame,a,a\n0,1,1\n").contains("1:9: column `a`: the name stands twice"));
    assert!(error("Timecode,BlendshapeCount,EyeBlinkLeft\n00:00:00:00.0,0,0.1\n").contains("2:15: `0`"));
    assert!(
        error("Timecode,BlendshapeCount,EyeBlinkLft\n00:00:00:00.0,1,0.1\n").contains("did you mean `EyeBlinkLeft`")
    );
    assert!(
        error("Timecode,BlendshapeCount,EyeBlinkLeft\n0:0:0,1,0.1\n").contains("2:1: `0:0:0` in column `Timecode`")
    );
    assert!(marker_error("marker,x_mm,y_mm,z_mm\nchin,1,2\n").contains("line 2 has 3 cells"));
    assert!(marker_error("marker,x_mm,y_mm,z_cm\nchin,1,2,3\n").contains("1:18: column `z_cm`: its unit is cm"));
    assert!(marker_error("marker,x,y,z\nchin,1,2,3\n").contains("must end in _x and a unit"));
    assert!(marker_error("marker,x_mm,y_mm,z_mm\nchin,1,,3\n").contains("2:8: ``"));
    assert!(marker_error("marker,x_mm,y_mm,z_mm\nchin,1,2,3\nchin,1,2,3\n").contains("3:1: `chin`"));
    assert!(marker_error("frame,a_x_mm,a_y_mm,b_z_mm\n0,1,2,3\n").contains("1:21: column `b_z_mm`"));
    assert!(marker_error("frame,a_x_mm,a_y_mm\n0,1,2\n").contains("three columns"));
}

fn names(count: usize) -> impl Strategy<Value = Vec<String>> {
    prop::collection::btree_set("[a-zA-Z_#][ -~]{0,8}[a-z]", count)
        .prop_map(|names| names.into_iter().filter(|name| !name.eq_ignore_ascii_case("frame")).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_curves_round_trip(
        channels in names(3),
        values in prop::collection::vec(prop::num::f32::NORMAL | prop::num::f32::ZERO | prop::num::f32::SUBNORMAL, 30),
        first in -1000_i64..1000,
        rate_hz in 1.0_f64..240.0,
    ) {
        let count = values.len() / channels.len().max(1);
        let values = values[..count * channels.len()].to_vec();
        let curves = Curves::new(FrameAxis { first, count, rate_hz }, channels, values).unwrap();
        let again = curves::read(&curves::write(&curves, true).unwrap(), None).unwrap();
        prop_assert_eq!(again, curves);
    }

    #[test]
    fn any_markers_round_trip(
        names in names(2),
        coordinates in prop::collection::vec((-3.0_f32..3.0, any::<bool>()), 24),
        first in -1000_i64..1000,
    ) {
        let count = coordinates.len() / names.len();
        let positions: Vec<_> = coordinates[..count * names.len()]
            .iter()
            .map(|(x, there)| if *there { Vec3::new(*x, -x, x * 0.3) } else { Vec3::NAN })
            .collect();
        let markers = Markers::new(FrameAxis { first, count, rate_hz: 59.94 }, names, positions).unwrap();
        let again = marker_csv::read(&marker_csv::write(&markers, LengthUnit::Metre).unwrap(), None).unwrap();
        prop_assert_eq!(again.names(), markers.names());
        for (a, b) in again.positions().iter().zip(markers.positions()) {
            prop_assert!(a == b || a.is_nan() && b.is_nan());
        }
    }

    #[test]
    fn no_damage_panics(at in 0_usize..400, value: u8, end in 0_usize..400) {
        let tables = [
            "# rate_hz: 60\nframe,\"a\"\"b\",c\r\n0,0.5,1\n1,0.25,0.75\n2,1e9,-3\n",
            "Timecode,BlendshapeCount,EyeBlinkLeft,HeadYaw\n00:00:59:58.1,2,0,0\n00:00:59:59.1,2,1,0\n00:01:00:00.1,2,0,0\n",
            "marker,x_mm,y_mm,z_mm\nchin,1,2,3\nbrow,,,\n",
            "frame,a_x_mm,a_y_mm,a_z_mm\n7,1,2,3\n8,,,\n",
        ];
        for table in tables {
            let mut bytes = table.as_bytes().to_vec();
            let length = bytes.len();
            bytes[at % length] = value;
            for part in [&bytes[..], &bytes[..end % length]] {
                let _ = curves::read(part, Some(60.0));
                let _ = marker_csv::read(part, Some(60.0));
            }
        }
    }
}
