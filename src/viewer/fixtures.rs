//! Small scenes for the tests of this floor.

use crate::session::scene::{LayerScene, PatchScene, Scene};
use glam::Vec3;

/// Two unit squares side by side, each a patch of two triangles, the cut between them.
pub fn two_squares() -> Scene {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let charts: Vec<[f32; 2]> =
        [0.0, 1.25].iter().flat_map(|dx| corners.map(|[x, y]| [x + dx, y])).collect();
    let positions = [0.0, 1.0].iter().flat_map(|dx| corners.map(|[x, y]| [x + dx - 1.0, y, 0.0]));
    let patch = |color, anchor| PatchScene {
        color,
        area_fraction: 0.5,
        anchor,
        flipped: 0,
        has_chart: true,
    };
    let mut rim_partners = vec![u32::MAX; 8];
    (rim_partners[1], rim_partners[7]) = (7, 1);
    Scene {
        positions: positions.flatten().collect(),
        normals: [0.0, 0.0, 1.0].repeat(8),
        charts: charts.concat(),
        vertex_patches: vec![0, 0, 0, 0, 1, 1, 1, 1],
        triangles: vec![0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7],
        triangle_faces: vec![0, 0, 1, 1],
        rims: vec![0, 1, 1, 2, 2, 3, 3, 0, 4, 5, 5, 6, 6, 7, 7, 4],
        rim_partners,
        patches: vec![patch(0, [0.5, 0.5]), patch(1, [1.5, 0.5])],
        sheet: [0.0, 0.0, 2.25, 1.0],
        ..Scene::default()
    }
}

/// A unit square in two patches as above, with a layer over each square; both cover the same places and weigh half.
pub fn overlapping_squares() -> Scene {
    let scene = two_squares();
    let one: Vec<f32> = scene.positions[..12].to_vec();
    let layers = LayerScene {
        positions: one.repeat(2),
        normals: scene.normals.clone(),
        uvs: scene.charts[..8].repeat(2),
        places: scene.charts.clone(),
        weights: [0.5, 0.5, -1.0, -1.0].repeat(8),
        vertex_charts: scene.vertex_patches.clone(),
        triangles: scene.triangles.clone(),
        rims: scene.rims.clone(),
        charts: scene.patches.clone(),
        sheet: [0.0, 0.0, 5.0, 1.0],
    };
    Scene { layers: Some(layers), ..scene }
}

/// A ball of `4ⁿ × 8` triangles in one patch without rims or charts, marks at `marks` of its vertices.
pub fn unit_ball(n: u32, marks: usize) -> Scene {
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z];
    let mut points = Vec::new();
    let mut triangles: Vec<[Vec3; 3]> = [[x, y, z], [y, -x, z], [-x, -y, z], [-y, x, z]].to_vec();
    triangles.extend([[y, x, -z], [-x, y, -z], [-y, -x, -z], [x, -y, -z]]);
    for _ in 0..n {
        let split = |[a, b, c]: [Vec3; 3]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    let mut index = |point: Vec3| {
        points.iter().position(|&p: &Vec3| p.distance(point) < 1e-5).unwrap_or_else(|| {
            points.push(point);
            points.len() - 1
        }) as u32
    };
    let triangles: Vec<u32> = triangles.into_iter().flatten().map(&mut index).collect();
    let positions: Vec<f32> = points.iter().flat_map(|p| p.to_array()).collect();
    Scene {
        normals: positions.clone(),
        charts: vec![f32::NAN; 2 * points.len()],
        vertex_patches: vec![0; points.len()],
        triangle_faces: (0..triangles.len() as u32 / 3).collect(),
        triangles,
        patches: vec![PatchScene { color: 4, area_fraction: 1.0, ..PatchScene::default() }],
        mark_points: positions[..3 * marks].to_vec(),
        positions,
        ..Scene::default()
    }
}
