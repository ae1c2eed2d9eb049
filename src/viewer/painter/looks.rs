//! How ribbons look: colours, widths, and what is drawn above what.

use super::super::arrays;
use super::super::color::{CASING, CUT, NEUTRAL, Rgb, WARNING};
use super::super::cones;
use super::super::stage::Part;

/// Two vectors.
pub(super) const STYLE_BYTES: u64 = 32;

/// Distance between styles in their buffer: the alignment that every device accepts.
pub(super) const STYLE_STRIDE: u32 = 256;

/// How ribbons of a kind look; the order is that of the styles in their buffer.
#[derive(Clone, Copy, Debug)]
pub(super) enum Look {
    Wire,
    Casing,
    Cut,
    Outline,
    /// The band in a piece's own colour inside a chart's rim.
    Band,
    MarkLine,
    MarkLineBehind,
    MarkPoint,
    MarkPointBehind,
    BrushEdge,
    Brush,
    BrushBehind,
    Cone,
    /// Rim of a chart that fades towards it.
    Hem,
    /// Cuts of what is hidden beside the one piece that is shown.
    Ghost,
    /// The edge and the middle of the place that the pointer has in the other view.
    MarkerEdge,
    Marker,
    MarkerBehind,
    /// The seam beside the pointer, its light edge, and the thread between its sides.
    SeamEdge,
    Seam,
    Thread,
    /// A measured way and its ends.
    PathEdge,
    Path,
    PathBehind,
    PathEndEdge,
    PathEnd,
}

impl Look {
    pub(super) const ALL: [Self; 26] = [
        Self::Wire,
        Self::Casing,
        Self::Cut,
        Self::Outline,
        Self::Band,
        Self::MarkLine,
        Self::MarkLineBehind,
        Self::MarkPoint,
        Self::MarkPointBehind,
        Self::BrushEdge,
        Self::Brush,
        Self::BrushBehind,
        Self::Cone,
        Self::Hem,
        Self::Ghost,
        Self::MarkerEdge,
        Self::Marker,
        Self::MarkerBehind,
        Self::SeamEdge,
        Self::Seam,
        Self::Thread,
        Self::PathEdge,
        Self::Path,
        Self::PathBehind,
        Self::PathEndEdge,
        Self::PathEnd,
    ];

    /// Colour, opacity, width in CSS pixels.
    pub(super) fn paint(self, accent: Rgb) -> (Rgb, f32, f32) {
        match self {
            Self::Wire => (CUT, 0.3, 0.8),
            Self::Casing => (CASING, 0.55, 2.2 + 2.0 * 0.8),
            Self::Cut => (CUT, 1.0, 2.2),
            Self::Outline => (accent, 1.0, 3.6),
            Self::Band => (CUT, 1.0, 6.2),
            Self::MarkLine => (WARNING, 1.0, 4.0),
            Self::MarkLineBehind => (WARNING, 0.35, 4.0),
            Self::MarkPoint => (WARNING, 1.0, 10.0),
            Self::MarkPointBehind => (WARNING, 0.35, 10.0),
            // Fields have every colour: a light line beside a dark one is seen on all of them.
            Self::BrushEdge => (CASING, 0.8, 4.4),
            Self::Brush => (CUT, 1.0, 2.0),
            Self::BrushBehind => (CUT, 0.25, 2.0),
            Self::Cone => (accent, 1.0, 0.0),
            // Grey is seen on both grounds.
            Self::Hem => (NEUTRAL.darker(), 0.9, 1.3),
            Self::Ghost => (NEUTRAL.darker(), 0.45, 1.4),
            Self::MarkerEdge | Self::PathEndEdge => (CASING, 0.95, 11.0),
            Self::Marker => (accent, 1.0, 7.0),
            Self::MarkerBehind => (accent, 0.4, 7.0),
            Self::SeamEdge => (CASING, 0.9, 6.4),
            Self::Seam => (accent, 1.0, 4.0),
            Self::Thread => (accent, 0.9, 1.6),
            Self::PathEdge => (CASING, 0.9, 5.0),
            Self::Path => (CUT, 1.0, 2.4),
            Self::PathBehind => (CUT, 0.3, 2.4),
            Self::PathEnd => (CUT, 1.0, 7.0),
        }
    }

    pub(super) fn bytes(self, accent: Rgb) -> Vec<u8> {
        let (colour, opacity, width) = self.paint(accent);
        let is_band = f32::from(u8::from(matches!(self, Self::Band)));
        // Higher than the surface rises within the width of a line on a slope of about 70°; what
        // turns further away than that is faded out by the shader.
        let lift = 3.0;
        // A casing fades earlier, since along an outline it would be a halo on the ground.
        let whole_from = if matches!(self, Self::Casing) { 0.3 } else { 0.03 };
        let shape = if matches!(self, Self::Cone) {
            [cones::RINGS[0], cones::RINGS[1], cones::LIFT, cones::TURNED]
        } else {
            [width / 2.0, is_band, lift, whole_from]
        };
        let mut bytes = Vec::with_capacity(STYLE_STRIDE as usize);
        arrays::push_floats(&mut bytes, &arrays::opaque(colour, opacity));
        arrays::push_floats(&mut bytes, &shape);
        bytes.resize(STYLE_STRIDE as usize, 0);
        bytes
    }
}

/// What the pointer shows, from below to above.
pub(super) const SEAM: [(Part, Look); 2] = [(Part::Seam, Look::SeamEdge), (Part::Seam, Look::Seam)];

pub(super) const POINTED_BEHIND: [(Part, Look); 2] =
    [(Part::Path, Look::PathBehind), (Part::Marker, Look::MarkerBehind)];

pub(super) const POINTED: [(Part, Look); 6] = [
    (Part::Path, Look::PathEdge),
    (Part::Path, Look::Path),
    (Part::PathEnds, Look::PathEndEdge),
    (Part::PathEnds, Look::PathEnd),
    (Part::Marker, Look::MarkerEdge),
    (Part::Marker, Look::Marker),
];

pub(super) const POINTED_ON_CHARTS: [(Part, Look); 9] = [
    (Part::ChartSeam, Look::SeamEdge),
    (Part::ChartSeam, Look::Seam),
    (Part::SeamThread, Look::Thread),
    (Part::ChartPath, Look::PathEdge),
    (Part::ChartPath, Look::Path),
    (Part::ChartPathEnds, Look::PathEndEdge),
    (Part::ChartPathEnds, Look::PathEnd),
    (Part::ChartMarker, Look::MarkerEdge),
    (Part::ChartMarker, Look::Marker),
];
