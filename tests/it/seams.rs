//! Seams through cones, and charts whose cones have exact angles.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use cutflow::flatten::{Flattening, NoChart, bff_scaled, measure};
use cutflow::geometry::{Geometry, Laplacian, angle_defects, geodesic_distances, visibility};
use cutflow::linalg::{Analysis, Factor};
use cutflow::mesh::{CutMesh, HalfedgeId, Mesh, OpenedMesh, Soup, VertexId};
use cutflow::methods::cutgraph::{Seams, cut_through};
use cutflow::methods::flow::SolveError;
use nalgebra::{Point2, Point3, Rotation3, Vector2};

use crate::surfaces::{Surface, cube, cylinder, tetrahedron};

/// Log scale factors u with L u = μ − Ω, u = 0 on boundaries and at one vertex of every closed component.
fn scale_factors(surface: &Surface, cones: &[(VertexId, f64)]) -> Vec<f64> {
    let (mesh, geometry) = (&surface.mesh, &surface.geometry);
    let laplacian = Laplacian::new(mesh, geometry);
    let pattern = &laplacian.pattern;
    let mut is_fixed: Vec<bool> = mesh.vertices().map(|v| mesh.is_boundary_vertex(v)).collect();
    let topology = mesh.topology();
    let mut is_grounded = vec![false; topology.components];
    for pass in 0..2 {
        for f in mesh.faces() {
            let component = topology.face_components[f.index()] as usize;
            for v in mesh.face_vertices(f) {
                if pass == 0 {
                    is_grounded[component] |= is_fixed[v.index()];
                } else if !is_grounded[component] {
                    is_grounded[component] = true;
                    is_fixed[v.index()] = true;
                }
            }
        }
    }
    let mut values = laplacian.values.clone();
    for (e, &slot) in mesh.edges().zip(&laplacian.edge_slots) {
        if mesh.edge_vertices(e).iter().any(|v| is_fixed[v.index()]) {
            values[slot as usize] = 0.0;
        }
    }
    let mut wanted: Vec<f64> = angle_defects(mesh, geometry).iter().map(|defect| -defect).collect();
    for (v, angle) in cones {
        wanted[v.index()] += angle;
    }
    for v in mesh.vertices().filter(|v| is_fixed[v.index()]) {
        values[pattern.diagonal(v.index())] = 1.0;
        wanted[v.index()] = 0.0;
    }
    let analysis = Arc::new(Analysis::new(pattern.clone()).unwrap());
    let mut factor = Factor::new(analysis, &values).unwrap();
    let mut u = vec![0.0; wanted.len()];
    let mut rest = wanted.clone();
    for _ in 0..2 {
        factor.solve(&mut rest, 1);
        for (u, d) in u.iter_mut().zip(&rest) {
            *u += d;
        }
        pattern.multiply(&values, &u, &mut rest);
        for (r, w) in rest.iter_mut().zip(&wanted) {
            *r = w - *r;
        }
    }
    u
}

/// The place of every opened vertex, measured.
fn opened_geometry(surface: &Surface, opened: &OpenedMesh) -> Geometry {
    let place = |&p: &u32| surface.geometry.positions[p as usize];
    Geometry::measure(&opened.mesh, opened.vertex_points.iter().map(place).collect())
}

/// Cut through cones, flattened.
struct Flat {
    seams: Seams,
    geometry: Geometry,
    u: Vec<f64>,
    flattening: Flattening,
}

impl Flat {
    fn new(surface: &Surface, cones: &[(VertexId, f64)]) -> Self {
        let places: Vec<VertexId> = cones.iter().map(|(v, _)| *v).collect();
        let seams = cut_through(&surface.mesh, &surface.geometry, &places, &[]).unwrap();
        Self::along(surface, cones, seams)
    }

    fn along(surface: &Surface, cones: &[(VertexId, f64)], seams: Seams) -> Self {
        let u = scale_factors(surface, cones);
        let geometry = opened_geometry(surface, &seams.opened);
        let rim_u: Vec<f64> = seams.opened.vertex_points.iter().map(|&p| u[p as usize]).collect();
        let flattening = bff_scaled(&seams.opened, &geometry, &rim_u).unwrap();
        Self { seams, geometry, u, flattening }
    }

    /// Interior angles of the rim polygons as they are drawn, at every opened rim vertex.
    fn rim_angles(&self) -> Vec<(VertexId, f64)> {
        let opened = &self.seams.opened;
        let mut angles = Vec::new();
        for rim in self.flattening.charts.iter().flatten() {
            for (i, &h) in rim.iter().enumerate() {
                let before = rim[(i + rim.len() - 1) % rim.len()];
                let side = |h: HalfedgeId| {
                    let [a, b] = [opened.mesh.tail(h), opened.mesh.tip(h)];
                    self.flattening.uv[b.index()] - self.flattening.uv[a.index()]
                };
                let (z, w) = (side(before), side(h));
                angles.push((opened.mesh.tail(h), PI - z.perp(&w).atan2(z.dot(&w))));
            }
        }
        angles
    }

    /// The largest deviation of the angle about a vertex on seams from 2π − μ, up to full turns, which drawn polygons do not show.
    fn worst_angle(&self, surface: &Surface, cones: &[(VertexId, f64)]) -> f64 {
        let mut sums = vec![None; surface.mesh.vertex_count()];
        for (v, angle) in self.rim_angles() {
            let sum = &mut sums[self.seams.opened.vertex_points[v.index()] as usize];
            *sum = Some(sum.unwrap_or(0.0) + angle);
        }
        let mut wanted = vec![TAU; sums.len()];
        for (v, angle) in cones {
            wanted[v.index()] -= angle;
        }
        let mut worst = 0.0f64;
        for v in surface.mesh.vertices().filter(|&v| !surface.mesh.is_boundary_vertex(v)) {
            if let Some(sum) = sums[v.index()] {
                let miss = (sum - wanted[v.index()]) / TAU;
                worst = worst.max(TAU * (miss - miss.round()).abs());
            }
        }
        worst
    }

    /// The largest deviation of a seam's two sides from being equally long, over the mean edge length.
    fn worst_partners(&self) -> f64 {
        let opened = &self.seams.opened;
        let length = |h: HalfedgeId| {
            let [a, b] = [opened.mesh.tail(h), opened.mesh.tip(h)];
            (self.flattening.uv[b.index()] - self.flattening.uv[a.index()]).norm()
        };
        let mut worst = 0.0f64;
        for &h in self.flattening.charts.iter().flatten().flatten() {
            if let Some(partner) = opened.partner(h) {
                worst = worst.max((length(h) - length(partner)).abs());
            }
        }
        worst / self.geometry.mean_edge_length()
    }

    fn worst_length(&self) -> f64 {
        let mesh = &self.seams.opened.mesh;
        mesh.edges()
            .map(|e| {
                let [a, b] = mesh.edge_vertices(e).map(|v| self.flattening.uv[v.index()]);
                ((a - b).norm() - self.geometry.edge_length(e)).abs()
            })
            .fold(0.0, f64::max)
    }
}

/// Vertices far from each other: each one farthest from those before it.
fn spread(surface: &Surface, count: usize) -> Vec<VertexId> {
    let first = surface.mesh.triangles()[0][0];
    let mut found = vec![first];
    while found.len() < count {
        let distances = geodesic_distances(&surface.mesh, &surface.geometry, &found);
        let far = (0..distances.len())
            .filter(|&i| {
                distances[i].is_finite() && surface.mesh.halfedge(VertexId::from(i)).is_some()
            })
            .max_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        found.push(VertexId::from(far.unwrap()));
    }
    found
}

/// Angles in the proportion 1 : 2 : 3 : 1 … that add up to what a closed component of this Euler characteristic needs; one negative.
fn angles_for(places: &[VertexId], total: f64) -> Vec<(VertexId, f64)> {
    let weights: Vec<f64> = (0..places.len()).map(|i| 1.0 + (i % 3) as f64).collect();
    let last = places.len() - 1;
    let mut cones: Vec<(VertexId, f64)> = Vec::new();
    let saddle = -0.6;
    let sum: f64 = weights[..last].iter().sum();
    for (i, &v) in places.iter().enumerate() {
        cones.push((v, if i == last { saddle } else { (total - saddle) * weights[i] / sum }));
    }
    cones
}

/// Splits every polygon into triangles and those into four, some times.
fn finer(surface: &Surface, times: usize) -> Surface {
    let mut positions = surface.geometry.positions.clone();
    let mut triangles: Vec<[u32; 3]> =
        surface.mesh.triangles().iter().map(|t| t.map(|v| v.0)).collect();
    for _ in 0..times {
        let mut middles = std::collections::BTreeMap::new();
        let mut next = Vec::new();
        for t in &triangles {
            let m = [0, 1, 2].map(|i| {
                let (a, b) = (t[i], t[(i + 1) % 3]);
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let middle = nalgebra::center(&positions[a as usize], &positions[b as usize]);
                    positions.push(middle);
                    positions.len() as u32 - 1
                })
            });
            next.extend([[t[0], m[0], m[2]], [t[1], m[1], m[0]], [t[2], m[2], m[1]], m]);
        }
        triangles = next;
    }
    let positions: Vec<[f64; 3]> = positions.iter().map(|p| [p.x, p.y, p.z]).collect();
    let mesh = Mesh::new(positions.len(), &triangles).unwrap();
    let (geometry, _) = Geometry::unit_area(&mesh, &positions).unwrap();
    Surface { name: surface.name.clone(), mesh, geometry }
}

#[test]
fn angles_at_cones_and_on_seams_are_exact_and_partners_are_congruent() {
    let mut surfaces = vec![
        (Surface::sphere(12), 7, 2.0 * TAU),
        (Surface::sample("torus"), 6, 0.0),
        (Surface::sample("double_torus"), 6, -2.0 * TAU),
        (Surface::sample("plush_bear"), 14, 2.0 * TAU),
        (Surface::sample("wavy_vase"), 5, 1.0),
        (Surface::sample("noisy_cylinder"), 4, 1.0),
        (Surface::sample("car_hood"), 6, 1.0),
    ];
    surfaces.extend(Surface::shared("rocker-arm.obj").map(|s| (s, 12, 0.0)));
    for (surface, count, total) in surfaces {
        let mut cones = angles_for(&spread(&surface, count), total);
        cones.retain(|(v, _)| !surface.mesh.is_boundary_vertex(*v));
        let flat = Flat::new(&surface, &cones);
        let name = &surface.name;
        assert!(flat.flattening.angles_exact && flat.flattening.seams_equal, "{name}");
        // Rounding of coordinates of size 1 over edges of .01, in sums of up to four angles.
        let worst = flat.worst_angle(&surface, &cones);
        assert!(worst < 1e-10, "{name}: {worst:e}");
        assert!(flat.worst_partners() < 1e-11, "{name}");
        // The u that was asked for is there, inside as well: the patches solve the rows of the whole.
        for (v, &p) in flat.seams.opened.vertex_points.iter().enumerate() {
            assert!((flat.flattening.u[v] - flat.u[p as usize]).abs() < 1e-9, "{name}");
        }
        // A plain vertex on a seam turns one way on one side and as much the other way on the other.
        let angles = flat.rim_angles();
        let mut copies = vec![Vec::new(); surface.mesh.vertex_count()];
        for (v, angle) in angles {
            copies[flat.seams.opened.vertex_points[v.index()] as usize].push(angle);
        }
        let is_cone = |v: usize| cones.iter().any(|(cone, _)| cone.index() == v);
        let plain: Vec<&Vec<f64>> = copies
            .iter()
            .enumerate()
            .filter(|(v, at)| {
                at.len() == 2
                    && !is_cone(*v)
                    && !surface.mesh.is_boundary_vertex(VertexId::from(*v))
            })
            .map(|(_, at)| at)
            .collect();
        assert!(plain.len() > 5, "{name}");
        for at in plain {
            let turns = (PI - at[0]) + (PI - at[1]);
            assert!((turns / TAU - (turns / TAU).round()).abs() < 1e-10, "{name}: {turns}");
        }
    }
}

#[test]
fn the_boundary_of_the_surface_keeps_its_lengths_and_turns_by_the_flux() {
    // Cones of its own curvature: a dome of a cube's five sides flattens without distortion, boundary included.
    let whole = finer(&Surface::from_soup("cube", &cube()), 3);
    let top = whole.geometry.positions.iter().fold(0.0, |m: f64, p| m.max(p.z));
    let triangles: Vec<[u32; 3]> = whole
        .mesh
        .triangles()
        .iter()
        .filter(|t| t.iter().any(|v| whole.geometry.positions[v.index()].z < top - 1e-9))
        .map(|t| t.map(|v| v.0))
        .collect();
    let positions = whole.geometry.positions.iter().map(|p| [p.x, p.y, p.z]).collect();
    let dome = Surface::from_soup("dome", &Soup::from_triangles(positions, &triangles));
    let defects = angle_defects(&dome.mesh, &dome.geometry);
    let cones: Vec<(VertexId, f64)> = dome
        .mesh
        .vertices()
        .filter(|&v| !dome.mesh.is_boundary_vertex(v) && defects[v.index()].abs() > 1e-6)
        .map(|v| (v, defects[v.index()]))
        .collect();
    assert_eq!(cones.len(), 4);
    let flat = Flat::new(&dome, &cones);
    assert!(flat.flattening.angles_exact);
    assert!(flat.worst_length() < 1e-10, "{:e}", flat.worst_length());

    // Elsewhere: lengths change a little, turning angles do not. With u of the boundary 0 they are those of the flux.
    let vase = Surface::sample("wavy_vase");
    let mut cones = angles_for(&spread(&vase, 5), 1.0);
    cones.retain(|(v, _)| !vase.mesh.is_boundary_vertex(*v));
    let flat = Flat::new(&vase, &cones);
    let laplacian = Laplacian::new(&vase.mesh, &vase.geometry);
    let mut flux = vec![0.0; flat.u.len()];
    laplacian.pattern.multiply(&laplacian.values, &flat.u, &mut flux);
    let defects = angle_defects(&vase.mesh, &vase.geometry);
    let mut checked = 0;
    let mut sums = vec![0.0; flat.u.len()];
    let mut copies = vec![0.0; flat.u.len()];
    for (v, angle) in flat.rim_angles() {
        let p = flat.seams.opened.vertex_points[v.index()] as usize;
        sums[p] += angle;
        copies[p] += 1.0;
    }
    for v in vase.mesh.vertices().filter(|&v| vase.mesh.is_boundary_vertex(v)) {
        let turn = PI - sums[v.index()];
        assert!(copies[v.index()] > 0.0);
        assert!((turn - defects[v.index()] - flux[v.index()]).abs() < 1e-10);
        checked += 1;
    }
    assert!(checked > 50);
}

#[test]
fn surfaces_that_are_flat_but_for_their_cones_flatten_without_distortion() {
    let n = 16;
    let mut apex = vec![[0.0, 0.0, 0.8]];
    let mut triangles = Vec::new();
    for j in 1..=8u32 {
        for i in 0..n {
            let (r, t) = (f64::from(j) / 8.0, TAU * f64::from(i) / f64::from(n));
            apex.push([0.6 * r * t.cos(), 0.6 * r * t.sin(), 0.8 * (1.0 - r)]);
            let at = |i: u32, j: u32| 1 + (j - 1) * n + i % n;
            match j {
                1 => triangles.push([0, at(i, 1), at(i + 1, 1)]),
                _ => triangles.extend([
                    [at(i, j - 1), at(i, j), at(i + 1, j)],
                    [at(i, j - 1), at(i + 1, j), at(i + 1, j - 1)],
                ]),
            }
        }
    }
    let tilt = Rotation3::from_euler_angles(0.4, -0.2, 1.0);
    let apex = apex.into_iter().map(|p| (tilt * Point3::from(p)).into()).collect();
    for (surface, corners) in [
        (Surface::from_soup("cone", &Soup::from_triangles(apex, &triangles)), 1),
        (finer(&Surface::from_soup("tetrahedron", &tetrahedron()), 3), 4),
        (finer(&Surface::from_soup("cube", &cube()), 3), 8),
    ] {
        let defects = angle_defects(&surface.mesh, &surface.geometry);
        let cones: Vec<(VertexId, f64)> = surface
            .mesh
            .vertices()
            .filter(|&v| !surface.mesh.is_boundary_vertex(v) && defects[v.index()].abs() > 1e-6)
            .map(|v| (v, defects[v.index()]))
            .collect();
        assert_eq!(cones.len(), corners, "{}", surface.name);
        let flat = Flat::new(&surface, &cones);
        assert!(flat.flattening.angles_exact && flat.flattening.seams_equal);
        // Rounding of coordinates of size 1, magnified by the condition of the systems.
        assert!(flat.worst_length() < 1e-9, "{}: {:e}", surface.name, flat.worst_length());
        assert!(flat.worst_angle(&surface, &cones) < 1e-10);
        let measures = measure(&flat.seams.opened, &flat.geometry, &flat.flattening);
        assert_eq!(measures.totals.flipped, 0);
    }
}

/// A hemisphere of radius 1 with its pole as vertex 0 and 6 j vertices in ring j.
fn hemisphere(rings: u32) -> Surface {
    let mut positions = vec![[0.0, 0.0, 1.0]];
    let start = |j: u32| if j == 0 { 0 } else { 1 + 3 * j * (j - 1) };
    let at = |j: u32, i: u32| if j == 0 { 0 } else { start(j) + i % (6 * j) };
    let mut triangles = Vec::new();
    for j in 1..=rings {
        for i in 0..6 * j {
            let (t, angle) = (
                FRAC_PI_2 * f64::from(j) / f64::from(rings),
                TAU * f64::from(i) / f64::from(6 * j),
            );
            positions.push([t.sin() * angle.cos(), t.sin() * angle.sin(), t.cos()]);
        }
        for sector in 0..6 {
            for i in 0..j {
                let (outer, inner) = (sector * j + i, sector * (j - 1) + i);
                triangles.push([at(j - 1, inner), at(j, outer), at(j, outer + 1)]);
                if i + 1 < j {
                    triangles.push([at(j - 1, inner), at(j, outer + 1), at(j - 1, inner + 1)]);
                }
            }
        }
    }
    Surface::from_soup("hemisphere", &Soup::from_triangles(positions, &triangles))
}

#[test]
fn a_hemisphere_with_a_cone_at_its_pole_converges_to_the_exact_cone() {
    // The plane of stereographic projection has r = tan(t/2), and r^{1−β} / (1 − β) is the distance from a cone of angle 2πβ.
    let beta: f64 = 0.25;
    let mut errors = Vec::new();
    for rings in [8, 16, 32, 64] {
        let surface = hemisphere(rings);
        // Radius 1.
        let scale = surface.geometry.positions.iter().fold(0.0, |m: f64, p| m.max(p.x)).recip();
        let high = surface.geometry.positions.iter().fold(f64::MIN, |m, p| m.max(p.z));
        let pole = (0..surface.mesh.vertex_count())
            .find(|&v| surface.geometry.positions[v].z >= high)
            .map(VertexId::from)
            .unwrap();
        let flat = Flat::new(&surface, &[(pole, TAU * beta)]);
        assert!(flat.flattening.angles_exact);
        let apex = flat.flattening.uv[pole.index()];
        let (mut u_error, mut chart_error) = (0.0f64, 0.0f64);
        for (v, &p) in flat.seams.opened.vertex_points.iter().enumerate() {
            let height = 1.0 - (high - surface.geometry.positions[p as usize].z) * scale;
            let t = height.clamp(-1.0, 1.0).acos();
            if t < 0.5 {
                continue;
            }
            let r = (t / 2.0).tan();
            let u = -beta * r.ln() + (0.5 * (1.0 + r * r)).ln();
            u_error = u_error.max((flat.flattening.u[v] - u).abs());
            let distance = (flat.flattening.uv[v] - apex).norm() * scale;
            chart_error = chart_error.max((distance - r.powf(1.0 - beta) / (1.0 - beta)).abs());
        }
        errors.push((u_error, chart_error));
    }
    for pair in errors.windows(2) {
        // u: second order away from the pole. Charts: order 1 − β, because the mean of u along the first edges from the cone is as
        // wrong as they are long: 2^.75 is 1.68.
        assert!(pair[0].0 / pair[1].0 > 3.5, "{errors:?}");
        assert!(pair[0].1 / pair[1].1 > 1.65, "{errors:?}");
    }
    assert!(errors[3].0 < 2e-5 && errors[3].1 < 3e-3, "{errors:?}");
}

#[test]
fn patches_that_lengths_alone_cannot_close_keep_their_angles_or_say_so() {
    // A sphere cut along its equator into halves that are mirror images, with u = 0 on it: curvature is left along the seam, and
    // the conditions of the halves are the same but for signs.
    let surface = Surface::sphere(8);
    let mut cut = CutMesh::uncut(&surface.mesh);
    let side = |t: [VertexId; 3]| {
        t.iter().map(|v| surface.geometry.positions[v.index()].x).sum::<f64>() > 0.0
    };
    for e in surface.mesh.edges() {
        let faces = [e.halfedge(), e.halfedge().twin()].map(|h| surface.mesh.face(h));
        if let [Some(f), Some(g)] = faces
            && side(surface.mesh.face_vertices(f)) != side(surface.mesh.face_vertices(g))
        {
            cut.cut_edges.push(surface.mesh.edge_vertices(e).map(|v| v.0));
        }
    }
    let opened = cut.open().unwrap();
    let geometry = opened_geometry(&surface, &opened);
    assert_eq!(opened.patch_count, 2);
    let flattening =
        bff_scaled(&opened, &geometry, &vec![0.0; opened.vertex_points.len()]).unwrap();
    assert!(flattening.seams_equal);
    // A torus without cones: a flat torus has no turn between its seams' sides, the discrete u of a bent one has a little.
    let torus = Surface::sample("torus");
    let bent = torus.geometry.positions.iter().map(|p| {
        let up = 0.1 * (9.0 * p.x).sin() + 0.07 * (7.0 * p.y + 2.0 * p.x).cos();
        [p.x + 0.05 * (8.0 * p.y).sin(), p.y, p.z * (1.0 + p.x) + up]
    });
    let (geometry, _) = Geometry::unit_area(&torus.mesh, &bent.collect::<Vec<_>>()).unwrap();
    let torus = Surface { geometry, ..torus };
    let flat = Flat::new(&torus, &[]);
    assert!(flat.flattening.seams_equal && !flat.flattening.angles_exact);
    assert!(flat.worst_partners() < 1e-11);
    // How wrong the angles are is a matter of the triangles' size.
    assert!(flat.worst_angle(&torus, &[]) < 0.05, "{}", flat.worst_angle(&torus, &[]));
}

#[test]
fn scale_factors_that_are_no_numbers_cost_their_patch_its_chart() {
    let surface = Surface::from_soup("cylinder", &cylinder(24, 9));
    let seams = cut_through(&surface.mesh, &surface.geometry, &[], &[]).unwrap();
    let geometry = opened_geometry(&surface, &seams.opened);
    let rim = seams.opened.mesh.boundary_loops()[0];
    for bad in [f64::NAN, f64::INFINITY, -5000.0] {
        let mut u = vec![0.0; seams.opened.vertex_points.len()];
        u[seams.opened.mesh.tail(rim).index()] = bad;
        let flattening = bff_scaled(&seams.opened, &geometry, &u).unwrap();
        assert!(matches!(flattening.charts[0], Err(NoChart::Degenerate { .. })), "{bad}");
        assert!(flattening.uv.iter().all(|p| p.x.is_nan()));
    }
}

/// Opens along seams and checks what is promised of all of them.
fn check(surface: &Surface, cones: &[VertexId], cost: &[f64]) -> Seams {
    // A sphere with fewer than two cones is slit from somewhere, and one edge between two is made two.
    let loose = 3usize.saturating_sub(cones.len()).min(2);
    check_with(surface, cones, cost, loose)
}

/// As [`check`], with so many ends of seams that are no cones.
fn check_with(surface: &Surface, cones: &[VertexId], cost: &[f64], loose: usize) -> Seams {
    let (mesh, geometry) = (&surface.mesh, &surface.geometry);
    let name = &surface.name;
    let seams = cut_through(mesh, geometry, cones, cost).unwrap();
    let shapes = seams.opened.patch_shapes();
    assert_eq!(shapes.len(), mesh.topology().components, "{name}");
    assert!(shapes.iter().all(|&s| s == (1, 1)), "{name}: {shapes:?}");
    let on_rim: BTreeSet<u32> = seams
        .opened
        .mesh
        .vertices()
        .filter(|&v| seams.opened.mesh.is_boundary_vertex(v))
        .map(|v| seams.opened.vertex_points[v.index()])
        .collect();
    assert!(cones.iter().all(|v| on_rim.contains(&v.0)), "{name}");
    let distinct: BTreeSet<[u32; 2]> =
        seams.cut.cut_edges.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    assert_eq!(distinct.len(), seams.cut.cut_edges.len(), "{name}: each edge once");
    let length: f64 = distinct
        .iter()
        .map(|e| {
            let h = mesh.outgoing(VertexId(e[0])).find(|&h| mesh.tip(h).0 == e[1]).unwrap();
            assert!(!mesh.is_boundary_edge(h.edge()));
            geometry.edge_length(h.edge())
        })
        .sum();
    assert!((length - seams.length).abs() < 1e-12 * (1.0 + length));
    if mesh.vertex_count() < 5000 {
        let again = cut_through(mesh, geometry, cones, cost).unwrap();
        assert_eq!(again.cut, seams.cut, "{name}: deterministic");
    }
    // Every end of a seam is a cone or lies on the boundary, unless spheres had to be slit.
    let mut degrees = vec![0; mesh.vertex_count()];
    for v in seams.cut.cut_edges.iter().flatten() {
        degrees[*v as usize] += 1;
    }
    let tips = (0..degrees.len())
        .map(VertexId::from)
        .filter(|&v| degrees[v.index()] == 1 && !mesh.is_boundary_vertex(v) && !cones.contains(&v));
    assert!(tips.count() <= loose, "{name}");
    seams
}

/// Length of a minimum spanning tree of given vertices, all boundary vertices being one, by shortest paths along edges.
fn spanning_tree(surface: &Surface, cones: &[VertexId]) -> f64 {
    let mesh = &surface.mesh;
    let paths = |sources: &[VertexId]| {
        let mut distances = vec![f64::INFINITY; mesh.vertex_count()];
        let mut queue = BTreeSet::new();
        for v in sources {
            distances[v.index()] = 0.0;
            queue.insert((0u64, *v));
        }
        while let Some((bits, v)) = queue.pop_first() {
            for h in mesh.outgoing(v) {
                let candidate = f64::from_bits(bits) + surface.geometry.edge_length(h.edge());
                let tip = mesh.tip(h);
                if candidate < distances[tip.index()] {
                    distances[tip.index()] = candidate;
                    queue.insert((candidate.to_bits(), tip));
                }
            }
        }
        distances
    };
    let mut nodes: Vec<Vec<VertexId>> = cones.iter().map(|&v| vec![v]).collect();
    let boundary: Vec<VertexId> = mesh.vertices().filter(|&v| mesh.is_boundary_vertex(v)).collect();
    if !boundary.is_empty() {
        nodes.retain(|n| !mesh.is_boundary_vertex(n[0]));
        nodes.insert(0, boundary);
    }
    let distances: Vec<Vec<f64>> = nodes.iter().map(|n| paths(n)).collect();
    let mut nearest: Vec<f64> = nodes.iter().map(|n| distances[0][n[0].index()]).collect();
    let mut is_in = vec![false; nodes.len()];
    is_in[0] = true;
    let mut total = 0.0;
    for _ in 1..nodes.len() {
        let next = (0..nodes.len())
            .filter(|&i| !is_in[i])
            .min_by(|&a, &b| nearest[a].total_cmp(&nearest[b]))
            .unwrap();
        is_in[next] = true;
        total += nearest[next];
        for i in 0..nodes.len() {
            nearest[i] = nearest[i].min(distances[next][nodes[i][0].index()]);
        }
    }
    total
}

#[test]
fn every_surface_of_the_zoo_becomes_disks_with_its_cones_on_their_rims() {
    for surface in Surface::zoo() {
        for count in [0, 1, 2, 9] {
            let count = count.min(surface.mesh.vertex_count());
            check(&surface, &spread(&surface, count.max(1))[..count], &[]);
        }
    }
    for name in ["double-torus.obj", "rocker-arm.obj"] {
        if let Some(surface) = Surface::shared(name) {
            check(&surface, &spread(&surface, 25), &[]);
        }
    }
}

#[test]
fn several_components_are_cut_each_for_itself() {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let parts = [
        Surface::sphere(5),
        finer(&Surface::from_soup("cylinder", &cylinder(12, 4)), 1),
        Surface::sample("torus"),
        Surface::sphere(4),
        Surface::from_soup("tetrahedron", &tetrahedron()),
    ];
    let mut cones = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        let first = positions.len() as u32;
        if i != 3 {
            cones.extend(spread(part, 4).into_iter().map(|v| VertexId(v.0 + first)));
        }
        positions.extend(part.geometry.positions.iter().map(|p| [p.x + 3.0 * i as f64, p.y, p.z]));
        triangles.extend(part.mesh.triangles().iter().map(|t| t.map(|v| v.0 + first)));
    }
    let mesh = Mesh::new(positions.len(), &triangles).unwrap();
    let (geometry, _) = Geometry::unit_area(&mesh, &positions).unwrap();
    let surface = Surface { name: "five parts".into(), mesh, geometry };
    // One of the spheres has no cones: it is slit.
    check_with(&surface, &cones, &[], 2);
}

#[test]
fn seams_are_no_longer_than_a_spanning_tree_of_shortest_paths() {
    let mut surfaces = vec![
        (Surface::sphere(12), 20),
        (Surface::sample("plush_bear"), 30),
        (Surface::sample("wavy_vase"), 12),
        (Surface::sample("sinusoidal_sheet"), 25),
    ];
    surfaces.extend(Surface::shared("spot.obj").map(|s| (s, 60)));
    surfaces.extend(Surface::shared("face.obj").map(|s| (s, 40)));
    let mut gains = Vec::new();
    for (surface, count) in surfaces {
        let cones = spread(&surface, count);
        let seams = check(&surface, &cones, &[]);
        let tree = spanning_tree(&surface, &cones);
        assert!(seams.length <= tree * (1.0 + 1e-9), "{}: {} {tree}", surface.name, seams.length);
        gains.push(1.0 - seams.length / tree);
    }
    // Steiner points save up to 13 % in the plane.
    assert!(gains.iter().sum::<f64>() / gains.len() as f64 > 0.01, "{gains:?}");
}

#[test]
fn junctions_move_to_where_three_seams_meet_at_equal_angles() {
    // An even triangle about the pole of a dome, far from its boundary: a spanning tree has two sides of it, the star three radii. One
    // more seam joins it to the boundary.
    let disk = hemisphere(32);
    let ring = 8u32;
    let high = disk.geometry.positions.iter().fold(f64::MIN, |m, p| m.max(p.z));
    let scale = disk.geometry.positions.iter().fold(0.0, |m: f64, p| m.max(p.x)).recip();
    let t = FRAC_PI_2 * f64::from(ring) / 32.0;
    let corner = |k: f64| {
        let angle = TAU * k / 3.0;
        let aim = Vector2::new(t.sin() * angle.cos(), t.sin() * angle.sin());
        let miss = |v: &VertexId| {
            let p = disk.geometry.positions[v.index()];
            let height = 1.0 - (high - p.z) * scale;
            (Vector2::new(p.x, p.y) * scale - aim).norm() + (height - t.cos()).abs()
        };
        disk.mesh.vertices().min_by(|a, b| miss(a).total_cmp(&miss(b))).unwrap()
    };
    let cones = [corner(0.0), corner(1.0), corner(2.0)];
    let seams = check(&disk, &cones, &[]);
    let radius = t / scale;
    let to_rim = (FRAC_PI_2 - t) / scale;
    // Radial edges are straight: the star has three radii.
    let star = 3.0 * radius + to_rim;
    assert!(seams.length < star * 1.001, "{} {star}", seams.length);
}

#[test]
fn cost_moves_seams_out_of_sight_and_must_be_a_number_not_below_zero() {
    let surface = Surface::sphere(16);
    let eye = Point3::new(4.0, 0.3, 0.2);
    let seen = visibility(&surface.mesh, &surface.geometry, eye);
    // Cones on a circle around the axis to the eye, all in sight.
    let cones: Vec<VertexId> = (0..6)
        .map(|i| {
            let angle = TAU * f64::from(i) / 6.0;
            let aim = Point3::new(0.35, angle.cos(), angle.sin());
            let miss =
                |v: &VertexId| -surface.geometry.positions[v.index()].coords.dot(&aim.coords);
            surface.mesh.vertices().min_by(|a, b| miss(a).total_cmp(&miss(b))).unwrap()
        })
        .collect();
    let cost: Vec<f64> = seen.iter().map(|s| 20.0 * s).collect();
    let sight = |seams: &Seams| -> f64 {
        seams
            .cut
            .cut_edges
            .iter()
            .map(|e| {
                let [a, b] = e.map(|v| surface.geometry.positions[v as usize]);
                (b - a).norm() * 0.5 * (seen[e[0] as usize] + seen[e[1] as usize])
            })
            .sum()
    };
    let plain = check(&surface, &cones, &[]);
    let hidden = check(&surface, &cones, &cost);
    assert!(sight(&hidden) < 0.5 * sight(&plain), "{} {}", sight(&hidden), sight(&plain));
    assert!(hidden.length > plain.length);

    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let mut cost = cost.clone();
        cost[7] = bad;
        let refused = cut_through(&surface.mesh, &surface.geometry, &cones, &cost);
        assert!(matches!(refused, Err(SolveError::Parameter { name: "seam cost", .. })), "{bad}");
    }
    let missing = VertexId(surface.mesh.vertex_count() as u32);
    assert!(matches!(
        cut_through(&surface.mesh, &surface.geometry, &[missing], &[]),
        Err(SolveError::NoSuchVertex { vertex, .. }) if vertex == missing
    ));
}

#[test]
fn one_cone_two_neighbours_and_cones_on_the_boundary_are_no_special_cases() {
    let sphere = Surface::sphere(6);
    let one = check(&sphere, &[VertexId(5)], &[]);
    assert!(one.length > 0.3, "half way round: {}", one.length);
    // Neighbours: one edge opens nothing, two do.
    let h = sphere.mesh.halfedge(VertexId(5)).unwrap();
    let pair = [VertexId(5), sphere.mesh.tip(h)];
    assert_eq!(check_with(&sphere, &pair, &[], 1).cut.cut_edges.len(), 2);
    // Twice the same is once.
    assert_eq!(
        check(&sphere, &[VertexId(5), VertexId(5), VertexId(9)], &[]).cut,
        check(&sphere, &[VertexId(9), VertexId(5)], &[]).cut
    );
    let torus = Surface::sample("torus");
    check(&torus, &[VertexId(17)], &[]);
    // On the boundary: nothing to do.
    let vase = Surface::sample("wavy_vase");
    let rim = vase.mesh.tail(vase.mesh.boundary_loops()[0]);
    assert!(check(&vase, &[rim], &[]).cut.cut_edges.is_empty());
}

#[test]
fn charts_do_not_care_where_the_surface_stands_or_how_its_vertices_are_numbered() {
    let surface = Surface::sphere(9);
    let cones = angles_for(&spread(&surface, 5), 2.0 * TAU);
    let flat = Flat::new(&surface, &cones);
    // The same seams on a turned, renumbered copy.
    let count = surface.mesh.vertex_count() as u32;
    let number = |v: u32| (v * 11 + 3) % count;
    assert!(!count.is_multiple_of(11));
    let turn = Rotation3::from_euler_angles(1.0, 0.4, -2.0);
    let mut positions = vec![Point3::origin(); count as usize];
    for (v, p) in surface.geometry.positions.iter().enumerate() {
        positions[number(v as u32) as usize] = turn * p;
    }
    let triangles: Vec<[u32; 3]> =
        surface.mesh.triangles().iter().map(|t| t.map(|v| number(v.0))).collect();
    let mesh = Mesh::new(positions.len(), &triangles).unwrap();
    let geometry = Geometry::new(&mesh, positions).unwrap();
    let other = Surface { name: "turned".into(), mesh, geometry };
    let mut cut = CutMesh::uncut(&other.mesh);
    cut.cut_edges = flat.seams.cut.cut_edges.iter().map(|e| e.map(number)).collect();
    let seams = Seams { opened: cut.open().unwrap(), length: flat.seams.length, cut };
    let moved: Vec<(VertexId, f64)> =
        cones.iter().map(|&(v, angle)| (VertexId(number(v.0)), angle)).collect();
    let again = Flat::along(&other, &moved, seams);
    // u of closed surfaces is free up to a constant, here one for each way of grounding.
    let shift = again.u[number(0) as usize] - flat.u[0];
    let lengths = |flat: &Flat| -> Vec<f64> {
        let opened = &flat.seams.opened;
        let uv = |v: VertexId| -> Point2<f64> { flat.flattening.uv[v.index()] };
        opened
            .mesh
            .faces()
            .flat_map(|f| opened.mesh.face_halfedges(f))
            .map(|h| (uv(opened.mesh.tip(h)) - uv(opened.mesh.tail(h))).norm())
            .collect()
    };
    for (a, b) in lengths(&flat).iter().zip(lengths(&again)) {
        assert!((a * shift.exp() - b).abs() < 1e-9 * a.max(1e-3));
    }
}
