//! Nodes that load files, or make sample data: where every graph begins.

mod load_cameras;
mod load_curves;
mod load_edits;
mod load_markers;
mod load_meshes;
mod load_regions;
mod load_rig;
mod load_rig_landmarks;
mod load_views;
mod sample_actor;

pub use load_cameras::LoadCameras;
pub use load_curves::LoadCurves;
pub use load_edits::LoadEdits;
pub use load_markers::LoadMarkers;
pub use load_meshes::LoadMeshes;
pub use load_regions::LoadRegions;
pub use load_rig::LoadRig;
pub use load_rig_landmarks::LoadRigLandmarks;
pub use load_views::LoadViews;
pub use sample_actor::SampleActor;

use face_math::data::{Attachment, Rig, SurfacePoint};
use graph_core::node::Context;
use std::path::Path;

/// The ending of a file's name, in small letters, without the dot.
fn extension(name: &str) -> String {
    name.rsplit_once('.').map_or(String::new(), |(_, last)| last.to_lowercase())
}

/// Files beside the source file, for readers of formats that lie in several files.
fn beside<'a>(context: &'a Context<'_>) -> impl FnMut(&str) -> std::io::Result<Vec<u8>> + 'a {
    |path| {
        if Path::new(path).has_root() {
            return Err(std::io::Error::other("only files beside the one that names them are read, by relative paths"));
        }
        context.sibling(path).map(|bytes| bytes.to_vec()).map_err(std::io::Error::other)
    }
}

/// Landmarks at vertices of a rig, as points of its surface; each in the first triangle that has its vertex.
fn landmarks_on(rig: &Rig, vertices: &[u32]) -> Attachment {
    let triangles = || rig.parts.iter().flat_map(|part| &part.triangles);
    let point = |(number, vertex): (usize, &u32)| {
        let triangle = triangles().find(|triangle| triangle.contains(vertex)).copied().unwrap_or([*vertex; 3]);
        let mut weights = [0.0; 3];
        weights[triangle.iter().position(|own| own == vertex).unwrap_or_default()] = 1.0;
        SurfacePoint { name: format!("landmark_{number:02}"), vertices: triangle, weights, distance_m: 0.0 }
    };
    Attachment { points: vertices.iter().enumerate().map(point).collect() }
}
