//! OBJ: single faces, and shapes as one file each beside the neutral face.
//!
//! The numbers of vertices are what makes a shape fit its neutral face: they are read as the file counts them, and the
//! surface (polygons, texture coordinates, parts) is always that of the neutral face.

mod parse;
mod write;

use crate::surface::{Assembly, Piece, Split};
use crate::{LengthUnit, ReadError};
use face_math::data::Rig;
use glam::{DVec3, Vec3};

pub use parse::{Obj, detect};
pub use write::write;

/// Why bytes are not an OBJ file that can be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ObjError {
    /// A line that makes no sense.
    #[error("line {line}: {problem}")]
    Line {
        /// The line, from 1.
        line: usize,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// No polygons.
    #[error("{vertices} vertices and no polygons (`f` lines), so there is no surface; export the mesh with its faces")]
    NoFaces {
        /// Number of vertices.
        vertices: usize,
    },
    /// A shape of another number of vertices than its neutral face.
    #[error(
        "{found} vertices, but the neutral face {neutral} has {expected}; export both from one topology, with the order \
         of vertices kept"
    )]
    Count {
        /// Name of the neutral file.
        neutral: String,
        /// Vertices of the neutral face.
        expected: usize,
        /// Vertices of the shape.
        found: usize,
    },
    /// More vertices than 32 bits can count.
    #[error("part `{part}` does not fit: a rig has at most 4,294,967,295 vertices")]
    Large {
        /// The part.
        part: String,
    },
}

/// Displacements below this, in metres, are rounding of the decimal places in the files.
const STILL_M: f64 = 1e-7;

/// Reads an OBJ file.
///
/// # Errors
/// See [`ObjError`]; each names the line.
pub fn open(bytes: &[u8]) -> Result<Obj, ReadError> {
    Ok(parse::parse(bytes)?)
}

impl Obj {
    /// The face as a rig called `name`, without shapes.
    ///
    /// Parts are the file's groups (`g`), or objects (`o`); those of several materials have one part for each
    /// (`head/lips`). The vertices of a part stand in the order of the file; where a seam of the texture runs through
    /// vertices, their further sides follow at the part's end.
    ///
    /// # Errors
    /// Where there are more vertices than can be counted.
    pub fn head(&self, name: &str, unit: LengthUnit) -> Result<Rig, ReadError> {
        self.rig(name, unit, None)
    }

    /// This neutral face with one shape, called `shape`, which is the face `sculpt`. Both are in `unit`. The shape is a
    /// channel whatever its name says; what `a+b` and `a@0.5` mean shows when the shapes are joined
    /// ([`face_math::rig::join_shapes`]).
    ///
    /// `neutral_file` is the name of this face's file, for messages.
    ///
    /// # Errors
    /// Where the two have different numbers of vertices.
    pub fn sculpted(
        &self,
        name: &str,
        unit: LengthUnit,
        neutral_file: &str,
        (shape, sculpt): (&str, &Self),
    ) -> Result<Rig, ReadError> {
        let (expected, found) = (self.positions.len(), sculpt.positions.len());
        if expected != found {
            return Err(ObjError::Count { neutral: neutral_file.to_owned(), expected, found }.into());
        }
        self.rig(name, unit, Some((shape, &sculpt.positions)))
    }

    fn rig(&self, name: &str, unit: LengthUnit, shape: Option<(&str, &[DVec3])>) -> Result<Rig, ReadError> {
        let metres = |point: DVec3| (point * unit.metres()).as_vec3();
        let mut assembly = Assembly::new(name);
        for Split { group, vertices, part } in self.polygons.split(&self.positions, &self.uvs) {
            let moves = shape.map(|(shape, sculpt)| {
                let moved = (0_u32..).zip(&vertices).filter_map(|(at, vertex)| {
                    let vertex = *vertex as usize;
                    let offset = (sculpt[vertex] - self.positions[vertex]) * unit.metres();
                    (offset.abs().max_element() > STILL_M).then(|| (at, offset.as_vec3()))
                });
                (shape.to_owned(), moved.collect::<Vec<(u32, Vec3)>>())
            });
            let piece = Piece {
                name: self.groups[group].clone(),
                part,
                positions: vertices.iter().map(|vertex| metres(self.positions[*vertex as usize])).collect(),
                jaw: vec![0.0; vertices.len()],
                moves: moves.into_iter().collect(),
            };
            assembly.add(piece).map_err(|error| ObjError::Large { part: error.piece })?;
        }
        Ok(assembly.finish_alone().checked()?)
    }
}
