//! Random numbers from a seed, for noise on markers and mixtures of motion: the same whatever runs beside them.

use glam::{DQuat, DVec3};

/// `SplitMix64`: a counter passed through a mixing function (Steele, Lea and Flood, "Fast splittable pseudorandom number
/// generators", OOPSLA 2014), and normal numbers from it by the method of Box and Muller (1958).
#[derive(Debug, Clone)]
pub(crate) struct Random {
    state: u64,
    spare: Option<f64>,
}

/// The counter's step: 2^64 divided by the golden ratio, made odd.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

fn mix(value: u64) -> u64 {
    let value = (value ^ (value >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    value ^ (value >> 31)
}

impl Random {
    /// A stream of its own for each `part` under `seed`.
    pub fn new(seed: u64, part: u64) -> Self {
        Self { state: mix(mix(seed.wrapping_add(GOLDEN)) ^ part.wrapping_add(1).wrapping_mul(GOLDEN)), spare: None }
    }

    /// A whole number below `bound`, which is above 0.
    pub fn below(&mut self, bound: usize) -> usize {
        ((self.unit() * bound as f64) as usize).min(bound.saturating_sub(1))
    }

    /// A number above 0 and not above 1.
    pub fn unit(&mut self) -> f64 {
        self.state = self.state.wrapping_add(GOLDEN);
        ((mix(self.state) >> 11) + 1) as f64 / 9_007_199_254_740_992.0
    }

    /// A normal number of mean 0 and standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let (radius, angle) = ((-2.0 * self.unit().ln()).sqrt(), std::f64::consts::TAU * self.unit());
        self.spare = Some(radius * angle.sin());
        radius * angle.cos()
    }

    /// Three normal numbers.
    pub fn vector(&mut self) -> DVec3 {
        let (x, y) = (self.normal(), self.normal());
        DVec3::new(x, y, self.normal())
    }

    /// A direction, all equally likely.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            if let Some(direction) = self.vector().try_normalize() {
                return direction;
            }
        }
    }

    /// A turn by `angle_rad` about a random axis.
    pub fn turn(&mut self, angle_rad: f64) -> DQuat {
        DQuat::from_axis_angle(self.direction(), angle_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moments_are_those_of_a_normal_number() {
        let mut numbers = Random::new(3, 0);
        let drawn: Vec<f64> = (0..100_000).map(|_| numbers.normal()).collect();
        let moment = |power: i32| drawn.iter().map(|number| number.powi(power)).sum::<f64>() / drawn.len() as f64;
        assert!(moment(1).abs() < 0.01 && (moment(2) - 1.0).abs() < 0.02, "{} {}", moment(1), moment(2));
        assert!(moment(3).abs() < 0.05 && (moment(4) - 3.0).abs() < 0.1, "{} {}", moment(3), moment(4));
    }

    #[test]
    fn streams_differ_by_seed_and_part_and_repeat() {
        let first = |seed, part| Random::new(seed, part).normal().to_bits();
        assert_eq!(first(1, 2), first(1, 2));
        assert_ne!(first(1, 2), first(2, 1));
        assert_ne!(first(1, 2), first(1, 3));
    }

    #[test]
    fn whole_numbers_are_all_as_likely() {
        let mut numbers = Random::new(9, 0);
        let mut counts = [0_usize; 5];
        (0..50_000).for_each(|_| counts[numbers.below(5)] += 1);
        assert!(counts.iter().all(|count| (9_600..10_400).contains(count)), "{counts:?}");
    }

    #[test]
    fn directions_lean_nowhere() {
        let mut numbers = Random::new(5, 0);
        let mean = (0..10_000).map(|_| numbers.direction()).sum::<DVec3>() / 10_000.0;
        assert!(mean.length() < 0.03, "{mean}");
        assert!((numbers.turn(0.2).to_axis_angle().1 - 0.2).abs() < 1e-12);
    }
}
