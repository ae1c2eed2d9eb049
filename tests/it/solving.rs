//! From files as they come to cuts: slivers, many components, what the file says besides shape, sizes in exports.

use cutflow::geometry::Geometry;
use cutflow::mesh::read::obj;
use cutflow::mesh::{Mesh, Soup};
use cutflow::session::{Command, Document, Session, Value, samples};

fn text_of(soup: &Soup) -> String {
    let mut text = String::new();
    for [x, y, z] in &soup.positions {
        text += &format!("v {x} {y} {z}\n");
    }
    for i in 0..soup.polygon_count() {
        let corners: Vec<String> = soup.polygon(i).iter().map(|v| (v + 1).to_string()).collect();
        text += &format!("f {}\n", corners.join(" "));
    }
    text
}

/// A ball in which every tenth triangle is divided by a point that lies almost (`height` sides away), or exactly, on one
/// of its sides.
fn with_slivers(frequency: u32, height: f64) -> Soup {
    let ball = samples::icosphere(frequency);
    let mut positions = ball.positions.clone();
    let mut triangles = Vec::new();
    for i in 0..ball.polygon_count() {
        let [a, b, c] = [0, 1, 2].map(|k| ball.polygon(i)[k]);
        if i % 10 != 3 {
            triangles.push([a, b, c]);
            continue;
        }
        let at = |v: u32| ball.positions[v as usize];
        let new = [0, 1, 2].map(|k| {
            let on_side = 0.5 * (at(a)[k] + at(b)[k]);
            on_side + height * (at(c)[k] - on_side)
        });
        let n = positions.len() as u32;
        positions.push(new);
        triangles.extend([[a, b, n], [b, c, n], [c, a, n]]);
    }
    Soup::from_triangles(positions, &triangles)
}

fn cut_by_plane(text: &str, steps: usize) -> Session {
    let mut session = Session::new();
    session.open("ball.obj", text.as_bytes());
    for (id, value) in [
        ("init", Value::Text("plane".into())),
        ("dirichlet", Value::Number(10.0)),
        ("hencky", Value::Number(0.0)),
    ] {
        session.handle(Command::SetParameter { id: id.into(), value });
    }
    for _ in 0..steps {
        session.handle(Command::Step);
    }
    session
}

#[test]
fn slivers_and_triangles_without_area_do_not_change_the_energy_of_a_cut() {
    let clean = cut_by_plane(&text_of(&samples::icosphere(14)), 0);
    let energy = clean.history()[0].total;
    for height in [1e-2, 1e-5, 1e-9, 0.0] {
        let soup = with_slivers(14, height);
        let mut session = cut_by_plane(&text_of(&soup), 0);
        let surface = session.document().unwrap().surface.as_ref().unwrap();
        let better = surface.solving.as_ref().unwrap();
        let cotangents = better.geometry.corner_cotangents.iter().flatten();
        let largest = cotangents.fold(0.0, |m: f64, c| m.max(c.abs()));
        // Intrinsic Delaunay angles beside a mid-edge point of an even triangle are about 30° and 120°.
        assert!(largest < 30.0, "{height}: {largest}");
        let total = session.history()[0].total;
        // The added points change the discrete problem by the order of an edge squared: 1/14² of it.
        assert!((total / energy - 1.0).abs() < 0.01, "{height}: {total} {energy}");
        // The result comes back on the vertices of the file.
        for _ in 0..5 {
            session.handle(Command::Step);
        }
        assert!(session.history().last().unwrap().total < total);
        assert_eq!(session.labels().len(), soup.positions.len());
        let file = session.export("UV mesh (OBJ)").unwrap();
        let read = obj::read(&file.bytes).unwrap().soup;
        assert_eq!(read.positions[..soup.positions.len()], soup.positions);
        let report = session.cut_report(None).unwrap();
        assert_eq!(report.patches.len(), 2);
        // A sliver is turned over where the chart bends its long side by more than its height; what is not thin stays.
        let slivers = samples::icosphere(14).polygon_count() / 10;
        assert!(report.flattening.totals.flipped <= slivers, "{height}");
        assert!(report.flattening.totals.area_distortion.is_finite(), "{height}");
    }
}

#[test]
fn a_cut_taken_back_to_the_given_triangles_is_as_long_as_the_one_solved_on() {
    let mut session = cut_by_plane(&text_of(&with_slivers(20, 1e-4)), 8);
    let solved = session.history().last().unwrap().length;
    let report = session.cut_report(None).unwrap();
    assert!(report.patches.iter().all(|p| p.euler == 1));
    let given = session.layout().unwrap().cut_length();
    // They differ where a flipped edge and the given one see the level set change sign at other places.
    assert!((given / solved - 1.0).abs() < 0.02, "{given} {solved}");
}

#[test]
fn forty_five_components_are_cut_and_flattened() {
    let ball = samples::icosphere(4);
    let mut text = String::new();
    for i in 0..45 {
        for [x, y, z] in &ball.positions {
            text +=
                &format!("v {} {y} {}\n", x + 3.0 * f64::from(i % 9), z + 3.0 * f64::from(i / 9));
        }
        for f in 0..ball.polygon_count() {
            let first = i as usize * ball.positions.len() + 1;
            let [a, b, c] = [0, 1, 2].map(|k| ball.polygon(f)[k] as usize + first);
            text += &format!("f {a} {b} {c}\n");
        }
    }
    for init in ["normals", "plane"] {
        let mut session = Session::new();
        session.open("parts.obj", text.as_bytes());
        assert_eq!(session.info_report().unwrap().components, 45);
        session
            .handle(Command::SetParameter { id: "init".into(), value: Value::Text(init.into()) });
        for _ in 0..3 {
            session.handle(Command::Step);
        }
        let rows = session.history();
        assert!(rows.last().unwrap().total < rows[0].total, "{init}");
        let report = session.cut_report(None).unwrap();
        assert!(
            report.patches.len() >= 45 && report.patches.iter().all(|p| p.euler == 1),
            "{init}"
        );
        assert!(report.flattening.charts.iter().all(Option::is_some), "{init}");
    }
}

#[test]
fn normals_groups_and_materials_come_back_in_the_uv_mesh() {
    // A pyramid on a square, two materials, two groups, a normal for each corner.
    let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1.5\n\
        vn 0 0 -1\nvn 0 -0.8 0.6\nvn 0.8 0 0.6\nvn 0 0.8 0.6\nvn -0.8 0 0.6\n\
        g base\nusemtl felt\nf 4//1 3//1 2//1 1//1\n\
        g roof\nusemtl tin plate\nf 1//2 2//2 5//2\nf 2//3 3//3 5//3\nf 3//4 4//4 5//4\nf 4//5 1//5 5//5\n";
    let mut session = Session::new();
    session.open("house.obj", text.as_bytes());
    let written = session.export("UV mesh (OBJ)").unwrap().bytes;
    let read = obj::read(&written).unwrap().soup;
    assert_eq!(read.positions[..5], obj::read(text.as_bytes()).unwrap().soup.positions[..]);
    assert_eq!(read.materials, ["felt", "tin plate"]);
    for i in 0..read.polygon_count() {
        let corners = read.starts[i] as usize..read.starts[i + 1] as usize;
        let material = read.materials[read.polygon_materials[i] as usize].as_str();
        let group = read.groups[read.polygon_groups[i] as usize].as_str();
        for corner in corners {
            // Flat faces: also the points on the cut have the normal of their face.
            let normal = read.normals[read.normal_corners[corner] as usize];
            let is_base = normal[2] < 0.0;
            assert_eq!((material == "felt", group.ends_with("base")), (is_base, is_base));
            let length = normal.iter().map(|x| x * x).sum::<f64>();
            assert!((length - 1.0).abs() < 1e-9);
        }
    }
    let mesh = obj::read(&session.export("Mesh (OBJ)").unwrap().bytes).unwrap().soup;
    let file = obj::read(text.as_bytes()).unwrap().soup;
    assert_eq!(mesh, Soup { lines: mesh.lines.clone(), ..file });
}

#[test]
fn far_and_tiny_and_flattened_meshes_give_the_same_angles() {
    let ball = samples::icosphere(8);
    let area = |d: &Document| d.surface.as_ref().unwrap().geometry.total_area();
    for (shift, scale) in [(0.0, 1.0), (1e9, 1e3), (0.0, 1e-6), (-3e7, 1.0)] {
        let mut moved = ball.clone();
        for p in moved.positions.iter_mut().flatten() {
            *p = *p * scale + shift;
        }
        let d = Document::from_bytes("ball.obj", text_of(&moved).as_bytes()).unwrap();
        assert!((area(&d) - 1.0).abs() < 1e-12);
        let smallest =
            |g: &Geometry| g.corner_angles.iter().flatten().fold(9.0, |m: f64, a| m.min(*a));
        let triangles: Vec<[u32; 3]> =
            (0..ball.polygon_count()).map(|i| [0, 1, 2].map(|k| ball.polygon(i)[k])).collect();
        let mesh = Mesh::new(ball.positions.len(), &triangles).unwrap();
        let exact = Geometry::unit_area(&mesh, &ball.positions).unwrap().0;
        let is = smallest(&d.surface.as_ref().unwrap().geometry);
        // 1e9 in double precision leaves 1e-7, a ten-thousandth of an edge of 1e3 / 8.
        assert!((is - smallest(&exact)).abs() < 1e-6, "{shift} {scale}");
    }
}
