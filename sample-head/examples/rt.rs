//! throw-away
use face_math::render::*;
use sample_head::*;
fn main() {
    let h = build(&Options::default()).unwrap();
    let cam = Camera::framing(&h.rig.neutral);
    let n: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    for i in 0..n {
        render_rig(&h.rig, &h.rig.neutral, &cam.turned(i as f32 * 0.01, 0.0), &Style::sized(512, 512)).unwrap();
    }
}
