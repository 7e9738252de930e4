//! Frame ranges as studios write them: `1001-1100x2,1200`.

/// The frames that `text` names, in its order, each once: single frames, ranges `a-b`, and ranges with a step
/// `a-bxs`, with commas between them.
///
/// # Errors
/// Where the text is no such range, or names more than `limit` frames.
pub(super) fn frames(text: &str, limit: usize) -> Result<Vec<i64>, String> {
    let mut frames: Vec<i64> = Vec::new();
    for piece in text.split(',').map(str::trim) {
        let (first, last, step) = range(piece)
            .ok_or_else(|| format!("`{piece}` is no frame range; write frames such as `1200` or `1001-1100x2`"))?;
        if last < first {
            return Err(format!("`{piece}` ends before it begins"));
        }
        let mut frame = first;
        while frame <= last {
            if !frames.contains(&frame) {
                frames.push(frame);
            }
            if frames.len() > limit {
                return Err(format!("`{text}` names more than {limit} frames; take larger steps (`1001-1100x10`)"));
            }
            let Some(next) = frame.checked_add(step) else { break };
            frame = next;
        }
    }
    Ok(frames)
}

/// First frame, last frame and step.
fn range(piece: &str) -> Option<(i64, i64, i64)> {
    let (span, step) = match piece.split_once('x') {
        Some((span, step)) => (span, step.trim().parse().ok().filter(|step| *step > 0)?),
        None => (piece, 1),
    };
    // A minus at the beginning belongs to the number.
    let dash = span.char_indices().skip(1).find(|(_, letter)| *letter == '-').map(|(at, _)| at);
    let (first, last) = dash.map_or((span, span), |at| (&span[..at], &span[at + 1..]));
    Some((first.trim().parse().ok()?, last.trim().parse().ok()?, step))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_as_studios_write_them() {
        assert_eq!(frames("1001-1007x3, 1200", 10).unwrap(), [1001, 1004, 1007, 1200]);
        assert_eq!(frames("5,3-5", 10).unwrap(), [5, 3, 4]);
        assert_eq!(frames("-2--1", 10).unwrap(), [-2, -1]);
        assert_eq!(frames(&i64::MAX.to_string(), 10).unwrap(), [i64::MAX]);
    }

    #[test]
    fn what_is_no_range_is_refused() {
        for text in ["", "a", "1-", "1-5x0", "1-5x", "1,,2", "1.5"] {
            assert!(frames(text, 10).unwrap_err().contains("no frame range"), "{text}");
        }
        assert!(frames("9-1", 10).unwrap_err().contains("ends before"));
        assert!(frames("1-9000000000000000000", 10).unwrap_err().contains("more than 10 frames"));
    }
}
