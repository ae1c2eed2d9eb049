//! Work that advances one bounded step at a time.

use super::cones::ConeError;
use crate::linalg::LinalgError;
use crate::mesh::{FaceId, MeshError, VertexId};

/// Work that advances one bounded step at a time. The driver (page, terminal, test) differs only in when it stops.
///
/// Every flow is *bounded* (a step is one outer iteration), *atomic* (after `Err` or a rejected trial the state is the last
/// accepted one), *quiet at its end* (stepping an ended flow changes nothing), *deterministic* (same input, parameters,
/// seed: same bits), *descending* in the first entry of [`StepReport::energy`], and *splittable* by its checkpoint.
pub trait Flow {
    /// Always complete, always drawable.
    type State;
    /// The last accepted state.
    fn state(&self) -> &Self::State;
    /// One bounded step.
    fn step(&mut self) -> Result<StepReport, SolveError>;
}

/// What one step did.
#[derive(Clone, Debug, PartialEq)]
pub struct StepReport {
    /// Number of accepted steps so far.
    pub step: usize,
    /// The objective first, then its terms.
    pub energy: Vec<(&'static str, f64)>,
    /// Relative residual of the linear solves behind the state.
    pub residual: f64,
    /// Fraction done, where it can be told.
    pub progress: Option<f32>,
    /// Whether there is more to do.
    pub status: Status,
}

/// How a flow stands. Everything but `Running` is an end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A further step may change the state.
    Running,
    /// Nothing left to gain within tolerance.
    Converged,
    /// No acceptable step could be found.
    Stalled,
    /// The number of steps asked for is done.
    StepLimit,
    /// The problem has no solution as it was posed.
    Infeasible,
}

/// Why a solve could not be done at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A factorisation failed.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
    /// Connectivity that the method cannot work on.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The initial cut separates nothing.
    #[error("the initial cut is empty: all {vertices} vertices lie on the same side")]
    EmptyCut {
        /// Number of vertices of the surface.
        vertices: usize,
    },
    /// A vertex that is not there, or that no face has.
    #[error("there is no vertex {} among {vertices}", .vertex.0)]
    NoSuchVertex {
        /// What was asked for.
        vertex: VertexId,
        /// Number of vertices of the surface.
        vertices: usize,
    },
    /// Two seeds at one vertex.
    #[error("vertex {} is a seed twice", .vertex.0)]
    SeedTwice {
        /// The vertex.
        vertex: VertexId,
    },
    /// A parameter out of its range.
    #[error("{name} is {value}; it must lie between {min} and {max}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// What was given.
        value: f64,
        /// Smallest allowed value.
        min: f64,
        /// Largest allowed value.
        max: f64,
    },
    /// Both distortion weights are zero, so that nothing opposes the length term.
    #[error("both distortion weights are 0")]
    NoEnergy,
    /// Distortion is to count in the first region only, and there is none.
    #[error("there is no first region")]
    NoFirstRegion,
    /// The mean of the initial cut over the symmetries is no cut.
    #[error("the initial cut has no symmetric part")]
    NotSymmetric,
    /// A surface that is heated nowhere has no temperature to even out.
    #[error("the heat source is 0 everywhere")]
    NoSource,
    /// Something about cones.
    #[error(transparent)]
    Cones(#[from] ConeError),
    /// A patch that was accepted is not what it was said to be when it is flattened anew.
    #[error("the patch of face {} does not pass when it is flattened anew", .face.0)]
    PatchCheck {
        /// Its first face.
        face: FaceId,
    },
    /// The iteration left the range of numbers.
    #[error("the energy is not finite")]
    NotFinite,
}

impl SolveError {
    /// Checks a parameter against its range; NaN is in none.
    pub fn within(name: &'static str, value: f64, min: f64, max: f64) -> Result<(), Self> {
        if value >= min && value <= max {
            Ok(())
        } else {
            Err(Self::Parameter { name, value, min, max })
        }
    }
}
