//! Writes one mesh as OBJ: a group a part, in metres.

use face_math::data::Part;
use glam::Vec3;
use std::fmt::Write;

/// The mesh of `parts` at `positions` (metres) as OBJ text. All vertices are written, in their order.
pub fn write(parts: &[Part], positions: &[Vec3]) -> Vec<u8> {
    let mut text = String::from("# metres\n");
    for Vec3 { x, y, z } in positions {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    let mut uvs = 0;
    for part in parts {
        let _ = writeln!(text, "g {}", part.name.replace(char::is_whitespace, "_"));
        for [u, v] in &part.uvs {
            // OBJ counts upwards from the bottom.
            let _ = writeln!(text, "vt {u} {}", 1.0 - v);
        }
        for triangle in &part.triangles {
            text.push('f');
            for vertex in triangle {
                let _ = match vertex.checked_sub(part.vertices.start).filter(|own| (*own as usize) < part.uvs.len()) {
                    Some(own) => write!(text, " {}/{}", vertex + 1, uvs + own + 1),
                    None => write!(text, " {}", vertex + 1),
                };
            }
            text.push('\n');
        }
        uvs += part.uvs.len() as u32;
    }
    text.into_bytes()
}
