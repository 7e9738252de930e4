//! From markers to channel weights and back: what the solving nodes compute.
//!
//! - [`graph_features`]: what the region networks see (section 4.3 of FDLS).
//! - [`select_salient`]: which training samples are worth keeping (section 4.2).
//! - [`align_anchors`]: moves a take's markers towards the puppet by anchor poses (section 4.4.2).
//! - [`find_anchor`]: the first anchor pose of a take, found by itself.
//! - [`minimise()`]: L-BFGS in a box, behind every fit.
//! - [`finetune()`]: raw curves until the puppet's markers meet the captured ones (section 4.5).
//! - [`match_markers`]: weights from markers by a quadratic programme (Eq. 2 of FDLS), solved by [`BoundedQuadratic`].
//! - [`measure_jitter`]: how noisy each marker is, told from the take itself.
//! - [`layer`]: what an artist's keys change in every frame.
//! - [`marker_error`], [`weight_error`]: how far solves are off; [`worst_frames`]: where.

mod align;
mod anchor;
#[cfg(test)]
mod anchor_tests;
mod bounded;
mod cholesky;
mod curvature;
mod features;
mod finetune;
mod finetune_plan;
mod jitter;
mod keys;
mod matching;
mod measure;
mod minimise;
#[cfg(test)]
mod minimise_tests;
mod salience;
mod worst;

pub use align::{AlignError, AlignOptions, Aligned, align_anchors};
pub use anchor::{FindAnchorError, FindAnchorOptions, FoundAnchor, find_anchor, spread_frames};
pub use bounded::{BoundedError, BoundedQuadratic, WarmStart};
pub use features::{FeatureError, fdls_sets, feature_width, graph_features};
pub use finetune::{FinetuneError, FinetuneOptions, Finetuned, finetune};
pub use jitter::{MarkerJitter, NEEDED_RUNS, measure_jitter};
pub use keys::{Change, layer};
pub use matching::{LinearPuppet, MatchError, MatchOptions, match_markers};
pub use measure::{MarkerError, MeasureError, WeightError, marker_error, weight_error};
pub use minimise::{Metric, MinimiseError, MinimiseOptions, Minimum, Stop, minimise};
pub use salience::{DEFAULT_BANDWIDTH_SHARE, Salience, SalienceError, SalienceOptions, select_salient};
pub use worst::worst_frames;
