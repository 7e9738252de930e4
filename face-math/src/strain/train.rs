//! Expression shapes into a rig: the solvers of section A.3 on rigs, meshes and curves; and a plain linear rig of the same
//! channels, to measure against.

use super::error::{StrainError, same};
use super::measure::distance_penalties;
use super::pose_shapes::{offsets, sparse};
use super::shapes::{StrainShapeOptions, expression_shapes, fit_strain_shapes};
use super::skinning::check_meshes;
use crate::data::{Curves, Driver, Meshes, Muscles, Rig, Shape};
use faer::Mat;
use glam::Vec3;

/// How far strains reach over the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrainReach {
    /// The distance at which the penalty d is 1, in metres.
    pub falloff_m: f64,
    /// Beyond this a strain moves nothing, in metres; infinite where it may move all.
    pub reach_m: f64,
}

/// A strain rig and its strains.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainedStrains {
    /// The rig, with a channel and a shape for each strain.
    pub rig: Rig,
    /// The strains, refined.
    pub strains: Curves,
    /// The loss after the first E and after each half of a round, in square metres.
    pub losses_m2: Vec<f64>,
}

/// Adds the strains of `muscles` to a rig with joints (and pose shapes), fitted to `unposed` meshes (pose shapes taken off).
///
/// # Errors
/// Where sizes do not fit, a setting is out of range, or `go_on` says so.
pub fn train_strain_rig<E: From<StrainError>>(
    rig: &Rig,
    unposed: &Meshes,
    strains: &Curves,
    muscles: &Muscles,
    (reach, options): (StrainReach, &StrainShapeOptions),
    go_on: impl FnMut(usize, f64) -> Result<(), E>,
) -> Result<TrainedStrains, E> {
    same("vertices of the meshes", rig.neutral.len(), unposed.vertices())?;
    same("vertices of the muscles' head", rig.neutral.len(), muscles.vertices())?;
    same("frames of the strains", unposed.frames(), strains.frames())?;
    check_meshes(unposed)?;
    for (what, value) in [("the falloff", reach.falloff_m), ("the reach", reach.reach_m)] {
        if value.is_nan() || value <= 0.0 {
            return Err(StrainError::Setting { what, value, wanted: "more than 0 m" }.into());
        }
    }
    let names = muscles.names();
    let measured = matrix(&strains.arrange(&names, None).map_err(StrainError::from)?)?;
    let penalties = distance_penalties(muscles, &rig.neutral, reach.falloff_m, reach.reach_m);
    let targets = offsets(&rig.neutral, unposed);
    let fitted = fit_strain_shapes(&targets, &measured, &penalties, options, go_on)?;
    let out = with_channels(rig, &names, &fitted.shapes)?;
    let values = (0..strains.frames()).flat_map(|t| (0..names.len()).map(move |s| (s, t)));
    let values = values.map(|(s, t)| fitted.strains[(s, t)] as f32).collect();
    let strains = Curves::new(strains.frame_axis(), names, values).map_err(StrainError::from)?;
    Ok(TrainedStrains { rig: out, strains, losses_m2: fitted.losses_m2 })
}

/// A rig whose channels are those of `curves`, each with one shape, fitted to meshes by least squares with no joint and no
/// corrective: E = argmin `Σ_t` ‖V(t) − N − E w(t)‖².
///
/// # Errors
/// Where sizes do not fit.
pub fn fit_linear_rig(rig: &Rig, meshes: &Meshes, curves: &Curves) -> Result<Rig, StrainError> {
    same("vertices of the meshes", rig.neutral.len(), meshes.vertices())?;
    same("frames of the curves", meshes.frames(), curves.frames())?;
    check_meshes(meshes)?;
    let weights = matrix(curves)?;
    let free = vec![0.0; weights.nrows() * rig.neutral.len()];
    let shapes = expression_shapes(&offsets(&rig.neutral, meshes), &weights, &free, 0.0)?;
    let bare = Rig {
        channels: Vec::new(),
        shapes: Vec::new(),
        skin: Vec::new(),
        jaw: None,
        joints: Vec::new(),
        ..rig.clone()
    };
    with_channels(&bare, curves.channels(), &shapes)
}

/// Values of curves, channels × frames.
pub(super) fn matrix(curves: &Curves) -> Result<Mat<f64>, StrainError> {
    let count = curves.channels().len();
    if let Some(at) = curves.values().iter().position(|value| !value.is_finite()) {
        let frame = at / count;
        let number = curves.frame_axis().slice(&(frame..frame + 1)).first;
        return Err(StrainError::NotFinite { what: "channel", index: at % count, frame: number });
    }
    Ok(Mat::from_fn(count, curves.frames(), |channel, frame| f64::from(curves.frame(frame)[channel])))
}

/// The rig with a channel and a dense shape for each column of `shapes`.
fn with_channels(rig: &Rig, names: &[String], shapes: &Mat<f64>) -> Result<Rig, StrainError> {
    let mut out = rig.clone();
    for (column, name) in names.iter().enumerate() {
        let delta =
            |vertex: usize| Vec3::from_array(std::array::from_fn(|axis| shapes[(3 * vertex + axis, column)] as f32));
        let (vertices, deltas) = sparse((0..rig.neutral.len()).map(delta));
        let driver = Driver::Channel(out.channels.len() as u32);
        out.channels.push(name.clone());
        out.shapes.push(Shape { name: name.clone(), driver, vertices, deltas });
    }
    Ok(out.checked()?)
}

/// How far meshes are from others, in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshError {
    /// Mean distance of each frame.
    pub mean_m: Vec<f64>,
    /// Root of the mean squared distance of each frame.
    pub rms_m: Vec<f64>,
    /// Greatest distance of each frame.
    pub max_m: Vec<f64>,
    /// Mean distance of each vertex over all frames.
    pub vertex_m: Vec<f64>,
    /// Root of the mean squared second difference over time of the offsets from the truth, over all vertices and inner frames;
    /// 0 where there are fewer than three. Unlike a distance it does not see an offset that stays.
    pub jitter_m: f64,
}

/// The distances of the vertices `chosen` between `found` (a frame's positions by its number) and `truth`.
///
/// # Errors
/// Where a position is not finite.
pub fn mesh_error<'m>(
    truth: &Meshes,
    chosen: &[usize],
    found: impl Fn(usize) -> &'m [Vec3],
) -> Result<MeshError, StrainError> {
    let frames = truth.frames();
    let mut error = MeshError {
        mean_m: Vec::with_capacity(frames),
        rms_m: Vec::with_capacity(frames),
        max_m: Vec::with_capacity(frames),
        vertex_m: vec![0.0; chosen.len()],
        jitter_m: 0.0,
    };
    let inner = frames.saturating_sub(2);
    for frame in 0..frames {
        let (own, known) = (found(frame), truth.frame(frame));
        let (mut sum, mut squares, mut most) = (0.0, 0.0, 0.0_f64);
        for (vertex, total) in chosen.iter().zip(&mut error.vertex_m) {
            let far = own[*vertex].as_dvec3().distance(known[*vertex].as_dvec3());
            if !far.is_finite() {
                let number = truth.frame_axis().slice(&(frame..frame + 1)).first;
                return Err(StrainError::NotFinite { what: "vertex", index: *vertex, frame: number });
            }
            sum += far;
            squares += far * far;
            most = most.max(far);
            *total += far / frames as f64;
        }
        let count = chosen.len().max(1) as f64;
        error.mean_m.push(sum / count);
        error.rms_m.push((squares / count).sqrt());
        error.max_m.push(most);
    }
    for frame in 1..=inner {
        let offset =
            |frame: usize, vertex: usize| found(frame)[vertex].as_dvec3() - truth.frame(frame)[vertex].as_dvec3();
        let second =
            |vertex: &usize| offset(frame - 1, *vertex) - 2.0 * offset(frame, *vertex) + offset(frame + 1, *vertex);
        error.jitter_m += chosen.iter().map(|vertex| second(vertex).length_squared()).sum::<f64>();
    }
    error.jitter_m = (error.jitter_m / (inner * chosen.len()).max(1) as f64).sqrt();
    Ok(error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{MuscleCurve, RidingPoint};
    use crate::strain::{Keep, toy, unpose_meshes};

    fn muscles(rig: &Rig, names: &[String]) -> Muscles {
        let curve = |(at, name): (usize, &String)| {
            let point = |vertex: u32| RidingPoint { vertices: [vertex, 0, 1], weights: [1.0, 0.0, 0.0] };
            let points = vec![point(at as u32 * 7), point(at as u32 * 7 + 9)];
            let mut curve = MuscleCurve { name: name.clone(), points, rest_length_m: 1.0 };
            curve.rest_length_m = curve.length_m(&rig.neutral);
            curve
        };
        Muscles::new(names.iter().enumerate().map(curve).collect(), rig.neutral.len()).unwrap()
    }

    #[test]
    fn a_strain_rig_reproduces_the_meshes_that_a_strain_rig_made() {
        let base = toy::jointed_head();
        let known = toy::with_shapes(&base, 5, 0.01);
        let (poses, strains) = (toy::pose_curves(&known, 40), toy::values(&known.channels[9..], 40, 0.5, 6));
        let meshes = toy::evaluated(&known, &toy::beside(&poses, &strains));
        let unposed = unpose_meshes(&base, &meshes, &poses, Keep::Strains).unwrap();
        let muscles = muscles(&base, strains.channels());
        let reach = StrainReach { falloff_m: 0.02, reach_m: f64::INFINITY };
        let options = StrainShapeOptions { rounds: 2, prior_m2: 1e-6, distance_penalty: 0.0 };
        let go_on = |_, _| Ok::<(), StrainError>(());
        let trained = train_strain_rig(&base, &unposed, &strains, &muscles, (reach, &options), go_on).unwrap();
        let again = toy::evaluated(&trained.rig, &toy::beside(&poses, &trained.strains));
        let all: Vec<usize> = (0..96).collect();
        let error = mesh_error(&meshes, &all, |frame| again.frame(frame)).unwrap();
        assert!(error.max_m.iter().all(|far| *far < 2e-6), "{:?}", error.max_m);
        assert_eq!(again.frame(0), &base.neutral[..]);
        let short = StrainReach { reach_m: 0.01, ..reach };
        let local = train_strain_rig(&base, &unposed, &strains, &muscles, (short, &options), go_on).unwrap();
        assert!(local.rig.shapes.last().unwrap().vertices.len() < 10);
    }

    #[test]
    fn a_linear_rig_reproduces_a_linear_rig_and_errors_are_distances() {
        let linear = toy::with_shapes(&toy::bare_head(), 4, 0.01);
        let curves = toy::values(&linear.channels, 30, 1.0, 9);
        let meshes = toy::evaluated(&linear, &curves);
        let fitted = fit_linear_rig(&toy::bare_head(), &meshes, &curves).unwrap();
        let again = toy::evaluated(&fitted, &curves);
        for (a, b) in again.positions().iter().zip(meshes.positions()) {
            assert!(a.abs_diff_eq(*b, 1e-7));
        }
        let moved: Vec<Vec3> = linear.neutral.iter().map(|point| *point + Vec3::new(3e-3, 4e-3, 0.0)).collect();
        let axis = wire::FrameAxis::new(1, 60.0);
        let one = Meshes::new(axis, linear.parts.clone(), 96, moved).unwrap();
        let error = mesh_error(&one, &[3, 80], |_| &linear.neutral).unwrap();
        assert!((error.mean_m[0] - 5e-3).abs() < 1e-8 && (error.max_m[0] - 5e-3).abs() < 1e-8);
        assert!(error.jitter_m == 0.0);
    }

    #[test]
    fn jitter_is_the_second_difference_of_what_is_off() {
        let head = toy::bare_head();
        let shift = [0.0, 3e-3, 0.0, 0.0].map(|by| Vec3::new(0.0, by, 0.0) + Vec3::X);
        let moved = shift.iter().flat_map(|by| head.neutral.iter().map(move |point| *point + *by)).collect();
        let axis = wire::FrameAxis::new(4, 60.0);
        let truth = Meshes::new(axis, head.parts.clone(), 96, moved).unwrap();
        let error = mesh_error(&truth, &[3, 80], |_| &head.neutral).unwrap();
        // Second differences of −6 and 3 mm in the two inner frames.
        assert!((error.jitter_m - 1e-3 * (45.0_f64 / 2.0).sqrt()).abs() < 1e-6, "{}", error.jitter_m);
    }
}
