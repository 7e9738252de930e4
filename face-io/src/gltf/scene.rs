//! The tree of nodes: where each stands in the world, and which of them carry the meshes of the scene.

use super::GltfError;
use super::container::File;
use glam::{DMat4, DQuat, DVec3, Vec3};
use gltf_json::Index;
use gltf_json::scene::Node;

/// Where all nodes stand at rest.
pub(super) struct Scene {
    /// Node to world, one a node.
    pub world: Vec<DMat4>,
    /// Nodes of the scene, parents before children.
    pub nodes: Vec<usize>,
    /// Parent of each node.
    pub parents: Vec<Option<usize>>,
}

impl Scene {
    pub fn read(file: &File) -> Result<Self, GltfError> {
        let nodes = &file.root.nodes;
        let count = nodes.len();
        let inside = |from: String, index: usize| {
            if index < count { Ok(index) } else { Err(GltfError::Reference { from, kind: "node", index, count }) }
        };
        let mut parents = vec![None; count];
        for (parent, node) in nodes.iter().enumerate() {
            for child in node.children.iter().flatten() {
                let child = inside(format!("node {parent}"), child.value())?;
                if parents[child].replace(parent).is_some() {
                    return Err(GltfError::Tree { node: child });
                }
            }
        }
        let mut scene = Self { world: vec![DMat4::IDENTITY; count], nodes: Vec::new(), parents };
        let roots: Vec<usize> = (0..count).filter(|node| scene.parents[*node].is_none()).collect();
        let reached = scene.descend(nodes, &roots, true);
        if reached.len() < count {
            // Whatever no root leads to goes round in a circle.
            let mut seen = vec![false; count];
            for node in &reached {
                seen[*node] = true;
            }
            return Err(GltfError::Tree { node: seen.iter().position(|seen| !seen).unwrap_or_default() });
        }
        let default = file.root.scene.map_or(0, |scene| scene.value());
        scene.nodes = match file.root.scenes.get(default) {
            Some(default_scene) => {
                let tops = default_scene
                    .nodes
                    .iter()
                    .map(|node| inside(format!("scene {default}"), node.value()))
                    .collect::<Result<Vec<_>, _>>()?;
                scene.descend(nodes, &tops, false)
            }
            None if file.root.scenes.is_empty() => reached,
            None => {
                let count = file.root.scenes.len();
                let from = "the file's default".to_owned();
                return Err(GltfError::Reference { from, kind: "scene", index: default, count });
            }
        };
        Ok(scene)
    }

    /// All nodes at and below `tops`, parents first, in the order of the file; places them in the world where asked.
    fn descend(&mut self, nodes: &[Node], tops: &[usize], place: bool) -> Vec<usize> {
        let mut order = Vec::new();
        let mut seen = vec![false; nodes.len()];
        let mut open: Vec<usize> = tops.iter().rev().copied().collect();
        while let Some(node) = open.pop() {
            if std::mem::replace(&mut seen[node], true) {
                continue;
            }
            if place {
                let above = self.parents[node].map_or(DMat4::IDENTITY, |parent| self.world[parent]);
                self.world[node] = above * local(&nodes[node]);
            }
            order.push(node);
            open.extend(nodes[node].children.iter().flatten().rev().map(Index::value));
        }
        order
    }

    /// Whether `node` is `above` or stands below it.
    pub fn is_below(&self, node: usize, above: usize) -> bool {
        std::iter::successors(Some(node), |node| self.parents[*node]).any(|node| node == above)
    }
}

/// A node's own transform: its matrix, or translation · rotation · scale.
fn local(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |numbers: [f32; 3]| Vec3::from_array(numbers).as_dvec3();
    let scale = node.scale.map_or(DVec3::ONE, vector);
    let translation = node.translation.map_or(DVec3::ZERO, vector);
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |rotation| {
        let quaternion = DQuat::from_array(rotation.0.map(f64::from));
        if quaternion.length_squared() > 0.0 { quaternion.normalize() } else { DQuat::IDENTITY }
    });
    DMat4::from_scale_rotation_translation(scale, rotation, translation)
}
