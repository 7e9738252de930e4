//! Nodes that make takes fit for solving: after loading, before anything is solved.

mod fill_gaps;
mod keep_frames;
mod learn_shape_space;
mod measure_jitter;
mod project_eye_markers;
mod smooth_curves;
mod smooth_markers;
mod stabilize_head;
mod triangulate_markers;

pub use fill_gaps::FillGaps;
pub use keep_frames::KeepFrames;
pub use learn_shape_space::LearnShapeSpace;
pub use measure_jitter::MeasureJitter;
pub use project_eye_markers::ProjectEyeMarkers;
pub use smooth_curves::SmoothCurves;
pub use smooth_markers::SmoothMarkers;
pub use stabilize_head::StabilizeHead;
pub use triangulate_markers::TriangulateMarkers;
