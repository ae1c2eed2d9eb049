//! What one step does: a round over Green's functions, a Newton step, or a step on the coarse surface.

use super::certificate::{Certificate, certify};
use super::coarse::Stage;
use super::extent::{self, Extent};
use super::flow::ConeFlow;
use super::greens;
use super::newton::{Descent, Outcome};
use super::params::ConeMethod;
use super::problem::ActiveSet;
use super::rounding::{RoundParams, round_clusters};
use super::system::Response;
use super::two_ring::TwoRing;
use crate::methods::flow::{SolveError, Status};

/// Excess of |φ| over λ w, in λ, that is none. Rounding in φ is about 1e-13 of its size, and φ is of the size of λ_max.
const TOLERANCE: f64 = 1e-10;

/// Residual above which a finished optimum is polished further, as long as that helps.
const POLISHED: f64 = 1e-10;

/// Rounding of φ, as a fraction of its size, which is that of λ_max.
const ROUNDING: f64 = 1e-14;

/// Residual of an optimum. Rounding leaves 1e-13 to 1e-10; a wrong vertex in the support leaves 1e-5.
const GOOD: f64 = 1e-8;

/// Angles let free in one round: at least so many, and a share of those that are free already. With fewer there are more rounds,
/// with more there are columns that nobody needs.
const FEWEST_NEW: usize = 6;

/// Green's functions computed in one step: what keeps a step short.
const MOST_COLUMNS: usize = 64;

impl ConeFlow {
    /// Excess that is rounding.
    pub(super) fn tolerance(&self) -> f64 {
        TOLERANCE * self.problem.params.lambda + ROUNDING * self.lambda_max()
    }

    /// Residual that an optimum may have: with a price far below λ_max, rounding of φ is no longer small against it.
    pub(super) fn good(&self) -> f64 {
        GOOD.max(100.0 * self.tolerance() / self.problem.params.lambda)
    }

    /// One round over Green's functions.
    pub(super) fn greens_round(&mut self) -> Result<(), SolveError> {
        let tolerance = self.tolerance();
        let mut set = self.progress.set.clone();
        let phi = greens::shifted(&self.problem, &set, &self.response);
        let free = set.order.len();
        if self.progress.is_settled {
            let limit = if self.progress.is_stuck { 1 } else { FEWEST_NEW.max(free / 2) };
            let entering = greens::entering(&self.problem, &set, &phi, tolerance, limit);
            if entering.is_empty() {
                return self.polish();
            }
            for (i, sign) in entering {
                set.release(i, sign);
            }
        }
        let entered = set.order.len() - free;
        let missing = self.dictionary.missing(&set.order);
        self.progress.columns += missing.len().min(MOST_COLUMNS);
        if missing.len() > MOST_COLUMNS {
            // The rest in further steps: the angles stay as they are.
            self.dictionary.add(&mut self.problem, &missing[..MOST_COLUMNS]);
            return Ok(());
        }
        self.dictionary.add(&mut self.problem, &missing);
        let settled = greens::settle(&self.problem, &self.dictionary, &mut set, &phi, tolerance);
        let (response, certificate, is_refined) = self.problem.reassess(&set, &self.response);
        if !certificate.objective.is_finite() {
            return Err(SolveError::NotFinite);
        }
        let is_still = settled.moved == 0.0;
        if is_still && entered == 1 {
            // The one angle whose direction is certain did not move: rounding.
            return self.polish();
        }
        self.progress.is_stuck = is_still && entered > 1;
        self.progress.is_settled = settled.is_done;
        self.accept(set, response, certificate);
        self.progress.is_refined = is_refined;
        Ok(())
    }

    /// One step on the coarse surface; at its end its cones are where to begin, if they are better than what there is.
    pub(super) fn coarse_step(&mut self) -> Result<(), SolveError> {
        let Some(coarse) = &mut self.coarse else { return Ok(()) };
        let stage = coarse.step(&self.mesh, &self.geometry, &self.problem, &self.fields)?;
        if let Stage::Over(start) = stage {
            self.coarse = None;
            self.progress.is_fine = true;
            if let Some(set) = start {
                let (response, certificate) = self.problem.assess(&set);
                if certificate.objective < self.certificate.objective {
                    self.progress.is_warm = true;
                    self.progress.is_settled = set.order.is_empty();
                    self.accept(set, response, certificate);
                }
            }
        }
        Ok(())
    }

    pub(super) fn accept(&mut self, set: ActiveSet, response: Response, certificate: Certificate) {
        self.progress.set = set;
        self.progress.is_refined = false;
        self.response = response;
        self.certificate = certificate;
    }

    /// Whether Newton's method is predicted to be faster from here.
    ///
    /// Solves move data, factorisations compute: an entry of a factor takes about as long in a solve as 16 operations in a factorisation.
    /// How many cones there will be is not known, so Green's functions go on until they have cost what Newton's method
    /// would: at worst the two together cost twice the better one.
    pub(super) fn prefers_newton(&self) -> bool {
        match self.problem.params.method {
            _ if self.progress.is_lost => return false,
            ConeMethod::Greens => return false,
            ConeMethod::Newton => return true,
            ConeMethod::Auto => {}
        }
        let n = self.problem.system.len() as f64;
        let (entries, solves) = self.problem.system.factor_size();
        let entries = entries as f64;
        // The factor of the two-ring matrix has about four times the entries of L's, and entries² / n · 2 operations.
        let (large, small) =
            if solves == 1 { (entries, entries) } else { (4.0 * entries, entries) };
        let factorisations = if self.progress.is_warm { 8.0 } else { 18.0 };
        let newton = factorisations * 2.0 * large * large / n;
        let missing = self.dictionary.missing(&self.progress.set.order).len();
        let columns = (self.progress.columns + missing) as f64;
        let free = self.progress.set.order.len() as f64;
        // A column is solves; with it come about four moves of the dense problem.
        let greens = columns * (64.0 * solves as f64 * small + 8.0 * free * free);
        greens > newton
    }

    pub(super) fn newton_round(&mut self) -> Result<(), SolveError> {
        if self.two_ring.is_none() {
            self.two_ring = Some(match self.problem.system.two_ring() {
                Some(own) => own.sibling(),
                None => TwoRing::new(&self.problem.system)?,
            });
        }
        let Some(two_ring) = &mut self.two_ring else { return Ok(()) };
        let progress = &mut self.progress;
        if progress.descent.is_none() {
            let phi = greens::shifted(&self.problem, &progress.set, &self.response);
            progress.is_warm |= progress.columns > 0;
            progress.descent = Some(if progress.is_warm {
                Descent::warm(phi, progress.set.clone())
            } else {
                Descent::cold(phi)
            });
        }
        let Some(descent) = &mut progress.descent else { return Ok(()) };
        let mut trial = descent.clone();
        match trial.step(&mut self.problem, two_ring)? {
            Outcome::Guess(mut set) => {
                *descent = trial;
                if self.problem.repair(&mut set) {
                    let (response, certificate) = self.problem.assess(&set);
                    if certificate.objective < self.certificate.objective {
                        self.accept(set, response, certificate);
                    }
                }
            }
            Outcome::Optimum(set) => {
                progress.descent = None;
                let response = self.problem.exact_response(&set.angles, &self.response);
                let certificate = certify(&mut self.problem, &set, &response);
                self.accept(set, response, certificate);
                self.progress.is_refined = true;
                self.progress.is_settled = true;
                if certificate.residual() < self.good() {
                    self.progress.status = Status::Converged;
                } else {
                    self.progress.is_lost = true;
                }
            }
            Outcome::Lost => {
                // From the beginning, or else by Green's functions, which cannot go in circles.
                progress.descent = None;
                progress.is_lost = !progress.is_warm;
                progress.is_warm = false;
                progress.columns = 0;
                progress.is_settled = progress.set.order.is_empty();
            }
        }
        Ok(())
    }

    /// Nothing is left to be let free: refine, and end if that changes nothing.
    pub(super) fn polish(&mut self) -> Result<(), SolveError> {
        if !self.progress.is_refined {
            let set = &self.progress.set;
            (self.response, self.certificate, _) = self.problem.reassess(set, &self.response);
            self.progress.is_refined = true;
            if self.certificate.violation > TOLERANCE && self.progress.polished < 3 {
                self.progress.polished += 1;
                return Ok(());
            }
        }
        if self.certificate.support > POLISHED && self.progress.polished < 3 {
            self.progress.polished += 1;
            self.progress.is_settled = false;
            return Ok(());
        }
        self.progress.status = if self.certificate.residual() < self.good() {
            Status::Converged
        } else {
            Status::Stalled
        };
        Ok(())
    }

    /// How many cones are left when clusters are merged.
    fn merged_count(&self) -> usize {
        let params = RoundParams { bounds: self.problem.params.bounds, ..RoundParams::default() };
        round_clusters(&self.mesh, &self.geometry, &self.state.cones, &params).cones.len()
    }

    /// Learns λ_max from an optimum, and goes on to the next λ of a search.
    pub(super) fn conclude(&mut self) {
        self.progress.is_warm = true;
        let set = &self.progress.set;
        let phi = greens::shifted(&self.problem, set, &self.response);
        let told = extent::from_optimum(&self.problem, set, &phi);
        for (old, new) in self.lambda_max.iter_mut().zip(told) {
            *old = new.map_or(*old, |value| Extent { value, is_exact: true });
        }
        let most = self.lambda_max().max(f64::MIN_POSITIVE);
        if let Some(mut search) = self.progress.search.take() {
            let cones = match search.is_merged() {
                true => self.merged_count(),
                false => self.state.cones.len(),
            };
            // Above λ_max nothing changes (at it the last cone is there still, of no angle); below a thousandth of it every vertex is
            // about to become a cone.
            let next = search.next(&self.state, cones, [1e-3 * most, 1.001 * most]);
            match next {
                Some(lambda) => {
                    self.progress.search = Some(search);
                    self.change_lambda(lambda);
                }
                None if !search.is_reached => self.progress.status = Status::Infeasible,
                None => {}
            }
        }
    }
}
