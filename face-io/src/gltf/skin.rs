//! Skins: where joints stand at rest, how vertices follow them, and which of them is the jaw.

use super::GltfError;
use super::accessor::Array;
use super::container::File;
use super::scene::Scene;
use glam::{DMat4, Vec3};
use gltf_json::Index;
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;

/// A skin that meshes hang on.
pub(super) struct Skin {
    /// World at rest times inverse bind matrix, one a joint; empty where they all are the identity.
    matrices: Vec<DMat4>,
    /// Whether each joint is the jaw or hangs on it; empty where there is no jaw.
    is_jaw: Vec<bool>,
    /// Where the jaw's joint stands, in metres.
    pub jaw_pivot_m: Option<Vec3>,
    joints: usize,
}

/// What a skin makes of one vertex.
pub(super) struct Followed {
    /// Rest transform; nothing where it is the identity.
    pub matrix: Option<DMat4>,
    /// Share of the jaw.
    pub jaw: f32,
}

impl Skin {
    pub fn read(file: &File, scene: &Scene, index: usize, from: &str) -> Result<Self, GltfError> {
        let count = file.root.skins.len();
        let skin = file.root.skins.get(index).ok_or_else(|| GltfError::Reference {
            from: from.to_owned(),
            kind: "skin",
            index,
            count,
        })?;
        let place = format!("skin {index}");
        let nodes = &file.root.nodes;
        let joints: Vec<usize> = skin.joints.iter().map(Index::value).collect();
        if let Some(joint) = joints.iter().find(|joint| **joint >= nodes.len()) {
            return Err(GltfError::Reference { from: place, kind: "node", index: *joint, count: nodes.len() });
        }
        let inverse = match skin.inverse_bind_matrices {
            None => vec![DMat4::IDENTITY; joints.len()],
            Some(accessor) => {
                let place = format!("{place}, inverse bind matrices");
                let array = Array::open(file, accessor, &place)?;
                let matrices = array.floats::<16>()?;
                if matrices.len() < joints.len() {
                    return Err(array.wrong(format!("{} matrices for {} joints", matrices.len(), joints.len())));
                }
                matrices.iter().map(|matrix| DMat4::from_cols_array(&matrix.map(f64::from))).collect()
            }
        };
        let mut matrices: Vec<_> =
            joints.iter().zip(&inverse).map(|(joint, inverse)| scene.world[*joint] * *inverse).collect();
        // A skin that is bound where it rests moves nothing; rounding in its matrices must not either.
        if matrices.iter().all(|matrix| matrix.abs_diff_eq(DMat4::IDENTITY, 1e-6)) {
            matrices.clear();
        }
        let jaw = find_jaw(file, scene, &joints);
        let is_jaw = jaw.map_or(Vec::new(), |jaw| joints.iter().map(|joint| scene.is_below(*joint, jaw)).collect());
        let jaw_pivot_m = jaw.map(|jaw| scene.world[jaw].w_axis.truncate().as_vec3());
        Ok(Self { matrices, is_jaw, jaw_pivot_m, joints: joints.len() })
    }

    /// What this skin makes of each of the `count` vertices of a primitive.
    pub fn follow(
        &self,
        file: &File,
        primitive: &Primitive,
        count: usize,
        place: &str,
    ) -> Result<Vec<Followed>, GltfError> {
        let mut sums = vec![(DMat4::ZERO, 0.0_f64, 0.0_f64); count];
        for set in 0.. {
            let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
            let (joints, weights) = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)));
            let (Some(joints), Some(weights)) = (joints, weights) else { break };
            let joint_place = format!("{place}, JOINTS_{set}");
            let weight_place = format!("{place}, WEIGHTS_{set}");
            let joints = Array::open(file, joints, &joint_place)?;
            let weights = Array::open(file, weights, &weight_place)?;
            for (array, name) in [(&joints, "JOINTS"), (&weights, "WEIGHTS")] {
                let found = array.count()?;
                if found != count {
                    return Err(array.wrong(format!("{found} {name} for {count} vertices")));
                }
            }
            let values = joints.integers::<4>()?.into_iter().zip(weights.floats::<4>()?);
            for (vertex, ((numbers, shares), sum)) in values.zip(&mut sums).enumerate() {
                for (joint, share) in numbers.into_iter().zip(shares).filter(|(_, share)| *share != 0.0) {
                    let joint = joint as usize;
                    if joint >= self.joints {
                        let many = self.joints;
                        return Err(
                            joints.wrong(format!("vertex {vertex} follows joint {joint} where there are {many}"))
                        );
                    }
                    let share = f64::from(share);
                    if let Some(matrix) = self.matrices.get(joint) {
                        sum.0 += *matrix * share;
                    }
                    sum.1 += share;
                    sum.2 += if self.is_jaw.get(joint).copied().unwrap_or_default() { share } else { 0.0 };
                }
            }
        }
        Ok(sums
            .into_iter()
            .map(|(matrix, total, jaw)| {
                let moved = !self.matrices.is_empty() && total > 0.0;
                Followed {
                    matrix: moved.then(|| matrix * total.recip()),
                    jaw: if total > 0.0 { (jaw / total) as f32 } else { 0.0 },
                }
            })
            .collect())
    }

    /// Whether it has a jaw.
    pub fn has_jaw(&self) -> bool {
        !self.is_jaw.is_empty()
    }
}

/// The joint called `jaw` (whatever comes before a `:`), or else the first whose name contains `jaw`, in any case.
fn find_jaw(file: &File, scene: &Scene, joints: &[usize]) -> Option<usize> {
    let name = |joint: usize| file.root.nodes[joint].name.as_deref().unwrap_or_default().to_lowercase();
    let exact = joints.iter().find(|joint| name(**joint).rsplit(':').next() == Some("jaw"));
    let near = || {
        let mut found: Vec<usize> = joints.iter().copied().filter(|joint| name(*joint).contains("jaw")).collect();
        found.sort_by_key(|joint| scene.nodes.iter().position(|node| node == joint));
        found.into_iter().next()
    };
    exact.copied().or_else(near)
}
