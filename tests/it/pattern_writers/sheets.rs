//! Sheets with everything that a pattern can have on it, made of round pieces: material for the writers.

use std::f64::consts::TAU;

use cutflow::pattern::{
    Bounds, Layer, Line, Outline, Partner, Pattern, Piece, Seam, Sheet, Text, piece_name,
};

/// Where a point of a piece's outline lies: a circle with waves.
fn wave(radius: f64, waves: f64, angle: f64) -> [f64; 2] {
    let r = radius * (0.88 + 0.12 * (waves * angle).cos());
    [r * angle.cos(), r * angle.sin()]
}

/// A ring of points, counter-clockwise.
fn ring(centre: [f64; 2], radius: f64, waves: f64, count: usize) -> Vec<[f64; 2]> {
    let angles = (0..count).map(|i| TAU * i as f64 / count as f64);
    let around = angles.map(|angle| wave(radius, waves, angle));
    around.map(|[x, y]| [centre[0] + x, centre[1] + y]).collect()
}

/// A circle by four Bézier curves, and points on it.
pub fn bezier_circle(centre: [f64; 2], radius: f64) -> (Vec<[f64; 2]>, Vec<[[f64; 2]; 3]>) {
    let k = 4.0 / 3.0 * (TAU / 16.0).tan();
    let at = |x: f64, y: f64| [centre[0] + radius * x, centre[1] + radius * y];
    let curve = vec![
        [at(1.0, k), at(k, 1.0), at(0.0, 1.0)],
        [at(-k, 1.0), at(-1.0, k), at(-1.0, 0.0)],
        [at(-1.0, -k), at(-k, -1.0), at(0.0, -1.0)],
        [at(k, -1.0), at(1.0, -k), at(1.0, 0.0)],
    ];
    let mut points = Vec::new();
    let mut from = at(1.0, 0.0);
    for &[p, q, end] in &curve {
        for i in 0..16 {
            let t = f64::from(i) / 16.0;
            let weights = [(1.0 - t).powi(3), 3.0 * t * (1.0 - t).powi(2), 3.0 * t * t * (1.0 - t)];
            let mix = |a: usize| {
                weights[0] * from[a] + weights[1] * p[a] + weights[2] * q[a] + t.powi(3) * end[a]
            };
            points.push([mix(0), mix(1)]);
        }
        from = end;
    }
    (points, curve)
}

/// A bounding box.
fn bounds(points: &[[f64; 2]]) -> Bounds {
    let fold = |axis: usize, start: f64, pick: fn(f64, f64) -> f64| {
        points.iter().map(|p| p[axis]).fold(start, pick)
    };
    Bounds {
        low: [0, 1].map(|a| fold(a, f64::INFINITY, f64::min)),
        high: [0, 1].map(|a| fold(a, f64::NEG_INFINITY, f64::max)),
    }
}

/// `count` pieces of about twice `radius` in rows of `columns`, each with an outline of `points` points, a hole, a sew line, a fold of
/// each kind, notches, a grain line and texts; each sewn to the next.
pub fn round_pieces(count: usize, columns: usize, radius: f64, points: usize) -> Sheet {
    let pitch = 2.0 * radius + 12.0;
    let rows = count.div_ceil(columns);
    let below = 70.0;
    let size = [columns as f64 * pitch + 20.0, rows as f64 * pitch + 20.0 + below];
    let mut sheet = Sheet {
        title: "Möbel & Co: “Größe ½”".into(),
        size,
        pattern: Pattern {
            pieces: Vec::new(),
            patch_count: count,
            bounds: Bounds { low: [10.0, 10.0 + below], high: [size[0] - 10.0, size[1] - 10.0] },
        },
        lines: Vec::new(),
        texts: Vec::new(),
        frames: Vec::new(),
    };
    for index in 0..count {
        let (column, row) = (index % columns, index / columns);
        let centre =
            [10.0 + pitch * (column as f64 + 0.5), size[1] - 10.0 - pitch * (row as f64 + 0.5)];
        add_piece(&mut sheet, index, count, centre, radius, points);
    }
    let square = vec![[10.0, 10.0], [60.0, 10.0], [60.0, 60.0], [10.0, 60.0]];
    sheet.lines.push(Line {
        layer: Layer::Control,
        id: "control-square".into(),
        piece: None,
        seam: None,
        is_closed: true,
        points: square,
        curve: Vec::new(),
    });
    let text = |id: &str, at, is_left, height, text: &str| Text {
        layer: Layer::Control,
        id: id.into(),
        piece: None,
        seam: None,
        at,
        is_left,
        height,
        text: text.into(),
    };
    sheet.texts.push(text("control-label", [35.0, 35.0], false, 3.0, "50 mm × 50 mm"));
    let title = sheet.title.clone();
    sheet.texts.push(text("title-1", [65.0, 55.0], true, 5.0, &title));
    sheet.lines.sort_by_key(|line| line.layer);
    sheet.texts.sort_by_key(|text| text.layer);
    sheet
}

fn add_piece(
    sheet: &mut Sheet,
    index: usize,
    count: usize,
    centre: [f64; 2],
    radius: f64,
    points: usize,
) {
    let name = piece_name(index);
    let waves = 2.0 + (index % 4) as f64;
    let outer = ring(centre, radius, waves, points);
    let sew = ring(centre, radius - 6.0, waves, points);
    let (hole, hole_curve) = bezier_circle([centre[0], centre[1] - 0.45 * radius], 0.12 * radius);
    let (hole, hole_curve): (Vec<_>, _) = (hole.into_iter().rev().collect(), hole_curve);
    // Reversed, the first point stays the first of the curve run backwards.
    let mut hole = hole;
    hole.rotate_right(1);
    let backwards = {
        let starts: Vec<[f64; 2]> = std::iter::once(hole[0])
            .chain(hole_curve.iter().map(|c| c[2]))
            .take(hole_curve.len())
            .collect();
        let pairs = hole_curve.iter().zip(&starts).rev();
        pairs.map(|(&[p, q, _], &start)| [q, p, start]).collect::<Vec<_>>()
    };
    let outlines = vec![
        Outline { points: sew.clone(), vertices: Vec::new() },
        Outline { points: hole.clone(), vertices: Vec::new() },
    ];
    let half = points / 2;
    let seam = |number: usize, other: usize, first: usize, is_second: bool| {
        let run: Vec<[f64; 2]> = (first..=first + half).map(|i| sew[i % points]).collect();
        let steps = run.windows(2).map(|w| (w[0][0] - w[1][0]).hypot(w[0][1] - w[1][1]));
        let length: f64 = steps.clone().sum();
        let mut arcs_mm = vec![0.0];
        for step in steps {
            arcs_mm.push(arcs_mm[arcs_mm.len() - 1] + step);
        }
        Seam {
            number,
            partner: Partner::Patch(other),
            outline: 0,
            first,
            sides: half,
            is_closed: false,
            is_second,
            length_mm: length,
            surface_length_mm: length,
            arcs_mm,
        }
    };
    let (next, before) = ((index + 1) % count, (index + count - 1) % count);
    let seams = vec![seam(index + 1, next, 0, false), seam(before + 1, before, half, true)];
    let area = outlines.iter().map(Outline::area_mm2).sum();
    let mut line = |layer, id: String, seam, is_closed, points: Vec<[f64; 2]>, curve| {
        let (id, piece) = (format!("{name}-{id}"), Some(index));
        sheet.lines.push(Line { layer, id, piece, seam, is_closed, points, curve });
    };
    line(Layer::Cut, "cut".into(), None, true, outer.clone(), Vec::new());
    line(Layer::Cut, "hole-1".into(), None, true, hole, backwards);
    line(Layer::Sew, "sew".into(), Some(0), true, sew.clone(), Vec::new());
    for k in 0..6 {
        let i = k * points / 6;
        let (p, c) = (outer[i], centre);
        let inward = |d: f64| [0, 1].map(|a| p[a] + d * (c[a] - p[a]) / radius);
        line(Layer::Notch, format!("notch-{k}"), None, false, vec![p, inward(3.0)], Vec::new());
    }
    let [x, y] = centre;
    let r = 0.5 * radius;
    let across = |dy: f64| vec![[x - r, y + dy], [x + r, y + dy]];
    line(Layer::FoldMountain, "fold-1".into(), None, false, across(0.15 * radius), Vec::new());
    line(Layer::FoldValley, "fold-2".into(), None, false, across(0.35 * radius), Vec::new());
    line(Layer::Score, "score-1".into(), None, false, across(0.25 * radius), Vec::new());
    line(Layer::Drill, "drill-1".into(), None, false, vec![[x + r, y - 0.2 * radius]], Vec::new());
    let grain = vec![[x - 0.3 * radius, y - r], [x - 0.3 * radius, y + r]];
    line(Layer::Grain, "grain".into(), None, false, grain, Vec::new());
    let mut text = |id: &str, seam, at, height, words: String| {
        let (id, piece) = (format!("{name}-{id}"), Some(index));
        let layer = Layer::Text;
        sheet.texts.push(Text { layer, id, piece, seam, at, is_left: false, height, text: words });
    };
    text("name", None, centre, 0.1 * radius, name.clone());
    text("note", None, [x, y - 0.15 * radius], 0.04 * radius, format!("cut 1 × – {index}°"));
    let label = |number: usize, other: usize| format!("{number} > {}", piece_name(other));
    text("seam-1", Some(0), [x, y + 0.7 * radius], 3.0, label(index + 1, next));
    text("seam-2", Some(1), [x, y - 0.7 * radius], 3.0, label(before + 1, before));
    sheet.pattern.pieces.push(Piece {
        patch: index,
        name,
        outlines,
        seams,
        area_mm2: area,
        bounds: bounds(&sew),
        centre,
        room_mm: 0.7 * radius,
        crossings: 0,
    });
}
