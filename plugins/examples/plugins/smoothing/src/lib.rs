//! Two filters for animation curves: one that follows fast moves and calms slow ones, and one that keeps peaks.

mod one_euro;
mod savitzky_golay;

pub use one_euro::OneEuro;
pub use savitzky_golay::{SavitzkyGolay, smooth};

grimace_plugin::export!(OneEuro, SavitzkyGolay);
