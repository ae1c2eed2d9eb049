//! A cut that goes along to another mesh: every vertex takes the label of the nearest point of the surface before.
//!
//! Both meshes are compared twice, by the coordinates of their files and by those of unit area about the origin; the closer fit
//! counts. So a mesh that was edited where it lies keeps its cut, and one that was moved or scaled as a whole does as well.
//!
//! Not guaranteed: that a turned mesh finds its cut; that thin regions survive on triangles that are larger than they are.

use std::rc::Rc;

use nalgebra::Point3;

use super::brought::Brought;
use super::document::Document;
use super::message::{Command, Event};
use super::method::Method;
use super::surface::Surface;
use super::text::Problem;
use super::{Session, nothing_open};
use crate::geometry::{Hit, Nearest};

/// Mean distance of the new vertices from the surface before, √area = 1, beyond which the two have nothing to do with each other:
/// half the radius of a ball. Larger, and a cut lands anywhere; smaller, and a sleeve that was lengthened loses its own.
const FAR: f64 = 0.14;

/// The cut of the mesh before.
pub(super) struct Kept {
    document: Rc<Document>,
    labels: Vec<u32>,
}

impl Session {
    /// The cut at hand, where a person would miss it: of a file, in two regions at least.
    pub(super) fn cut_at_hand(&self) -> Option<Kept> {
        let work = self.work.as_ref()?;
        if work.document.sample.is_some() || work.document.surface.is_none() {
            return None;
        }
        let labels = work.labels();
        let is_cut = labels.iter().any(|label| Some(label) != labels.first());
        is_cut.then(|| Kept { document: work.document.clone(), labels })
    }

    /// Says whether the cut before can be kept.
    pub(super) fn offer_to_keep(&mut self, kept: Option<Kept>, events: &mut Vec<Event>) {
        let can_be_cut = self.document().is_some_and(|document| document.surface.is_some());
        self.kept = kept.filter(|_| can_be_cut);
        if let Some(kept) = &self.kept {
            events.push(Event::KeepOffer { from: kept.document.name.clone() });
        }
    }

    /// Puts the cut of the mesh before on this one: a cut that was brought along, which projects keep.
    pub(super) fn keep_cut(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let Some(kept) = &self.kept else {
            return Err(Problem::new(
                "There is no cut to keep.",
                format!("{}.", work.document.name),
                "Open a mesh while another one is cut.",
            ));
        };
        let surface = work.document.surface()?;
        let labels = carried(kept.document.surface()?, &kept.labels, surface)?;
        let text = cut_text(surface, &labels);
        let name = kept.document.name.clone();
        self.kept = None;
        events.extend(self.do_again(Command::SetMethod { id: Method::CutFlow.id().into() }));
        events.extend(self.bring(Brought::Cut { name: &name, bytes: text.as_bytes() }));
        Ok(())
    }
}

/// For every vertex of `after` the label of the nearest point of `before`.
fn carried(before: &Surface, labels: &[u32], after: &Surface) -> Result<Vec<u32>, Problem> {
    let tree = Nearest::new(&before.mesh, &before.geometry.positions);
    let as_they_lie = |p: &Point3<f64>| {
        let in_file = after.frame.centre + p.coords / after.frame.scale;
        Point3::from((in_file - before.frame.centre) * before.frame.scale)
    };
    let places = &after.geometry.positions;
    let hits = |places: &mut dyn Iterator<Item = Point3<f64>>| -> Option<Vec<Hit>> {
        places.map(|place| tree.find(place)).collect()
    };
    let distance = |hits: &Vec<Hit>| {
        hits.iter().map(|hit| hit.squared.sqrt()).sum::<f64>() / hits.len().max(1) as f64
    };
    let candidates = [hits(&mut places.iter().map(as_they_lie)), hits(&mut places.iter().copied())];
    let best = candidates
        .into_iter()
        .flatten()
        .map(|hits| (distance(&hits), hits))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(distance, _)| *distance <= FAR);
    let Some((_, hits)) = best else {
        return Err(Problem::new(
            format!("The cut of {} does not fit: the two surfaces lie too far apart.", before.name),
            format!("{}.", after.name),
            "Move the mesh to where the other one lies, or cut it anew.",
        ));
    };
    let nearest_corner = |hit: &Hit| {
        let mut corner = 0;
        for i in [1, 2] {
            if hit.weights[i] > hit.weights[corner] {
                corner = i;
            }
        }
        before.mesh.face_vertices(hit.face)[corner]
    };
    let carried: Vec<u32> = hits.iter().map(|hit| labels[nearest_corner(hit).index()]).collect();
    if carried.iter().all(|label| Some(label) == carried.first()) {
        return Err(Problem::new(
            format!("All of the surface lies in one region of the cut of {}.", before.name),
            format!("{}.", after.name),
            "Cut it anew.",
        ));
    }
    Ok(carried)
}

/// A `cut.json` of labels alone.
fn cut_text(surface: &Surface, labels: &[u32]) -> String {
    let count = surface.soup.positions.len();
    let mut of_file = vec![None; count];
    for (&vertex, &label) in surface.soup_vertices.iter().zip(labels) {
        of_file[vertex as usize] = Some(label);
    }
    let list: Vec<String> = of_file
        .iter()
        .map(|label| label.map_or_else(|| "null".into(), |label| label.to_string()))
        .collect();
    format!(
        "{{\"cutflow_cut\":1,\"vertices\":{count},\"points\":[],\"vertex_labels\":[{}]}}",
        list.join(",")
    )
}
