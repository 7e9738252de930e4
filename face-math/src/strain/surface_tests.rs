//! Tests of [`Surface`]: straight lines on planes and cylinders, seams and gaps.

use super::*;

/// A sheet of `side × side` vertices bent by `bend`, from 0..1 in u and v.
fn sheet(side: usize, bend: impl Fn(f32, f32) -> Vec3) -> (Vec<Vec3>, Part) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for y in 0..side {
        for x in 0..side {
            positions.push(bend(x as f32 / (side - 1) as f32, y as f32 / (side - 1) as f32));
            if x + 1 < side && y + 1 < side {
                let corner = (y * side + x) as u32;
                let below = corner + side as u32;
                triangles.push([corner, corner + 1, below + 1]);
                triangles.push([corner, below + 1, below]);
            }
        }
    }
    let vertices = 0..positions.len() as u32;
    (positions, Part { name: "sheet".into(), vertices, triangles, uvs: Vec::new(), colour: [0.0; 3] })
}

fn length(surface: &Surface, path: &[RidingPoint]) -> f64 {
    path.windows(2).map(|pair| surface.place(&pair[0]).distance(surface.place(&pair[1]))).sum()
}

#[test]
fn a_path_on_a_plane_is_a_straight_line() {
    let (positions, part) = sheet(21, |u, v| Vec3::new(u, v, 0.0));
    let surface = Surface::new(&positions, [&part]);
    for (from, to) in [((0.03, 0.11), (0.93, 0.64)), ((0.5, 0.02), (0.52, 0.99)), ((0.9, 0.1), (0.07, 0.77))] {
        let ends = [from, to].map(|(x, y)| surface.nearest(DVec3::new(x, y, 0.3)).unwrap());
        let path = surface.path(&ends[0], &ends[1]).unwrap();
        let straight = surface.place(&ends[0]).distance(surface.place(&ends[1]));
        let ratio = length(&surface, &path) / straight;
        assert!((1.0 - 1e-6..1.0 + 2e-4).contains(&ratio), "{ratio}");
    }
}

#[test]
fn a_path_on_a_cylinder_is_the_line_on_its_unrolled_surface() {
    let (positions, part) = sheet(61, |u, v| Vec3::new((2.0 * u).sin(), v, (2.0 * u).cos()));
    let surface = Surface::new(&positions, [&part]);
    let at = |u: f64, v: f64| surface.nearest(DVec3::new((2.0 * u).sin(), v, (2.0 * u).cos())).unwrap();
    let path = surface.path(&at(0.1, 0.2), &at(0.9, 0.8)).unwrap();
    let expected = (1.6_f64.powi(2) + 0.6_f64.powi(2)).sqrt();
    assert!((length(&surface, &path) / expected - 1.0).abs() < 1e-3, "{}", length(&surface, &path) / expected);
}

#[test]
fn seams_are_crossed_and_gaps_are_not() {
    let (mut positions, mut part) = sheet(9, |u, v| Vec3::new(u, v, 0.0));
    // The right half gets vertices of its own along the middle, at the same places.
    let mut twin = BTreeMap::new();
    for triangle in &mut part.triangles {
        if triangle.iter().any(|vertex| vertex % 9 > 4) {
            for vertex in triangle.iter_mut().filter(|vertex| **vertex % 9 == 4) {
                *vertex = *twin.entry(*vertex).or_insert_with(|| {
                    positions.push(positions[*vertex as usize]);
                    positions.len() as u32 - 1
                });
            }
        }
    }
    let find = |positions: &[Vec3]| {
        let surface = Surface::new(positions, [&part]);
        let ends = [0.1, 0.9].map(|x| surface.nearest(DVec3::new(x, 0.5, 0.0)).unwrap());
        surface.path(&ends[0], &ends[1]).map(|path| length(&surface, &path))
    };
    assert!((find(&positions).unwrap() - 0.8).abs() < 1e-4);
    positions[81..].iter_mut().for_each(|point| point.z += 1e-3);
    assert_eq!(find(&positions), None);
}

#[test]
fn points_on_vertices_and_in_one_triangle_are_joined() {
    let (positions, part) = sheet(5, |u, v| Vec3::new(u, v, 0.0));
    let surface = Surface::new(&positions, [&part]);
    let corner = |vertex: u32| {
        let triangle = surface.triangles.iter().find(|triangle| triangle.contains(&vertex)).unwrap();
        RidingPoint { vertices: *triangle, weights: triangle.map(|own| f32::from(u8::from(own == vertex))) }
    };
    let path = surface.path(&corner(0), &corner(1)).unwrap();
    assert_eq!(path.len(), 2);
    let path = surface.path(&corner(0), &corner(4)).unwrap();
    assert!((length(&surface, &path) - 1.0).abs() < 1e-3);
}
