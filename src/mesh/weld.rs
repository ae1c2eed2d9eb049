//! Welding: corners at the very same place become one vertex.
//!
//! Guaranteed: places are numbered in order of first appearance, whatever the machine; −0 and 0 are the same coordinate;
//! the expected cost is linear, and no choice of coordinates makes it worse than n log n.
//!
//! Not guaranteed: that corners which nearly coincide are joined. A tolerance is a question of geometry, not of bytes.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use std::collections::BTreeMap;

/// A free slot of the table. Also one more than the largest number of a vertex.
const FREE: u32 = u32::MAX;
/// Slots looked at per corner, on average, before the table is given up. A quarter-full to half-full table needs one or
/// two; a smaller limit would leave it for ordinary meshes, a larger one only lets crafted coordinates waste time.
const PROBES: u64 = 24;

/// Makes one vertex of all corners with equal coordinates, one by one: places in order of first appearance.
///
/// **Costs** expected linear time; a table of at most 16 bytes per place beside the result. It is an open hash table over the bits of the coordinates, grown as places are found. Coordinates crafted so that all of
/// them want the same slot are noticed by the number of slots looked at; the table then gives way to a search tree.
#[derive(Debug, Default)]
pub struct Welder {
    places: Vec<[f64; 3]>,
    slots: Vec<u32>,
    added: u64,
    probes: u64,
    tree: Option<BTreeMap<[u64; 3], u32>>,
}

impl Welder {
    /// The number of the vertex at `position`, a new one where there is none.
    ///
    /// **Takes** fewer than 2³² − 1 different places.
    pub fn add(&mut self, position: [f64; 3]) -> u32 {
        // Adding 0 makes 0 of −0 and changes nothing else.
        let position = position.map(|c| c + 0.0);
        let key = position.map(f64::to_bits);
        if let Some(tree) = &mut self.tree {
            let next = self.places.len() as u32;
            let vertex = *tree.entry(key).or_insert(next);
            if vertex == next {
                self.places.push(position);
            }
            return vertex;
        }
        if self.slots.len() < 2 * (self.places.len() + 1) {
            self.grow();
        }
        self.added += 1;
        let mask = self.slots.len() - 1;
        let mut slot = hash(key) as usize & mask;
        let vertex = loop {
            self.probes += 1;
            let vertex = self.slots[slot];
            if vertex == FREE {
                let vertex = self.places.len() as u32;
                self.slots[slot] = vertex;
                self.places.push(position);
                break vertex;
            }
            if self.places[vertex as usize].map(f64::to_bits) == key {
                break vertex;
            }
            slot = (slot + 1) & mask;
        };
        if self.probes > PROBES * (self.added + 64) {
            let numbered = self.places.iter().zip(0..);
            self.tree = Some(numbered.map(|(p, i)| (p.map(f64::to_bits), i)).collect());
            self.slots = Vec::new();
        }
        vertex
    }

    /// The places, by number.
    pub fn into_places(self) -> Vec<[f64; 3]> {
        self.places
    }

    fn grow(&mut self) {
        let size = (2 * self.slots.len()).max(256);
        self.slots.clear();
        self.slots.resize(size, FREE);
        let mask = size - 1;
        for (position, vertex) in self.places.iter().zip(0..) {
            let mut slot = hash(position.map(f64::to_bits)) as usize & mask;
            while self.slots[slot] != FREE {
                self.probes += 1;
                slot = (slot + 1) & mask;
            }
            self.slots[slot] = vertex;
        }
    }
}

/// Mixes all bits of the coordinates into the lower bits of the result: coordinates on a grid differ in a few upper bits
/// of the mantissa only.
fn hash(key: [u64; 3]) -> u64 {
    let hash = key.into_iter().fold(0x9e37_79b9_7f4a_7c15, mix);
    hash ^ (hash >> 32)
}

fn mix(hash: u64, bits: u64) -> u64 {
    let product = u128::from(hash ^ bits) * 0xd6e8_feb8_6659_fd93;
    (product >> 64) as u64 ^ (product as u64).rotate_left(23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_that_all_want_one_slot_are_welded_in_good_time() {
        // The second coordinate undoes what the first one did to the hash.
        let corner = |x: f64| {
            let y = f64::from_bits(mix(0x9e37_79b9_7f4a_7c15, x.to_bits()));
            [x, y, 1.0]
        };
        // Without the tree 10¹⁰ slots would be looked at.
        let corners: Vec<_> = (0..200_000).map(|i| corner(f64::from(i))).collect();
        let corners: Vec<_> = corners.into_iter().filter(|c| c[1].is_finite()).collect();
        let hashes: Vec<_> = corners.iter().map(|c| hash(c.map(f64::to_bits))).collect();
        assert!(corners.len() > 100_000 && hashes.iter().all(|h| *h == hashes[0]));
        let twice: Vec<_> = corners.iter().chain(&corners).copied().collect();
        let mut welder = Welder::default();
        let numbers: Vec<_> = twice.iter().map(|&corner| welder.add(corner)).collect();
        assert_eq!(welder.into_places(), corners);
        assert!(numbers.iter().zip((0..).take(corners.len()).cycle()).all(|(a, b)| *a == b));
    }
}
