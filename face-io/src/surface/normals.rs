//! Normals of a surface at rest, for formats that want them.

use glam::Vec3;
use std::collections::BTreeMap;

/// Normals of vertices: the sum of the normals of the triangles around, each as long as the triangle is large, of
/// length 1. Vertices in one place (split along a texture's seam) share theirs; where there is none it is +Z.
pub(crate) fn normals(positions: &[Vec3], corners: &[u32]) -> Vec<Vec3> {
    let place = |point: Vec3| point.to_array().map(f32::to_bits);
    let mut sums: BTreeMap<[u32; 3], Vec3> = BTreeMap::new();
    for triangle in corners.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|corner| positions[triangle[corner] as usize]);
        let normal = (b - a).cross(c - a);
        for corner in [a, b, c] {
            *sums.entry(place(corner)).or_default() += normal;
        }
    }
    positions
        .iter()
        .map(|point| {
            let sum = sums.get(&place(*point)).copied().unwrap_or_default();
            // Triangles of a head are so small that their areas want lifting before they are normalised.
            (sum * 1e6).try_normalize().unwrap_or(Vec3::Z)
        })
        .collect()
}
