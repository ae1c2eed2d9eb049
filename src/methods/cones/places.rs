//! A given number of cones, at the places where they do most.
//!
//! The price of angle decides how many cones an optimum has, and on many surfaces no price leads to few of them: below 4π on a sphere
//! there is no smaller total angle. Asked for is then
//!
//! minimise ½ uᵀM u over places and angles of so many cones, within their bounds, adding up to 2πχ on closed components,
//!
//! which is not convex in the places. With the places given the angles are the small dense problem of [`super::greens`] with price 0. φ,
//! its dual variable, is 0 at the cones, and says at every other vertex what a cone there would gain at first. More cones than are wanted
//! move up its slope as long as that helps; those that are missed least are taken away one by one; the rest move on; then one is tried at
//! the peaks of |φ| in place of the one that is missed least. All of these are decided by the exact energy: among places whose Green's
//! functions are known it is a quadratic function of the angles.
//!
//! Guaranteed: the energy falls with every change at one number of cones; at the end none of the moves that promise most gains, and no
//! exchange with one of the highest peaks. Not guaranteed: the best places of all.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::collections::BTreeSet;
use std::f64::consts::PI;

use super::debias::{MOST, TOLERANCE};
use super::greens::{self, Dictionary};
use super::params::FREE_BOUND;
use super::problem::{ActiveSet, Problem, Stance};
use super::system::{NONE, Response};
use super::{Cone, ConeError, ConeFields, ConeFlow};
use crate::mesh::VertexId;
use crate::methods::flow::SolveError;

/// Largest |angle| where no bound is given, radians: half a turn is left about a cone. Without this limit the eight best cones of bunny-closed
/// have 3π/2 and half the ∫u², and spikes that triangles follow badly: 1.049 of angle distortion where these have 1.034.
const USUAL: f64 = PI;
/// Neighbours that each cone may move to in a round, the most promising first.
const WAYS: usize = 2;
/// Steps up the slope of φ after which each cone may stay, too.
const STRIDES: [usize; 3] = [3, 9, 27];
/// Cones that may go, the one that is worth least first.
const TRIED: usize = 4;
/// Moves that are tried in a round, the most promising first.
const MOVES: usize = 96;
/// Peaks of |φ| that are tried as places for another cone.
const PEAKS: usize = 12;
/// Cones beyond the number that is wanted that the search begins with.
const MOST_MORE: usize = 64;
/// Green's functions kept: k² numbers.
const MOST_KEPT: usize = 600;
/// What a change has to gain, over the energy: less is rounding.
const GAIN: f64 = 1e-7;
/// Mean of ½ u² that is as good as none: without this limit cones of a polyhedron would wander for ever from one exact answer to the next.
const FLAT: f64 = 1e-9;
/// Angle that is none, radians.
const NOTHING: f64 = 1e-9;

/// The search for the best places of a number of cones, one bounded step at a time.
///
/// It is made from the cones that are given and once more from some that are far from one another: where it ends depends on where it
/// begins.
#[derive(Clone, Debug)]
pub struct Places(Vec<Search>);

/// One search.
#[derive(Clone, Debug)]
struct Search {
    count: usize,
    /// Cones that stay where they are, by dof.
    pinned: BTreeSet<u32>,
    /// Cones whose angles stay as well.
    held: BTreeSet<u32>,
    /// All cones, by dof.
    places: BTreeSet<u32>,
    /// Bounds of every dof.
    bounds: [Vec<f64>; 2],
    set: ActiveSet,
    dictionary: Dictionary,
    response: Response,
    /// φ at every dof with its constants.
    phi: Vec<f64>,
    energy: f64,
    stage: Stage,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// To more cones than are wanted.
    Grow,
    /// These to where they do most.
    Spread,
    /// To as many as are wanted.
    Shrink,
    /// These to where they do most.
    Move,
    /// One for another.
    Exchange,
    Done,
}

/// Cones elsewhere.
struct Change {
    set: ActiveSet,
    places: BTreeSet<u32>,
    /// What it does to the energy.
    gain: f64,
}

impl Places {
    /// **Takes** cones to begin with, as [`ConeFlow::evaluate`] takes them (none: only those that are far from one another); those that are to stay where
    /// they are, and among them those that keep their angle; how many there are to be, at least as many as stay. Corners of the boundary
    /// keep the angles that they have in the flow's state.
    /// **Fails** as [`ConeFlow::evaluate`], and where so few cones cannot have the total angle. **Costs** two solves for each cone, and
    /// two responses.
    pub fn new(
        flow: &mut ConeFlow,
        start: &[Cone],
        pinned: &[VertexId],
        held: &[VertexId],
        count: usize,
    ) -> Result<Self, SolveError> {
        let parts = parts(flow);
        if let Some(part) = parts.iter().find(|part| part.needed > part.members.len()) {
            let most = part.rest.signum() * part.bound * part.members.len() as f64;
            let vertex = part.members.first().map_or(0, |&i| flow.problem.system.dofs[i]);
            let [least, most] = [most.min(0.0), most.max(0.0)];
            let (vertex, needed) = (VertexId(vertex), part.rest);
            return Err(ConeError::OutOfBounds { vertex, needed, least, most }.into());
        }
        let needed = flow.fields.fixed.len() + parts.iter().map(|part| part.needed).sum::<usize>();
        if needed > count {
            return Err(ConeError::TooFew { count, needed }.into());
        }
        let spread = spread_evenly(flow, &parts);
        let mut searches = Vec::new();
        for start in [start, &spread].into_iter().skip(usize::from(start.is_empty())) {
            searches.extend(Search::new(flow, start, [pinned, held], count)?);
        }
        Ok(Self(searches))
    }

    /// Whether the search has ended.
    pub fn is_done(&self) -> bool {
        self.0.iter().all(|search| search.stage == Stage::Done)
    }

    /// The best of the searches that have ended; the first while none has.
    fn best(&self) -> &Search {
        let done = self.0.iter().filter(|search| search.stage == Stage::Done);
        done.min_by(|a, b| a.energy.total_cmp(&b.energy)).unwrap_or(&self.0[0])
    }

    /// ½ ∫ w_E u² with the cones at hand.
    pub fn energy(&self) -> f64 {
        self.best().energy
    }

    /// The cones, by ascending vertex; corners of the boundary left out.
    pub fn cones(&self, flow: &ConeFlow) -> Vec<Cone> {
        self.best().cones(flow)
    }

    /// One cone more or less, one round of moves, or one round of exchanges. **Takes** the flow that it was made with. **Costs** some tens
    /// of solves.
    pub fn step(&mut self, flow: &mut ConeFlow) -> Result<(), SolveError> {
        match self.0.iter_mut().find(|search| search.stage != Stage::Done) {
            Some(search) => search.step(flow),
            None => Ok(()),
        }
    }
}

impl Search {
    /// As [`Places::new`]; none where there are too many cones to begin with and the largest of them have no room for the others.
    fn new(
        flow: &mut ConeFlow,
        start: &[Cone],
        [pinned, held]: [&[VertexId]; 2],
        count: usize,
    ) -> Result<Option<Self>, SolveError> {
        flow.evaluate(start)?;
        let problem = &mut flow.problem;
        let dofs = problem.system.len();
        let dof = |v: &VertexId| problem.system.dof_of[v.index()];
        let is_inside = |i: &u32| *i != NONE && problem.is_inside[*i as usize];
        let mut set = ActiveSet {
            angles: vec![0.0; dofs],
            stances: vec![Stance::Held; dofs],
            signs: vec![1.0; dofs],
            order: Vec::new(),
        };
        for i in (0..dofs).filter(|&i| !problem.is_inside[i]) {
            set.angles[i] = flow.progress.set.angles[i];
        }
        for cone in start {
            set.angles[dof(&cone.vertex) as usize] = cone.angle;
        }
        let mut places: BTreeSet<u32> =
            start.iter().map(|c| dof(&c.vertex)).filter(is_inside).collect();
        let [mut low, mut high] = [vec![0.0; dofs], vec![0.0; dofs]];
        let open = open_dofs(problem, &flow.fields);
        for i in 0..dofs {
            if open[i] {
                [low[i], high[i]] = usual(problem, i);
            }
            // What is out of bounds may stay there but not go farther.
            low[i] = f64::min(low[i], set.angles[i]);
            high[i] = f64::max(high[i], set.angles[i]);
        }
        let among = |vertices: &[VertexId]| -> BTreeSet<u32> {
            vertices.iter().map(dof).filter(|i| places.contains(i)).collect()
        };
        let (held, stay) = (among(held), &among(pinned) | &among(held));
        if places.len() > count + MOST_MORE {
            // A spread optimum: the largest of its cones are a start.
            let mut order: Vec<u32> = places.difference(&stay).copied().collect();
            let size = |i: &u32| set.angles[*i as usize].abs();
            order.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.cmp(b)));
            let mut rest = vec![0.0; problem.system.components.len()];
            for i in order.drain((count + MOST_MORE).min(order.len())..) {
                places.remove(&i);
                rest[problem.system.component_of[i as usize] as usize] +=
                    std::mem::take(&mut set.angles[i as usize]);
            }
            share_out(problem, [&low, &high], &mut set.angles, &order, &mut rest);
            if rest.iter().any(|rest| rest.abs() > NOTHING) {
                return Ok(None);
            }
        }
        let mut found = Self {
            count,
            pinned: stay,
            held,
            places,
            bounds: [low, high],
            set,
            dictionary: Dictionary::new(dofs),
            response: flow.response.clone(),
            phi: Vec::new(),
            energy: 0.0,
            stage: Stage::Grow,
        };
        found.with_bounds(problem, |found, problem| found.fit(problem));
        Ok(Some(found))
    }

    fn cones(&self, flow: &ConeFlow) -> Vec<Cone> {
        let system = &flow.problem.system;
        let cone = |&i: &u32| Cone {
            vertex: VertexId(system.dofs[i as usize]),
            angle: self.set.angles[i as usize],
        };
        self.places.iter().map(cone).filter(|cone| cone.angle.abs() > NOTHING).collect()
    }

    fn step(&mut self, flow: &mut ConeFlow) -> Result<(), SolveError> {
        let problem = &mut flow.problem;
        self.with_bounds(problem, |found, problem| {
            let goes_on = match found.stage {
                Stage::Grow => found.grow(problem),
                Stage::Spread | Stage::Move => found.move_on(problem),
                Stage::Shrink => found.shrink(problem)?,
                Stage::Exchange => found.exchange(problem),
                Stage::Done => true,
            };
            found.stage = match (found.stage, goes_on) {
                (Stage::Grow, false) => Stage::Spread,
                (Stage::Spread, false) => Stage::Shrink,
                (Stage::Shrink, false) | (Stage::Exchange, true) => Stage::Move,
                (Stage::Move, false) => Stage::Exchange,
                (Stage::Exchange, false) => Stage::Done,
                (same, _) => same,
            };
            Ok(())
        })
    }

    /// Cones at no price, within the bounds of this search.
    fn with_bounds<T>(
        &mut self,
        problem: &mut Problem,
        work: impl FnOnce(&mut Self, &mut Problem) -> T,
    ) -> T {
        let mut own = std::mem::take(&mut self.bounds);
        let mut prices = vec![0.0; problem.prices.len()];
        let mut settled = vec![false; problem.settled.len()];
        let mut swap = |problem: &mut Problem, [low, high]: &mut [Vec<f64>; 2]| {
            std::mem::swap(&mut problem.low, low);
            std::mem::swap(&mut problem.high, high);
            std::mem::swap(&mut problem.prices, &mut prices);
            std::mem::swap(&mut problem.settled, &mut settled);
        };
        swap(problem, &mut own);
        let result = work(self, problem);
        swap(problem, &mut own);
        self.bounds = own;
        result
    }

    /// The best angles at the places, φ and the energy.
    fn fit(&mut self, problem: &mut Problem) {
        if self.dictionary.len() > MOST_KEPT {
            let kept: Vec<u32> = self.places.iter().copied().collect();
            self.dictionary.retain(problem, &kept);
        }
        let needed: Vec<u32> = self.places.iter().copied().collect();
        self.learn(problem, &needed);
        self.respond(problem);
        release(&mut self.set, &self.places, &self.held);
        let tolerance = self.tolerance();
        greens::settle(problem, &self.dictionary, &mut self.set, &self.phi, tolerance);
        self.respond(problem);
    }

    /// φ and the energy at the angles at hand.
    fn respond(&mut self, problem: &mut Problem) {
        self.response = problem.exact_response(&self.set.angles, &self.response);
        self.phi = greens::shifted(problem, &self.set, &self.response);
        let mass = &problem.system.mass;
        self.energy = 0.5 * self.response.u.iter().zip(mass).map(|(u, m)| m * u * u).sum::<f64>();
    }

    /// What a change has to gain.
    fn least_gain(&self, problem: &Problem) -> f64 {
        GAIN * self.energy.max(FLAT * problem.system.mass.iter().sum::<f64>())
    }

    /// Rounding of φ.
    fn tolerance(&self) -> f64 {
        TOLERANCE * self.phi.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
    }

    /// Green's functions at these vertices.
    fn learn(&mut self, problem: &mut Problem, dofs: &[u32]) {
        let missing = self.dictionary.missing(dofs);
        self.dictionary.add(problem, &missing);
    }

    /// The best angles with the cones elsewhere; none where they could not have the total angle there.
    ///
    /// **Takes** places whose Green's functions are known.
    fn at(&self, problem: &Problem, places: BTreeSet<u32>) -> Option<Change> {
        let mut set = self.set.clone();
        // What cones have that are gone goes to those that are new, then to all others, as far as they have room.
        let mut rest = vec![0.0; problem.system.components.len()];
        for &i in self.places.difference(&places) {
            rest[problem.system.component_of[i as usize] as usize] +=
                std::mem::take(&mut set.angles[i as usize]);
        }
        let bounds = [&problem.low[..], &problem.high[..]];
        let fresh: Vec<u32> = places.difference(&self.places).copied().collect();
        let all: Vec<u32> = places.difference(&self.held).copied().collect();
        share_out(problem, bounds, &mut set.angles, &fresh, &mut rest);
        share_out(problem, bounds, &mut set.angles, &all, &mut rest);
        if rest.iter().any(|rest| rest.abs() > NOTHING) {
            return None;
        }
        for &i in &self.places {
            set.stances[i as usize] = Stance::Held;
        }
        release(&mut set, &places, &self.held);

        let all: Vec<u32> = self.places.union(&places).copied().collect();
        let changes = |set: &ActiveSet| -> Vec<f64> {
            all.iter().map(|&i| set.angles[i as usize] - self.set.angles[i as usize]).collect()
        };
        let mut phi = self.phi.clone();
        let first = changes(&set);
        for &i in &places {
            phi[i as usize] -= self.dictionary.product(i, &all, &first);
        }
        greens::settle(problem, &self.dictionary, &mut set, &phi, self.tolerance());
        let change = changes(&set);
        let gain = all.iter().zip(&change).map(|(&i, d)| {
            d * (self.phi[i as usize] - 0.5 * self.dictionary.product(i, &all, &change))
        });
        Some(Change { gain: gain.sum(), set, places })
    }

    fn take(&mut self, change: Change) {
        (self.set, self.places) = (change.set, change.places);
    }

    /// The change to one of these places less that loses the least.
    ///
    /// **Takes** places whose Green's functions are known, and angles there. To first order a cone is worth μ² / (2 (G⁻¹)ᵢᵢ): those
    /// that are worth least are looked at exactly.
    fn without_one(
        &self,
        problem: &Problem,
        places: &BTreeSet<u32>,
        angles: &[f64],
    ) -> Option<Change> {
        let order: Vec<u32> = places.iter().copied().collect();
        let spreads = self.dictionary.inverse_diagonal(problem, &order);
        let mut worth: Vec<(f64, u32)> = order
            .iter()
            .zip(spreads)
            .filter(|(i, _)| !self.pinned.contains(i))
            .map(|(&i, spread)| (angles[i as usize].powi(2) / spread, i))
            .collect();
        worth.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let without = |(_, i): &(f64, u32)| {
            let mut fewer = places.clone();
            fewer.remove(i);
            self.at(problem, fewer)
        };
        // On a part whose other cones have no room none can be spared.
        let tried = worth.iter().filter_map(without).take(TRIED);
        tried.max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// The highest peaks of |φ| where another cone may be.
    fn peaks(&self, problem: &Problem) -> Vec<u32> {
        let system = &problem.system;
        let height = |i: u32| {
            let (at, i) = (self.phi[i as usize], i as usize);
            let bound = if at > 0.0 { problem.high[i] } else { problem.low[i] };
            if problem.is_inside[i] && bound != 0.0 { at.abs() } else { 0.0 }
        };
        let mut found: Vec<(f64, u32)> = (0..system.len() as u32)
            .filter(|i| !self.places.contains(i))
            .map(|i| (height(i), i))
            .filter(|&(own, i)| {
                let ring =
                    system.starts[i as usize] as usize..system.starts[i as usize + 1] as usize;
                own > 0.0 && system.neighbours[ring].iter().all(|&j| height(j) <= own)
            })
            .collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        found.truncate(PEAKS);
        found.into_iter().map(|(_, i)| i).collect()
    }

    /// One cone more, until there are more than wanted. Gives whether there was a place for it.
    fn grow(&mut self, problem: &mut Problem) -> bool {
        let more = self.count + (self.count / 2).clamp(4, MOST_MORE);
        if self.places.len() >= more {
            return false;
        }
        let peaks = self.peaks(problem);
        self.learn(problem, &peaks);
        let with = |peak: u32| {
            let mut more = self.places.clone();
            more.insert(peak);
            self.at(problem, more)
        };
        let best = peaks.into_iter().filter_map(with).max_by(|a, b| a.gain.total_cmp(&b.gain));
        let Some(change) = best else { return false };
        self.take(change);
        self.fit(problem);
        true
    }

    /// One cone less, until there are as many as wanted. Gives whether one went.
    fn shrink(&mut self, problem: &mut Problem) -> Result<bool, ConeError> {
        if self.places.len() <= self.count.max(self.pinned.len()) {
            return Ok(false);
        }
        let change = self.without_one(problem, &self.places, &self.set.angles);
        let too_few = ConeError::TooFew { count: self.count, needed: self.places.len() };
        self.take(change.ok_or(too_few)?);
        self.fit(problem);
        Ok(true)
    }

    /// Neighbours where a cone may be and none is.
    fn open_neighbours(&self, problem: &Problem, i: u32) -> Vec<u32> {
        let system = &problem.system;
        let ring = system.starts[i as usize] as usize..system.starts[i as usize + 1] as usize;
        let is_open = |&&j: &&u32| {
            let j = j as usize;
            problem.is_inside[j] && problem.high[j] > problem.low[j]
        };
        let open = system.neighbours[ring].iter().filter(is_open);
        open.copied().filter(|j| !self.places.contains(j)).collect()
    }

    /// Every cone to the neighbour that gains most, as far as that gains. Gives whether any did.
    fn move_on(&mut self, problem: &mut Problem) -> bool {
        let mut ways: Vec<(f64, u32, u32)> = Vec::new();
        for &i in self.places.difference(&self.pinned) {
            let angle = self.set.angles[i as usize];
            let promise = |j: u32| angle * (self.phi[j as usize] - self.phi[i as usize]);
            let mut ring = self.open_neighbours(problem, i);
            ring.sort_by(|&a, &b| promise(b).total_cmp(&promise(a)).then(a.cmp(&b)));
            let mut found: Vec<u32> = ring.iter().copied().take(WAYS).collect();
            // Up the slope of φ, for long ways on fine meshes.
            let (mut at, mut steps) = (i, 0);
            while steps < STRIDES[STRIDES.len() - 1] {
                let up = self.open_neighbours(problem, at).into_iter();
                let up = up.filter(|&j| promise(j) > promise(at));
                let Some(next) = up.max_by(|&a, &b| promise(a).total_cmp(&promise(b))) else {
                    break;
                };
                (at, steps) = (next, steps + 1);
                if STRIDES.contains(&steps) {
                    found.push(at);
                }
            }
            ways.extend(found.into_iter().map(|j| (promise(j), i, j)));
        }
        ways.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
        ways.truncate(MOVES);
        let targets: BTreeSet<u32> = ways.iter().map(|way| way.2).collect();
        self.learn(problem, &targets.into_iter().collect::<Vec<_>>());
        // All gains are against the cones before the round: φ is theirs.
        let mut best = Change { set: self.set.clone(), places: self.places.clone(), gain: 0.0 };
        for (_, from, to) in ways {
            if !best.places.contains(&from) || best.places.contains(&to) {
                continue;
            }
            let mut places = best.places.clone();
            places.remove(&from);
            places.insert(to);
            if let Some(change) = self.at(problem, places)
                && change.gain > best.gain + self.least_gain(problem)
            {
                best = change;
            }
        }
        let has_gained = best.gain > 0.0;
        if has_gained {
            self.take(best);
            self.fit(problem);
        }
        has_gained
    }

    /// A cone at one of the highest peaks in place of the one that is missed least. Gives whether that gained.
    fn exchange(&mut self, problem: &mut Problem) -> bool {
        let peaks = self.peaks(problem);
        self.learn(problem, &peaks);
        let best = peaks
            .into_iter()
            .filter_map(|peak| {
                let mut more = self.places.clone();
                more.insert(peak);
                let with = self.at(problem, more)?;
                self.without_one(problem, &with.places, &with.set.angles)
            })
            .max_by(|a, b| a.gain.total_cmp(&b.gain));
        match best.filter(|change| change.gain > self.least_gain(problem)) {
            Some(change) => {
                self.take(change);
                self.fit(problem);
                true
            }
            None => false,
        }
    }
}

/// Gives angles what is left on their floating components, as far as they have room. What is left on others is nobody's.
fn share_out(
    problem: &Problem,
    [low, high]: [&[f64]; 2],
    angles: &mut [f64],
    takers: &[u32],
    rest: &mut [f64],
) {
    for (c, rest) in rest.iter_mut().enumerate() {
        if !problem.system.components[c].is_floating {
            *rest = 0.0;
        }
        let own = takers.iter().map(|&i| i as usize);
        let own = own.filter(|&i| problem.system.component_of[i] as usize == c);
        let bounds = if *rest > 0.0 { high } else { low };
        let rooms: Vec<(usize, f64)> = own.map(|i| (i, (bounds[i] - angles[i]).abs())).collect();
        let whole: f64 = rooms.iter().map(|room| room.1).sum();
        if whole > 0.0 {
            let share = rest.signum() * (rest.abs() / whole).min(1.0);
            for (i, room) in rooms {
                angles[i] += share * room;
                *rest -= share * room;
            }
        }
    }
}

/// Lets the angles at all places free but those that are held.
fn release(set: &mut ActiveSet, places: &BTreeSet<u32>, held: &BTreeSet<u32>) {
    set.order.clear();
    for &i in places.difference(held) {
        set.release(i, 1.0);
    }
}

/// What cones inside have to do on a connected part.
struct Part {
    /// What they add up to besides those that are prescribed and the corners; 0 where anything is allowed.
    rest: f64,
    /// The fewest that can.
    needed: usize,
    /// Largest size of one of them on that side.
    bound: f64,
    /// Where they may be.
    members: Vec<usize>,
}

fn parts(flow: &ConeFlow) -> Vec<Part> {
    let (problem, fields) = (&flow.problem, &flow.fields);
    let system = &problem.system;
    let open = open_dofs(problem, fields);
    let part = |(c, component): (usize, &super::system::Component)| {
        let own = (0..system.len()).filter(|&i| system.component_of[i] as usize == c);
        let corners = own.clone().filter(|&i| !problem.is_inside[i]);
        let corners: f64 = corners.map(|i| flow.progress.set.angles[i]).sum();
        let dof = |v: VertexId| system.dof_of[v.index()] as usize;
        let fixed = fields.fixed.iter().filter(|(v, _)| system.component_of[dof(*v)] as usize == c);
        let rest = component.total - corners - fixed.map(|fixed| fixed.1).sum::<f64>();
        let members: Vec<usize> = own.filter(|&i| open[i]).collect();
        if !component.is_floating || rest.abs() < NOTHING {
            return Part { rest: 0.0, needed: 0, bound: 0.0, members };
        }
        let bound = |i: usize| {
            let [least, most] = usual(problem, i);
            if rest > 0.0 { most } else { -least }
        };
        let bound = members.iter().fold(0.0, |m: f64, &i| m.max(bound(i)));
        let needed = (rest.abs() / bound.max(f64::MIN_POSITIVE) - NOTHING).ceil();
        Part { rest, needed: needed as usize, bound, members }
    };
    system.components.iter().enumerate().map(part).collect()
}

/// Bounds of a cone that may be anything within those of the flow.
fn usual(problem: &Problem, i: usize) -> [f64; 2] {
    let [least, most] = [problem.low[i], problem.high[i]];
    [
        if least > -FREE_BOUND { least } else { -USUAL },
        if most < FREE_BOUND { most.min(MOST) } else { USUAL },
    ]
}

/// Equal cones far from one another (in steps from vertex to vertex), as few as are needed, and those by hand.
fn spread_evenly(flow: &ConeFlow, parts: &[Part]) -> Vec<Cone> {
    let (system, fields) = (&flow.problem.system, &flow.fields);
    let mut cones: Vec<Cone> =
        fields.fixed.iter().map(|&(vertex, angle)| Cone { vertex, angle }).collect();
    cones.extend(fields.free.iter().map(|&vertex| Cone { vertex, angle: 0.0 }));
    for part in parts.iter().filter(|part| part.needed > 0) {
        let is_taken = |i: usize| fields.free.contains(&VertexId(system.dofs[i]));
        let members: Vec<usize> = part.members.iter().copied().filter(|&i| !is_taken(i)).collect();
        let Some(&first) = members.first() else { continue };
        let mut steps = vec![u32::MAX; system.len()];
        let mut next = first;
        for trial in 0..=part.needed {
            // The first vertex only leads to one that is far.
            if trial > 0 {
                let vertex = VertexId(system.dofs[next]);
                cones.push(Cone { vertex, angle: part.rest / part.needed as f64 });
            }
            let mut queue = std::collections::VecDeque::from([next]);
            steps[next] = 0;
            while let Some(i) = queue.pop_front() {
                let ring = system.starts[i] as usize..system.starts[i + 1] as usize;
                for &j in &system.neighbours[ring] {
                    if steps[i] + 1 < steps[j as usize] {
                        steps[j as usize] = steps[i] + 1;
                        queue.push_back(j as usize);
                    }
                }
            }
            let reached = |i: usize| if steps[i] == u32::MAX { 0 } else { steps[i] };
            next = members.iter().copied().max_by_key(|&i| reached(i)).unwrap_or(next);
            if trial == 0 {
                steps.fill(u32::MAX);
            }
        }
    }
    cones
}

/// For every dof whether a cone may come to be there.
fn open_dofs(problem: &Problem, fields: &ConeFields) -> Vec<bool> {
    let is_open = |(i, &v): (usize, &u32)| {
        problem.is_inside[i]
            && fields.excluded.get(v as usize) != Some(&true)
            && fields.fixed.iter().all(|(fixed, _)| fixed.0 != v)
            && (problem.low[i] < 0.0 || problem.high[i] > 0.0)
    };
    problem.system.dofs.iter().enumerate().map(is_open).collect()
}
