//! Nodes that solve markers for channel weights (FDLS): training data, features, networks, alignment, fine-tuning, and how
//! far off it all is. Between the rig and the saving of curves.

mod add_jitter;
mod align_anchors;
mod curve_error;
mod edit_curves;
mod find_anchor;
mod finetune_curves;
mod frames;
mod graph_features;
mod marker_error;
mod marker_scores;
mod match_markers;
mod measure_curves;
mod measure_distance;
mod pick_edits;
mod select_salient;
mod set_anchors;
mod solve_jaw;
mod solve_regions;
mod solving;
mod train_regions;
mod training;

pub use add_jitter::AddJitter;
pub use align_anchors::AlignAnchors;
pub use curve_error::CurveError;
pub use edit_curves::EditCurves;
pub use find_anchor::FindAnchor;
pub use finetune_curves::FinetuneCurves;
pub use graph_features::GraphFeatures;
pub use marker_error::MarkerErrors;
pub use marker_scores::MarkerScores;
pub use match_markers::MatchMarkers;
pub use measure_curves::MeasureCurves;
pub use measure_distance::MeasureDistance;
pub use pick_edits::PickEdits;
pub use select_salient::SelectSalient;
pub use set_anchors::SetAnchors;
pub use solve_jaw::SolveJaw;
pub use solve_regions::SolveRegions;
pub use train_regions::TrainRegions;
