//! Muscles: named curves on the surface of a head, whose stretching drives a strain rig.

use super::{DataError, check_unique};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use wire::{Data, DecodeError, Decoder, Encoder, Rows, Table, Tolerance, Value, ValueKind};

/// A point that rides on the surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RidingPoint {
    /// The three vertices of its triangle.
    pub vertices: [u32; 3],
    /// Their barycentric weights, which sum to 1.
    pub weights: [f32; 3],
}

impl RidingPoint {
    /// Where the point is, in metres, when the vertices are at `positions`.
    pub fn at(&self, positions: &[Vec3]) -> DVec3 {
        let corners = self.vertices.iter().zip(self.weights);
        corners.map(|(vertex, weight)| f64::from(weight) * positions[*vertex as usize].as_dvec3()).sum()
    }
}

/// One muscle fibre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MuscleCurve {
    /// Its name, such as `zygomaticus_major_2_L`; the channel that it drives.
    pub name: String,
    /// Its points from origin to insertion, two at least.
    pub points: Vec<RidingPoint>,
    /// Its length on the neutral head, in metres.
    pub rest_length_m: f64,
}

impl MuscleCurve {
    /// Length of the curve, in metres, when the vertices are at `positions`.
    pub fn length_m(&self, positions: &[Vec3]) -> f64 {
        let mut last: Option<DVec3> = None;
        let mut length = 0.0;
        for point in &self.points {
            let at = point.at(positions);
            length += last.map_or(0.0, |last| last.distance(at));
            last = Some(at);
        }
        length
    }
}

/// The muscles of a head.
#[derive(Debug, Clone, PartialEq)]
pub struct Muscles {
    curves: Vec<MuscleCurve>,
    vertices: usize,
}

impl Muscles {
    /// Muscles on a head of `vertices` vertices.
    ///
    /// # Errors
    /// Where a name stands twice, a vertex is not there, or a curve has no length.
    pub fn new(curves: Vec<MuscleCurve>, vertices: usize) -> Result<Self, DataError> {
        check_unique("muscle", &curves.iter().map(|curve| curve.name.clone()).collect::<Vec<_>>())?;
        for curve in &curves {
            let beyond =
                curve.points.iter().flat_map(|point| point.vertices).find(|vertex| *vertex as usize >= vertices);
            if let Some(vertex) = beyond {
                let what = format!("vertex of muscle `{}`", curve.name);
                return Err(DataError::Index { what, index: vertex as usize, count: vertices });
            }
            if !(curve.rest_length_m.is_finite() && curve.rest_length_m > 0.0) {
                let what = format!("rest length of muscle `{}` in metres", curve.name);
                return Err(DataError::Number { what, value: curve.rest_length_m, wanted: "a positive number" });
            }
        }
        Ok(Self { curves, vertices })
    }

    /// The fibres, in their order.
    pub fn curves(&self) -> &[MuscleCurve] {
        &self.curves
    }

    /// Names of the fibres: the channels of strains.
    pub fn names(&self) -> Vec<String> {
        self.curves.iter().map(|curve| curve.name.clone()).collect()
    }

    /// Vertices of the head that they were traced on.
    pub fn vertices(&self) -> usize {
        self.vertices
    }
}

impl Value for Muscles {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.count(self.vertices);
        out.record(&self.curves);
    }

    fn summary(&self) -> String {
        let lengths = self.curves.iter().map(|curve| 1000.0 * curve.rest_length_m);
        let (low, high) = lengths.fold((f64::INFINITY, 0.0_f64), |(low, high), mm| (low.min(mm), high.max(mm)));
        format!("{} muscle fibres of {low:.1} to {high:.1} mm on {} vertices", self.curves.len(), self.vertices)
    }

    fn size(&self) -> usize {
        self.curves.iter().map(|curve| curve.points.len() * 24 + curve.name.len() + 56).sum()
    }

    fn tables(&self) -> Vec<Table<'_>> {
        vec![Table {
            what: "muscles",
            unit: "mm",
            tolerance: Tolerance { absolute: 0.05, relative: 0.0 },
            rows: Rows::Named("muscle", self.names()),
            columns: vec!["rest length".to_owned()],
            number: Box::new(|curve, _| 1000.0 * self.curves[curve].rest_length_m),
        }]
    }
}

impl Data for Muscles {
    const NAME: &'static str = "Muscles";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let vertices = input.count()?;
        Self::new(input.record()?, vertices).map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(name: &str) -> MuscleCurve {
        let point = |vertex| RidingPoint { vertices: [vertex, 0, 1], weights: [1.0, 0.0, 0.0] };
        MuscleCurve { name: name.into(), points: vec![point(0), point(1), point(2)], rest_length_m: 2.0 }
    }

    #[test]
    fn lengths_follow_vertices_and_muscles_round_trip() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.5, 0.0)];
        assert!((curve("a").length_m(&positions) - 2.5).abs() < 1e-12);
        let muscles = Muscles::new(vec![curve("a"), curve("b")], 3).unwrap();
        assert_eq!(muscles.summary(), "2 muscle fibres of 2000.0 to 2000.0 mm on 3 vertices");
        let encoded = (&muscles as &dyn Value).encoded();
        let decoded = (ValueKind::of::<Muscles>().decode)(&encoded).unwrap();
        assert_eq!(decoded.downcast_ref::<Muscles>(), Some(&muscles));
        assert!(Muscles::new(vec![curve("a"), curve("a")], 3).is_err());
        assert!(Muscles::new(vec![curve("a")], 2).is_err());
        assert!(Muscles::new(vec![MuscleCurve { rest_length_m: 0.0, ..curve("a") }], 3).is_err());
    }
}
