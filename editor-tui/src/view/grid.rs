//! A grid of wires: lines of box characters that join where they belong together and pass over each other where they do not.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};

/// To which sides a line goes from a cell.
pub const UP: u8 = 1;
/// See [`UP`].
pub const DOWN: u8 = 2;
/// See [`UP`].
pub const LEFT: u8 = 4;
/// See [`UP`].
pub const RIGHT: u8 = 8;

#[derive(Clone, Copy)]
struct Cell {
    sides: u8,
    wire: u32,
    colour: Color,
    strong: bool,
}

/// The wires on a part of the screen.
pub struct Grid {
    area: Rect,
    cells: Vec<Cell>,
}

/// How a wire is drawn.
#[derive(Clone, Copy)]
pub struct Ink {
    /// Which wire; lines of one wire join.
    pub wire: u32,
    /// Its colour.
    pub colour: Color,
    /// Whether it is stressed.
    pub strong: bool,
}

impl Grid {
    /// No wires.
    pub fn new(area: Rect) -> Self {
        let blank = Cell { sides: 0, wire: 0, colour: Color::Reset, strong: false };
        Self { area, cells: vec![blank; usize::from(area.width) * usize::from(area.height)] }
    }

    fn put(&mut self, x: i32, y: i32, sides: u8, ink: Ink) {
        let (width, height) = (i32::from(self.area.width), i32::from(self.area.height));
        if x < 0 || y < 0 || x >= width || y >= height || sides == 0 {
            return;
        }
        let cell = &mut self.cells[(y * width + x) as usize];
        if cell.sides != 0 && cell.wire == ink.wire {
            cell.sides |= sides;
            cell.strong |= ink.strong;
            return;
        }
        // A stressed wire passes over others; among equals, what turns or goes up and down does.
        let over =
            cell.sides == 0 || (ink.strong && !cell.strong) || (ink.strong == cell.strong && sides & (UP | DOWN) != 0);
        if over {
            *cell = Cell { sides, wire: ink.wire, colour: ink.colour, strong: ink.strong };
        }
    }

    /// A level line, with `from` and `to` in it.
    pub fn level(&mut self, from: i32, to: i32, y: i32, ink: Ink) {
        if y < 0 || y >= i32::from(self.area.height) {
            return;
        }
        for x in from.max(0)..=to.min(i32::from(self.area.width) - 1) {
            self.put(x, y, LEFT | RIGHT, ink);
        }
    }

    /// A wire that comes from the left at (`left`, `from`), turns in the column `turn`, and goes on to (`right`, `to`).
    pub fn turning(&mut self, (left, from): (i32, i32), turn: i32, (right, to): (i32, i32), ink: Ink) {
        if from == to {
            return self.level(left, right, from, ink);
        }
        self.level(left, turn - 1, from, ink);
        self.level(turn + 1, right, to, ink);
        let (out, into) = if from < to { (DOWN, UP) } else { (UP, DOWN) };
        self.put(turn, from, LEFT | out, ink);
        self.put(turn, to, RIGHT | into, ink);
        let height = i32::from(self.area.height);
        for y in (from.min(to) + 1).max(0)..from.max(to).min(height) {
            self.put(turn, y, UP | DOWN, ink);
        }
    }

    /// Draws all lines.
    pub fn draw(&self, buffer: &mut Buffer) {
        for (at, cell) in self.cells.iter().enumerate().filter(|(_, cell)| cell.sides != 0) {
            let x = self.area.x + (at % usize::from(self.area.width)) as u16;
            let y = self.area.y + (at / usize::from(self.area.width)) as u16;
            let mut style = Style::new().fg(cell.colour);
            if cell.strong {
                style = style.add_modifier(Modifier::BOLD);
            }
            buffer[(x, y)].set_char(sign(cell.sides)).set_style(style);
        }
    }
}

fn sign(sides: u8) -> char {
    const SIGNS: [char; 16] = [' ', '│', '│', '│', '─', '╯', '╮', '┤', '─', '╰', '╭', '├', '─', '┴', '┬', '┼'];
    SIGNS[usize::from(sides & 15)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_one_wire_join_and_others_cross() {
        let area = Rect::new(0, 0, 5, 3);
        let (mut grid, mut buffer) = (Grid::new(area), Buffer::empty(area));
        let ink = |wire| Ink { wire, colour: Color::Green, strong: false };
        grid.level(0, 4, 1, ink(1));
        grid.turning((2, 0), 3, (4, 2), ink(2));
        grid.turning((0, 0), 1, (2, 2), ink(3));
        grid.turning((0, 0), 1, (2, 1), ink(3));
        grid.draw(&mut buffer);
        let lines: Vec<String> = (0..3).map(|y| (0..5).map(|x| buffer[(x, y)].symbol()).collect()).collect();
        assert_eq!(lines, ["─╮─╮ ", "─├─│─", " ╰─╰─"]);
    }
}
