//! Brushes: where on the face a channel pulls, how far around, and which way. Left channels only; right ones are
//! mirror images.

/// Which lip a brush moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lip {
    /// Both, and all other skin.
    Both,
    /// What does not go with the jaw.
    Upper,
    /// What goes with the jaw.
    Lower,
}

/// One pull, in millimetres over the face plane.
#[derive(Debug, Clone, Copy)]
pub struct Brush {
    /// Centre x, y.
    pub centre: [f32; 2],
    /// Half axes of the ellipse beyond which nothing moves.
    pub radius: [f32; 2],
    /// Displacement at the centre: x and y along the head's surface, z on top of following it.
    pub pull: [f32; 3],
    /// Which lip.
    pub lip: Lip,
}

const fn both(centre: [f32; 2], radius: [f32; 2], pull: [f32; 3]) -> Brush {
    Brush { centre, radius, pull, lip: Lip::Both }
}

const fn upper(centre: [f32; 2], radius: [f32; 2], pull: [f32; 3]) -> Brush {
    Brush { centre, radius, pull, lip: Lip::Upper }
}

const fn lower(centre: [f32; 2], radius: [f32; 2], pull: [f32; 3]) -> Brush {
    Brush { centre, radius, pull, lip: Lip::Lower }
}

/// The brushes of a channel; empty for channels that only move jaw, lids or eyeballs.
#[rustfmt::skip]
pub fn of(channel: &str) -> &'static [Brush] {
    match channel {
        "browDown_L" => const { &[
            both([26.0, 56.0], [34.0, 22.0], [-1.8, -5.6, 0.6]),
            both([10.0, 52.0], [17.0, 15.0], [-2.2, -2.6, 1.2]),
            both([33.0, 46.0], [24.0, 10.0], [0.0, -1.6, 0.4]),
        ] },
        "browInnerUp_L" => const { &[
            both([10.0, 60.0], [29.0, 30.0], [0.6, 8.0, 0.2]),
            both([10.0, 82.0], [24.0, 20.0], [0.0, 2.2, 0.5]),
        ] },
        "browOuterUp_L" => const { &[
            both([42.0, 59.0], [34.0, 27.0], [0.8, 7.8, 0.0]),
            both([42.0, 47.0], [20.0, 9.0], [0.0, 2.0, 0.3]),
        ] },
        "cheekPuff_L" => const { &[
            both([46.0, -27.0], [40.0, 38.0], [6.5, -0.5, 10.5]),
            both([22.0, -20.0], [16.0, 16.0], [0.5, 0.0, 2.0]),
        ] },
        "cheekSquint_L" => const { &[
            both([38.0, 12.0], [30.0, 21.0], [0.8, 5.6, 2.8]),
            both([52.0, 28.0], [16.0, 14.0], [-1.0, 1.5, 0.5]),
        ] },
        "eyeSquint_L" => const { &[
            both([33.0, 22.0], [23.0, 12.0], [0.0, 2.6, 0.9]),
            both([52.0, 34.0], [13.0, 13.0], [-2.4, 0.0, 0.3]),
        ] },
        "eyeWide_L" => const { &[both([32.0, 52.0], [24.0, 12.0], [0.0, 1.4, 0.0])] },
        "jawOpen" => const { &[
            both([26.0, -36.0], [22.0, 22.0], [-2.6, 0.0, -1.0]),
            both([-26.0, -36.0], [22.0, 22.0], [2.6, 0.0, -1.0]),
            upper([0.0, -27.0], [24.0, 14.0], [0.0, -0.5, -0.6]),
            upper([15.0, -32.0], [15.0, 13.0], [0.6, 2.4, 0.3]),
            upper([-15.0, -32.0], [15.0, 13.0], [-0.6, 2.4, 0.3]),
            lower([16.0, -37.0], [15.0, 13.0], [0.8, -3.0, 0.0]),
            lower([-16.0, -37.0], [15.0, 13.0], [-0.8, -3.0, 0.0]),
        ] },
        "mouthDimple_L" => const { &[
            both([27.0, -34.0], [17.0, 16.0], [4.2, 0.6, -3.4]),
            both([37.0, -32.0], [12.0, 14.0], [1.0, 0.0, -1.2]),
        ] },
        "mouthFrown_L" => const { &[
            both([25.0, -36.0], [22.0, 18.0], [0.8, -7.2, -0.6]),
            lower([14.0, -43.0], [15.0, 12.0], [0.0, -1.8, 0.2]),
            both([33.0, -54.0], [20.0, 18.0], [0.0, -2.6, 0.4]),
        ] },
        "mouthLeft" => const { &[
            both([0.0, -36.0], [50.0, 27.0], [8.5, 0.0, 0.0]),
            both([25.0, -34.0], [20.0, 18.0], [1.5, 1.0, 0.0]),
            both([0.0, -10.0], [18.0, 14.0], [1.2, 0.0, 0.0]),
        ] },
        "mouthLowerDown_L" => const { &[
            lower([13.0, -41.0], [20.0, 20.0], [1.2, -7.6, 0.4]),
            both([16.0, -56.0], [18.0, 16.0], [0.8, -2.2, 0.0]),
        ] },
        "mouthShrugLower" => const { &[
            both([0.0, -64.0], [32.0, 24.0], [0.0, 5.6, 1.4]),
            lower([0.0, -45.0], [30.0, 16.0], [0.0, 2.4, 2.8]),
            upper([0.0, -28.0], [24.0, 12.0], [0.0, 1.8, 0.8]),
        ] },
        "mouthShrugUpper" => const { &[
            upper([0.0, -26.0], [28.0, 17.0], [0.0, 4.2, 3.2]),
            lower([0.0, -38.0], [22.0, 10.0], [0.0, 1.6, 0.8]),
        ] },
        "mouthSmile_L" => const { &[
            both([26.0, -33.0], [31.0, 25.0], [8.4, 8.2, -0.6]),
            both([38.0, -3.0], [26.0, 22.0], [1.4, 3.8, 4.2]),
            both([33.0, -15.0], [9.0, 18.0], [0.4, 0.4, -0.8]),
            upper([12.0, -26.0], [16.0, 14.0], [1.0, 1.6, -0.8]),
            lower([10.0, -42.0], [16.0, 12.0], [1.0, 0.6, -1.0]),
        ] },
        "mouthStretch_L" => const { &[
            both([27.0, -38.0], [29.0, 24.0], [9.2, -3.6, -1.2]),
            both([44.0, -62.0], [28.0, 26.0], [2.4, -3.2, 0.6]),
        ] },
        "mouthUpperUp_L" => const { &[
            upper([11.0, -28.0], [20.0, 19.0], [0.6, 6.6, 0.6]),
            both([20.0, -12.0], [17.0, 16.0], [0.6, 2.2, 1.0]),
        ] },
        "noseSneer_L" => const { &[
            both([13.0, -4.0], [14.0, 15.0], [0.8, 5.2, 0.0]),
            both([13.0, 17.0], [17.0, 17.0], [-1.2, 3.4, 1.4]),
            upper([13.0, -25.0], [15.0, 13.0], [0.6, 3.0, 0.4]),
            both([11.0, 48.0], [14.0, 12.0], [-0.8, -1.8, 0.6]),
        ] },
        _ => const { &[] },
    }
}
