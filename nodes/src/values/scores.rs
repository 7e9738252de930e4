//! Scores: a few named numbers that say how good a result is, for people to read and snapshots to hold.

use wire::{Data, DecodeError, Decoder, Encoder, Rows, Table, Tolerance, Value, ValueKind};

/// How far a result is off: over all, and by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Scores {
    /// What was measured, with its unit: `root mean square difference of weights`.
    pub what: String,
    /// Over all.
    pub overall: f64,
    /// By name (channel or marker), in the order of what was measured.
    pub by_name: Vec<(String, f64)>,
}

impl Value for Scores {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&(&self.what, self.overall, &self.by_name));
    }

    fn summary(&self) -> String {
        let mut worst: Vec<_> = self.by_name.iter().collect();
        worst.sort_by(|a, b| b.1.total_cmp(&a.1));
        let worst: Vec<_> = worst.iter().take(3).map(|(name, score)| format!("{name} {score:.4}")).collect();
        let worst = if worst.is_empty() { String::new() } else { format!("; worst: {}", worst.join(", ")) };
        format!("{} {:.5}{worst}", self.what, self.overall)
    }

    fn size(&self) -> usize {
        self.by_name.len() * 48 + 64
    }

    fn tables(&self) -> Vec<Table<'_>> {
        let names = std::iter::once("overall").chain(self.by_name.iter().map(|(name, _)| name.as_str()));
        vec![Table {
            what: "scores",
            unit: "",
            tolerance: Tolerance { absolute: 1e-6, relative: 1e-2 },
            rows: Rows::Named("score", names.map(str::to_owned).collect()),
            columns: vec!["score".to_owned()],
            number: Box::new(|row, _| if row == 0 { self.overall } else { self.by_name[row - 1].1 }),
        }]
    }
}

impl Data for Scores {
    const NAME: &'static str = "Scores";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (what, overall, by_name) = input.record()?;
        Ok(Self { what, overall, by_name })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_tells_the_whole_and_the_worst_and_the_encoding_round_trips() {
        let by_name = ["a", "b", "c", "d"].map(str::to_owned).into_iter().zip([0.1, 0.4, 0.2, 0.3]).collect();
        let scores = Scores { what: "rms".into(), overall: 0.25, by_name };
        assert_eq!(scores.summary(), "rms 0.25000; worst: b 0.4000, d 0.3000, c 0.2000");
        let encoded = (&scores as &dyn Value).encoded();
        let decoded = (ValueKind::of::<Scores>().decode)(&encoded).unwrap();
        assert_eq!(decoded.downcast_ref::<Scores>(), Some(&scores));
    }
}
