//! Pieces moved, turned and turned over, with everything that is drawn of them.

use super::blank::{Blank, Word};
use super::nesting::NestPose;
use super::piece::{Bounds, Outline, Piece};
use super::seam::Seam;
use super::sheet::Line;

impl Blank {
    /// As it lies after a motion. Outlines stay counter-clockwise and holes clockwise when it is turned over.
    pub fn moved(&self, pose: &NestPose) -> Self {
        let points = |points: &[[f64; 2]]| points.iter().map(|&p| pose.apply(p)).collect();
        let closed = |points: &Vec<[f64; 2]>| {
            let mut moved: Vec<[f64; 2]> = points.iter().map(|&p| pose.apply(p)).collect();
            if pose.is_mirrored {
                turn_around(&mut moved);
            }
            moved
        };
        let line = |line: &Line| {
            let mut moved = Line { points: points(&line.points), ..line.clone() };
            moved.curve.iter_mut().flatten().for_each(|p| *p = pose.apply(*p));
            if pose.is_mirrored && line.is_closed {
                turn_around(&mut moved.points);
                moved.curve = reversed(moved.points[0], &moved.curve);
            }
            moved
        };
        Self {
            piece: self.piece.moved(pose),
            cut: self.cut.iter().map(closed).collect(),
            lines: self.lines.iter().map(line).collect(),
            words: self
                .words
                .iter()
                .map(|word| Word { at: pose.apply(word.at), ..word.clone() })
                .collect(),
            hints: self.hints.clone(),
        }
    }
}

impl Piece {
    fn moved(&self, pose: &NestPose) -> Self {
        let outline = |outline: &Outline| {
            let mut moved = Outline {
                points: outline.points.iter().map(|&p| pose.apply(p)).collect(),
                vertices: outline.vertices.clone(),
            };
            if pose.is_mirrored {
                turn_around(&mut moved.points);
                turn_around(&mut moved.vertices);
            }
            moved
        };
        let outlines: Vec<Outline> = self.outlines.iter().map(outline).collect();
        let seams = self.seams.iter().map(|seam| {
            if !pose.is_mirrored {
                return seam.clone();
            }
            // Point i has become point n − i, and the run goes the other way.
            let n = self.outlines[seam.outline].points.len();
            let total = seam.surface_length_mm;
            Seam {
                first: (2 * n - (seam.first + seam.sides) % n) % n,
                is_second: !seam.is_second,
                arcs_mm: seam.arcs_mm.iter().rev().map(|arc| total - arc).collect(),
                ..seam.clone()
            }
        });
        Self {
            seams: seams.collect(),
            bounds: Bounds::around(outlines.iter().flat_map(|o| o.points.iter().copied())),
            centre: pose.apply(self.centre),
            outlines,
            ..self.clone()
        }
    }
}

/// A closed run of points the other way around, from the same first point.
fn turn_around<T>(points: &mut [T]) {
    if let Some(rest) = points.get_mut(1..) {
        rest.reverse();
    }
}

/// A closed chain of curves the other way around.
fn reversed(start: [f64; 2], curve: &[[[f64; 2]; 3]]) -> Vec<[[f64; 2]; 3]> {
    let begins = std::iter::once(start).chain(curve.iter().map(|[.., end]| *end));
    let pairs = curve.iter().zip(begins);
    let mut reversed: Vec<_> = pairs.map(|([c1, c2, _], begin)| [*c2, *c1, begin]).collect();
    reversed.reverse();
    reversed
}
