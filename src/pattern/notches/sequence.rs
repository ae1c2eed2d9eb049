//! Groups of notches along a seam, and whether two seams could be taken for each other.

use super::plan::{NotchPlan, SeamNotches};
use crate::pattern::{Partner, Pattern};

/// Marks that belong together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Distance of its middle from the beginning of the seam, along the surface.
    pub arc_mm: f64,
    /// How many marks.
    pub count: usize,
}

/// Why a seam could be sewn wrongly. Seams by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Conflict {
    /// Its notches are the same from both ends.
    Reverse {
        /// The seam.
        number: usize,
    },
    /// Its notches are those of another seam of similar length on one of its pieces.
    Same {
        /// The seam,
        number: usize,
        /// and the other.
        other: usize,
    },
}

/// Seams whose lengths differ by less than this share are of similar length.
const SIMILAR: f64 = 0.05;

/// What of a seam its notches are judged by.
#[derive(Clone, Copy)]
pub(super) struct Reading<'a> {
    pub length_mm: f64,
    pub groups: &'a [Group],
}

impl Reading<'_> {
    /// Whether a person could take the groups for those of another seam, or for their own reverse: as many, with the same counts, all
    /// at places that differ by less than a group is wide or a twelfth of the seam.
    pub fn resembles(&self, other: &Reading<'_>, backwards: bool, pair_mm: f64) -> bool {
        let (n, long) = (self.groups.len(), self.length_mm.max(other.length_mm));
        let apart = pair_mm.max(long / 12.0);
        n == other.groups.len()
            && (0..n).all(|i| {
                let g = self.groups[i];
                let h = other.groups[if backwards { n - 1 - i } else { i }];
                let at = if backwards { other.length_mm - h.arc_mm } else { h.arc_mm };
                g.count == h.count && (g.arc_mm - at).abs() < apart
            })
    }
}

impl SeamNotches {
    /// Distances from the start mark of a closed seam; as they are for others.
    pub(super) fn reading(&self) -> Vec<Group> {
        let Some(start) = self.groups.iter().find(|_| self.is_closed) else {
            return self.groups.clone();
        };
        // The start mark comes first and stands for both ends.
        let from = |g: &Group| Group {
            arc_mm: (g.arc_mm - start.arc_mm).rem_euclid(self.length_mm),
            count: g.count,
        };
        self.groups[1..].iter().map(from).collect()
    }
}

pub(super) fn is_similar(a: f64, b: f64) -> bool {
    (a - b).abs() <= SIMILAR * a.max(b)
}

/// For each seam number up to the largest: length, whether closed, pieces that it lies on.
pub(super) fn seams(pattern: &Pattern) -> Vec<(usize, f64, bool, Vec<usize>)> {
    let largest = pattern.pieces.iter().flat_map(|p| &p.seams).map(|s| s.number).max().unwrap_or(0);
    let mut seams = vec![(0, 0.0, false, Vec::new()); largest + 1];
    for (p, piece) in pattern.pieces.iter().enumerate() {
        for seam in &piece.seams {
            let entry = &mut seams[seam.number];
            (entry.0, entry.1, entry.2) = (seam.number, seam.surface_length_mm, seam.is_closed);
            let is_own = matches!(seam.partner, Partner::Own { .. });
            if !is_own || !entry.3.contains(&p) {
                entry.3.push(p);
            }
        }
    }
    seams.retain(|seam| !seam.3.is_empty());
    seams
}

/// All ways in which seams of a pattern that have notches could be confused by them: each with its own reverse, and each pair of
/// similar length on a common piece, in both directions. **Costs** O(s² n) for s seams of n groups.
pub fn conflicts(pattern: &Pattern, plan: &NotchPlan) -> Vec<Conflict> {
    let seams = seams(pattern);
    let pieces = |number: usize| seams.iter().find(|s| s.0 == number).map(|s| &s.3);
    let readings: Vec<(&SeamNotches, Vec<Group>)> =
        plan.seams.iter().filter(|s| !s.groups.is_empty()).map(|s| (s, s.reading())).collect();
    let mut conflicts = Vec::new();
    for (i, (seam, groups)) in readings.iter().enumerate() {
        let reading = Reading { length_mm: seam.length_mm, groups };
        if reading.resembles(&reading, true, plan.pair_mm) {
            conflicts.push(Conflict::Reverse { number: seam.number });
        }
        for (other, others) in &readings[i + 1..] {
            let (Some(p), Some(q)) = (pieces(seam.number), pieces(other.number)) else { continue };
            if !is_similar(seam.length_mm, other.length_mm)
                || seam.is_closed != other.is_closed
                || !p.iter().any(|piece| q.contains(piece))
            {
                continue;
            }
            let with = Reading { length_mm: other.length_mm, groups: others };
            if [false, true].iter().any(|&back| reading.resembles(&with, back, plan.pair_mm)) {
                conflicts.push(Conflict::Same { number: seam.number, other: other.number });
            }
        }
    }
    conflicts
}

/// Whether there are no [`conflicts`].
pub fn is_unambiguous(pattern: &Pattern, plan: &NotchPlan) -> bool {
    conflicts(pattern, plan).is_empty()
}
