//! What can be done, one file an action: each takes the state, changes it, and says what is to be done outside of it.
//!
//! [`update`] is the one way in: it takes a message, finds the action of a key, and runs it.

mod add;
mod cook;
mod curves;
mod delete;
mod edit_key;
mod edit_value;
mod find;
mod help;
mod item;
mod journal;
mod keys;
mod look;
mod mouse;
mod next_mistake;
mod open;
mod pan;
mod place;
mod port;
mod prompt;
mod quit;
mod rename;
mod save;
mod scrub;
mod select;
mod take;
mod undo;
mod wire;
mod worst_frame;
mod zoom;

pub use add::listed as listed_kinds;
pub use curves::channels_like as listed_channels;
pub use find::found as listed_nodes;
pub use help::{HELP_SIZE, columns, listed_keys};
pub use keys::update;
pub use wire::listed as listed_wires;

use crate::model::texts::Operation;
use crate::model::{Effect, State};
use graph_core::document::edit::{Change, Draft, EditFault};

/// What an action does: state → state and effects.
pub type Run = fn(&mut State) -> Vec<Effect>;

/// Something that can be done with a key.
pub struct Action {
    /// Its name in keymaps.
    pub name: &'static str,
    /// What it does, in a few words.
    pub does: &'static str,
    /// Doing it.
    pub run: Run,
}

const fn action(name: &'static str, does: &'static str, run: Run) -> Action {
    Action { name, does, run }
}

/// All actions, in the order in which help lists them.
pub const ACTIONS: &[Action] = &[
    action("left", "go to where the wire comes from", select::left),
    action("right", "go to where the wire leads", select::right),
    action("up", "the card above", select::up),
    action("down", "the card below", select::down),
    action("next_port", "the next port", port::next),
    action("previous_port", "the previous port", port::previous),
    action("next_item", "the next item of a list", item::next),
    action("open", "open a nested graph, or the parameters", open::open),
    action("leave", "back to the graph around", open::leave),
    action("zoom", "boxes or lines", zoom::zoom),
    action("centre", "centre the board", zoom::centre),
    action("pan_left", "move the board", pan::left),
    action("pan_right", "move the board", pan::right),
    action("pan_up", "move the board", pan::up),
    action("pan_down", "move the board", pan::down),
    action("find", "find a node by a few letters", find::find),
    action("add", "add a node that fits the port", add::add),
    action("wire", "wire the port", wire::wire),
    action("unwire", "take the port's wire away", wire::unwire),
    action("rename", "rename the node", rename::rename),
    action("delete", "delete the node", delete::delete),
    action("form", "the node's parameters", place::form),
    action("graph_params", "the graph's own parameters", place::graph_params),
    action("canvas", "back to the graph", place::canvas),
    action("next_place", "the next part of the screen", place::next),
    action("previous_place", "the previous part", place::previous),
    action("next_field", "the next parameter", edit_value::next),
    action("previous_field", "the previous parameter", edit_value::previous),
    action("edit_value", "edit the value", edit_value::begin),
    action("next_choice", "switch to the next choice", edit_value::next_choice),
    action("reset_value", "back to the default", edit_value::reset),
    action("preview", "show or hide the preview", look::preview),
    action("scrub_back", "a frame back", scrub::back),
    action("scrub_on", "a frame on", scrub::on),
    action("play", "play or stop", scrub::play),
    action("next_row", "the next channel", scrub::next_row),
    action("previous_row", "the previous channel", scrub::previous_row),
    action("turn_left", "turn the view", look::turn_left),
    action("turn_right", "turn the view", look::turn_right),
    action("turn_up", "tilt the view", look::turn_up),
    action("turn_down", "tilt the view", look::turn_down),
    action("nearer", "come nearer", look::nearer),
    action("farther", "go farther away", look::farther),
    action("curves", "work on the output's curves", curves::begin),
    action("end_curves", "back to the graph", curves::end),
    action("frame_back", "a frame back", curves::frame_back),
    action("frame_on", "a frame on", curves::frame_on),
    action("frames_back", "ten frames back", curves::frames_back),
    action("frames_on", "ten frames on", curves::frames_on),
    action("first_frame", "the first frame", curves::first_frame),
    action("last_frame", "the last frame", curves::last_frame),
    action("next_channel", "the next channel", curves::next_channel),
    action("previous_channel", "the previous channel", curves::previous_channel),
    action("find_channel", "find a channel by a few letters", curves::find_channel),
    action("set_key", "type a key's value, or +0.1", edit_key::ask),
    action("key_up", "key: a little more", edit_key::up),
    action("key_down", "key: a little less", edit_key::down),
    action("key_up_more", "key: much more", edit_key::up_more),
    action("key_down_more", "key: much less", edit_key::down_more),
    action("key_earlier", "move the key a frame back", edit_key::earlier),
    action("key_later", "move the key a frame on", edit_key::later),
    action("key_wider", "key: fade over more frames", edit_key::wider),
    action("key_narrower", "key: over fewer frames", edit_key::narrower),
    action("key_curve", "key: smooth, linear or hold", edit_key::curve),
    action("delete_key", "delete the key", edit_key::delete),
    action("next_key", "the channel's next key", edit_key::next),
    action("previous_key", "the channel's previous key", edit_key::previous),
    action("anchor", "anchor this frame, or not", edit_key::anchor),
    action("next_worst", "the next worst frame", worst_frame::next),
    action("previous_worst", "the previous worst frame", worst_frame::previous),
    action("next_region", "another region for the worst", curves::next_region),
    action("span", "more or fewer frames", curves::span),
    action("next_take", "the next take", curves::next_take),
    action("play_curves", "play or stop", curves::play),
    action("cook", "cook the graph", cook::all),
    action("cook_selected", "cook the node and what it needs", cook::selected),
    action("cancel", "cancel the cook", cook::cancel),
    action("next_mistake", "go to the next mistake", next_mistake::next_mistake),
    action("undo", "undo", undo::undo),
    action("redo", "redo", undo::redo),
    action("save", "save all files", save::save),
    action("help", "the keys", help::help),
    action("quit", "leave", quit::quit),
];

/// The names of all actions.
pub fn names() -> Vec<&'static str> {
    ACTIONS.iter().map(|action| action.name).collect()
}

/// Edits the open file: makes an operation of what `edit` finds to be changed.
fn edit(
    state: &mut State,
    label: impl Into<String>,
    edit: impl FnOnce(&Draft<'_>) -> Result<Vec<Change>, EditFault>,
) -> Result<Vec<Effect>, EditFault> {
    let file = state.level().file.clone();
    let Some(text) = state.texts.get(&file) else { return Ok(Vec::new()) };
    let changes = edit(&Draft::of(&text.now)?)?;
    let operation = state.texts.edit(label, &file, &changes);
    Ok(changed(state, operation))
}

/// What follows a change of the texts.
fn changed(state: &mut State, operation: Option<Operation>) -> Vec<Effect> {
    let Some(operation) = operation else { return Vec::new() };
    state.refresh();
    let mut effects = vec![Effect::Journal(operation)];
    if state.work.is_some() {
        // What shows is cooked at once; all else is looked at when the work ends.
        effects.extend(curves::refresh(state));
    } else {
        effects.push(Effect::Check);
    }
    effects.extend(unread(state));
    effects
}

/// Nested files that the boards name and that were not read yet.
fn unread(state: &State) -> Vec<Effect> {
    use crate::model::board::Role;
    let cards = state.trail.iter().flat_map(|level| &level.board.cards);
    let nested = cards.filter_map(|card| match &card.role {
        Role::Nested(_, Some(file)) if state.texts.get(file).is_none() => Some(Effect::Read(file.clone())),
        _ => None,
    });
    nested.collect()
}

/// Asks for the value that the preview shows, where it shows.
fn peek(state: &mut State) -> Vec<Effect> {
    if !state.preview_open || state.work.is_some() {
        return Vec::new();
    }
    let Some((cell, port)) = state.shown_output() else {
        state.preview.show_nothing();
        return Vec::new();
    };
    if state.preview.is_of(&cell, &port) {
        return Vec::new();
    }
    state.preview.ask(&cell, &port);
    vec![Effect::Peek(cell, port)]
}
