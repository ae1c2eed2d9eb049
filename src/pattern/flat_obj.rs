//! The flat pieces as a mesh: OBJ in the plane z = 0.

use super::number::exact;
use super::obj::{CutSurface, write_numbers};
use super::uv_map::{UvMap, faces_by_patch};

/// Bytes of an OBJ file of all charts as they lie side by side.
///
/// In millimetres where the real size is known, otherwise in the unit of the charts; y up, seen from the outer side, all
/// coordinates from 0. Vertex `k` is texture coordinate `k` of [`super::uv_obj`], and faces follow each other as there, so
/// that the two files show the same triangles flat and in space. Group `piece_1`, `piece_2`, … for each patch that has a chart.
///
/// **Takes** a place for each vertex of the opened surface (NaN for patches without chart), and millimetres of that unit.
pub fn flat_obj(
    surface: &CutSurface,
    charts: &[[f64; 2]],
    mm_per_chart_unit: Option<f64>,
) -> Vec<u8> {
    let opened = surface.opened;
    let map = UvMap::new(opened, charts);
    let scale = mm_per_chart_unit.filter(|mm| mm.is_finite() && *mm > 0.0);
    let mut out = String::from("# Cutflow: flat pieces, seen from the outer side\n");
    out += match scale {
        Some(_) => "# units: mm\n",
        None => "# units: none, the real size is not known\n",
    };
    if let Some(mm) = scale {
        out += "# uv_scale_mm ";
        exact(&mut out, map.extent * mm);
        out += " (side of the unit square of the texture coordinates)\n";
    }
    let pieces = map.has_chart.iter().filter(|&&has| has).count();
    out += &format!("# {} vertices, {pieces} of {} pieces\n", map.placed.len(), opened.patch_count);
    let mut numbers = vec![0usize; charts.len()];
    for (i, &v) in map.placed.iter().enumerate() {
        numbers[v as usize] = i + 1;
        let [x, y] = [0, 1].map(|a| (charts[v as usize][a] - map.low[a]) * scale.unwrap_or(1.0));
        write_numbers(&mut out, "v", &[x, y, 0.0]);
    }
    for (patch, faces) in faces_by_patch(opened).iter().enumerate() {
        if !map.has_chart[patch] {
            continue;
        }
        out += &format!("g piece_{}\n", patch + 1);
        for &face in faces {
            let [a, b, c] = opened.mesh.triangles()[face].map(|v| numbers[v.index()]);
            out += &format!("f {a} {b} {c}\n");
        }
    }
    out.into_bytes()
}
