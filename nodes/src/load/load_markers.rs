//! `load_markers`: takes of markers from files; where most graphs begin.

use super::selection::Selection;
use crate::unit::Unit;
use face_io::{LengthUnit, c3d, marker_csv};
use face_math::data::Markers;
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port, SourceFile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wire::FrameAxis;

const MARKERS: Port<Markers> =
    Port::new("markers", "named points over frames, in metres; a point that was not seen is missing (NaN)");

/// Loads markers from C3D files and from tables (CSV).
///
/// C3D is read in every flavour: PC, DEC and SGI numbers, integer and real. Unnamed points are called `point_1`,
/// `point_2` and so on. Tables have a column `frame` and then three columns a marker (`chin_x_mm`, `chin_y_mm`,
/// `chin_z_mm`); a face at rest has the columns `marker`, `x_mm`, `y_mm`, `z_mm`. Empty cells are missing points.
///
/// The parameters work in this order: `strip_subject`, `only`, `without`, `rename`.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadMarkers {
    /// The file, or a pattern such as `takes/*.c3d`, which gives one item for each file that it fits.
    path: String,
    /// Unit of the coordinates in the file, in place of the one that it states. C3D files that state none are taken
    /// to be in millimetres.
    unit: Option<Unit>,
    /// Frames a second, in place of what the file states. Tables often state nothing; then it must be given here.
    #[schemars(range(min = 0.001, max = 100_000.0))]
    rate_hz: Option<f64>,
    /// Cuts the subject's name off: `anna:chin` becomes `chin`.
    strip_subject: bool,
    /// Names of markers to keep, as patterns: `lip_*`, `brow_[LR]_1`, `{chin,jaw*}`. Keeps all where empty.
    only: Vec<String>,
    /// Names of markers to leave out, as patterns: `head_*`.
    without: Vec<String>,
    /// New names by old ones: `{"LLip1": "lip_1"}`. A name that is not in the file is an error.
    rename: BTreeMap<String, String>,
}

graph_core::register!(LoadMarkers);

#[typetag::serde(name = "load_markers")]
impl Node for LoadMarkers {
    fn card(&self) -> Card {
        Card::new("load").reads("path").gives(&MARKERS)
    }

    fn compute(&self, context: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        let source = context.source()?;
        let (mut markers, unit) = self.read(&source)?;
        if let Some(wanted) = self.unit.map(LengthUnit::from).filter(|wanted| *wanted != unit) {
            markers = restated(&markers, unit, wanted).map_err(|error| NodeError::file(&source.name, error))?;
        }
        Ok(Outputs::default().with(&MARKERS, self.selected(&source.name, &markers)?))
    }
}

impl LoadMarkers {
    /// The markers in the file, in metres, and the unit in which the file has them.
    fn read(&self, source: &SourceFile) -> Result<(Markers, LengthUnit), NodeError> {
        let wrong = |problem: &dyn std::fmt::Display| NodeError::file(&source.name, problem);
        let bytes = source.bytes.as_slice();
        let (markers, unit) = match super::extension(&source.name).as_str() {
            "csv" => {
                let mut table = marker_csv::open(bytes).map_err(|error| wrong(&error))?;
                table.rate_hz = self.rate_hz.or(table.rate_hz);
                let unit = table.unit;
                (table.into_markers(None).map_err(|error| wrong(&error))?, unit)
            }
            other if other == "c3d" || c3d::detect(bytes) => {
                let take = c3d::read_take(bytes).map_err(|error| wrong(&error))?;
                let axis = take.markers.frame_axis();
                let axis = FrameAxis { rate_hz: self.rate_hz.unwrap_or(axis.rate_hz), ..axis };
                let markers = Markers::new(axis, take.markers.names().to_vec(), take.markers.positions().to_vec());
                (markers.map_err(|error| wrong(&error))?, take.unit)
            }
            _ => return Err(wrong(&"markers are read from C3D (.c3d) and from tables (.csv); convert the file first")),
        };
        if markers.names().is_empty() || markers.frames() == 0 {
            let (count, frames) = (markers.names().len(), markers.frames());
            return Err(wrong(&format!("holds {count} markers in {frames} frames; export the trajectories again")));
        }
        Ok((markers, unit))
    }

    fn selected(&self, file: &str, markers: &Markers) -> Result<Markers, NodeError> {
        let bare = |name: &String| match name.rsplit_once(':') {
            Some((_, own)) if self.strip_subject => own.to_owned(),
            _ => name.clone(),
        };
        let names: Vec<String> = markers.names().iter().map(bare).collect();
        if let Some((index, name)) = names.iter().enumerate().find(|(index, name)| names[..*index].contains(name)) {
            let other = names.iter().position(|own| own == name).unwrap_or_default();
            let [other, this] = [other, index].map(|index| &markers.names()[index]);
            let problem =
                format!("`{other}` and `{this}` of {file} would both be `{name}`; load one subject with `only`");
            return Err(NodeError::parameter("strip_subject", problem));
        }
        let selection = Selection { what: "marker", only: &self.only, without: &self.without, rename: &self.rename };
        let (columns, names): (Vec<usize>, Vec<String>) = selection.apply(file, &names)?.into_iter().unzip();
        let positions = (0..markers.frames()).flat_map(|frame| {
            let all = markers.frame(frame);
            columns.iter().map(|column| all[*column])
        });
        Markers::new(markers.frame_axis(), names, positions.collect()).map_err(|error| NodeError::file(file, error))
    }
}

/// The same numbers, read as `wanted` instead of `stated`.
fn restated(markers: &Markers, stated: LengthUnit, wanted: LengthUnit) -> Result<Markers, face_math::data::DataError> {
    let restate = |metres: f32| wanted.to_metres(f64::from(stated.from_metres(metres)));
    let positions = markers
        .positions()
        .iter()
        .map(|point| if point.is_nan() { Vec3::NAN } else { Vec3::from_array(point.to_array().map(restate)) });
    markers.with_positions(positions.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, made, test_data};
    use serde_json::json;

    fn load(parameters: serde_json::Value, name: &str, bytes: &[u8]) -> Result<Markers, String> {
        let node: LoadMarkers = made(parameters);
        let outputs = Bench::default().with_source(name, bytes).compute(&node, &Inputs::default());
        outputs.map(|outputs| outputs.get(&MARKERS).unwrap().clone()).map_err(|error| error.to_string())
    }

    fn take() -> Markers {
        let names = ["anna:chin", "anna:lip_1", "anna:head_1"].map(str::to_owned).to_vec();
        let axis = FrameAxis { first: 101, count: 2, rate_hz: 60.0 };
        let mut positions: Vec<Vec3> = (0..6).map(|i| Vec3::new(i as f32 * 0.25, 0.5, -0.125)).collect();
        positions[4] = Vec3::NAN;
        Markers::new(axis, names, positions).unwrap()
    }

    fn same(a: &Markers, b: &Markers) {
        assert_eq!(a.names(), b.names());
        assert_eq!(a.frame_axis(), b.frame_axis());
        for (a, b) in a.positions().iter().zip(b.positions()) {
            assert!(a == b || a.is_nan() && b.is_nan(), "{a} {b}");
        }
    }

    #[test]
    fn written_takes_are_read_back() {
        let bytes = c3d::write(&take(), LengthUnit::Millimetre).unwrap();
        same(&load(json!({}), "day1.C3D", &bytes).unwrap(), &take());
        same(&load(json!({}), "day1", &bytes).unwrap(), &take());
        let bytes = marker_csv::write(&take(), LengthUnit::Millimetre).unwrap();
        same(&load(json!({}), "day1.csv", &bytes).unwrap(), &take());
    }

    #[test]
    fn unit_and_rate_replace_those_of_the_file() {
        let bytes = c3d::write(&take(), LengthUnit::Millimetre).unwrap();
        let markers = load(json!({"unit": "cm", "rate_hz": 120.0}), "a.c3d", &bytes).unwrap();
        assert!((markers.frame(0)[1].x - 2.5).abs() < 1e-6 && markers.frame(1)[1].is_nan());
        assert_eq!(markers.frame_axis(), FrameAxis { first: 101, count: 2, rate_hz: 120.0 });
    }

    #[test]
    fn names_are_stripped_chosen_and_renamed() {
        let bytes = c3d::write(&take(), LengthUnit::Millimetre).unwrap();
        let with = json!({"strip_subject": true, "without": ["head_*"], "rename": {"chin": "mental"}});
        let markers = load(with, "a.c3d", &bytes).unwrap();
        assert_eq!(markers.names(), ["mental", "lip_1"]);
        assert_eq!(markers.frame(1)[0], take().frame(1)[0]);
        let error = load(json!({"only": ["anna:chn"]}), "a.c3d", &bytes).unwrap_err();
        assert!(error.contains("did you mean `anna:chin`?"), "{error}");
    }

    #[test]
    fn two_subjects_are_not_mixed_up() {
        let names = ["anna:chin", "ben:chin"].map(str::to_owned).to_vec();
        let markers = Markers::new(FrameAxis::new(1, 60.0), names, vec![Vec3::ZERO; 2]).unwrap();
        let bytes = c3d::write(&markers, LengthUnit::Metre).unwrap();
        let error = load(json!({"strip_subject": true}), "a.c3d", &bytes).unwrap_err();
        assert!(error.contains("`anna:chin` and `ben:chin` of a.c3d would both be `chin`"), "{error}");
    }

    #[test]
    fn a_table_without_a_rate_asks_for_one() {
        let table = "frame,chin_x_mm,chin_y_mm,chin_z_mm\n1,1,2,3\n2,,,\n";
        let error = load(json!({}), "a.csv", table.as_bytes()).unwrap_err();
        assert!(error.starts_with("a.csv: ") && error.contains("rate"), "{error}");
        let markers = load(json!({"rate_hz": 25.0}), "a.csv", table.as_bytes()).unwrap();
        assert_eq!(markers.frame_axis(), FrameAxis { first: 1, count: 2, rate_hz: 25.0 });
        assert_eq!(markers.missing(), 1);
    }

    #[test]
    fn other_files_are_refused_with_what_is_readable() {
        let error = load(json!({}), "a.trc", b"PathFileType\t4").unwrap_err();
        assert!(error.starts_with("a.trc: ") && error.contains(".c3d") && error.contains(".csv"), "{error}");
        assert!(load(json!({}), "a.c3d", b"no").unwrap_err().starts_with("a.c3d: C3D"));
        let none = Markers::new(FrameAxis::new(0, 60.0), vec!["chin".into()], Vec::new()).unwrap();
        let bytes = c3d::write(&none, LengthUnit::Metre).unwrap();
        assert!(load(json!({}), "a.c3d", &bytes).unwrap_err().contains("1 markers in 0 frames"));
    }

    #[test]
    fn a_real_take_is_read() {
        let Some(path) = test_data("actors/ict_actor_a/neutral_markers.csv") else { return };
        let neutral = load(json!({}), "neutral_markers.csv", &std::fs::read(&path).unwrap()).unwrap();
        let takes = path.with_file_name("takes");
        let file = std::fs::read_dir(takes).unwrap().map(|entry| entry.unwrap().path()).min().unwrap();
        let take = load(json!({}), "take.c3d", &std::fs::read(file).unwrap()).unwrap();
        assert_eq!(take.names(), neutral.names());
        assert_eq!(take.names().len(), 102);
        let face = load(json!({"without": ["head_*"]}), "n.csv", &std::fs::read(path).unwrap()).unwrap();
        assert_eq!(face.names().len(), 98);
    }
}
