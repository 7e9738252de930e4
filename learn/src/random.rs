//! Random numbers from a seed: initial weights, the order of samples, dropped nodes.
//!
//! Every use draws from a stream of its own, found from the seed, the use and a count (the epoch, the step), so that
//! nothing but these has to be kept to go on where a training stopped.

/// What a stream of random numbers is for. The numbers are part of what makes a training repeatable: never renumber.
#[derive(Clone, Copy)]
pub(crate) enum Use {
    /// Initial weights; counted by layer.
    Weights = 1,
    /// The order of samples; counted by epoch.
    Order = 2,
    /// Dropped nodes; counted by step.
    Dropout = 3,
}

/// `SplitMix64`: a counter passed through a mixing function (Steele, Lea and Flood, "Fast splittable pseudorandom number
/// generators", OOPSLA 2014).
#[derive(Clone, Debug)]
pub(crate) struct Stream {
    state: u64,
}

/// The counter's step: 2^64 divided by the golden ratio, made odd.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// The mixing function of `SplitMix64`.
fn mix(value: u64) -> u64 {
    let value = (value ^ (value >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    value ^ (value >> 31)
}

impl Stream {
    /// The stream of one use and count under a seed.
    pub fn new(seed: u64, purpose: Use, count: usize) -> Self {
        let purposeful = mix(mix(seed.wrapping_add(GOLDEN)) ^ (purpose as u64).wrapping_mul(GOLDEN));
        Self { state: mix(purposeful ^ (count as u64).wrapping_add(1).wrapping_mul(GOLDEN)) }
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GOLDEN);
        mix(self.state)
    }

    /// A number from 0 (included) to 1 (excluded), with 24 random bits: all that an `f32` can hold.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (1.0 / 16_777_216.0)
    }

    /// A whole number below `bound`, as the high half of a 64 x 64 bit product. The bias is below bound / 2^64.
    fn below(&mut self, bound: usize) -> usize {
        ((u128::from(self.bits()) * bound as u128) >> 64) as usize
    }

    /// Puts the items in random order (Fisher and Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }

    /// The factors of inverted dropout for `count` nodes: 0 with the chance `dropout`, else 1 / (1 - dropout), so that the
    /// expected value of a node stays what it was (Srivastava et al. 2014, section 10).
    pub fn dropout(&mut self, dropout: f32, count: usize) -> Vec<f32> {
        let threshold = (f64::from(dropout) * 4_294_967_296.0) as u64;
        let kept = 1.0 / (1.0 - dropout);
        let mut factors = Vec::with_capacity(count + 1);
        while factors.len() < count {
            let bits = self.bits();
            for half in [bits & 0xFFFF_FFFF, bits >> 32] {
                factors.push(if half < threshold { 0.0 } else { kept });
            }
        }
        factors.truncate(count);
        factors
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "the compared numbers are exact")]
mod tests {
    use super::*;

    #[test]
    fn units_are_even() {
        let mut stream = Stream::new(7, Use::Weights, 0);
        let values: Vec<f64> = (0..100_000).map(|_| f64::from(stream.unit())).collect();
        let mean = values.iter().sum::<f64>() / 1e5;
        let square = values.iter().map(|value| value * value).sum::<f64>() / 1e5;
        assert!((mean - 0.5).abs() < 0.005, "{mean}");
        assert!((square - 1.0 / 3.0).abs() < 0.005, "{square}");
        assert!(values.iter().all(|value| (0.0..1.0).contains(value)));
    }

    #[test]
    fn streams_differ_by_seed_use_and_count() {
        let first = |seed, purpose, count| Stream::new(seed, purpose, count).bits();
        let base = first(1, Use::Order, 0);
        assert_eq!(base, first(1, Use::Order, 0));
        assert_ne!(base, first(2, Use::Order, 0));
        assert_ne!(base, first(1, Use::Dropout, 0));
        assert_ne!(base, first(1, Use::Order, 1));
    }

    #[test]
    fn shuffling_keeps_every_item() {
        let mut items: Vec<usize> = (0..1000).collect();
        Stream::new(3, Use::Order, 5).shuffle(&mut items);
        assert_ne!(items, (0..1000).collect::<Vec<_>>());
        items.sort_unstable();
        assert_eq!(items, (0..1000).collect::<Vec<_>>());
    }

    #[test]
    fn dropout_keeps_the_expected_value() {
        let factors = Stream::new(3, Use::Dropout, 9).dropout(0.25, 100_001);
        assert_eq!(factors.len(), 100_001);
        let dropped = factors.iter().filter(|factor| **factor == 0.0).count() as f64 / 100_001.0;
        assert!((dropped - 0.25).abs() < 0.006, "{dropped}");
        assert!(factors.iter().all(|factor| *factor == 0.0 || (*factor - 4.0 / 3.0).abs() < 1e-6));
    }
}
