//! Pieces of charts, cut between their sheets.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::super::validity::FacePair;
use crate::geometry::Geometry;
use crate::mesh::{EdgeId, FaceId, OpenedMesh};
use crate::methods::maxflow::Network;

const NONE: u32 = u32::MAX;

/// A face belongs to one of two that overlap if it is nearer to it than this times its distance to the other. With 1 the cut would be
/// given; with less than a half it comes near the two faces, where it is short but parts little.
const NEARER: f64 = 0.6;

/// Steps of capacity on the dearest edge: sums over all edges of a mesh stay far below 2⁶⁴.
const STEPS: f64 = (1u64 << 30) as f64;

pub(super) struct Pieces<'a> {
    opened: &'a OpenedMesh,
    geometry: &'a Geometry,
    /// What a cut along each edge costs.
    prices: Vec<f64>,
    is_cut: Vec<bool>,
    /// For each face its number within the piece that is worked on.
    local: Vec<u32>,
}

impl<'a> Pieces<'a> {
    pub fn new(opened: &'a OpenedMesh, geometry: &'a Geometry, prices: Vec<f64>) -> Self {
        let is_cut = vec![false; opened.mesh.edge_count()];
        let local = vec![NONE; opened.mesh.face_count()];
        Self { opened, geometry, prices, is_cut, local }
    }

    /// The edges that were cut, in increasing order.
    pub fn cuts(&self) -> impl Iterator<Item = EdgeId> + '_ {
        self.opened.mesh.edges().filter(|e| self.is_cut[e.index()])
    }

    /// Cuts between the faces of a chart that have a property and those that have not.
    pub fn part_by(&mut self, faces: &[FaceId], has: impl Fn(FaceId) -> bool) {
        for &f in faces {
            for (e, g) in self.neighbours(f).into_iter().flatten() {
                self.is_cut[e.index()] |= has(f) != has(g);
            }
        }
    }

    /// Cuts a chart until no pair overlaps within a piece, as long as more charts are allowed. **Gives** the pairs that are left.
    pub fn split(
        &mut self,
        faces: &[FaceId],
        pairs: Vec<FacePair>,
        room: &mut usize,
    ) -> Vec<FacePair> {
        let mut left = Vec::new();
        let mut open = self.parts(faces, &pairs);
        while let Some((faces, pairs)) = open.pop() {
            if *room == 0 {
                left.extend(pairs);
                continue;
            }
            let (sources, sinks) = self.sheets(&faces, &pairs);
            self.cut(&faces, &sources, &sinks);
            let parts = self.parts(&faces, &pairs);
            *room = room.saturating_sub(1);
            open.extend(parts);
        }
        left
    }

    /// The faces across the sides of a face that are neither rim nor cut.
    fn neighbours(&self, f: FaceId) -> [Option<(EdgeId, FaceId)>; 3] {
        let mesh = &self.opened.mesh;
        mesh.face_halfedges(f).map(|h| {
            let is_open = !self.is_cut[h.edge().index()];
            mesh.face(h.twin()).filter(|_| is_open).map(|g| (h.edge(), g))
        })
    }

    /// Connected parts of some faces, with the pairs that each of them has; parts without pairs are done.
    fn parts(&mut self, faces: &[FaceId], pairs: &[FacePair]) -> Vec<(Vec<FaceId>, Vec<FacePair>)> {
        let (count, number) = self.components(faces, |_| true);
        let mut parts = vec![(Vec::new(), Vec::new()); count];
        for (f, &part) in faces.iter().zip(&number) {
            parts[part as usize].0.push(*f);
            self.local[f.index()] = part;
        }
        for pair in pairs {
            let [p, q] = pair.faces.map(|f| self.local[f.index()]);
            if p == q {
                parts[p as usize].1.push(*pair);
            }
        }
        parts.retain(|(_, pairs): &(_, Vec<FacePair>)| !pairs.is_empty());
        parts
    }

    /// Numbers the components of the faces of a piece that are wanted, by first face; NONE for the others.
    fn components(
        &mut self,
        faces: &[FaceId],
        is_wanted: impl Fn(FaceId) -> bool,
    ) -> (usize, Vec<u32>) {
        self.name(faces);
        let mut number = vec![NONE; faces.len()];
        let mut count = 0;
        for (i, &start) in faces.iter().enumerate() {
            if number[i] != NONE || !is_wanted(start) {
                continue;
            }
            number[i] = count;
            let mut stack = vec![start];
            while let Some(f) = stack.pop() {
                for (_, g) in self.neighbours(f).into_iter().flatten() {
                    let slot = &mut number[self.local[g.index()] as usize];
                    if *slot == NONE && is_wanted(g) {
                        *slot = count;
                        stack.push(g);
                    }
                }
            }
            count += 1;
        }
        (count as usize, number)
    }

    /// Numbers the faces of a piece.
    fn name(&mut self, faces: &[FaceId]) {
        for (i, f) in faces.iter().enumerate() {
            self.local[f.index()] = super::super::small(i);
        }
    }

    /// Two sets of faces that are to be separated.
    fn sheets(&mut self, faces: &[FaceId], pairs: &[FacePair]) -> (Vec<FaceId>, Vec<FaceId>) {
        let mut is_double = vec![false; self.local.len()];
        for f in pairs.iter().flat_map(|pair| pair.faces) {
            is_double[f.index()] = true;
        }
        let (_, sheets) = self.components(faces, |f| is_double[f.index()]);
        let sheet = |f: FaceId| sheets[self.local[f.index()] as usize];
        let mut common: BTreeMap<[u32; 2], f64> = BTreeMap::new();
        for pair in pairs {
            let [p, q] = pair.faces.map(sheet);
            *common.entry([p.min(q), p.max(q)]).or_default() += pair.area;
        }
        let first_largest = |a: &f64, b: &f64| a.total_cmp(b).is_gt();
        let mut best = (&[0, 0], &f64::NEG_INFINITY);
        for candidate in &common {
            if first_largest(candidate.1, best.1) {
                best = candidate;
            }
        }
        let [p, q] = *best.0;
        let of = |s: u32| faces.iter().copied().filter(|&f| sheet(f) == s).collect::<Vec<_>>();
        if p != q {
            return (of(p), of(q));
        }
        let within = pairs.iter().filter(|pair| pair.faces.map(sheet) == [p, p]);
        let Some(worst) = within.reduce(|a, b| if first_largest(&b.area, &a.area) { b } else { a })
        else {
            return (Vec::new(), Vec::new());
        };
        let sheet_faces = of(p);
        let [near, far] = worst.faces.map(|f| self.distances(&sheet_faces, f));
        let cell = |near: &[f64], far: &[f64]| {
            let is_nearer = |i: &usize| near[*i] < NEARER * far[*i];
            (0..sheet_faces.len()).filter(is_nearer).map(|i| sheet_faces[i]).collect()
        };
        (cell(&near, &far), cell(&far, &near))
    }

    /// Distances between the centres of faces along the dual graph of a connected set of them.
    fn distances(&mut self, faces: &[FaceId], from: FaceId) -> Vec<f64> {
        let names: Vec<u32> = faces.iter().map(|f| self.local[f.index()]).collect();
        let mut is_there = vec![false; self.local.len()];
        for f in faces {
            is_there[f.index()] = true;
        }
        self.name(faces);
        let centre = |f: FaceId| {
            let corners = self.opened.mesh.face_vertices(f);
            corners.iter().fold(nalgebra::Vector3::zeros(), |sum, v| {
                sum + self.geometry.positions[v.index()].coords / 3.0
            })
        };
        let mut distances = vec![f64::INFINITY; faces.len()];
        distances[self.local[from.index()] as usize] = 0.0;
        let mut heap = BinaryHeap::from([Reverse((0u64, from))]);
        while let Some(Reverse((bits, f))) = heap.pop() {
            let distance = f64::from_bits(bits);
            if distance > distances[self.local[f.index()] as usize] {
                continue;
            }
            for (_, g) in
                self.neighbours(f).into_iter().flatten().filter(|(_, g)| is_there[g.index()])
            {
                let candidate = distance + (centre(g) - centre(f)).norm();
                let slot = &mut distances[self.local[g.index()] as usize];
                if candidate < *slot {
                    *slot = candidate;
                    heap.push(Reverse((candidate.to_bits(), g)));
                }
            }
        }
        for (f, name) in faces.iter().zip(names) {
            self.local[f.index()] = name;
        }
        distances
    }

    /// Marks the cheapest cut of a piece between two sets of its faces.
    fn cut(&mut self, faces: &[FaceId], sources: &[FaceId], sinks: &[FaceId]) {
        self.name(faces);
        let mut dearest = 0.0f64;
        for &f in faces {
            for (e, _) in self.neighbours(f).into_iter().flatten() {
                dearest = dearest.max(self.prices[e.index()]);
            }
        }
        let mut network = Network::new(faces.len());
        for (i, &f) in faces.iter().enumerate() {
            for (e, g) in self.neighbours(f).into_iter().flatten() {
                let j = self.local[g.index()];
                if (i as u64) < u64::from(j) {
                    let capacity = whole(self.prices[e.index()] / dearest * STEPS) + 1;
                    network.join(super::super::small(i), j, capacity);
                }
            }
        }
        let names = |set: &[FaceId]| set.iter().map(|f| self.local[f.index()]).collect::<Vec<_>>();
        let side = network.cut(&names(sources), &names(sinks));
        let mut cuts = Vec::new();
        for (i, &f) in faces.iter().enumerate() {
            for (e, g) in self.neighbours(f).into_iter().flatten() {
                if side[i] && !side[self.local[g.index()] as usize] {
                    cuts.push(e);
                }
            }
        }
        for e in cuts {
            self.is_cut[e.index()] = true;
        }
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
fn whole(x: f64) -> u64 {
    x as u64
}
