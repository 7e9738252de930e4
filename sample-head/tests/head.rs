//! What the sample head must be: symmetric, closed where it should close, rigid where it should be rigid, and such that
//! every channel can be told from its markers.

#![allow(clippy::unwrap_used, reason = "a test may panic")]
#![allow(clippy::float_cmp, reason = "what must be the same must be the same bits")]

use face_math::data::Rig;
use face_math::render::smooth_normals;
use face_math::rig::{MarkerPose, MarkerRig, Puppet, SkinJawOptions, fit_rigid, skin_jaw};
use glam::{DVec3, Vec3};
use sample_head::{CHANNELS, Options, SampleHead, SampleHeadError, build, takes};
use std::sync::LazyLock;

static HEAD: LazyLock<SampleHead> = LazyLock::new(|| build(&Options::default()).unwrap());

fn pose(rig: &Rig, weights: &[(&str, f32)]) -> Vec<Vec3> {
    let mut all = vec![0.0; rig.channels.len()];
    for (name, weight) in weights {
        all[rig.channel(name).unwrap()] = *weight;
    }
    Puppet::new(rig).unwrap().vertices(&all).unwrap()
}

fn part<'a>(rig: &Rig, positions: &'a [Vec3], name: &str) -> &'a [Vec3] {
    let part = rig.part(name).unwrap();
    &positions[part.vertices.start as usize..part.vertices.end as usize]
}

/// Other people than the average one.
fn others() -> Vec<SampleHead> {
    [3, 8]
        .map(|identity| build(&Options { identity, variation: 1.5, density: 0.7, ..Options::default() }).unwrap())
        .into()
}

#[test]
fn it_is_a_human_head_in_metres() {
    for head in others().iter().chain([&*HEAD]) {
        let rig = &head.rig;
        assert_eq!(rig.channels, CHANNELS);
        let marker = |name: &str| head.neutral_markers.frame(0)[head.neutral_markers.index(name).unwrap()];
        let pupils = marker("pupil_L").distance(marker("pupil_R"));
        assert!((0.056..0.070).contains(&pupils), "pupils {pupils} m apart");
        let top = rig.neutral.iter().map(|point| point.y).fold(f32::MIN, f32::max);
        let height = top - marker("jawline_08").y;
        assert!((0.20..0.26).contains(&height), "{height} m from chin to crown");
        let nose = marker("nose_bridge_3");
        assert!(nose.z > marker("skin_03").z && marker("pupil_L").x > 0.0);
        for part in ["face", "head_neck", "teeth_upper", "teeth_lower", "eyeball_L", "eyeball_R", "tongue"] {
            assert!(rig.part(part).is_some(), "{part}");
        }
        assert!(rig.parts.iter().all(|part| part.uvs.len() == part.vertices.len()));
    }
}

#[test]
fn markers_regions_and_landmarks_fit_together() {
    let head = &*HEAD;
    let names = head.neutral_markers.names();
    assert_eq!(names.len(), 102);
    assert_eq!(names.iter().filter(|name| name.starts_with("head_")).count(), 4);
    let mut channels: Vec<String> = Vec::new();
    for region in &head.regions.regions {
        assert!(region.markers.iter().all(|marker| names.contains(marker)), "{}", region.name);
        assert_eq!(region.markers[0], "nose_bridge_0");
        channels.extend(region.channels.iter().cloned());
    }
    channels.sort();
    let mut all = CHANNELS.to_vec();
    all.sort_unstable();
    assert_eq!(channels, all, "each channel belongs to one region");
    let face = head.rig.part("face").unwrap();
    assert!(head.landmarks.iter().all(|vertex| face.vertices.contains(vertex)));
    let mut places: Vec<u32> = head.landmarks.to_vec();
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), 68, "landmarks differ");
    // Multi-PIE order: the performer's right first, the midline in between.
    let x = |landmark: usize| head.rig.neutral[head.landmarks[landmark] as usize].x;
    for (right, left) in [(0, 16), (17, 26), (31, 35), (36, 45), (48, 54), (60, 64)] {
        assert!(x(right) < 0.0 && (x(right) + x(left)).abs() < 1e-6);
    }
    for middle in [8, 27, 28, 29, 30, 33, 51, 57, 62, 66] {
        assert_eq!(x(middle), 0.0, "landmark {middle}");
    }
}

#[test]
fn left_and_right_channels_are_mirror_images() {
    let rig = &HEAD.rig;
    let count = |name: &str| {
        let shape = rig.shapes.iter().find(|shape| shape.name == name).unwrap();
        let mut sums = [0.0f64; 4];
        for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
            let at = rig.neutral[*vertex as usize];
            let (at, delta) = (at.as_dvec3(), delta.as_dvec3());
            for (sum, value) in sums.iter_mut().zip([delta.y, delta.z, delta.x * at.x, at.x * delta.length()]) {
                *sum += value;
            }
        }
        (shape.vertices.len(), sums)
    };
    for left in CHANNELS.iter().filter(|name| name.ends_with("_L") || name.ends_with("Left")) {
        let right = left.replace("Left", "Right").replace("_L", "_R");
        let ((left_count, a), (right_count, b)) = (count(left), count(&right));
        assert_eq!(left_count, right_count, "{left}");
        for (i, (a, b)) in a.iter().zip(&b).enumerate() {
            let sign = if i == 3 { -1.0 } else { 1.0 };
            assert!((a - sign * b).abs() < 1e-6 * (1.0 + a.abs()), "{left}: {a} {b}");
        }
    }
}

/// The vertices of the upper and lower edge of the left eye (or the right), column by column: those of the face part
/// that come together when it shuts.
fn lid_landmarks(head: &SampleHead, first: usize) -> [(u32, u32); 2] {
    let l = |i: usize| head.landmarks[first + i];
    [(l(1), l(5)), (l(2), l(4))]
}

#[test]
fn a_blink_closes_the_eye_and_hides_the_eyeball() {
    for head in others().iter().chain([&*HEAD]) {
        let rig = &head.rig;
        let open = &rig.neutral;
        let shut = pose(rig, &[("eyeBlink_L", 1.0), ("eyeBlink_R", 1.0)]);
        for (upper, lower) in lid_landmarks(head, 36).into_iter().chain(lid_landmarks(head, 42)) {
            let gap = |at: &[Vec3]| at[upper as usize].distance(at[lower as usize]);
            assert!(gap(open) > 0.006 && gap(&shut) < 0.0005, "{} m open, {} m shut", gap(open), gap(&shut));
        }
        // Seen from the front, no point of the eyeball stands before the closed lids; and none does on the way.
        for weight in [0.25, 0.5, 0.75, 1.0] {
            let at = pose(rig, &[("eyeBlink_L", weight), ("eyeBlink_R", weight)]);
            let poked = poking(rig, &at);
            assert!(poked < 0.0002, "an eyeball stands {poked} m out of the lids at blink {weight}");
            if weight == 1.0 {
                assert_eq!(seen(rig, &at, "iris_L") + seen(rig, &at, "eyeball_L"), 0, "shut eyes show");
            }
        }
        assert!(seen(rig, open, "iris_L") > 3);
    }
}

/// How far the left lids' skin sinks under the eyeball's surface, in metres.
fn poking(rig: &Rig, at: &[Vec3]) -> f32 {
    let eyeball: Vec<Vec3> = part(rig, at, "eyeball_L").to_vec();
    let centre = eyeball.iter().sum::<Vec3>() / eyeball.len() as f32;
    let rest = part(rig, &rig.neutral, "eyeball_L");
    let pole = rest.iter().copied().min_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
    let front = part(rig, &rig.neutral, "pupil_L")[0];
    let radius = (front.z - pole.z) * 0.5;
    let middle = Vec3::new(pole.x, pole.y, pole.z + radius);
    assert!(centre.distance(middle) < radius);
    // Only skin that shows: points before the eye's middle and outside the rims, which are hidden in it on purpose.
    let face = rig.part("face").unwrap();
    let mut worst: f32 = 0.0;
    for vertex in face.vertices.clone() {
        let point = at[vertex as usize];
        let rest = rig.neutral[vertex as usize].distance(middle) - radius;
        if point.z > middle.z && (0.0008..0.006).contains(&rest) {
            worst = worst.max(radius - point.distance(middle));
        }
    }
    worst
}

/// How many vertices of a part are seen from the front: no triangle of the face stands before them.
fn seen(rig: &Rig, at: &[Vec3], name: &str) -> usize {
    let own = rig.part(name).unwrap();
    let face = rig.part("face").unwrap();
    let box_of = |points: &[Vec3]| {
        points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
    };
    let (low, high) = box_of(part(rig, at, name));
    let near: Vec<[Vec3; 3]> = face
        .triangles
        .iter()
        .map(|corners| corners.map(|vertex| at[vertex as usize]))
        .filter(|[a, b, c]| {
            let (l, h) = (a.min(*b).min(*c), a.max(*b).max(*c));
            l.x < high.x && h.x > low.x && l.y < high.y && h.y > low.y
        })
        .collect();
    own.vertices
        .clone()
        .filter(|vertex| {
            let p = at[*vertex as usize];
            !near.iter().any(|[a, b, c]| {
                let area = |p: Vec3, q: Vec3, r: Vec3| (q - p).truncate().perp_dot((r - p).truncate());
                let whole = area(*a, *b, *c);
                let (wa, wb) = (area(p, *b, *c) / whole, area(*a, p, *c) / whole);
                let wc = 1.0 - wa - wb;
                wa >= 0.0 && wb >= 0.0 && wc >= 0.0 && a.z * wa + b.z * wb + c.z * wc > p.z
            })
        })
        .count()
}

#[test]
fn lower_teeth_move_rigidly_and_upper_teeth_stay() {
    let rig = &HEAD.rig;
    let wide = |points: &[Vec3]| points.iter().map(|point| point.as_dvec3()).collect::<Vec<DVec3>>();
    for name in CHANNELS {
        let at = pose(rig, &[(name, 1.0)]);
        assert_eq!(part(rig, &at, "teeth_upper"), part(rig, &rig.neutral, "teeth_upper"), "{name}");
        let (from, to) = (wide(part(rig, &rig.neutral, "teeth_lower")), wide(part(rig, &at, "teeth_lower")));
        let fit = fit_rigid(&from, &to, None).unwrap();
        assert!(fit.residual_rms_m < 1e-7, "{name}: {} m", fit.residual_rms_m);
        let moved = from.iter().zip(&to).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert_eq!(moved > 0.003, name.starts_with("jaw"), "{name} moves the lower teeth {moved} m");
    }
    let split = skin_jaw(rig, &SkinJawOptions::default()).unwrap();
    assert_eq!(split.fits.len(), 4);
}

#[test]
fn lips_part_with_the_jaw_and_stand_before_the_teeth() {
    let head = &*HEAD;
    let at = |positions: &[Vec3], landmark: usize| positions[head.landmarks[landmark] as usize];
    let rig = &head.rig;
    assert!(at(&rig.neutral, 62).distance(at(&rig.neutral, 66)) < 0.0005);
    let open = pose(rig, &[("jawOpen", 1.0)]);
    let gap = at(&open, 62).distance(at(&open, 66));
    assert!((0.02..0.045).contains(&gap), "{gap} m");
    let closed = pose(rig, &[("jawOpen", 1.0), ("mouthClose", 1.0)]);
    assert!(at(&closed, 62).distance(at(&closed, 66)) < 0.003);
    for teeth in ["teeth_upper", "teeth_lower", "gums_upper", "gums_lower"] {
        assert_eq!(seen(rig, &rig.neutral, teeth), 0, "{teeth} show through closed lips");
    }
}

#[test]
fn every_channel_shows_in_the_markers_and_none_looks_like_another() {
    let head = &*HEAD;
    let rig = MarkerRig::of_vertices(&head.rig, &head.marker_vertices).unwrap();
    let mut jacobian = Vec::new();
    let mut at = MarkerPose::default();
    rig.pose(&[0.0; 53], &mut at);
    let rest = at.positions().to_vec();
    let responses: Vec<Vec<DVec3>> = (0..53)
        .map(|channel| {
            let mut weights = [0.0; 53];
            weights[channel] = 1.0;
            rig.pose(&weights, &mut at);
            rig.jacobian(&at, &mut jacobian);
            at.positions().iter().zip(&rest).map(|(moved, rest)| *moved - *rest).collect()
        })
        .collect();
    for (channel, response) in responses.iter().enumerate() {
        let most = response.iter().map(|delta| delta.length()).fold(0.0, f64::max);
        assert!(most > 0.0015, "{} moves no marker more than {most} m", CHANNELS[channel]);
        let head_moves = response[98..].iter().any(|delta| delta.length() > 0.0);
        assert!(!head_moves, "{} moves a head marker", CHANNELS[channel]);
    }
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    let mut worst: (f64, String) = (0.0, String::new());
    for a in 0..53 {
        for b in 0..a {
            let (x, y) = (&responses[a], &responses[b]);
            let cosine = dot(x, y) / (dot(x, x) * dot(y, y)).sqrt();
            // Channels at opposite ends of one motion can be told apart by their sign: weights are not negative.
            if cosine > worst.0 {
                worst = (cosine, format!("{} and {}", CHANNELS[a], CHANNELS[b]));
            }
        }
    }
    assert!(worst.0 < 0.9, "cosine {:.3} between {}", worst.0, worst.1);
}

#[test]
fn triangles_face_outwards() {
    let rig = &HEAD.rig;
    for part in &rig.parts {
        let mut outward = 0.0;
        let mut area = 0.0;
        // Six times the signed volume under a closed surface; for open ones, the flux of the field that points away
        // from the part's own middle (the head's middle for the skin and what lies on it).
        let points = &rig.neutral[part.vertices.start as usize..part.vertices.end as usize];
        let mean = points.iter().sum::<Vec3>() / points.len() as f32;
        let middle = match part.name.as_str() {
            "eyeball_L" | "eyeball_R" | "tongue" | "mouth_cavity" | "ear_L" | "ear_R" => mean,
            _ => Vec3::new(0.0, mean.y, 0.0),
        };
        for corners in &part.triangles {
            let [a, b, c] = corners.map(|vertex| rig.neutral[vertex as usize]);
            let normal = (b - a).cross(c - a);
            outward += normal.dot(((a + b + c) / 3.0 - middle).normalize());
            area += normal.length();
        }
        let share = outward / area;
        // The cavity is seen from within; teeth have backs; lips have insides.
        let least = match part.name.as_str() {
            "mouth_cavity" => {
                assert!(share < 0.0, "the cavity faces inwards: {share}");
                continue;
            }
            "teeth_upper" | "teeth_lower" | "lashes" => 0.02,
            "lips" => -0.2,
            "nostrils" => 0.1,
            "ear_L" | "ear_R" => 0.2,
            _ => 0.5,
        };
        assert!(share > least, "{}: {share}", part.name);
    }
}

#[test]
fn no_head_is_folded() {
    for identity in 0..8 {
        let rig = build(&Options { identity, density: 0.7, ..Options::default() }).unwrap().rig;
        let normals = smooth_normals(&rig, &rig.neutral);
        for part in &rig.parts[..2] {
            let folded = part.triangles.iter().filter(|corners| {
                let [a, b, c] = corners.map(|vertex| rig.neutral[vertex as usize]);
                let normal = (b - a).cross(c - a);
                corners.iter().all(|vertex| normals[*vertex as usize].dot(normal) < 0.0)
            });
            assert_eq!(folded.count(), 0, "{} of identity {identity}", part.name);
        }
    }
}

#[test]
fn building_twice_gives_the_same_head() {
    let options = Options { identity: 5, density: 0.6, ..Options::default() };
    let (a, b) = (build(&options).unwrap(), build(&options).unwrap());
    assert_eq!(a, b);
    assert_ne!(a.rig.neutral, build(&Options { identity: 6, ..options }).unwrap().rig.neutral);
}

#[test]
fn takes_are_the_jawed_head_with_a_little_noise() {
    let head = &*HEAD;
    let recorded = takes(head, 2, 200, 1).unwrap();
    assert_eq!(recorded, takes(head, 2, 200, 1).unwrap());
    assert_ne!(recorded[0].truth, recorded[1].truth);
    let jawed = skin_jaw(&head.rig, &SkinJawOptions::default()).unwrap().rig;
    let rig = MarkerRig::of_vertices(&jawed, &head.marker_vertices).unwrap();
    for take in &recorded {
        let exact = rig.drive(&take.truth).unwrap();
        let deviation = |marker: &str| {
            let column = take.markers.index(marker).unwrap();
            let sum: f32 =
                (0..200).map(|t| take.markers.frame(t)[column].distance_squared(exact.frame(t)[column])).sum();
            (sum / 600.0).sqrt() * 1000.0
        };
        let (brow, chin) = (deviation("brow_L_2"), deviation("jawline_08"));
        assert!((0.04..0.06).contains(&brow) && (0.13..0.17).contains(&chin), "{brow} {chin} mm");
    }
}

#[test]
fn options_out_of_bounds_are_refused() {
    let error = build(&Options { density: 9.0, ..Options::default() }).unwrap_err();
    assert!(matches!(error, SampleHeadError::Option { option: "density", .. }));
    assert!(error.to_string().contains("0.5 to 2"));
}
