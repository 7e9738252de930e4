//! The facts of each kind of value.

use crate::curves::{CurveTable, Gap};
use crate::gltf::Outline;
use crate::markers::MarkerFile;
use crate::obj::Obj;
use crate::view_csv::ViewTable;
use crate::{LengthUnit, ReadError, fbx};
use face_math::data::{Cameras, Driver, Edits, Image, Regions, Rig};
use glam::Vec3;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::fmt;

/// A smallest, largest or mean value: one number, or one an axis (or colour).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Stats {
    /// Over all numbers.
    One(f64),
    /// x and y.
    Two([f64; 2]),
    /// x, y, z or red, green, blue.
    Three([f64; 3]),
}

/// What a file holds. What does not apply is left out of the JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// `markers`, `curves`, `rig`, `mesh`, `image`, `landmarks`, `views`, `cameras`, `edits` or `regions`.
    pub kind: &'static str,
    /// The format and its flavour.
    pub format: String,
    /// Number of frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<usize>,
    /// Number of the first frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_frame: Option<i64>,
    /// Frames a second, where the file says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Names of markers, channels, regions ….
    pub names: Vec<String>,
    /// Missing values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missing: Option<usize>,
    /// Smallest values: metres for positions, weights for curves, 0 to 255 for pictures, pixels for landmarks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<Stats>,
    /// Largest values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<Stats>,
    /// Means.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean: Option<Stats>,
    /// Unit of the file's own numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// What else there is to know of this kind.
    #[serde(flatten)]
    pub more: Map<String, Value>,
}

impl Inspection {
    pub(super) fn new(kind: &'static str, format: impl Into<String>) -> Self {
        Self {
            kind,
            format: format.into(),
            frames: None,
            first_frame: None,
            rate_hz: None,
            names: Vec::new(),
            missing: None,
            min: None,
            max: None,
            mean: None,
            unit: None,
            more: Map::new(),
        }
    }

    fn more(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.more.insert(name.to_owned(), value.into());
        self
    }

    pub(super) fn range<const N: usize>(mut self, rows: impl Iterator<Item = [f64; N]>) -> Self {
        let (mut low, mut high, mut sum, mut count) = ([f64::INFINITY; N], [f64::NEG_INFINITY; N], [0.0; N], 0_usize);
        for row in rows {
            count += 1;
            for axis in 0..N {
                low[axis] = low[axis].min(row[axis]);
                high[axis] = high[axis].max(row[axis]);
                sum[axis] += row[axis];
            }
        }
        if count > 0 {
            let stats = |numbers: [f64; N]| match numbers.as_slice() {
                [x, y] => Stats::Two([*x, *y]),
                [x, y, z] => Stats::Three([*x, *y, *z]),
                numbers => Stats::One(numbers.first().copied().unwrap_or_default()),
            };
            (self.min, self.max) = (Some(stats(low)), Some(stats(high)));
            self.mean = Some(stats(sum.map(|sum| sum / count as f64)));
        }
        self
    }

    fn positions(mut self, positions: &[Vec3]) -> Self {
        self.missing = Some(positions.iter().filter(|point| point.is_nan()).count());
        self.range(positions.iter().filter(|point| !point.is_nan()).map(|point| point.as_dvec3().to_array()))
    }
}

pub(super) fn markers(file: &MarkerFile) -> Inspection {
    let mut facts = Inspection::new("markers", file.format.to_string()).positions(&file.positions);
    facts.names.clone_from(&file.names);
    (facts.frames, facts.first_frame, facts.rate_hz) = (Some(file.frames), Some(file.first_frame), file.rate_hz);
    let assumed = if file.unit_assumed { " (assumed, the file states none)" } else { "" };
    facts.unit = Some(format!("{}{assumed}", file.unit));
    let points = file.positions.len();
    let share = |part: usize| part as f64 / points.max(1) as f64;
    let missing = facts.missing.unwrap_or_default();
    let extent = match (facts.min, facts.max) {
        (Some(Stats::Three(low)), Some(Stats::Three(high))) => Some([0, 1, 2].map(|axis| high[axis] - low[axis])),
        _ => None,
    };
    let at_origin = file.positions.iter().filter(|point| **point == Vec3::ZERO).count();
    let never: Vec<&str> = (0..file.names.len())
        .filter(|column| file.positions.iter().skip(*column).step_by(file.names.len()).all(|point| point.is_nan()))
        .map(|column| file.names[column].as_str())
        .collect();
    let mut facts = facts.more("markers", file.names.len()).more("missing_share", share(missing));
    if let Some(extent) = extent {
        facts = facts.more("extent_m", json!(extent));
    }
    if at_origin > 0 {
        facts = facts.more("points_at_origin", at_origin);
    }
    facts.more("never_seen", json!(never)).more("renamed", file.renamed.clone()).more("left_out", file.left_out.clone())
}

pub(super) fn views(table: &ViewTable) -> Inspection {
    let seen = table.points_px.iter().filter(|point| !point.is_nan());
    let points = seen.map(|point| [f64::from(point.x), f64::from(point.y)]);
    let mut facts = Inspection::new("views", "CSV, 2D markers of cameras").range(points);
    facts.missing = Some(table.points_px.iter().filter(|point| point.is_nan()).count());
    facts.names.clone_from(&table.markers);
    (facts.frames, facts.first_frame, facts.rate_hz) = (Some(table.frames), Some(table.first_frame), table.rate_hz);
    facts.unit = Some("px".to_owned());
    facts.more("cameras", table.cameras.clone())
}

pub(super) fn cameras(cameras: &Cameras) -> Inspection {
    let mut facts = Inspection::new("cameras", "JSON, calibrated cameras");
    facts.names = cameras.names();
    let eyes: Map<String, Value> =
        cameras.cameras().iter().map(|camera| (camera.name.clone(), json!(camera.eye_m().to_array()))).collect();
    facts.more("positions_m", eyes)
}

pub(super) fn curves(table: &CurveTable) -> Inspection {
    let format = if table.live_link.is_some() { "CSV, Live Link Face" } else { "CSV, curves" };
    let mut facts = Inspection::new("curves", format).range(table.values.iter().map(|value| [f64::from(*value)]));
    facts.names.clone_from(&table.channels);
    (facts.frames, facts.first_frame, facts.rate_hz) = (Some(table.frames), Some(table.first_frame), table.rate_hz);
    facts.missing = Some(0);
    match &table.live_link {
        None => facts,
        Some(live_link) => facts
            .more("first_timecode", live_link.first_timecode.clone())
            .more("rotations", live_link.pose_names.clone())
            .more("unmapped", live_link.unmapped.clone())
            .more("filled_frames", live_link.filled_frames)
            .more("repeated_rows", live_link.repeated_rows)
            .more("gaps", gaps(&live_link.gaps)),
    }
}

fn gaps(gaps: &[Gap]) -> Value {
    let one = |gap: &Gap| format!("{} frames before line {}", gap.frames, gap.line);
    gaps.iter().map(one).collect()
}

pub(super) fn head(outline: &Outline) -> Inspection {
    let format = if outline.binary { "GLB" } else { "glTF" };
    let facts = shaped(&outline.rig, format.to_owned());
    if outline.animations.is_empty() {
        return facts;
    }
    let mut facts = facts.more("animations", outline.animations.clone());
    let Some(motion) = &outline.motion else { return facts };
    let axis = motion.curves.frame_axis();
    (facts.frames, facts.first_frame, facts.rate_hz) = (Some(axis.count), Some(axis.first), Some(axis.rate_hz));
    let facts = facts.more("animated", motion.name.clone()).more("moving_nodes", motion.moving_nodes.clone());
    facts.more("free_correctives", motion.free_correctives.clone())
}

pub(super) fn fbx(outline: &fbx::Outline) -> Inspection {
    shaped(&outline.rig, outline.format.clone())
}

/// An OBJ file states no unit: its numbers are told as they are.
pub(super) fn obj(file: &Obj, name: &str) -> Result<Inspection, ReadError> {
    let mut facts = shaped(&file.head(name, LengthUnit::Metre)?, "OBJ".to_owned());
    facts.unit = Some("not stated; positions are as in the file".to_owned());
    Ok(facts.more("vertices", file.vertices()).more("faces", file.faces()))
}

/// A head, with or without shapes.
fn shaped(rig: &Rig, format: String) -> Inspection {
    let kind = if rig.shapes.is_empty() { "mesh" } else { "rig" };
    let parts: Vec<_> = rig.parts.iter().map(|part| part.name.clone()).collect();
    let triangles: usize = rig.parts.iter().map(|part| part.triangles.len()).sum();
    let count = |of: fn(&Driver) -> bool| rig.shapes.iter().filter(|shape| of(&shape.driver)).count();
    let mut facts = Inspection::new(kind, format).positions(&rig.neutral);
    facts.unit = Some("m".to_owned());
    facts.names = if rig.shapes.is_empty() { parts.clone() } else { rig.channels.clone() };
    let facts = facts.more("parts", parts).more("vertices", rig.neutral.len()).more("triangles", triangles);
    if rig.shapes.is_empty() {
        return facts;
    }
    let facts = facts
        .more("channels", rig.channels.len())
        .more("shapes", rig.shapes.len())
        .more("combinations", count(|driver| matches!(driver, Driver::Combination(_))))
        .more("in_betweens", count(|driver| matches!(driver, Driver::InBetween { .. })))
        .more("jaw_skin", !rig.skin.is_empty());
    match rig.jaw_pivot_m {
        None => facts,
        Some(pivot) => facts.more("jaw_pivot_m", json!(pivot.to_array())),
    }
}

pub(super) fn picture(image: &Image) -> Inspection {
    let mut facts = Inspection::new("image", "PNG")
        .range(image.pixels().chunks_exact(3).map(|pixel| [0, 1, 2].map(|channel| f64::from(pixel[channel]))));
    facts.names = ["red", "green", "blue"].map(str::to_owned).to_vec();
    facts.more("width_px", image.width_px()).more("height_px", image.height_px())
}

pub(super) fn edits(edits: &Edits) -> Inspection {
    let mut facts = Inspection::new("edits", "edits");
    facts.names = edits.takes.keys().cloned().collect();
    let sizes: Map<String, Value> = edits
        .takes
        .iter()
        .map(|(name, take)| {
            let keys: usize = take.keys.values().map(Vec::len).sum();
            (name.clone(), json!({ "keys": keys, "channels": take.keys.keys().collect::<Vec<_>>(), "anchors": take.anchors.len() }))
        })
        .collect();
    facts.more("takes", sizes)
}

pub(super) fn regions(regions: &Regions) -> Inspection {
    let mut facts = Inspection::new("regions", "regions");
    facts.names = regions.regions.iter().map(|region| region.name.clone()).collect();
    let sizes: Map<String, Value> = regions
        .regions
        .iter()
        .map(|region| {
            let size = json!({ "markers": region.markers.len(), "channels": region.channels.len() });
            (region.name.clone(), size)
        })
        .collect();
    facts.more("regions", sizes)
}

impl fmt::Display for Stats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::One(number) => write!(f, "{number:.6}"),
            Self::Two([x, y]) => write!(f, "{x:.6}, {y:.6}"),
            Self::Three([x, y, z]) => write!(f, "{x:.6}, {y:.6}, {z:.6}"),
        }
    }
}

impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.kind, self.format)?;
        if let Some(frames) = self.frames {
            write!(f, "\n  frames   {frames}")?;
            if let Some(first) = self.first_frame {
                write!(f, " from {first}")?;
            }
            match self.rate_hz {
                Some(rate) => write!(f, " at {rate} Hz")?,
                None => write!(f, ", rate not stated")?,
            }
        }
        if let Some(unit) = &self.unit {
            write!(f, "\n  unit     {unit}")?;
        }
        if let Some(missing) = self.missing {
            write!(f, "\n  missing  {missing}")?;
        }
        for (name, stats) in [("min", self.min), ("max", self.max), ("mean", self.mean)] {
            if let Some(stats) = stats {
                write!(f, "\n  {name:<8} {stats}")?;
            }
        }
        for (name, value) in &self.more {
            match value {
                Value::Array(items) if items.is_empty() => {}
                Value::Array(items) => {
                    let items: Vec<_> = items.iter().map(plain).collect();
                    write!(f, "\n  {name}  {}", items.join(", "))?;
                }
                value => write!(f, "\n  {name}  {}", plain(value))?,
            }
        }
        write!(f, "\n  {} names: {}", self.names.len(), self.names.join(", "))
    }
}

fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
