//! From the pieces of a file to one rig: what the readers of glTF, FBX and OBJ have in common.
//!
//! A reader makes a [`Piece`] of each of its surfaces, out of polygons where the format has them ([`Polygons`]); the
//! [`Assembly`] lays them one after the other and makes shapes of the same name over all pieces one shape.

mod normals;
mod polygons;

pub(crate) use normals::normals;
pub(crate) use polygons::{Corner, Polygons, Split};

use face_math::data::{Driver, Part, Rig, Shape};
use face_math::rig::{ShapeNameError, shape_drivers};
use glam::Vec3;
use std::collections::BTreeMap;

/// A surface, ready to become a part. Indices count from its own first vertex.
pub(crate) struct Piece {
    pub name: String,
    pub part: Part,
    /// In metres.
    pub positions: Vec<Vec3>,
    /// Share of the jaw, a vertex.
    pub jaw: Vec<f32>,
    /// Shapes by name: displaced vertices, ascending, and their displacements in metres.
    pub moves: Vec<(String, Vec<(u32, Vec3)>)>,
}

/// More vertices than 32 bits can count.
#[derive(Debug)]
pub(crate) struct TooManyVertices {
    /// The piece that did not fit any more.
    pub piece: String,
}

/// A rig in the making.
pub(crate) struct Assembly {
    rig: Rig,
    names: Vec<String>,
    index: BTreeMap<String, usize>,
    moves: Vec<(Vec<u32>, Vec<Vec3>)>,
}

impl Assembly {
    /// A rig called `name` without anything.
    pub fn new(name: &str) -> Self {
        let rig = Rig {
            name: name.to_owned(),
            parts: Vec::new(),
            neutral: Vec::new(),
            channels: Vec::new(),
            shapes: Vec::new(),
            skin: Vec::new(),
            jaw_pivot_m: None,
            jaw: None,
            joints: Vec::new(),
        };
        Self { rig, names: Vec::new(), index: BTreeMap::new(), moves: Vec::new() }
    }

    /// Adds a piece. Shapes are listed in the order in which their names first stood, those that move nothing too.
    pub fn add(&mut self, piece: Piece) -> Result<(), TooManyVertices> {
        let rig = &mut self.rig;
        let first = u32::try_from(rig.neutral.len()).unwrap_or(u32::MAX);
        let count = u32::try_from(piece.positions.len()).ok();
        let Some(end) = count.and_then(|count| first.checked_add(count)) else {
            return Err(TooManyVertices { piece: piece.name });
        };
        let mut part = piece.part;
        part.vertices = first..end;
        part.triangles.iter_mut().flatten().for_each(|index| *index += first);
        // Two parts of one name could not be told apart.
        let taken = |name: &str| rig.parts.iter().any(|part| part.name == name);
        part.name = std::iter::once(piece.name.clone())
            .chain((2..rig.parts.len() + 2).map(|number| format!("{}_{number}", piece.name)))
            .find(|name| !taken(name))
            .unwrap_or(piece.name);
        rig.neutral.extend(piece.positions);
        rig.skin.extend(piece.jaw);
        rig.parts.push(part);
        for (name, moves) in piece.moves {
            let slot = *self.index.entry(name).or_insert_with_key(|name| {
                self.names.push(name.clone());
                self.moves.push((Vec::new(), Vec::new()));
                self.names.len() - 1
            });
            let (vertices, deltas) = &mut self.moves[slot];
            for (vertex, delta) in moves {
                vertices.push(first + vertex);
                deltas.push(delta);
            }
        }
        Ok(())
    }

    /// Whether there is no surface yet.
    pub fn is_empty(&self) -> bool {
        self.rig.parts.is_empty()
    }

    /// Whether any piece has shapes.
    pub fn has_shapes(&self) -> bool {
        !self.names.is_empty()
    }

    /// The rig, where the one name of a shape may wait for others (`a+b`): it is a channel whatever it says.
    pub fn finish_alone(mut self) -> Rig {
        let shapes = self.names.iter().cloned().zip(std::mem::take(&mut self.moves)).zip(0..);
        self.rig.shapes = shapes
            .map(|((name, (vertices, deltas)), channel)| Shape {
                name,
                driver: Driver::Channel(channel),
                vertices,
                deltas,
            })
            .collect();
        self.rig.channels = self.names;
        self.rig.skin.clear();
        self.rig
    }

    /// The rig. `jaw_pivot_m` is where the jaw's joint stands; `has_jaw` whether the shares of the jaw mean anything.
    pub fn finish(mut self, has_jaw: bool, jaw_pivot_m: Option<Vec3>) -> Result<Rig, ShapeNameError> {
        if !has_jaw {
            self.rig.skin.clear();
        }
        let (channels, drivers) = shape_drivers(&self.names)?;
        self.rig.channels = channels;
        self.rig.jaw_pivot_m = jaw_pivot_m;
        self.rig.shapes = drivers
            .into_iter()
            .zip(self.names)
            .zip(self.moves)
            .map(|((driver, name), (vertices, deltas))| Shape { name, driver, vertices, deltas })
            .collect();
        Ok(self.rig)
    }
}
