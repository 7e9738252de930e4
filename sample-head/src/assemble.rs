//! Puts the head together: skin and pieces become one rig in metres, motions become its shapes.

use crate::channels::{CHANNELS, COMBINATIONS, IN_BETWEENS};
use crate::features::Features;
use crate::jaw;
use crate::motion::{Motion, Mover};
use crate::piece::{Follow, Piece};
use crate::skin::Skin;
use face_math::data::{Driver, Part, Rig, Shape};
use glam::Vec3;
use std::collections::BTreeMap;

/// Displacements below this are nothing, in metres.
const STILL_M: f32 = 2e-7;

/// Where each of the rig's vertices comes from.
enum Source {
    Skin(u32),
    Piece(usize, u32),
}

/// A rig being put together.
pub struct Assembly {
    /// The rig, without shapes until [`Assembly::add_shapes`].
    pub rig: Rig,
    /// For each vertex of the skin, its vertex in the rig.
    pub of_skin: Vec<u32>,
    sources: Vec<Source>,
    metres: f32,
}

/// Whether a triangle belongs to the face rather than to the head and neck.
fn in_face(skin: &Skin, corners: &[u32; 3]) -> bool {
    corners.iter().all(|vertex| {
        let point = &skin.points[*vertex as usize];
        point.u.abs() < 106.0 && (-106.0..=108.0).contains(&point.v)
    })
}

impl Assembly {
    /// Lays out all parts: the skin as `face` and `head_neck`, then the pieces.
    pub fn new(name: &str, features: &Features, skin: &Skin, pieces: &[Piece]) -> Self {
        let metres = features.identity.scale * 1e-3;
        let mut assembly = Self {
            rig: Rig {
                name: name.to_owned(),
                parts: Vec::new(),
                neutral: Vec::new(),
                channels: CHANNELS.iter().map(|channel| (*channel).to_owned()).collect(),
                shapes: Vec::new(),
                skin: Vec::new(),
                jaw_pivot_m: Some(jaw::PIVOT * metres),
                jaw: None,
                joints: Vec::new(),
            },
            of_skin: vec![u32::MAX; skin.points.len()],
            sources: Vec::new(),
            metres,
        };
        let (face, rest): (Vec<_>, Vec<_>) = skin.triangles.iter().partition(|corners| in_face(skin, corners));
        let colour = features.identity.colours.skin;
        assembly.add_skin("face", colour, skin, &face);
        assembly.add_skin("head_neck", colour, skin, &rest);
        for (index, piece) in pieces.iter().enumerate() {
            assembly.add_piece(index, piece);
        }
        assembly
    }

    fn add_skin(&mut self, name: &str, colour: [f32; 3], skin: &Skin, triangles: &[&[u32; 3]]) {
        let start = self.sources.len() as u32;
        let mut place = BTreeMap::new();
        for vertex in triangles.iter().flat_map(|corners| corners.iter()) {
            place.insert(*vertex, 0);
        }
        let mut uvs = Vec::new();
        for (offset, (vertex, own)) in place.iter_mut().enumerate() {
            *own = start + offset as u32;
            let point = &skin.points[*vertex as usize];
            self.rig.neutral.push(point.at * self.metres);
            self.sources.push(Source::Skin(*vertex));
            uvs.push(point.uv);
            let known = &mut self.of_skin[*vertex as usize];
            *known = (*known).min(*own);
        }
        let triangles = triangles.iter().map(|corners| corners.map(|vertex| place[&vertex])).collect();
        let vertices = start..self.sources.len() as u32;
        self.rig.parts.push(Part { name: name.to_owned(), vertices, triangles, uvs, colour });
    }

    fn add_piece(&mut self, index: usize, piece: &Piece) {
        let start = self.sources.len() as u32;
        self.rig.neutral.extend(piece.points.iter().map(|point| *point * self.metres));
        self.sources.extend((0..piece.points.len() as u32).map(|vertex| Source::Piece(index, vertex)));
        self.rig.parts.push(Part {
            name: piece.name.to_owned(),
            vertices: start..self.sources.len() as u32,
            triangles: piece.triangles.iter().map(|corners| corners.map(|vertex| vertex + start)).collect(),
            uvs: piece.uvs.clone(),
            colour: piece.colour,
        });
    }

    /// Adds the jaw's shares and all shapes.
    pub fn add_shapes(&mut self, mover: &Mover<'_>, features: &Features, pieces: &[Piece]) {
        let share = |source: &Source| match source {
            Source::Skin(vertex) => mover.jaw_share[*vertex as usize],
            Source::Piece(piece, vertex) => match &pieces[*piece].follow {
                Follow::Jaw(shares) => shares[*vertex as usize],
                Follow::Eye(_) => 0.0,
                Follow::Lining(shares) => {
                    let (own, skin, jaw) = shares[*vertex as usize];
                    mover.jaw_share[own as usize] * skin + jaw
                }
                Follow::Skin(weights) => {
                    weights[*vertex as usize].iter().map(|(own, weight)| mover.jaw_share[*own as usize] * weight).sum()
                }
            },
        };
        self.rig.skin = self.sources.iter().map(share).collect();
        let index = |name: &str| CHANNELS.iter().position(|channel| *channel == name).unwrap_or_default() as u32;
        for name in CHANNELS.iter().chain(&COMBINATIONS).chain(&IN_BETWEENS) {
            let driver = if let Some((channel, peak)) = name.split_once('@') {
                Driver::InBetween { channel: index(channel), peak: peak.parse().unwrap_or(0.5) }
            } else if name.contains('+') {
                Driver::Combination(name.split('+').map(index).collect())
            } else {
                Driver::Channel(index(name))
            };
            let shape = self.shape(name, driver, &mover.motion(name), features, pieces);
            self.rig.shapes.push(shape);
        }
    }

    fn shape(&self, name: &str, driver: Driver, motion: &Motion, features: &Features, pieces: &[Piece]) -> Shape {
        let (mut vertices, mut deltas) = (Vec::new(), Vec::new());
        for (vertex, source) in self.sources.iter().enumerate() {
            let delta = self.metres
                * match source {
                    Source::Skin(own) => motion.skin[*own as usize],
                    Source::Piece(piece, own) => {
                        let own = *own as usize;
                        let at = pieces[*piece].points[own];
                        match &pieces[*piece].follow {
                            Follow::Jaw(shares) => motion.jaw.map_or(Vec3::ZERO, |jaw| jaw.delta(at) * shares[own]),
                            Follow::Eye(eye) => motion.eyes[*eye].map_or(Vec3::ZERO, |turn| {
                                let side = if *eye == 0 { 1.0 } else { -1.0 };
                                let centre = features.eye * Vec3::new(side, 1.0, 1.0);
                                centre + turn * (at - centre) - at
                            }),
                            Follow::Lining(shares) => {
                                let (near, skin, share) = shares[own];
                                motion.skin[near as usize] * skin
                                    + motion.jaw.map_or(Vec3::ZERO, |jaw| jaw.delta(at) * share)
                            }
                            Follow::Skin(weights) => {
                                weights[own].iter().map(|(skin, w)| motion.skin[*skin as usize] * *w).sum()
                            }
                        }
                    }
                };
            if delta.abs().max_element() > STILL_M {
                vertices.push(vertex as u32);
                deltas.push(delta);
            }
        }
        Shape { name: name.to_owned(), driver, vertices, deltas }
    }
}
