//! Attachments: where markers sit on a rig's surface.

use serde::{Deserialize, Serialize};
use wire::{Data, DecodeError, Decoder, Encoder, Table, Value, ValueKind};

/// One marker's place on the neutral surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurfacePoint {
    /// Name of the marker.
    pub name: String,
    /// The triangle's three vertices, as indices into the rig's vertices.
    pub vertices: [u32; 3],
    /// Barycentric weights of the three vertices; they sum to 1.
    pub weights: [f32; 3],
    /// Distance of the captured neutral marker from the surface, in metres.
    pub distance_m: f32,
}

/// Markers attached to a rig's neutral surface, in the order of the neutral markers.
#[derive(Debug, Clone, PartialEq)]
pub struct Attachment {
    /// The attached points.
    pub points: Vec<SurfacePoint>,
}

impl Attachment {
    /// Marker names, in order.
    pub fn names(&self) -> Vec<String> {
        self.points.iter().map(|point| point.name.clone()).collect()
    }
}

impl Value for Attachment {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&self.points);
    }

    fn summary(&self) -> String {
        let count = self.points.len();
        let mean = self.points.iter().map(|point| f64::from(point.distance_m)).sum::<f64>() / count.max(1) as f64;
        let worst = self.points.iter().max_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        let worst = worst.map_or(String::new(), |point| {
            format!(", worst {:.2} mm ({})", f64::from(point.distance_m) * 1000.0, point.name)
        });
        format!("{count} markers on the surface, mean distance {:.2} mm{worst}", mean * 1000.0)
    }

    fn size(&self) -> usize {
        self.points.len() * 72
    }

    fn tables(&self) -> Vec<Table<'_>> {
        super::tables::attachment(self)
    }
}

impl Data for Attachment {
    const NAME: &'static str = "Attachment";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Ok(Self { points: input.record()? })
    }
}
