//! What a person should know of a cut as a whole: under the table of measures, in reports, and on the terminal.

use super::layout::Layout;
use super::message::NoticeText;
use super::method::Method;
use super::work::Work;
use crate::methods::cutflow::CutFlow;
use crate::methods::flow::Flow;
use crate::methods::prepare::TOO_COARSE;

impl Work {
    /// All notices of the current cut.
    pub fn notices(&self, layout: &Layout) -> Vec<NoticeText> {
        let mut notices = Vec::new();
        if let Some(flow) = &self.flow {
            notices.extend(uncut_parts(flow));
            notices.extend(inaccurate(flow));
            notices.extend(self.coarse_mesh());
        }
        notices.extend(inaccurate_charts(layout));
        notices.extend(layout.notice.iter().map(|text| NoticeText::new("outlines", 1, text)));
        notices
    }

    /// The same as one text.
    pub fn note(&self, layout: &Layout) -> Option<String> {
        if self.method == Method::Cones {
            let coarse = self.coarse_mesh().map(|notice| notice.text);
            let is_exact = layout.flattening.angles_exact;
            let inexact = (!is_exact && self.is_settled).then(|| {
                "The chart could not be closed with exact angles at the cones: its outline was bent a little.".to_owned()
            });
            let inaccurate = inaccurate_charts(layout).map(|notice| notice.text);
            let texts: Vec<String> = self
                .cones_note()
                .into_iter()
                .chain(inexact)
                .chain(inaccurate)
                .chain(coarse)
                .collect();
            return (!texts.is_empty()).then(|| texts.join(" "));
        }
        let of_method = self.segmentation().map(|segmentation| segmentation.notes());
        let texts: Vec<String> = self
            .notices(layout)
            .into_iter()
            .map(|notice| notice.text)
            .chain(of_method.unwrap_or_default())
            .collect();
        (!texts.is_empty()).then(|| texts.join(" "))
    }

    /// That the triangles are too large for the curvature: the flow runs all the same, on what linear functions can tell.
    fn coarse_mesh(&self) -> Option<NoticeText> {
        let coarseness = self.document.surface.as_ref()?.coarseness;
        (coarseness > TOO_COARSE).then(|| {
            NoticeText::new(
                "coarse_mesh",
                1,
                format!(
                    "The mesh is coarse for its curvature: edges span {:.1}° of it, more than {:.1}°, so that cut and measures are rough. \
                     Refine it under Prepare first, or by the command prepare with --tool refine.",
                    coarseness.to_degrees(),
                    TOO_COARSE.to_degrees()
                ),
            )
        })
    }
}

/// Relative residual of scale factors and of places beyond which their digits are told not to be trusted. Good meshes have 1e-12; at 1e-6 energies
/// and lengths are still right to more digits than are shown.
const WORST_RESIDUAL: f64 = 1e-6;

/// That the last solve left more than rounding.
fn inaccurate(flow: &CutFlow) -> Option<NoticeText> {
    let residual = flow.state().residual();
    (!(residual <= WORST_RESIDUAL)).then(|| {
        let text = format!(
            "The scale factors solve their equation only to {residual:.0e} of its size: the triangles are too thin for exact distortion. Remesh \
             under Prepare, or by the command prepare with --tool remesh."
        );
        NoticeText::new("inaccurate_solve", 1, text)
    })
}

/// That the places in the charts solve their equations only roughly.
fn inaccurate_charts(layout: &Layout) -> Option<NoticeText> {
    let residual = layout.flattening.residual;
    (!(residual <= WORST_RESIDUAL)).then(|| {
        let text = format!(
            "The charts solve their equations only to {residual:.0e} of their size: the triangles are too thin for exact lengths. Remesh under \
             Prepare, or by the command prepare with --tool remesh."
        );
        NoticeText::new("inaccurate_charts", 1, text)
    })
}

/// Closed components that the initial cut leaves whole.
fn uncut_parts(flow: &CutFlow) -> Option<NoticeText> {
    let count = flow.resting_components();
    let who = match count {
        0 => return None,
        1 => "1 closed part is missed by".to_owned(),
        n => format!("{n} closed parts are missed by"),
    };
    let text = format!(
        "{who} the initial cut: it lies in one region and stays whole. Choose another start to cut it."
    );
    Some(NoticeText::new("uncut_parts", count, text))
}
