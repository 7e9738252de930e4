//! FBX: rigs with blend shapes and a jaw joint, as Maya, Blender and their like write them.
//!
//! The file is taken apart by the library ufbx; here its meshes become parts, in metres with Y up, its blend channels
//! shapes, and its skins the share of the jaw, as in [`crate::gltf`].

mod channels;
mod skin;

use crate::ReadError;
use crate::surface::{Assembly, Corner, Piece, Polygons, Split};
use channels::Offsets;
use face_math::data::Rig;
use face_math::rig::ShapeNameError;
use glam::{DMat3, DMat4, DVec3, DVec4};
use skin::Skin;

/// Why bytes are not an FBX file that can be read as a rig.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FbxError {
    /// Nothing at all.
    #[error("the file is empty; export the head again")]
    Empty,
    /// The file cannot be taken apart.
    #[error("{problem} (in a file of {bytes} bytes); the file is damaged or cut short, copy or export it again")]
    Damaged {
        /// What the library that reads FBX says.
        problem: String,
        /// Size of the file.
        bytes: usize,
    },
    /// Something in a mesh that a rig cannot have.
    #[error("mesh `{mesh}`: {problem}")]
    Mesh {
        /// The mesh, by the name of its node.
        mesh: String,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// A shape's name that makes no sense.
    #[error(transparent)]
    Shape(#[from] ShapeNameError),
    /// No polygons at all.
    #[error("the scene holds no mesh of polygons that is visible, so it is no rig; export the head with its meshes")]
    NoMesh,
    /// No blend shapes at all.
    #[error(
        "none of the {meshes} meshes in the scene has blend shapes, so nothing can drive this as a rig; export the head \
         with its blend shapes (in Maya: Deformed Models, Blend Shapes)"
    )]
    NoShapes {
        /// How many meshes there are.
        meshes: usize,
    },
}

/// What a file may take in memory, in bytes: a damaged one can announce any size.
const MOST_BYTES: usize = 4 << 30;

/// Whether bytes look like an FBX file, binary or ASCII.
pub fn detect(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(4096)];
    bytes.starts_with(b"Kaydara FBX Binary") || {
        let head = String::from_utf8_lossy(head);
        head.trim_start().starts_with("; FBX") || head.contains("FBXHeaderExtension:")
    }
}

/// Reads the rig in an FBX file, in metres and with Y up whatever the file's own unit and axes. `name` becomes the
/// rig's name.
///
/// Every visible mesh becomes a part, one for each of its materials. Shapes bear the names of blend channels without
/// what stands before the last dot (`faceShapes.jawOpen` is `jawOpen`); in-between targets of a channel become shapes
/// such as `jawOpen@0.5`. The weight of the joint called `jaw`, with everything that hangs on it, becomes the rig's skin.
///
/// # Errors
/// See [`FbxError`]; also where there are no blend shapes, since nothing could drive such a rig.
pub fn read(bytes: &[u8], name: &str) -> Result<Rig, ReadError> {
    let outline = outline(bytes, name)?;
    if outline.rig.shapes.is_empty() {
        return Err(FbxError::NoShapes { meshes: outline.meshes }.into());
    }
    Ok(outline.rig)
}

/// An FBX file whatever it holds: with or without shapes.
pub(crate) struct Outline {
    pub rig: Rig,
    pub meshes: usize,
    /// Version and flavour, such as `FBX 7400, binary`.
    pub format: String,
}

/// Reads a file as [`read`] does, but allows that it has no blend shapes.
pub(crate) fn outline(bytes: &[u8], name: &str) -> Result<Outline, ReadError> {
    if bytes.is_empty() {
        return Err(FbxError::Empty.into());
    }
    let scene = load(bytes)?;
    let mut assembly = Assembly::new(name);
    let (mut meshes, mut has_jaw, mut jaw_pivot_m) = (0, false, None);
    for node in &scene.nodes {
        let Some(mesh) = node.mesh.as_ref().filter(|_| node.visible) else { continue };
        meshes += 1;
        let skin = mesh.skin_deformers.first().map(|skin| Skin::of(skin));
        if let Some(skin) = &skin {
            has_jaw |= skin.has_jaw();
            jaw_pivot_m = jaw_pivot_m.or(skin.jaw_pivot_m);
        }
        for piece in pieces(node, mesh, skin.as_ref())? {
            assembly.add(piece).map_err(|error| FbxError::Mesh {
                mesh: error.piece,
                problem: "the rig has more vertices than 32 bits can count".to_owned(),
            })?;
        }
    }
    if assembly.is_empty() {
        return Err(FbxError::NoMesh.into());
    }
    let rig = assembly.finish(has_jaw, jaw_pivot_m).map_err(FbxError::from)?.checked()?;
    let flavour = if scene.metadata.ascii { "ASCII" } else { "binary" };
    Ok(Outline { rig, meshes, format: format!("FBX {}, {flavour}", scene.metadata.version) })
}

fn load(bytes: &[u8]) -> Result<ufbx::SceneRoot, FbxError> {
    let memory = || ufbx::AllocatorOpts { memory_limit: MOST_BYTES, ..Default::default() };
    let options = ufbx::LoadOpts {
        file_format: ufbx::FileFormat::Fbx,
        temp_allocator: memory(),
        result_allocator: memory(),
        ignore_embedded: true,
        index_error_handling: ufbx::IndexErrorHandling::AbortLoading,
        target_axes: ufbx::CoordinateAxes::right_handed_y_up(),
        target_unit_meters: 1.0,
        ..Default::default()
    };
    ufbx::load_memory(bytes, options)
        .map_err(|error| FbxError::Damaged { problem: error.description.to_string(), bytes: bytes.len() })
}

/// A mesh where its node places it, one piece for each material.
fn pieces(node: &ufbx::Node, mesh: &ufbx::Mesh, skin: Option<&Skin<'_>>) -> Result<Vec<Piece>, FbxError> {
    let name = [&node.element.name, &mesh.element.name].into_iter().find(|name| !name.is_empty());
    let name = name.map_or_else(|| format!("mesh_{}", mesh.element.typed_id), ToString::to_string);
    let wrong = |problem: String| FbxError::Mesh { mesh: name.clone(), problem };
    let stored: Vec<DVec3> = mesh.vertices.iter().copied().map(vector).collect();
    if let Some(at) = stored.iter().position(|point| !point.is_finite()) {
        return Err(wrong(format!("vertex {at} is {}, not a finite position", stored[at])));
    }
    let uvs: Vec<[f32; 2]> = mesh.vertex_uv.values.iter().map(|uv| [uv.x as f32, (1.0 - uv.y) as f32]).collect();
    let polygons = polygons(mesh, stored.len(), uvs.len()).map_err(&wrong)?;
    let shapes = channels::shapes(mesh, stored.len()).map_err(&wrong)?;

    let own = matrix(&node.geometry_to_world);
    let followed = skin.map_or(Vec::new(), |skin| skin.follow(stored.len()));
    let world = |vertex: usize| followed.get(vertex).and_then(|followed| followed.matrix).unwrap_or(own);
    let worlds: Vec<DMat4> = (0..stored.len()).map(world).collect();
    let mirrored = worlds.first().is_some_and(|world| world.determinant() < 0.0);
    // Instances of a mesh may have materials of their own.
    let materials = if node.materials.is_empty() { &mesh.materials } else { &node.materials };
    let split = polygons.split(&stored, &uvs);
    let several = split.len() > 1;
    let piece = |Split { group, vertices, mut part }: Split| {
        if mirrored {
            part.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        let material = materials.get(group);
        part.colour = material.map_or([1.0; 3], |material| colour(material));
        let label = material.map(|material| material.element.name.to_string()).filter(|label| !label.is_empty());
        let name =
            if several { format!("{name}/{}", label.unwrap_or_else(|| group.to_string())) } else { name.clone() };
        let positions = vertices.iter().map(|vertex| {
            let vertex = *vertex as usize;
            worlds[vertex].transform_point3(stored[vertex]).as_vec3()
        });
        let moves = shapes.iter().map(|(name, offsets)| (name.clone(), moved(offsets, &vertices, &worlds)));
        let jaw = vertices.iter().map(|vertex| followed.get(*vertex as usize).map_or(0.0, |followed| followed.jaw));
        Piece { name, part, positions: positions.collect(), jaw: jaw.collect(), moves: moves.collect() }
    };
    Ok(split.into_iter().map(piece).collect())
}

/// Offsets of the vertices of a part, in metres.
fn moved(offsets: &Offsets, vertices: &[u32], worlds: &[DMat4]) -> Vec<(u32, glam::Vec3)> {
    let placed = (0_u32..).zip(vertices).filter_map(|(at, vertex)| {
        let offset = offsets.get(vertex)?;
        Some((at, (DMat3::from_mat4(worlds[*vertex as usize]) * *offset).as_vec3()))
    });
    placed.filter(|(_, offset)| *offset != glam::Vec3::ZERO).collect()
}

/// The polygons of a mesh, grouped by material, with their indices checked.
fn polygons(mesh: &ufbx::Mesh, vertices: usize, uvs: usize) -> Result<Polygons, String> {
    let mut polygons = Polygons::default();
    for (face, polygon) in mesh.faces.iter().enumerate() {
        if polygon.num_indices < 3 {
            continue;
        }
        let begin = polygons.corners.len();
        for at in (polygon.index_begin as usize..).take(polygon.num_indices as usize) {
            let vertex = mesh.vertex_indices.get(at).copied().filter(|vertex| (*vertex as usize) < vertices);
            let vertex = vertex.ok_or_else(|| format!("polygon {face} names a vertex that is not there"))?;
            let uv = mesh.vertex_uv.indices.get(at).copied().filter(|uv| (*uv as usize) < uvs);
            polygons.corners.push(Corner { vertex, uv });
        }
        let group = mesh.face_material.get(face).copied().unwrap_or_default() as usize;
        polygons.faces.push((begin..polygons.corners.len(), group));
    }
    Ok(polygons)
}

fn colour(material: &ufbx::Material) -> [f32; 3] {
    let base = &material.pbr.base_color;
    if !base.has_value {
        return [1.0; 3];
    }
    [base.value_vec4.x, base.value_vec4.y, base.value_vec4.z].map(|channel| channel as f32)
}

fn vector(vector: ufbx::Vec3) -> DVec3 {
    DVec3::new(vector.x, vector.y, vector.z)
}

fn matrix(m: &ufbx::Matrix) -> DMat4 {
    DMat4::from_cols(
        DVec4::new(m.m00, m.m10, m.m20, 0.0),
        DVec4::new(m.m01, m.m11, m.m21, 0.0),
        DVec4::new(m.m02, m.m12, m.m22, 0.0),
        DVec4::new(m.m03, m.m13, m.m23, 1.0),
    )
}
