//! throw-away
use face_math::render::*;
use face_math::rig::*;
use sample_head::*;
use std::time::Instant;
fn main() {
    let t = Instant::now();
    let h = build(&Options::default()).unwrap();
    println!("build {:?}", t.elapsed());
    use wire::Value;
    println!("{}", h.rig.summary());
    println!("{}", h.neutral_markers.summary());
    println!("{}", h.range_of_motion.summary());
    let t = Instant::now();
    let k = takes(&h, 3, 360, 1).unwrap();
    println!("takes {:?} {}", t.elapsed(), k[0].markers.summary());
    let t = Instant::now();
    let s = skin_jaw(&h.rig, &SkinJawOptions::default()).unwrap();
    println!("skin_jaw {:?}", t.elapsed());
    for f in &s.fits {
        println!("{:?}", f);
    }
    let cam = Camera::framing(&h.rig.neutral);
    for size in [256, 512] {
        let t = Instant::now();
        for i in 0..10 {
            render_rig(&h.rig, &h.rig.neutral, &cam.turned(i as f32 * 0.1, 0.0), &Style::sized(size, size)).unwrap();
        }
        println!("render {size}: {:?}", t.elapsed() / 10);
    }
    for rig in [&h.rig, &s.rig] {
        let m = MarkerRig::of_vertices(rig, &h.marker_vertices).unwrap();
        let mut p = MarkerPose::default();
        m.pose(&[0.0; 53], &mut p);
        let rest = p.positions().to_vec();
        let r: Vec<Vec<glam::DVec3>> = (0..53)
            .map(|c| {
                let mut w = [0.0; 53];
                w[c] = 1.0;
                m.pose(&w, &mut p);
                p.positions().iter().zip(&rest).map(|(a, b)| *a - *b).collect()
            })
            .collect();
        let dot = |a: &[glam::DVec3], b: &[glam::DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
        let mut v = vec![];
        for a in 0..53 {
            for b in 0..a {
                v.push((dot(&r[a], &r[b]) / (dot(&r[a], &r[a]) * dot(&r[b], &r[b])).sqrt(), CHANNELS[b], CHANNELS[a]));
            }
        }
        v.sort_by(|a, b| b.0.total_cmp(&a.0));
        for x in &v[..8] {
            println!("{:.3} {} {}", x.0, x.1, x.2);
        }
        println!("most negative: {:?}", v.last());
        let mut e: Vec<_> =
            (0..53).map(|c| (r[c].iter().map(|d| d.length()).fold(0.0, f64::max) * 1e3, CHANNELS[c])).collect();
        e.sort_by(|a, b| a.0.total_cmp(&b.0));
        println!("{:?} .. {:?}", &e[..6], e.last());
    }
}
