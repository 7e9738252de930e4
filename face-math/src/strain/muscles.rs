//! Lays muscles on a head: from a plan (origins, waypoints, insertions by landmarks) to curves that ride on the surface.
//!
//! A muscle is a sheet of fibres: its origin is a line of one or more places, and so are its waypoints and its insertion. The
//! k-th of n fibres takes from each line the place at k/(n − 1) of its way. Muscles are written for the performer's left;
//! those of both sides are mirrored by the landmarks that mirror each other.

use super::error::StrainError;
use super::surface::Surface;
use crate::data::{Attachment, MuscleCurve, Muscles, Part, RidingPoint, Rig};
use glam::DVec3;
use rayon::prelude::*;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The muscles that a head is to have.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MusclePlan {
    /// In the order of the strains.
    pub muscles: Vec<PlannedMuscle>,
}

/// One muscle of a plan.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedMuscle {
    /// Its name; fibres add their number and side (`frontalis_2_L`).
    pub name: String,
    /// Number of fibres (a side).
    #[serde(default = "one")]
    pub fibres: usize,
    /// Whether there is one on each side; otherwise it lies in the middle.
    #[serde(default)]
    pub both_sides: bool,
    /// Line of places where fibres begin.
    pub origin: Vec<Place>,
    /// Lines of places that fibres pass through, in their order.
    #[serde(default)]
    pub waypoints: Vec<Vec<Place>>,
    /// Line of places where fibres end.
    pub insertion: Vec<Place>,
}

fn one() -> usize {
    1
}

/// A place on the head; the surface's point nearest to it is meant.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub enum Place {
    /// A landmark, by its number among the 68 of Multi-PIE.
    #[serde(rename = "landmark")]
    Landmark(u32),
    /// A sum of landmarks by shares, which are divided by their sum; shares below 0 lead away from a landmark.
    #[serde(rename = "mix")]
    Mix(BTreeMap<u32, f64>),
    /// A vertex of a part.
    #[serde(rename = "vertex")]
    Vertex {
        /// The part.
        part: String,
        /// The vertex, counted within the part.
        vertex: u32,
    },
    /// A place in a part's texture.
    #[serde(rename = "uv")]
    Uv {
        /// The part.
        part: String,
        /// To the right, 0 to 1.
        u: f32,
        /// Down, 0 to 1.
        v: f32,
    },
}

/// The landmark that mirrors a landmark of Multi-PIE's 68.
pub fn mirrored_landmark(landmark: u32) -> u32 {
    match landmark {
        0..=16 => 16 - landmark,
        17..=26 => 43 - landmark,
        31..=35 => 66 - landmark,
        36..=39 | 42..=45 => 81 - landmark,
        40 | 41 | 46 | 47 => 87 - landmark,
        48..=54 => 102 - landmark,
        55..=59 => 114 - landmark,
        60..=64 => 124 - landmark,
        65..=67 => 132 - landmark,
        _ => landmark,
    }
}

/// Traces the muscles of a plan on the neutral surface of `rig`, over the parts `parts`. Landmarks are the points
/// `landmark_00` to `landmark_67` of `landmarks`.
///
/// # Errors
/// Where a landmark, part or vertex is not there, places coincide, or the surface does not hang together between two.
pub fn trace_muscles(
    rig: &Rig,
    parts: &[&Part],
    landmarks: &Attachment,
    plan: &MusclePlan,
) -> Result<Muscles, StrainError> {
    let tracer = Tracer { rig, surface: Surface::new(&rig.neutral, parts.iter().copied()), landmarks };
    let mut fibres = Vec::new();
    for muscle in &plan.muscles {
        if muscle.fibres == 0 {
            return Err(wrong(&muscle.name, "has no fibres; give it one or more"));
        }
        let sides: &[(bool, &str)] = if muscle.both_sides { &[(false, "_L"), (true, "_R")] } else { &[(false, "")] };
        for fibre in 0..muscle.fibres {
            for (mirrored, side) in sides {
                let number = if muscle.fibres > 1 { format!("_{}", fibre + 1) } else { String::new() };
                fibres.push((muscle, fibre, *mirrored, format!("{}{number}{side}", muscle.name)));
            }
        }
    }
    let curves =
        fibres.into_par_iter().map(|(muscle, fibre, mirrored, name)| tracer.fibre(muscle, fibre, mirrored, name));
    Ok(Muscles::new(curves.collect::<Result<_, _>>()?, rig.neutral.len())?)
}

struct Tracer<'a> {
    rig: &'a Rig,
    surface: Surface,
    landmarks: &'a Attachment,
}

fn wrong(muscle: &str, problem: impl Into<String>) -> StrainError {
    StrainError::Muscle { muscle: muscle.to_owned(), problem: problem.into() }
}

impl Tracer<'_> {
    fn fibre(
        &self,
        muscle: &PlannedMuscle,
        fibre: usize,
        mirrored: bool,
        name: String,
    ) -> Result<MuscleCurve, StrainError> {
        let share = if muscle.fibres > 1 { fibre as f64 / (muscle.fibres - 1) as f64 } else { 0.5 };
        let lines = std::iter::once(&muscle.origin).chain(&muscle.waypoints).chain(std::iter::once(&muscle.insertion));
        let mut stops: Vec<RidingPoint> = Vec::new();
        for line in lines {
            let places = line.iter().map(|place| self.place(&name, place, mirrored)).collect::<Result<Vec<_>, _>>()?;
            let at =
                along(&places, share).ok_or_else(|| wrong(&name, "has a line without a place; name one at least"))?;
            stops.push(self.surface.nearest(at).ok_or_else(|| wrong(&name, "finds no surface; name parts with skin"))?);
        }
        let mut points: Vec<RidingPoint> = vec![stops[0]];
        for pair in stops.windows(2) {
            let path = self.surface.path(&pair[0], &pair[1]);
            let path = path.ok_or_else(|| {
                wrong(&name, "runs between places that no surface joins; move them, or add a part between")
            })?;
            points.extend(path.into_iter().skip(1));
        }
        let mut curve = MuscleCurve { name, points, rest_length_m: 1.0 };
        curve.rest_length_m = curve.length_m(&self.rig.neutral);
        if curve.rest_length_m < 1e-4 {
            return Err(wrong(&curve.name, "is shorter than 0.1 mm; its origin and insertion are one place"));
        }
        Ok(curve)
    }

    fn landmark(&self, muscle: &str, landmark: u32, mirrored: bool) -> Result<DVec3, StrainError> {
        let own = if mirrored { mirrored_landmark(landmark) } else { landmark };
        let name = format!("landmark_{own:02}");
        let point = self.landmarks.points.iter().find(|point| point.name == name);
        let point = point.ok_or_else(|| wrong(muscle, format!("asks for `{name}`, which the landmarks lack")))?;
        let riding = RidingPoint { vertices: point.vertices, weights: point.weights };
        match riding.vertices.iter().find(|vertex| **vertex as usize >= self.rig.neutral.len()) {
            Some(vertex) => Err(wrong(muscle, format!("`{name}` sits on vertex {vertex}, which the head lacks"))),
            None => Ok(riding.at(&self.rig.neutral)),
        }
    }

    /// Where a place is, in metres.
    fn place(&self, muscle: &str, place: &Place, mirrored: bool) -> Result<DVec3, StrainError> {
        let part = |name: &str| {
            self.rig
                .part(name)
                .ok_or_else(|| wrong(muscle, format!("asks for the part `{name}`, which the head lacks")))
        };
        let flip = |point: DVec3| if mirrored { point * DVec3::new(-1.0, 1.0, 1.0) } else { point };
        match place {
            Place::Landmark(landmark) => self.landmark(muscle, *landmark, mirrored),
            Place::Mix(shares) => {
                let total: f64 = shares.values().sum();
                if total.abs() < 1e-6 {
                    return Err(wrong(muscle, "has a mix whose shares sum to 0; let them sum to 1"));
                }
                let mut sum = DVec3::ZERO;
                for (landmark, share) in shares {
                    sum += *share / total * self.landmark(muscle, *landmark, mirrored)?;
                }
                Ok(sum)
            }
            Place::Vertex { part: name, vertex } => {
                let range = &part(name)?.vertices;
                let own = range.start + vertex;
                if own >= range.end {
                    return Err(wrong(
                        muscle,
                        format!("asks for vertex {vertex} of `{name}`, which has {}", range.len()),
                    ));
                }
                Ok(flip(self.rig.neutral[own as usize].as_dvec3()))
            }
            Place::Uv { part: name, u, v } => self.uv(muscle, part(name)?, [*u, *v]).map(flip),
        }
    }

    fn uv(&self, muscle: &str, part: &Part, [u, v]: [f32; 2]) -> Result<DVec3, StrainError> {
        let flat = |vertex: u32| {
            let [u, v] = part.uvs.get((vertex - part.vertices.start) as usize).copied().unwrap_or_default();
            DVec3::new(f64::from(u), f64::from(v), 0.0)
        };
        if part.uvs.is_empty() {
            return Err(wrong(muscle, format!("asks for a place in the texture of `{}`, which has none", part.name)));
        }
        let wanted = DVec3::new(f64::from(u), f64::from(v), 0.0);
        let found = part
            .triangles
            .iter()
            .map(|triangle| (triangle, crate::rig::closest_on_triangle(wanted, triangle.map(flat))));
        let nearest = found.min_by(|(_, a), (_, b)| a.distance_m.total_cmp(&b.distance_m));
        let (triangle, point) =
            nearest.ok_or_else(|| wrong(muscle, format!("part `{}` has no triangles", part.name)))?;
        Ok(triangle
            .iter()
            .zip(point.weights)
            .map(|(vertex, weight)| weight * self.rig.neutral[*vertex as usize].as_dvec3())
            .sum())
    }
}

/// The place at a share of the way along a line of places, which are taken to be evenly spaced.
fn along(places: &[DVec3], share: f64) -> Option<DVec3> {
    let at = share * (places.len().checked_sub(1)?) as f64;
    let from = (at.floor() as usize).min(places.len() - 1);
    let to = (from + 1).min(places.len() - 1);
    Some(places[from].lerp(places[to], at - from as f64))
}

/// Fewer muscles of a head, spread over it: starting with the first, always the one farthest from those chosen (Gonzalez 1985),
/// by the middles of the curves. In their own order.
///
/// # Errors
/// Never for muscles that are valid themselves.
pub fn spread_muscles(muscles: &Muscles, neutral: &[glam::Vec3], count: usize) -> Result<Muscles, StrainError> {
    let middles: Vec<DVec3> = muscles
        .curves()
        .iter()
        .map(|curve| curve.points.iter().map(|point| point.at(neutral)).sum::<DVec3>() / curve.points.len() as f64)
        .collect();
    let mut far = vec![f64::INFINITY; middles.len()];
    let mut chosen = Vec::new();
    let mut next = 0;
    while chosen.len() < count.min(middles.len()) {
        chosen.push(next);
        for (far, middle) in far.iter_mut().zip(&middles) {
            *far = far.min(middle.distance(middles[next]));
        }
        far[next] = -1.0;
        next = (0..far.len()).fold(0, |best, place| if far[place] > far[best] { place } else { best });
    }
    chosen.sort_unstable();
    let kept = chosen.into_iter().map(|place| muscles.curves()[place].clone()).collect();
    Ok(Muscles::new(kept, muscles.vertices())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::SurfacePoint;
    use crate::strain::toy;

    fn landmarks(rig: &Rig) -> Attachment {
        let at = |number: u32, vertex: u32| SurfacePoint {
            name: format!("landmark_{number:02}"),
            vertices: *rig.parts[0].triangles.iter().find(|triangle| triangle[0] == vertex).unwrap(),
            weights: [1.0, 0.0, 0.0],
            distance_m: 0.0,
        };
        Attachment { points: vec![at(22, 46), at(21, 41), at(54, 14), at(48, 9), at(8, 4)] }
    }

    fn plan(text: &str) -> MusclePlan {
        ron::from_str(text).unwrap()
    }

    #[test]
    fn sheets_have_fibres_and_sides_mirror() {
        let rig = toy::jointed_head();
        let plan = plan(
            "(muscles: [
                (name: \"zygomaticus\", fibres: 3, both_sides: true, origin: [landmark(22), mix({22: 0.5, 21: 0.5})],
                 waypoints: [[mix({22: 0.4, 54: 0.6})]], insertion: [landmark(54)]),
                (name: \"mentalis\", origin: [landmark(8)], insertion: [mix({54: 0.5, 48: 0.5})]),
            ])",
        );
        let muscles = trace_muscles(&rig, &[&rig.parts[0]], &landmarks(&rig), &plan).unwrap();
        let names = muscles.names();
        assert_eq!(names[..3], ["zygomaticus_1_L", "zygomaticus_1_R", "zygomaticus_2_L"]);
        assert_eq!(names[6], "mentalis");
        let length = |at: usize| muscles.curves()[at].rest_length_m;
        assert!((length(0) / length(1) - 1.0).abs() < 0.1, "{} {}", length(0), length(1));
        for curve in muscles.curves() {
            let straight = curve.points[0].at(&rig.neutral).distance(curve.points.last().unwrap().at(&rig.neutral));
            assert!(curve.rest_length_m >= straight * (1.0 - 1e-9));
            assert!(curve.length_m(&rig.neutral) / curve.rest_length_m - 1.0 == 0.0);
        }
        assert_eq!(spread_muscles(&muscles, &rig.neutral, 3).unwrap().curves().len(), 3);
    }

    #[test]
    fn what_is_missing_is_named() {
        let rig = toy::jointed_head();
        let error =
            |text: &str| trace_muscles(&rig, &[&rig.parts[0]], &landmarks(&rig), &plan(text)).unwrap_err().to_string();
        let one = |place: &str| format!("(muscles: [(name: \"m\", origin: [{place}], insertion: [landmark(8)])])");
        assert!(error(&one("landmark(33)")).contains("muscle `m`: asks for `landmark_33`"));
        assert!(error(&one("landmark(8)")).contains("one place"));
        assert!(error(&one("mix({22: 1.0, 21: -1.0})")).contains("sum to 0"));
        assert!(error(&one("vertex(part: \"face\", vertex: 99)")).contains("which has 64"));
        assert!(error(&one("uv(part: \"face\", u: 0.5, v: 0.5)")).contains("which has none"));
    }

    #[test]
    fn landmarks_mirror_twice_to_themselves() {
        for landmark in 0..68 {
            assert_eq!(mirrored_landmark(mirrored_landmark(landmark)), landmark);
        }
        assert_eq!(mirrored_landmark(22), 21);
        assert_eq!(mirrored_landmark(42), 39);
    }
}
