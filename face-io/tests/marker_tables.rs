//! TRC, Motive, Vicon and `OpenFace`: tables written here with the liberties that each system takes, real ones, and what
//! is said of damaged ones.
#![allow(clippy::float_cmp, reason = "what is written is read back to the bit")]
#![allow(clippy::format_collect, reason = "short tables, made once")]
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::tables::Tables;
use common::{bytes, data};
use face_io::markers::{self, Format, MarkerFile, trc};
use face_io::{LengthUnit, inspect, no_sibling};
use face_math::data::Markers;
use glam::Vec3;
use proptest::prelude::*;
use wire::FrameAxis;

fn open(bytes: &[u8]) -> MarkerFile {
    markers::open("take", bytes).unwrap_or_else(|error| panic!("{error}\n{}", String::from_utf8_lossy(bytes)))
}

fn error(name: &str, text: &str) -> String {
    markers::open(name, text.as_bytes()).unwrap_err().to_string()
}

fn any_tables() -> impl Strategy<Value = (Tables, LengthUnit)> {
    let units = vec![("mm", LengthUnit::Millimetre), ("Meters", LengthUnit::Metre), ("cm", LengthUnit::Centimetre)];
    let ends = prop::sample::select(vec!["\n", "\r\n", "\r"]);
    let missing = prop::sample::select(vec!["", "NaN", "nan"]);
    let points = prop::collection::vec(prop::option::weighted(0.8, prop::array::uniform3(-900.0_f32..900.0)), 60);
    let shape = (1..7_usize, 1..12_usize, -50..2000_i64, any::<bool>(), any::<bool>());
    (shape, prop::sample::select(units), ends, missing, points).prop_map(
        |((count, frames, first, trimmed, mark), (stated, unit), line_end, missing, points)| {
            let names = (0..count).map(|index| format!("anna:lip {index}")).collect::<Vec<_>>();
            let points = points[..(count * frames).min(60) / count * count].to_vec();
            let mut tables = Tables::new(names, points);
            (tables.first_frame, tables.unit, tables.line_end) = (first, stated, line_end);
            (tables.missing, tables.trimmed, tables.byte_order_mark) = (missing, trimmed, mark);
            tables.rate_hz = 59.94;
            (tables, unit)
        },
    )
}

fn check(file: &MarkerFile, tables: &Tables, unit: LengthUnit, format: Format) -> Result<(), TestCaseError> {
    prop_assert_eq!(&file.names, &tables.names);
    prop_assert_eq!((file.format, file.first_frame, file.frames), (format, tables.first_frame, tables.frames()));
    prop_assert_eq!((file.unit, file.rate_hz), (unit, Some(59.94)));
    for (read, put) in file.positions.iter().zip(&tables.points) {
        match put {
            None => prop_assert!(read.is_nan()),
            Some(put) => prop_assert_eq!(read.to_array(), put.map(|number| unit.to_metres(f64::from(number)))),
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_dialect_of_trc_reads((tables, unit) in any_tables(), axes: bool, blank: bool) {
        check(&open(&tables.trc(axes, blank)), &tables, unit, Format::Trc)?;
    }

    #[test]
    fn every_version_of_motive_reads(
        (tables, unit) in any_tables(),
        version in prop::sample::select(vec!["1.1", "1.21", "1.22", "1.24"]),
        rotation in 3..5_usize,
    ) {
        let file = open(&tables.motive(version, rotation));
        check(&file, &tables, unit, Format::Motive { expected: false })?;
        prop_assert_eq!(&file.left_out[..], &["1 of kind `Rigid Body`", "1 of kind `Rigid Body Marker`"]);
    }

    #[test]
    fn every_export_of_nexus_reads(
        (tables, unit) in any_tables(),
        separator in prop::sample::select(vec![",", "\t", ";"]),
        devices: bool,
        velocities: bool,
    ) {
        check(&open(&tables.vicon(separator, devices, velocities)), &tables, unit, Format::Vicon)?;
    }

    #[test]
    fn trc_that_is_written_reads_back_bit_for_bit((tables, unit) in any_tables()) {
        let whole = |point: &Option<[f32; 3]>| {
            point.map_or(Vec3::NAN, |point| Vec3::from_array(point.map(|number| unit.to_metres(f64::from(number)))))
        };
        let axis = FrameAxis { first: tables.first_frame, count: tables.frames(), rate_hz: tables.rate_hz };
        let positions = tables.points.iter().map(whole).collect();
        let markers = Markers::new(axis, tables.names.clone(), positions).unwrap();
        let again = markers::read("a", &trc::write(&markers, unit).unwrap(), None).unwrap();
        prop_assert_eq!((again.names(), again.frame_axis()), (markers.names(), axis));
        for (a, b) in again.positions().iter().zip(markers.positions()) {
            prop_assert!(a == b || a.is_nan() && b.is_nan());
        }
    }
}

fn sample() -> Tables {
    let points = (0..40).map(|i| (i % 7 != 6).then_some([i as f32, 0.5, -1.25])).collect();
    Tables { rate_hz: 25.0, ..Tables::new(["a", "b"].map(str::to_owned).to_vec(), points) }
}

#[test]
fn openface_gives_landmarks_in_space_where_it_succeeded() {
    for blanks in [false, true] {
        let tables = sample();
        let file = open(&tables.openface(false, blanks));
        assert_eq!(
            (file.format, file.names.clone()),
            (Format::OpenFace, ["landmark_0", "landmark_1"].map(str::to_owned).to_vec())
        );
        assert_eq!((file.first_frame, file.frames, file.rate_hz), (1, 20, Some(25.0)));
        for frame in 0..20 {
            let there = tables.points[2 * frame].is_some();
            assert_eq!(file.positions[2 * frame].is_nan(), !there);
            assert_eq!(file.positions[2 * frame + 1].is_nan(), !there);
        }
        assert!((file.positions[0] - Vec3::new(0.0, 0.5e-3, -1.25e-3)).length() < 1e-9);
        assert!(file.left_out.contains(&"landmarks in the picture".to_owned()));
    }
}

#[test]
fn openface_rates_are_told_only_where_the_stamps_tell_them() {
    let rate = |rate_hz: f64, frames: usize| {
        let points = vec![Some([1.0; 3]); frames];
        let tables = Tables { rate_hz, ..Tables::new(vec!["a".into()], points) };
        open(&tables.openface(false, true)).rate_hz
    };
    assert_eq!(rate(25.0, 100), Some(25.0));
    assert_eq!(rate(30_000.0 / 1001.0, 900), Some(30_000.0 / 1001.0));
    assert_eq!(rate(30.0, 900), Some(30.0));
    // 29.97 and 30 differ by less than a stamp in so short a take.
    assert_eq!(rate(30.0, 10), None);
    assert!((rate(17.0, 300).unwrap() - 17.0).abs() < 0.01);
}

#[test]
fn several_faces_have_names_of_their_own() {
    let text = "frame,face_id,timestamp,confidence,success,X_0,Y_0,Z_0\n1,0,0,0.9,1,1,2,3\n1,4,0,0.9,1,7,8,9\n3,4,0.1,0.9,1,7,8,9\n";
    let file = open(text.as_bytes());
    assert_eq!(file.names, ["face_0:landmark_0", "face_4:landmark_0"]);
    assert_eq!((file.frames, file.positions.iter().filter(|point| point.is_nan()).count()), (3, 3));
}

#[test]
fn what_is_no_marker_is_refused_with_what_to_do() {
    let flat = String::from_utf8(sample().openface(true, true)).unwrap();
    let refused = error("a.csv", &flat);
    assert!(refused.contains("without depth") && refused.contains("-3Dfp"), "{refused}");
    let facts = inspect("a.csv", flat.as_bytes(), &mut no_sibling).unwrap();
    assert_eq!(
        (facts.kind, facts.missing),
        ("landmarks", Some(2 * sample().points.iter().step_by(2).filter(|point| point.is_none()).count()))
    );
    assert!(error("a.csv", "image,confidence,x_0,y_0\na.jpg,1,2,3\n").contains("load them as landmarks"));
    assert!(error("a.csv", "frame,jawOpen\n0,1\n").contains("animation curves, no markers"));
    assert!(error("a.csv", "Timecode,BlendshapeCount,EyeBlinkLeft\n0:0:0:0,1,0\n").contains("Live Link Face"));
    assert!(error("a.trc", "").contains("TRC: the file is empty; export the take again"));
    assert!(error("a.csv", "").contains("the file is empty"));
    assert!(error("a.txt", "hello").contains("none of the kinds of file"));
    let devices = "Devices\n1000\n,,Force\nFrame,Sub Frame,Fx\n,,N\n1,0,2\n";
    assert!(error("a.csv", devices).contains("the sections `Devices`, no markers"), "{}", error("a.csv", devices));
    let mut bodies = sample();
    bodies.names.clear();
    let only_body = "Format Version,1.21,Length Units,Meters\n\n,,Rigid Body,Rigid Body,Rigid Body\n,,Hat,Hat,Hat\n,,Position,Position,Position\nFrame,Time,X,Y,Z\n0,0,1,2,3\n";
    assert!(error("a.csv", only_body).contains("1 of kind `Rigid Body`"), "{}", error("a.csv", only_body));
}

#[test]
fn expected_places_stand_in_where_motive_wrote_no_measured_markers() {
    let table = String::from_utf8(sample().motive("1.22", 4)).unwrap();
    let table = table.replace(",Marker,", ",Bone,").replace(",Marker,", ",Bone,");
    let file = open(table.as_bytes());
    assert_eq!((file.format, file.names.len()), (Format::Motive { expected: true }, 1));
    assert_eq!(file.positions[0], Vec3::new(9.5e-3, 9.25e-3, 9.125e-3));
}

#[test]
fn damage_is_named_with_its_line() {
    let tables = sample();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let trc = text(tables.trc(true, true));
    let cut = |text: &str, lines: usize| text.lines().take(lines).fold(String::new(), |all, line| all + line + "\n");
    assert!(
        error("a", &cut(&trc, 16)).contains("end in line 16 after 10, line 3 says 20"),
        "{}",
        error("a", &cut(&trc, 16))
    );
    assert!(error("a", &cut(&trc, 2)).contains("3:1: the file ends where the values of the keys must stand"));
    assert!(error("a", &cut(&trc, 6)).contains("no rows"));
    assert!(
        error("a", &trc.replace("\tmm\t", "\tdeg\t")).contains("3:14: `deg` is no unit of length"),
        "{}",
        error("a", &trc.replace("\tmm\t", "\tdeg\t"))
    );
    assert!(error("a", &trc.replace("Units", "Unit")).contains("2:1: the key `Units` is absent"));
    assert!(error("a", &trc.replace("X1\tY1", "Y1\tX1")).contains("5:3: `Y1` stands where X of a marker must"));
    assert!(error("a", &trc.replace("\n5\t", "\n6\t")).contains("11:1: frame 6 follows frame 4"));
    assert!(error("a", &trc.replace("-1.25", "x")).contains("`x` in column `a` is not a finite number"));
    assert!(
        error("a", &trc.replace("\n3\t", "\n\n3\t")).contains("blank")
            || error("a", &trc.replace("\n3\t", "\n\n3\t")).contains("says 20")
    );
    assert!(
        error("a", &trc[..trc.len() - 12]).contains("middle of this row"),
        "{}",
        error("a", &trc[..trc.len() - 12])
    );
    let motive = text(tables.motive("1.21", 4));
    assert!(error("a", &cut(&motive, 12)).contains("line 1 says 20"), "{}", error("a", &cut(&motive, 12)));
    assert!(error("a", &cut(&motive, 5)).contains("6:1: the header ends before"), "{}", error("a", &cut(&motive, 5)));
    assert!(error("a", &motive.replace("Length Units,mm", "Length Units,px")).contains("`px` is no unit of length"));
    assert!(error("a", &motive.replace("X,Y,Z,X,Y,Z,X,Y,Z,\n", "X,Y,Z,X,Z,Y,X,Y,Z,\n")).contains("expected Y of `b`"));
    let vicon = text(tables.vicon(",", true, true));
    assert!(
        error("a", &vicon.replace(",mm,mm,mm/s", ",mm,m,mm/s"))
            .contains("its unit is m, that of the columns before mm")
    );
    assert!(error("a", &vicon.replace("X,Y,Z,X'", "X,Z,Y,X'")).contains("`X` stands alone"));
    assert!(error("a", &vicon.replacen("\n3,0,", "\n3,1,", 1)).contains("in column `Sub Frame`"));
    let face = text(tables.openface(false, true));
    assert!(error("a", &face.replace(", 1, 0.1", ", 2, 0.1")).contains("`2` in column `success` is not 0 or 1"));
}

#[test]
fn rows_of_next_to_nothing_are_refused_before_memory_is_asked_for() {
    let names = (0..40_000).map(|index| format!("m{index}\t\t\t")).collect::<String>();
    let rows: String = (1..200_000).map(|frame| format!("{frame}\n")).collect();
    let file = format!("PathFileType\t4\nDataRate\tUnits\n60\tmm\nFrame#\tTime\t{names}\n\n{rows}");
    assert!(error("a", &file).contains("next to nothing of the 40000 markers"));
    let faces: String = (0..3000_i64).map(|face| format!("{},{face},1,2,3\n", face * 1_000_000)).collect();
    assert!(error("a", &format!("frame,face_id,X_0,Y_0,Z_0\n{faces}")).contains("next to nothing"));
}

#[test]
fn real_takes_of_every_system_read() {
    let Some(data) = data() else { return };
    let read = |path: &str| open(&bytes(data.join(path)));
    let motive = read("mocap/csv/sample_optitrack_take.csv");
    assert_eq!((motive.format, motive.names.len(), motive.frames), (Format::Motive { expected: false }, 9, 250));
    assert_eq!((motive.first_frame, motive.rate_hz, motive.unit), (0, Some(120.0), LengthUnit::Metre));
    assert_eq!(motive.names[3], "Rigid Body 1:Marker1");
    assert_eq!(motive.positions[3], Vec3::new(0.009_933, 0.019_16, 0.009_812));
    assert_eq!(motive.left_out, ["1 of kind `Rigid Body`", "3 of kind `Rigid Body Marker`"]);
    let vicon = read("mocap/csv/markers.csv");
    assert_eq!((vicon.format, vicon.names.len(), vicon.frames, vicon.rate_hz), (Format::Vicon, 51, 580, Some(100.0)));
    assert!((vicon.positions[0] - Vec3::new(44.1628e-3, -276.862e-3, 675.697e-3)).length() < 1e-7);
    let gait = read("mocap/trc/Gait.trc");
    assert_eq!((gait.format, gait.names.len(), gait.frames, gait.rate_hz), (Format::Trc, 33, 487, Some(100.0)));
    assert_eq!((gait.names[0].as_str(), gait.left_out[0].as_str()), ("R.Shoulder", "72 unnamed trajectories"));
    assert!(gait.positions.iter().any(|point| point.is_nan()) && gait.positions.iter().any(|point| point.is_finite()));
    let empty = markers::open("Empty.trc", &bytes(data.join("mocap/trc/Empty.trc"))).unwrap_err().to_string();
    assert_eq!(empty, "TRC: the file is empty; export the take again");
    for path in ["mocap/csv/sample_optitrack_take.csv", "mocap/csv/markers.csv", "mocap/trc/Gait.trc"] {
        let whole = bytes(data.join(path));
        let facts = serde_json::to_value(inspect("x", &whole, &mut no_sibling).unwrap()).unwrap();
        assert_eq!(facts["kind"], "markers");
        assert!(
            facts["missing_share"].as_f64().unwrap() > 0.0 && facts["extent_m"][0].as_f64().unwrap() > 0.5,
            "{facts}"
        );
        let error = markers::open("x", &whole[..whole.len() * 2 / 3]).map(|file| file.frames).unwrap_err().to_string();
        assert!(error.contains("line "), "{path}: {error}");
    }
}
