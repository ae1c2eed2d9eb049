//! What is drawn of a line: the same strokes in every file.

use std::cmp::Ordering;

use super::sheet::{Layer, Line, Sheet};

/// Size of the cross at a point to drill.
const CROSS: f64 = 3.0;

/// A polyline whose consecutive points differ as they are written.
pub(super) struct Stroke {
    pub points: Vec<[f64; 2]>,
    /// The last point is joined to the first, which is not repeated; three points at least.
    pub is_closed: bool,
}

/// To the 0.0001 mm that files hold.
pub(super) fn rounded(x: f64) -> f64 {
    let x = (x * 1e4).round() / 1e4;
    // No −0.
    x + 0.0
}

/// The strokes of a line: none if it is a single place, two for the cross of a point to drill, else one. Places that fall
/// together when written are written once; what then is closed without area is an open slit.
pub(super) fn drawn(line: &Line) -> Vec<Stroke> {
    let mut points: Vec<[f64; 2]> = line.points.iter().map(|p| p.map(rounded)).collect();
    points.dedup();
    let mut is_closed = line.is_closed;
    if is_closed {
        while points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        is_closed = points.len() > 2;
    }
    match points[..] {
        [] => Vec::new(),
        [[x, y]] if line.layer == Layer::Drill => {
            let half = 0.5 * CROSS;
            let open = |points| Stroke { points, is_closed: false };
            vec![open(vec![[x - half, y], [x + half, y]]), open(vec![[x, y - half], [x, y + half]])]
        }
        [_] => Vec::new(),
        _ => vec![Stroke { points, is_closed }],
    }
}

/// Twice the area of a closed polygon, signed.
pub(super) fn twice_area(points: &[[f64; 2]]) -> f64 {
    let Some(&[x, y]) = points.first() else { return 0.0 };
    let sides = points.windows(2).map(|w| [w[0], w[1]]);
    sides.map(|[a, b]| (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x)).sum()
}

/// Cut lines in an order in which nothing loosens before it is done: inner contours before those around them, pieces that lie
/// within a hole of another piece before that piece, open lines of a piece first.
pub(super) fn cutting_order(sheet: &Sheet) -> Vec<usize> {
    let area = |line: &Line| if line.is_closed { twice_area(&line.points).abs() } else { 0.0 };
    let mut outer = vec![0.0_f64; sheet.pattern.pieces.len()];
    let cuts: Vec<usize> =
        (0..sheet.lines.len()).filter(|&i| sheet.lines[i].layer == Layer::Cut).collect();
    for &i in &cuts {
        let line = &sheet.lines[i];
        if let Some(largest) = line.piece.and_then(|piece| outer.get_mut(piece)) {
            *largest = largest.max(area(line));
        }
    }
    let mut keyed: Vec<(f64, usize, f64, usize)> = cuts
        .into_iter()
        .map(|i| {
            let line = &sheet.lines[i];
            let own = area(line);
            let whole = line.piece.and_then(|piece| outer.get(piece)).copied().unwrap_or(own);
            (whole, line.piece.unwrap_or(usize::MAX), own, i)
        })
        .collect();
    keyed.sort_by(|a, b| {
        let by = a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.total_cmp(&b.2));
        if by == Ordering::Equal { a.3.cmp(&b.3) } else { by }
    });
    keyed.into_iter().map(|key| key.3).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(layer: Layer, is_closed: bool, points: &[[f64; 2]]) -> Line {
        let (id, points) = ("a".to_owned(), points.to_vec());
        Line { layer, id, piece: None, seam: None, is_closed, points, curve: Vec::new() }
    }

    #[test]
    fn places_that_fall_together_are_written_once() {
        let strokes = drawn(&line(
            Layer::Cut,
            true,
            &[[0.0, -1e-9], [1.0, 0.0], [1.000_01, 0.0], [1.0, 1.0], [0.0, 1e-6]],
        ));
        assert_eq!(strokes[0].points, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
        assert!(strokes[0].is_closed && strokes[0].points[0][1].is_sign_positive());
    }

    #[test]
    fn a_closed_line_of_two_points_is_a_slit() {
        let strokes = drawn(&line(Layer::Cut, true, &[[0.0, 0.0], [1.0, 0.0]]));
        assert!(strokes.len() == 1 && !strokes[0].is_closed);
        assert!(drawn(&line(Layer::Cut, false, &[[0.0, 0.0], [1e-6, 0.0]])).is_empty());
    }

    #[test]
    fn a_point_to_drill_is_a_cross_of_three_millimetres() {
        let strokes = drawn(&line(Layer::Drill, false, &[[10.0, 20.0]]));
        assert_eq!(strokes[0].points, [[8.5, 20.0], [11.5, 20.0]]);
        assert_eq!(strokes[1].points, [[10.0, 18.5], [10.0, 21.5]]);
    }
}
