//! Calibrated cameras: where each stood and what its lens does, as a calibration leaves them.
//!
//! The convention is that of `OpenCV`: `x_cam = R x_world + t` (metres), z forward, y down; pixels count from the top left.
//! What a camera does to a point is computed in [`crate::views`].

use super::{DataError, check_unique};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use wire::{Data, DecodeError, Decoder, Encoder, Value, ValueKind};

/// One calibrated camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibratedCamera {
    /// Its name.
    pub name: String,
    /// Width and height of its pictures, in pixels.
    pub size_px: [u32; 2],
    /// fx and fy: focal length in widths and in heights of a pixel.
    pub focal_px: [f64; 2],
    /// cx and cy: where the optical axis meets the picture.
    pub centre_px: [f64; 2],
    /// R: world to camera, a rotation.
    pub rotation: DMat3,
    /// t in metres.
    pub translation_m: DVec3,
    /// Lens distortion k₁, k₂, p₁, p₂, k₃ on normalised coordinates; 0 is none.
    pub distortion: [f64; 5],
}

impl CalibratedCamera {
    /// Where the camera stands: −Rᵀ t, in metres.
    pub fn eye_m(&self) -> DVec3 {
        -(self.rotation.transpose() * self.translation_m)
    }
}

/// Calibrated cameras, each named once.
#[derive(Debug, Clone, PartialEq)]
pub struct Cameras {
    cameras: Vec<CalibratedCamera>,
}

/// How far R may be from a rotation before it is refused: calibration files carry few digits.
const ROTATION_TOLERANCE: f64 = 1e-4;

impl Cameras {
    /// Checked cameras. Rotations that few digits have bent are straightened.
    ///
    /// # Errors
    /// Where a name stands twice, a number is not finite, a focal length is not positive, or R is no rotation.
    pub fn new(mut cameras: Vec<CalibratedCamera>) -> Result<Self, DataError> {
        check_unique("camera", &cameras.iter().map(|camera| camera.name.clone()).collect::<Vec<_>>())?;
        for camera in &mut cameras {
            let name = &camera.name;
            let wrong = |what: &str, value: f64, wanted| {
                Err(DataError::Number { what: format!("{what} of camera `{name}`"), value, wanted })
            };
            if let Some(focal) = camera.focal_px.iter().find(|focal| !(**focal > 0.0 && focal.is_finite())) {
                return wrong("focal length in pixels", *focal, "a positive number");
            }
            let numbers = camera.centre_px.iter().chain(&camera.distortion).copied();
            let mut numbers = numbers.chain(camera.translation_m.to_array()).chain(camera.rotation.to_cols_array());
            if let Some(number) = numbers.find(|number| !number.is_finite()) {
                return wrong("a number", number, "a finite number");
            }
            let bend = camera.rotation * camera.rotation.transpose() - DMat3::IDENTITY;
            let bend = bend.to_cols_array().into_iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
            if bend > ROTATION_TOLERANCE {
                return wrong("the deviation of R Rᵀ from the identity", bend, "0: R is a rotation");
            }
            if camera.rotation.determinant() < 0.0 {
                return wrong("the determinant of R", camera.rotation.determinant(), "1: R mirrors");
            }
            camera.rotation = straightened(camera.rotation);
        }
        Ok(Self { cameras })
    }

    /// The cameras, in the order of their file.
    pub fn cameras(&self) -> &[CalibratedCamera] {
        &self.cameras
    }

    /// Their names.
    pub fn names(&self) -> Vec<String> {
        self.cameras.iter().map(|camera| camera.name.clone()).collect()
    }

    /// The camera called `name`.
    pub fn camera(&self, name: &str) -> Option<&CalibratedCamera> {
        self.cameras.iter().find(|camera| camera.name == name)
    }
}

/// The rotation nearest to a matrix that is nearly one: R ← R (3 I − Rᵀ R) / 2, Newton's iteration for the polar factor
/// (Higham, "Computing the polar decomposition", 1986), which squares the deviation at each step.
fn straightened(mut rotation: DMat3) -> DMat3 {
    for _ in 0..4 {
        rotation = rotation * (DMat3::IDENTITY * 3.0 - rotation.transpose() * rotation) * 0.5;
    }
    rotation
}

impl Value for Cameras {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&self.cameras);
    }

    fn summary(&self) -> String {
        let one = |camera: &CalibratedCamera| {
            let [width, height] = camera.size_px;
            format!("{} ({width} x {height} px, f {:.0} px)", camera.name, camera.focal_px[0])
        };
        let names: Vec<_> = self.cameras.iter().map(one).collect();
        format!("{} cameras: {}", self.cameras.len(), names.join(", "))
    }

    fn size(&self) -> usize {
        self.cameras.len() * size_of::<CalibratedCamera>()
    }
}

impl Data for Cameras {
    const NAME: &'static str = "Cameras";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Ok(Self { cameras: input.record()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(name: &str) -> CalibratedCamera {
        CalibratedCamera {
            name: name.to_owned(),
            size_px: [640, 480],
            focal_px: [500.0, 510.0],
            centre_px: [320.0, 240.0],
            rotation: DMat3::from_rotation_y(0.3),
            translation_m: DVec3::new(0.1, 0.0, 0.7),
            distortion: [0.0; 5],
        }
    }

    #[test]
    fn cameras_round_trip_and_are_found() {
        let cameras = Cameras::new(vec![camera("a"), camera("b")]).unwrap();
        assert_eq!(cameras.names(), ["a", "b"]);
        assert!(cameras.camera("b").is_some() && cameras.camera("c").is_none());
        let encoded = (&cameras as &dyn Value).encoded();
        let decoded = (ValueKind::of::<Cameras>().decode)(&encoded).unwrap();
        assert_eq!(decoded.downcast_ref::<Cameras>(), Some(&cameras));
        let camera = &cameras.cameras()[0];
        let seen = camera.rotation * camera.eye_m() + camera.translation_m;
        assert!(seen.length() < 1e-12, "the eye is the camera's own origin");
    }

    #[test]
    fn few_digits_are_straightened_and_what_is_no_rotation_is_refused() {
        let rounded = |number: f64| (number * 1e5).round() / 1e5;
        let mut few = camera("a");
        few.rotation = DMat3::from_cols_array(&few.rotation.to_cols_array().map(rounded));
        let straight = Cameras::new(vec![few]).unwrap().cameras()[0].rotation;
        assert!((straight * straight.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-14));
        assert!(straight.abs_diff_eq(camera("a").rotation, 2e-5));
        let refused = |change: &dyn Fn(&mut CalibratedCamera)| {
            let mut one = camera("a");
            change(&mut one);
            Cameras::new(vec![one]).unwrap_err().to_string()
        };
        assert!(refused(&|one| one.rotation *= 1.1).contains("R is a rotation"));
        assert!(refused(&|one| one.rotation.x_axis *= -1.0).contains("mirrors"));
        assert!(refused(&|one| one.focal_px[1] = 0.0).contains("focal length"));
        assert!(refused(&|one| one.distortion[4] = f64::NAN).contains("finite"));
        assert!(matches!(Cameras::new(vec![camera("a"), camera("a")]), Err(DataError::Twice { .. })));
    }
}
