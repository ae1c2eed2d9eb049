//! The cut surface as binary PLY, with texture coordinates at vertices and the piece of each face.
//!
//! | element | property | type | meaning |
//! |---|---|---|---|
//! | vertex | `x y z` | double | the file's coordinates, bit for bit |
//! | vertex | `nx ny nz` | float | unit normal; left out where the file has none |
//! | vertex | `s t` | float | place in the unit square, t up; 0 where the piece has no chart |
//! | vertex | `source_vertex` | int | vertex of the file, from 0; vertices on the cut go on from its last |
//! | face | `vertex_indices` | list uchar int | three corners, counter-clockwise from outside |
//! | face | `piece` | int | from 1 |
//!
//! Vertices are split like those of the GLB, in the order in which the faces use them; faces are those of the refined
//! triangulation, in its order. Not kept: groups and materials, which PLY has no place for.

#![expect(
    clippy::cast_possible_wrap,
    clippy::cast_possible_truncation,
    reason = "PLY counts in signed 32 bits as everybody writes it; `Mesh::new` refuses larger meshes"
)]

use super::bytes::{push_singles, single};
use super::number::exact;
use super::obj::CutSurface;
use super::split::Split;
use super::uv_map::UvMap;

/// Bytes of a PLY file.
///
/// **Takes** a place for each vertex of the opened surface (NaN for patches without chart), and the length of that unit in
/// units of the file. **Costs** O(F).
pub fn uv_ply(surface: &CutSurface, charts: &[[f64; 2]], chart_unit: f64) -> Vec<u8> {
    let map = UvMap::new(surface.opened, charts);
    let split = Split::new(surface);
    let mut out = header(surface, &map, chart_unit, &split).into_bytes();
    let places = split.places(surface);
    let patches = surface.opened.vertex_patches();
    let sources = split.source_vertices(surface);
    for (i, &v) in split.vertices.iter().enumerate() {
        for x in places[i] {
            out.extend(x.to_le_bytes());
        }
        push_singles(&mut out, split.normals.get(i).copied().into_iter().flatten());
        let uv = match map.has_chart[patches[v as usize] as usize] {
            true => map.uv(charts[v as usize]),
            false => [0.0; 2],
        };
        push_singles(&mut out, uv.map(single));
        out.extend((sources[i] as i32).to_le_bytes());
    }
    for (triangle, &patch) in split.triangles.iter().zip(&surface.opened.face_patches) {
        out.push(3);
        for v in triangle {
            out.extend((*v as i32).to_le_bytes());
        }
        out.extend((patch as i32 + 1).to_le_bytes());
    }
    out
}

fn header(surface: &CutSurface, map: &UvMap, chart_unit: f64, split: &Split) -> String {
    let mut out = String::from("ply\nformat binary_little_endian 1.0\n");
    out += "comment Cutflow: surface cut into pieces, with texture coordinates\n";
    let mut comment = |key: &str, x: f64, words: &str| {
        if x.is_finite() {
            out += &format!("comment {key} ");
            exact(&mut out, x);
            out += words;
        }
    };
    if let Some(mm) = surface.mm_per_unit {
        comment("mm_per_unit", mm, "\n");
    }
    if !map.placed.is_empty() {
        let words = " (units of the input per 1 in s and t)\n";
        comment("uv_scale", map.extent * chart_unit, words);
    }
    out += &format!("element vertex {}\n", split.vertices.len());
    for name in ["x", "y", "z"] {
        out += &format!("property double {name}\n");
    }
    let normal: &[&str] = if split.normals.is_empty() { &[] } else { &["nx", "ny", "nz"] };
    for name in normal.iter().chain(&["s", "t"]) {
        out += &format!("property float {name}\n");
    }
    out += "property int source_vertex\n";
    out += &format!("element face {}\n", split.triangles.len());
    out += "property list uchar int vertex_indices\nproperty int piece\nend_header\n";
    out
}
