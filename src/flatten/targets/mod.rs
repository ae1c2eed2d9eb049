//! Boundary first flattening [BFF] with a rim that is told what to be: lengths, angles, a disk, a rectangle, a polygon.
//!
//! A log scale factor u on a disk with angle defects Ω inside and exterior angles k along its rim becomes flat if
//!
//! A u = (−Ω, k̃ − k), Σ k̃ = 2π,
//!
//! k̃ being the exterior angles of the chart. So u on the rim gives k̃ (one Dirichlet problem), and k̃ gives u up to a constant (one Neumann
//! problem: one vertex is pinned, nothing is added to the matrix). Lengths l e^{(u_a + u_b) / 2} and angles k̃ draw the rim once lengths
//! are changed by the little that closes it, and two harmonic coordinates fill it in.
//!
//! Guaranteed: angles asked for are those of the rim, to rounding; a target that cannot be is an error with the number that is wrong.
//! Inside convex rims (disks, rectangles) faces that harmonic coordinates turn over are mended by positive weights.
//! What an inner edge between two vertices of one straight side cuts off is flat there whatever the weights.
//! Not guaranteed: freedom from flips and overlaps elsewhere, and where rounding decides. Seams keep equal lengths where the rim's scale factors are given and equal on both
//! sides of them, not where angles are: two charts that meet cannot both be rectangles.

mod rim;
mod solver;
mod sphere;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Point2;

use super::{Flattening, NoChart};
use crate::geometry::Geometry;
use crate::linalg::LinalgError;
use crate::mesh::{HalfedgeId, OpenedMesh, VertexId};
use solver::System;

pub use sphere::{SphereMap, flatten_sphere};

/// What the rim of a chart is to be. What is given for each rim vertex or side is in the order of [`TargetSolver::rim`].
#[derive(Clone, Debug, PartialEq)]
pub enum RimTarget {
    /// As long as on the surface: u = 0.
    Isometric,
    /// Scaled by u at each rim vertex.
    Scales(Vec<f64>),
    /// Sides of these lengths; side i follows vertex i.
    Lengths(Vec<f64>),
    /// Turned by this exterior angle at each rim vertex, radians; they add up to 2π. Scaled for least area distortion.
    Angles(Vec<f64>),
    /// Straight between corners with these exterior angles. Scaled for least area distortion.
    Polygon(Vec<(VertexId, f64)>),
    /// A rectangle with these four corners. Scaled for least area distortion.
    Rectangle(Vec<VertexId>),
    /// A circle. Scaled for least area distortion.
    Disk,
    /// Free, with the least area distortion: u is constant on the rim.
    Free,
}

/// How the interior follows from the rim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interior {
    /// Two harmonic coordinates: the rim is exactly what was drawn.
    #[default]
    Harmonic,
    /// One harmonic coordinate and its conjugate: conformal along the rim too, which gives way for that. Only where u was given.
    Conjugate,
}

/// Why there is no chart with such a rim.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// The patch has no chart at all.
    #[error(transparent)]
    NoChart(#[from] NoChart),
    /// As many numbers as rim vertices are needed.
    #[error("the rim has {needed} sides, but {given} numbers were given")]
    Count {
        /// How many there are.
        given: usize,
        /// How many there must be.
        needed: usize,
    },
    /// Exterior angles of a disk add up to one turn.
    #[error(
        "exterior angles add up to {given:.6} rad; a disk needs 2π: nearest are angles smaller by {shift:.6} at each of {count}"
    )]
    AngleSum {
        /// Their sum.
        given: f64,
        /// What to take from each of them for the nearest angles that add up to 2π.
        shift: f64,
        /// How many angles there are.
        count: usize,
    },
    /// No polygon turns back on itself.
    #[error("the exterior angle {angle:.6} at vertex {} must stay below π (3.141593)", .vertex.0)]
    AngleTooLarge {
        /// The rim vertex.
        vertex: VertexId,
        /// What was asked for.
        angle: f64,
    },
    /// A number of corners that the shape does not have.
    #[error("{given} corners were given; the shape needs {needed}")]
    Corners {
        /// How many there are.
        given: usize,
        /// How many there must be, at least.
        needed: usize,
    },
    /// A corner that is not on the rim, or named twice.
    #[error("vertex {} is no corner: it is not on the rim, or named twice", .vertex.0)]
    NoCorner {
        /// The vertex.
        vertex: VertexId,
    },
    /// Lengths are positive, scale factors finite.
    #[error("{value} at rim position {position} is no length or scale factor")]
    Value {
        /// Place in the list.
        position: usize,
        /// What was given.
        value: f64,
    },
    /// A conjugate coordinate follows from given scale factors only.
    #[error("a conjugate coordinate needs scale factors on the rim, not angles")]
    NoConjugate,
    /// Only closed surfaces without handles are spheres.
    #[error(
        "the surface is no sphere: Euler characteristic {euler} (2 is needed), {boundary_loops} boundary loops, {components} parts"
    )]
    NotASphere {
        /// V − E + F.
        euler: i64,
        /// Number of boundary loops.
        boundary_loops: usize,
        /// Number of connected components.
        components: usize,
    },
    /// Scale factors left the range of numbers.
    #[error("the scale factors that this rim needs are out of range")]
    NotFinite,
    /// A factorisation failed.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
}

/// What was spent so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Numeric factorisations, of A or of its interior block.
    pub factorisations: usize,
    /// Solves with one right-hand side.
    pub solves: usize,
}

/// One chart.
#[derive(Clone, Debug)]
pub struct TargetChart {
    /// For each of [`TargetSolver::vertices`] its place.
    pub places: Vec<Point2<f64>>,
    /// For each of them the log scale factor that was aimed at.
    pub u: Vec<f64>,
    /// For each rim vertex the exterior angle that was aimed at.
    pub exterior_angles: Vec<f64>,
    /// By how much closing the rim changed the length of a side most, as a log ratio. 0 for a disk.
    pub closing: f64,
    /// By how much closing the rim turned a side most, radians: 0 where angles were given.
    pub turned: f64,
    /// By how much exterior angles changed in the last round towards a circle, at most; 0 for other shapes.
    pub change: f64,
    /// Whether harmonic coordinates turned faces over, and weights of edges were raised against that: angles changed there.
    pub is_raised: bool,
    /// What it took from the beginning, factors that were there already left out.
    pub effort: Effort,
}

/// How often the exterior angles of a disk are made those of its lengths: each is a solve, and eight are allowed in all.
const ROUNDS: usize = 6;
/// The circle stands where angles change by less than this.
const STANDS: f64 = 1e-10;

/// Charts of one patch with any rim, from factors that are made once.
pub struct TargetSolver<'a> {
    opened: &'a OpenedMesh,
    geometry: &'a Geometry,
    patch: usize,
    system: System,
}

impl<'a> TargetSolver<'a> {
    /// **Takes** a patch of an opened surface that is a disk. **Fails** otherwise, and on faces without usable shape.
    /// **Costs** O(F): matrices are factored when they are needed.
    pub fn new(
        opened: &'a OpenedMesh,
        geometry: &'a Geometry,
        patch: usize,
    ) -> Result<Self, TargetError> {
        let rim = super::rims(opened).swap_remove(patch)?;
        let system = System::new(opened, geometry, patch, rim)?;
        Ok(Self { opened, geometry, patch, system })
    }

    /// The patch.
    pub fn patch(&self) -> usize {
        self.patch
    }

    /// The sides of the rim, counter-clockwise. Rim vertex i is the tail of side i.
    pub fn rim(&self) -> &[HalfedgeId] {
        &self.system.rim
    }

    /// The vertices of the patch, ascending.
    pub fn vertices(&self) -> &[VertexId] {
        &self.system.vertices
    }

    /// Flattens the patch.
    ///
    /// **Fails** on targets that cannot be, with the number that is wrong and the nearest that could.
    /// **Costs** two factorisations and at most eight solves, disks included, and no factorisation that was made before; where weights are raised, one
    /// factorisation and two solves for each of three tries at most, at every call.
    /// **From** [BFF] §4–6. **Differs**: rims close by least relative entropy, which keeps lengths positive and angles exact; the rim of a disk is a
    /// circle exactly.
    pub fn flatten(
        &mut self,
        target: &RimTarget,
        interior: Interior,
    ) -> Result<TargetChart, TargetError> {
        let before = self.system.effort;
        let n = self.rim().len();
        let zeros = || vec![0.0; n];
        let mut shape = match target {
            RimTarget::Isometric | RimTarget::Free => self.by_scales(&zeros(), None, false)?,
            RimTarget::Scales(u) => {
                self.check_values(u, |x| x.is_finite())?;
                self.by_scales(u, None, true)?
            }
            RimTarget::Lengths(lengths) => {
                self.check_values(lengths, |x| x > 0.0 && x.is_finite())?;
                self.by_scales(&self.system.scales_of(lengths), Some(lengths), false)?
            }
            RimTarget::Angles(angles) => {
                self.check_angles(angles)?;
                self.by_angles(angles)?
            }
            RimTarget::Polygon(corners) => {
                let angles = self.corners(corners)?;
                self.by_angles(&angles)?
            }
            RimTarget::Rectangle(corners) => {
                if corners.len() != 4 {
                    return Err(TargetError::Corners { given: corners.len(), needed: 4 });
                }
                let corners: Vec<_> = corners.iter().map(|&v| (v, FRAC_PI_2)).collect();
                let angles = self.corners(&corners)?;
                self.by_angles(&angles)?
            }
            RimTarget::Disk => self.disk()?,
        };
        let has_scales = matches!(
            target,
            RimTarget::Isometric | RimTarget::Scales(_) | RimTarget::Lengths(_) | RimTarget::Free
        );
        let mut is_raised = false;
        shape.places = match interior {
            Interior::Harmonic => {
                let (places, raised) = self.system.fill(&shape.rim)?;
                is_raised = raised;
                places
            }
            Interior::Conjugate if has_scales => self.system.fill_conjugate(&shape.rim)?,
            Interior::Conjugate => return Err(TargetError::NoConjugate),
        };
        let is_scaled =
            matches!(target, RimTarget::Isometric | RimTarget::Scales(_) | RimTarget::Lengths(_));
        if !is_scaled {
            self.rescale(&mut shape);
        }
        if !shape.places.iter().all(|p| p.x.is_finite() && p.y.is_finite()) {
            return Err(TargetError::NotFinite);
        }
        let effort = Effort {
            factorisations: self.system.effort.factorisations - before.factorisations,
            solves: self.system.effort.solves - before.solves,
        };
        Ok(TargetChart {
            places: shape.places,
            u: shape.u,
            exterior_angles: shape.angles,
            closing: shape.closing,
            turned: shape.turned,
            change: shape.change,
            is_raised,
            effort,
        })
    }

    /// Puts a chart in the place of the one that the patch has in a flattening.
    ///
    /// [`Flattening::seams_equal`] becomes false where a side is not as long as its partner (to 1e-10 of it), and
    /// [`Flattening::angles_exact`] for rims that are not scaled.
    pub fn put(&self, chart: &TargetChart, target: &RimTarget, flattening: &mut Flattening) {
        for (i, v) in self.vertices().iter().enumerate() {
            flattening.uv[v.index()] = chart.places[i];
            flattening.u[v.index()] = chart.u[i];
        }
        flattening.charts[self.patch] = Ok(self.rim().to_vec());
        let mesh = &self.opened.mesh;
        let length = |h: HalfedgeId| {
            let [a, b] = [mesh.tail(h), mesh.tip(h)].map(|v| flattening.uv[v.index()]);
            (b - a).norm()
        };
        let is_equal = |&h: &HalfedgeId| {
            self.opened.partner(h).is_none_or(|p| {
                let (own, other) = (length(h), length(p));
                other.is_nan() || (own - other).abs() <= 1e-10 * own.max(other)
            })
        };
        flattening.seams_equal &= self.rim().iter().all(is_equal);
        flattening.angles_exact &= matches!(target, RimTarget::Scales(_)) && chart.turned == 0.0;
    }

    fn by_scales(
        &mut self,
        rim_u: &[f64],
        lengths: Option<&[f64]>,
        keeps_angles: bool,
    ) -> Result<Shape, TargetError> {
        let (u, angles) = self.system.angles_of(rim_u)?;
        let own = self.system.scaled_lengths(&u);
        let lengths = lengths.unwrap_or(&own);
        let drawn =
            rim::draw_shared(self.opened, &self.system.rim, lengths, &angles, keeps_angles)?;
        let rim::Drawn { corners: rim, closing, turned } = drawn;
        Ok(Shape { rim, u, angles, closing, turned, ..Shape::default() })
    }

    fn by_angles(&mut self, angles: &[f64]) -> Result<Shape, TargetError> {
        let mut u = self.system.scales_for(angles)?;
        self.system.centre(&mut u);
        let lengths = self.system.scaled_lengths(&u);
        let (rim, closing) = rim::draw(&lengths, angles)?;
        Ok(Shape { rim, u, angles: angles.to_vec(), closing, ..Shape::default() })
    }

    fn disk(&mut self) -> Result<Shape, TargetError> {
        let mut angles = rim::circle_angles(&self.system.scaled_lengths(&self.system.zeros()));
        let mut mixer = rim::Mixer::default();
        for round in 1.. {
            let mut u = self.system.scales_for(&angles)?;
            self.system.centre(&mut u);
            let lengths = self.system.scaled_lengths(&u);
            let next = rim::circle_angles(&lengths);
            let differences = next.iter().zip(&angles).map(|(a, b)| (a - b).abs());
            let change = differences.fold(0.0, f64::max);
            if !change.is_finite() {
                return Err(TargetError::NotFinite);
            }
            if change < STANDS || round == ROUNDS {
                let rim = rim::circle(&lengths);
                return Ok(Shape { rim, u, angles, change, ..Shape::default() });
            }
            angles = mixer.mix(angles, next);
        }
        Err(TargetError::NotFinite)
    }

    /// Scales a chart so that the mean of its faces' log scales is 0: ∫u² is least.
    fn rescale(&self, shape: &mut Shape) {
        let (mut sum, mut weight) = (0.0, 0.0);
        for (f, corners) in self.system.triangles() {
            let [a, b, c] = corners.map(|v| shape.places[v as usize]);
            let area = 0.5 * (b - a).perp(&(c - a));
            let own = self.geometry.face_areas[f.index()];
            if area > 0.0 && own > 0.0 {
                sum += own * 0.5 * (area / own).ln();
                weight += own;
            }
        }
        let shift = if weight > 0.0 { sum / weight } else { 0.0 };
        shape.places.iter_mut().for_each(|p| *p *= (-shift).exp());
        shape.u.iter_mut().for_each(|u| *u -= shift);
    }

    fn check_values(
        &self,
        values: &[f64],
        is_fine: impl Fn(f64) -> bool,
    ) -> Result<(), TargetError> {
        let needed = self.rim().len();
        if values.len() != needed {
            return Err(TargetError::Count { given: values.len(), needed });
        }
        match values.iter().position(|&x| !is_fine(x)) {
            Some(position) => Err(TargetError::Value { position, value: values[position] }),
            None => Ok(()),
        }
    }

    fn check_angles(&self, angles: &[f64]) -> Result<(), TargetError> {
        self.check_values(angles, f64::is_finite)?;
        if let Some(i) = angles.iter().position(|&angle| angle >= PI) {
            let vertex = self.opened.mesh.tail(self.rim()[i]);
            return Err(TargetError::AngleTooLarge { vertex, angle: angles[i] });
        }
        check_sum(angles)
    }

    /// Exterior angles of all rim vertices from those of corners.
    fn corners(&self, corners: &[(VertexId, f64)]) -> Result<Vec<f64>, TargetError> {
        if corners.len() < 3 {
            return Err(TargetError::Corners { given: corners.len(), needed: 3 });
        }
        let mut angles = vec![0.0; self.rim().len()];
        let mut is_named = vec![false; angles.len()];
        for &(vertex, angle) in corners {
            let position = self.rim().iter().position(|&h| self.opened.mesh.tail(h) == vertex);
            match position.filter(|&i| !is_named[i]) {
                Some(i) => (angles[i], is_named[i]) = (angle, true),
                None => return Err(TargetError::NoCorner { vertex }),
            }
            if !(angle < PI) {
                return Err(TargetError::AngleTooLarge { vertex, angle });
            }
        }
        check_sum(&corners.iter().map(|c| c.1).collect::<Vec<_>>())?;
        Ok(angles)
    }
}

/// Angles may miss 2π by what rounding makes of their sum, which is then spread over all.
fn check_sum(angles: &[f64]) -> Result<(), TargetError> {
    let given: f64 = angles.iter().sum();
    let count = angles.len();
    if (given - TAU).abs() < 1e-9 * count as f64 {
        return Ok(());
    }
    Err(TargetError::AngleSum { given, shift: (given - TAU) / count as f64, count })
}

/// A chart in the making.
#[derive(Default)]
struct Shape {
    rim: Vec<Point2<f64>>,
    places: Vec<Point2<f64>>,
    u: Vec<f64>,
    angles: Vec<f64>,
    closing: f64,
    turned: f64,
    change: f64,
}
