//! From an atlas of overlapping charts to the layers of a scene.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::collections::BTreeMap;

use nalgebra::Point2;

use super::scene::{LayerScene, PatchScene};
use super::surface::Surface;
use crate::flatten::Atlas;
use crate::flatten::atlas::AtlasChart;

/// Other charts that a vertex knows of: a fourth one is nowhere the largest but in single triangles.
const RIVALS: usize = 3;
/// Free space between charts, √area = 1.
const GAP: f64 = 0.02;

/// The layers of an atlas.
///
/// **Takes** an atlas of the surface, and a colour for each of its sources (neutral beyond).
pub fn layers(surface: &Surface, atlas: &Atlas, colours: &[u8]) -> LayerScene {
    let unit = 1.0 / surface.radius().max(1e-300);
    let small = |x: f64| (x * unit) as f32;
    let (packing, places) = atlas.pack(GAP);
    let mut layers = LayerScene {
        sheet: [0.0, 0.0, small(packing.sheet.x), small(packing.sheet.y)],
        ..LayerScene::default()
    };
    let covering = covering(surface, atlas);
    for (number, (chart, places)) in atlas.charts.iter().zip(&places).enumerate() {
        let has_chart = chart.measures.is_some();
        let mut known = BTreeMap::new();
        let mut twins = BTreeMap::new();
        for (i, (face, triangle)) in chart.faces.iter().zip(&chart.triangles).enumerate() {
            let rivals = rivals(atlas, &covering[face.index()], number);
            let corners = [0, 1, 2].map(|corner| {
                let v = triangle[corner] as usize;
                let names = rivals.map(|rival| rival.map_or(u32::MAX, |(chart, _)| chart));
                *known.entry((v, names)).or_insert_with(|| {
                    let at = chart.vertices[v].index();
                    let point = surface.geometry.positions[at];
                    layers.positions.extend(point.iter().map(|&x| small(x)));
                    layers.normals.extend(surface.vertex_normals[at].iter().map(|&x| x as f32));
                    let uv = if has_chart { chart.uv[v] } else { Point2::origin() };
                    layers.uvs.extend([small(uv.x), small(uv.y)]);
                    layers.places.extend([small(places[v].x), small(places[v].y)]);
                    layers.weights.push(chart.weights[v] as f32);
                    layers.weights.extend(rivals.map(|rival| {
                        rival.map_or(-1.0, |(other, i)| weight(atlas, other, i, corner) as f32)
                    }));
                    layers.vertex_charts.push(number as u32);
                    layers.vertex_charts.len() as u32 - 1
                })
            });
            layers.triangles.extend(corners);
            for side in 0..3 {
                let [a, b] = [triangle[side], triangle[(side + 1) % 3]];
                if twins.remove(&(b, a)).is_none() {
                    twins.insert((a, b), (i, [corners[side], corners[(side + 1) % 3]]));
                }
            }
        }
        // In the order of faces, whatever the numbers of their vertices.
        let mut rims: Vec<(usize, [u32; 2])> = twins.into_values().collect();
        rims.sort_unstable();
        layers.rims.extend(rims.iter().flat_map(|(_, rim)| rim));
        layers.charts.push(PatchScene {
            color: colours.get(chart.source).copied().unwrap_or(PatchScene::NEUTRAL),
            area_fraction: chart.share as f32,
            anchor: anchor(chart, places).map(small),
            flipped: chart.measures.as_ref().map_or(0, |m| m.flipped as u32),
            has_chart,
        });
    }
    layers
}

/// For each face of the surface the charts that cover it, and the number of the face in each.
fn covering(surface: &Surface, atlas: &Atlas) -> Vec<Vec<(u32, usize)>> {
    let mut covering = vec![Vec::new(); surface.mesh.face_count()];
    for (number, chart) in atlas.charts.iter().enumerate() {
        for (i, face) in chart.faces.iter().enumerate() {
            covering[face.index()].push((number as u32, i));
        }
    }
    covering
}

/// The weight of a chart at a corner of its face `i`; corners are numbered alike in all charts.
fn weight(atlas: &Atlas, chart: u32, i: usize, corner: usize) -> f64 {
    let chart = &atlas.charts[chart as usize];
    chart.weights[chart.triangles[i][corner] as usize]
}

/// The other charts of a face that may be the largest somewhere in it, by number.
fn rivals(atlas: &Atlas, covering: &[(u32, usize)], own: usize) -> [Option<(u32, usize)>; RIVALS] {
    let mut others: Vec<(u32, usize)> =
        covering.iter().copied().filter(|&(chart, _)| chart as usize != own).collect();
    let most = |&(chart, i): &(u32, usize)| {
        (0..3).map(|corner| weight(atlas, chart, i, corner)).fold(0.0, f64::max)
    };
    others.sort_by(|a, b| most(b).total_cmp(&most(a)));
    others.truncate(RIVALS);
    others.sort_unstable();
    std::array::from_fn(|i| others.get(i).copied())
}

/// Where a chart's number is written: its vertex next to the weighted mean of all. NaN without chart.
fn anchor(chart: &AtlasChart, places: &[Point2<f64>]) -> [f64; 2] {
    let total: f64 = chart.weights.iter().sum();
    let weighted = places.iter().zip(&chart.weights).map(|(p, w)| p.coords * *w);
    let middle = Point2::from(weighted.sum::<nalgebra::Vector2<f64>>() / total);
    let full = places.iter().zip(&chart.weights).filter(|(_, w)| **w > 0.5).map(|(p, _)| *p);
    let nearest = full.min_by(|a, b| (a - middle).norm().total_cmp(&(b - middle).norm()));
    nearest.unwrap_or(middle).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::AtlasParams;
    use crate::session::document::Document;

    #[test]
    fn shares_add_up_everywhere_whether_charts_are_blended_or_the_largest_is_taken() {
        let document = Document::from_sample("ball").unwrap();
        let surface = document.surface.as_ref().unwrap();
        let amounts = |corner: [f64; 3]| {
            let amount = |p: &nalgebra::Point3<f64>| {
                let cosine =
                    p.coords.normalize().dot(&nalgebra::Vector3::from(corner)) / 3f64.sqrt();
                (cosine + 0.2).max(0.0).powi(2)
            };
            surface.geometry.positions.iter().map(amount).collect::<Vec<f64>>()
        };
        let tetrahedron =
            [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let mut weights: Vec<Vec<f64>> = tetrahedron.into_iter().map(amounts).collect();
        for v in 0..surface.mesh.vertex_count() {
            let sum: f64 = weights.iter().map(|w| w[v]).sum();
            weights.iter_mut().for_each(|w| w[v] /= sum);
        }
        let atlas = Atlas::new(&surface.mesh, &surface.geometry, &weights, &AtlasParams::default())
            .unwrap();
        let layers = layers(surface, &atlas, &[3, 1, 4, 1]);
        assert_eq!(layers.charts.iter().map(|c| c.color).collect::<Vec<_>>(), [3, 1, 4, 1]);
        assert_eq!(
            crate::session::scene::Scene { layers: Some(layers.clone()), ..Default::default() }
                .vertex_count(),
            0
        );
        // Triangles by the place of their middle: the same bits in each chart.
        let mut middles: BTreeMap<[u32; 9], Vec<[f32; 4]>> = BTreeMap::new();
        for t in layers.triangles.as_chunks::<3>().0 {
            let mut key = [0; 9];
            let mut mean = [0.0f32; 4];
            for (i, &v) in t.iter().enumerate() {
                let v = v as usize;
                for axis in 0..3 {
                    key[3 * i + axis] = layers.positions[3 * v + axis].to_bits();
                }
                for w in 0..4 {
                    mean[w] += layers.weights[4 * v + w] / 3.0;
                }
            }
            middles.entry(key).or_default().push(mean);
        }
        assert_eq!(middles.len(), surface.mesh.face_count());
        let mut most = 0;
        for charts in middles.values() {
            most = most.max(charts.len());
            let sum: f32 = charts.iter().map(|w| w[0]).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{sum}");
            // Each chart knows the others, so one of them wins and only one.
            let wins = charts.iter().filter(|w| w[1..].iter().all(|other| w[0] > *other)).count();
            let ties = charts.iter().filter(|w| w[1..].iter().all(|other| w[0] >= *other)).count();
            assert!(wins == 1 || ties > 1, "{charts:?}");
            assert!(charts.iter().all(|w| {
                w[1..].iter().filter(|other| **other >= 0.0).count() == charts.len() - 1
            }));
        }
        assert!(most >= 3, "three charts meet between the corners of a tetrahedron");
        let [_, _, x, y] = layers.sheet;
        for place in layers.places.as_chunks::<2>().0 {
            // A millionth is rounding to 32 bits.
            assert!(
                place[0] > -1e-6 && place[1] > -1e-6 && place[0] < x + 1e-6 && place[1] < y + 1e-6
            );
        }
        // Rims are closed: each vertex is left as often as it is reached, up to copies for other rivals.
        assert!(!layers.rims.is_empty());
    }
}
