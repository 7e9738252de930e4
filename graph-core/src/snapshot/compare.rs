//! Holds a reduced value against the one that a snapshot holds.

use super::golden::HeldTolerance;
use super::reduce::{Column, Reduced, ReducedTable, Statistics};
use serde::Serialize;
use std::collections::BTreeMap;
use wire::Tolerance;

/// How far a value agrees with its snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Agreement {
    /// Bit for bit.
    Equal,
    /// Within the tolerances.
    Within,
    /// Not.
    Differs,
}

/// A number or a fact that differs by more than it may.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// The table.
    pub table: String,
    /// The column; empty for what is said of the whole table.
    pub column: String,
    /// Where in it: `frame 1001`, `mean`, `rows`.
    pub place: String,
    /// What the snapshot holds.
    pub expected: String,
    /// What was found.
    pub found: String,
    /// How far they may lie apart, with the unit; empty for what must be equal.
    pub tolerance: String,
    /// How many tolerances they lie apart.
    #[serde(skip)]
    pub excess: f64,
}

/// What became of one value.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// How far it agrees.
    pub agreement: Agreement,
    /// What differs, the worst first.
    pub differences: Vec<Difference>,
    /// Numbers that were compared.
    pub compared: usize,
}

/// Compares what was `found` with what is `expected`. Tolerances are those of `own`, by table, unless the snapshot `held` others.
pub fn compare(
    expected: &Reduced,
    found: &Reduced,
    own: &BTreeMap<String, Tolerance>,
    held: &BTreeMap<String, HeldTolerance>,
) -> Verdict {
    if expected.digest == found.digest {
        return Verdict { agreement: Agreement::Equal, differences: Vec::new(), compared: 0 };
    }
    let mut work = Work { differences: Vec::new(), compared: 0 };
    if expected.tables.is_empty() && found.tables.is_empty() {
        work.fact("", "content", &expected.summary, &found.summary, true);
    }
    for name in expected.tables.keys().chain(found.tables.keys().filter(|name| !expected.tables.contains_key(*name))) {
        match (expected.tables.get(name), found.tables.get(name)) {
            (Some(expected), Some(found)) => {
                let held = held.get(name).map(|held| Tolerance { absolute: held.absolute, relative: held.relative });
                let tolerance = held.or_else(|| own.get(name).copied()).unwrap_or(Tolerance::absolute(0.0));
                work.table(name, expected, found, tolerance);
            }
            (expected, _) => {
                let told = |there: bool| if there { "there" } else { "not there" };
                work.fact(name, "table", told(expected.is_some()), told(expected.is_none()), true);
            }
        }
    }
    work.differences.sort_by(|a, b| b.excess.total_cmp(&a.excess));
    let agreement = if work.differences.is_empty() { Agreement::Within } else { Agreement::Differs };
    Verdict { agreement, differences: work.differences, compared: work.compared }
}

struct Work {
    differences: Vec<Difference>,
    compared: usize,
}

impl Work {
    /// Something that must be equal.
    fn fact(&mut self, table: &str, place: &str, expected: &str, found: &str, differs: bool) {
        if differs {
            self.differences.push(Difference {
                table: table.to_owned(),
                column: String::new(),
                place: place.to_owned(),
                expected: expected.to_owned(),
                found: found.to_owned(),
                tolerance: String::new(),
                excess: f64::INFINITY,
            });
        }
    }

    fn table(&mut self, name: &str, expected: &ReducedTable, found: &ReducedTable, tolerance: Tolerance) {
        self.fact(name, "unit", &expected.unit, &found.unit, expected.unit != found.unit);
        self.fact(name, "rows", &expected.rows, &found.rows, expected.rows != found.rows);
        let width = |table: &ReducedTable| format!("{} columns", table.width);
        self.fact(name, "columns", &width(expected), &width(found), expected.width != found.width);
        let mut place = Place { table: name, column: "", unit: &expected.unit, tolerance };
        self.statistics(&place, (&expected.all, &found.all));
        for (column, was) in &expected.columns {
            place.column = column;
            match found.columns.get(column) {
                Some(now) => self.column(&place, was, now, &expected.held, &found.held),
                None if expected.width == found.width => {
                    self.fact(name, &format!("column `{column}`"), "there", "not there", true);
                }
                None => {}
            }
        }
        for column in found.columns.keys().filter(|column| !expected.columns.contains_key(*column)) {
            if expected.width == found.width {
                self.fact(name, &format!("column `{column}`"), "not there", "there", true);
            }
        }
    }

    fn column(&mut self, place: &Place<'_>, was: &Column, now: &Column, held: &[String], now_held: &[String]) {
        let of = |column: &Column| Statistics {
            missing: column.missing,
            low: column.low,
            high: column.high,
            mean: column.mean,
        };
        self.statistics(place, (&of(was), &of(now)));
        self.number(place, "change from row to row", was.step, now.step);
        if held == now_held {
            for ((row, was), now) in held.iter().zip(&was.at).zip(&now.at) {
                self.number(place, row, *was, *now);
            }
        }
    }

    fn statistics(&mut self, place: &Place<'_>, (was, now): (&Statistics, &Statistics)) {
        if was.missing != now.missing {
            self.differences.push(Difference {
                table: place.table.to_owned(),
                column: place.column.to_owned(),
                place: "missing".to_owned(),
                expected: was.missing.to_string(),
                found: now.missing.to_string(),
                tolerance: String::new(),
                excess: f64::INFINITY,
            });
        }
        self.number(place, "least", was.low, now.low);
        self.number(place, "greatest", was.high, now.high);
        self.number(place, "mean", was.mean, now.mean);
    }

    fn number(&mut self, place: &Place<'_>, at: &str, was: f64, now: f64) {
        self.compared += 1;
        // The same number, infinities included, or missing in both.
        if was.to_bits() == now.to_bits() || (was.is_nan() && now.is_nan()) {
            return;
        }
        // Numbers are held with seven digits, of which the last may be rounded either way.
        let allowed = place.tolerance.at(was) + 1e-6 * was.abs().max(now.abs());
        let apart = (was - now).abs();
        if apart <= allowed {
            return;
        }
        let unit = if place.unit.is_empty() { String::new() } else { format!(" {}", place.unit) };
        self.differences.push(Difference {
            table: place.table.to_owned(),
            column: place.column.to_owned(),
            place: at.to_owned(),
            expected: format!("{was}{unit}"),
            found: format!("{now}{unit}"),
            tolerance: format!("{}{unit}", shown(place.tolerance, was)),
            excess: if apart.is_nan() { f64::INFINITY } else { apart / allowed },
        });
    }
}

fn shown(tolerance: Tolerance, at: f64) -> String {
    let allowed = tolerance.at(at);
    let text = format!("{allowed:.3e}").parse::<f64>().unwrap_or(allowed);
    text.to_string()
}

struct Place<'a> {
    table: &'a str,
    column: &'a str,
    unit: &'a str,
    tolerance: Tolerance,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(digest: &str, numbers: [f64; 3]) -> Reduced {
        let [low, mean, high] = [0, 1, 2].map(|at| numbers[at]);
        let column = Column { missing: 0, low, high, mean, step: 0.5, at: numbers.to_vec() };
        let table = ReducedTable {
            unit: "mm".into(),
            rows: "3 frames".into(),
            width: 1,
            all: Statistics { missing: 0, low, high, mean },
            held: ["frame 1", "frame 2", "frame 3"].map(str::to_owned).to_vec(),
            columns: BTreeMap::from([("chin x".to_owned(), column)]),
        };
        Reduced {
            digest: digest.into(),
            summary: String::new(),
            tables: BTreeMap::from([("positions".to_owned(), table)]),
        }
    }

    fn verdict(found: [f64; 3], absolute: f64, held: Option<f64>) -> Verdict {
        let own = BTreeMap::from([("positions".to_owned(), Tolerance::absolute(absolute))]);
        let held = held.map(|absolute| ("positions".to_owned(), HeldTolerance { absolute, relative: 0.0 }));
        compare(&value("a", [1.0, 2.0, 3.0]), &value("b", found), &own, &held.into_iter().collect())
    }

    #[test]
    fn what_is_within_the_tolerance_agrees() {
        assert_eq!(verdict([1.0, 2.005, 3.0], 0.01, None).agreement, Agreement::Within);
        let same = compare(&value("a", [1.0; 3]), &value("a", [9.0; 3]), &BTreeMap::new(), &BTreeMap::new());
        assert_eq!(same.agreement, Agreement::Equal);
    }

    #[test]
    fn what_is_not_is_told_with_its_place_and_unit_and_the_worst_first() {
        let found = verdict([1.0, 2.5, 3.02], 0.01, None);
        assert_eq!(found.agreement, Agreement::Differs);
        let worst = found.differences.iter().find(|one| one.place == "frame 2").unwrap();
        let told = (worst.column.as_str(), worst.expected.as_str(), worst.found.as_str(), worst.tolerance.as_str());
        assert_eq!(told, ("chin x", "2 mm", "2.5 mm", "0.01 mm"));
        assert!(found.differences.windows(2).all(|pair| pair[0].excess >= pair[1].excess));
    }

    #[test]
    fn a_tolerance_that_was_set_by_hand_counts() {
        assert_eq!(verdict([1.0, 2.5, 3.0], 0.01, Some(0.6)).agreement, Agreement::Within);
    }

    #[test]
    fn a_number_that_went_missing_differs() {
        assert_eq!(verdict([1.0, f64::NAN, 3.0], 10.0, None).agreement, Agreement::Differs);
    }
}
