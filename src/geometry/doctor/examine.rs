//! The examination: everything that is found, at once.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use super::clean::Clean;
use super::makes_a_mesh;
use super::orient::closed_patches;
use super::parts::SMALL;
use super::polygons::folded;
use super::surface::{doubled_normal, faces_inward, is_flat};
use super::weld;
use crate::mesh::Soup;
use crate::mesh::doctor::{Finding, FindingKind, Repair, Severity, Shape};

/// How near to each other boundary vertices must lie to be offered for welding, in parts of the diagonal of the box: files
/// in single precision write the same place twice with this difference.
const NEAR: f64 = 1e-6;
/// The part of all edges that a weld must close for the soup to count as fallen apart.
const SHATTERED: f64 = 0.1;
/// Triangles with a smaller angle are slivers: 1°.
const SMALL_ANGLE: f64 = std::f64::consts::PI / 180.0;
/// Triangles with a longest side more times their height are slivers.
const ASPECT: f64 = 100.0;
/// Longest to shortest edge above which it is worth a note: cells this different in one linear system cost it digits.
const HUGE_RATIO: f64 = 1e5;
/// Distance from the origin over size above which single precision would lose more than half of its digits.
const FAR: f64 = 1e4;

/// Components that are offered to be kept alone, the largest first: a list of more is no help.
const OFFERED: usize = 8;
/// Edges of a hole that is small: one that a scanner missed, not one that was meant.
const SMALL_HOLE: u32 = 30;

/// One component, numbered by its first polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Its first polygon.
    pub first_face: u32,
    /// Number of polygons.
    pub faces: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of boundary loops.
    pub boundary_loops: usize,
    /// Vertices − edges + polygons.
    pub euler: i64,
    /// Genus with holes capped; `None` where it is not manifold or not orientable.
    pub genus: Option<usize>,
    /// Whether neighbours could be made to agree.
    pub is_orientable: bool,
    /// Whether every edge has exactly two sides.
    pub is_closed: bool,
    /// In square model units.
    pub area: f64,
    /// Part of the whole area.
    pub area_share: f64,
    /// In cubic model units, negative for one that faces inward; `None` unless it is closed and its neighbours agree.
    pub volume: Option<f64>,
}

/// A boundary loop of the surface with its bow-ties split.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryLoop {
    /// In order, each once.
    pub vertices: Vec<u32>,
    /// In model units.
    pub length: f64,
    /// Number of edges.
    pub edges: usize,
    /// `false` where it ends at an edge with three or more sides.
    pub is_closed: bool,
    /// The component that it bounds.
    pub component: u32,
}

/// What an examination finds. Counts, components and loops are those of the surface without duplicates, repetitions, and
/// polygons without area that nothing hangs on.
#[derive(Clone, Debug, PartialEq)]
pub struct Examination {
    /// Blocking ones first, then by kind.
    pub findings: Vec<Finding>,
    /// Number of vertices in use.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of polygons.
    pub faces: usize,
    /// For each polygon of the soup its component; `u32::MAX` for those left out.
    pub face_components: Vec<u32>,
    /// The components, by first polygon.
    pub components: Vec<Component>,
    /// The boundary loops.
    pub boundary_loops: Vec<BoundaryLoop>,
    /// Vertices − edges + polygons.
    pub euler: i64,
    /// Sum over the components with holes capped; `None` where the surface is not manifold or not orientable.
    pub genus: Option<usize>,
    /// Whether every edge has at most two sides and every vertex one fan.
    pub is_manifold: bool,
    /// Whether neighbours could be made to agree everywhere.
    pub is_orientable: bool,
    /// In square model units.
    pub area: f64,
    /// Whether nothing blocks: [`crate::mesh::Mesh::new`] accepts the triangles of the polygons, and not all are without
    /// area.
    pub is_solvable: bool,
}

impl Examination {
    /// The finding of a kind, if there is one.
    pub fn find(&self, kind: FindingKind) -> Option<&Finding> {
        self.findings.iter().find(|finding| finding.kind == kind)
    }

    /// The repairs that make the mesh solvable, in the order of the findings.
    pub fn recommended(&self) -> Vec<Repair> {
        let mut repairs = Vec::new();
        for finding in self.findings.iter().filter(|finding| finding.recommended) {
            let first = finding.repairs.first().copied();
            repairs.extend(first.filter(|first| !repairs.contains(first)));
        }
        repairs
    }
}

/// Looks for everything that may be wrong. **Costs** O(n log n) but for large polygons, which cost their triangulation.
pub fn examine(soup: &Soup) -> Examination {
    let clean = Clean::new(soup);
    let shape = Shape::new(&clean.soup, &clean.sides);
    let mut findings = Vec::new();
    topology(&clean, &shape, &mut findings);
    faces(soup, &clean, &mut findings);
    placement(soup, &clean, &shape, &mut findings);
    let components = components(&clean, &shape);
    let is_small = |component: &Component| component.area_share < SMALL;
    if components.len() > 1 {
        let mut finding = Finding::new(FindingKind::Components, Severity::Note, components.len());
        finding.faces = components.iter().map(|component| component.first_face).collect();
        finding.repairs.push(Repair::KeepLargest);
        finding
            .repairs
            .extend(components.iter().any(is_small).then_some(Repair::DropSmallComponents));
        let mut largest: Vec<usize> = (0..components.len()).collect();
        largest.sort_by(|&a, &b| components[b].area.total_cmp(&components[a].area).then(a.cmp(&b)));
        let one = |&c: &usize| Repair::KeepComponent { component: c as u32 };
        finding.repairs.extend(largest.iter().take(OFFERED).map(one));
        findings.push(finding);
    }
    let extent = clean.surface.extent;
    let faces_inward =
        |c: &Component, v: f64| faces_inward(v / extent.powi(3), c.area / extent.powi(2));
    let inward = components.iter().filter(|c| c.volume.is_some_and(|v| faces_inward(c, v)));
    let inward = Vec::from_iter(inward.map(|component| component.first_face));
    if !inward.is_empty() {
        let mut finding = Finding::new(FindingKind::InsideOut, Severity::Note, inward.len());
        finding.faces = inward;
        finding.repairs.extend([Repair::Orient, Repair::TurnInsideOut]);
        findings.push(finding);
    }
    findings.sort_by_key(|finding| (finding.severity, finding.kind));

    let mut face_components = vec![u32::MAX; soup.polygon_count()];
    for (&origin, &component) in clean.origins.iter().zip(&shape.face_components) {
        face_components[origin as usize] = component;
    }
    let is_blocked = findings.iter().any(|finding| finding.severity == Severity::Blocks);
    let genus = components.iter().map(|component| component.genus).sum::<Option<usize>>();
    Examination {
        findings,
        vertices: shape.used_vertices,
        edges: clean.sides.edges.len(),
        faces: clean.soup.polygon_count(),
        face_components,
        boundary_loops: boundary_loops(&clean, &shape),
        euler: shape.euler(&clean.sides),
        genus,
        is_manifold: shape.is_manifold(),
        is_orientable: shape.conflicts.is_empty(),
        area: components.iter().map(|component| component.area).sum(),
        is_solvable: !is_blocked,
        components,
    }
}

/// The tolerance of the weld that a soup needs because it has fallen apart.
pub(super) fn recommended_weld(soup: &Soup) -> Option<f64> {
    let clean = Clean::new(soup);
    let (weld, tolerance) = best_weld(&clean);
    is_shattered(&clean, weld.closable).then_some(tolerance)
}

fn is_shattered(clean: &Clean, closable: usize) -> bool {
    closable as f64 > SHATTERED * clean.sides.edges.len() as f64
}

/// The weld that closes the most, of equal places where that does. The other is not looked for where that closes all.
fn best_weld(clean: &Clean) -> (weld::Weld, f64) {
    let plan = |tolerance| weld::plan(&clean.soup, &clean.sides, &clean.surface, tolerance);
    let exact = plan(0.0);
    if exact.closable == exact.boundary {
        return (exact, 0.0);
    }
    let near = plan(NEAR);
    if near.closable > exact.closable { (near, NEAR) } else { (exact, 0.0) }
}

/// Where the polygons are no oriented manifold.
fn topology(clean: &Clean, shape: &Shape, findings: &mut Vec<Finding>) {
    let faces_at = |edges: &[u32]| {
        let sides = edges.iter().flat_map(|&edge| clean.sides.of(edge as usize));
        let mut faces = Vec::from_iter(
            sides.map(|&side| clean.origins[clean.sides.polygons[side as usize] as usize]),
        );
        faces.sort_unstable();
        faces.dedup();
        faces
    };
    let names = |edges: &[u32]| edges.iter().map(|&e| clean.sides.edges[e as usize]).collect();
    let mut add = |kind, count, fill: &dyn Fn(&mut Finding), first| {
        if count > 0 {
            let mut finding = Finding::new(kind, Severity::Blocks, count);
            fill(&mut finding);
            finding.repairs.push(first);
            finding.recommended = true;
            findings.push(finding);
        }
    };
    add(
        FindingKind::RepeatedVertices,
        clean.repeated.len(),
        &|finding| finding.faces.clone_from(&clean.repeated),
        Repair::DropRepeated,
    );
    add(
        FindingKind::DuplicateFaces,
        clean.duplicates.len(),
        &|finding| finding.faces.clone_from(&clean.duplicates),
        Repair::DropDuplicates,
    );
    add(
        FindingKind::NonManifoldEdges,
        shape.crowded.len(),
        &|finding| {
            finding.edges = names(&shape.crowded);
            finding.faces = faces_at(&shape.crowded);
        },
        Repair::SplitEdges,
    );
    add(
        FindingKind::NonManifoldVertices,
        shape.bow_ties.len(),
        &|finding| finding.vertices.clone_from(&shape.bow_ties),
        Repair::SplitVertices,
    );
    let one_sided =
        |&polygon: &usize| !shape.patch_is_orientable[shape.face_patches[polygon] as usize];
    add(
        FindingKind::NotOrientable,
        shape.patch_is_orientable.iter().filter(|&&is| !is).count(),
        &|finding| {
            finding.edges = names(&shape.conflicts);
            let faces = (0..clean.origins.len()).filter(one_sided);
            finding.faces = faces.map(|polygon| clean.origins[polygon]).collect();
        },
        Repair::OpenOneSided,
    );
    add(
        FindingKind::Orientation,
        shape.disagreeing.len(),
        &|finding| {
            finding.edges = names(&shape.disagreeing);
            let turned = (0..clean.origins.len()).filter(|&i| shape.turned[i]);
            finding.faces = turned.map(|polygon| clean.origins[polygon]).collect();
        },
        Repair::Orient,
    );
    let folded = folded(&clean.soup, &clean.sides, &clean.surface);
    add(
        FindingKind::FoldedPolygons,
        folded.len(),
        &|finding| {
            let faces = folded.iter().map(|fault| clean.origins[fault.polygon as usize]);
            finding.faces = faces.collect();
        },
        Repair::SplitPolygons,
    );
    if !shape.loops.is_empty() {
        let mut finding =
            Finding::new(FindingKind::BoundaryLoops, Severity::Note, shape.loops.len());
        finding.edges = names(&shape.boundary);
        let is_small = |edges: usize| edges <= SMALL_HOLE as usize;
        let small = shape.loops.iter().filter(|l| is_small(l.vertices.len())).count();
        if small > 0 && small < shape.loops.len() {
            finding.repairs.push(Repair::FillHoles { max_edges: Some(SMALL_HOLE) });
        }
        finding.repairs.push(Repair::FillHoles { max_edges: None });
        findings.push(finding);
    }
}

/// Polygons of a bad shape, and none at all.
fn faces(soup: &Soup, clean: &Clean, findings: &mut Vec<Finding>) {
    if soup.polygon_count() == 0 {
        findings.push(Finding::new(FindingKind::NoFaces, Severity::Blocks, 1));
        return;
    }
    let all = clean.degenerate.len() + clean.duplicates.len() == soup.polygon_count();
    if all && clean.surface.extent == 0.0 {
        let mut finding = Finding::new(FindingKind::NoExtent, Severity::Blocks, 1);
        finding.faces = (0..soup.polygon_count() as u32).collect();
        findings.push(finding);
        return;
    }
    if !clean.degenerate.is_empty() {
        // They do not harm the methods, but what was left out above may hang on edges that have enough sides.
        let others_block = findings.iter().any(|other| other.severity == Severity::Blocks);
        let blocks = all || clean.hides_degenerate && !others_block && !makes_a_mesh(soup);
        let severity = if blocks { Severity::Blocks } else { Severity::Warning };
        let count = clean.degenerate.len();
        let mut finding = Finding::new(FindingKind::DegenerateFaces, severity, count);
        finding.faces.clone_from(&clean.degenerate);
        if !all {
            finding.repairs.push(Repair::DropDegenerate);
            finding.recommended = true;
        }
        findings.push(finding);
    }
    let mut slivers = Vec::new();
    let (mut worst, small) = (1.0_f64, SMALL_ANGLE.sin());
    let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
    for polygon in 0..clean.soup.polygon_count() {
        let mut is_sliver = false;
        for &t in clean.surface.of(polygon) {
            let corners = clean.surface.corners(&clean.soup, t);
            let sides = [0, 1, 2].map(|k| corners[(k + 1) % 3] - corners[k]);
            let lengths = sides.map(|side| side.norm());
            for length in lengths.into_iter().filter(|&length| length > 0.0) {
                (shortest, longest) = (shortest.min(length), longest.max(length));
            }
            if is_flat(corners) {
                continue;
            }
            let doubled = doubled_normal(corners).norm();
            let most = lengths.into_iter().fold(0.0, f64::max);
            // The smallest angle lies between the two longer sides; it is never obtuse, so its sine will do.
            let product = lengths[0] * lengths[1] * lengths[2];
            let least = lengths.into_iter().fold(f64::INFINITY, f64::min);
            let sine = doubled * least / product;
            worst = worst.min(sine);
            is_sliver |= sine < small || most * most > ASPECT * doubled;
        }
        if is_sliver {
            slivers.push(clean.origins[polygon]);
        }
    }
    if !slivers.is_empty() {
        let mut finding = Finding::new(FindingKind::Slivers, Severity::Warning, slivers.len());
        finding.faces = slivers;
        finding.worst = Some(worst.asin());
        findings.push(finding);
    }
    if longest > HUGE_RATIO * shortest {
        let mut finding = Finding::new(FindingKind::HugeRatio, Severity::Note, 1);
        finding.worst = Some(longest / shortest);
        findings.push(finding);
    }
}

/// Where the vertices lie: nowhere in use, at one place, far away.
fn placement(soup: &Soup, clean: &Clean, shape: &Shape, findings: &mut Vec<Finding>) {
    let mut is_used = vec![false; soup.positions.len()];
    for &v in &soup.corners {
        is_used[v as usize] = true;
    }
    let isolated = (0..soup.positions.len()).filter(|&v| !is_used[v]).map(|v| v as u32);
    let isolated = Vec::from_iter(isolated);
    if !isolated.is_empty() {
        let mut finding = Finding::new(FindingKind::Isolated, Severity::Note, isolated.len());
        finding.vertices = isolated;
        finding.repairs.push(Repair::DropIsolated);
        findings.push(finding);
    }
    if !shape.boundary.is_empty() && clean.surface.extent > 0.0 {
        let (weld, tolerance) = best_weld(clean);
        if weld.closable > 0 {
            let count = weld.merges.len();
            let mut finding =
                Finding::new(FindingKind::CoincidentVertices, Severity::Warning, count);
            finding.vertices = weld.merges.concat();
            finding.vertices.sort_unstable();
            finding.vertices.dedup();
            finding.recommended = is_shattered(clean, weld.closable);
            finding.closable = Some(weld.closable);
            finding.repairs.push(Repair::Weld { tolerance });
            findings.push(finding);
        }
    }
    let ratio = clean.surface.distance / clean.surface.diagonal;
    if clean.surface.extent > 0.0 && ratio > FAR {
        let mut finding = Finding::new(FindingKind::FarFromOrigin, Severity::Note, 1);
        finding.worst = Some(ratio);
        findings.push(finding);
    }
}

fn components(clean: &Clean, shape: &Shape) -> Vec<Component> {
    let soup = &*clean.soup;
    let empty = Component {
        first_face: u32::MAX,
        faces: 0,
        vertices: 0,
        boundary_loops: 0,
        euler: 0,
        genus: None,
        is_orientable: true,
        is_closed: true,
        area: 0.0,
        area_share: 0.0,
        volume: None,
    };
    let mut components = vec![empty; shape.components];
    let mut volumes = vec![0.0; shape.components];
    let mut is_manifold = vec![true; shape.components];
    let mut agrees = vec![true; shape.components];
    let component_of =
        |side: u32| shape.face_components[clean.sides.polygons[side as usize] as usize] as usize;
    let is_closed = closed_patches(&clean.sides, shape);
    for polygon in 0..soup.polygon_count() {
        let number = shape.face_components[polygon] as usize;
        let patch = shape.face_patches[polygon] as usize;
        let component = &mut components[number];
        component.first_face = component.first_face.min(clean.origins[polygon]);
        component.faces += 1;
        component.area += clean.surface.area(soup, polygon) * clean.surface.extent.powi(2);
        component.is_orientable &= shape.patch_is_orientable[patch];
        component.is_closed &= is_closed[patch] || !shape.patch_is_orientable[patch];
        volumes[number] += clean.surface.volume(soup, polygon);
    }
    for edge in 0..clean.sides.edges.len() {
        let number = component_of(clean.sides.of(edge)[0]);
        components[number].euler -= 1;
        components[number].is_closed &= clean.sides.of(edge).len() == 2;
        is_manifold[number] &= clean.sides.of(edge).len() <= 2;
    }
    for &edge in shape.disagreeing.iter().chain(&shape.conflicts) {
        agrees[component_of(clean.sides.of(edge as usize)[0])] = false;
    }
    // Each vertex once for each component that it belongs to: corner by corner, component by component.
    let mut corners = Vec::from_iter(0..soup.corners.len() as u32);
    if shape.components > 1 {
        corners.sort_by_key(|&corner| component_of(corner));
    }
    let mut last = vec![usize::MAX; soup.positions.len()];
    for corner in corners {
        let (v, number) = (soup.corners[corner as usize], component_of(corner));
        if last[v as usize] != number {
            last[v as usize] = number;
            components[number].vertices += 1;
            is_manifold[number] &= shape.bow_ties.binary_search(&v).is_err();
        }
    }
    for chain in &shape.loops {
        components[component_of(chain.sides[0])].boundary_loops += 1;
    }
    let total: f64 = components.iter().map(|component| component.area).sum();
    for (number, component) in components.iter_mut().enumerate() {
        component.euler += component.vertices as i64 + component.faces as i64;
        component.area_share = if total > 0.0 { component.area / total } else { 0.0 };
        let doubled = 2 - component.euler - component.boundary_loops as i64;
        if is_manifold[number] && component.is_orientable {
            component.genus = usize::try_from(doubled / 2).ok();
        }
        if component.is_closed && agrees[number] {
            component.volume = Some(volumes[number] * clean.surface.extent.powi(3));
        }
    }
    components
}

fn boundary_loops(clean: &Clean, shape: &Shape) -> Vec<BoundaryLoop> {
    let length = |&side: &u32| {
        let next = clean.sides.next[side as usize];
        let [p, q] =
            [side, next].map(|c| clean.surface.points[clean.soup.corners[c as usize] as usize]);
        (p - q).norm() * clean.surface.extent
    };
    let component = |side: u32| clean.sides.polygons[side as usize] as usize;
    let loops = shape.loops.iter().map(|chain| BoundaryLoop {
        vertices: chain.vertices.clone(),
        length: chain.sides.iter().map(length).sum(),
        edges: chain.sides.len(),
        is_closed: chain.is_closed,
        component: shape.face_components[component(chain.sides[0])],
    });
    loops.collect()
}
