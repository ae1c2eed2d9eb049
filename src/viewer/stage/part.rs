//! What a graphics device holds a copy of, and the bytes of each.

use super::super::arrays::{self, NONE, RimChoice};
use super::super::{color, cones, layers, occlusion};
use super::{Stage, View};

/// Something that a graphics device holds a copy of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Places, normals and openness of all vertices.
    Geometry,
    /// Colours and values of all vertices.
    Paint,
    /// Places of all vertices on the sheet.
    Charts,
    /// Triangles of the surface.
    Triangles,
    /// Triangles of the charts that stand as they should.
    ChartTriangles,
    /// Triangles of the charts that are turned over.
    FlippedTriangles,
    /// Cuts and boundary on the surface.
    Cuts,
    /// Rims of the charts.
    ChartRims,
    /// Cuts of what is hidden beside the one piece that is shown.
    Ghost,
    /// Rim of the patch under the pointer, on the surface.
    Outline,
    /// The same on the sheet.
    ChartOutline,
    /// Edges on the surface.
    Wires,
    /// Edges of the charts.
    ChartWires,
    /// Points that an error points at.
    MarkPoints,
    /// Lines that an error points at.
    MarkSegments,
    /// The colour map.
    Ramp,
    /// The ring of the brush.
    Brush,
    /// On the surface, the place under the pointer that is over the sheet.
    Marker,
    /// The other way round.
    ChartMarker,
    /// The seam beside the pointer, on the surface.
    Seam,
    /// Both its sides on the sheet.
    ChartSeam,
    /// The bow between them.
    SeamThread,
    /// A measured way along the surface.
    Path,
    /// The straight line between its ends on the sheet.
    ChartPath,
    /// The ends on the surface.
    PathEnds,
    /// The ends on the sheet.
    ChartPathEnds,
    /// Cones on the surface.
    Cones,
    /// Cones on the sheet.
    ChartCones,
    /// The shadow on the ground.
    Shadow,
    /// Vertices of overlapping charts.
    LayerVertices,
    /// Their triangles.
    LayerTriangles,
    /// Those of them that have a place on the sheet.
    LayerChartTriangles,
    /// Their rims on the sheet.
    LayerRims,
    /// The pixels of the texture.
    Pixels,
}

impl Part {
    /// Number of parts.
    pub const COUNT: usize = Self::Pixels as usize + 1;
}

/// Pixels of the colour map.
pub const RAMP_PIXELS: usize = 256;

impl Stage {
    pub(super) fn stamp(&mut self, has_changed: bool, parts: &[Part]) {
        for &part in parts.iter().filter(|_| has_changed) {
            self.stamps[part as usize] += 1;
        }
    }

    /// Changes whenever [`Stage::bytes`] of the part does.
    pub fn stamp_of(&self, part: Part) -> u64 {
        self.stamps[part as usize]
    }

    /// The bytes that a graphics device is to hold of a part.
    pub fn bytes(&mut self, part: Part) -> Vec<u8> {
        let scene = &self.scene;
        let rims =
            |choice, on_charts| arrays::rim_ribbons(scene, &self.neighbours, choice, on_charts);
        // A seam beside the pointer is shown in place of the whole outline.
        let hovered = RimChoice::Patch(if self.pointing.has_seam() { NONE } else { self.hover });
        let isolated = self.isolated();
        match part {
            Part::Geometry | Part::LayerVertices => self.shaded_bytes(part),
            Part::Paint => arrays::paint(scene),
            Part::Charts => arrays::charts(scene),
            Part::Triangles => self.shown_triangles(),
            Part::ChartTriangles => arrays::indices(&arrays::chart_triangles(scene)[0]),
            Part::FlippedTriangles => arrays::indices(&arrays::chart_triangles(scene)[1]),
            Part::Cuts => rims(isolated.map_or(RimChoice::Cuts, RimChoice::Patch), false),
            Part::Ghost if isolated.is_some() => rims(RimChoice::Cuts, false),
            Part::Ghost => Vec::new(),
            Part::ChartRims => rims(RimChoice::All, true),
            Part::Outline => rims(hovered, false),
            Part::ChartOutline => rims(hovered, true),
            Part::Wires => arrays::wire_ribbons(scene, false, isolated),
            Part::ChartWires => arrays::wire_ribbons(scene, true, None),
            Part::MarkPoints => arrays::mark_point_ribbons(scene),
            Part::MarkSegments => arrays::mark_segment_ribbons(scene),
            Part::Brush => arrays::ring_ribbons(&self.ring),
            Part::Marker
            | Part::ChartMarker
            | Part::Seam
            | Part::ChartSeam
            | Part::SeamThread
            | Part::Path
            | Part::ChartPath
            | Part::PathEnds
            | Part::ChartPathEnds => self.pointed_bytes(part),
            Part::Cones => {
                let glyphs = self.glyphs_in_sight();
                cones::bytes(&self.scene, glyphs, self.cone_marks, self.viewport(View::Surface))
            }
            Part::ChartCones => cones::bytes(
                scene,
                self.glyphs(View::Flat),
                self.cone_marks,
                self.viewport(View::Flat),
            ),
            Part::Ramp => match &scene.field {
                Some(field) if arrays::is_labels(field) => color::label_ramp(RAMP_PIXELS),
                field => color::ramp(field.as_ref().is_some_and(|f| f.signed), RAMP_PIXELS),
            },
            Part::Shadow => match &self.occlusion {
                Some(occlusion) => occlusion.ground_shadow(),
                None => vec![0; occlusion::SHADOW_PIXELS.pow(2)],
            },
            Part::LayerTriangles => layers::triangles(scene, false),
            Part::LayerChartTriangles => layers::triangles(scene, true),
            Part::LayerRims => layers::rim_ribbons(scene),
            Part::Pixels => {
                let levels = self.pixels().map(|pixels| pixels.levels.iter());
                levels.into_iter().flatten().flat_map(|(_, _, bytes)| bytes).copied().collect()
            }
        }
    }

    /// Has the next picture shaded whole, for those who keep it.
    pub fn shade_whole(&mut self) {
        if let Some(occlusion) = &mut self.occlusion {
            occlusion.catch_up();
        }
    }

    /// Vertices with soft shade. Of a large mesh that is new some are shaded with each picture, so that no picture is late.
    fn shaded_bytes(&mut self, part: Part) -> Vec<u8> {
        let Some(occlusion) = &mut self.occlusion else { return Vec::new() };
        occlusion.begin();
        let bytes = match part {
            Part::LayerVertices => layers::vertices(&self.scene, occlusion),
            _ => arrays::geometry(&self.scene, occlusion),
        };
        if occlusion.is_behind() {
            self.stamp(true, &[part]);
            self.dirty[View::Surface as usize] = true;
        }
        bytes
    }
}
