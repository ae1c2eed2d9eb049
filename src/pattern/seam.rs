//! Seams: which run of an outline is sewn to which.

use std::collections::BTreeMap;

use crate::mesh::{HalfedgeId, OpenedMesh};

/// One side of a seam: a run of a piece's outline that is sewn to a run of the same length on the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam {
    /// The same on both sides; from 1.
    pub number: usize,
    /// What it is sewn to.
    pub partner: Partner,
    /// Index into the piece's outlines.
    pub outline: usize,
    /// Its first side: the one from point `first` of the outline to the next.
    pub first: usize,
    /// Number of its sides, counted on around the outline. The other side of the seam runs the other way.
    pub sides: usize,
    /// Whether it is a whole outline and has no ends. Both sides then start at the same point of the surface.
    pub is_closed: bool,
    /// Whether this is the side that runs against the seam's own direction: the one met second.
    pub is_second: bool,
    /// Length in the plane.
    pub length_mm: f64,
    /// Length on the surface, the same on both sides.
    pub surface_length_mm: f64,
    /// Distance along the surface of each of its points from its first one: `sides + 1` numbers, from 0 to
    /// `surface_length_mm`.
    pub arcs_mm: Vec<f64>,
}

impl Seam {
    /// The distance along the surface from the seam's own beginning, which both sides share, to a distance from this side's first
    /// point; and back.
    pub fn shared_arc(&self, arc_mm: f64) -> f64 {
        if self.is_second { self.surface_length_mm - arc_mm } else { arc_mm }
    }
}

/// Across a seam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// The piece of another patch.
    Patch(usize),
    /// Another run of the same piece; whether that one comes first in it.
    Own {
        /// Whether this is the second of the two runs.
        is_second: bool,
    },
}

/// A seam as a run of sides, before anything is measured.
pub(super) struct Run {
    pub number: usize,
    pub partner: Partner,
    pub first: usize,
    pub sides: usize,
    pub is_closed: bool,
    pub is_second: bool,
}

/// The boundary of the opened surface as loops of sides.
pub(super) struct Rims<'a> {
    opened: &'a OpenedMesh,
    /// For each patch its loops; a loop runs with the surface on its left.
    pub loops: Vec<Vec<Vec<HalfedgeId>>>,
    /// The side before each side.
    before: BTreeMap<HalfedgeId, HalfedgeId>,
}

impl<'a> Rims<'a> {
    pub(super) fn new(opened: &'a OpenedMesh) -> Self {
        let mesh = &opened.mesh;
        let mut loops = vec![Vec::new(); opened.patch_count];
        let mut before = BTreeMap::new();
        for &outside in mesh.boundary_loops() {
            let mut sides: Vec<HalfedgeId> =
                mesh.boundary_loop(outside).map(HalfedgeId::twin).collect();
            sides.reverse();
            for (i, &side) in sides.iter().enumerate() {
                before.insert(side, sides[(i + sides.len() - 1) % sides.len()]);
            }
            if let Some(face) = mesh.face(sides[0]) {
                loops[opened.face_patches[face.index()] as usize].push(sides);
            }
        }
        Self { opened, loops, before }
    }

    /// The seams of all loops, as `loops` are ordered. Sides in none of them are the surface's own rim.
    pub(super) fn runs(&self) -> Vec<Vec<Vec<Run>>> {
        // The number of a seam whose other side was met, by its first halfedge.
        let mut numbers = BTreeMap::new();
        let mut next_number = 1;
        let mut runs_of = |patch: usize, sides: &Vec<HalfedgeId>| {
            let mut runs = Vec::new();
            for (first, count, is_closed) in self.stretches(sides) {
                let last = sides[(first + count - 1) % sides.len()];
                let Some(opposite) = self.opened.partner(last) else { continue };
                let met = numbers.get(&sides[first]).copied();
                let number = met.unwrap_or(next_number);
                if met.is_none() {
                    next_number += 1;
                    numbers.insert(opposite, number);
                }
                let across = self
                    .opened
                    .mesh
                    .face(opposite)
                    .map_or(patch, |face| self.opened.face_patches[face.index()] as usize);
                let partner = if across == patch {
                    Partner::Own { is_second: met.is_some() }
                } else {
                    Partner::Patch(across)
                };
                let is_second = met.is_some();
                runs.push(Run { number, partner, first, sides: count, is_closed, is_second });
            }
            runs
        };
        self.loops
            .iter()
            .enumerate()
            .map(|(patch, loops)| loops.iter().map(|sides| runs_of(patch, sides)).collect())
            .collect()
    }

    /// Cuts a loop where what lies across changes: first side, number of sides, and whether it was not cut at all.
    fn stretches(&self, sides: &[HalfedgeId]) -> Vec<(usize, usize, bool)> {
        let n = sides.len();
        let starts: Vec<usize> =
            (0..n).filter(|&i| !self.continues(sides[(i + n - 1) % n], sides[i])).collect();
        if starts.is_empty() {
            // Both sides of a closed seam begin at the same point.
            let point = |i: &usize| {
                let tail = self.opened.mesh.tail(sides[*i]);
                self.opened.vertex_points[tail.index()]
            };
            let first = (0..n).min_by_key(point).unwrap_or(0);
            return vec![(first, n, true)];
        }
        let next = |k: usize| if k + 1 < starts.len() { starts[k + 1] } else { starts[0] + n };
        starts.iter().enumerate().map(|(k, &first)| (first, next(k) - first, false)).collect()
    }

    /// Whether a side and the next one belong to one seam (or both to the rim).
    fn continues(&self, side: HalfedgeId, next: HalfedgeId) -> bool {
        match (self.opened.partner(side), self.opened.partner(next)) {
            (None, None) => true,
            // At the tip of a slit a side is followed by its own partner.
            (Some(p), Some(q)) => p != next && self.before.get(&p) == Some(&q),
            _ => false,
        }
    }
}
