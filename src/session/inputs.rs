//! What a flow starts from and reads: parameters and what was painted, put together for one surface.

use std::rc::Rc;

use nalgebra::{Point3, Vector3};

use super::params::Settings;
use super::regions::FaceSource;
use super::surface::Surface;
use super::symmetric::{Kept, KeptByPatches};
use super::text::Problem;
use crate::mesh::VertexId;
use crate::methods::cutflow::{CutFields, Initial, Source};

/// What a person put on the surface by hand. Empty lists are empty layers.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    /// A label for each vertex.
    pub regions: Rc<Vec<u32>>,
    /// Centres of cells.
    pub seeds: Rc<Vec<VertexId>>,
    /// How unwelcome the cut is at each vertex, from 0 to 1.
    pub penalty: Rc<Vec<f64>>,
    /// How much heat there is at each vertex beyond the common one, from 0 to 1.
    pub heat: Rc<Vec<f64>>,
    /// How firmly each vertex holds the cut, from 0 to 1.
    pub pin: Rc<Vec<f64>>,
    /// How important distortion is at each vertex beyond the common measure, from 0 to 1.
    pub importance: Rc<Vec<f64>>,
    /// How little distortion counts at each vertex, from 0 to 1.
    pub unimportant: Rc<Vec<f64>>,
    /// How unwelcome cones are at each vertex, from 0 to 1.
    pub cone_cost: Rc<Vec<f64>>,
    /// Where cones are forbidden, from one half.
    pub excluded: Rc<Vec<f64>>,
    /// Where seams of developable patches stay, from one half.
    pub seams: Rc<Vec<f64>>,
    /// Where seams of developable patches are drawn, from one half.
    pub drawn: Rc<Vec<f64>>,
    /// Labels of a cut that was brought along.
    pub brought: Rc<Vec<u32>>,
    /// The pieces of another method.
    pub handed: Option<Rc<Initial>>,
    /// Symmetries that the cut keeps.
    pub symmetry: Rc<Kept>,
    /// The symmetry that developable patches keep.
    pub patch_symmetry: Rc<KeptByPatches>,
}

/// The initial cut that parameters and layers ask for.
pub fn initial(
    settings: &Settings,
    layers: &Layers,
    surface: &Surface,
) -> Result<Initial, Problem> {
    let count = |id: &str| small(settings.number(id));
    Ok(match settings.text("init") {
        "plane" => plane(settings, surface),
        "circle" => {
            let wanted = settings.number("vertex");
            let Some(vertex) = surface.mesh_vertex_from(small(wanted) as usize) else {
                let count = surface.soup.positions.len();
                return Err(Problem::new(
                    format!("There is no vertex {wanted}: the mesh has {count}."),
                    "Centre vertex of the initial circle.",
                    format!("Choose a number from 0 to {}.", count - 1),
                ));
            };
            Initial::Circle { vertex, radius: settings.number("radius") }
        }
        "curvature" => Initial::CurvatureLevels { regions: count("regions") },
        "random" => Initial::Random {
            // More labels than cells say the same as one for each.
            regions: count("regions").min(count("cells")),
            cells: count("cells"),
            seed: u64::from(count("seed")),
        },
        "seeds" if layers.seeds.is_empty() => {
            return Err(nothing_painted(
                "there are no seeds yet",
                "Choose Brush, Seeds, and click on the surface.",
            ));
        }
        "seeds" => Initial::Seeds(layers.seeds.to_vec()),
        "painted" if layers.regions.is_empty() => {
            let advice = "Choose Brush, Regions, and paint on the surface.";
            return Err(nothing_painted("no regions are painted yet", advice));
        }
        "painted" => Initial::Labels(layers.regions.to_vec()),
        "file" if layers.brought.is_empty() => {
            return Err(nothing_painted(
                "no other cut was opened yet",
                "Open a cut.json that was written for this mesh.",
            ));
        }
        "file" => Initial::Labels(layers.brought.to_vec()),
        "handed" => match &layers.handed {
            Some(initial) => (**initial).clone(),
            None => {
                return Err(nothing_painted(
                    "no other method has made pieces yet",
                    "Choose Phase field or Developable patches, run it, and press Improve by the cut flow.",
                ));
            }
        },
        "uv" => of_faces(surface, FaceSource::UvIslands)?,
        "groups" => of_faces(surface, FaceSource::Groups)?,
        "materials" => of_faces(surface, FaceSource::Materials)?,
        "volleyball" => Initial::Volleyball { axes: [Vector3::x(), Vector3::y(), Vector3::z()] },
        _ => Initial::NormalClusters {
            angle: settings.number("angle").to_radians(),
            regions: count("regions"),
        },
    })
}

/// Sources, penalties and pins.
pub fn fields(settings: &Settings, layers: &Layers, vertex_count: usize) -> CutFields {
    let source = match settings.text("source") {
        "uniform" => Source::Uniform,
        "heat" => {
            let factor = settings.number("heat");
            let at = |v: usize| 1.0 + (factor - 1.0) * layers.heat.get(v).copied().unwrap_or(0.0);
            Source::Heat((0..vertex_count).map(at).collect())
        }
        _ => Source::Curvature,
    };
    CutFields {
        source,
        penalty: layers.penalty.to_vec(),
        pins: layers.pin.to_vec(),
        symmetry: layers.symmetry.maps.clone(),
    }
}

fn of_faces(surface: &Surface, source: FaceSource) -> Result<Initial, Problem> {
    Ok(surface.initial_of_faces(surface.face_regions(source)?)?.0)
}

fn plane(settings: &Settings, surface: &Surface) -> Initial {
    let (mesh, geometry) = surface.solving();
    let axis = match settings.text("axis") {
        "x" => 0,
        "y" => 1,
        _ => 2,
    };
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
        let x = geometry.positions[v.index()][axis];
        low = low.min(x);
        high = high.max(x);
    }
    let mut point = Point3::origin();
    point[axis] = low + (high - low) * (0.5 + settings.number("offset") / 100.0);
    let mut normal = Vector3::zeros();
    normal[axis] = 1.0;
    Initial::Plane { point, normal }
}

fn nothing_painted(what: &str, advice: &str) -> Problem {
    Problem::new(format!("Nothing to start from: {what}."), "Initial cut.", advice)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers that count are whole and within 32 bits by their ranges"
)]
fn small(x: f64) -> u32 {
    x as u32
}
