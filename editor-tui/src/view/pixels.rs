//! The preview in pixels, for terminals that draw pictures: what [`super::preview`] leaves room for.

use super::theme::Theme;
use super::{areas, body, preview};
use crate::model::{Overlay, State};
use crate::preview::Picture;
use ratatui::layout::Rect;
use std::sync::Arc;

/// What is looked at and how: where two are equal, so are their pictures.
#[derive(Debug, Clone)]
pub struct Look {
    /// The cells.
    pub area: Rect,
    cell_px: (u16, u16),
    picture: Arc<Picture>,
    frame: usize,
    row: usize,
    turn: [f32; 3],
}

impl PartialEq for Look {
    fn eq(&self, other: &Self) -> bool {
        let same = |own: &Self| (own.area, own.cell_px, own.frame, own.row, own.turn.map(f32::to_bits));
        same(self) == same(other) && Arc::ptr_eq(&self.picture, &other.picture)
    }
}

/// A picture and the cells that it lies on.
#[derive(Debug, Clone)]
pub struct Pixels {
    /// The cells.
    pub area: Rect,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Red, green and blue, row after row.
    pub colours: Vec<[u8; 3]>,
}

/// Behind what is shown.
const GROUND: [u8; 3] = [13, 14, 20];

/// Most pixels along a side: more cost more to send than they show.
const MOST: usize = 960;

/// What the preview shows in pixels, where it does; nothing may lie over it.
pub fn look(state: &State, theme: Theme) -> Option<Look> {
    let free = state.preview_open && state.work.is_none() && matches!(state.overlay, Overlay::None);
    let cell_px = theme.cell_px.filter(|_| free)?;
    let preview = &state.preview;
    let picture = preview.value.as_ref()?.as_ref().ok()?;
    matches!(&**picture, Picture::Body(_) | Picture::Image(_)).then(|| Look {
        area: preview::inner(areas(state).preview),
        cell_px,
        picture: Arc::clone(picture),
        frame: preview.frame,
        row: preview.row,
        turn: [preview.yaw_rad, preview.pitch_rad, preview.zoom],
    })
}

/// The picture in pixels; `None` where there is nothing to draw, or no room.
pub fn pixels(state: &State, look: &Look) -> Option<Pixels> {
    let (area, cell) = (look.area, look.cell_px);
    let (full_x, full_y) =
        (usize::from(area.width) * usize::from(cell.0), usize::from(area.height) * usize::from(cell.1));
    let shrink = full_x.max(full_y).div_ceil(MOST).max(1);
    let (width, height) = (full_x / shrink, full_y / shrink);
    if width < 8 || height < 8 {
        return None;
    }
    let drawn = match &*look.picture {
        Picture::Body(shown) => body::pixels(shown, &state.preview, width, height)?,
        Picture::Image(image) => body::fitted(image, width, height),
        Picture::Curves { .. } | Picture::Table(_) => return None,
    };
    let colours = drawn.into_iter().map(|colour| colour.unwrap_or(GROUND)).collect();
    Some(Pixels { area, width, height, colours })
}
