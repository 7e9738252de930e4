//! What may be written after `grimace edit-key`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// `grimace edit-key`
#[derive(Debug, Args)]
#[command(
    after_help = "The key goes into a file of edits, which graphs read by `load_edits`; the solve itself stays as it is. A key \
                  that stands at the frame already is replaced, and how to go back is said.\n\n\
                  Examples:\n  grimace edit-key day1_161 jawOpen 120 0.4\n  \
                  grimace edit-key day1_161 mouthSmile_L 300 0.1 --offset --falloff 20 --edits shots/edits.ron\n  \
                  grimace edit-key day1_161 jawOpen 120 --remove"
)]
pub struct EditKey {
    /// The take, by its name
    pub take: String,
    /// The channel
    pub channel: String,
    /// The frame, as the take counts it
    #[arg(allow_negative_numbers = true)]
    pub frame: i64,
    /// The weight that the channel has there
    #[arg(allow_negative_numbers = true, required_unless_present = "remove", conflicts_with = "remove")]
    pub value: Option<f64>,
    /// VALUE is what is added to the solved weight
    #[arg(long, conflicts_with = "remove")]
    pub offset: bool,
    /// Frames over which the change fades on either side
    #[arg(long, value_name = "FRAMES", default_value_t = face_io::edits::USUAL_FALLOFF_FRAMES)]
    pub falloff: u32,
    /// How the change fades, or passes into the next key's
    #[arg(long, value_enum, default_value_t = Way::Smooth)]
    pub curve: Way,
    /// Take the key out, so that the frame is as it was solved
    #[arg(long)]
    pub remove: bool,
    /// The file of edits; made where there is none
    #[arg(long, value_name = "FILE", default_value = "edits.ron")]
    pub edits: PathBuf,
}

/// How a key's change passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Way {
    /// Slowly at both ends
    Smooth,
    /// In a straight line
    Linear,
    /// Not at all, until the next key or the end of its falloff
    Hold,
}
