//! glTF and GLB: rigs with morph targets and a jaw joint, and animated heads.
//!
//! Reading goes container → scene → primitives → one [`Rig`]: every primitive becomes a part, the transforms of nodes
//! and the skin's rest pose are applied to it, and targets of the same name become one shape over all parts.

mod accessor;
mod animation;
mod container;
mod error;
mod primitive;
mod scene;
mod skin;
mod write;

pub use animation::{Animation, animation_names, read_animation};
pub use container::detect;
pub use error::GltfError;
pub use write::{write, write_animation};

use crate::surface::{Assembly, TooManyVertices};
use crate::{ReadError, Sibling};
use container::File;
use face_math::data::Rig;
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
    /// Names of its animations.
    pub animations: Vec<String>,
    /// The first animation as curves, where it moves morph targets at a rate that shows.
    pub motion: Option<Animation>,
}

/// Reads a file as [`read`] does, but allows that it has no morph targets.
pub(crate) fn outline(bytes: &[u8], name: &str, sibling: &mut Sibling<'_>) -> Result<Outline, ReadError> {
    let file = File::read(bytes, sibling)?;
    let rig = rig(&file, name, false)?.checked()?;
    let animations = animation::names(&file);
    let motion = animations.first().and_then(|first| animation::read(&file, 0, first, None).ok());
    Ok(Outline { rig, binary: file.binary, animations, motion })
}

fn rig(file: &File, name: &str, needs_shapes: bool) -> Result<Rig, GltfError> {
    let scene = Scene::read(file)?;
    let mut skins: BTreeMap<usize, Skin> = BTreeMap::new();
    let mut assembly = Assembly::new(name);
    let mut jaw_pivot_m = None;
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
            jaw_pivot_m = jaw_pivot_m.or(skin.jaw_pivot_m);
        }
        meshes += 1;
        let source = primitive::Source { file, mesh, mesh_index, node, world: scene.world[*node_index], skin };
        let targets = source.target_names()?;
        for primitive in 0..mesh.primitives.len() {
            if let Some(piece) = source.read(primitive, &targets)? {
                assembly.add(piece)?;
            }
        }
    }
    if assembly.is_empty() {
        return Err(GltfError::NoMesh);
    }
    if needs_shapes && !assembly.has_shapes() {
        return Err(GltfError::NoTargets { meshes });
    }
    Ok(assembly.finish(has_jaw, jaw_pivot_m)?)
}

impl From<TooManyVertices> for GltfError {
    fn from(error: TooManyVertices) -> Self {
        Self::Mesh { place: error.piece, problem: "the rig has more vertices than 32 bits can count".into() }
    }
}
