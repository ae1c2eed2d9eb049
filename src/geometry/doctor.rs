//! stub
use super::polygon;
use crate::mesh::{Mesh, Soup};
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    Blocks,
    Warning,
    Note,
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FindingKind {
    RepeatedVertices,
    DegenerateFaces,
    DuplicateFaces,
    NonManifoldEdges,
    NonManifoldVertices,
    Orientation,
    InsideOut,
    NotOrientable,
    Isolated,
    Components,
    BoundaryLoops,
    Slivers,
    FarFromOrigin,
    Coincident,
}
impl FindingKind {
    pub fn id(self) -> &'static str {
        "stub"
    }
}
#[derive(Clone, Debug)]
pub struct Finding {
    pub kind: FindingKind,
    pub severity: Severity,
    pub count: usize,
    pub vertices: Vec<u32>,
    pub edges: Vec<[u32; 2]>,
    pub faces: Vec<u32>,
}
impl Finding {
    pub fn repairs(&self) -> Vec<Repair> {
        Vec::new()
    }
}
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Repair {
    Orient,
}
#[derive(Clone, Debug)]
pub struct Diagnosis {
    pub findings: Vec<Finding>,
    pub components: usize,
    pub boundary_loops: usize,
    pub euler: i64,
    pub genus: Option<usize>,
    pub area: f64,
    ok: bool,
}
impl Diagnosis {
    pub fn is_solvable(&self) -> bool {
        self.ok
    }
    pub fn is_inside_out(&self) -> bool {
        false
    }
    pub fn isolated_vertices(&self) -> usize {
        0
    }
    pub fn recommended(&self) -> Vec<Repair> {
        Vec::new()
    }
}
pub fn diagnose(soup: &Soup) -> Diagnosis {
    let mut t = Vec::new();
    for i in 0..soup.polygon_count() {
        polygon::triangulate(&soup.positions, soup.polygon(i), &mut t);
    }
    match Mesh::new(soup.positions.len(), &t) {
        Ok(m) => {
            let x = m.topology();
            Diagnosis {
                findings: vec![],
                components: x.components,
                boundary_loops: x.boundary_loops,
                euler: x.euler,
                genus: Some(x.genus),
                area: 0.0,
                ok: true,
            }
        }
        Err(_) => Diagnosis {
            findings: vec![],
            components: 0,
            boundary_loops: 0,
            euler: 0,
            genus: None,
            area: 0.0,
            ok: false,
        },
    }
}
