//! Tests of [`fill_gaps`]: motion found again, blocks and whole alike, and what must stay as it is.

use super::{GapError, GapOptions, Source, fill_gaps, learn_shapes};
use crate::data::Markers;
use glam::{Quat, Vec3};
use std::ops::Range;
use wire::FrameAxis;

const SIDE: usize = 6;
const FRAMES: usize = 150;

/// A curved patch of skin at rest, 36 markers in 10 cm.
fn neutral() -> Markers {
    let grid = (0..SIDE * SIDE).map(|index| ((index % SIDE) as f32 * 0.02 - 0.05, (index / SIDE) as f32 * 0.02 - 0.05));
    let positions: Vec<Vec3> = grid.map(|(x, y)| Vec3::new(x, y, -4.0 * (x * x + y * y))).collect();
    let names = (0..positions.len()).map(|index| format!("m{index}")).collect();
    Markers::new(FrameAxis::new(1, 60.0), names, positions).unwrap()
}

/// The patch on a turning head: it stretches as a smile does, and sits 1 mm off its place at rest.
fn take() -> Markers {
    let neutral = neutral();
    let positions = (0..FRAMES).flat_map(|frame| {
        let seconds = frame as f32 / 60.0;
        let turn = Quat::from_rotation_y(0.4 * (2.0 * seconds).sin());
        let smile = 0.5 - 0.5 * (3.0 * seconds).cos();
        let moved = |place: &Vec3| {
            let pull = smile * (-(place.distance_squared(Vec3::new(0.03, -0.02, 0.0)) / 0.002)).exp();
            let skin = *place + Vec3::new(0.008, 0.006, -0.003) * pull + Vec3::new(0.0, 0.001, 0.0);
            turn * skin + Vec3::new(0.0, 1.5, 0.1 * seconds)
        };
        neutral.frame(0).iter().map(moved).collect::<Vec<_>>()
    });
    let axis = FrameAxis { first: 7, count: FRAMES, rate_hz: 60.0 };
    Markers::new(axis, neutral.names().to_vec(), positions.collect()).unwrap()
}

/// The take without `marker` in `frames`.
fn without(take: &Markers, gaps: &[(usize, Range<usize>)]) -> Markers {
    let mut positions = take.positions().to_vec();
    for (marker, frames) in gaps {
        for frame in frames.clone() {
            positions[frame * take.names().len() + marker] = Vec3::NAN;
        }
    }
    take.with_positions(positions).unwrap()
}

/// Gaps of many kinds: short, long, at both ends, side by side, of neighbours, a lone seen frame, and a whole marker.
fn gaps() -> Vec<(usize, Range<usize>)> {
    let mut gaps =
        vec![(0, 0..5), (0, 40..41), (3, 20..26), (3, 27..33), (3, 60..130), (10, 50..62), (10, 140..FRAMES)];
    gaps.extend([(14, 30..80), (15, 45..90), (20, 31..79), (21, 0..FRAMES), (22, 100..113), (35, 0..60)]);
    gaps
}

fn worst_mm(a: &Markers, b: &Markers) -> f32 {
    a.positions().iter().zip(b.positions()).map(|(a, b)| a.distance(*b) * 1000.0).fold(0.0, f32::max)
}

fn bits(markers: &Markers) -> Vec<[u32; 3]> {
    markers.positions().iter().map(|point| point.to_array().map(f32::to_bits)).collect()
}

fn cut(take: &Markers, frames: Range<usize>) -> Markers {
    let width = take.names().len();
    let positions = take.positions()[frames.start * width..frames.end * width].to_vec();
    Markers::new(take.frame_axis().slice(&frames), take.names().to_vec(), positions).unwrap()
}

#[test]
fn smooth_motion_is_found_again_in_short_gaps() {
    let take = take();
    for (length, limit_mm) in [(1, 0.01), (4, 0.1), (12, 1.5)] {
        let gaps: Vec<_> = (0..36).map(|marker| (marker, 20 + 3 * marker..20 + 3 * marker + length)).collect();
        let filled = fill_gaps(&without(&take, &gaps), None, None, &GapOptions::default()).unwrap();
        let worst = worst_mm(&filled.markers, &take);
        assert!(worst < limit_mm, "{length} frames: {worst} mm");
        assert_eq!(filled.filled.iter().sum::<usize>(), 36 * length);
    }
}

/// Root mean square distance (mm) at which each marker comes back from a gap of one second, and the greatest step (mm)
/// that the error makes where such a gap begins or ends.
fn one_second_gaps_mm(neutral: Option<&Markers>, options: &GapOptions) -> (f32, f32) {
    let (take, gap) = (take(), 30..90);
    let width = take.names().len();
    let (mut squares, mut step) = (0.0, 0.0_f32);
    for marker in 0..width {
        let filled = fill_gaps(&without(&take, &[(marker, gap.clone())]), neutral, None, options).unwrap().markers;
        let error = |frame: usize| filled.frame(frame)[marker] - take.frame(frame)[marker];
        squares += gap.clone().map(|frame| error(frame).length_squared()).sum::<f32>();
        step = step.max(error(gap.start).length()).max(error(gap.end - 1).length());
    }
    (1000.0 * (squares / (width * gap.len()) as f32).sqrt(), 1000.0 * step)
}

#[test]
fn long_gaps_follow_the_neighbours_and_meet_their_ends() {
    let neutral = neutral();
    let options = GapOptions::default();
    let (found_mm, step_mm) = one_second_gaps_mm(Some(&neutral), &options);
    let in_time = GapOptions { max_gap_frames: 60, ..options };
    let (in_time_mm, _) = one_second_gaps_mm(None, &in_time);
    let (alone_mm, alone_step_mm) = one_second_gaps_mm(Some(&neutral), &GapOptions { carry_frames: 0, ..options });
    let all = format!("{found_mm} {step_mm}, in time {in_time_mm}, nothing carried {alone_mm} {alone_step_mm}");
    assert!(found_mm < in_time_mm && found_mm < alone_mm && found_mm < 0.6, "{all}");
    assert!(step_mm < 0.2 * alone_step_mm, "{all}");
}

#[test]
fn what_rides_on_a_head_is_found_exactly_though_it_sits_off_its_place() {
    let neutral = neutral();
    let mut off = neutral.frame(0).to_vec();
    off[8] += Vec3::new(0.001, -0.002, 0.0015);
    let positions = (0..80).flat_map(|frame| {
        let turn = Quat::from_rotation_x(0.02 * frame as f32);
        off.iter().map(move |place| turn * *place + Vec3::X).collect::<Vec<_>>()
    });
    let take = Markers::new(FrameAxis::new(80, 60.0), neutral.names().to_vec(), positions.collect()).unwrap();
    let options = GapOptions { carry_frames: 1000, ..GapOptions::default() };
    let filled = fill_gaps(&without(&take, &[(8, 20..60)]), Some(&neutral), None, &options).unwrap();
    assert!(worst_mm(&filled.markers, &take) < 0.1, "{}", worst_mm(&filled.markers, &take));
}

#[test]
fn blocks_are_the_whole_bit_for_bit() {
    let (gapped, neutral) = (without(&take(), &gaps()), neutral());
    let short = GapOptions { max_gap_frames: 3, carry_frames: 0, neighbours: 3 };
    for options in [GapOptions::default(), short, GapOptions { max_gap_frames: 40, ..short }] {
        for neutral in [None, Some(&neutral)] {
            let whole = fill_gaps(&gapped, neutral, None, &options).unwrap();
            for block in [1, 7, 32] {
                for start in (0..FRAMES).step_by(block) {
                    let end = (start + block).min(FRAMES);
                    let halo = options.halo_frames();
                    let from = start.saturating_sub(halo);
                    let part = cut(&gapped, from..(end + halo).min(FRAMES));
                    let part = fill_gaps(&part, neutral, None, &options).unwrap();
                    let own = cut(&part.markers, start - from..end - from);
                    assert_eq!(bits(&own), bits(&cut(&whole.markers, start..end)), "{options:?} {start}..{end}");
                    assert_eq!(part.filled[start - from..end - from], whole.filled[start..end]);
                }
            }
        }
    }
}

#[test]
fn seen_points_stay_as_they_were_and_every_fill_is_counted() {
    let gapped = without(&take(), &gaps());
    let filled = fill_gaps(&gapped, Some(&neutral()), None, &GapOptions::default()).unwrap();
    for (before, after) in gapped.positions().iter().zip(filled.markers.positions()) {
        assert!(before.is_nan() || before.to_array().map(f32::to_bits) == after.to_array().map(f32::to_bits));
    }
    assert_eq!(filled.markers.missing(), 0);
    let missing = |frame| gapped.frame(frame).iter().filter(|point| point.is_nan()).count();
    assert_eq!(filled.filled, (0..FRAMES).map(missing).collect::<Vec<_>>());
    assert_eq!(filled.markers.frame_axis(), gapped.frame_axis());
}

#[test]
fn long_gaps_stay_where_nothing_tells_of_them() {
    let gapped = without(&take(), &[(4, 30..43), (4, 60..72), (9, 0..3), (9, 145..FRAMES)]);
    let filled = fill_gaps(&gapped, None, None, &GapOptions::default()).unwrap();
    assert_eq!(filled.markers.missing(), 13 + 3 + 5);
    assert_eq!(filled.filled.iter().sum::<usize>(), 12);
    let others: Vec<String> = neutral().names().iter().filter(|name| *name != "m4").cloned().collect();
    let neutral = neutral().pick(&others).unwrap();
    let filled = fill_gaps(&gapped, Some(&neutral), None, &GapOptions::default()).unwrap();
    assert_eq!(filled.markers.missing(), 13, "the face at rest does not place m4");
}

#[test]
fn a_frame_in_which_almost_nothing_was_seen_stays_missing() {
    let gaps: Vec<_> = (2..36).map(|marker| (marker, 50..70)).collect();
    let filled = fill_gaps(&without(&take(), &gaps), Some(&neutral()), None, &GapOptions::default()).unwrap();
    assert_eq!(filled.markers.missing(), 34 * 20);
}

#[test]
fn what_cannot_be_used_is_named() {
    let (take, neutral, options) = (take(), neutral(), GapOptions::default());
    assert_eq!(fill_gaps(&take, Some(&take), None, &options), Err(GapError::NeutralFrames { frames: FRAMES }));
    let two = neutral.pick(&["m1".to_owned(), "m2".to_owned()]).unwrap();
    assert_eq!(fill_gaps(&take, Some(&two), None, &options), Err(GapError::NeutralMarkers { shared: 2, markers: 36 }));
    let few = GapOptions { neighbours: 2, ..options };
    assert_eq!(fill_gaps(&take, None, None, &few), Err(GapError::Neighbours { neighbours: 2 }));
    let mut positions = take.positions().to_vec();
    positions[36 * 2 + 5].y = f32::INFINITY;
    let infinite = take.with_positions(positions).unwrap();
    assert_eq!(
        fill_gaps(&infinite, None, None, &options),
        Err(GapError::Infinite { marker: "m5".to_owned(), frame: 9 })
    );
}

#[test]
fn takes_without_frames_or_markers_pass() {
    let empty = Markers::new(FrameAxis::new(0, 60.0), vec!["m0".to_owned()], Vec::new()).unwrap();
    assert_eq!(fill_gaps(&empty, None, None, &GapOptions::default()).unwrap().filled, Vec::<usize>::new());
    let none = Markers::new(FrameAxis::new(3, 60.0), Vec::new(), Vec::new()).unwrap();
    assert_eq!(fill_gaps(&none, None, None, &GapOptions::default()).unwrap().filled, [0; 3]);
}

#[test]
fn shapes_of_the_whole_face_fill_long_gaps_and_every_point_says_where_it_comes_from() {
    let (take, gap) = (take(), 30..90);
    let shapes = learn_shapes(&[&take], take.names(), 6).unwrap();
    let gaps: Vec<_> = [7, 14, 21].map(|marker| (marker, gap.clone())).into_iter().chain([(3, 10..14)]).collect();
    let filled = fill_gaps(&without(&take, &gaps), None, Some(&shapes), &GapOptions::default()).unwrap();
    assert!(worst_mm(&filled.markers, &take) < 0.3, "{} mm", worst_mm(&filled.markers, &take));
    for (index, source) in filled.sources.iter().enumerate() {
        let (frame, marker) = (index / take.names().len(), index % take.names().len());
        let expected = match marker {
            7 | 14 | 21 if gap.contains(&frame) => Source::Shapes,
            3 if (10..14).contains(&frame) => Source::Time,
            _ => Source::Seen,
        };
        assert_eq!(*source, expected, "frame {frame}, marker {marker}");
    }
    let other = take.names().iter().map(|name| format!("other_{name}")).collect();
    let other = Markers::new(take.frame_axis(), other, take.positions().to_vec()).unwrap();
    let error = fill_gaps(&other, None, Some(&shapes), &GapOptions::default()).unwrap_err();
    assert_eq!(error, GapError::Shapes { shared: 0, markers: 36 });
}
