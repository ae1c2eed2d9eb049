//! Pieces in millimetres.

use std::collections::BinaryHeap;
use std::f64::consts::SQRT_2;
use std::fmt;

use nalgebra::{Point2, Point3};

use super::seam::{Partner, Rims, Run, Seam};
use crate::flatten::overlap;
use crate::mesh::{OpenedMesh, VertexId};

/// All pieces, as they lie on the sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    /// In the order of their patches.
    pub pieces: Vec<Piece>,
    /// Number of patches, those without a piece included.
    pub patch_count: usize,
    /// Around all pieces; its low corner is the origin.
    pub bounds: Bounds,
}

/// A chart in millimetres: what is cut out. Seen from outside the surface, y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// The patch that it is the chart of, counted from 0.
    pub patch: usize,
    /// The patch as letters: A, B, …, Z, AA.
    pub name: String,
    /// The outer outline, counter-clockwise, then those of holes, clockwise.
    pub outlines: Vec<Outline>,
    /// The parts of the outlines that are sewn. What is in none of them is the rim of the surface.
    pub seams: Vec<Seam>,
    /// Area within the outlines.
    pub area_mm2: f64,
    /// Around the outlines.
    pub bounds: Bounds,
    /// The place farthest from the outlines: room for a label.
    pub centre: [f64; 2],
    /// Distance from there to the outlines.
    pub room_mm: f64,
    /// How often the outlines cross one another or themselves.
    pub crossings: usize,
}

/// A closed polygon with the piece on its left; the first point is not repeated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Places, mm.
    pub points: Vec<[f64; 2]>,
    /// The vertex of the opened surface at each point.
    pub vertices: Vec<VertexId>,
}

/// An upright rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub low: [f64; 2],
    /// Largest coordinates.
    pub high: [f64; 2],
}

/// What a person should know of a piece before cutting it. Patches are counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// The patch has no chart; there is no piece.
    NoChart {
        /// The patch.
        patch: usize,
    },
    /// The chart is turned over or has no area; there is no piece.
    NoArea {
        /// The patch.
        patch: usize,
    },
    /// The outline crosses itself: the piece is drawn, but cannot be cut from one sheet.
    CrossesItself {
        /// The patch.
        patch: usize,
        /// How often.
        crossings: usize,
        /// Where the first crossing lies on the sheet, mm.
        at: [f64; 2],
    },
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoChart { patch } => {
                write!(
                    f,
                    "piece {} ({}) is missing: it was not flattened",
                    patch + 1,
                    piece_name(*patch)
                )
            }
            Self::NoArea { patch } => {
                write!(
                    f,
                    "piece {} ({}) is missing: its chart has no area",
                    patch + 1,
                    piece_name(*patch)
                )
            }
            Self::CrossesItself { patch, crossings, at } => {
                let times =
                    if *crossings == 1 { "once".into() } else { format!("{crossings} times") };
                let [x, y] = at;
                let name = piece_name(*patch);
                write!(f, "the outline of piece {} ({name}) crosses itself {times}, ", patch + 1)?;
                write!(f, "first at {x:.1}, {y:.1} mm")
            }
        }
    }
}

/// Letters for a patch: A to Z, then AA, AB, …
pub fn piece_name(patch: usize) -> String {
    let mut letters = Vec::new();
    let mut rest = patch + 1;
    while rest > 0 {
        rest -= 1;
        letters.push(char::from(b"ABCDEFGHIJKLMNOPQRSTUVWXYZ"[rest % 26]));
        rest /= 26;
    }
    letters.iter().rev().collect()
}

impl Pattern {
    /// Pieces in millimetres from charts.
    ///
    /// **Takes** a place for each vertex of the opened surface, charts laid out on one sheet (NaN where a patch has none), the
    /// points of the surface in the same unit, and millimetres per unit. **Gives** the pieces as they lie, moved so that their
    /// bounds begin at the origin, and what is wrong with any. **Costs** about O(n log n).
    pub fn new(
        opened: &OpenedMesh,
        charts: &[[f64; 2]],
        positions: &[Point3<f64>],
        mm_per_unit: f64,
    ) -> (Self, Vec<Notice>) {
        assert_eq!(charts.len(), opened.mesh.vertex_count());
        assert!(mm_per_unit.is_finite() && mm_per_unit > 0.0);
        let rims = Rims::new(opened);
        let mut notices = Vec::new();
        let mut pieces = Vec::new();
        for (patch, (loops, runs)) in rims.loops.iter().zip(rims.runs()).enumerate() {
            let mut outlines: Vec<(Outline, Vec<Run>)> = Vec::new();
            for (sides, runs) in loops.iter().zip(runs) {
                let vertices: Vec<VertexId> = sides.iter().map(|&h| opened.mesh.tail(h)).collect();
                let place = |v: &VertexId| charts[v.index()].map(|x| x * mm_per_unit);
                let points = vertices.iter().map(place);
                outlines.push((Outline { points: points.collect(), vertices }, runs));
            }
            outlines.sort_by(|(a, _), (b, _)| b.area_mm2().total_cmp(&a.area_mm2()));
            let mut all = outlines.iter().flat_map(|(outline, _)| &outline.points).flatten();
            if outlines.is_empty() || !all.all(|x| x.is_finite()) {
                notices.push(Notice::NoChart { patch });
                continue;
            }
            // Distances along the surface from the first point of a run.
            let arcs = |outline: &Outline, run: &Run| {
                let place = |i: usize| {
                    let vertex = outline.vertices[i % outline.vertices.len()];
                    positions[opened.vertex_points[vertex.index()] as usize]
                };
                let mut arc = 0.0;
                let rest = (run.first..run.first + run.sides).map(|i| {
                    arc += (place(i + 1) - place(i)).norm() * mm_per_unit;
                    arc
                });
                std::iter::once(0.0).chain(rest).collect::<Vec<f64>>()
            };
            let seams = outlines.iter().enumerate().flat_map(|(index, (outline, runs))| {
                runs.iter().map(move |run| {
                    let arcs_mm = arcs(outline, run);
                    Seam {
                        number: run.number,
                        partner: run.partner,
                        outline: index,
                        first: run.first,
                        sides: run.sides,
                        is_closed: run.is_closed,
                        is_second: run.is_second,
                        length_mm: length(&outline.run(run.first, run.sides)),
                        surface_length_mm: arcs_mm[run.sides],
                        arcs_mm,
                    }
                })
            });
            let seams = seams.collect();
            let outlines: Vec<Outline> = outlines.into_iter().map(|(outline, _)| outline).collect();
            pieces.push(Piece::new(patch, outlines, seams));
        }
        pieces.retain(|piece| {
            // A hair's breadth of area is none: the outline is a line, or rounding noise.
            let extent = length(&[piece.bounds.low, piece.bounds.high]);
            let has_area = piece.area_mm2 > 1e-9 * extent * extent;
            if !has_area {
                notices.push(Notice::NoArea { patch: piece.patch });
            }
            has_area
        });
        let bounds = Bounds::around(pieces.iter().flat_map(|p| [p.bounds.low, p.bounds.high]));
        for piece in &mut pieces {
            piece.translate(bounds.low.map(|x| -x));
            piece.centre_and_room();
            let (crossings, at) = crossings(&piece.outlines);
            piece.crossings = crossings;
            if crossings > 0 {
                notices.push(Notice::CrossesItself { patch: piece.patch, crossings, at });
            }
        }
        let high = [0, 1].map(|a| bounds.high[a] - bounds.low[a]);
        let bounds = Bounds { low: [0.0; 2], high };
        notices.sort_by_key(Notice::patch);
        (Self { pieces, patch_count: opened.patch_count, bounds }, notices)
    }
}

impl Notice {
    /// The patch that it is about.
    pub fn patch(&self) -> usize {
        match *self {
            Self::NoChart { patch }
            | Self::NoArea { patch }
            | Self::CrossesItself { patch, .. } => patch,
        }
    }
}

impl Piece {
    fn new(patch: usize, outlines: Vec<Outline>, seams: Vec<Seam>) -> Self {
        Self {
            patch,
            name: piece_name(patch),
            area_mm2: outlines.iter().map(Outline::area_mm2).sum(),
            bounds: Bounds::around(
                outlines.iter().flat_map(|outline| outline.points.iter().copied()),
            ),
            centre: [0.0; 2],
            room_mm: 0.0,
            crossings: 0,
            outlines,
            seams,
        }
    }

    /// The points of a seam, ends included.
    pub fn seam_points(&self, seam: &Seam) -> Vec<[f64; 2]> {
        self.outlines[seam.outline].run(seam.first, seam.sides)
    }

    /// What is written beside a seam: `3 > B`, or `3a > 3b` where the piece is sewn to itself.
    pub fn seam_label(&self, seam: &Seam) -> String {
        let number = seam.number;
        match seam.partner {
            Partner::Patch(patch) => format!("{number} > {}", piece_name(patch)),
            Partner::Own { is_second: false } => format!("{number}a > {number}b"),
            Partner::Own { is_second: true } => format!("{number}b > {number}a"),
        }
    }

    pub(super) fn translate(&mut self, by: [f64; 2]) {
        let places = self.outlines.iter_mut().flat_map(|outline| &mut outline.points);
        let marks = [&mut self.bounds.low, &mut self.bounds.high, &mut self.centre];
        for p in places.chain(marks) {
            *p = [p[0] + by[0], p[1] + by[1]];
        }
    }

    /// Whether a point lies within the outlines (even–odd).
    pub(super) fn contains(&self, p: [f64; 2]) -> bool {
        let sides = self.outlines.iter().flat_map(Outline::sides);
        let crossed = sides.filter(|(a, b)| {
            (a[1] > p[1]) != (b[1] > p[1])
                && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        crossed.count() % 2 == 1
    }

    /// Signed distance to the outlines, positive inside.
    pub(super) fn distance(&self, p: [f64; 2]) -> f64 {
        let sides = self.outlines.iter().flat_map(Outline::sides);
        let nearest = sides.map(|(a, b)| squared_distance(p, a, b)).fold(f64::INFINITY, f64::min);
        if self.contains(p) { nearest.sqrt() } else { -nearest.sqrt() }
    }

    /// Finds the pole of inaccessibility by a best-first search over squares, to a hundredth of the piece's width.
    fn centre_and_room(&mut self) {
        let Bounds { low, high } = self.bounds;
        let extent = [high[0] - low[0], high[1] - low[1]];
        let tolerance = 0.01 * extent[0].min(extent[1]).max(extent[0].max(extent[1]) / 64.0);
        // Squares by centre and half side, and the distance that no point of a square can exceed. That is positive
        // where it matters, and then ordered as its bits are.
        let mut squares =
            vec![([0, 1].map(|a| 0.5 * (low[a] + high[a])), 0.5 * extent[0].max(extent[1]))];
        let mut queue = BinaryHeap::from([(f64::INFINITY.to_bits(), 0)]);
        let mut best = (squares[0].0, self.distance(squares[0].0));
        while let Some((bound, square)) = queue.pop() {
            if f64::from_bits(bound) <= best.1 + tolerance {
                break;
            }
            let ([x, y], half) = squares[square];
            let h = 0.5 * half;
            for centre in [[x - h, y - h], [x + h, y - h], [x - h, y + h], [x + h, y + h]] {
                let distance = self.distance(centre);
                if distance > best.1 {
                    best = (centre, distance);
                }
                let bound = distance + h * SQRT_2;
                if bound > best.1.max(0.0) + tolerance {
                    queue.push((bound.to_bits(), squares.len()));
                    squares.push((centre, h));
                }
            }
        }
        (self.centre, self.room_mm) = (best.0, best.1.max(0.0));
    }
}

impl Outline {
    /// Enclosed area; negative where the outline runs clockwise.
    pub fn area_mm2(&self) -> f64 {
        // About a point of the outline, so that a far sheet loses no digits.
        let Some(&[x, y]) = self.points.first() else { return 0.0 };
        let twice = self.sides().map(|(a, b)| (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x));
        0.5 * twice.sum::<f64>()
    }

    /// Pairs of consecutive points, the last and the first included.
    pub fn sides(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
        let next = self.points.iter().cycle().skip(1);
        self.points.iter().zip(next).map(|(&a, &b)| (a, b))
    }

    /// The points of a number of consecutive sides: one more.
    pub fn run(&self, first: usize, sides: usize) -> Vec<[f64; 2]> {
        (first..=first + sides).map(|i| self.points[i % self.points.len()]).collect()
    }
}

impl Bounds {
    /// The smallest rectangle around points; a point at the origin around none.
    pub fn around(points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        points
            .into_iter()
            .map(|p| Self { low: p, high: p })
            .reduce(|a, b| Self {
                low: [0, 1].map(|i| a.low[i].min(b.low[i])),
                high: [0, 1].map(|i| a.high[i].max(b.high[i])),
            })
            .unwrap_or(Self { low: [0.0; 2], high: [0.0; 2] })
    }
}

/// Length of an open polyline.
pub(super) fn length(points: &[[f64; 2]]) -> f64 {
    points.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum()
}

/// Squared distance of a point from a segment.
pub(super) fn squared_distance([x, y]: [f64; 2], [ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    let (dx, dy) = (bx - ax, by - ay);
    let squared = dx * dx + dy * dy;
    let t = if squared > 0.0 { ((x - ax) * dx + (y - ay) * dy) / squared } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    let (rx, ry) = (x - ax - t * dx, y - ay - t * dy);
    rx * rx + ry * ry
}

/// A crossing counts if both sides reach at least this far beyond each other, mm. The two sides of a cut in a flat surface lie
/// on each other up to rounding, and would cross by chance if this were 0; no blade sees a micrometre.
const DEPTH_MM: f64 = 1e-3;

/// How often the sides of outlines cross, and where first.
pub(super) fn crossings(outlines: &[Outline]) -> (usize, [f64; 2]) {
    let corners: Vec<Vec<Point2<f64>>> = outlines
        .iter()
        .map(|outline| outline.points.iter().copied().map(Point2::from).collect())
        .collect();
    let corners: Vec<&[Point2<f64>]> = corners.iter().map(Vec::as_slice).collect();
    let ends = |name: overlap::Side| {
        let corners = corners[name.outline as usize];
        let i = name.side as usize;
        [corners[i], corners[(i + 1) % corners.len()]]
    };
    let pairs = overlap::crossings(&corners).into_iter().map(|pair| pair.map(ends));
    let deep: Vec<_> =
        pairs.filter(|&[s, t]| depth(s, t) > DEPTH_MM && depth(t, s) > DEPTH_MM).collect();
    let at = deep.first().map_or([0.0; 2], |&[[a, b], [c, d]]| {
        let [before, after] = [a, b].map(|p| overlap::orientation(c, d, p));
        let p = a + (b - a) * (before / (before - after));
        [p.x, p.y]
    });
    (deep.len(), at)
}

/// How far a segment that crosses a line reaches beyond it.
fn depth(line: [Point2<f64>; 2], segment: [Point2<f64>; 2]) -> f64 {
    let [a, b] = line;
    let twice = segment.map(|p| overlap::orientation(a, b, p).abs());
    twice[0].min(twice[1]) / (b - a).norm()
}
