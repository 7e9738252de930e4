//! Small numerical tools: smooth steps, kernels, interpolated tables, and reproducible random numbers.

use glam::Vec2;

/// 3t² − 2t³ with t = (x − low) / (high − low) held to 0..1.
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// (1 − r²)³ within the ellipse of half axes `radius` around `centre`, 0 outside: twice differentiable.
pub fn kernel(at: Vec2, centre: Vec2, radius: Vec2) -> f32 {
    let r2 = ((at - centre) / radius).length_squared();
    if r2 < 1.0 { (1.0 - r2).powi(3) } else { 0.0 }
}

/// exp(−r²/2) with r measured in the standard deviations `sigma`.
pub fn gauss(at: Vec2, centre: Vec2, sigma: Vec2) -> f32 {
    (-0.5 * ((at - centre) / sigma).length_squared()).exp()
}

/// A smooth maximum: equals max(a, b) where they differ by more than `width`, rounds the edge between.
pub fn soft_max(a: f32, b: f32, width: f32) -> f32 {
    let h = (width - (a - b).abs()).max(0.0) / width;
    a.max(b) + h * h * width * 0.25
}

/// A table over ascending arguments, read by cubic Hermite interpolation; its slopes are central differences.
/// Outside it keeps its first and last value.
pub fn interpolate<const N: usize>(table: &[(f32, [f32; N])], x: f32) -> [f32; N] {
    let last = table.len() - 1;
    if x <= table[0].0 {
        return table[0].1;
    }
    if x >= table[last].0 {
        return table[last].1;
    }
    let i = table.partition_point(|(at, _)| *at <= x) - 1;
    let slope = |k: usize, c: usize| {
        let (low, high) = (k.saturating_sub(1), (k + 1).min(last));
        (table[high].1[c] - table[low].1[c]) / (table[high].0 - table[low].0)
    };
    let step = table[i + 1].0 - table[i].0;
    let t = (x - table[i].0) / step;
    let (t2, t3) = (t * t, t * t * t);
    std::array::from_fn(|c| {
        (2.0 * t3 - 3.0 * t2 + 1.0) * table[i].1[c]
            + (t3 - 2.0 * t2 + t) * step * slope(i, c)
            + (3.0 * t2 - 2.0 * t3) * table[i + 1].1[c]
            + (t3 - t2) * step * slope(i + 1, c)
    })
}

/// Reproducible random numbers (`SplitMix64` of Steele, Lea and Flood, 2014).
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// A stream of its own for each seed.
    pub fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5DEE_CE66_D1CE_4E5B);
        random.next();
        random
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Evenly between `low` and `high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.next() >> 40) as f32 / (1u64 << 24) as f32)
    }

    /// One of 0..count.
    pub fn below(&mut self, count: usize) -> usize {
        (self.between(0.0, count as f32) as usize).min(count - 1)
    }

    /// True with the given probability.
    pub fn chance(&mut self, probability: f32) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// Normally distributed with mean 0 and deviation 1: the sum of twelve even numbers, so never beyond ±6.
    pub fn normal(&mut self) -> f32 {
        (0..12).map(|_| self.between(0.0, 1.0)).sum::<f32>() - 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_pass_through_their_points() {
        let table = [(0.0, [1.0]), (1.0, [3.0]), (4.0, [2.0])];
        for (at, value) in table {
            assert!((interpolate(&table, at)[0] - value[0]).abs() < 1e-6);
        }
        assert!((interpolate(&table, 9.0)[0] - 2.0).abs() < 1e-6);
    }

    #[test]
    fn random_numbers_repeat_and_spread() {
        let draw = |seed| {
            let mut random = Random::new(seed);
            (0..4000).map(|_| random.normal()).collect::<Vec<_>>()
        };
        assert_eq!(draw(7), draw(7));
        let values = draw(3);
        let mean = values.iter().sum::<f32>() / 4000.0;
        let variance = values.iter().map(|v| v * v).sum::<f32>() / 4000.0 - mean * mean;
        assert!(mean.abs() < 0.05 && (variance - 1.0).abs() < 0.08);
    }
}
