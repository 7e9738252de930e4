//! Made-up values of each type: usual ones, and those that a careless node trips over.

use crate::schema::{NodeSchema, PortSchema};
use crate::values::{Blob, FrameTensor, Number, Numbers, Tensor, Text};
use face_math::data::{Curves, FeatureSet, Features, Image, Markers, Meshes, Part, RegionFeatures, Views};
use glam::{Vec2, Vec3};
use graph_core::node::{Inputs, PortValue};
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::{FrameAxis, Value};

/// Frames of usual values: three blocks and a little.
pub const FRAMES: usize = 100;

/// What is special about the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Case {
    /// Nothing.
    Usual,
    /// There are no frames.
    NoFrames,
    /// There is one frame.
    OneFrame,
    /// There are no channels, markers or vertices.
    Nothing,
    /// Every number is NaN.
    Nan,
    /// Every number is infinite or as large as can be.
    Huge,
}

impl Case {
    /// All that are not usual.
    pub const HOSTILE: [Self; 5] = [Self::NoFrames, Self::OneFrame, Self::Nothing, Self::Nan, Self::Huge];

    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Usual => "made-up values",
            Self::NoFrames => "no frames",
            Self::OneFrame => "one frame",
            Self::Nothing => "no channels, markers or vertices",
            Self::Nan => "nothing but NaN",
            Self::Huge => "infinite numbers",
        }
    }

    fn frames(self) -> usize {
        match self {
            Self::NoFrames => 0,
            Self::OneFrame => 1,
            _ => FRAMES,
        }
    }

    fn count(self, usual: usize) -> usize {
        if self == Self::Nothing { 0 } else { usual }
    }

    /// The number at a place: a slow wave of its own for every column.
    fn number(self, frame: usize, column: usize) -> f32 {
        match self {
            Self::Nan => f32::NAN,
            Self::Huge => [f32::INFINITY, f32::NEG_INFINITY, f32::MAX][(frame + column) % 3],
            _ => 0.5 + 0.4 * (frame as f32 * 0.13 * (1.0 + column as f32 * 0.21)).sin(),
        }
    }

    fn numbers(self, frames: usize, columns: usize) -> Vec<f32> {
        (0..frames).flat_map(|t| (0..columns).map(move |column| self.number(t, column))).collect()
    }

    fn points(self, frames: usize, count: usize) -> Vec<Vec3> {
        let at = |t, point: usize| {
            let place = Vec3::new(point as f32, (point * point % 7) as f32, (point % 3) as f32) * 0.01;
            place + 0.002 * Vec3::new(self.number(t, point), self.number(t, point + 1), self.number(t, point + 2))
        };
        (0..frames).flat_map(|t| (0..count).map(move |point| at(t, point))).collect()
    }
}

/// Values on all inputs of `node`.
pub fn inputs(node: &NodeSchema, case: Case) -> Result<Inputs, String> {
    let mut inputs = Inputs::default();
    for port in &node.inputs {
        match value(port, case) {
            Ok(value) if port.many => {
                let items = BTreeMap::from([("first".to_owned(), Arc::clone(&value)), ("second".to_owned(), value)]);
                inputs.set(port.name.clone(), PortValue::List(items));
            }
            Ok(value) => inputs.set(port.name.clone(), PortValue::One(value)),
            Err(_) if port.optional => {}
            Err(problem) => return Err(problem),
        }
    }
    Ok(inputs)
}

fn value(port: &PortSchema, case: Case) -> Result<Arc<dyn Value>, String> {
    let frames = case.frames();
    let axis = FrameAxis { first: 1001, count: frames, rate_hz: 60.0 };
    let names = |what: &str, count: usize| (1..=case.count(count)).map(|at| format!("{what}{at}")).collect::<Vec<_>>();
    let made: Result<Arc<dyn Value>, String> = match port.type_name.as_str() {
        "Curves" => {
            let channels = names("channel", 5);
            let values = case.numbers(frames, channels.len());
            shared(Curves::new(axis, channels, values))
        }
        "Markers" => {
            let markers = names("marker", 8);
            let points = case.points(frames, markers.len());
            shared(Markers::new(axis, markers, points))
        }
        "Views" => {
            let (cameras, markers) = (names("camera", 2), names("marker", 8));
            let points = case.points(frames, cameras.len() * markers.len());
            let points = points.iter().map(|point| Vec2::new(point.x, point.y) * 1e4).collect();
            shared(Views::new(axis, cameras, markers, points))
        }
        "Features" => {
            let width = case.count(6);
            let values = case.numbers(frames, width);
            let sets = vec![FeatureSet::Distance];
            let region = RegionFeatures { region: "face".to_owned(), markers: names("marker", 4), sets, width, values };
            shared(Features::new(axis, vec![region]))
        }
        "Meshes" => {
            let vertices = case.count(4);
            let triangles = if vertices == 4 { vec![[0, 1, 2], [0, 2, 3]] } else { Vec::new() };
            let (uvs, colour) = (Vec::new(), [0.8, 0.6, 0.5]);
            let part = Part { name: "skin".to_owned(), vertices: 0..vertices as u32, triangles, uvs, colour };
            shared(Meshes::new(axis, vec![part], vertices, case.points(frames, vertices)))
        }
        "Image" => Ok(Arc::new(Image::filled(case.count(16), case.count(16), [120, 90, 80]))),
        "Number" => Ok(Arc::new(Number(f64::from(case.number(3, 1))))),
        "Text" => Ok(Arc::new(Text(if case == Case::Nothing { String::new() } else { "chin up".to_owned() }))),
        "Tensor" => {
            let rows = case.count(6);
            shared(Tensor::new(vec![rows as u32, 4], Numbers::F32(case.numbers(rows, 4))))
        }
        "FrameTensor" => {
            let columns = case.count(4);
            shared(FrameTensor::new(axis, vec![columns as u32], Numbers::F32(case.numbers(frames, columns))))
        }
        "Blob" => Ok(Arc::new(Blob { version: 1, bytes: vec![7; case.count(64)] })),
        other => Err(format!("values of the type {other} cannot be made up; try the plugin in a graph")),
    };
    made
}

fn shared<T: Value, E: std::fmt::Display>(made: Result<T, E>) -> Result<Arc<dyn Value>, String> {
    made.map(|value| Arc::new(value) as Arc<dyn Value>).map_err(|problem| problem.to_string())
}
