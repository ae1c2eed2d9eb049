//! The line search: steps that lower the energy, turn no triangle over and, if asked for, do not make rims cross.

use nalgebra::{Complex, Point2};

use super::{IsometricFlow, along};
use crate::flatten::overlap::{Side, crossings};
use crate::mesh::HalfedgeId;

/// How far a step may go on the way to the first triangle without area.
const CAP: f64 = 0.9;

/// Trials of one line search: a millionth of a step is none.
const TRIALS: usize = 20;

/// Decrease that a trial must reach, as a fraction of what the slope promises.
const ARMIJO: f64 = 1e-4;

/// Halvings of a step that would make rims cross before the vertices there are held instead: so near rims come to each other.
const CLOSER: usize = 2;

/// What a line search found.
pub(super) enum Search {
    Moved,
    /// Nothing lower: rounding hides what is left.
    Nothing,
    /// Lower, but only with rims that cross: their vertices are held from now on.
    Touched,
    /// Lower, but only with rims that cross, and holding their vertices did not help.
    Blocked,
}

impl IsometricFlow {
    /// Crossings of each chart's outline with itself: pairs of sides.
    fn rim_crossings(&self, x: &[Complex<f64>]) -> Vec<Vec<[Side; 2]>> {
        let place = |h: &HalfedgeId| {
            let z = x[self.opened.mesh.tail(*h).index()];
            Point2::new(z.re, z.im)
        };
        self.charts
            .iter()
            .zip(&self.starts)
            .map(|(rim, start)| match rim {
                Ok(rim) if start.is_refined() => {
                    let outline: Vec<_> = rim.iter().map(place).collect();
                    crossings(&[&outline])
                }
                _ => Vec::new(),
            })
            .collect()
    }

    /// Rim vertices that have to be held lest charts cross themselves more often: the ends of sides that cross anew there.
    fn new_contacts(&self, before: &[Vec<[Side; 2]>], now: &[Vec<[Side; 2]>]) -> Vec<u32> {
        let mut contacts = Vec::new();
        for (patch, rim) in self.charts.iter().enumerate() {
            let Ok(rim) = rim else { continue };
            if now[patch].len() <= before[patch].len() {
                continue;
            }
            for pair in now[patch].iter().filter(|p| before[patch].binary_search(p).is_err()) {
                for side in pair {
                    let h = rim[side.side as usize];
                    contacts.extend([self.opened.mesh.tail(h).0, self.opened.mesh.tip(h).0]);
                }
            }
        }
        contacts
    }

    /// Looks for a place along a direction that is lower, upright and, if asked for, does not cross.
    pub(super) fn search(&mut self, d: &[Complex<f64>], slope: f64) -> Search {
        // Not `>=`: a slope that is no number is none.
        if !(slope < 0.0) {
            return Search::Nothing;
        }
        let before = self.state.energy.total;
        let mut length = (CAP * self.model.largest_step(&self.state.places, d)).min(1.0);
        let mut known = None;
        let mut blocked = 0;
        for _ in 0..TRIALS {
            let x = along(&self.state.places, d, length);
            let energy = self.model.energy(&x, &self.forces);
            let is_lower =
                energy.total < before && energy.total <= before + ARMIJO * length * slope;
            if is_lower && self.model.is_upright(&x) {
                let contacts = if self.params.guard_rims {
                    let known = known.get_or_insert_with(|| self.rim_crossings(&self.state.places));
                    self.new_contacts(known, &self.rim_crossings(&x))
                } else {
                    Vec::new()
                };
                if contacts.is_empty() {
                    self.state.places = x;
                    self.state.step_length = length;
                    self.measure();
                    return Search::Moved;
                }
                blocked += 1;
                if blocked > CLOSER && self.touch(contacts) {
                    return Search::Touched;
                }
            }
            length *= 0.5;
        }
        if blocked > 0 { Search::Blocked } else { Search::Nothing }
    }

    /// Holds more vertices. **Gives** whether there were any that were not held yet.
    fn touch(&mut self, contacts: Vec<u32>) -> bool {
        let touching = &mut self.forces.touching;
        let known = touching.len();
        touching.extend(contacts);
        touching.sort_unstable();
        touching.dedup();
        self.state.contacts = touching.len();
        touching.len() > known
    }
}
