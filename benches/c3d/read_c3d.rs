//! Reads a C3D file again and again, and says how much processor time a reading takes: our side of `benches/c3d`.

use std::error::Error;
use std::hint::black_box;
use std::io::Write;
use std::time::Instant;

/// Prints the name, the best and the middle time of a reading in seconds, and the number of points.
fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(path), Some(count)) = (arguments.next(), arguments.next()) else {
        return Err("usage: read_c3d FILE COUNT".into());
    };
    let count: u32 = count.parse()?;
    let mut points = 0;
    let mut times = Vec::with_capacity(count as usize);
    for _ in 0..count {
        // The file is opened anew each time, as the peer does. One thread does all the work, so the clock on the wall
        // shows the time of the processor and what others take from it, never less.
        let start = Instant::now();
        let bytes = std::fs::read(&path)?;
        let markers = black_box(face_io::c3d::read(black_box(&bytes))?);
        times.push(start.elapsed().as_secs_f64());
        points = markers.positions().len();
    }
    times.sort_by(f64::total_cmp);
    let best = times.first().copied().unwrap_or_default();
    let median = times.get(times.len() / 2).copied().unwrap_or_default();
    writeln!(std::io::stdout(), "grimace {best} {median} {points}")?;
    Ok(())
}
