//! What a person does with a segmentation besides running it.

use std::rc::Rc;

use super::super::message::{Event, Value};
use super::super::method::Method;
use super::super::text::Problem;
use super::super::work::start_flow;
use super::super::{Session, nothing_open};

impl Session {
    /// Shows a segment of the hierarchy.
    pub(in super::super) fn select_segment(
        &mut self,
        node: usize,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        if !work.phase.select(node) {
            return Err(Problem::new(
                format!("There is no segment {node}."),
                "In the hierarchy of segments.",
                "Choose one that is shown.",
            ));
        }
        events.extend(work.segmentation().and_then(|segmentation| segmentation.told()));
        self.scene_is_new = true;
        events.push(Event::Scene);
        Ok(())
    }

    /// Goes on with the cut flow from the pieces that there are.
    pub(in super::super) fn hand_over(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let initial = match work.method {
            Method::PhaseField => work.phase.cut_start(),
            Method::Developable => work.develop.cut_start(),
            Method::CutFlow | Method::Cones => None,
        };
        let Some(initial) = initial else {
            return Err(Problem::new(
                "There are no pieces to improve.",
                "Improve by the cut flow.",
                "Choose Phase field or Developable patches and run it first.",
            ));
        };
        let mut settings = work.settings.clone();
        let mut layers = work.layers.clone();
        layers.handed = Some(Rc::new(initial));
        settings.put("init", Value::Text("handed".into()));
        // Try before anything changes.
        let flow = start_flow(&work.document, &settings, &layers, None)?;
        self.set_method(Method::CutFlow.id(), events)?;
        let Some(work) = &mut self.work else { return Ok(()) };
        work.settings = settings;
        work.layers = layers;
        work.begin(flow);
        self.push_energy(events);
        self.settle(events);
        events.push(self.parameters());
        events.push(self.presets());
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    /// Joins two pieces, or keeps them apart.
    pub(in super::super) fn sew(
        &mut self,
        patches: [usize; 2],
        joins: bool,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let layout = work.layout.as_ref().filter(|_| work.method == Method::Developable);
        let faces = layout.and_then(|layout| {
            let face = |patch: usize| {
                let f = layout.opened.face_patches.iter().position(|&p| p as usize == patch)?;
                Some(layout.cut.triangle_faces[f].index())
            };
            Some([face(patches[0])?, face(patches[1])?])
        });
        let Some(faces) = faces.filter(|_| patches[0] != patches[1]) else {
            let count = layout.map_or(0, |layout| layout.opened.patch_count);
            let missing = patches.into_iter().find(|&patch| patch >= count);
            let what = match missing {
                _ if count < 2 => "There are no two pieces to sew.".to_owned(),
                Some(patch) => {
                    format!("There is no piece {}: there are {count}.", patch.saturating_add(1))
                }
                None => format!("Piece {} cannot be sewn to itself.", patches[0] + 1),
            };
            return Err(Problem::new(
                what,
                "Join or keep apart.",
                "Choose two pieces of developable patches; the table of pieces has the numbers of all, and lights up the one that is pointed at.",
            ));
        };
        if work.develop.is_one_first_piece(faces) {
            return Err(Problem::new(
                "These pieces are parted by a seam that was drawn.",
                "Join or keep apart.",
                "Erase the drawn seam between them to join them.",
            ));
        }
        if work.develop.first_pieces(faces).is_none() {
            return Err(Problem::new(
                "These pieces cannot be sewn yet.",
                "Join or keep apart.",
                "Run first, then choose two different pieces.",
            ));
        }
        let label = if joins { "join two pieces" } else { "keep two pieces apart" };
        self.remember(label, label);
        if let Some(work) = &mut self.work {
            work.develop.sew(faces, joins);
        }
        self.segment_follow(events)?;
        events.push(self.history_event());
        events.push(self.status());
        Ok(())
    }
}
