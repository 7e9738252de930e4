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
    /// An entry of a joint's rotation matrix, less what it is at rest: a pose corrective (section A.2 of Animatomy).
    Turn {
        /// 0 is the jaw, 1 the first of the rig's other joints.
        joint: u32,
        /// Row of the entry, 0 to 2.
        row: u32,
        /// Column of the entry, 0 to 2.
        column: u32,
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
#[derive(Debug, Clone, Default, PartialEq)]
pub struct JawSkin {
    /// The point c about which it turns, in metres: x ↦ R (x − c) + c + T. Jaws that were split off shapes turn about
    /// the origin.
    pub pivot_m: Vec3,
    /// M: per vertex, 0 follows the skull, 1 follows the jaw.
    pub weights: Vec<f32>,
    /// The shapes that move the jaw.
    pub motions: Vec<JawMotion>,
}

/// A joint besides the jaw: an eye. It is skinned and moved as the jaw is.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name of the joint, such as `eye_L`.
    pub name: String,
    /// Who follows it, and what moves it.
    pub skin: JawSkin,
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
    /// Joints besides the jaw. Each vertex follows the jaw, these, and with what is left of 1 the skull.
    pub joints: Vec<Joint>,
}

impl Rig {
    /// The jaw, where it is a joint, and all other joints: what [`Driver::Turn`] counts.
    pub fn all_joints(&self) -> impl Iterator<Item = &JawSkin> {
        self.jaw.iter().chain(self.joints.iter().map(|joint| &joint.skin))
    }

    /// The joint of a [`Driver::Turn`]: 0 is the jaw.
    pub fn joint(&self, index: u32) -> Option<&JawSkin> {
        match index {
            0 => self.jaw.as_ref(),
            other => self.joints.get(other as usize - 1).map(|joint| &joint.skin),
        }
    }

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
                Driver::Turn { joint, row, column } => {
                    let what = |what: &str| format!("{what} that drives shape `{}`", shape.name);
                    if self.joint(*joint).is_none() {
                        inside(&|| what("joint"), *joint, 1 + self.joints.len())?;
                        return Err(DataError::Index { what: what("joint"), index: 0, count: 0 });
                    }
                    inside(&|| what("row of the rotation"), *row, 3)?;
                    inside(&|| what("column of the rotation"), *column, 3)?;
                    &[]
                }
            };
            for channel in channels {
                inside(&|| format!("channel that drives shape `{}`", shape.name), *channel, self.channels.len())?;
            }
        }
        if !self.skin.is_empty() {
            check_size("skin weights", count, self.skin.len())?;
        }
        check_unique("joint", &self.joints.iter().map(|joint| joint.name.clone()).collect::<Vec<_>>())?;
        for joint in self.all_joints() {
            check_size("joint weights", count, joint.weights.len())?;
            for motion in &joint.motions {
                inside(&|| "shape of a joint's motion".to_owned(), motion.shape, self.shapes.len())?;
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

impl JawSkin {
    /// The same joint with no vertex.
    #[must_use]
    pub fn without_weights(&self) -> Self {
        Self { pivot_m: self.pivot_m, weights: Vec::new(), motions: self.motions.clone() }
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
        out.count(usize::from(self.jaw.is_some()));
        if let Some(jaw) = &self.jaw {
            encode_joint(jaw, out);
        }
        out.count(self.joints.len());
        for joint in &self.joints {
            out.record(&joint.name);
            encode_joint(&joint.skin, out);
        }
    }

    fn summary(&self) -> String {
        let triangles: usize = self.parts.iter().map(|part| part.triangles.len()).sum();
        let jaw = match &self.jaw {
            None => String::new(),
            Some(jaw) => format!(", jaw moved by {} shapes", jaw.motions.len()),
        };
        let joints: String = self.joints.iter().flat_map(|joint| [", joint ", &joint.name]).collect();
        format!(
            "{}: {} parts, {} vertices, {triangles} triangles, {} channels, {} shapes{jaw}{joints}",
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
    const VERSION: u32 = 2;
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
        let jaw = if input.count()? == 0 { None } else { Some(decode_joint(input)?) };
        let mut joints = Vec::new();
        for _ in 0..input.count()? {
            joints.push(Joint { name: input.record()?, skin: decode_joint(input)? });
        }
        Self { name, parts, neutral, channels, shapes, skin, jaw_pivot_m, jaw, joints }
            .checked()
            .map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }
}

fn encode_joint(joint: &JawSkin, out: &mut Encoder) {
    out.record(&(joint.pivot_m, &joint.motions));
    out.f32s(&joint.weights);
}

fn decode_joint(input: &mut Decoder<'_>) -> Result<JawSkin, DecodeError> {
    let (pivot_m, motions) = input.record()?;
    Ok(JawSkin { pivot_m, weights: input.f32s()?, motions })
}
