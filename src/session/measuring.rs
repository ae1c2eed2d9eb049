//! How far two places of the surface are from each other.

use nalgebra::{Point3, Vector3};

use super::message::{Event, Spot};
use super::surface::Surface;
use super::text::Problem;
use super::{Session, nothing_open};
use crate::geometry::{closest, shortest_path};
use crate::mesh::FaceId;

impl Session {
    pub(super) fn measure(
        &self,
        from: Spot,
        to: Spot,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let surface = work.document.surface()?;
        if self.is_folded() {
            return Err(Problem::new(
                "The fold preview cannot be measured.",
                format!("{}, measuring.", surface.name),
                "End the preview, then measure on the surface itself.",
            ));
        }
        let [from, to] = [point(surface, from)?, point(surface, to)?];
        let mm = work.mm_per_unit();
        // Scenes have radius 1.
        let scale = surface.radius();
        let path = shortest_path(&surface.mesh, &surface.geometry, from.on_face(), to.on_face());
        events.push(Event::Measured {
            straight_mm: (to.place - from.place).norm() * mm,
            along_mm: path.as_ref().map(|path| path.length * mm),
            path: path.map_or_else(Vec::new, |path| {
                path.points.iter().map(|p| (p.coords / scale).into()).collect()
            }),
        });
        Ok(())
    }
}

struct OnSurface {
    face: FaceId,
    weights: [f64; 3],
    place: Point3<f64>,
}

impl OnSurface {
    fn on_face(&self) -> (FaceId, [f64; 3]) {
        (self.face, self.weights)
    }
}

/// The point of the spot's face that is nearest to its place.
fn point(surface: &Surface, spot: Spot) -> Result<OnSurface, Problem> {
    let face = spot.face as usize;
    if face >= surface.mesh.face_count() || !spot.place.iter().all(|x| x.is_finite()) {
        return Err(Problem::new(
            "There is no such place on the surface.",
            format!("{}, face {face}.", surface.name),
            "Point at the surface.",
        ));
    }
    let face = FaceId(spot.face);
    let corners = surface.mesh.face_vertices(face).map(|v| surface.geometry.positions[v.index()]);
    let place = Point3::from(Vector3::from(spot.place) * surface.radius());
    let (weights, place) = closest(&corners, place);
    Ok(OnSurface { face, weights, place })
}
