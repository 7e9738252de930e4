//! Damages files as disks, networks and editors do: bytes that flip, parts that go, come twice or come from nowhere.

use proptest::prelude::*;

/// One damage, at a place given as a fraction of the file.
#[derive(Debug, Clone)]
pub enum Harm {
    Flip { at: f64, bits: u8 },
    Set { at: f64, value: u8 },
    Cut { at: f64 },
    Drop { at: f64, length: usize },
    Insert { at: f64, bytes: Vec<u8> },
    Repeat { at: f64, length: usize },
}

impl Harm {
    pub fn apply(&self, bytes: &mut Vec<u8>) {
        let place = |at: f64| ((bytes.len() as f64 * at) as usize).min(bytes.len().saturating_sub(1));
        if bytes.is_empty() {
            return;
        }
        match self {
            Self::Flip { at, bits } => {
                let at = place(*at);
                bytes[at] ^= bits;
            }
            Self::Set { at, value } => {
                let at = place(*at);
                bytes[at] = *value;
            }
            Self::Cut { at } => bytes.truncate(place(*at)),
            Self::Drop { at, length } => {
                let at = place(*at);
                bytes.drain(at..(at + length).min(bytes.len()));
            }
            Self::Insert { at, bytes: new } => {
                let at = place(*at);
                bytes.splice(at..at, new.iter().copied());
            }
            Self::Repeat { at, length } => {
                let at = place(*at);
                let part = bytes[at..(at + length).min(bytes.len())].to_vec();
                bytes.splice(at..at, part);
            }
        }
    }
}

/// Where damage strikes: mostly at the start, where the counts are.
fn place() -> impl Strategy<Value = f64> {
    prop_oneof![0.0..1.0_f64, (0.0..1.0_f64).prop_map(|at| at * at * at * 0.1)]
}

/// A few damages.
pub fn harms() -> impl Strategy<Value = Vec<Harm>> {
    let noise = prop_oneof![
        prop::collection::vec(any::<u8>(), 1..40),
        "[0-9eE.,;\t\n\"#nNa-]{1,20}".prop_map(String::into_bytes),
    ];
    let one = prop_oneof![
        4 => (place(), any::<u8>()).prop_map(|(at, bits)| Harm::Flip { at, bits }),
        4 => (place(), prop_oneof![any::<u8>(), prop::sample::select(b",;\t\n\r\"0-9.\xff\x7f".to_vec())])
            .prop_map(|(at, value)| Harm::Set { at, value }),
        1 => place().prop_map(|at| Harm::Cut { at }),
        1 => (place(), 1..200_usize).prop_map(|(at, length)| Harm::Drop { at, length }),
        1 => (place(), noise).prop_map(|(at, bytes)| Harm::Insert { at, bytes }),
        1 => (place(), 1..300_usize).prop_map(|(at, length)| Harm::Repeat { at, length }),
    ];
    prop::collection::vec(one, 1..6)
}
