//! From a value to what can be drawn of it: curves, bodies in space, images, tables, or its summary.

use face_math::data::{Curves, Image, MarkerNoise, Markers, Meshes, Rig};
use glam::Vec3;

use nodes::values::{Anchors, Networks, Scores};
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::Value;

/// What can be drawn of a value.
#[derive(Debug, Clone)]
pub enum Picture {
    /// Numbers over frames, by channel.
    Curves {
        /// Number of the first frame, as the source counts.
        first: i64,
        /// Frames a second; zero where the steps are no frames.
        rate_hz: f64,
        /// Names and values of the channels.
        channels: Vec<(String, Vec<f32>)>,
    },
    /// Points or faces in space, over frames.
    Body(Body),
    /// An image.
    Image(Arc<Image>),
    /// Rows of text.
    Table(Table),
}

/// Points in space over frames, with the triangles between them.
#[derive(Debug, Clone)]
pub struct Body {
    /// Number of the first frame.
    pub first: i64,
    /// Frames a second.
    pub rate_hz: f64,
    /// Positions in metres, by frame; what is missing is no number.
    pub frames: Vec<Vec<Vec3>>,
    /// Triangles; none for points.
    pub triangles: Vec<[u32; 3]>,
    /// Names of the points; none for faces.
    pub names: Vec<String>,
}

/// Rows of text under a title.
#[derive(Debug, Clone)]
pub struct Table {
    /// The title.
    pub title: String,
    /// The rows: name, text, and a number from 0 to 1 for a bar.
    pub rows: Vec<(String, String, Option<f64>)>,
}

/// Most frames of a mesh that are kept for the preview.
const MOST_MESH_FRAMES: usize = 400;

/// Makes ready what stands on an output: one value, or a list by item.
pub fn picture(values: &BTreeMap<String, Arc<dyn Value>>) -> Picture {
    let mut each = values.iter();
    match (each.next(), each.next()) {
        (Some((_, only)), None) => of_value(only),
        _ => Picture::Table(Table {
            title: format!("{} items", values.len()),
            rows: values.iter().map(|(item, value)| (item.clone(), value.summary(), None)).collect(),
        }),
    }
}

fn of_value(value: &Arc<dyn Value>) -> Picture {
    if let Some(curves) = value.downcast_ref::<Curves>() {
        return of_curves(curves);
    }
    if let Some(markers) = value.downcast_ref::<Markers>() {
        let axis = markers.frame_axis();
        return Picture::Body(Body {
            first: axis.first,
            rate_hz: axis.rate_hz,
            frames: (0..axis.count).map(|frame| markers.frame(frame).to_vec()).collect(),
            triangles: Vec::new(),
            names: markers.names().to_vec(),
        });
    }
    if let Some(meshes) = value.downcast_ref::<Meshes>() {
        let axis = meshes.frame_axis();
        return Picture::Body(Body {
            first: axis.first,
            rate_hz: axis.rate_hz,
            frames: (0..axis.count.min(MOST_MESH_FRAMES)).map(|frame| meshes.frame(frame).to_vec()).collect(),
            triangles: meshes.parts().iter().flat_map(|part| part.triangles.iter().copied()).collect(),
            names: Vec::new(),
        });
    }
    if let Some(rig) = value.downcast_ref::<Rig>() {
        return Picture::Body(Body {
            first: 0,
            rate_hz: 0.0,
            frames: vec![rig.neutral.clone()],
            triangles: rig.parts.iter().flat_map(|part| part.triangles.iter().copied()).collect(),
            names: Vec::new(),
        });
    }
    if let Some(image) = Arc::clone(value).downcast_arc::<Image>() {
        return Picture::Image(image);
    }
    of_small(value)
}

fn of_curves(curves: &Curves) -> Picture {
    let axis = curves.frame_axis();
    let channels = curves.channels().iter().enumerate().map(|(channel, name)| {
        let values = (0..axis.count).map(|frame| curves.frame(frame)[channel]).collect();
        (name.clone(), values)
    });
    Picture::Curves { first: axis.first, rate_hz: axis.rate_hz, channels: channels.collect() }
}

fn of_small(value: &Arc<dyn Value>) -> Picture {
    if let Some(networks) = value.downcast_ref::<Networks>() {
        let losses = networks.regions.iter().map(|region| {
            let losses = region.training.losses.iter().map(|loss| loss.max(1e-12).log10() as f32).collect();
            (format!("{} (log10 loss)", region.region), losses)
        });
        return Picture::Curves { first: 1, rate_hz: 0.0, channels: losses.collect() };
    }
    if let Some(scores) = value.downcast_ref::<Scores>() {
        let most = scores.by_name.iter().map(|(_, score)| *score).fold(f64::MIN_POSITIVE, f64::max);
        let row = |(name, score): &(String, f64)| (name.clone(), format!("{score:.4}"), Some(score / most));
        let title = format!("{}: {:.4}", scores.what, scores.overall);
        return Picture::Table(Table { title, rows: scores.by_name.iter().map(row).collect() });
    }
    if let Some(noise) = value.downcast_ref::<MarkerNoise>() {
        let most = noise.markers().iter().map(|marker| marker.sigma_mm).fold(f64::MIN_POSITIVE, f64::max);
        let rows = noise
            .markers()
            .iter()
            .map(|one| (one.marker.clone(), format!("{:.3} mm", one.sigma_mm), Some(one.sigma_mm / most)));
        return Picture::Table(Table { title: "noise".to_owned(), rows: rows.collect() });
    }
    if let Some(anchors) = value.downcast_ref::<Anchors>() {
        let rows = anchors.frames().iter().map(|frame| (format!("frame {frame}"), String::new(), None));
        return Picture::Table(Table { title: value.summary(), rows: rows.collect() });
    }
    let rows = vec![
        ("type".to_owned(), value.kind().name.to_owned(), None),
        ("bytes".to_owned(), value.size().to_string(), None),
    ];
    Picture::Table(Table { title: value.summary(), rows })
}

impl Picture {
    /// How many frames there are to scrub through.
    pub fn frames(&self) -> usize {
        match self {
            Self::Curves { channels, .. } => channels.iter().map(|(_, values)| values.len()).max().unwrap_or(0),
            Self::Body(body) => body.frames.len(),
            Self::Image(_) | Self::Table(_) => 1,
        }
    }

    /// How many channels or rows there are to step through.
    pub fn rows(&self) -> usize {
        match self {
            Self::Curves { channels, .. } => channels.len(),
            Self::Body(body) => body.names.len(),
            Self::Table(table) => table.rows.len(),
            Self::Image(_) => 1,
        }
    }
}
