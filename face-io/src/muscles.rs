//! Muscle files: which muscles a head has, in RON.
//!
//! ```text
//! (muscles: [
//!     (name: "zygomaticus_major", fibres: 3, both_sides: true,
//!      origin: [mix({15: 0.5, 45: 0.5})], waypoints: [], insertion: [landmark(54)]),
//! ])
//! ```

use crate::ReadError;
use face_math::strain::MusclePlan;

/// Why text is no file of muscles.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MusclesError {
    /// Bytes that are no UTF-8 text.
    #[error("byte {at} is not UTF-8 text; save the file as UTF-8")]
    NotText {
        /// Position of the byte.
        at: usize,
    },
    /// A mistake at a place of the text.
    #[error("{line}:{column}: {problem}")]
    At {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
    },
    /// Nothing at all.
    #[error("the file holds no muscles; write `(muscles: [(name: …, origin: […], insertion: […])])`")]
    Empty,
    /// A name that stands twice.
    #[error("muscle `{name}` stands twice; names must differ")]
    Twice {
        /// The name.
        name: String,
    },
}

/// Reads a file of muscles.
///
/// # Errors
/// See [`MusclesError`].
pub fn read(bytes: &[u8]) -> Result<MusclePlan, ReadError> {
    Ok(parse(bytes)?)
}

fn parse(bytes: &[u8]) -> Result<MusclePlan, MusclesError> {
    let text = std::str::from_utf8(bytes).map_err(|error| MusclesError::NotText { at: error.valid_up_to() })?;
    let plan: MusclePlan = ron::from_str(text).map_err(|error| MusclesError::At {
        line: error.span.start.line,
        column: error.span.start.col,
        problem: error.code.to_string(),
    })?;
    let mut seen = std::collections::BTreeSet::new();
    match plan.muscles.iter().find(|muscle| !seen.insert(muscle.name.as_str())) {
        Some(muscle) => Err(MusclesError::Twice { name: muscle.name.clone() }),
        None if plan.muscles.is_empty() => Err(MusclesError::Empty),
        None => Ok(plan),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn muscles_are_read_and_mistakes_have_a_place() {
        let one = "(name: \"m\", origin: [landmark(1)], insertion: [mix({2: 0.5, 3: 0.5})])";
        let plan = parse(format!("(muscles: [{one}])").as_bytes()).unwrap();
        assert_eq!((plan.muscles[0].fibres, plan.muscles[0].both_sides), (1, false));
        let wrong = parse(b"(muscles: [\n (name: \"m\", orign: [])])").unwrap_err().to_string();
        assert!(wrong.starts_with("2:") && wrong.contains("orign"), "{wrong}");
        assert!(matches!(parse(format!("(muscles: [{one}, {one}])").as_bytes()), Err(MusclesError::Twice { .. })));
        assert_eq!(parse(b"(muscles: [])"), Err(MusclesError::Empty));
        assert_eq!(parse(b"\xff"), Err(MusclesError::NotText { at: 0 }));
    }
}
