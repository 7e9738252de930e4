//! Nodes that turn results into files and pictures: where every graph ends.

mod frame_range;
mod parts;
mod render_errors;
mod render_faces;
mod save_animation;
mod save_curves;
mod save_images;
mod save_markers;
mod save_meshes;
mod save_plot;
mod save_scores;
pub mod scene;

pub use render_errors::RenderErrors;
pub use render_faces::RenderFaces;
pub use save_animation::SaveAnimation;
pub use save_curves::SaveCurves;
pub use save_images::SaveImages;
pub use save_markers::SaveMarkers;
pub use save_meshes::SaveMeshes;
pub use save_plot::SavePlot;
pub use save_scores::SaveScores;
