//! Strains: how much longer each muscle is than at rest, `γ_s = ℓ_s / ℓ_s⁰ − 1` (section 3 of Animatomy). Unitless; exactly 0 at
//! rest, because the same numbers are added in the same order. And how far vertices are from curves: d of section A.3.

use super::error::{StrainError, same};
use crate::data::{Curves, Meshes, MuscleCurve, Muscles};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// The strains of all muscles in every frame.
///
/// # Errors
/// Where the muscles were traced on another head, or a mesh has a vertex that is not finite.
pub fn measure_strains(muscles: &Muscles, meshes: &Meshes) -> Result<Curves, StrainError> {
    same("vertices of the meshes", muscles.vertices(), meshes.vertices())?;
    let frames: Vec<Vec<f32>> = (0..meshes.frames())
        .into_par_iter()
        .map(|frame| {
            let posed = meshes.frame(frame);
            let strain = |(index, curve): (usize, &crate::data::MuscleCurve)| {
                let strain = curve.length_m(posed) / curve.rest_length_m - 1.0;
                let number = meshes.frame_axis().slice(&(frame..frame + 1)).first;
                if strain.is_finite() {
                    Ok(strain as f32)
                } else {
                    Err(StrainError::NotFinite { what: "length of muscle", index, frame: number })
                }
            };
            muscles.curves().iter().enumerate().map(strain).collect::<Result<_, _>>()
        })
        .collect::<Result<_, StrainError>>()?;
    Ok(Curves::new(meshes.frame_axis(), muscles.names(), frames.concat())?)
}

/// d_{s,i} = distance of vertex i from curve s over `falloff_m`, not finite beyond `reach_m`: S numbers a vertex.
pub fn distance_penalties(muscles: &Muscles, neutral: &[Vec3], falloff_m: f64, reach_m: f64) -> Vec<f32> {
    let points = |curve: &MuscleCurve| -> Vec<DVec3> { curve.points.iter().map(|point| point.at(neutral)).collect() };
    let curves: Vec<Vec<Segment>> =
        muscles.curves().iter().map(|curve| points(curve).windows(2).map(Segment::new).collect()).collect();
    neutral
        .par_iter()
        .flat_map_iter(|vertex| {
            let vertex = vertex.as_dvec3();
            curves.iter().map(move |segments| {
                let nearest = segments.iter().map(|own| own.square_from(vertex)).fold(f64::INFINITY, f64::min).sqrt();
                if nearest > reach_m { f32::INFINITY } else { (nearest / falloff_m) as f32 }
            })
        })
        .collect()
}

/// A straight piece of a curve.
struct Segment {
    from: DVec3,
    edge: DVec3,
    /// 1 / ‖edge‖².
    inverse: f64,
}

impl Segment {
    fn new(ends: &[DVec3]) -> Self {
        let edge = ends[1] - ends[0];
        Self { from: ends[0], edge, inverse: 1.0 / edge.length_squared().max(f64::MIN_POSITIVE) }
    }

    /// Squared distance of a point.
    fn square_from(&self, point: DVec3) -> f64 {
        let arm = point - self.from;
        let along = (self.edge.dot(arm) * self.inverse).clamp(0.0, 1.0);
        (arm - along * self.edge).length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{MuscleCurve, RidingPoint};
    use crate::strain::toy;

    fn muscles() -> Muscles {
        let rig = toy::jointed_head();
        let point = |vertex: u32| RidingPoint { vertices: [vertex, 0, 1], weights: [0.9, 0.04, 0.06] };
        let mut curve =
            MuscleCurve { name: "m".into(), points: vec![point(3), point(12), point(29)], rest_length_m: 1.0 };
        curve.rest_length_m = curve.length_m(&rig.neutral);
        Muscles::new(vec![curve], rig.neutral.len()).unwrap()
    }

    #[test]
    fn rest_is_exactly_nought_and_twice_the_size_is_one() {
        let rig = toy::jointed_head();
        let twice = rig.neutral.iter().map(|point| *point * 2.0);
        let positions = rig.neutral.iter().copied().chain(twice).collect();
        let axis = wire::FrameAxis::new(2, 60.0);
        let meshes = Meshes::new(axis, rig.parts.clone(), rig.neutral.len(), positions).unwrap();
        let strains = measure_strains(&muscles(), &meshes).unwrap();
        assert_eq!(strains.frame(0), [0.0]);
        assert!((strains.frame(1)[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn vertices_on_the_curve_have_no_distance_and_far_ones_are_out_of_reach() {
        let rig = toy::jointed_head();
        let muscles = muscles();
        let distances = distance_penalties(&muscles, &rig.neutral, 0.01, 0.05);
        let brute = |vertex: usize| {
            let curve = &muscles.curves()[0];
            let places: Vec<DVec3> = curve.points.iter().map(|point| point.at(&rig.neutral)).collect();
            let steps =
                places.windows(2).flat_map(|pair| (0..=200).map(|step| pair[0].lerp(pair[1], f64::from(step) / 200.0)));
            steps.map(|place| place.distance(rig.neutral[vertex].as_dvec3())).fold(f64::INFINITY, f64::min)
        };
        for (vertex, distance) in distances.iter().enumerate() {
            let expected = brute(vertex);
            if expected > 0.0501 {
                assert!(distance.is_infinite());
            } else if expected < 0.0499 {
                assert!((f64::from(*distance) * 0.01 - expected).abs() < 2e-5, "{vertex}");
            }
        }
    }
}
