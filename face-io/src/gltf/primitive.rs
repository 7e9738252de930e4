//! One primitive of a mesh as a piece of a rig: its vertices at rest, triangles, targets and share of the jaw.

use super::GltfError;
use super::accessor::Array;
use super::container::File;
use super::skin::{Followed, Skin};
use crate::surface::Piece;
use face_math::data::Part;
use glam::{DMat3, DMat4, Vec3};
use gltf_json::Index;
use gltf_json::accessor::Accessor;
use gltf_json::extras::RawValue;
use gltf_json::mesh::{Mesh, Mode, Primitive, Semantic};
use gltf_json::scene::Node;
use gltf_json::validation::Checked;

/// A mesh where a node places it.
pub(super) struct Source<'a> {
    pub file: &'a File,
    pub mesh: &'a Mesh,
    pub mesh_index: usize,
    pub node: &'a Node,
    pub world: DMat4,
    pub skin: Option<&'a Skin>,
}

impl Source<'_> {
    /// Names of the mesh's morph targets.
    pub fn target_names(&self) -> Result<Vec<String>, GltfError> {
        target_names(self.mesh, self.mesh_index)
    }

    /// One primitive; nothing where it is no surface (points or lines).
    pub fn read(&self, index: usize, targets: &[String]) -> Result<Option<Piece>, GltfError> {
        let primitive = &self.mesh.primitives[index];
        let place = format!("{}, primitive {index}", mesh_place(self.mesh, self.mesh_index));
        let wrong = |problem: String| GltfError::Mesh { place: place.clone(), problem };
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
            Checked::Valid(_) => return Ok(None),
            Checked::Invalid => return Err(wrong("its mode is unknown".into())),
        };
        let at = format!("{place}, POSITION");
        let position = attribute(primitive, Semantic::Positions).ok_or_else(|| wrong("it has no POSITION".into()))?;
        let stored = Array::open(self.file, position, &at)?.floats::<3>()?;
        let count = stored.len();

        let followed = match self.skin {
            Some(skin) => skin.follow(self.file, primitive, count, &place)?,
            None => Vec::new(),
        };
        // The transform of a skinned mesh's own node does not count (section 3.7.3.3 of the specification).
        let world = if self.skin.is_some() { DMat4::IDENTITY } else { self.world };
        let matrix = |vertex: usize| followed.get(vertex).and_then(|f: &Followed| f.matrix).unwrap_or(world);
        let positions: Vec<Vec3> = stored
            .iter()
            .enumerate()
            .map(|(vertex, p)| matrix(vertex).transform_point3(Vec3::from_array(*p).as_dvec3()).as_vec3())
            .collect();

        let mut triangles = self.triangles(primitive, mode, count, &place)?;
        if world.determinant() < 0.0 {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }
        let mut moves = Vec::with_capacity(targets.len());
        for (target, name) in primitive.targets.iter().flatten().zip(targets) {
            let moved = match target.positions {
                None => Vec::new(),
                Some(accessor) => self.moves(accessor, count, &format!("{place}, target `{name}`"), &matrix)?,
            };
            moves.push((name.clone(), moved));
        }
        let uvs = match attribute(primitive, Semantic::TexCoords(0)) {
            None => Vec::new(),
            Some(accessor) => {
                let at = format!("{place}, TEXCOORD_0");
                let array = Array::open(self.file, accessor, &at)?;
                self.same_count(&array, count)?;
                array.floats::<2>()?
            }
        };
        let part =
            Part { name: String::new(), vertices: 0..0, triangles, uvs, colour: self.colour(primitive, &place)? };
        let jaw = if followed.is_empty() { vec![0.0; count] } else { followed.iter().map(|f| f.jaw).collect() };
        Ok(Some(Piece { name: self.part_name(index), part, positions, jaw, moves }))
    }

    #[allow(clippy::unused_self, reason = "reads as a question to the source, beside its siblings")]
    fn same_count(&self, array: &Array<'_>, count: usize) -> Result<(), GltfError> {
        let found = array.count()?;
        if found == count { Ok(()) } else { Err(array.wrong(format!("{found} elements for {count} vertices"))) }
    }

    fn moves(
        &self,
        accessor: Index<Accessor>,
        count: usize,
        place: &str,
        matrix: &dyn Fn(usize) -> DMat4,
    ) -> Result<Vec<(u32, Vec3)>, GltfError> {
        let array = Array::open(self.file, accessor, place)?;
        self.same_count(&array, count)?;
        Ok(array
            .floats::<3>()?
            .into_iter()
            .enumerate()
            .filter(|(_, delta)| delta.iter().any(|by| *by != 0.0))
            .map(|(vertex, delta)| {
                let linear = DMat3::from_mat4(matrix(vertex));
                (vertex as u32, (linear * Vec3::from_array(delta).as_dvec3()).as_vec3())
            })
            .collect())
    }

    fn triangles(
        &self,
        primitive: &Primitive,
        mode: Mode,
        count: usize,
        place: &str,
    ) -> Result<Vec<[u32; 3]>, GltfError> {
        let corners: Vec<u32> = match primitive.indices {
            None => (0..u32::try_from(count).unwrap_or(u32::MAX)).collect(),
            Some(accessor) => {
                let at = format!("{place}, indices");
                let array = Array::open(self.file, accessor, &at)?;
                let corners: Vec<u32> = array.integers::<1>()?.into_iter().flatten().collect();
                if let Some(at) = corners.iter().position(|corner| *corner as usize >= count) {
                    let corner = corners[at];
                    return Err(array.wrong(format!("index {at} is vertex {corner}, but there are {count} vertices")));
                }
                corners
            }
        };
        Ok(match mode {
            Mode::TriangleStrip => corners
                .windows(3)
                .enumerate()
                .map(|(at, c)| if at % 2 == 0 { [c[0], c[1], c[2]] } else { [c[1], c[0], c[2]] })
                .collect(),
            Mode::TriangleFan => corners.windows(2).skip(1).map(|c| [corners[0], c[0], c[1]]).collect(),
            _ => {
                if !corners.len().is_multiple_of(3) {
                    let problem = format!("{} corners do not make whole triangles", corners.len());
                    return Err(GltfError::Mesh { place: place.to_owned(), problem });
                }
                corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()
            }
        })
    }

    /// `primitive.extras.part`; else the name of the mesh (or its node), with that of the material or the number of
    /// the primitive where the mesh has several.
    fn part_name(&self, index: usize) -> String {
        let primitive = &self.mesh.primitives[index];
        if let Some(serde_json::Value::String(part)) = field(primitive.extras.as_deref(), "part") {
            return part;
        }
        let mesh = self.mesh.name.clone().or_else(|| self.node.name.clone());
        let mesh = mesh.unwrap_or_else(|| format!("mesh_{}", self.mesh_index));
        if self.mesh.primitives.len() == 1 {
            return mesh;
        }
        let material = primitive.material.and_then(|material| self.file.root.materials.get(material.value()));
        let material = material.and_then(|material| material.name.clone());
        format!("{mesh}/{}", material.unwrap_or_else(|| index.to_string()))
    }

    fn colour(&self, primitive: &Primitive, place: &str) -> Result<[f32; 3], GltfError> {
        let Some(material) = primitive.material else { return Ok([1.0; 3]) };
        let (index, count) = (material.value(), self.file.root.materials.len());
        let material = self.file.root.materials.get(index).ok_or_else(|| GltfError::Reference {
            from: place.to_owned(),
            kind: "material",
            index,
            count,
        })?;
        let [red, green, blue, _] = material.pbr_metallic_roughness.base_color_factor.0;
        Ok([red, green, blue])
    }
}

fn mesh_place(mesh: &Mesh, index: usize) -> String {
    match &mesh.name {
        Some(name) => format!("mesh `{name}`"),
        None => format!("mesh {index}"),
    }
}

fn targets_of(primitive: &Primitive) -> usize {
    primitive.targets.as_ref().map_or(0, Vec::len)
}

/// Names of the morph targets of the mesh at `index`.
pub(super) fn target_names(mesh: &Mesh, index: usize) -> Result<Vec<String>, GltfError> {
    let count = mesh.primitives.iter().map(targets_of).max().unwrap_or(0);
    let wrong = |problem: String| GltfError::Mesh { place: mesh_place(mesh, index), problem };
    if let Some(odd) = mesh.primitives.iter().position(|primitive| targets_of(primitive) != count) {
        let found = targets_of(&mesh.primitives[odd]);
        return Err(wrong(format!("primitive {odd} has {found} morph targets, another one {count}; all must agree")));
    }
    let listed = field(mesh.extras.as_deref(), "targetNames");
    let Some(listed) = listed else { return Ok((0..count).map(|index| format!("target_{index}")).collect()) };
    let names: Vec<String> =
        serde_json::from_value(listed).map_err(|_| wrong("its extras.targetNames are no list of texts".into()))?;
    if names.len() != count {
        return Err(wrong(format!("{} targetNames for {count} morph targets", names.len())));
    }
    let mut seen = std::collections::BTreeSet::new();
    match names.iter().find(|name| !seen.insert(name.as_str())) {
        Some(twice) => Err(wrong(format!("the target name `{twice}` stands twice"))),
        None => Ok(names),
    }
}

fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

/// A field of an `extras` object.
fn field(extras: Option<&RawValue>, name: &str) -> Option<serde_json::Value> {
    let mut extras: serde_json::Value = serde_json::from_str(extras?.get()).ok()?;
    extras.get_mut(name).map(serde_json::Value::take)
}
