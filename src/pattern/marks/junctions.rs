//! Points of the surface where three or more seams end.

use std::collections::{BTreeMap, BTreeSet};

use super::ticks::{inwards, seam_ends};
use crate::pattern::labels::text_width;
use crate::pattern::laid::LaidSurface;
use crate::pattern::piece::{Pattern, Piece};

/// Height of the letters, and half the diagonal of the diamond, mm.
const HEIGHT: f64 = 2.0;
const HALF_DIAMOND: f64 = 0.6;
/// Where the letters may stand along the bisector of the corner, mm from it.
const NEAREST: f64 = 3.0;
const STEP: f64 = 0.5;
const TRIES: u32 = 24;

/// For each piece the outline and the point of each junction on it, and the number of the junction.
///
/// Junctions are numbered from 0 in the order in which the pieces show them.
pub(super) fn junctions(
    surface: &LaidSurface,
    pattern: &Pattern,
) -> Vec<Vec<(usize, usize, usize)>> {
    let vertex_points = &surface.opened.vertex_points;
    // Ends of seams at each point of the surface: number, and which end of the seam's own direction.
    let mut ends: BTreeMap<u32, BTreeSet<(usize, bool)>> = BTreeMap::new();
    for piece in &pattern.pieces {
        for seam in piece.seams.iter().filter(|seam| !seam.is_closed) {
            let vertices = &piece.outlines[seam.outline].vertices;
            for (i, is_last) in [(seam.first, false), (seam.first + seam.sides, true)] {
                let point = vertex_points[vertices[i % vertices.len()].index()];
                let end = (seam.number, is_last != seam.is_second);
                ends.entry(point).or_default().insert(end);
            }
        }
    }
    let mut numbers: BTreeMap<u32, usize> = BTreeMap::new();
    let mut found = Vec::new();
    for piece in &pattern.pieces {
        let mut own = Vec::new();
        for (outline, at) in seam_ends(piece) {
            let point = vertex_points[piece.outlines[outline].vertices[at].index()];
            if ends.get(&point).is_some_and(|ends| ends.len() >= 3) {
                let next = numbers.len();
                own.push((outline, at, *numbers.entry(point).or_insert(next)));
            }
        }
        found.push(own);
    }
    found
}

/// A small diamond in a corner, and where its letters stand: middle, height, letters.
pub(super) fn mark(
    piece: &Piece,
    (outline, at): (usize, usize),
    letters: &str,
) -> (Vec<[f64; 2]>, ([f64; 2], f64, String)) {
    let points = &piece.outlines[outline].points;
    let p = points[at];
    let [x, y] = inwards(points, at);
    let along = |d: f64| [p[0] + d * x, p[1] + d * y];
    let half = 0.5 * text_width(letters, HEIGHT).hypot(HEIGHT);
    // The first place with room for the letters, or the one with most room.
    let mut best = (f64::NEG_INFINITY, NEAREST);
    let places = (0..TRIES).map(|k| NEAREST + half + STEP * f64::from(k));
    for d in places {
        let room = piece.distance(along(d));
        if room > best.0 {
            best = (room, d);
        }
        if room >= half {
            break;
        }
    }
    let at = along(best.1);
    // The diamond between corner and letters.
    let c = along((best.1 - half - HALF_DIAMOND).max(HALF_DIAMOND));
    let corner = |dx: f64, dy: f64| [c[0] + HALF_DIAMOND * dx, c[1] + HALF_DIAMOND * dy];
    let diamond = vec![corner(1.0, 0.0), corner(0.0, 1.0), corner(-1.0, 0.0), corner(0.0, -1.0)];
    (diamond, (at, HEIGHT, letters.to_owned()))
}
