//! What can be wrong with a glTF file, with the place where it is wrong.

use face_math::rig::ShapeNameError;

/// Why bytes are not a glTF file that can be read as what was asked for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GltfError {
    /// Nothing at all.
    #[error("the file is empty; export the head again")]
    Empty,
    /// Neither a GLB container nor JSON.
    #[error("the file begins neither with `glTF` (GLB) nor with `{{` (glTF); this is no glTF file")]
    NoGltf,
    /// Another version of the format.
    #[error("the file is glTF {found}; version 2 is read here, export it as that")]
    Version {
        /// The version found.
        found: String,
    },
    /// A GLB chunk does not fit into the file.
    #[error(
        "the file ends at byte {have}, but {what} begins at byte {begins} and is {length} bytes long; the file was cut \
         short, copy or export it again"
    )]
    Short {
        /// What is cut.
        what: String,
        /// Where it begins.
        begins: usize,
        /// How long it is.
        length: usize,
        /// Where the file ends.
        have: usize,
    },
    /// The JSON part is no JSON, or lacks a field.
    #[error("the JSON at line {line}, column {column}: {problem}")]
    Json {
        /// Line within the JSON, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
    },
    /// The file needs an extension that is not read here.
    #[error("the file needs the extension {name}, which is not read here; export it without")]
    Extension {
        /// Name of the extension.
        name: String,
    },
    /// A buffer could not be had.
    #[error("buffer {index}: {problem}")]
    Buffer {
        /// Index of the buffer.
        index: usize,
        /// What is wrong.
        problem: String,
    },
    /// A reference to something that is not there.
    #[error("{from} refers to {kind} {index}, but there are {count}")]
    Reference {
        /// What refers.
        from: String,
        /// What it refers to.
        kind: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// An accessor does not hold what its user needs.
    #[error("{place}: accessor {accessor}: {problem}")]
    Accessor {
        /// Which mesh, primitive and attribute use it.
        place: String,
        /// Index of the accessor.
        accessor: usize,
        /// What is wrong.
        problem: String,
    },
    /// Nodes that are their own ancestors, or have two parents.
    #[error("node {node} is reached twice in the tree of nodes; each node must have one parent")]
    Tree {
        /// Index of the node.
        node: usize,
    },
    /// A mesh or primitive is not what a rig needs.
    #[error("{place}: {problem}")]
    Mesh {
        /// Which mesh, or mesh and primitive.
        place: String,
        /// What is wrong.
        problem: String,
    },
    /// A shape's name does not make sense.
    #[error(transparent)]
    Shape(#[from] ShapeNameError),
    /// An animation that is no curves.
    #[error("animation `{name}`: {problem}")]
    Animation {
        /// Name of the animation; empty where none was asked for.
        name: String,
        /// What is wrong, and the cure.
        problem: String,
    },
    /// No triangles at all.
    #[error("the scene holds no mesh of triangles, so it is no rig; export the head with its meshes")]
    NoMesh,
    /// No morph targets at all.
    #[error(
        "no mesh of the {meshes} in the scene has morph targets, so nothing can drive this as a rig; export the head \
         with its blend shapes (shape keys)"
    )]
    NoTargets {
        /// How many meshes there are.
        meshes: usize,
    },
}
