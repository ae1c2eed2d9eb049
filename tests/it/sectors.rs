//! Seams through negative cones: no sector of a full turn is left, no chart is added where a seam can be led elsewhere.

use std::f64::consts::{PI, TAU};

use cutflow::flatten::{Flattening, SplitParams, bff_scaled, split_overlaps, validate};
use cutflow::geometry::{Geometry, angle_sums};
use cutflow::mesh::{Mesh, OpenedMesh, VertexId};
use cutflow::methods::cones::Cone;
use cutflow::methods::cutgraph::{Parted, Seams, WIDEST, cut_through, part_sectors};
use nalgebra::Point3;

use super::splitting::cones;
use super::surfaces::Surface;

/// A cone of more than a full turn about vertex 0: rays that go up and down, and rings around.
fn saddle(rays: u32, rings: u32, steepness: f64) -> (Mesh, Geometry) {
    let mut positions = vec![Point3::origin()];
    for (j, i) in (1..=rings).flat_map(|j| (0..rays).map(move |i| (j, i))) {
        let angle = TAU * f64::from(i) / f64::from(rays);
        let (sin, cos) = angle.sin_cos();
        let up = steepness * (3.0 * angle).sin();
        positions.push(Point3::new(cos, sin, up) * (f64::from(j) / f64::from(rings)));
    }
    let at = |j: u32, i: u32| 1 + (j - 1) * rays + i % rays;
    let mut triangles: Vec<[u32; 3]> = (0..rays).map(|i| [0, at(1, i), at(1, i + 1)]).collect();
    for (j, i) in (1..rings).flat_map(|j| (0..rays).map(move |i| (j, i))) {
        triangles.push([at(j, i), at(j + 1, i), at(j + 1, i + 1)]);
        triangles.push([at(j, i), at(j + 1, i + 1), at(j, i + 1)]);
    }
    let mesh = Mesh::new(positions.len(), &triangles).unwrap();
    let geometry = Geometry::new(&mesh, positions).unwrap();
    (mesh, geometry)
}

fn opened_geometry(geometry: &Geometry, opened: &OpenedMesh) -> Geometry {
    let place = |&p: &u32| geometry.positions[p as usize];
    Geometry::measure(&opened.mesh, opened.vertex_points.iter().map(place).collect())
}

fn flatten(geometry: &Geometry, seams: &Seams, u: &[f64]) -> (Geometry, Flattening) {
    let measured = opened_geometry(geometry, &seams.opened);
    let rim_u: Vec<f64> = seams.opened.vertex_points.iter().map(|&p| u[p as usize]).collect();
    let flattening = bff_scaled(&seams.opened, &measured, &rim_u).unwrap();
    (measured, flattening)
}

/// The widest sector at the copies of each vertex, by angles on the surface scaled to those of the cone.
fn widest_sectors(mesh: &Mesh, geometry: &Geometry, seams: &Seams, cones: &[Cone]) -> Vec<f64> {
    let whole = angle_sums(mesh, geometry);
    let parts = angle_sums(&seams.opened.mesh, &opened_geometry(geometry, &seams.opened));
    let widest = |c: &Cone| {
        let copies = seams.opened.vertex_points.iter().zip(&parts);
        let own = copies.filter(|(p, _)| **p == c.vertex.0).map(|(_, angle)| *angle);
        let flat = if mesh.is_boundary_vertex(c.vertex) { PI } else { TAU };
        own.fold(0.0, f64::max) / whole[c.vertex.index()] * (flat - c.angle)
    };
    cones.iter().map(widest).collect()
}

fn part(mesh: &Mesh, geometry: &Geometry, seams: &Seams, cones: &[Cone]) -> Parted {
    let given: Vec<(VertexId, f64)> = cones.iter().map(|c| (c.vertex, c.angle)).collect();
    let parted = part_sectors(mesh, geometry, seams, &given, &[]).unwrap();
    let shapes = parted.seams.opened.patch_shapes();
    assert!(shapes.iter().all(|&shape| shape == (1, 1)), "{shapes:?}");
    assert_eq!(shapes.len(), seams.opened.patch_count + parted.added);
    for c in cones {
        let is_on_rim = parted.seams.cut.cut_edges.iter().flatten().any(|&p| p == c.vertex.0);
        assert!(is_on_rim || mesh.is_boundary_vertex(c.vertex), "{c:?} is on no seam");
    }
    parted
}

#[test]
fn a_cone_of_several_turns_gets_a_seam_for_each() {
    for steepness in [0.3, 0.9, 1.6, 2.2] {
        let (mesh, geometry) = saddle(72, 8, steepness);
        let total = angle_sums(&mesh, &geometry)[0];
        let apex = [Cone { vertex: VertexId(0), angle: TAU - total }];
        let needed = (total / WIDEST).ceil() as usize;
        assert!(needed >= 2);
        let seams = cut_through(&mesh, &geometry, &[VertexId(0)], &[]).unwrap();
        let parted = part(&mesh, &geometry, &seams, &apex);
        assert!(parted.wide.is_empty());
        let degree = parted.seams.cut.cut_edges.iter().flatten().filter(|&&p| p == 0).count();
        assert!(degree >= needed && degree <= needed + 1, "{degree} of {needed}");
        // All seams run from the cone to the rim: each more is a chart more.
        assert_eq!((parted.paths, parted.added), (degree - 1, degree - 1));
        assert!(widest_sectors(&mesh, &geometry, &parted.seams, &apex)[0] < TAU);
        let flat = vec![0.0; mesh.vertex_count()];
        let (_, before) = flatten(&geometry, &seams, &flat);
        let (_, after) = flatten(&geometry, &parted.seams, &flat);
        assert!(!validate(&seams.opened, &before, None).is_valid());
        let validity = validate(&parted.seams.opened, &after, None).totals;
        assert!(
            validity.is_valid(),
            "{total}: {validity:?} {} {}",
            after.seams_equal,
            after.angles_exact
        );
    }
}

#[test]
fn seams_of_optimal_cones_are_led_through_the_negative_ones() {
    for (name, lambda) in [("spot.obj", 0.001), ("cheburashka.obj", 0.00042)] {
        let Some(surface) = Surface::shared(name) else { continue };
        let (cones, u) = cones(&surface, lambda);
        let Surface { mesh, geometry, .. } = surface;
        let places: Vec<VertexId> = cones.iter().map(|c| c.vertex).collect();
        let seams = cut_through(&mesh, &geometry, &places, &[]).unwrap();
        let parted = part(&mesh, &geometry, &seams, &cones);
        let widest = |seams: &Seams| {
            let all = widest_sectors(&mesh, &geometry, seams, &cones);
            (
                all.iter().filter(|&&angle| angle >= TAU).count(),
                all.iter().copied().fold(0.0, f64::max),
            )
        };
        let (before, after) = (widest(&seams), widest(&parted.seams));
        assert!(after.1 < TAU && parted.wide.is_empty(), "{name}: {after:?}");
        let mut results = Vec::new();
        for seams in [&seams, &parted.seams] {
            let (measured, flattening) = flatten(&geometry, seams, &u);
            let validity = validate(&seams.opened, &flattening, None).totals;
            let params = SplitParams::default();
            let split =
                split_overlaps(&seams.cut, &seams.opened, &measured, &flattening, &[], &params);
            let split = split.unwrap();
            results.push((validity.pairs, validity.flipped, split.added, split.length));
        }
        println!(
            "{name}: {} cones, {} wide ({:.2} π) before, {} paths, {} charts added, {:.2} π after, length {:.3} → {:.3}; pairs, flips, cuts, length {results:?}",
            cones.len(),
            before.0,
            before.1 / PI,
            parted.paths,
            parted.added,
            after.1 / PI,
            seams.length,
            parted.seams.length
        );
        // One more seam for each cone that was too wide, and hardly any chart.
        assert!(parted.added <= 1, "{name}: {} of {}", parted.added, parted.paths);
        let [before, after] = [results[0], results[1]];
        assert!(after.2 < before.2 && after.3 < before.3, "less is left to split: {results:?}");
    }
}

#[test]
fn without_negative_cones_seams_stay_as_they_are() {
    let Surface { mesh, geometry, .. } = Surface::sphere(5);
    let cones = [3u32, 40, 90, 200].map(|v| Cone { vertex: VertexId(v), angle: PI });
    let places: Vec<VertexId> = cones.iter().map(|c| c.vertex).collect();
    let seams = cut_through(&mesh, &geometry, &places, &[]).unwrap();
    let parted = part(&mesh, &geometry, &seams, &cones);
    assert_eq!((parted.paths, parted.added), (0, 0));
    let set = |seams: &Seams| {
        let mut edges: Vec<[u32; 2]> =
            seams.cut.cut_edges.iter().map(|e| [e[0].min(e[1]), e[0].max(e[1])]).collect();
        edges.sort_unstable();
        edges
    };
    assert_eq!(set(&parted.seams), set(&seams));
    let nowhere = [(VertexId(100_000), -1.0)];
    assert!(part_sectors(&mesh, &geometry, &seams, &nowhere, &[]).is_err());
}
