//! Which places of the cut are closest to a vertex, while its band is built.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use super::cut::NONE;
use crate::mesh::VertexId;

/// The closest place of a label's boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Nearest {
    pub segment: u32,
    /// Position along the segment.
    pub fraction: f64,
    pub distance: f64,
}

/// A vertex and a number as one number that sorts like both.
pub(super) fn joined(v: VertexId, number: u32) -> u64 {
    u64::from(v.0) << 32 | u64::from(number)
}

/// For each vertex the closest places found so far of the boundaries of some labels, as lists in one piece of memory.
pub(super) struct Candidates {
    /// The first entry of each vertex, or [`NONE`].
    first: Vec<u32>,
    /// Label, place, and the next entry of the same vertex.
    entries: Vec<(u32, Nearest, u32)>,
}

impl Candidates {
    pub fn new(vertex_count: usize) -> Self {
        Self { first: vec![NONE; vertex_count], entries: Vec::new() }
    }

    /// Number of all that were found, over all vertices and labels.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    pub fn is_empty(&self, v: VertexId) -> bool {
        self.first[v.index()] == NONE
    }

    pub fn for_each(&self, v: VertexId, mut call: impl FnMut(u32, &Nearest)) {
        let mut at = self.first[v.index()];
        while at != NONE {
            let (label, nearest, next) = &self.entries[at as usize];
            call(*label, nearest);
            at = *next;
        }
    }

    /// Whether a segment is what is known to be closest of the boundaries of both these labels.
    pub fn has(&self, v: VertexId, labels: [u32; 2], segment: u32) -> bool {
        let mut found = [false; 2];
        self.for_each(v, |label, nearest| {
            for k in 0..2 {
                found[k] |= label == labels[k] && nearest.segment == segment;
            }
        });
        found == [true; 2]
    }

    /// Takes a place on the boundary between two labels where it is closer than what is known.
    pub fn offer(&mut self, v: VertexId, labels: [u32; 2], nearest: Nearest) {
        'labels: for label in labels {
            let mut at = self.first[v.index()];
            while at != NONE {
                let (known, old, next) = &mut self.entries[at as usize];
                if *known == label {
                    if nearest.distance < old.distance {
                        *old = nearest;
                    }
                    continue 'labels;
                }
                at = *next;
            }
            let new = self.entries.len() as u32;
            self.entries.push((label, nearest, self.first[v.index()]));
            self.first[v.index()] = new;
        }
    }
}
