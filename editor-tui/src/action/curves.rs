//! Curve work: begun at a curves output, ended, brought up to date, and moved about in.

use super::peek;
use crate::model::catalogue::closeness;
use crate::model::curves::{CurveWork, SPANS, regions};
use crate::model::line::Line;
use crate::model::{Ask, Cooking, Effect, Focus, Overlay, State};

/// Begins work on the curves of the selected output.
pub fn begin(state: &mut State) -> Vec<Effect> {
    let Some(of) = state.shown_output() else {
        state.complain("select an output that gives curves first");
        return Vec::new();
    };
    let mut work = CurveWork::new(of);
    (work.frame, work.channel) = (state.preview.frame, state.preview.row);
    state.work = Some(work);
    state.focus = Focus::Curves;
    refresh(state)
}

/// Ends it.
pub fn end(state: &mut State) -> Vec<Effect> {
    if let Some(work) = state.work.take() {
        (state.preview.frame, state.preview.row) = (work.frame, work.channel);
    }
    state.focus = Focus::Canvas;
    state.preview.forget();
    let mut effects = peek(state);
    effects.push(Effect::Check);
    effects
}

/// Has what is worked on cooked as the texts are now; while a cook runs, this waits for its end.
pub fn refresh(state: &mut State) -> Vec<Effect> {
    let Some(work) = state.work.as_mut().filter(|_| state.cooking.is_none()) else { return Vec::new() };
    work.asked_of = Some(state.texts.revision);
    state.cooking = Some(Cooking { revision: state.texts.revision, ..Cooking::default() });
    vec![Effect::Work(work.of.0.clone(), work.of.1.clone())]
}

/// Reads the file of edits where that is not known yet.
pub fn unread(state: &State) -> Vec<Effect> {
    let file = state.work.as_ref().and_then(|work| work.desk.as_ref()).map(|desk| desk.file.clone());
    let file = file.filter(|file| state.texts.get(file).is_none());
    file.map(Effect::Read).into_iter().collect()
}

fn scrub(state: &mut State, by: isize) -> Vec<Effect> {
    if let Some(work) = &mut state.work {
        work.scrub(by);
    }
    Vec::new()
}

/// A frame back.
pub fn frame_back(state: &mut State) -> Vec<Effect> {
    scrub(state, -1)
}

/// A frame on.
pub fn frame_on(state: &mut State) -> Vec<Effect> {
    scrub(state, 1)
}

/// Ten frames back.
pub fn frames_back(state: &mut State) -> Vec<Effect> {
    scrub(state, -10)
}

/// Ten frames on.
pub fn frames_on(state: &mut State) -> Vec<Effect> {
    scrub(state, 10)
}

/// The first frame.
pub fn first_frame(state: &mut State) -> Vec<Effect> {
    scrub(state, isize::MIN)
}

/// The last frame.
pub fn last_frame(state: &mut State) -> Vec<Effect> {
    scrub(state, isize::MAX)
}

/// Plays, or stops.
pub fn play(state: &mut State) -> Vec<Effect> {
    if let Some(work) = &mut state.work {
        work.playing = !work.playing;
    }
    Vec::new()
}

/// More or fewer frames in the chart.
pub fn span(state: &mut State) -> Vec<Effect> {
    if let Some(work) = &mut state.work {
        let at = SPANS.iter().position(|span| *span == work.span).map_or(0, |at| at + 1);
        work.span = SPANS[at % SPANS.len()];
    }
    Vec::new()
}

fn step(state: &mut State, by: isize) -> Vec<Effect> {
    if let Some(work) = &mut state.work {
        let channels = work.desk.as_ref().map_or(0, |desk| desk.edited.channels().len());
        work.channel = work.channel.saturating_add_signed(by).min(channels.saturating_sub(1));
    }
    Vec::new()
}

/// The next channel.
pub fn next_channel(state: &mut State) -> Vec<Effect> {
    step(state, 1)
}

/// The previous channel.
pub fn previous_channel(state: &mut State) -> Vec<Effect> {
    step(state, -1)
}

/// Asks for letters of a channel's name.
pub fn find_channel(state: &mut State) -> Vec<Effect> {
    if state.work.as_ref().is_some_and(|work| work.desk.is_some()) {
        state.overlay = Overlay::Prompt { ask: Ask::Channel, line: Line::default(), error: None };
    }
    Vec::new()
}

/// The channels that the letters may mean, the likeliest first.
pub fn channels_like<'a>(state: &'a State, typed: &str) -> Vec<&'a str> {
    let desk = state.work.as_ref().and_then(|work| work.desk.as_ref());
    let channels = desk.map_or(&[][..], |desk| desk.edited.channels());
    let near = channels.iter().enumerate().filter_map(|(at, name)| Some((closeness(typed, name)?, at, name.as_str())));
    let mut near: Vec<(u32, usize, &str)> = near.collect();
    near.sort_unstable();
    near.into_iter().map(|(_, _, name)| name).collect()
}

/// Goes to the likeliest.
pub fn channel_found(state: &mut State, typed: &str) -> Result<Vec<Effect>, String> {
    let name = channels_like(state, typed).first().map(|name| (*name).to_owned());
    let name = name.ok_or_else(|| format!("no channel is called like `{typed}`"))?;
    if let Some(work) = &mut state.work {
        let found = work.desk.as_ref().and_then(|desk| desk.edited.index(&name));
        work.channel = found.unwrap_or(work.channel);
    }
    Ok(Vec::new())
}

/// The next row of errors for the worst frames to go by.
pub fn next_region(state: &mut State) -> Vec<Effect> {
    if let Some(work) = &mut state.work {
        let rows = work.desk.as_ref().map_or(0, |desk| regions(desk).len());
        (work.region, work.worst) = ((work.region + 1) % rows.max(1), None);
    }
    Vec::new()
}

/// The same take's curves for the next item of the list.
pub fn next_take(state: &mut State) -> Vec<Effect> {
    let Some(work) = &state.work else { return Vec::new() };
    let Some(desk) = &work.desk else { return Vec::new() };
    let Some((path, item)) = desk.cell.split_once('@') else {
        state.complain("these curves are cooked once, not for items");
        return Vec::new();
    };
    let items: Vec<&String> = state.statuses.tally(path).map(|tally| tally.items.keys().collect()).unwrap_or_default();
    let at = items.iter().position(|known| *known == item).map_or(0, |at| at + 1);
    let Some(next) = items.get(at % items.len().max(1)).map(|item| (*item).clone()) else { return Vec::new() };
    let mut then = CurveWork::new((format!("{path}@{next}"), "curves".to_owned()));
    (then.channel, then.region, then.span) = (work.channel, work.region, work.span);
    state.item = Some(next);
    state.work = Some(then);
    refresh(state)
}
