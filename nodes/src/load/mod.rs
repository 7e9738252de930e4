//! Nodes that load files, or make sample data: where every graph begins.

mod load_curves;
mod load_markers;
mod load_rig;
mod sample_actor;
mod selection;

pub use load_curves::LoadCurves;
pub use load_markers::LoadMarkers;
pub use load_rig::LoadRig;
pub use sample_actor::SampleActor;
