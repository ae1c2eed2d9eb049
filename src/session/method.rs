//! The methods that a document can be worked on with.

use super::Session;
use super::message::{Event, MethodChoice};
use super::text::Problem;
use super::work::{Pending, Work};

/// Which method is at work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Method {
    /// Variational surface cutting [VSC].
    #[default]
    CutFlow,
    /// Optimal cones [MAD].
    Cones,
    /// Phase-field segmentation [PF].
    PhaseField,
    /// Quasi-developable patches [LPFB].
    Developable,
}

/// Identifiers and labels.
const METHODS: [(&str, &str, Method); 4] = [
    ("cutflow", "Cut flow", Method::CutFlow),
    ("cones", "Cones", Method::Cones),
    ("phasefield", "Phase field", Method::PhaseField),
    ("developable", "Developable patches", Method::Developable),
];

impl Method {
    /// All of them, in the order of the page.
    pub const ALL: [Self; 4] = [Self::CutFlow, Self::Cones, Self::PhaseField, Self::Developable];

    /// The method of an identifier, if there is one.
    pub fn from_id(id: &str) -> Option<Self> {
        METHODS.iter().find(|(known, ..)| *known == id).map(|&(.., method)| method)
    }

    /// Stable identifier.
    pub fn id(self) -> &'static str {
        METHODS.iter().find(|(.., method)| *method == self).map_or("", |(id, ..)| id)
    }

    /// What a person reads.
    pub fn label(self) -> &'static str {
        METHODS.iter().find(|(.., method)| *method == self).map_or("", |(_, label, _)| label)
    }

    /// The field that is painted when the method is shown for the first time.
    pub fn first_field(self) -> &'static str {
        match self {
            Self::CutFlow | Self::Developable => "pieces",
            Self::Cones => "u",
            Self::PhaseField => "phase",
        }
    }

    /// All identifiers.
    pub fn known() -> String {
        METHODS.map(|(id, ..)| id).join(", ")
    }
}

/// All methods and the one at work.
pub fn event(current: Method) -> Event {
    let choice =
        |(id, label, _): (&str, &str, Method)| MethodChoice { id: id.into(), label: label.into() };
    Event::Methods { current: current.id().into(), options: METHODS.map(choice).into() }
}

impl Session {
    pub(super) fn methods(&self) -> Event {
        event(self.method())
    }

    /// Chooses the method, of the mesh that is open and of those to come.
    pub(super) fn set_method(&mut self, id: &str, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(method) = Method::from_id(id) else {
            return Err(Problem::new(
                format!("There is no method called “{id}”."),
                "In the choice of a method.",
                format!("Choose one of {}.", Method::known()),
            ));
        };
        if self.work.is_none() && self.wanted_method != method {
            self.field = method.first_field().into();
        }
        self.wanted_method = method;
        if self.method() == method {
            events.push(self.methods());
            return Ok(());
        }
        self.remember(&format!("change to {}", method.label().to_lowercase()), "method");
        if self.is_folded() {
            self.unfold(events)?;
        }
        self.is_running = false;
        let Some(work) = &mut self.work else { return Ok(()) };
        let field = work.change_method(method, &self.field);
        self.field = field.unwrap_or_else(|| method.first_field().into());
        match method {
            Method::Cones => {
                work.first_cut_is_due = false;
                // Parameters and paint may have changed meanwhile: a look at them, and at the seams.
                work.cones.ask_again();
                work.is_settled = false;
            }
            Method::CutFlow => {
                work.first_cut_is_due = work.flow.is_none() && work.document.surface.is_some();
                // The flow has not heard of what was painted meanwhile.
                work.pending = work.pending.max(Pending::Fields);
            }
            Method::PhaseField | Method::Developable => {
                work.first_cut_is_due = false;
                if work.document.surface.is_some()
                    && let Err(problem) = self.segment_prepare(events)
                {
                    // The method is chosen all the same: it says what it lacks.
                    events.push(super::error_event(problem));
                }
            }
        }
        self.scene_is_new = true;
        events.push(self.methods());
        events.push(self.parameters());
        events.push(self.presets());
        events.push(self.paint_channels());
        events.push(self.symmetries());
        events.push(self.fields());
        self.push_energy(events);
        events.extend(self.cones_event());
        if self.is_segmenting() && self.work.as_ref().is_some_and(|work| !work.is_settled) {
            self.settle(events);
        }
        events.extend(self.work.as_ref().map(Work::measures));
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }
}
