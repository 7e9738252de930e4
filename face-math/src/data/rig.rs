//! Rigs: a head of several parts, its channels and shapes, and the jaw's share in them.

use super::{DataError, check_size, check_unique};
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use wire::{Data, DecodeError, Decoder, Encoder, Table, Value, ValueKind};

/// A connected piece of the head: face, teeth, eyeball …; its vertices are a run of the rig's vertices.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Name of the part, for example `teeth_lower`.
    pub name: String,
    /// The part's vertices within the rig's.
    pub vertices: Range<u32>,
    /// Triangles, counter-clockwise from outside, as indices into the rig's vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates, one a vertex of the part, origin at the top left; empty where there are none.
    pub uvs: Vec<[f32; 2]>,
    /// Base colour, linear RGB.
    pub colour: [f32; 3],
}

/// What drives a shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Driver {
    /// The weight of one channel (index into the rig's channels).
    Channel(u32),
    /// The product of the weights of several channels: a combination corrective (`a+b`).
    Combination(Vec<u32>),
    /// A tent over one channel's weight: 0 at the neighbours, 1 at `peak` (`a@0.5`).
    InBetween {
        /// The channel.
        channel: u32,
        /// Where the tent peaks, strictly between 0 and 1.
        peak: f32,
    },
}

/// One shape: sparse displacements of vertices, and what drives them.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Name of the shape (the channel's name, `a+b`, or `a@0.5`).
    pub name: String,
    /// What drives it.
    pub driver: Driver,
    /// Displaced vertices, ascending.
    pub vertices: Vec<u32>,
    /// Displacement of each at weight 1, in metres.
    pub deltas: Vec<Vec3>,
}

/// How the jaw moves when a shape's weight is 1: x ↦ R (x) + T about the origin of the rig.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JawMotion {
    /// Index of the shape among the rig's shapes.
    pub shape: u32,
    /// `R_i` as angles about the fixed axes of the rig, in radians: first x (opening), then y (left and right), then z,
    /// so R = Rz·Ry·Rx. Rotations of several shapes mix by adding these angles.
    pub euler_rad: Vec3,
    /// `T_i` in metres.
    pub translation_m: Vec3,
}

/// The jaw as a joint: who follows it, and where each jaw shape takes it (section 6 of the deepfake capture paper).
/// A rig that has one holds "de-skinned" deltas `D_i` in its shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct JawSkin {
    /// M: per vertex, 0 follows the skull, 1 follows the jaw.
    pub weights: Vec<f32>,
    /// The shapes that move the jaw.
    pub motions: Vec<JawMotion>,
}

/// A head that channel weights drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// Name of the head.
    pub name: String,
    /// Parts, in the order of their vertices.
    pub parts: Vec<Part>,
    /// Neutral positions of all vertices, in metres.
    pub neutral: Vec<Vec3>,
    /// Channel names.
    pub channels: Vec<String>,
    /// Shapes: of channels, combinations and in-betweens.
    pub shapes: Vec<Shape>,
    /// How much each vertex follows the jaw joint of the rig's own skin; empty where the rig has none.
    pub skin: Vec<f32>,
    /// Where the jaw's own joint stands, in metres, where the rig has one.
    pub jaw_pivot_m: Option<Vec3>,
    /// The jaw as a joint, where it has been split off the shapes.
    pub jaw: Option<JawSkin>,
}

impl Rig {
    /// Checks that all indices and table sizes fit together.
    ///
    /// # Errors
    /// At the first that does not.
    pub fn checked(self) -> Result<Self, DataError> {
        let count = self.neutral.len();
        let inside = |what: &dyn Fn() -> String, index: u32, count: usize| {
            if (index as usize) < count {
                Ok(())
            } else {
                Err(DataError::Index { what: what(), index: index as usize, count })
            }
        };
        check_unique("channel", &self.channels)?;
        for part in &self.parts {
            for index in part.triangles.iter().flatten() {
                inside(&|| format!("triangle of part `{}`", part.name), *index, count)?;
            }
            if part.vertices.end as usize > count {
                inside(&|| format!("last vertex of part `{}`", part.name), part.vertices.end, count)?;
            }
            if !part.uvs.is_empty() {
                check_size("texture coordinates", part.vertices.len(), part.uvs.len())?;
            }
        }
        for shape in &self.shapes {
            check_size("shape displacements", shape.vertices.len(), shape.deltas.len())?;
            for index in &shape.vertices {
                inside(&|| format!("vertex of shape `{}`", shape.name), *index, count)?;
            }
            let channels = match &shape.driver {
                Driver::Channel(channel) | Driver::InBetween { channel, .. } => std::slice::from_ref(channel),
                Driver::Combination(channels) => channels.as_slice(),
            };
            for channel in channels {
                inside(&|| format!("channel that drives shape `{}`", shape.name), *channel, self.channels.len())?;
            }
        }
        if !self.skin.is_empty() {
            check_size("skin weights", count, self.skin.len())?;
        }
        if let Some(jaw) = &self.jaw {
            check_size("jaw weights", count, jaw.weights.len())?;
            for motion in &jaw.motions {
                inside(&|| "shape of a jaw motion".to_owned(), motion.shape, self.shapes.len())?;
            }
        }
        Ok(self)
    }

    /// The part called `name`.
    pub fn part(&self, name: &str) -> Option<&Part> {
        self.parts.iter().find(|part| part.name == name)
    }

    /// The channel called `name`.
    pub fn channel(&self, name: &str) -> Option<usize> {
        self.channels.iter().position(|own| own == name)
    }
}

impl JawMotion {
    /// The rotation `R_i` = Rz·Ry·Rx.
    pub fn rotation(&self) -> Quat {
        Quat::from_euler(glam::EulerRot::ZYX, self.euler_rad.z, self.euler_rad.y, self.euler_rad.x)
    }
}

impl Value for Rig {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&(&self.name, &self.parts, &self.channels, self.jaw_pivot_m));
        out.points(&self.neutral);
        out.f32s(&self.skin);
        out.count(self.shapes.len());
        for shape in &self.shapes {
            out.record(&(&shape.name, &shape.driver));
            out.u32s(&shape.vertices);
            out.points(&shape.deltas);
        }
        match &self.jaw {
            None => out.count(0),
            Some(jaw) => {
                out.count(1);
                out.f32s(&jaw.weights);
                out.record(&jaw.motions);
            }
        }
    }

    fn summary(&self) -> String {
        let triangles: usize = self.parts.iter().map(|part| part.triangles.len()).sum();
        let jaw = match &self.jaw {
            None => String::new(),
            Some(jaw) => format!(", jaw moved by {} shapes", jaw.motions.len()),
        };
        format!(
            "{}: {} parts, {} vertices, {triangles} triangles, {} channels, {} shapes{jaw}",
            self.name,
            self.parts.len(),
            self.neutral.len(),
            self.channels.len(),
            self.shapes.len(),
        )
    }

    fn size(&self) -> usize {
        self.neutral.len() * 16
            + self.parts.iter().map(|part| part.triangles.len() * 12 + part.uvs.len() * 8).sum::<usize>()
            + self.shapes.iter().map(|shape| shape.vertices.len() * 16 + 100).sum::<usize>()
    }

    fn tables(&self) -> Vec<Table<'_>> {
        super::tables::rig(self)
    }
}

impl Data for Rig {
    const NAME: &'static str = "Rig";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (name, parts, channels, jaw_pivot_m) = input.record()?;
        let neutral = input.points()?;
        let skin = input.f32s()?;
        let count = input.count()?;
        let mut shapes = Vec::new();
        for _ in 0..count {
            let (name, driver) = input.record()?;
            shapes.push(Shape { name, driver, vertices: input.u32s()?, deltas: input.points()? });
        }
        let jaw = match input.count()? {
            0 => None,
            _ => Some(JawSkin { weights: input.f32s()?, motions: input.record()? }),
        };
        Self { name, parts, neutral, channels, shapes, skin, jaw_pivot_m, jaw }
            .checked()
            .map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }
}
