//! Polygons with texture coordinates of their own at each corner, as vertices and triangles.
//!
//! Vertices keep the order of the file within their part. Where a texture's seam runs through a vertex, the same place
//! is needed once for each side: the further sides follow after all of the part's own vertices. Polygons are cut into
//! triangles by clipping ears (Meisters, "Polygons have ears", 1975), so that hollow ones are covered once.

use face_math::data::Part;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::ops::Range;

/// Where a polygon meets a vertex of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    /// The vertex.
    pub vertex: u32,
    /// Its texture coordinates there, by index; `None` where the file gives none.
    pub uv: Option<u32>,
}

/// Polygons over vertices of a file. Whoever makes them has checked all indices.
#[derive(Debug, Default)]
pub(crate) struct Polygons {
    /// Corners of all polygons, one polygon after the other.
    pub corners: Vec<Corner>,
    /// Each polygon's corners, and the group it belongs to.
    pub faces: Vec<(Range<usize>, usize)>,
}

/// One group of polygons as a part.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Split {
    /// The group.
    pub group: usize,
    /// Vertex of the file that each vertex of the part is.
    pub vertices: Vec<u32>,
    /// The surface; without name, and with indices from the part's own first vertex.
    pub part: Part,
}

impl Polygons {
    /// The groups that hold polygons, in the order in which their first polygons stand.
    ///
    /// A vertex that several groups use is one of each of them. One that none uses stays with the group of the vertex
    /// before it, so that the file's own numbers hold within a group.
    pub fn split(&self, positions: &[DVec3], uvs: &[[f32; 2]]) -> Vec<Split> {
        let mut slots: BTreeMap<usize, usize> = BTreeMap::new();
        let mut faces: Vec<(usize, Vec<&Range<usize>>)> = Vec::new();
        for (corners, group) in &self.faces {
            let slot = *slots.entry(*group).or_insert_with(|| {
                faces.push((*group, Vec::new()));
                faces.len() - 1
            });
            faces[slot].1.push(corners);
        }
        let mut users: Vec<Vec<usize>> = vec![Vec::new(); positions.len()];
        for (slot, (_, faces)) in faces.iter().enumerate() {
            for corner in faces.iter().flat_map(|face| &self.corners[(*face).clone()]) {
                let users = &mut users[corner.vertex as usize];
                if users.last() != Some(&slot) {
                    users.push(slot);
                }
            }
        }
        let mut own: Vec<Vec<u32>> = vec![Vec::new(); faces.len()];
        let mut before = 0;
        for (vertex, users) in (0_u32..).zip(&users) {
            if users.is_empty() && before < own.len() {
                own[before].push(vertex);
            }
            for slot in users {
                own[*slot].push(vertex);
                before = users[0];
            }
        }
        let groups = faces.into_iter().zip(own);
        groups.map(|((group, faces), own)| self.part(group, &faces, own, positions, uvs)).collect()
    }

    fn part(
        &self,
        group: usize,
        faces: &[&Range<usize>],
        own: Vec<u32>,
        positions: &[DVec3],
        uvs: &[[f32; 2]],
    ) -> Split {
        let textured = faces.iter().flat_map(|face| &self.corners[(*face).clone()]).any(|corner| corner.uv.is_some());
        // Which texture coordinates each vertex of the part has; those of the part's own vertices are not known yet.
        let mut at: Vec<Option<Option<u32>>> = vec![None; own.len()];
        let mut sides: BTreeMap<(u32, Option<u32>), u32> = BTreeMap::new();
        let number: BTreeMap<u32, u32> = own.iter().copied().zip(0..).collect();
        let mut vertices = own;
        let mut triangles = Vec::new();
        for face in faces {
            let corners = &self.corners[(*face).clone()];
            let numbers: Vec<u32> = corners
                .iter()
                .map(|corner| {
                    let first = number[&corner.vertex];
                    let slot = &mut at[first as usize];
                    if *slot.get_or_insert(corner.uv) == corner.uv {
                        return first;
                    }
                    *sides.entry((corner.vertex, corner.uv)).or_insert_with(|| {
                        vertices.push(corner.vertex);
                        at.push(Some(corner.uv));
                        vertices.len() as u32 - 1
                    })
                })
                .collect();
            let points: Vec<DVec3> = corners.iter().map(|corner| positions[corner.vertex as usize]).collect();
            triangles.extend(triangulate(&points).into_iter().map(|ear| ear.map(|corner| numbers[corner])));
        }
        let uv_of = |side: &Option<Option<u32>>| side.flatten().map_or([0.0; 2], |uv| uvs[uv as usize]);
        let uvs = if textured { at.iter().map(uv_of).collect() } else { Vec::new() };
        let part = Part { name: String::new(), vertices: 0..0, triangles, uvs, colour: [1.0; 3] };
        Split { group, vertices, part }
    }
}

/// Cuts a polygon into triangles of its corners, with its own sense of turning. Convex ones are cut as a fan.
fn triangulate(points: &[DVec3]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..points.len()).collect();
    if points.len() < 4 {
        return if points.len() == 3 { vec![[0, 1, 2]] } else { Vec::new() };
    }
    let flat = flattened(points);
    let turn = |a: usize, b: usize, c: usize| (flat[b] - flat[a]).perp_dot(flat[c] - flat[a]);
    let mut triangles = Vec::with_capacity(points.len() - 2);
    while left.len() > 3 {
        let count = left.len();
        let corners = |at: usize| [left[at % count], left[(at + 1) % count], left[(at + 2) % count]];
        let is_ear = |[a, b, c]: [usize; 3]| {
            let covers = |p: usize| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            turn(a, b, c) > 0.0 && !left.iter().any(|p| ![a, b, c].contains(p) && covers(*p))
        };
        // A polygon that crosses itself may have no ear; it is cut as a fan.
        let ear = (0..count).find(|at| is_ear(corners(*at))).unwrap_or(0);
        triangles.push(corners(ear));
        left.remove((ear + 1) % count);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

/// The polygon seen along its normal, turning counter-clockwise: Newell's normal n = Σ pᵢ × pᵢ₊₁, and two axes across it.
fn flattened(points: &[DVec3]) -> Vec<DVec2> {
    let origin = points[0];
    let next = |at: usize| points[(at + 1) % points.len()] - origin;
    let normal: DVec3 = (0..points.len()).map(|at| (points[at] - origin).cross(next(at))).sum();
    let normal = normal.try_normalize().unwrap_or(DVec3::Z);
    let (across, up) = normal.any_orthonormal_pair();
    points.iter().map(|point| DVec2::new((point - origin).dot(across), (point - origin).dot(up))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn corner(vertex: u32, uv: u32) -> Corner {
        Corner { vertex, uv: Some(uv) }
    }

    #[test]
    fn seams_come_after_the_vertices_that_keep_their_numbers() {
        // Two squares side by side whose common edge has two places in the texture; vertex 6 belongs to no polygon.
        let corners = [(0, 0), (1, 1), (4, 2), (3, 3), (1, 4), (2, 5), (5, 6), (4, 7)];
        let polygons = Polygons {
            corners: corners.map(|(vertex, uv)| corner(vertex, uv)).to_vec(),
            faces: vec![(0..4, 0), (4..8, 0)],
        };
        let positions: Vec<DVec3> = (0..7).map(|v| DVec3::new(f64::from(v % 3), f64::from(v / 3), 0.0)).collect();
        let uvs: Vec<[f32; 2]> = (0..8_u8).map(|uv| [f32::from(uv), 0.5]).collect();
        let parts = polygons.split(&positions, &uvs);
        assert_eq!((parts.len(), parts[0].vertices.as_slice()), (1, &[0, 1, 2, 3, 4, 5, 6, 1, 4][..]));
        assert_eq!(parts[0].part.triangles, [[0, 1, 4], [0, 4, 3], [7, 2, 5], [7, 5, 8]]);
        assert_eq!((parts[0].part.uvs[1], parts[0].part.uvs[7]), ([1.0, 0.5], [4.0, 0.5]));
        let two = Polygons { faces: vec![(0..4, 3), (4..8, 1)], ..polygons };
        let parts = two.split(&positions, &uvs);
        assert_eq!((parts[0].group, parts[0].vertices.as_slice()), (3, &[0, 1, 3, 4][..]));
        assert_eq!((parts[1].group, parts[1].vertices.as_slice()), (1, &[1, 2, 4, 5, 6][..]));
    }

    #[test]
    fn a_hollow_polygon_is_covered_once() {
        // An arrow's head: the fan from its first corner would reach outside.
        let points = [(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (0.8, 1.0)].map(|(x, z)| DVec3::new(x, 0.0, z));
        for start in 0..4 {
            let turned: Vec<DVec3> = (0..4).map(|at| points[(at + start) % 4]).collect();
            let triangles = triangulate(&turned);
            let area = |[a, b, c]: [usize; 3]| (turned[b] - turned[a]).cross(turned[c] - turned[a]).y / 2.0;
            let areas: Vec<f64> = triangles.into_iter().map(area).collect();
            assert!(areas.iter().all(|area| *area < 0.0) && (areas.iter().sum::<f64>() + 1.2).abs() < 1e-12);
        }
    }

    proptest! {
        #[test]
        fn stars_are_covered_once(radii in prop::collection::vec(0.2_f64..2.0, 3..12)) {
            let step = std::f64::consts::TAU / radii.len() as f64;
            let points: Vec<DVec3> = radii.iter().enumerate()
                .map(|(at, r)| DVec3::new(r * (step * at as f64).cos(), r * (step * at as f64).sin(), 1.0)).collect();
            let cross = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).z;
            let whole: f64 = (0..points.len()).map(|at| {
                points[at].cross(points[(at + 1) % points.len()]).z
            }).sum();
            let areas: Vec<f64> = triangulate(&points).into_iter().map(|[a, b, c]| cross(points[a], points[b], points[c])).collect();
            prop_assert_eq!(areas.len(), points.len() - 2);
            prop_assert!(areas.iter().all(|area| *area > -1e-12));
            prop_assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-9);
        }
    }
}
