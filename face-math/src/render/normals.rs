//! Smooth normals of a posed rig: averaged over triangles, and across the seams between parts.

use crate::data::Rig;
use glam::Vec3;

/// For each vertex the first vertex that stands at the same neutral place in a part of the same colour.
fn welds(rig: &Rig) -> Vec<u32> {
    let mut colour_of = vec![[0u32; 3]; rig.neutral.len()];
    for part in &rig.parts {
        for vertex in part.vertices.clone() {
            colour_of[vertex as usize] = part.colour.map(f32::to_bits);
        }
    }
    let key = |vertex: u32| {
        let p = rig.neutral[vertex as usize];
        ([p.x.to_bits(), p.y.to_bits(), p.z.to_bits()], colour_of[vertex as usize], vertex)
    };
    let mut order: Vec<u32> = (0..rig.neutral.len() as u32).collect();
    order.sort_unstable_by_key(|vertex| key(*vertex));
    let mut first = vec![0u32; order.len()];
    for (place, vertex) in order.iter().enumerate() {
        let same = place > 0 && {
            let (a, b) = (key(order[place - 1]), key(*vertex));
            (a.0, a.1) == (b.0, b.1)
        };
        first[*vertex as usize] = if same { first[order[place - 1] as usize] } else { *vertex };
    }
    first
}

/// Unit normals of `positions` (metres, one a vertex of the rig), weighted by triangle area; vertices that stand at
/// the same neutral place in parts of one colour share theirs, so that seams do not show.
///
/// A vertex without triangles gets +Z.
pub fn smooth_normals(rig: &Rig, positions: &[Vec3]) -> Vec<Vec3> {
    let welds = welds(rig);
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for [a, b, c] in rig.parts.iter().flat_map(|part| &part.triangles) {
        let [pa, pb, pc] = [a, b, c].map(|vertex| positions[*vertex as usize]);
        // The cross product of two edges is the normal times twice the area.
        let normal = (pb - pa).cross(pc - pa);
        for vertex in [a, b, c] {
            sums[welds[*vertex as usize] as usize] += normal;
        }
    }
    welds.iter().map(|weld| sums[*weld as usize].normalize_or(Vec3::Z)).collect()
}
