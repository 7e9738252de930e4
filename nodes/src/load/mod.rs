//! Nodes that load files, or make sample data: where every graph begins.

mod load_cameras;
mod load_curves;
mod load_markers;
mod load_regions;
mod load_rig;
mod load_views;
mod sample_actor;
mod selection;

pub use load_cameras::LoadCameras;
pub use load_curves::LoadCurves;
pub use load_markers::LoadMarkers;
pub use load_regions::LoadRegions;
pub use load_rig::LoadRig;
pub use load_views::LoadViews;
pub use sample_actor::SampleActor;

/// The ending of a file's name, in small letters, without the dot.
fn extension(name: &str) -> String {
    name.rsplit_once('.').map_or(String::new(), |(_, last)| last.to_lowercase())
}
