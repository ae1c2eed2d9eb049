//! The hierarchy of segments as the page shows it.

use serde::Serialize;

use super::super::picture::COLOURS;

/// A tree of segments. Lengths over √area, losses for a surface of area 4π.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SegmentTree {
    /// Parents come before their children.
    pub nodes: Vec<Segment>,
    /// The one whose weight is shown.
    pub selected: usize,
    /// The one that is being divided.
    pub active: Option<usize>,
}

/// A segment in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Segment {
    /// Its number.
    pub node: usize,
    /// The segment that it is a part of.
    pub parent: Option<usize>,
    /// Divisions above it.
    pub level: usize,
    /// What a person calls it: `Whole`, `1`, `2`, `1.1` and so on.
    pub label: String,
    /// Whether it has not been divided.
    pub is_leaf: bool,
    /// Index into the palette, of leaves.
    pub color: Option<u8>,
    /// Fraction of the area of the surface.
    pub area_fraction: f64,
    /// Parts that do not hang together.
    pub components: usize,
    /// Length of the interface that divides it, where it has been divided.
    pub length: Option<f64>,
    /// Sharp Hencky loss of its two parts, where it has been divided.
    pub loss: Option<f64>,
}

/// The palette as the leaves use it.
pub(super) fn colour(leaf: usize) -> u8 {
    u8::try_from(leaf % COLOURS).unwrap_or(0)
}
