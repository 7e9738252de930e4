//! Values that flow between nodes and belong to no other crate: trained networks, anchor poses, scores, manifolds of strains.

mod anchors;
mod networks;
mod scores;
mod strain_autoencoder;

pub use anchors::Anchors;
pub use networks::{Networks, RegionNetwork, TrainingRecord};
pub use scores::Scores;
pub use strain_autoencoder::StrainAutoencoder;
