//! glTF and GLB: rigs with morph targets and a jaw joint, and animated heads.
//!
//! Reading goes container → scene → primitives → one [`Rig`]: every primitive becomes a part, the transforms of nodes
//! and the skin's rest pose are applied to it, and targets of the same name become one shape over all parts.

mod accessor;
mod container;
mod error;
mod primitive;
mod scene;
mod shapes;
mod skin;
mod write;

pub use container::detect;
pub use error::GltfError;
pub use write::{write, write_animation};

use crate::{ReadError, Sibling};
use container::File;
use face_math::data::{Rig, Shape};
use glam::Vec3;
use primitive::Piece;
use scene::Scene;
use skin::Skin;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Reads the rig in a glTF or GLB file, in metres. `name` becomes the rig's name, `sibling` fetches buffers that lie
/// in files of their own.
///
/// Names of morph targets come from `mesh.extras.targetNames` (`target_N` where there are none). The weight of the
/// joint called `jaw`, with everything that hangs on it, becomes the rig's skin.
///
/// # Errors
/// See [`GltfError`]; also where there are no morph targets, since nothing could drive such a rig.
pub fn read(bytes: &[u8], name: &str, sibling: &mut Sibling<'_>) -> Result<Rig, ReadError> {
    let file = File::read(bytes, sibling)?;
    Ok(rig(&file, name, true)?.checked()?)
}

/// A glTF file whatever it holds: with or without shapes.
pub(crate) struct Outline {
    pub rig: Rig,
    /// Whether it is a GLB container.
    pub binary: bool,
}

/// Reads a file as [`read`] does, but allows that it has no morph targets.
pub(crate) fn outline(bytes: &[u8], name: &str, sibling: &mut Sibling<'_>) -> Result<Outline, ReadError> {
    let file = File::read(bytes, sibling)?;
    Ok(Outline { rig: rig(&file, name, false)?.checked()?, binary: file.binary })
}

fn rig(file: &File, name: &str, needs_shapes: bool) -> Result<Rig, GltfError> {
    let scene = Scene::read(file)?;
    let mut skins: BTreeMap<usize, Skin> = BTreeMap::new();
    let mut rig = Rig {
        name: name.to_owned(),
        parts: Vec::new(),
        neutral: Vec::new(),
        channels: Vec::new(),
        shapes: Vec::new(),
        skin: Vec::new(),
        jaw_pivot_m: None,
        jaw: None,
    };
    let mut shapes = ShapeTable::default();
    let (mut meshes, mut has_jaw) = (0, false);
    for node_index in &scene.nodes {
        let node = &file.root.nodes[*node_index];
        let Some(mesh_index) = node.mesh.map(|mesh| mesh.value()) else { continue };
        let count = file.root.meshes.len();
        let from = format!("node {node_index}");
        let mesh = file.root.meshes.get(mesh_index).ok_or_else(|| GltfError::Reference {
            from: from.clone(),
            kind: "mesh",
            index: mesh_index,
            count,
        })?;
        let skin = match node.skin.map(|skin| skin.value()) {
            None => None,
            Some(index) => Some(&*match skins.entry(index) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => new.insert(Skin::read(file, &scene, index, &from)?),
            }),
        };
        if let Some(skin) = skin {
            has_jaw |= skin.has_jaw();
            rig.jaw_pivot_m = rig.jaw_pivot_m.or(skin.jaw_pivot_m);
        }
        meshes += 1;
        let source = primitive::Source { file, mesh, mesh_index, node, world: scene.world[*node_index], skin };
        let targets = source.target_names()?;
        for primitive in 0..mesh.primitives.len() {
            if let Some(piece) = source.read(primitive, &targets)? {
                add(&mut rig, &mut shapes, piece, &targets)?;
            }
        }
    }
    if rig.parts.is_empty() {
        return Err(GltfError::NoMesh);
    }
    if needs_shapes && shapes.names.is_empty() {
        return Err(GltfError::NoTargets { meshes });
    }
    if !has_jaw {
        rig.skin.clear();
    }
    let (channels, drivers) = shapes::drivers(&shapes.names)?;
    rig.channels = channels;
    rig.shapes = drivers
        .into_iter()
        .zip(shapes.names)
        .zip(shapes.moves)
        .map(|((driver, name), (vertices, deltas))| Shape { name, driver, vertices, deltas })
        .collect();
    Ok(rig)
}

/// Shapes by name, in the order in which their names first stood.
#[derive(Default)]
struct ShapeTable {
    names: Vec<String>,
    index: BTreeMap<String, usize>,
    moves: Vec<(Vec<u32>, Vec<Vec3>)>,
}

impl ShapeTable {
    fn slot(&mut self, name: &str) -> &mut (Vec<u32>, Vec<Vec3>) {
        let index = *self.index.entry(name.to_owned()).or_insert_with(|| {
            self.names.push(name.to_owned());
            self.moves.push((Vec::new(), Vec::new()));
            self.names.len() - 1
        });
        &mut self.moves[index]
    }
}

fn add(rig: &mut Rig, shapes: &mut ShapeTable, piece: Piece, targets: &[String]) -> Result<(), GltfError> {
    let first = u32::try_from(rig.neutral.len()).unwrap_or(u32::MAX);
    let end = first.checked_add(piece.positions.len() as u32).ok_or_else(|| GltfError::Mesh {
        place: piece.name.clone(),
        problem: "the rig has more vertices than 32 bits can count".into(),
    })?;
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
    for (name, moves) in targets.iter().zip(piece.moves) {
        let (vertices, deltas) = shapes.slot(name);
        for (vertex, delta) in moves {
            vertices.push(first + vertex);
            deltas.push(delta);
        }
    }
    Ok(())
}
