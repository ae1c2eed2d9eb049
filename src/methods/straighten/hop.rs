//! Changes of the sequence of edges that curves cross: past a vertex, past an end of a boundary edge, of a junction into the next
//! face, and the removal of crossings that a curve takes back.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::f64::consts::{FRAC_PI_2, PI};

use super::flat::Place;
use super::network::{Anchor, End, Network};
use super::relax::GAP;
use crate::mesh::{EdgeId, FaceId, VertexId};

/// Angles must gain this much, so that rounding does not send a curve to and fro.
const GAIN: f64 = 1e-9;

/// How often a junction of held curves may change its face.
pub(super) const HELD_HOPS: u32 = 3;

/// Crossings of one curve on edges at one vertex, in the order of the curve.
struct Run {
    nodes: Vec<u32>,
    /// The segments that lead on at either end; none where the curve ends at the boundary.
    arms: [Option<u32>; 2],
}

/// Lets every curve pass vertices to the other side where it is shorter there. **Gives** the number of passes.
pub(super) fn pass_vertices(net: &mut Network) -> usize {
    let mut passes = 0;
    let mut node = 0;
    while node < net.nodes.len() {
        for end in 0..2 {
            let n = &net.nodes[node];
            if let (true, false, Place::Edge(e, _)) = (n.is_alive, n.is_fixed, n.place) {
                let v = net.flat.mesh.edge_vertices(e)[end];
                passes += usize::from(pass(net, node as u32, v).is_some());
            }
        }
        node += 1;
    }
    passes
}

/// The run of a crossing's curve around a vertex.
fn run(net: &Network, node: u32, v: VertexId) -> Option<Run> {
    let mesh = net.flat.mesh;
    let limit = mesh.outgoing(v).count();
    let walk = |first: Option<u32>| {
        let (mut nodes, mut at, mut arm) = (Vec::new(), node, first);
        while let Some(segment) = arm {
            let next = net.other_end(segment, at);
            match net.place(next) {
                Place::Edge(e, _) if mesh.edge_vertices(e).contains(&v) => {
                    nodes.push(next);
                    arm = net.other_arm(next, segment);
                    at = next;
                }
                _ => break,
            }
            if nodes.len() > limit {
                return None;
            }
        }
        Some((nodes, arm))
    };
    let arms = &net.nodes[node as usize].arms;
    let (mut nodes, first) = walk(arms.first().copied())?;
    let (after, last) = walk(arms.get(1).copied())?;
    nodes.reverse();
    nodes.push(node);
    nodes.extend(after);
    Some(Run { nodes, arms: [first, last] })
}

/// Takes a curve past a vertex, if it is shorter on the other side.
fn pass(net: &mut Network, node: u32, v: VertexId) -> Option<()> {
    if net.is_occupied[v.index()] {
        return None;
    }
    let mesh = net.flat.mesh;
    let mut run = run(net, node, v)?;
    let is_end = run.arms.iter().any(Option::is_none);
    if run.arms[1].is_none() {
        // An end comes first.
        run.nodes.reverse();
        run.arms.reverse();
    }
    let last_arm = run.arms[1]?;
    if is_end != mesh.is_boundary_vertex(v) || run.nodes.iter().any(|&n| blocks(net, n, v)) {
        return None;
    }
    let spokes: Vec<EdgeId> = mesh.outgoing(v).map(|h| h.edge()).collect();
    let sectors: Vec<FaceId> = mesh.outgoing(v).filter_map(|h| mesh.face(h)).collect();
    let count = spokes.len();
    if run.nodes.len() > count {
        return None;
    }
    let index = |n: u32| match net.place(n) {
        Place::Edge(e, _) => spokes.iter().position(|&s| s == e),
        _ => None,
    };
    let (first, last) = (index(run.nodes[0])?, index(*run.nodes.last()?)?);
    // Counter-clockwise, the curve leaves the last spoke into the sector of the same number.
    let last_face = net.segments[last_arm as usize].face;
    let is_ccw = sectors.get(last) == Some(&last_face);
    let step = |i: usize, n: usize| {
        if is_ccw { (i + n) % count } else { (i + count - n % count) % count }
    };
    let sector_after = |i: usize| if is_ccw { i } else { (i + count - 1) % count };
    if sectors.get(sector_after(last)) != Some(&last_face) {
        return None;
    }
    let angle_of = |i: usize| {
        let next = spokes[step(i, 1)];
        let far = mesh.edge_vertices(next).into_iter().find(|&w| w != v).unwrap_or(v);
        net.flat.angle(sectors[sector_after(i)], v, spokes[i], Place::Vertex(far))
    };
    let toward = |arm: u32, n: u32, i: usize| {
        let other = net.other_end(arm, n);
        let face = net.segments[arm as usize].face;
        let place = net.place(other);
        let origin = net.flat.at(face, Place::Vertex(v));
        (
            other,
            net.flat.angle(face, v, spokes[i], place),
            (net.flat.at(face, place) - origin).norm(),
        )
    };
    let between: f64 = (0..run.nodes.len() - 1).map(|n| angle_of(step(first, n))).sum();
    let (q, angle_q, distance_q) = toward(last_arm, *run.nodes.last()?, last);
    let mut own = between + angle_q;
    let start = match run.arms[0] {
        Some(arm) => {
            let (p, angle_p, distance_p) = toward(arm, run.nodes[0], first);
            own += angle_p;
            Some((arm, p, distance_p))
        }
        None => None,
    };
    let other = net.flat.angle_sums[v.index()] - own;
    let straight = if is_end { FRAC_PI_2 } else { PI };
    if !(own > straight + GAIN && other < straight - GAIN && distance_q > 0.0) {
        return None;
    }
    if start.is_some_and(|(_, p, d)| p == q || !(d > 0.0)) {
        return None;
    }
    let is_free = net.segments[last_arm as usize].is_free;
    let anchor = if is_free { None } else { Some(moved_anchor(net, &run.nodes, v)?) };

    // The spokes on the other side, from q on, each with the place where a straight line crosses it.
    let added =
        if is_end { if is_ccw { count - 1 - last } else { last } } else { count - run.nodes.len() };
    let mut turned = angle_of(last) - angle_q;
    let mut ends = vec![End::Node(q)];
    let mut faces = vec![last_face];
    for n in 1..=added {
        let i = step(last, n);
        let e = spokes[i];
        let distance = match start {
            Some((_, _, d)) => {
                let below = distance_q * turned.sin() + d * (other - turned).sin();
                if below > 0.0 { distance_q * d * other.sin() / below } else { f64::INFINITY }
            }
            None => distance_q * other.cos() / (other - turned).cos().max(1e-9),
        };
        let (nearest, crossing) = net.nearest(e, v);
        let most = if crossing.is_some() { 0.6 * nearest } else { 1.0 - GAP };
        let s = (distance / net.flat.length(e)).clamp(GAP.min(0.3 * most), most);
        if !(s > 1e-9) {
            return None;
        }
        let t = if mesh.edge_vertices(e)[0] == v { s } else { 1.0 - s };
        ends.push(End::New(n as u32, Place::Edge(e, t)));
        if n < added || !is_end {
            faces.push(sectors[sector_after(i)]);
            turned += angle_of(i);
        }
    }
    let mut removed = vec![last_arm];
    if let Some((arm, p, _)) = start {
        ends.push(End::Node(p));
        removed.push(arm);
        if faces.last() != Some(&net.segments[arm as usize].face) {
            return None;
        }
    }
    for (i, &face) in faces.iter().enumerate() {
        if net.is_busy(face) && !net.admits(face, &removed, &[[ends[i], ends[i + 1]]]) {
            return None;
        }
    }

    for &n in &run.nodes {
        net.remove_node(n);
    }
    let mut nodes = Vec::new();
    for end in ends {
        nodes.push(match end {
            End::Node(n) => n,
            End::New(_, place) => {
                let n = net.add_node(place);
                if let (Some(a), Place::Edge(e, _)) = (anchor, place) {
                    let origin = if mesh.edge_vertices(e)[0] == v { 0.0 } else { 1.0 };
                    net.nodes[n as usize].anchor = Some(Anchor { origin, target: origin, ..a });
                }
                n
            }
        });
    }
    for (pair, face) in nodes.windows(2).zip(faces) {
        net.add_segment([pair[0], pair[1]], face, is_free);
    }
    Some(())
}

/// Whether another curve runs between a crossing and the vertex.
fn blocks(net: &Network, node: u32, v: VertexId) -> bool {
    match net.place(node) {
        Place::Edge(e, _) => net.nearest(e, v).1 != Some(node) || net.is_wall[e.index()],
        _ => true,
    }
}

/// How crossings are held after a curve that stays near its place has passed a vertex; `None` where that is too far, or where
/// the curve does not press against the vertex.
fn moved_anchor(net: &Network, nodes: &[u32], v: VertexId) -> Option<Anchor> {
    let mut reach = f64::INFINITY;
    for &n in nodes {
        let (Place::Edge(e, t), Some(anchor)) = (net.place(n), net.nodes[n as usize].anchor) else {
            return None;
        };
        let end = if net.flat.mesh.edge_vertices(e)[0] == v { 0.0 } else { 1.0 };
        if (t - end).abs() > 2.0 * GAP {
            return None;
        }
        reach = reach.min(anchor.reach - (anchor.origin - end).abs() * net.flat.length(e));
    }
    (reach > 0.0).then_some(Anchor { origin: 0.0, target: 0.0, stiffness: 0.0, reach })
}

/// Moves a junction across a side of its face, near parameter `t`. Arms that cross there end at it; the others cross there from
/// then on. **Gives** whether that was possible.
pub(super) fn cross_edge(net: &mut Network, node: u32, e: EdgeId, t: f64) -> bool {
    let Place::Face(f, _) = net.place(node) else { return false };
    let mesh = net.flat.mesh;
    let h = e.halfedge();
    let beyond = [mesh.face(h), mesh.face(h.twin())].into_iter().flatten().find(|&g| g != f);
    let Some(g) = beyond.filter(|_| !net.is_wall[e.index()]) else { return false };
    let arms = net.nodes[node as usize].arms.clone();
    let held = arms.iter().filter(|&&a| !net.segments[a as usize].is_free).count();
    if held > 2 && net.nodes[node as usize].hops >= HELD_HOPS {
        return false;
    }
    let crosses = |n: u32| matches!(net.place(n), Place::Edge(d, _) if d == e);
    type Ends = Vec<(u32, u32)>;
    let (mut there, mut here): (Ends, Ends) =
        arms.iter().map(|&a| (a, net.other_end(a, node))).partition(|&(_, n)| crosses(n));

    // The gap between the crossings that stay.
    let list = net.edge_nodes[e.index()].clone();
    let position = |n: u32| list.iter().position(|&m| m == n).unwrap_or(0);
    let value =
        |i: Option<usize>, default: f64| match i.and_then(|i| list.get(i)).map(|&n| net.place(n)) {
            Some(Place::Edge(_, t)) => t,
            _ => default,
        };
    there.sort_by_key(|&(_, n)| position(n));
    let first = match there.first() {
        Some(&(_, n)) => position(n),
        None => {
            list.iter().filter(|&&n| matches!(net.place(n), Place::Edge(_, s) if s < t)).count()
        }
    };
    if there.iter().enumerate().any(|(i, &(_, n))| position(n) != first + i) {
        return false;
    }
    let low = value(first.checked_sub(1), 0.0);
    let high = value(Some(first + there.len()), 1.0);
    let room = high - low;
    if !(room > 1e-6) {
        return false;
    }
    // Near the ends too, or else no junction could go around a vertex.
    let t = t.clamp(low + 2.0 * GAP * room, high - 2.0 * GAP * room);
    let along = t * net.flat.length(e);
    let angle = |n: u32| {
        let [x, y] = net.flat.beside(f, e, net.place(n));
        y.atan2(x - along)
    };
    here.sort_by(|a, b| angle(b.1).total_cmp(&angle(a.1)));
    let mut beyond = Vec::new();
    for &(arm, n) in &there {
        let Some(outer) = net.other_arm(n, arm) else { return false };
        let far = net.other_end(outer, n);
        if far == node {
            return false;
        }
        beyond.push((outer, far));
    }
    let Some(side) = net.flat.side(g, e) else { return false };
    let mut weights = [4.0 * GAP; 3];
    let s = super::flat::along(mesh.face_halfedges(g)[side], t);
    weights[side] = (1.0 - s) * (1.0 - 4.0 * GAP);
    weights[(side + 1) % 3] = s * (1.0 - 4.0 * GAP);
    let place = Place::Face(g, net.flat.place_of_weights(g, weights));

    let centre = End::New(u32::MAX, place);
    // Where the new arms are straight, in order and apart.
    let own = net.flat.beside(g, e, place);
    let length = net.flat.length(e);
    let apart = GAP * room / (here.len() + 1) as f64;
    let mut previous = low;
    let crossings: Vec<Place> = here
        .iter()
        .enumerate()
        .map(|(k, &(_, n))| {
            let [x, y] = net.flat.beside(f, e, net.place(n));
            let straight = (own[0] * y + x * own[1]) / ((y + own[1]) * length).max(1e-300);
            let most = high - apart * (here.len() - k) as f64;
            previous = straight.clamp(previous + apart, most.max(previous + apart));
            Place::Edge(e, previous)
        })
        .collect();
    let new = |k: usize| End::New(k as u32, crossings[k]);
    let near: Vec<[End; 2]> =
        here.iter().enumerate().map(|(k, &(_, n))| [End::Node(n), new(k)]).collect();
    let mut far: Vec<[End; 2]> = (0..here.len()).map(|k| [new(k), centre]).collect();
    far.extend(beyond.iter().map(|&(_, n)| [centre, End::Node(n)]));
    let outer: Vec<u32> = beyond.iter().map(|b| b.0).collect();
    if !net.admits(f, &arms, &near) || !net.admits(g, &outer, &far) {
        return false;
    }

    let is_free = |net: &Network, arm: u32| net.segments[arm as usize].is_free;
    // A curve that stays near its place crosses the edge on the other side of the junction now.
    let mut held = there
        .iter()
        .filter(|&&(a, _)| !is_free(net, a))
        .map(|&(_, n)| net.nodes[n as usize].anchor);
    let anchor = held.next().flatten();
    let here: Vec<(u32, bool)> = here.iter().map(|&(a, n)| (n, is_free(net, a))).collect();
    let beyond: Vec<(u32, bool)> = beyond.iter().map(|&(a, n)| (n, is_free(net, a))).collect();
    for arm in arms {
        net.remove_segment(arm);
    }
    for (_, n) in there {
        net.remove_node(n);
    }
    net.nodes[node as usize].place = place;
    net.nodes[node as usize].hops += 1;
    for ((n, is_free), crossing) in here.into_iter().zip(crossings) {
        let c = net.add_node(crossing);
        if !is_free {
            net.nodes[c as usize].anchor = anchor;
        }
        net.add_segment([n, c], f, is_free);
        net.add_segment([c, node], g, is_free);
    }
    for (n, is_free) in beyond {
        net.add_segment([node, n], g, is_free);
    }
    true
}

/// Removes what curves take back: crossings to and fro, crossings of edges at the vertex where a curve ends, junctions of two arms.
pub(super) fn simplify(net: &mut Network) -> usize {
    let mut total = 0;
    loop {
        let mut removed = 0;
        for node in 0..net.nodes.len() as u32 {
            let n = &net.nodes[node as usize];
            if n.is_alive && !n.is_fixed {
                let done = match n.place {
                    Place::Edge(e, _) => take_back(net, node, e),
                    Place::Face(f, _) => dissolve(net, node, f),
                    Place::Vertex(_) => None,
                };
                removed += usize::from(done.is_some());
            }
        }
        total += removed;
        if removed == 0 {
            return total;
        }
    }
}

fn take_back(net: &mut Network, node: u32, e: EdgeId) -> Option<()> {
    let [a, b] = net.nodes[node as usize].arms[..] else { return None };
    for (arm, outer) in [(a, b), (b, a)] {
        let next = net.other_end(arm, node);
        let p = net.other_end(outer, node);
        let face = net.segments[outer as usize].face;
        let is_free = net.segments[outer as usize].is_free;
        match net.place(next) {
            Place::Edge(d, _) if d == e => {
                let list = &net.edge_nodes[e.index()];
                let [i, j] = [node, next].map(|n| list.iter().position(|&m| m == n));
                let Some(beyond) = net.other_arm(next, arm) else { continue };
                let q = net.other_end(beyond, next);
                let is_next = matches!((i, j), (Some(i), Some(j)) if i.abs_diff(j) == 1);
                let is_same = net.segments[beyond as usize].face == face;
                if !is_next || !is_same || p == next || p == q {
                    continue;
                }
                let pair = [End::Node(p), End::Node(q)];
                if net.is_busy(face) && !net.admits(face, &[outer, beyond], &[pair]) {
                    continue;
                }
                net.remove_node(node);
                net.remove_node(next);
                net.add_segment([p, q], face, is_free);
                return Some(());
            }
            Place::Vertex(v) if net.flat.mesh.edge_vertices(e).contains(&v) => {
                let is_nearest = net.nearest(e, v).1 == Some(node);
                let pair = [End::Node(p), End::Node(next)];
                if !is_nearest || p == next || !net.admits(face, &[outer], &[pair]) {
                    continue;
                }
                net.remove_node(node);
                net.add_segment([p, next], face, is_free);
                return Some(());
            }
            _ => {}
        }
    }
    None
}

fn dissolve(net: &mut Network, node: u32, face: FaceId) -> Option<()> {
    let [a, b] = net.nodes[node as usize].arms[..] else { return None };
    let is_free = net.segments[a as usize].is_free;
    let [p, q] = [a, b].map(|arm| net.other_end(arm, node));
    let ends = [End::Node(p), End::Node(q)];
    let is_same = net.segments[b as usize].is_free == is_free && p != q;
    if !is_same || !net.admits(face, &[a, b], &[ends]) {
        return None;
    }
    net.remove_node(node);
    net.add_segment([p, q], face, is_free);
    Some(())
}
