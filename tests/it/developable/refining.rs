//! Seams along minimum cuts: cheapest against trying all, creases, prices, the gate, the contract.

use cutflow::flatten::merging::{ChartGate, MergeParams};
use cutflow::geometry::Geometry;
use cutflow::mesh::{FaceId, Mesh};
use cutflow::methods::developable::{
    RefineFlow, RefineParams, RefineState, SeamMeasure, VsaParams, seam_curves,
};
use cutflow::methods::flow::SolveError;
use nalgebra::Point3;

use super::*;

/// n × m squares, each divided along the same diagonal, at given places.
fn sheet(n: u32, m: u32, place: impl Fn(f64, f64) -> [f64; 3]) -> Shape {
    let points = (0..=m).flat_map(|j| (0..=n).map(move |i| (i, j)));
    let points: Vec<_> =
        points.map(|(i, j)| Point3::from(place(f64::from(i), f64::from(j)))).collect();
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let triangles: Vec<[u32; 3]> = (0..n * m)
        .map(|k| [k % n, k / n])
        .flat_map(|[i, j]| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let mesh = Mesh::new(points.len(), &triangles).unwrap();
    let geometry = Geometry::new(&mesh, points).unwrap();
    (Arc::new(mesh), Arc::new(geometry))
}

fn column(f: FaceId, n: u32) -> u32 {
    f.0 / 2 % n
}

fn refine(
    (mesh, geometry): &Shape,
    labels: &[u32],
    params: RefineParams,
    prices: &[f64],
) -> RefineState {
    let mut flow = RefineFlow::new(mesh.clone(), geometry, labels, params, prices).unwrap();
    for _ in 0..20_000 {
        let report = flow.step().unwrap();
        assert_complete(mesh, &flow.state().face_charts);
        if report.status != Status::Running {
            return flow.state().clone();
        }
    }
    panic!("no end");
}

/// What the cut through some labels costs on a flat surface.
fn cost((mesh, geometry): &Shape, labels: &[u32], prices: &[f64]) -> f64 {
    seams(mesh, labels)
        .map(|e| geometry.edge_length(e) * prices.get(e.index()).copied().unwrap_or(1.0))
        .sum()
}

#[test]
fn the_seam_is_the_cheapest_of_all() {
    let mut state = 7u64;
    let mut hits = 0;
    for trial in 0..20 {
        // Columns 0 and 4 stay; between them are 12 faces in two rows, which are tried in all ways.
        let surface = sheet(5, 2, |x, y| [x, y, 0.0]);
        let (mesh, _) = &surface;
        let prices: Vec<f64> = mesh
            .edges()
            .map(|_| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                0.1 + (state >> 40) as f64 / (1u64 << 24) as f64
            })
            .collect();
        let labels: Vec<u32> = mesh.faces().map(|f| u32::from(column(f, 5) >= 2)).collect();
        let params =
            RefineParams { rings: 9, may_lengthen: true, passes: 1, ..RefineParams::default() };
        let refined = refine(&surface, &labels, params, &prices);
        // What may move: all but the innermost ring of each chart, which refinement chooses itself.
        let ring = rings(mesh, &labels);
        let deepest = [0, 1].map(|c| {
            mesh.faces().filter(|f| labels[f.index()] == c).map(|f| ring[f.index()]).max().unwrap()
        });
        let free: Vec<FaceId> = mesh
            .faces()
            .filter(|f| ring[f.index()] < deepest[labels[f.index()] as usize])
            .collect();
        assert!(free.len() >= 8 && free.len() <= 16, "{}", free.len());
        let mut least = f64::INFINITY;
        let mut best = labels.clone();
        for set in 0u32..1 << free.len() {
            for (i, f) in free.iter().enumerate() {
                best[f.index()] = set >> i & 1;
            }
            least = least.min(cost(&surface, &best, &prices));
        }
        let found = cost(&surface, &refined.face_charts, &prices);
        // The least cut may leave a chart in two parts; then it is refused. Capacities have 30 bits.
        let is_least = (found - least).abs() < 1e-7 * least;
        assert!(is_least || refined.refused > 0, "trial {trial}: {found} {least}");
        assert!(found <= cost(&surface, &labels, &prices));
        hits += usize::from(is_least);
    }
    assert!(hits >= 15, "{hits}");
}

/// How many rings of faces a face is away from the seam between two labels.
fn rings(mesh: &Mesh, labels: &[u32]) -> Vec<u32> {
    let mut vertices = vec![u32::MAX; mesh.vertex_count()];
    for e in seams(mesh, labels) {
        mesh.edge_vertices(e).iter().for_each(|v| vertices[v.index()] = 0);
    }
    let mut faces = vec![u32::MAX; mesh.face_count()];
    for number in 1..20 {
        for f in mesh.faces().filter(|f| faces[f.index()] == u32::MAX).collect::<Vec<_>>() {
            if mesh.face_vertices(f).iter().any(|v| vertices[v.index()] < number) {
                faces[f.index()] = number;
            }
        }
        for f in mesh.faces().filter(|f| faces[f.index()] == number) {
            for v in mesh.face_vertices(f) {
                vertices[v.index()] = vertices[v.index()].min(number);
            }
        }
    }
    faces
}

#[test]
fn a_zigzag_becomes_straight_on_a_plane() {
    let surface = sheet(12, 8, |x, y| [x, y, 0.0]);
    let (mesh, geometry) = &surface;
    // Teeth one square deep.
    let labels: Vec<u32> =
        mesh.faces().map(|f| u32::from(column(f, 12) >= 5 + (f.0 / 24) % 2)).collect();
    let refined = refine(&surface, &labels, RefineParams::default(), &[]);
    let measure =
        |labels: &[u32]| SeamMeasure::new(mesh, geometry, &seam_curves(mesh, geometry, labels));
    let (before, after) = (measure(&labels), measure(&refined.face_charts));
    assert!(before.zigzags > 5 && (before.length - 15.0).abs() < 1e-12, "{before:?}");
    // Across a sheet of height 8 nothing is shorter than 8.
    assert!(after.zigzags == 0 && (after.length - 8.0).abs() < 1e-12, "{after:?}");
    assert_eq!(refined.length, after.length);
}

#[test]
fn seams_lie_in_valleys_rather_than_on_ridges_or_where_they_are_dear() {
    // A valley at column 8 and a ridge at column 4, equally sharp; the seam begins between them, at 6.
    let fold =
        |x: f64, y: f64| [x, y, if x < 4.0 { x } else { 8.0 - x }.max(0.0) + (x - 8.0).max(0.0)];
    // Of slope 1, then −1 from 4 on, and 1 from 8 on.
    let surface = sheet(12, 8, |x, y| {
        let [x, y, z] = fold(x, y);
        [x, y, z]
    });
    let (mesh, _) = &surface;
    let labels: Vec<u32> = mesh.faces().map(|f| u32::from(column(f, 12) >= 6)).collect();
    let at = |state: &RefineState, j: u32| {
        (0..12).filter(|i| state.face_charts[(2 * (12 * j + i)) as usize] == 0).count()
    };
    let refined = refine(&surface, &labels, RefineParams::default(), &[]);
    assert!((0..8).all(|j| at(&refined, j) == 8), "in the valley");
    // Where the valley is dear the ridge is next.
    let prices: Vec<f64> = mesh
        .edges()
        .map(|e| {
            let is_valley = mesh.edge_vertices(e).iter().all(|v| v.0 % 13 == 8);
            if is_valley { 50.0 } else { 1.0 }
        })
        .collect();
    let refined = refine(&surface, &labels, RefineParams::default(), &prices);
    assert!((0..8).all(|j| at(&refined, j) == 4), "on the ridge");
}

#[test]
fn what_the_gate_refuses_is_not_done() {
    let surface = shape(Surface::sphere(9));
    let (mesh, geometry) = &surface;
    let vsa = approximate(&surface, VsaParams { tolerance: 0.02, ..VsaParams::default() });
    let labels = &vsa.state().face_charts;
    let new =
        || RefineFlow::new(mesh.clone(), geometry, labels, RefineParams::default(), &[]).unwrap();
    let mut shut = new();
    let mut asked = 0;
    let start = shut.state().face_charts.clone();
    while shut
        .step_if(&mut |charts, [a, b]| {
            asked += 1;
            let differs = (0..charts.len()).filter(|&f| charts[f] != start[f]);
            assert!(differs.clone().count() > 0);
            assert!(differs.into_iter().all(|f| [a, b].contains(&charts[f])));
            false
        })
        .unwrap()
        .status
        == Status::Running
    {}
    assert!(asked > 5 && shut.state().refused >= asked && shut.state().moved == 0);
    assert_eq!(shut.state().face_charts, start);
    assert_eq!(shut.status(), Status::Converged);

    // As flat as before: the bound of the flow itself.
    let tolerance = vsa.state().worst;
    let bound =
        refine(&surface, labels, RefineParams { tolerance, ..RefineParams::default() }, &[]);
    let normals = geometry.face_normals(mesh);
    for chart in 0..bound.charts as u32 {
        let faces = || mesh.faces().filter(|f| bound.face_charts[f.index()] == chart);
        let sum = faces().fold(nalgebra::Vector3::zeros(), |s, f| {
            s + normals[f.index()] * geometry.face_areas[f.index()]
        });
        let area: f64 = faces().map(|f| geometry.face_areas[f.index()]).sum();
        // Rounding of a difference of areas.
        assert!(2.0 * (area - sum.norm()) <= tolerance * geometry.total_area() + 1e-14);
    }
}

#[test]
fn behind_the_gate_charts_flatten_as_well_as_before_and_without_it_they_do_not() {
    let surface = shape(Surface::sample("torus"));
    let (mesh, geometry) = &surface;
    let vsa = approximate(&surface, VsaParams { tolerance: 0.002, ..VsaParams::default() });
    let gate = |charts: &[u32]| {
        ChartGate::new(mesh.clone(), geometry.clone(), charts, &MergeParams::default()).unwrap()
    };
    let labels = &vsa.state().face_charts;
    let mut flow =
        RefineFlow::new(mesh.clone(), geometry, labels, RefineParams::default(), &[]).unwrap();
    let mut keeper = gate(&flow.state().face_charts);
    let (flat, cost) = (keeper.flat_charts(), keeper.cost());
    while flow.step_if(&mut |charts, pair| keeper.accepts(charts, pair)).unwrap().status
        == Status::Running
    {}
    let (mesh_charts, length) = (flow.state().face_charts.clone(), flow.state().length);
    assert!(flow.state().moved > 3 && flow.state().refused > 0);
    assert!(keeper.flat_charts() >= flat && keeper.cost() <= cost);
    // What it remembers is what is there.
    let again = gate(&mesh_charts);
    assert_eq!(again.flat_charts(), keeper.flat_charts());
    // The same maps, summed in the same order.
    assert!((again.cost() - keeper.cost()).abs() < 1e-9 * cost);

    let open = refine(&surface, labels, RefineParams::default(), &[]);
    let ungated = gate(&open.face_charts);
    assert!(open.length < length, "more seams move");
    assert!(ungated.cost() > keeper.cost(), "{} {}", ungated.cost(), keeper.cost());
}

#[test]
fn hostile_labels_are_charts_too() {
    let surface = shape(Surface::sphere(6));
    let (mesh, _) = &surface;
    let scattered: Vec<u32> =
        (0..mesh.face_count() as u32).map(|f| f.wrapping_mul(2_654_435_761) >> 30 << 28).collect();
    let one = vec![u32::MAX; mesh.face_count()];
    let each: Vec<u32> = (0..mesh.face_count() as u32).rev().collect();
    for labels in [scattered, one, each] {
        let (_, before) = connected_charts(mesh, &labels);
        let refined = refine(&surface, &labels, RefineParams::default(), &[]);
        assert_eq!(assert_complete(mesh, &refined.face_charts), before);
    }
}

#[test]
fn a_run_repeats_bit_for_bit_descends_goes_on_from_a_checkpoint_and_ends_quietly() {
    let surface = shape(Surface::sample("torus"));
    let (mesh, geometry) = &surface;
    let vsa = approximate(&surface, VsaParams { tolerance: 0.01, ..VsaParams::default() });
    let labels = &vsa.state().face_charts;
    let new =
        || RefineFlow::new(mesh.clone(), geometry, labels, RefineParams::default(), &[]).unwrap();
    let mut whole = new();
    let mut last = [whole.state().cost, whole.state().length];
    let mut total = 0;
    while whole.status() == Status::Running {
        let report = whole.step().unwrap();
        let now = [report.energy[0].1, report.energy[1].1];
        // Lengths are summed in another order than by pair.
        assert!(now[0] <= last[0] && now[1] <= last[1] * (1.0 + 1e-12));
        (last, total) = (now, report.step);
    }
    assert!(whole.state().moved > 10);
    for split in [1, total / 2, total - 1] {
        let mut first = new();
        (0..split).for_each(|_| drop(first.step().unwrap()));
        let mut second = new();
        second.step().unwrap();
        second.restore(&first.checkpoint());
        while second.step().unwrap().status == Status::Running {}
        assert_eq!(second.checkpoint(), whole.checkpoint(), "{split}");
    }
    let checkpoint = whole.checkpoint();
    assert_eq!(whole.step().unwrap().step, total);
    assert_eq!(whole.checkpoint(), checkpoint);
    for (params, prices) in [
        (RefineParams { rings: 0, ..RefineParams::default() }, vec![]),
        (RefineParams::default(), vec![f64::NAN; mesh.edge_count()]),
        (RefineParams::default(), vec![-1.0; mesh.edge_count()]),
    ] {
        let refused = RefineFlow::new(mesh.clone(), geometry, labels, params, &prices);
        assert!(matches!(refused.err(), Some(SolveError::Parameter { .. })));
    }
}
