//! Values that flow between nodes and belong to no other crate: trained networks, anchor poses, scores.

mod anchors;
mod networks;
mod scores;

pub use anchors::Anchors;
pub use networks::{Networks, RegionNetwork, TrainingRecord};
pub use scores::Scores;
