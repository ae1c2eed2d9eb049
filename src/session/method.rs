//! The methods that a document can be worked on with.

use super::message::{Event, MethodChoice};

/// Which method is at work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Variational surface cutting [VSC].
    #[default]
    CutFlow,
    /// Optimal cones [MAD].
    Cones,
}

/// Identifiers and labels, those that are not there yet included.
const METHODS: [(&str, &str, Option<Method>); 4] = [
    ("cutflow", "Cut flow", Some(Method::CutFlow)),
    ("cones", "Cones", Some(Method::Cones)),
    ("phasefield", "Phase field", None),
    ("developable", "Developable patches", None),
];

impl Method {
    /// The method of an identifier, if there is one.
    pub fn from_id(id: &str) -> Option<Self> {
        METHODS.iter().find(|(known, ..)| *known == id).and_then(|&(.., method)| method)
    }

    /// Stable identifier.
    pub fn id(self) -> &'static str {
        METHODS.iter().find(|(.., method)| *method == Some(self)).map_or("", |(id, ..)| id)
    }

    /// What a person reads.
    pub fn label(self) -> &'static str {
        METHODS.iter().find(|(.., method)| *method == Some(self)).map_or("", |(_, label, _)| label)
    }

    /// The field that is painted when the method is shown for the first time.
    pub fn first_field(self) -> &'static str {
        match self {
            Self::CutFlow => "pieces",
            Self::Cones => "u",
        }
    }

    /// Identifiers of those that can be chosen.
    pub fn known() -> String {
        let ids: Vec<&str> =
            METHODS.iter().filter(|(.., method)| method.is_some()).map(|(id, ..)| *id).collect();
        ids.join(", ")
    }
}

/// All methods and the one at work.
pub fn event(current: Method) -> Event {
    let choice = |&(id, label, method): &(&str, &str, Option<Method>)| MethodChoice {
        id: id.into(),
        label: label.into(),
        available: method.is_some(),
    };
    Event::Methods { current: current.id().into(), options: METHODS.iter().map(choice).collect() }
}
