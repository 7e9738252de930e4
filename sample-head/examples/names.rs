//! throw-away
use sample_head::*;
fn main() {
    let h = build(&Options::default()).unwrap();
    println!("{}", h.neutral_markers.names().join(","));
    for r in &h.regions.regions {
        println!("{}|{}|{}", r.name, r.markers.join(","), r.channels.join(","));
    }
    println!("{}", CHANNELS.join(","));
    for (n, p) in h.neutral_markers.names().iter().zip(h.neutral_markers.frame(0)) {
        println!("{n} {:.1} {:.1} {:.1}", p.x * 1e3, p.y * 1e3, p.z * 1e3);
    }
}
