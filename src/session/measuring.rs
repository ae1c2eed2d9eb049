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

#[cfg(test)]
mod tests {
    use super::super::message::Command;
    use super::*;

    fn opened(sample: &str) -> Session {
        let mut session = Session::new();
        session.handle(Command::OpenSample { name: sample.into() });
        session
    }

    /// The middle of a face, as the scene has it.
    fn middle(session: &Session, face: u32) -> Spot {
        let surface = session.work.as_ref().and_then(|work| work.document.surface.as_ref());
        let surface = surface.expect("a surface");
        let corners = surface.mesh.face_vertices(FaceId(face));
        let sum: Vector3<f64> =
            corners.iter().map(|v| surface.geometry.positions[v.index()].coords).sum();
        Spot { face, place: (sum / 3.0 / surface.radius()).into() }
    }

    fn measured(session: &mut Session, from: Spot, to: Spot) -> (f64, f64, Vec<[f64; 3]>) {
        match &session.handle(Command::Measure { from, to })[..] {
            [Event::Measured { straight_mm, along_mm: Some(along), path }] => {
                (*straight_mm, *along, path.clone())
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_ball_is_measured_along_great_circles_in_millimetres() {
        let mut session = opened("ball");
        let radius_mm = {
            let work = session.work.as_ref().expect("a mesh");
            let surface = work.document.surface.as_ref().expect("a surface");
            surface.radius() * work.mm_per_unit()
        };
        let faces = session.work.as_ref().and_then(|work| work.document.surface.as_ref());
        let faces = u32::try_from(faces.expect("a surface").mesh.face_count()).expect("few");
        for (a, b) in [(0, faces / 2), (3, faces - 1), (faces / 3, faces / 7)] {
            let [from, to] = [a, b].map(|face| middle(&session, face));
            let (straight, along, path) = measured(&mut session, from, to);
            let [p, q] = [from, to].map(|spot| Vector3::from(spot.place));
            assert!((straight / ((q - p).norm() * radius_mm) - 1.0).abs() < 1e-9);
            let circle = p.cross(&q).norm().atan2(p.dot(&q)) * radius_mm;
            // The sample's facets lie inside the ball by less than a hundredth.
            assert!((along / circle - 1.0).abs() < 0.01, "{along} for {circle}");
            assert!((Vector3::from(path[0]) - p).norm() < 1e-6);
            assert!(path.iter().all(|p| (Vector3::from(*p).norm() - 1.0).abs() < 0.02));
        }
    }

    #[test]
    fn what_is_measured_is_no_part_of_the_document() {
        let mut session = opened("ball");
        let [from, to] = [0, 9].map(|face| middle(&session, face));
        let kept = session.project().unwrap();
        measured(&mut session, from, to);
        assert_eq!(session.project().unwrap(), kept);
        let nowhere = Spot { face: u32::MAX, ..from };
        let events = session.handle(Command::Measure { from, to: nowhere });
        assert!(events.iter().any(|event| matches!(event, Event::Error { .. })));
        let events =
            session.handle(Command::Measure { from: Spot { place: [f64::NAN; 3], ..from }, to });
        assert!(events.iter().any(|event| matches!(event, Event::Error { .. })));
    }
}
