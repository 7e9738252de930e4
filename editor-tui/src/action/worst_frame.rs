//! Going to the frames in which the curves are farthest off, by what the graph's own node measured.

use crate::model::curves::region_title;
use crate::model::{Effect, State};

/// The next of the worst frames, the worst first.
pub fn next(state: &mut State) -> Vec<Effect> {
    go(state, |last, count| last.map_or(0, |last| (last + 1) % count))
}

/// The one before it.
pub fn previous(state: &mut State) -> Vec<Effect> {
    go(state, |last, count| last.map_or(0, |last| (last + count - 1) % count))
}

fn go(state: &mut State, step: impl Fn(Option<usize>, usize) -> usize) -> Vec<Effect> {
    let Some(work) = &mut state.work else { return Vec::new() };
    let Some(desk) = work.desk.clone() else { return Vec::new() };
    let frames = work.worst_frames();
    if frames.is_empty() {
        let known = desk.errors.is_some();
        state.complain(if known {
            "nothing was measured for this region"
        } else {
            "no `marker_error` of the graph measures these curves"
        });
        return Vec::new();
    }
    let rank = step(work.worst, frames.len());
    let (frame, error_mm) = frames[rank];
    (work.frame, work.worst) = (frame, Some(rank));
    let (number, region) = (work.frame_number(), work.region_name().map_or("", region_title).to_owned());
    state.say(format!("worst {} of {}: {error_mm:.2} mm off ({region}) at frame {number}", rank + 1, frames.len()));
    Vec::new()
}
