//! Regions: which markers and which channels belong together (section 9 of FDLS).

use serde::{Deserialize, Serialize};
use wire::{Data, DecodeError, Decoder, Encoder, Value, ValueKind};

/// One region of the face.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Name of the region, for example `lower-face`.
    pub name: String,
    /// Markers whose features the region's network sees.
    pub markers: Vec<String>,
    /// Channels that the region's network solves.
    pub channels: Vec<String>,
}

/// The regions of a face, in the order of their file.
#[derive(Debug, Clone, PartialEq)]
pub struct Regions {
    /// The regions.
    pub regions: Vec<Region>,
}

impl Regions {
    /// The region called `name`.
    pub fn get(&self, name: &str) -> Option<&Region> {
        self.regions.iter().find(|region| region.name == name)
    }
}

impl Value for Regions {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&self.regions);
    }

    fn summary(&self) -> String {
        let parts: Vec<_> = self
            .regions
            .iter()
            .map(|region| {
                format!("{} ({} markers, {} channels)", region.name, region.markers.len(), region.channels.len())
            })
            .collect();
        format!("{} regions: {}", parts.len(), parts.join(", "))
    }

    fn size(&self) -> usize {
        self.regions.iter().map(|region| (region.markers.len() + region.channels.len()) * 40).sum()
    }
}

impl Data for Regions {
    const NAME: &'static str = "Regions";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Ok(Self { regions: input.record()? })
    }
}
