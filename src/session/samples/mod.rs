//! Surfaces made by our own code, so that there is something to cut before a file is opened.
//!
//! Guaranteed of each sample: about 10 000 vertices, the same numbers each time, triangles without small angles,
//! faces that look outwards (upwards where there is no inside), one connected manifold without a repeated vertex.
//! The unit is the model's own; all fit a ball of radius 1.5 about the origin, upright along y.
//!
//! Formulas make the plain ones (`parametric`, `balls`, `sheets`); the others (`figures`) are level sets of functions
//! (`fields`), which are cut into triangles (`implicit`) that are then made even (`remesh`). All decisions about
//! connectivity are made by counting or from sums, products and roots, so that every target makes the same mesh; only
//! the vase compares lengths of points from sines. Not guaranteed: last bits of positions that come from sines.

mod balls;
mod fields;
mod figures;
mod grids;
mod implicit;
mod parametric;
mod remesh;
mod sheets;
#[cfg(test)]
mod tests;

use crate::mesh::Soup;

pub use parametric::icosphere;

/// One entry of the list that a person chooses from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Stable identifier, the argument of [`generate`].
    pub name: &'static str,
    /// What the list says.
    pub label: &'static str,
    /// One line: what it is good for.
    pub description: &'static str,
}

/// All samples, in the order of the list: from the plain to the rich.
pub const SAMPLES: &[Sample] = &[
    Sample {
        name: "ball",
        label: "Ball",
        description: "A unit sphere: curved the same everywhere, the classic that cannot be flattened.",
    },
    Sample {
        name: "tennis_ball",
        label: "Tennis ball",
        description: "A sphere with the symmetry of the tennis-ball seam: one closed cut into two equal pieces.",
    },
    Sample {
        name: "volleyball",
        label: "Volleyball",
        description: "A sphere with the symmetry of a cube: for starts with many regions, six sides of three panels.",
    },
    Sample {
        name: "rounded_box",
        label: "Rounded box",
        description: "A box with rounded edges: flat sides, curvature along the edges and in eight corners.",
    },
    Sample {
        name: "torus",
        label: "Torus",
        description: "A ring: one handle, curved outwards outside and saddle-shaped inside.",
    },
    Sample {
        name: "double_torus",
        label: "Double torus",
        description: "Two rings grown together: two handles, for cuts that must open a surface into a disk.",
    },
    Sample {
        name: "wavy_vase",
        label: "Wavy vase",
        description: "A fluted vase with an open rim: one boundary, bumps and saddles side by side.",
    },
    Sample {
        name: "sinusoidal_sheet",
        label: "Sinusoidal sheet",
        description: "A square of waves: hills and saddles in a regular pattern, where cones belong on the hilltops.",
    },
    Sample {
        name: "noisy_cylinder",
        label: "Noisy cylinder",
        description: "An uneven tube, open at both ends: nearly developable, with dents where it is not.",
    },
    Sample {
        name: "car_hood",
        label: "Car hood",
        description: "A panel with creases and a slotted scoop: paint its middle to keep cuts out of sight.",
    },
    Sample {
        name: "armchair",
        label: "Armchair",
        description: "An upholstered chair with a buttoned back: covers to sew, with seams in the grooves.",
    },
    Sample {
        name: "plush_bear",
        label: "Plush bear",
        description: "A bear that sits: head, ears, arms and legs for a sewing pattern of many pieces.",
    },
];

/// The sample of that name.
pub fn generate(name: &str) -> Option<Soup> {
    Some(match name {
        "ball" => icosphere(32),
        "tennis_ball" => balls::tennis_ball(39),
        "volleyball" => balls::volleyball(36),
        "rounded_box" => parametric::rounded_box(),
        "torus" => parametric::torus(142, 72),
        "double_torus" => figures::double_torus(),
        "wavy_vase" => parametric::wavy_vase(),
        "sinusoidal_sheet" => sheets::sinusoidal_sheet(),
        "noisy_cylinder" => sheets::noisy_cylinder(1),
        "car_hood" => figures::car_hood(),
        "armchair" => figures::armchair(),
        "plush_bear" => figures::plush_bear(),
        _ => return None,
    })
}
