//! What a refinement shows: places, energy, how equal seams are.

use nalgebra::{Complex, Point2};

use crate::mesh::VertexId;

/// The energy of places and its terms, weights included, without unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IsometricEnergy {
    /// Sum of the terms.
    pub total: f64,
    /// Mean of the distortion over the area: 0 for isometric charts.
    pub distortion: f64,
    /// Of seams: springs and multipliers, less what keeps it continuous where multipliers change. May be negative.
    pub seam: f64,
    /// Of pins that are not where they are pulled to.
    pub pins: f64,
}

/// Refined charts.
#[derive(Clone, Debug, PartialEq)]
pub struct IsometricState {
    pub(super) places: Vec<Complex<f64>>,
    pub(super) energy: IsometricEnergy,
    pub(super) seam_difference: f64,
    pub(super) pin_distance: f64,
    pub(super) step_length: f64,
    pub(super) contacts: usize,
}

impl IsometricState {
    /// Place of a vertex in its chart.
    pub fn place(&self, v: VertexId) -> Point2<f64> {
        let z = self.places[v.index()];
        Point2::new(z.re, z.im)
    }

    /// The energy and its terms.
    pub fn energy(&self) -> IsometricEnergy {
        self.energy
    }

    /// Largest |a − b| / ½ (a + b) over seam partners of lengths a, b in the charts.
    pub fn seam_difference(&self) -> f64 {
        self.seam_difference
    }

    /// Largest distance of a pinned vertex from where it is pulled to, in units of the model.
    pub fn pin_distance(&self) -> f64 {
        self.pin_distance
    }

    /// Length of the last accepted step; 1 is Newton's.
    pub fn step_length(&self) -> f64 {
        self.step_length
    }
    /// Number of rim vertices that are held because they have met a rim.
    pub fn contacts(&self) -> usize {
        self.contacts
    }
}
