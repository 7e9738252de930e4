//! Values of the engine on their way into a plugin of interface 0.1: numbers are lent, not copied, except where they hold
//! NaN of other bits than the one quiet NaN, which no plugin is to see.

use super::bindings::grimace::node::types as wit;
use crate::schema::{NodeSchema, Setting};
use crate::values::{Blob, FrameTensor, Number, Numbers, Tensor, Text};
use face_math::data::{Curves, FeatureSet, Features, Image, Markers, Meshes, Part, Views};
use graph_core::node::{Inputs, PortValue};
use std::borrow::Cow;
use std::collections::BTreeMap;
use wire::{FrameAxis, Value};

/// Everything that one call is given.
pub struct Given<'a> {
    node: &'a str,
    settings: Vec<(&'a str, &'a Setting)>,
    ports: Vec<(&'a str, Vec<(&'a str, Staged<'a>)>)>,
}

/// One value with what its parts need to be lent.
enum Staged<'a> {
    Plain(wit::ValueParam<'a>),
    Tensor { shape: Vec<u32>, numbers: Lent<'a>, frames: Option<wit::Frames> },
    Markers { frames: wit::Frames, names: Vec<&'a str>, positions: Cow<'a, [f32]> },
    Curves { frames: wit::Frames, channels: Vec<&'a str>, values: Cow<'a, [f32]> },
    Views { frames: wit::Frames, cameras: Vec<&'a str>, markers: Vec<&'a str>, points: Cow<'a, [f32]> },
    Features { frames: wit::Frames, regions: Vec<Region<'a>> },
    Meshes { frames: wit::Frames, parts: &'a [Part], vertices: u32, positions: Cow<'a, [f32]> },
    Blob { name: &'static str, version: u32, bytes: Cow<'a, [u8]> },
}

enum Lent<'a> {
    F32(Cow<'a, [f32]>),
    F64(Cow<'a, [f64]>),
    Other(wit::NumbersParam<'a>),
}

struct Region<'a> {
    name: &'a str,
    markers: Vec<&'a str>,
    sets: Vec<wit::FeatureSet>,
    width: u32,
    values: Cow<'a, [f32]>,
}

/// The lists within one value.
enum Lists<'a> {
    None,
    Regions(Vec<wit::RegionFeaturesParam<'a>>),
    Parts(Vec<wit::PartParam<'a>>),
}

fn canonical(numbers: &[f32]) -> Cow<'_, [f32]> {
    let odd = |number: &f32| number.is_nan() && number.to_bits() != f32::NAN.to_bits();
    // In pieces, so that the search can be done on several numbers at once.
    if numbers.chunks(256).all(|piece| piece.iter().fold(true, |fine, number| fine & !odd(number))) {
        return Cow::Borrowed(numbers);
    }
    Cow::Owned(numbers.iter().map(|number| if number.is_nan() { f32::NAN } else { *number }).collect())
}

fn canonical_wide(numbers: &[f64]) -> Cow<'_, [f64]> {
    let odd = |number: &f64| number.is_nan() && number.to_bits() != f64::NAN.to_bits();
    if numbers.chunks(256).all(|piece| piece.iter().fold(true, |fine, number| fine & !odd(number))) {
        return Cow::Borrowed(numbers);
    }
    Cow::Owned(numbers.iter().map(|number| if number.is_nan() { f64::NAN } else { *number }).collect())
}

fn frames(axis: FrameAxis) -> Result<wit::Frames, String> {
    let count =
        u32::try_from(axis.count).map_err(|_| format!("{} frames are more than a plugin can count", axis.count))?;
    Ok(wit::Frames { first: axis.first, rate_hz: axis.rate_hz, count })
}

fn texts(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

fn lent(numbers: &Numbers) -> Lent<'_> {
    match numbers {
        Numbers::F32(numbers) => Lent::F32(canonical(numbers)),
        Numbers::F64(numbers) => Lent::F64(canonical_wide(numbers)),
        Numbers::I32(numbers) => Lent::Other(wit::NumbersParam::S32s(numbers)),
        Numbers::U32(numbers) => Lent::Other(wit::NumbersParam::U32s(numbers)),
        Numbers::U8(numbers) => Lent::Other(wit::NumbersParam::U8s(numbers)),
    }
}

fn stage(value: &dyn Value) -> Result<Staged<'_>, String> {
    if let Some(curves) = value.downcast_ref::<Curves>() {
        let (channels, values) = (texts(curves.channels()), canonical(curves.values()));
        return Ok(Staged::Curves { frames: frames(curves.frame_axis())?, channels, values });
    }
    if let Some(markers) = value.downcast_ref::<Markers>() {
        let (names, positions) = (texts(markers.names()), canonical(bytemuck::cast_slice(markers.positions())));
        return Ok(Staged::Markers { frames: frames(markers.frame_axis())?, names, positions });
    }
    if let Some(meshes) = value.downcast_ref::<Meshes>() {
        let positions = canonical(bytemuck::cast_slice(meshes.positions()));
        let (frames, parts) = (frames(meshes.frame_axis())?, meshes.parts());
        return Ok(Staged::Meshes { frames, parts, vertices: meshes.vertices() as u32, positions });
    }
    if let Some(views) = value.downcast_ref::<Views>() {
        let (cameras, markers) = (texts(views.cameras()), texts(views.markers()));
        let points = canonical(bytemuck::cast_slice(views.points_px()));
        return Ok(Staged::Views { frames: frames(views.frame_axis())?, cameras, markers, points });
    }
    if let Some(features) = value.downcast_ref::<Features>() {
        let regions = features.regions().iter().map(|region| Region {
            name: &region.region,
            markers: texts(&region.markers),
            sets: region.sets.iter().copied().map(set).collect(),
            width: region.width as u32,
            values: canonical(&region.values),
        });
        return Ok(Staged::Features { frames: frames(features.frame_axis())?, regions: regions.collect() });
    }
    if let Some(tensor) = value.downcast_ref::<FrameTensor>() {
        let axis = frames(tensor.frame_axis())?;
        let shape = std::iter::once(axis.count).chain(tensor.shape().iter().copied()).collect();
        return Ok(Staged::Tensor { shape, numbers: lent(tensor.numbers()), frames: Some(axis) });
    }
    if let Some(tensor) = value.downcast_ref::<Tensor>() {
        return Ok(Staged::Tensor { shape: tensor.shape().to_vec(), numbers: lent(tensor.numbers()), frames: None });
    }
    if let Some(image) = value.downcast_ref::<Image>() {
        let (width_px, height_px) = (image.width_px() as u32, image.height_px() as u32);
        return Ok(Staged::Plain(wit::ValueParam::Image(wit::ImageParam { width_px, height_px, rgb: image.pixels() })));
    }
    if let Some(Number(number)) = value.downcast_ref() {
        let number = if number.is_nan() { f64::NAN } else { *number };
        return Ok(Staged::Plain(wit::ValueParam::Number(number)));
    }
    if let Some(Text(text)) = value.downcast_ref() {
        return Ok(Staged::Plain(wit::ValueParam::Text(text)));
    }
    if let Some(Blob { version, bytes }) = value.downcast_ref() {
        return Ok(Staged::Blob { name: "Blob", version: *version, bytes: Cow::Borrowed(bytes) });
    }
    let kind = value.kind();
    Ok(Staged::Blob { name: kind.name, version: kind.version, bytes: Cow::Owned(value.encoded()) })
}

fn set(set: FeatureSet) -> wit::FeatureSet {
    match set {
        FeatureSet::Distance => wit::FeatureSet::Distance,
        FeatureSet::Direction => wit::FeatureSet::Direction,
        FeatureSet::Delta => wit::FeatureSet::Delta,
        FeatureSet::Coordinates => wit::FeatureSet::Coordinates,
    }
}

fn part(part: &Part) -> wit::PartParam<'_> {
    wit::PartParam {
        name: &part.name,
        first_vertex: part.vertices.start,
        vertices: part.vertices.len() as u32,
        triangles: bytemuck::cast_slice(&part.triangles),
        uvs: bytemuck::cast_slice(&part.uvs),
        colour: part.colour.into(),
    }
}

fn region<'a>(region: &'a Region<'_>) -> wit::RegionFeaturesParam<'a> {
    let Region { name, markers, sets, width, values } = region;
    wit::RegionFeaturesParam { region: name, markers, sets, width: *width, values }
}

impl Staged<'_> {
    fn lists(&self) -> Lists<'_> {
        match self {
            Self::Features { regions, .. } => Lists::Regions(regions.iter().map(region).collect()),
            Self::Meshes { parts, .. } => Lists::Parts(parts.iter().map(part).collect()),
            _ => Lists::None,
        }
    }

    fn lend<'a>(&'a self, lists: &'a Lists<'a>) -> wit::ValueParam<'a> {
        match (self, lists) {
            (Self::Plain(value), _) => value.clone(),
            (Self::Tensor { shape, numbers, frames }, _) => {
                let numbers = match numbers {
                    Lent::F32(numbers) => wit::NumbersParam::F32s(numbers),
                    Lent::F64(numbers) => wit::NumbersParam::F64s(numbers),
                    Lent::Other(numbers) => numbers.clone(),
                };
                wit::ValueParam::Tensor(wit::TensorParam { shape, numbers, frames: *frames })
            }
            (Self::Markers { frames, names, positions }, _) => {
                wit::ValueParam::Markers(wit::MarkersParam { frames: *frames, names, positions_m: positions })
            }
            (Self::Curves { frames, channels, values }, _) => {
                wit::ValueParam::Curves(wit::CurvesParam { frames: *frames, channels, values })
            }
            (Self::Views { frames, cameras, markers, points }, _) => {
                wit::ValueParam::Views(wit::ViewsParam { frames: *frames, cameras, markers, points_px: points })
            }
            (Self::Features { frames, .. }, Lists::Regions(regions)) => {
                wit::ValueParam::Features(wit::FeaturesParam { frames: *frames, regions })
            }
            (Self::Features { frames, .. }, _) => {
                wit::ValueParam::Features(wit::FeaturesParam { frames: *frames, regions: &[] })
            }
            (Self::Meshes { frames, vertices, positions, .. }, lists) => wit::ValueParam::Meshes(wit::MeshesParam {
                frames: *frames,
                parts: if let Lists::Parts(parts) = lists { parts } else { &[] },
                vertices: *vertices,
                positions_m: positions,
            }),
            (Self::Blob { name, version, bytes }, _) => {
                wit::ValueParam::Blob(wit::BlobParam { type_name: name, version: *version, bytes })
            }
        }
    }
}

impl<'a> Given<'a> {
    /// Takes what stands on the inputs of `node`, in the order of its schema.
    pub fn stage(
        node: &'a NodeSchema,
        settings: &'a BTreeMap<String, Setting>,
        inputs: &'a Inputs,
    ) -> Result<Self, String> {
        let mut ports = Vec::with_capacity(node.inputs.len());
        for port in &node.inputs {
            let Some((_, value)) = inputs.ports().find(|(name, _)| *name == port.name) else { continue };
            let items = match value {
                PortValue::One(value) => vec![("", stage(value.as_ref())?)],
                PortValue::List(items) => {
                    let staged = items.iter().map(|(name, value)| Ok((name.as_str(), stage(value.as_ref())?)));
                    staged.collect::<Result<Vec<_>, String>>()?
                }
            };
            ports.push((port.name.as_str(), items));
        }
        let settings = settings.iter().map(|(name, setting)| (name.as_str(), setting)).collect();
        Ok(Self { node: &node.name, settings, ports })
    }

    /// The call, for as long as `work` takes.
    pub fn with<R>(&self, work: impl FnOnce(wit::Call<'_>) -> R) -> R {
        let parameters: Vec<wit::Parameter<'_>> =
            self.settings.iter().map(|(name, setting)| wit::Parameter { name, value: lend(setting) }).collect();
        let staged = || self.ports.iter().map(|(_, items)| items);
        let lists: Vec<Vec<Lists<'_>>> =
            staged().map(|items| items.iter().map(|(_, value)| value.lists()).collect()).collect();
        let items: Vec<Vec<wit::ItemParam<'_>>> = staged()
            .zip(&lists)
            .map(|(items, lists)| {
                let both = items.iter().zip(lists);
                both.map(|((name, value), lists)| wit::ItemParam { name, value: value.lend(lists) }).collect()
            })
            .collect();
        let inputs: Vec<wit::StandingParam<'_>> =
            self.ports.iter().zip(&items).map(|((port, _), items)| wit::StandingParam { port, items }).collect();
        work(wit::Call { node: self.node, parameters: &parameters, inputs: &inputs })
    }
}

fn lend(setting: &Setting) -> wit::SettingParam<'_> {
    match setting {
        Setting::Flag(flag) => wit::SettingParam::Flag(*flag),
        Setting::Integer(number) => wit::SettingParam::Integer(*number),
        Setting::Number(number) => wit::SettingParam::Number(*number),
        Setting::Text(text) => wit::SettingParam::Text(text),
        Setting::Numbers(numbers) => wit::SettingParam::Numbers(numbers),
    }
}
