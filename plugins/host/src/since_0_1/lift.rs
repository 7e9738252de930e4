//! What a plugin of interface 0.1 gave, as values of the engine: held against its schema and against what each type asks
//! for. Every NaN becomes the one quiet NaN.

use super::bindings::grimace::node::types as wit;
use crate::fault::RunError;
use crate::schema::{NodeSchema, PortSchema, kind_of};
use crate::values::{Blob, FrameTensor, Number, Numbers, Tensor, Text};
use face_math::data::{Curves, FeatureSet, Features, Image, Markers, Meshes, Part, RegionFeatures, Views};
use glam::{Vec2, Vec3};
use graph_core::node::{Outputs, PortValue};
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::{FrameAxis, Value};

/// Letters of a plugin's own words that a message repeats.
const SAID: usize = 2000;
/// Numbers that are searched for NaN at once.
const PIECE: usize = 256;

/// The fault that a plugin told.
pub fn fault(plugin: String, node: &NodeSchema, fault: wit::Fault) -> RunError {
    let cut = |text: String| text.chars().take(SAID).collect::<String>();
    let named = |wit::Complaint { name, problem }: wit::Complaint, known: bool| {
        let problem = format!("{} (says plugin `{plugin}`)", cut(problem));
        if known { Ok((name, problem)) } else { Err(format!("{}: {problem}", cut(name))) }
    };
    match fault {
        wit::Fault::Cancelled => RunError::Cancelled,
        wit::Fault::Failed(problem) => RunError::Failed { plugin, problem: cut(problem) },
        wit::Fault::Input(complaint) => {
            let known = node.inputs.iter().any(|port| port.name == complaint.name);
            match named(complaint, known) {
                Ok((name, problem)) => RunError::Input { name, problem },
                Err(problem) => RunError::Failed { plugin, problem },
            }
        }
        wit::Fault::Parameter(complaint) => {
            let known = node.parameters.iter().any(|parameter| parameter.name == complaint.name);
            match named(complaint, known) {
                Ok((name, problem)) => RunError::Parameter { name, problem },
                Err(problem) => RunError::Failed { plugin, problem },
            }
        }
    }
}

/// The outputs of `node`, each once and of its type.
pub fn outputs(node: &NodeSchema, given: Vec<wit::StandingResult>) -> Result<Outputs, String> {
    let mut by_port: BTreeMap<String, Vec<wit::ItemResult>> = BTreeMap::new();
    for standing in given {
        if !node.outputs.iter().any(|port| port.name == standing.port) {
            let known: Vec<&str> = node.outputs.iter().map(|port| port.name.as_str()).collect();
            let port: String = standing.port.chars().take(80).collect();
            return Err(format!("something on the output {port:?}, and its outputs are {}", known.join(", ")));
        }
        if by_port.insert(standing.port.clone(), standing.items).is_some() {
            return Err(format!("its output `{}` twice", standing.port));
        }
    }
    let mut outputs = Outputs::default();
    for port in &node.outputs {
        let items = by_port.remove(&port.name).ok_or_else(|| format!("nothing on its output `{}`", port.name))?;
        outputs = outputs.with_any(port.name.clone(), port_value(port, items)?);
    }
    Ok(outputs)
}

fn port_value(port: &PortSchema, items: Vec<wit::ItemResult>) -> Result<PortValue, String> {
    let wrong = |problem: String| format!("a wrong value on its output `{}`: {problem}", port.name);
    if port.many {
        let mut named: BTreeMap<String, Arc<dyn Value>> = BTreeMap::new();
        for item in items {
            let name = item.name;
            if !is_item_name(&name) {
                let shown: String = name.chars().take(80).collect();
                return Err(wrong(format!("an item is called {shown:?}; names are 1 to 200 letters without `/`")));
            }
            let value = value(port, item.value).map_err(|problem| wrong(format!("item `{name}`: {problem}")))?;
            if named.insert(name.clone(), value).is_some() {
                return Err(wrong(format!("two items are called `{name}`")));
            }
        }
        return Ok(PortValue::List(named));
    }
    let count = items.len();
    match (items.into_iter().next(), count) {
        (Some(item), 1) => value(port, item.value).map(PortValue::One).map_err(wrong),
        (_, count) => Err(wrong(format!("{count} values, where one belongs"))),
    }
}

fn is_item_name(name: &str) -> bool {
    (1..=200).contains(&name.chars().count()) && !name.chars().any(|letter| letter == '/' || letter.is_control())
}

fn value(port: &PortSchema, value: wit::ValueResult) -> Result<Arc<dyn Value>, String> {
    let wanted = port.type_name.as_str();
    let made: (&str, Result<Arc<dyn Value>, String>) = match value {
        wit::ValueResult::Number(number) => {
            let number = if number.is_nan() { f64::NAN } else { number };
            ("Number", Ok(Arc::new(Number(number))))
        }
        wit::ValueResult::Text(text) => ("Text", Ok(Arc::new(Text(text)))),
        wit::ValueResult::Tensor(tensor) if tensor.frames.is_some() => ("FrameTensor", frame_tensor(tensor)),
        wit::ValueResult::Tensor(tensor) => ("Tensor", still_tensor(tensor)),
        wit::ValueResult::Markers(markers) => ("Markers", of_markers(markers)),
        wit::ValueResult::Curves(curves) => ("Curves", of_curves(curves)),
        wit::ValueResult::Views(views) => ("Views", of_views(views)),
        wit::ValueResult::Features(features) => ("Features", of_features(features)),
        wit::ValueResult::Meshes(meshes) => ("Meshes", of_meshes(meshes)),
        wit::ValueResult::Image(image) => {
            let image = Image::new(image.width_px as usize, image.height_px as usize, image.rgb);
            ("Image", shared(image.map_err(|problem| problem.to_string())))
        }
        wit::ValueResult::Blob(blob) => return of_blob(wanted, blob),
    };
    match made {
        (name, value) if name == wanted => value,
        (name, _) => Err(format!("{name}, where {wanted} belongs")),
    }
}

fn shared<T: Value>(value: Result<T, String>) -> Result<Arc<dyn Value>, String> {
    value.map(|value| Arc::new(value) as Arc<dyn Value>)
}

fn axis(frames: wit::Frames) -> Result<FrameAxis, String> {
    let rate_hz = frames.rate_hz;
    if rate_hz.is_finite() && rate_hz > 0.0 {
        return Ok(FrameAxis { first: frames.first, count: frames.count as usize, rate_hz });
    }
    Err(format!("a rate of {rate_hz} Hz; it must be finite and more than 0"))
}

fn canonical(mut numbers: Vec<f32>) -> Vec<f32> {
    for piece in numbers.chunks_mut(PIECE) {
        // Mostly there is none, and looking is quicker than writing.
        if piece.iter().fold(false, |any, number| any | number.is_nan()) {
            piece.iter_mut().filter(|number| number.is_nan()).for_each(|number| *number = f32::NAN);
        }
    }
    numbers
}

fn canonical_wide(mut numbers: Vec<f64>) -> Vec<f64> {
    for piece in numbers.chunks_mut(PIECE) {
        if piece.iter().fold(false, |any, number| any | number.is_nan()) {
            piece.iter_mut().filter(|number| number.is_nan()).for_each(|number| *number = f64::NAN);
        }
    }
    numbers
}

fn numbers(numbers: wit::NumbersResult) -> Numbers {
    match numbers {
        wit::NumbersResult::F32s(numbers) => Numbers::F32(canonical(numbers)),
        wit::NumbersResult::F64s(numbers) => Numbers::F64(canonical_wide(numbers)),
        wit::NumbersResult::S32s(numbers) => Numbers::I32(numbers),
        wit::NumbersResult::U32s(numbers) => Numbers::U32(numbers),
        wit::NumbersResult::U8s(numbers) => Numbers::U8(numbers),
    }
}

fn still_tensor(tensor: wit::TensorResult) -> Result<Arc<dyn Value>, String> {
    shared(Tensor::new(tensor.shape, numbers(tensor.numbers)))
}

fn frame_tensor(tensor: wit::TensorResult) -> Result<Arc<dyn Value>, String> {
    let frames = tensor.frames.ok_or("no frames")?;
    let (first, rest) = tensor.shape.split_first().ok_or("a shape without the dimension of its frames")?;
    if *first != frames.count {
        return Err(format!("{first} rows for {} frames", frames.count));
    }
    shared(FrameTensor::new(axis(frames)?, rest.to_vec(), numbers(tensor.numbers)))
}

/// Points from their coordinates.
fn points(coordinates: &[f32]) -> Result<Vec<Vec3>, String> {
    let (points, rest) = coordinates.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(format!("{} coordinates, which are no whole points of three", coordinates.len()));
    }
    // A point that is missing is missing in all its coordinates.
    let point = |point: &[f32; 3]| {
        if point.iter().any(|number| number.is_nan()) { Vec3::NAN } else { Vec3::from_array(*point) }
    };
    Ok(points.iter().map(point).collect())
}

fn of_markers(markers: wit::MarkersResult) -> Result<Arc<dyn Value>, String> {
    let positions = points(&markers.positions_m)?;
    shared(Markers::new(axis(markers.frames)?, markers.names, positions).map_err(|problem| problem.to_string()))
}

fn of_curves(curves: wit::CurvesResult) -> Result<Arc<dyn Value>, String> {
    let values = canonical(curves.values);
    shared(Curves::new(axis(curves.frames)?, curves.channels, values).map_err(|problem| problem.to_string()))
}

fn of_views(views: wit::ViewsResult) -> Result<Arc<dyn Value>, String> {
    let (points, rest) = views.points_px.as_chunks::<2>();
    let wanted = views.cameras.len().checked_mul(views.markers.len());
    let wanted = wanted.and_then(|points| points.checked_mul(views.frames.count as usize));
    if !rest.is_empty() || wanted != Some(points.len()) {
        let (cameras, markers, frames) = (views.cameras.len(), views.markers.len(), views.frames.count);
        let count = views.points_px.len();
        return Err(format!("{count} coordinates for {cameras} cameras, {markers} markers and {frames} frames"));
    }
    let point = |point: &[f32; 2]| {
        if point.iter().any(|number| number.is_nan()) { Vec2::NAN } else { Vec2::from_array(*point) }
    };
    let points = points.iter().map(point).collect();
    let views = Views::new(axis(views.frames)?, views.cameras, views.markers, points);
    shared(views.map_err(|problem| problem.to_string()))
}

fn of_features(features: wit::FeaturesResult) -> Result<Arc<dyn Value>, String> {
    let set = |set: &wit::FeatureSet| match set {
        wit::FeatureSet::Distance => FeatureSet::Distance,
        wit::FeatureSet::Direction => FeatureSet::Direction,
        wit::FeatureSet::Delta => FeatureSet::Delta,
        wit::FeatureSet::Coordinates => FeatureSet::Coordinates,
    };
    let region = |region: wit::RegionFeaturesResult| RegionFeatures {
        region: region.region,
        markers: region.markers,
        sets: region.sets.iter().map(set).collect(),
        width: region.width as usize,
        values: canonical(region.values),
    };
    let regions = features.regions.into_iter().map(region).collect();
    shared(Features::new(axis(features.frames)?, regions).map_err(|problem| problem.to_string()))
}

fn of_meshes(meshes: wit::MeshesResult) -> Result<Arc<dyn Value>, String> {
    let mut parts = Vec::with_capacity(meshes.parts.len());
    for part in meshes.parts {
        let end = part.first_vertex.checked_add(part.vertices);
        let end = end
            .filter(|end| *end <= meshes.vertices && !part.triangles.iter().any(|vertex| *vertex >= meshes.vertices));
        let end = end.ok_or_else(|| {
            format!("part `{}` has vertices beyond the {} that there are", part.name, meshes.vertices)
        })?;
        let (triangles, odd) = part.triangles.as_chunks::<3>();
        let (uvs, odd_uv) = part.uvs.as_chunks::<2>();
        if !odd.is_empty() || !odd_uv.is_empty() {
            return Err(format!(
                "part `{}` has triangles of other than three vertices, or half a texture coordinate",
                part.name
            ));
        }
        parts.push(Part {
            name: part.name,
            vertices: part.first_vertex..end,
            triangles: triangles.to_vec(),
            uvs: uvs.to_vec(),
            colour: part.colour.into(),
        });
    }
    let positions = points(&meshes.positions_m)?;
    let meshes = Meshes::new(axis(meshes.frames)?, parts, meshes.vertices as usize, positions);
    shared(meshes.map_err(|problem| problem.to_string()))
}

fn of_blob(wanted: &str, blob: wit::BlobResult) -> Result<Arc<dyn Value>, String> {
    if blob.type_name != wanted {
        let name: String = blob.type_name.chars().take(80).collect();
        return Err(format!("bytes of the type {name:?}, where {wanted} belongs"));
    }
    if wanted == "Blob" {
        return Ok(Arc::new(Blob { version: blob.version, bytes: blob.bytes }));
    }
    let kind = kind_of(wanted).ok_or_else(|| format!("a type `{wanted}` that there is not"))?;
    if kind.version != blob.version {
        return Err(format!("{wanted} in version {} of its encoding; this program has {}", blob.version, kind.version));
    }
    (kind.decode)(&blob.bytes).map_err(|problem| format!("{wanted} that cannot be decoded: {problem}"))
}
