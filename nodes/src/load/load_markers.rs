//! `load_markers`: takes of markers from files; where most graphs begin.

use crate::selection::{Mapping, Selection};
use crate::unit::Unit;
use face_io::{LengthUnit, markers};
use face_math::data::{Markers, nearest_name};
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port, SourceFile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

const MARKERS: Port<Markers> =
    Port::new("markers", "named points over frames, in metres; a point that was not seen is missing (NaN)");

/// Loads markers from what capture systems write.
///
/// What a file is shows in its content, whatever it is called:
///
/// - C3D in every flavour: PC, DEC and SGI numbers, integer and real. Unnamed points are called `point_1`, `point_2` and
///   so on.
/// - TRC. Trajectories without a name, which systems append as they come and go, are left out.
/// - CSV of `OptiTrack`'s Motive: the columns of kind `Marker`; rigid bodies and bones are left out.
/// - CSV of Vicon's Nexus: the section `Trajectories`; devices, joints and the like are left out.
/// - CSV of `OpenFace`: its landmarks in space (`X_0` …), under the names `landmark_0` …, in the camera's axes (y down, z
///   away); frames without success are missing. Landmarks in the picture alone (`x_0` …) are refused, for they have no
///   depth: run it with `-3Dfp`.
/// - Plain tables: a column `frame` and then three columns a marker (`chin_x_mm`, `chin_y_mm`, `chin_z_mm`); a face at
///   rest has the columns `marker`, `x_mm`, `y_mm`, `z_mm`. Empty cells are missing points.
///
/// `grimace inspect` says what a file holds and what is left out. The parameters work in this order: `subject` or
/// `strip_subject`, `only`, `without`, `rename`. While it loads, the node tells how many markers it keeps, and where
/// there is a `rename`, how many of them that does not mention and how many of its names the file lacks.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[allow(clippy::struct_excessive_bools, reason = "each is a switch of its own in the graph")]
pub struct LoadMarkers {
    /// The file, or a pattern such as `takes/*.c3d`, which gives one item for each file that it fits.
    path: String,
    /// Unit of the coordinates in the file, in place of the one that it states. C3D and Vicon files that state none are
    /// taken to be in millimetres, those of Motive in metres.
    unit: Option<Unit>,
    /// Frames a second, in place of what the file states. Tables often state nothing; then it must be given here.
    #[schemars(range(min = 0.001, max = 100_000.0))]
    rate_hz: Option<f64>,
    /// Whether a point at exactly 0, 0, 0 was not seen. Some systems write that in place of missing points.
    origin_is_missing: bool,
    /// Loads the markers of one subject of several, without its name: with `anna`, `anna:chin` becomes `chin`, and
    /// `ben:chin` is left out.
    subject: Option<String>,
    /// Cuts the subject's name off: `anna:chin` becomes `chin`.
    strip_subject: bool,
    /// Names of markers to keep, as patterns: `lip_*`, `brow_[LR]_1`, `{chin,jaw*}`. Keeps all where empty.
    only: Vec<String>,
    /// Names of markers to leave out, as patterns: `head_*`.
    without: Vec<String>,
    /// New names by old ones: `{"LLip1": "lip_1"}`, or by patterns, whose `*` may stand in the new name: `{"LLip*":
    /// "lip_*_L"}`. A name goes before a pattern, a long pattern before a short one. What the file lacks is an error.
    rename: BTreeMap<String, String>,
    /// Whether `only`, `without` and `rename` may name markers that the file lacks, so that takes of several days share
    /// them.
    allow_absent: bool,
    /// Whether markers that `rename` does not mention are left out.
    only_mapped: bool,
    /// Whether a marker that `rename` does not mention is an error, which lists them.
    all_mapped: bool,
}

graph_core::register!(LoadMarkers);

#[typetag::serde(name = "load_markers")]
impl Node for LoadMarkers {
    fn card(&self) -> Card {
        Card::new("load").reads("path").gives(&MARKERS)
    }

    fn compute(&self, context: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        let source = context.source()?;
        let markers = self.read(&source)?;
        let names = self.bare(&source.name, markers.names())?;
        let (indices, bare): (Vec<usize>, Vec<String>) = names.into_iter().unzip();
        let selection = Selection {
            what: "marker",
            only: &self.only,
            without: &self.without,
            rename: &self.rename,
            mapping: Mapping {
                allow_absent: self.allow_absent,
                only_mapped: self.only_mapped,
                all_mapped: self.all_mapped,
            },
        };
        let chosen = selection.apply(&source.name, &bare)?;
        let mut numbers = vec![("markers", chosen.kept.len() as f64)];
        if !self.rename.is_empty() {
            numbers.push(("not_in_rename", chosen.unmapped.len() as f64));
            numbers.push(("not_in_file", chosen.absent.len() as f64));
        }
        context.progress(1.0, &numbers);
        let (columns, names): (Vec<usize>, Vec<String>) =
            chosen.kept.into_iter().map(|(kept, name)| (indices[kept], name)).unzip();
        let positions = (0..markers.frames()).flat_map(|frame| {
            let all = markers.frame(frame);
            columns.iter().map(|column| all[*column])
        });
        let markers = Markers::new(markers.frame_axis(), names, positions.collect());
        Ok(Outputs::default().with(&MARKERS, markers.map_err(|error| NodeError::file(&source.name, error))?))
    }
}

impl LoadMarkers {
    /// All markers in the file, in metres.
    fn read(&self, source: &SourceFile) -> Result<Markers, NodeError> {
        let wrong = |problem: &dyn std::fmt::Display| NodeError::file(&source.name, problem);
        let mut file = markers::open(&source.name, &source.bytes).map_err(|error| wrong(&error))?;
        if file.names.is_empty() || file.frames == 0 {
            let (count, frames) = (file.names.len(), file.frames);
            return Err(wrong(&format!("holds {count} markers in {frames} frames; export the trajectories again")));
        }
        if self.origin_is_missing {
            for point in file.positions.iter_mut().filter(|point| **point == Vec3::ZERO) {
                *point = Vec3::NAN;
            }
        }
        if let Some(wanted) = self.unit.map(LengthUnit::from).filter(|wanted| *wanted != file.unit) {
            let stated = file.unit;
            for point in file.positions.iter_mut().filter(|point| !point.is_nan()) {
                // The same numbers, read in another unit.
                *point = Vec3::from_array(
                    point.to_array().map(|metres| wanted.to_metres(f64::from(stated.from_metres(metres)))),
                );
            }
        }
        file.rate_hz = self.rate_hz.or(file.rate_hz);
        file.into_markers(None).map_err(|error| wrong(&error))
    }

    /// The markers of the subject: where each stands in the file, and its name without that of the subject.
    fn bare(&self, file: &str, names: &[String]) -> Result<Vec<(usize, String)>, NodeError> {
        let own = |name: &str| match name.rsplit_once(':') {
            Some((_, own)) if self.strip_subject || self.subject.is_some() => own.to_owned(),
            _ => name.to_owned(),
        };
        let subject = |name: &str| name.rsplit_once(':').map(|(subject, _)| subject.to_owned());
        let is_wanted = |name: &String| self.subject.is_none() || subject(name) == self.subject;
        let kept: Vec<usize> = (0..names.len()).filter(|index| is_wanted(&names[*index])).collect();
        if let (Some(wanted), []) = (&self.subject, kept.as_slice()) {
            let subjects: BTreeSet<String> = names.iter().filter_map(|name| subject(name)).collect();
            let list: Vec<_> = subjects.iter().map(|subject| format!("`{subject}`")).collect();
            let there =
                if list.is_empty() { "names no subjects".to_owned() } else { format!("has {}", list.join(", ")) };
            let near = nearest_name(wanted, subjects.iter().map(String::as_str));
            let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            let problem = format!("no marker of {file} is of `{wanted}`; it {there}{near}");
            return Err(NodeError::parameter("subject", problem));
        }
        let mut seen: BTreeMap<String, usize> = BTreeMap::new();
        let mut bare = Vec::with_capacity(kept.len());
        for index in kept {
            let name = own(&names[index]);
            if let Some(other) = seen.insert(name.clone(), index) {
                let [other, this] = [other, index].map(|index| &names[index]);
                let problem =
                    format!("`{other}` and `{this}` of {file} would both be `{name}`; load one subject with `subject`");
                return Err(NodeError::parameter("strip_subject", problem));
            }
            bare.push((index, name));
        }
        Ok(bare)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, made, test_data};
    use face_io::{c3d, marker_csv};
    use serde_json::json;
    use wire::FrameAxis;

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
        let bytes = c3d::write(&take(), LengthUnit::Millimetre, c3d::Flavour::PLAIN).unwrap();
        same(&load(json!({}), "day1.C3D", &bytes).unwrap(), &take());
        same(&load(json!({}), "day1", &bytes).unwrap(), &take());
        let bytes = marker_csv::write(&take(), LengthUnit::Millimetre).unwrap();
        same(&load(json!({}), "day1.csv", &bytes).unwrap(), &take());
        same(&load(json!({}), "day1.c3d", &bytes).unwrap(), &take());
        let bytes = markers::trc::write(&take(), LengthUnit::Millimetre).unwrap();
        same(&load(json!({}), "day1.trc", &bytes).unwrap(), &take());
    }

    #[test]
    fn unit_and_rate_replace_those_of_the_file() {
        let bytes = c3d::write(&take(), LengthUnit::Millimetre, c3d::Flavour::PLAIN).unwrap();
        let markers = load(json!({"unit": "cm", "rate_hz": 120.0}), "a.c3d", &bytes).unwrap();
        assert!((markers.frame(0)[1].x - 2.5).abs() < 1e-6 && markers.frame(1)[1].is_nan());
        assert_eq!(markers.frame_axis(), FrameAxis { first: 101, count: 2, rate_hz: 120.0 });
    }

    #[test]
    fn names_are_stripped_chosen_and_renamed() {
        let bytes = c3d::write(&take(), LengthUnit::Millimetre, c3d::Flavour::PLAIN).unwrap();
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
        let bytes = c3d::write(&markers, LengthUnit::Metre, c3d::Flavour::PLAIN).unwrap();
        let error = load(json!({"strip_subject": true}), "a.c3d", &bytes).unwrap_err();
        assert!(error.contains("`anna:chin` and `ben:chin` of a.c3d would both be `chin`"), "{error}");
        let anna = load(json!({"subject": "anna"}), "a.c3d", &bytes).unwrap();
        assert_eq!(anna.names(), ["chin"]);
        let error = load(json!({"subject": "bem"}), "a.c3d", &bytes).unwrap_err();
        assert!(error.contains("it has `anna`, `ben`; did you mean `ben`?"), "{error}");
    }

    #[test]
    fn points_at_the_origin_may_be_missing() {
        let at_origin = take().with_positions(vec![Vec3::ZERO; 6]).unwrap();
        let bytes = c3d::write(&at_origin, LengthUnit::Metre, c3d::Flavour::PLAIN).unwrap();
        assert_eq!(load(json!({}), "a.c3d", &bytes).unwrap().missing(), 0);
        assert_eq!(load(json!({"origin_is_missing": true}), "a.c3d", &bytes).unwrap().missing(), 6);
    }

    #[test]
    fn one_map_serves_takes_that_lack_some_of_its_names() {
        let bytes = c3d::write(&take(), LengthUnit::Metre, c3d::Flavour::PLAIN).unwrap();
        let map = json!({"chin": "mental", "lip_*": "mouth_*", "nose": "nasal"});
        let with = |more: serde_json::Value| {
            let mut with = json!({"strip_subject": true, "rename": map});
            with.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
            load(with, "a.c3d", &bytes)
        };
        assert!(with(json!({})).unwrap_err().contains("is called `nose`"));
        assert_eq!(with(json!({"allow_absent": true})).unwrap().names(), ["mental", "mouth_1", "head_1"]);
        let mapped = with(json!({"allow_absent": true, "only_mapped": true})).unwrap();
        assert_eq!(mapped.names(), ["mental", "mouth_1"]);
        let error = with(json!({"allow_absent": true, "all_mapped": true})).unwrap_err();
        assert!(error.contains("1 markers: `head_1`"), "{error}");
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
        let error = load(json!({}), "a.fbx", b"Kaydara FBX").unwrap_err();
        assert!(error.starts_with("a.fbx: ") && error.contains("C3D, TRC, CSV of Motive"), "{error}");
        assert!(load(json!({}), "a.trc", b"").unwrap_err().starts_with("a.trc: TRC: the file is empty"));
        assert!(load(json!({}), "a.c3d", b"no").unwrap_err().starts_with("a.c3d: C3D"));
        let none = Markers::new(FrameAxis::new(0, 60.0), vec!["chin".into()], Vec::new()).unwrap();
        let bytes = c3d::write(&none, LengthUnit::Metre, c3d::Flavour::PLAIN).unwrap();
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
