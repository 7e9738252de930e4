//! From markers to whole meshes (section B.1 of Animatomy): the mesh of a learned space that lies best under the markers.
//!
//! The principal components Q of training meshes V̄ (less their mean μ, metres) come from the T × T matrix V̄ᵀ V̄, or, where
//! there are many frames, from a randomised range finder (Halko, Martinsson and Tropp, SIAM Review 53, 2011, algorithm 4.4
//! with two power iterations): Y = (V̄ V̄ᵀ)² V̄ Ω, orthonormalised, and the small matrix Yᵀ V̄.
//!
//! Markers M see the mesh through P (barycentric weights on triangles). The controls of the mesh V = μ + Qᵀ X are
//!
//! ```text
//! X = argmin ‖M − P μ − P Qᵀ X‖² / σ² + Σ_c X_c² / s_c²
//! ```
//!
//! with σ how far markers are off (metres) and `s_c` the spread of a component: with σ → 0 the pseudo-inverse (P Qᵀ)⁺ of the
//! paper, and with its true value the likeliest mesh. Missing markers are left out.

use super::error::{StrainError, same};
use super::matrix::{outer, product};
use super::skinning::check_meshes;
use crate::data::{Attachment, Markers, MeshSpace, Meshes, Part};
use faer::linalg::solvers::Llt;
use faer::prelude::Solve;
use faer::{Mat, Side};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Components beyond those asked for, which make the range finder exact enough.
const MORE: usize = 12;

/// Learns a space of at most `components` components from meshes. `exact_frames` is the number of frames up to which all
/// components are found before the greatest are kept.
///
/// # Errors
/// Where there are fewer than two frames, or something is not finite.
pub fn learn_mesh_space(meshes: &Meshes, components: usize, exact_frames: usize) -> Result<MeshSpace, StrainError> {
    check_meshes(meshes)?;
    let frames = meshes.frames();
    if frames < 2 || components == 0 {
        return Err(StrainError::TooFewFrames { found: frames, needed: 2 });
    }
    let mean: Vec<Vec3> = (0..meshes.vertices())
        .into_par_iter()
        .map(|vertex| {
            let sum: DVec3 = (0..frames).map(|frame| meshes.frame(frame)[vertex].as_dvec3()).sum();
            (sum / frames as f64).as_vec3()
        })
        .collect();
    let offsets = super::pose_shapes::offsets(&mean, meshes);
    let (basis, levels) = if frames <= exact_frames {
        by_frames(&offsets)?
    } else {
        by_range(&offsets, (components + MORE).min(frames))?
    };
    let largest = levels.first().copied().unwrap_or_default().max(f64::MIN_POSITIVE);
    let told = levels.iter().take(components).take_while(|level| **level > 1e-14 * largest).count();
    let mut modes = Vec::with_capacity(told * mean.len());
    for mode in 0..told {
        let entry =
            |vertex: usize| Vec3::from_array(std::array::from_fn(|axis| basis[(3 * vertex + axis, mode)] as f32));
        modes.extend((0..mean.len()).map(entry));
    }
    let spreads = levels[..told].iter().map(|level| (level / (frames - 1) as f64).sqrt()).collect();
    Ok(MeshSpace::new(mean, modes, spreads)?)
}

/// All components: eigenvectors u of V̄ᵀ V̄ give the modes V̄ u / √λ. The greatest first, with their λ.
fn by_frames(offsets: &Mat<f64>) -> Result<(Mat<f64>, Vec<f64>), StrainError> {
    let gram = outer(offsets.transpose());
    turned(&gram, |vectors| product(offsets.as_ref(), vectors.as_ref()))
}

/// The greatest components by a randomised range.
fn by_range(offsets: &Mat<f64>, width: usize) -> Result<(Mat<f64>, Vec<f64>), StrainError> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let start = Mat::<f64>::from_fn(offsets.ncols(), width, |_, _| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    });
    let mut range = orthonormal(&product(offsets.as_ref(), start.as_ref()))?;
    for _ in 0..2 {
        let back = product(offsets.transpose(), range.as_ref());
        range = orthonormal(&product(offsets.as_ref(), back.as_ref()))?;
    }
    let small = product(range.transpose(), offsets.as_ref());
    let gram = product(small.as_ref(), small.transpose());
    let eigen =
        gram.self_adjoint_eigen(Side::Lower).map_err(|_| StrainError::Decomposition { what: "the training meshes" })?;
    let levels: Vec<f64> = (0..width).rev().map(|place| eigen.S().column_vector()[place].max(0.0)).collect();
    let vectors = Mat::<f64>::from_fn(width, width, |row, column| eigen.U()[(row, width - 1 - column)]);
    Ok((product(range.as_ref(), vectors.as_ref()), levels))
}

/// The columns made orthonormal, by the eigenvectors of their products; twice, for rounding.
fn orthonormal(columns: &Mat<f64>) -> Result<Mat<f64>, StrainError> {
    let once = |columns: &Mat<f64>| {
        let gram = outer(columns.transpose());
        turned(&gram, |vectors| product(columns.as_ref(), vectors.as_ref())).map(|(basis, _)| basis)
    };
    once(&once(columns)?)
}

/// Eigenvectors of a matrix of products, the greatest first, sent through `through` and made of length 1.
fn turned(gram: &Mat<f64>, through: impl Fn(&Mat<f64>) -> Mat<f64>) -> Result<(Mat<f64>, Vec<f64>), StrainError> {
    let size = gram.nrows();
    let eigen =
        gram.self_adjoint_eigen(Side::Lower).map_err(|_| StrainError::Decomposition { what: "the training meshes" })?;
    let levels: Vec<f64> = (0..size).rev().map(|place| eigen.S().column_vector()[place].max(0.0)).collect();
    let floor = 1e-28 * levels.first().copied().unwrap_or_default();
    let vectors = Mat::<f64>::from_fn(size, size, |row, column| {
        let level = levels[column];
        if level > floor { eigen.U()[(row, size - 1 - column)] / level.sqrt() } else { 0.0 }
    });
    Ok((through(&vectors), levels))
}

/// Fits meshes of a space to markers.
#[derive(Debug)]
pub struct MeshFitter<'s> {
    space: &'s MeshSpace,
    names: Vec<String>,
    /// P μ, a marker.
    means: Vec<DVec3>,
    /// P Qᵀ: rows of 3 a marker.
    basis: Mat<f64>,
    noise_m: f64,
}

/// A fitted mesh sequence with its distances from the markers.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedMeshes {
    /// The meshes.
    pub meshes: Meshes,
    /// Root mean square distance of the markers in each frame, in metres.
    pub residual_m: Vec<f64>,
}

impl<'s> MeshFitter<'s> {
    /// Prepares the markers `names` of an attachment, of which `noise_m` (metres) is the error to expect.
    ///
    /// # Errors
    /// Where a marker is not attached, or sits on a vertex that the space lacks.
    pub fn new(
        space: &'s MeshSpace,
        attachment: &Attachment,
        names: &[String],
        noise_m: f64,
    ) -> Result<Self, StrainError> {
        if !(noise_m.is_finite() && noise_m > 0.0) {
            return Err(StrainError::Setting {
                what: "the noise of the markers",
                value: noise_m,
                wanted: "a positive number",
            });
        }
        let points = names.iter().map(|name| {
            attachment.points.iter().find(|point| point.name == *name).ok_or_else(|| crate::data::DataError::Missing {
                what: "attached marker",
                name: name.clone(),
                near: crate::data::nearest_name(name, attachment.points.iter().map(|point| point.name.as_str())),
            })
        });
        let points = points.collect::<Result<Vec<_>, _>>()?;
        let count = space.mean().len();
        if let Some(vertex) = points.iter().flat_map(|point| point.vertices).find(|vertex| *vertex as usize >= count) {
            return Err(crate::data::DataError::Index {
                what: "vertex of a marker".into(),
                index: vertex as usize,
                count,
            }
            .into());
        }
        let see = |marker: usize, positions: &[Vec3]| -> DVec3 {
            let corners = points[marker].vertices.iter().zip(points[marker].weights);
            corners.map(|(vertex, weight)| f64::from(weight) * positions[*vertex as usize].as_dvec3()).sum()
        };
        Ok(Self {
            space,
            names: names.to_vec(),
            means: (0..points.len()).map(|marker| see(marker, space.mean())).collect(),
            basis: Mat::from_fn(3 * points.len(), space.spreads_m().len(), |row, mode| {
                see(row / 3, space.mode(mode))[row % 3]
            }),
            noise_m,
        })
    }

    /// The meshes under a take, on the given parts.
    ///
    /// # Errors
    /// Where the take lacks a marker, or a frame shows fewer than three.
    pub fn fit(&self, take: &Markers, parts: &[Part]) -> Result<FittedMeshes, StrainError> {
        let take = take.pick(&self.names)?;
        let seen: Vec<Vec<bool>> =
            (0..take.frames()).map(|frame| take.frame(frame).iter().map(|point| point.is_finite()).collect()).collect();
        let mut factors: BTreeMap<&[bool], Llt<f64>> = BTreeMap::new();
        for (frame, seen) in seen.iter().enumerate() {
            let count = seen.iter().filter(|seen| **seen).count();
            if count < 3 {
                let first = take.frame_axis().slice(&(frame..frame + 1)).first;
                return Err(StrainError::NotFinite {
                    what: "all but a few markers; the first is",
                    index: 0,
                    frame: first,
                });
            }
            if !factors.contains_key(seen.as_slice()) {
                factors.insert(seen, self.factor(seen)?);
            }
        }
        let frames: Vec<(Vec<Vec3>, f64)> = (0..take.frames())
            .into_par_iter()
            .map(|frame| self.fit_frame(take.frame(frame), &seen[frame], &factors[seen[frame].as_slice()]))
            .collect();
        let residual_m = frames.iter().map(|(_, residual)| *residual).collect();
        let positions = frames.into_iter().flat_map(|(positions, _)| positions).collect();
        let count = self.space.mean().len();
        same("vertices of the parts", count, parts.iter().map(|part| part.vertices.len()).sum())?;
        Ok(FittedMeshes { meshes: Meshes::new(take.frame_axis(), parts.to_vec(), count, positions)?, residual_m })
    }

    fn factor(&self, seen: &[bool]) -> Result<Llt<f64>, StrainError> {
        let rows: Vec<usize> = (0..3 * seen.len()).filter(|row| seen[row / 3]).collect();
        let own = Mat::<f64>::from_fn(rows.len(), self.basis.ncols(), |row, mode| self.basis[(rows[row], mode)]);
        let mut normal = own.transpose() * &own;
        for (mode, spread) in self.space.spreads_m().iter().enumerate() {
            normal[(mode, mode)] += (self.noise_m / spread).powi(2);
        }
        Llt::new(normal.as_ref(), Side::Lower).map_err(|_| StrainError::Decomposition { what: "what the markers see" })
    }

    fn fit_frame(&self, markers: &[Vec3], seen: &[bool], factor: &Llt<f64>) -> (Vec<Vec3>, f64) {
        let mut right = Mat::<f64>::zeros(self.basis.ncols(), 1);
        let offset =
            |marker: usize| if seen[marker] { markers[marker].as_dvec3() - self.means[marker] } else { DVec3::ZERO };
        for marker in (0..markers.len()).filter(|marker| seen[*marker]) {
            for axis in 0..3 {
                for mode in 0..self.basis.ncols() {
                    right[(mode, 0)] += self.basis[(3 * marker + axis, mode)] * offset(marker)[axis];
                }
            }
        }
        factor.solve_in_place(&mut right);
        let mut squares = 0.0;
        for marker in (0..markers.len()).filter(|marker| seen[*marker]) {
            for axis in 0..3 {
                let own: f64 =
                    (0..self.basis.ncols()).map(|mode| self.basis[(3 * marker + axis, mode)] * right[(mode, 0)]).sum();
                squares += (offset(marker)[axis] - own).powi(2);
            }
        }
        let mut positions = self.space.mean().to_vec();
        for mode in 0..self.basis.ncols() {
            let weight = right[(mode, 0)] as f32;
            for (position, own) in positions.iter_mut().zip(self.space.mode(mode)) {
                *position += weight * *own;
            }
        }
        let count = seen.iter().filter(|seen| **seen).count().max(1);
        (positions, (squares / count as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::SurfacePoint;
    use crate::rig::toy::Dice;
    use crate::strain::toy;

    fn training() -> Meshes {
        let rig = toy::with_shapes(&toy::jointed_head(), 4, 0.01);
        let (poses, strains) = (toy::pose_curves(&rig, 60), toy::values(&rig.channels[9..], 60, 1.0, 3));
        toy::evaluated(&rig, &toy::beside(&poses, &strains))
    }

    fn attachment(meshes: &Meshes) -> Attachment {
        let point = |(at, triangle): (usize, &[u32; 3])| SurfacePoint {
            name: format!("m{at}"),
            vertices: *triangle,
            weights: [0.2, 0.5, 0.3],
            distance_m: 0.0,
        };
        Attachment { points: meshes.parts()[0].triangles.iter().step_by(2).enumerate().map(point).collect() }
    }

    #[test]
    fn the_random_range_finds_what_all_frames_tell() {
        let meshes = training();
        let (exact, random) = (learn_mesh_space(&meshes, 8, 100).unwrap(), learn_mesh_space(&meshes, 8, 10).unwrap());
        for mode in 0..8 {
            let (a, b) = (exact.spreads_m()[mode], random.spreads_m()[mode]);
            assert!((a / b - 1.0).abs() < 1e-3, "mode {mode}: {a} {b}");
            let along: f32 = exact.mode(mode).iter().zip(random.mode(mode)).map(|(a, b)| a.dot(*b)).sum();
            assert!((along.abs() - 1.0).abs() < 1e-2, "mode {mode}: {along}");
            for other in 0..mode {
                let product: f32 = random.mode(mode).iter().zip(random.mode(other)).map(|(a, b)| a.dot(*b)).sum();
                assert!(product.abs() < 1e-4);
            }
        }
    }

    #[test]
    fn meshes_of_the_space_are_found_by_their_markers() {
        let meshes = training();
        let space = learn_mesh_space(&meshes, 12, 100).unwrap();
        let attachment = attachment(&meshes);
        // Meshes that lie in the space.
        let mut dice = Dice(71);
        let frames = 6;
        let mut positions = Vec::new();
        for _ in 0..frames {
            let mut own = space.mean().to_vec();
            for mode in 0..space.spreads_m().len() {
                let weight = dice.roll() * space.spreads_m()[mode] as f32;
                own.iter_mut().zip(space.mode(mode)).for_each(|(point, mode)| *point += weight * *mode);
            }
            positions.extend(own);
        }
        let axis = wire::FrameAxis::new(frames, 60.0);
        let known = Meshes::new(axis, meshes.parts().to_vec(), 96, positions).unwrap();
        let see = |frame: usize| attachment.points.iter().map(move |point| (frame, point));
        let mut markers: Vec<Vec3> = (0..frames)
            .flat_map(see)
            .map(|(frame, point)| {
                let corners = point.vertices.iter().zip(point.weights);
                corners.map(|(vertex, weight)| weight * known.frame(frame)[*vertex as usize]).sum()
            })
            .collect();
        markers[5] = Vec3::NAN;
        let take = Markers::new(axis, attachment.names(), markers).unwrap();
        let fitter = MeshFitter::new(&space, &attachment, &attachment.names(), 1e-7).unwrap();
        let fitted = fitter.fit(&take, meshes.parts()).unwrap();
        for (a, b) in fitted.meshes.positions().iter().zip(known.positions()) {
            assert!(a.abs_diff_eq(*b, 1e-4), "{a} {b}");
        }
        assert!(fitted.residual_m.iter().all(|residual| *residual < 1e-6));
        let blind = take.with_positions(vec![Vec3::NAN; take.positions().len()]).unwrap();
        assert!(fitter.fit(&blind, meshes.parts()).is_err());
        assert!(MeshFitter::new(&space, &attachment, &["chin".to_owned()], 1e-4).is_err());
    }
}
