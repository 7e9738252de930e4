//! Skins: how vertices follow joints at rest, and which of the joints is the jaw.

use super::matrix;
use glam::{DMat4, Vec3};

/// The skin of a mesh.
pub(super) struct Skin<'a> {
    deformer: &'a ufbx::SkinDeformer,
    /// Whether each cluster's joint is the jaw or hangs on it; empty where there is no jaw.
    is_jaw: Vec<bool>,
    /// Where the jaw's joint stands, in metres.
    pub jaw_pivot_m: Option<Vec3>,
}

/// What a skin makes of one vertex.
#[derive(Clone)]
pub(super) struct Followed {
    /// Mesh to world at rest; nothing where the vertex follows no joint.
    pub matrix: Option<DMat4>,
    /// Share of the jaw.
    pub jaw: f32,
}

impl<'a> Skin<'a> {
    pub fn of(deformer: &'a ufbx::SkinDeformer) -> Self {
        let bone = |cluster: &'a ufbx::SkinCluster| cluster.bone_node.as_deref();
        let bones: Vec<Option<&ufbx::Node>> = deformer.clusters.iter().map(|cluster| bone(cluster)).collect();
        let jaw = find_jaw(bones.iter().flatten().copied());
        let below = |bone: Option<&ufbx::Node>| jaw.is_some_and(|jaw| bone.is_some_and(|bone| is_below(bone, jaw)));
        let is_jaw = if jaw.is_some() { bones.iter().copied().map(below).collect() } else { Vec::new() };
        let jaw_pivot_m = jaw.map(|jaw| matrix(&jaw.node_to_world).w_axis.truncate().as_vec3());
        Self { deformer, is_jaw, jaw_pivot_m }
    }

    /// Whether it has a jaw.
    pub fn has_jaw(&self) -> bool {
        !self.is_jaw.is_empty()
    }

    /// What it makes of each of the `count` vertices of its mesh.
    pub fn follow(&self, count: usize) -> Vec<Followed> {
        let mut followed = vec![Followed { matrix: None, jaw: 0.0 }; count];
        let matrices: Vec<DMat4> =
            self.deformer.clusters.iter().map(|cluster| matrix(&cluster.geometry_to_world)).collect();
        for (vertex, followed) in self.deformer.vertices.iter().zip(&mut followed) {
            let weights =
                self.deformer.weights.iter().skip(vertex.weight_begin as usize).take(vertex.num_weights as usize);
            let (mut sum, mut total, mut jaw) = (DMat4::ZERO, 0.0, 0.0);
            for share in weights {
                let cluster = share.cluster_index as usize;
                let Some(matrix) = matrices.get(cluster) else { continue };
                sum += *matrix * share.weight;
                total += share.weight;
                jaw += if self.is_jaw.get(cluster).copied().unwrap_or_default() { share.weight } else { 0.0 };
            }
            if total > 0.0 {
                *followed = Followed { matrix: Some(sum * total.recip()), jaw: (jaw / total) as f32 };
            }
        }
        followed
    }
}

/// The joint called `jaw` (whatever comes before a `:`), or else the one highest up whose name contains `jaw`, in any
/// case.
fn find_jaw<'a>(bones: impl Iterator<Item = &'a ufbx::Node> + Clone) -> Option<&'a ufbx::Node> {
    let name = |bone: &ufbx::Node| bone.element.name.to_lowercase();
    let exact = bones.clone().find(|bone| name(bone).rsplit(':').next() == Some("jaw"));
    exact.or_else(|| bones.filter(|bone| name(bone).contains("jaw")).min_by_key(|bone| bone.node_depth))
}

fn is_below(bone: &ufbx::Node, above: &ufbx::Node) -> bool {
    let wanted = above.element.element_id;
    // Parents end at the root: the library that reads the file refuses circles.
    let mut node = Some(bone);
    while let Some(here) = node {
        if here.element.element_id == wanted {
            return true;
        }
        node = here.parent.as_deref();
    }
    false
}
