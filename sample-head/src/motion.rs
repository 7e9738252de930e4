//! Motions: what one channel, combination or in-between does at weight 1, to skin, jaw and eyeballs, in millimetres.

use crate::brushes::{self, Lip};
use crate::channels::mirrored;
use crate::features::{Features, Side, V_MOUTH};
use crate::jaw::{self, Rigid};
use crate::lids::{LidMove, Lids};
use crate::lips;
use crate::numbers::{kernel, smoothstep};
use crate::skin::{Place, Skin};
use glam::{Quat, Vec2, Vec3};

/// A whole motion.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Displacement of each vertex of the skin.
    pub skin: Vec<Vec3>,
    /// What the jaw's bone does.
    pub jaw: Option<Rigid>,
    /// How the eyeballs turn: the performer's left, then right.
    pub eyes: [Option<Quat>; 2],
}

/// Everything that motions are computed from.
#[derive(Debug)]
pub struct Mover<'a> {
    features: &'a Features,
    skin: &'a Skin,
    lids: Lids,
    /// How much each vertex of the skin follows the jaw.
    pub jaw_share: Vec<f32>,
    /// Which part of each vertex is lower lip, for brushes that move one lip only.
    lower: Vec<f32>,
}

/// How the lids follow the eyes, and shut.
fn lid_move(channel: &str) -> Option<LidMove> {
    let (upper, lower) = match channel {
        "eyeBlink_L" => return Some(LidMove::SHUT),
        "eyeLookDown_L" => (0.40, -0.14),
        "eyeLookUp_L" => (-0.16, 0.06),
        "eyeSquint_L" => (0.16, 0.34),
        "eyeWide_L" => (-0.26, -0.06),
        "cheekSquint_L" => (0.02, 0.16),
        "mouthSmile_L" => (0.0, 0.05),
        _ => return None,
    };
    Some(LidMove { upper, lower })
}

/// How far the left eyeball turns, towards +X about Y and downwards about X.
fn eye_turn(channel: &str) -> Option<Quat> {
    let degrees = |angle: f32| angle.to_radians();
    match channel {
        "eyeLookDown_L" => Some(Quat::from_rotation_x(degrees(27.0))),
        "eyeLookUp_L" => Some(Quat::from_rotation_x(degrees(-23.0))),
        "eyeLookIn_L" => Some(Quat::from_rotation_y(degrees(-30.0))),
        "eyeLookOut_L" => Some(Quat::from_rotation_y(degrees(30.0))),
        _ => None,
    }
}

impl<'a> Mover<'a> {
    /// Measures skin and lids.
    pub fn new(features: &'a Features, skin: &'a Skin) -> Self {
        let outside = |vertex: u32| &skin.points[skin.points[vertex as usize].edge as usize];
        let count = skin.points.len() as u32;
        let jaw_share = (0..count).map(|vertex| jaw::share(features, outside(vertex))).collect();
        let lower = (0..count)
            .map(|vertex| {
                let (along, up) = jaw::from_corner(features, outside(vertex));
                smoothstep(0.6, -0.6, up.atan2(along) / std::f32::consts::PI)
            })
            .collect();
        Self { features, skin, lids: Lids::new(features, skin), jaw_share, lower }
    }

    /// The motion of a shape of the given name.
    pub fn motion(&self, name: &str) -> Motion {
        // What stands for the right side is the mirror image of what stands for the left.
        let right = name.split(['+', '@']).any(|channel| channel.ends_with("_R") || channel.ends_with("Right"));
        if right {
            return self.mirror(&self.motion(&mirrored(name)));
        }
        if let Some((channel, peak)) = name.split_once('@') {
            return self.in_between(channel, peak.parse().unwrap_or(0.5));
        }
        match name.split_once('+') {
            None => self.channel(name),
            Some((a, b)) => self.combination(a, b),
        }
    }

    fn still(&self) -> Motion {
        Motion { skin: vec![Vec3::ZERO; self.skin.points.len()], jaw: None, eyes: [None, None] }
    }

    fn mirror(&self, motion: &Motion) -> Motion {
        let flip = |turn: Quat| Quat::from_xyzw(turn.x, -turn.y, -turn.z, turn.w);
        let skin = self.skin.mirror.iter().map(|vertex| motion.skin[*vertex as usize] * Vec3::new(-1.0, 1.0, 1.0));
        Motion {
            skin: skin.collect(),
            jaw: motion.jaw.map(|jaw| Rigid { turn: flip(jaw.turn), shift: jaw.shift * Vec3::new(-1.0, 1.0, 1.0) }),
            eyes: [motion.eyes[1].map(flip), motion.eyes[0].map(flip)],
        }
    }

    fn channel(&self, channel: &str) -> Motion {
        let mut motion = self.still();
        motion.jaw = jaw::motion(channel);
        motion.eyes[0] = eye_turn(channel);
        let lids = lid_move(channel);
        for (index, point) in self.skin.points.iter().enumerate() {
            let edge = &self.skin.points[point.edge as usize];
            let mut delta = self.brushed(channel, index);
            delta += lips::delta(self.features, channel, point, edge.at);
            if let Some(go) = lids {
                delta += self.lids.delta(point, go);
            }
            if let Some(jaw) = motion.jaw {
                delta += jaw.delta(point.at) * self.jaw_share[index];
            }
            motion.skin[index] = delta;
        }
        if channel == "mouthClose" {
            self.close_lips(&mut motion);
        }
        motion
    }

    /// The sum of a channel's brushes at a vertex; it slides over the bare head and leaves the lids to themselves.
    fn brushed(&self, channel: &str, index: usize) -> Vec3 {
        let point = &self.skin.points[index];
        let at = self.skin.points[point.edge as usize].at;
        if at.z < 0.0 || matches!(point.place, Place::BehindLid(_)) {
            return Vec3::ZERO;
        }
        let mut pull = Vec3::ZERO;
        for brush in brushes::of(channel) {
            let weight = kernel(at.truncate(), Vec2::from(brush.centre), Vec2::from(brush.radius));
            let lip = match brush.lip {
                Lip::Both => 1.0,
                Lip::Upper => 1.0 - self.lower[index],
                Lip::Lower => self.lower[index],
            };
            pull += Vec3::from(brush.pull) * (weight * lip);
        }
        if pull == Vec3::ZERO {
            return pull;
        }
        let lid = self.lids.hold(point).max(self.lids.hold(&self.skin.points[self.skin.mirror[index] as usize]));
        // The sides of the head do not move.
        let pull = pull * ((1.0 - lid) * smoothstep(8.0, 42.0, at.z));
        let skull = &self.features.skull;
        let slide = skull.depth(at.x + pull.x, at.y + pull.y) - skull.depth(at.x, at.y);
        pull + Vec3::Z * slide.clamp(-8.0, 8.0)
    }

    /// Brings the lips of an open mouth together: where `jawOpen` has parted a column of the slit, the lower edge goes
    /// up by most of the gap and the upper edge comes down by the rest.
    fn close_lips(&self, motion: &mut Motion) {
        let open = self.channel("jawOpen");
        let slit = &self.skin.mouth;
        let gaps: Vec<(f32, Vec3)> = slit
            .upper
            .iter()
            .zip(&slit.lower)
            .map(|(upper, lower)| {
                let parted = open.skin[*upper as usize] - open.skin[*lower as usize];
                (self.skin.points[*upper as usize].u, parted)
            })
            .collect();
        for (index, point) in self.skin.points.iter().enumerate() {
            let share = lips::closing(self.features, point);
            if share <= 0.0 {
                continue;
            }
            let next = gaps.partition_point(|(u, _)| *u < point.u).clamp(1, gaps.len() - 1);
            let ((u0, a), (u1, b)) = (gaps[next - 1], gaps[next]);
            let gap = a.lerp(b, ((point.u - u0) / (u1 - u0)).clamp(0.0, 1.0));
            let lower = point.v < V_MOUTH || (point.v == V_MOUTH && point.side == Side::Lower);
            motion.skin[index] += gap * share * if lower { 0.78 } else { -0.20 };
        }
    }

    /// What is missing at half a blink when the lids go straight instead of around the eyeball.
    fn in_between(&self, channel: &str, peak: f32) -> Motion {
        let mut motion = self.still();
        let Some(go) = lid_move(channel) else { return motion };
        for (index, point) in self.skin.points.iter().enumerate() {
            motion.skin[index] = self.lids.delta(point, go.times(peak)) - self.lids.delta(point, go) * peak;
        }
        motion
    }

    /// What is missing (or too much) when two channels act at once.
    fn combination(&self, a: &str, b: &str) -> Motion {
        let mut motion = self.still();
        let stem = |name: &str| name.trim_end_matches("_L").to_owned();
        match (stem(a).as_str(), stem(b).as_str()) {
            // Shut lids are shut already: take back what the second channel adds to them.
            ("eyeBlink", "eyeLookDown" | "eyeSquint") => {
                if let Some(go) = lid_move(b) {
                    for (index, point) in self.skin.points.iter().enumerate() {
                        motion.skin[index] = -self.lids.delta(point, go);
                    }
                }
            }
            // The cheek is raised already.
            ("cheekSquint", "mouthSmile") => self.add_brushes(&mut motion, "cheekSquint_L", -0.35),
            ("jawOpen", "mouthSmile") => {
                self.paint(&mut motion, [25.0, -36.0], [24.0, 24.0], [-1.8, -2.6, -1.2], Lip::Both);
                self.paint(&mut motion, [11.0, -28.0], [18.0, 14.0], [0.0, 1.8, 0.0], Lip::Upper);
            }
            ("jawOpen", "mouthStretch") => {
                self.paint(&mut motion, [26.0, -38.0], [24.0, 24.0], [-2.2, 1.2, -0.6], Lip::Both);
                self.paint(&mut motion, [13.0, -42.0], [18.0, 14.0], [0.4, -1.6, -0.4], Lip::Lower);
            }
            ("jawOpen", "mouthPucker") => {
                for sign in [1.0, -1.0] {
                    self.paint(&mut motion, [sign * 14.0, -36.0], [20.0, 22.0], [sign * -1.6, 0.0, 1.4], Lip::Both);
                }
                self.paint(&mut motion, [0.0, -42.0], [22.0, 16.0], [0.0, 3.2, 1.0], Lip::Lower);
            }
            ("jawOpen", "mouthFunnel") => {
                self.paint(&mut motion, [0.0, -42.0], [24.0, 16.0], [0.0, 2.4, 0.4], Lip::Lower);
                self.paint(&mut motion, [0.0, -28.0], [24.0, 14.0], [0.0, -1.4, 0.4], Lip::Upper);
            }
            ("mouthFunnel", "mouthPucker") => self.add_lips(&mut motion, "mouthFunnel", -0.35),
            _ => {}
        }
        motion
    }

    fn add_brushes(&self, motion: &mut Motion, channel: &str, factor: f32) {
        for (index, delta) in motion.skin.iter_mut().enumerate() {
            *delta += self.brushed(channel, index) * factor;
        }
    }

    fn add_lips(&self, motion: &mut Motion, channel: &str, factor: f32) {
        for (point, delta) in self.skin.points.iter().zip(&mut motion.skin) {
            let edge = &self.skin.points[point.edge as usize];
            *delta += lips::delta(self.features, channel, point, edge.at) * factor;
        }
    }

    fn paint(&self, motion: &mut Motion, centre: [f32; 2], radius: [f32; 2], pull: [f32; 3], lip: Lip) {
        for (index, (point, delta)) in self.skin.points.iter().zip(&mut motion.skin).enumerate() {
            let at = self.skin.points[point.edge as usize].at;
            if at.z > 0.0 {
                let side = match lip {
                    Lip::Both => 1.0,
                    Lip::Upper => 1.0 - self.lower[index],
                    Lip::Lower => self.lower[index],
                };
                let weight = kernel(at.truncate(), Vec2::from(centre), Vec2::from(radius)) * side;
                *delta += Vec3::from(pull) * weight;
            }
        }
    }
}
