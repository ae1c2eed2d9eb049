//! Curves as crossings of edges, with junctions between them.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::Vector2;

use super::flat::{Flat, Place, meet};
use crate::mesh::{EdgeId, FaceId, VertexId};

/// How a node of a curve that must stay near its place is held.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    /// Where the curve crossed the edge at first.
    pub origin: f64,
    /// Where the node is pulled to.
    pub target: f64,
    /// How strongly, per length of edge squared.
    pub stiffness: f64,
    /// How far it may go, in lengths.
    pub reach: f64,
}

/// A point of the network.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub place: Place,
    /// The segments that end here. A crossing has two, one on either side of its edge, or one where a curve ends.
    pub arms: Vec<u32>,
    pub is_fixed: bool,
    pub anchor: Option<Anchor>,
    /// How often it changed its face.
    pub hops: u32,
    pub is_alive: bool,
}

/// A straight piece inside a face.
#[derive(Clone, Debug)]
pub(super) struct Segment {
    pub ends: [u32; 2],
    pub face: FaceId,
    pub is_free: bool,
    pub is_alive: bool,
}

/// All curves on a surface.
pub(super) struct Network<'a> {
    pub flat: Flat<'a>,
    pub nodes: Vec<Node>,
    pub segments: Vec<Segment>,
    /// The crossings of every edge, from its tail on.
    pub edge_nodes: Vec<Vec<u32>>,
    pub face_segments: Vec<Vec<u32>>,
    /// Vertices that a curve passes through or ends at.
    pub is_occupied: Vec<bool>,
    /// Mesh edges that the cut runs along and stays at, and whether they are free.
    pub walls: Vec<(EdgeId, bool)>,
    pub is_wall: Vec<bool>,
}

impl<'a> Network<'a> {
    /// No curves.
    pub fn empty(flat: Flat<'a>) -> Self {
        let mesh = flat.mesh;
        Self {
            flat,
            nodes: Vec::new(),
            segments: Vec::new(),
            edge_nodes: vec![Vec::new(); mesh.edge_count()],
            face_segments: vec![Vec::new(); mesh.face_count()],
            is_occupied: vec![false; mesh.vertex_count()],
            walls: Vec::new(),
            is_wall: vec![false; mesh.edge_count()],
        }
    }

    pub fn add_node(&mut self, place: Place) -> u32 {
        let node = self.nodes.len() as u32;
        self.nodes.push(Node {
            place,
            arms: Vec::new(),
            is_fixed: false,
            anchor: None,
            hops: 0,
            is_alive: true,
        });
        if let Place::Edge(e, t) = place {
            let list = &self.edge_nodes[e.index()];
            let before =
                |&n: &u32| matches!(self.nodes[n as usize].place, Place::Edge(_, s) if s < t);
            let index = list.partition_point(before);
            self.edge_nodes[e.index()].insert(index, node);
        }
        node
    }

    pub fn add_segment(&mut self, ends: [u32; 2], face: FaceId, is_free: bool) {
        let segment = self.segments.len() as u32;
        self.segments.push(Segment { ends, face, is_free, is_alive: true });
        self.face_segments[face.index()].push(segment);
        for end in ends {
            self.nodes[end as usize].arms.push(segment);
        }
    }

    pub fn remove_segment(&mut self, segment: u32) {
        let Segment { ends, face, .. } = self.segments[segment as usize].clone();
        self.segments[segment as usize].is_alive = false;
        self.face_segments[face.index()].retain(|&s| s != segment);
        for end in ends {
            self.nodes[end as usize].arms.retain(|&s| s != segment);
        }
    }

    /// Removes a node and its segments.
    pub fn remove_node(&mut self, node: u32) {
        for segment in self.nodes[node as usize].arms.clone() {
            self.remove_segment(segment);
        }
        if let Place::Edge(e, _) = self.nodes[node as usize].place {
            self.edge_nodes[e.index()].retain(|&n| n != node);
        }
        self.nodes[node as usize].is_alive = false;
    }

    pub fn place(&self, node: u32) -> Place {
        self.nodes[node as usize].place
    }

    pub fn set_t(&mut self, node: u32, value: f64) {
        if let Place::Edge(_, t) = &mut self.nodes[node as usize].place {
            *t = value;
        }
    }

    pub fn other_end(&self, segment: u32, node: u32) -> u32 {
        let [a, b] = self.segments[segment as usize].ends;
        if a == node { b } else { a }
    }

    /// The arm of a crossing other than the one given.
    pub fn other_arm(&self, node: u32, segment: u32) -> Option<u32> {
        match self.nodes[node as usize].arms[..] {
            [a, b] if a == segment => Some(b),
            [a, b] if b == segment => Some(a),
            _ => None,
        }
    }

    /// The places of a segment's ends in its face's frame.
    pub fn ends(&self, segment: u32) -> [Vector2<f64>; 2] {
        let Segment { ends, face, .. } = &self.segments[segment as usize];
        ends.map(|n| self.flat.at(*face, self.place(n)))
    }

    pub fn segment_length(&self, segment: u32) -> f64 {
        let [a, b] = self.ends(segment);
        (b - a).norm()
    }

    /// The neighbours of a crossing on its edge, 0 and 1 where there is none.
    pub fn gap_around(&self, node: u32) -> [f64; 2] {
        let Place::Edge(e, _) = self.place(node) else { return [0.0, 1.0] };
        let list = &self.edge_nodes[e.index()];
        let i = list.iter().position(|&n| n == node).unwrap_or(0);
        let t = |n: Option<&u32>| match n.map(|&n| self.place(n)) {
            Some(Place::Edge(_, t)) => Some(t),
            _ => None,
        };
        let before = i.checked_sub(1).and_then(|i| t(list.get(i))).unwrap_or(0.0);
        [before, t(list.get(i + 1)).unwrap_or(1.0)]
    }

    /// How near to a vertex an edge is crossed first, as a fraction of the edge, and by which node.
    pub fn nearest(&self, e: EdgeId, v: VertexId) -> (f64, Option<u32>) {
        let list = &self.edge_nodes[e.index()];
        let at_tail = self.flat.mesh.edge_vertices(e)[0] == v;
        let node = if at_tail { list.first() } else { list.last() }.copied();
        match node.map(|n| self.place(n)) {
            Some(Place::Edge(_, t)) => (if at_tail { t } else { 1.0 - t }, node),
            _ => (1.0, None),
        }
    }

    /// Whether a face holds anything but segments from side to side, which cannot cross while their order is kept.
    pub fn is_busy(&self, f: FaceId) -> bool {
        self.face_segments[f.index()].iter().any(|&s| {
            let ends = self.segments[s as usize].ends;
            ends.iter().any(|&n| !matches!(self.place(n), Place::Edge(..)))
        })
    }

    /// Whether segments of a face could be replaced by others without crossing any. Ends are nodes or places to come.
    pub fn admits(&self, f: FaceId, removed: &[u32], added: &[[End; 2]]) -> bool {
        let at = |end: End| match end {
            End::Node(n) => self.flat.at(f, self.place(n)),
            End::New(_, place) => self.flat.at(f, place),
        };
        let is_same = |a: End, b: End| match (a, b) {
            (End::Node(a), End::Node(b)) => a == b,
            (End::New(a, _), End::New(b, _)) => a == b,
            _ => false,
        };
        let mut others: Vec<[End; 2]> = self.face_segments[f.index()]
            .iter()
            .filter(|s| !removed.contains(s))
            .map(|&s| self.segments[s as usize].ends.map(End::Node))
            .collect();
        for &new in added {
            let crosses = others.iter().any(|&old| {
                let shares = new.iter().any(|&a| old.iter().any(|&b| is_same(a, b)));
                !shares && meet(new.map(at), old.map(at))
            });
            if crosses {
                return false;
            }
            others.push(new);
        }
        true
    }

    /// Whether the segments at a node cross no others.
    pub fn is_clean_at(&self, node: u32) -> bool {
        self.nodes[node as usize].arms.iter().all(|&s| {
            let Segment { ends, face, .. } = self.segments[s as usize];
            !self.is_busy(face) || self.admits(face, &[s], &[ends.map(End::Node)])
        })
    }

    /// Sum of the lengths of all segments that are free, or of the others.
    pub fn length(&self, is_free: bool) -> f64 {
        let counts = |s: &usize| self.segments[*s].is_alive && self.segments[*s].is_free == is_free;
        (0..self.segments.len()).filter(counts).map(|s| self.segment_length(s as u32)).sum()
    }
}

/// An end of a segment that may not be there yet; new ones are told apart by number.
#[derive(Clone, Copy, Debug)]
pub(super) enum End {
    Node(u32),
    New(u32, Place),
}
