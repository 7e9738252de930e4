//! The frames in which a solve is farthest off: what a report draws, and where an artist looks first.

use crate::data::Curves;

/// The frames of the largest errors on `channel`, at least a quarter of a second apart, the largest first: position and error.
/// Frames without a number are passed over; a channel that is not there has none.
pub fn worst_frames(errors: &Curves, channel: &str, count: usize) -> Vec<(usize, f64)> {
    let Some(column) = errors.index(channel) else { return Vec::new() };
    let apart = (errors.frame_axis().rate_hz / 4.0).ceil().max(1.0) as usize;
    let mut frames: Vec<(usize, f64)> =
        (0..errors.frames()).map(|frame| (frame, f64::from(errors.frame(frame)[column]))).collect();
    frames.retain(|(_, error)| error.is_finite());
    frames.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut found: Vec<(usize, f64)> = Vec::new();
    for (frame, error) in frames {
        if found.len() >= count {
            break;
        }
        if found.iter().all(|(known, _)| known.abs_diff(frame) >= apart) {
            found.push((frame, error));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use wire::FrameAxis;

    #[test]
    fn worst_frames_stand_apart_and_gaps_are_passed_over() {
        let mut values = vec![0.1_f32; 100];
        (values[50], values[51], values[80], values[10]) = (3.0, 2.9, 2.0, f32::NAN);
        let axis = FrameAxis { first: 1001, count: 100, rate_hz: 24.0 };
        let curves = Curves::new(axis, vec!["rms_mm".into()], values).unwrap();
        let found: Vec<usize> = worst_frames(&curves, "rms_mm", 2).into_iter().map(|(frame, _)| frame).collect();
        assert_eq!(found, [50, 80]);
        assert!(worst_frames(&curves, "lips_mm", 2).is_empty());
    }
}
