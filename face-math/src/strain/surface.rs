//! Shortest paths on the surface of a head: what muscles are laid along.
//!
//! A path is searched from point to point over the edges (A* on five points of every edge, joined within triangles: Lanthier,
//! Maheshwari and Sack, "Approximating shortest paths on weighted polyhedral surfaces", Algorithmica 30, 2001), then drawn
//! tight in the strip of triangles it has found. There each point is moved along its edge to where the path through it is
//! straight once both triangles lie in one plane: with feet f₁, f₂ of its neighbours on the edge's line and their distances
//! h₁, h₂ from it, t = (f₁ h₂ + f₂ h₁) / (h₁ + h₂). Length is convex in all t together, so this ends at the strip's least.
//!
//! Vertices at one place are one: seams of the texture are no cuts.

use crate::data::{Part, RidingPoint};
use crate::rig::closest_on_triangle;
use glam::{DVec3, Vec3};
use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

/// Where along an edge its points lie.
const ALONG: [f64; 5] = [0.04, 0.27, 0.5, 0.73, 0.96];

/// A surface made ready for paths.
#[derive(Debug)]
pub struct Surface {
    /// Positions of all vertices of the rig, in metres.
    positions: Vec<DVec3>,
    /// Triangles, with vertices at one place made one.
    triangles: Vec<[u32; 3]>,
    /// The three edges of each triangle.
    edges_of: Vec<[u32; 3]>,
    /// Both ends of each edge.
    ends: Vec<[u32; 2]>,
    /// The triangles at each edge: more than two where the surface branches.
    beside: Vec<Vec<u32>>,
    /// The triangles at each vertex.
    around: BTreeMap<u32, Vec<u32>>,
}

/// A point of a path.
#[derive(Debug, Clone, Copy)]
enum Step {
    Fixed(RidingPoint, DVec3),
    Crossing { edge: u32, along: f64 },
}

impl Surface {
    /// The surface of some parts of a head, whose vertices stand at `positions`.
    pub fn new<'p>(positions: &[Vec3], parts: impl IntoIterator<Item = &'p Part>) -> Self {
        let mut at_place: BTreeMap<[u32; 3], u32> = BTreeMap::new();
        let mut surface = Self {
            positions: positions.iter().map(|position| position.as_dvec3()).collect(),
            triangles: Vec::new(),
            edges_of: Vec::new(),
            ends: Vec::new(),
            beside: Vec::new(),
            around: BTreeMap::new(),
        };
        let mut edge_at: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for triangle in parts.into_iter().flat_map(|part| &part.triangles) {
            let own = triangle.map(|vertex| {
                let place = positions[vertex as usize].to_array().map(f32::to_bits);
                *at_place.entry(place).or_insert(vertex)
            });
            if own[0] == own[1] || own[1] == own[2] || own[2] == own[0] {
                continue;
            }
            let number = surface.triangles.len() as u32;
            surface.triangles.push(own);
            surface.edges_of.push([(0, 1), (1, 2), (2, 0)].map(|(a, b)| {
                let ends = [own[a].min(own[b]), own[a].max(own[b])];
                let edge = *edge_at.entry(ends).or_insert_with(|| {
                    surface.ends.push(ends);
                    surface.beside.push(Vec::new());
                    surface.ends.len() as u32 - 1
                });
                surface.beside[edge as usize].push(number);
                edge
            }));
            for vertex in own {
                surface.around.entry(vertex).or_default().push(number);
            }
        }
        surface
    }

    /// The point of the surface nearest to `point` (metres); none where there are no triangles.
    pub fn nearest(&self, point: DVec3) -> Option<RidingPoint> {
        let mut best: Option<(f64, RidingPoint)> = None;
        for triangle in &self.triangles {
            let corners = triangle.map(|vertex| self.positions[vertex as usize]);
            // A triangle that is farther than its own size plus the best found cannot be nearer.
            let reach = corners[0].distance(corners[1]).max(corners[0].distance(corners[2]));
            if best.is_some_and(|(far, _)| corners[0].distance(point) - reach > far) {
                continue;
            }
            let found = closest_on_triangle(point, corners);
            if best.is_none_or(|(far, _)| found.distance_m < far) {
                let weights = found.weights.map(|weight| weight as f32);
                best = Some((found.distance_m, RidingPoint { vertices: *triangle, weights }));
            }
        }
        best.map(|(_, point)| point)
    }

    fn place(&self, point: &RidingPoint) -> DVec3 {
        let corners = point.vertices.iter().zip(point.weights);
        corners.map(|(vertex, weight)| f64::from(weight) * self.positions[*vertex as usize]).sum()
    }

    fn crossing(&self, edge: u32, along: f64) -> DVec3 {
        let [a, b] = self.ends[edge as usize].map(|vertex| self.positions[vertex as usize]);
        a.lerp(b, along)
    }

    /// The triangles that a point lies in: all around a vertex where it is one.
    fn touching(&self, point: &RidingPoint) -> Vec<u32> {
        let held: Vec<u32> = point
            .vertices
            .iter()
            .zip(point.weights)
            .filter(|(_, weight)| *weight > 1e-4)
            .map(|(vertex, _)| *vertex)
            .collect();
        let has = |triangle: &&u32| held.iter().all(|vertex| self.triangles[**triangle as usize].contains(vertex));
        let around = held.first().and_then(|vertex| self.around.get(vertex));
        around.map_or(Vec::new(), |around| around.iter().filter(has).copied().collect())
    }

    /// The shortest path between two points of the surface, both among its points; none where they lie on pieces that
    /// do not hang together.
    pub fn path(&self, from: &RidingPoint, to: &RidingPoint) -> Option<Vec<RidingPoint>> {
        let (start, goal) = (self.place(from), self.place(to));
        let mut steps = vec![Step::Fixed(*from, start)];
        steps.extend(self.search(from, to)?.into_iter().map(|(edge, along)| Step::Crossing { edge, along }));
        steps.push(Step::Fixed(*to, goal));
        self.tighten(&mut steps);
        let mut points: Vec<(RidingPoint, DVec3)> = Vec::with_capacity(steps.len());
        for step in &steps {
            let (point, place) = match step {
                Step::Fixed(point, place) => (*point, *place),
                Step::Crossing { edge, along } => (self.riding(*edge, *along), self.crossing(*edge, *along)),
            };
            let doubled = points.last().is_some_and(|(_, last)| last.distance(place) < 1e-7);
            let is_goal = matches!(step, Step::Fixed(..));
            if doubled && is_goal && points.len() > 1 {
                points.pop();
            }
            if !doubled || is_goal {
                points.push((point, place));
            }
        }
        Some(points.into_iter().map(|(point, _)| point).collect())
    }

    fn riding(&self, edge: u32, along: f64) -> RidingPoint {
        let [a, b] = self.ends[edge as usize];
        let triangle = self.triangles[self.beside[edge as usize][0] as usize];
        let third = triangle.into_iter().find(|vertex| *vertex != a && *vertex != b).unwrap_or(a);
        RidingPoint { vertices: [a, b, third], weights: [(1.0 - along) as f32, along as f32, 0.0] }
    }

    /// A*: crossings of the shortest way over the points of edges.
    fn search(&self, from: &RidingPoint, to: &RidingPoint) -> Option<Vec<(u32, f64)>> {
        let (start, goal) = (self.place(from), self.place(to));
        let (first, last) = (self.touching(from), self.touching(to));
        if first.iter().any(|triangle| last.contains(triangle)) {
            return Some(Vec::new());
        }
        let count = ALONG.len();
        let mut known: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
        let mut open = BinaryHeap::new();
        let mut best: Option<(f64, usize)> = None;
        let nodes = |triangle: u32| {
            let edges = self.edges_of[triangle as usize];
            edges.into_iter().flat_map(move |edge| (0..count).map(move |place| edge as usize * count + place))
        };
        let at = |node: usize| self.crossing((node / count) as u32, ALONG[node % count]);
        let mut visit = |open: &mut BinaryHeap<Open>, node: usize, length: f64, before: usize| {
            if known.get(&node).is_none_or(|(old, _)| length < *old) {
                known.insert(node, (length, before));
                open.push(Open { guess: length + at(node).distance(goal), length, node });
            }
        };
        for triangle in &first {
            for node in nodes(*triangle) {
                visit(&mut open, node, start.distance(at(node)), usize::MAX);
            }
        }
        while let Some(Open { guess, length, node }) = open.pop() {
            if best.is_some_and(|(found, _)| guess >= found) {
                break;
            }
            let here = at(node);
            for triangle in &self.beside[node / count] {
                if last.contains(triangle) {
                    let whole = length + here.distance(goal);
                    if best.is_none_or(|(found, _)| whole < found) {
                        best = Some((whole, node));
                    }
                }
                for next in nodes(*triangle) {
                    if next / count != node / count {
                        visit(&mut open, next, length + here.distance(at(next)), node);
                    }
                }
            }
        }
        let mut node = best?.1;
        let mut path = Vec::new();
        while node != usize::MAX {
            path.push(((node / count) as u32, ALONG[node % count]));
            node = known.get(&node)?.1;
        }
        path.reverse();
        Some(path)
    }

    /// Draws a path tight within its strip of triangles.
    fn tighten(&self, steps: &mut [Step]) {
        let place = |step: &Step| match step {
            Step::Fixed(_, place) => *place,
            Step::Crossing { edge, along } => self.crossing(*edge, *along),
        };
        for _ in 0..500 {
            let mut moved = 0.0_f64;
            for at in 1..steps.len().saturating_sub(1) {
                let (before, after) = (place(&steps[at - 1]), place(&steps[at + 1]));
                if let Step::Crossing { edge, along } = &mut steps[at] {
                    let [a, b] = self.ends[*edge as usize].map(|vertex| self.positions[vertex as usize]);
                    let direction = (b - a).normalize_or_zero();
                    let foot = |point: DVec3| (point - a).dot(direction);
                    let far = |point: DVec3| (point - a - foot(point) * direction).length();
                    let (f1, f2, h1, h2) = (foot(before), foot(after), far(before), far(after));
                    let length = a.distance(b);
                    let t = if h1 + h2 > 1e-12 { (f1 * h2 + f2 * h1) / (h1 + h2) } else { 0.5 * (f1 + f2) };
                    let t = (t / length).clamp(0.0, 1.0);
                    moved = moved.max((t - *along).abs() * length);
                    *along = t;
                }
            }
            if moved < 1e-9 {
                break;
            }
        }
    }
}

/// A point to go on from, the nearest to the goal first.
#[derive(Debug, PartialEq)]
struct Open {
    guess: f64,
    length: f64,
    node: usize,
}

impl Eq for Open {}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        other.guess.total_cmp(&self.guess).then_with(|| other.node.cmp(&self.node))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
#[path = "surface_tests.rs"]
mod tests;
