//! Whether charts can be cut out as they are: no face turned over, nothing covered twice.
//!
//! A face is *turned over* where its signed area in the plane is not positive. Two faces *overlap* where their insides have a point in
//! common. Both are decided by exact predicates for all faces and all pairs, so the report is a proof about the given coordinates.
//!
//! Guaranteed: no pair is missed, whatever the two share (a corner, a side, the same place). Not guaranteed: digits of areas beyond
//! rounding.

use nalgebra::Point2;

use super::overlap::{contacts, for_overlapping, orientation};
use super::{Flattening, Packing};
use crate::mesh::{FaceId, OpenedMesh};

/// Two faces that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacePair {
    /// The faces, in increasing order.
    pub faces: [FaceId; 2],
    /// Area in the plane of what they have in common.
    pub area: f64,
}

/// What is wrong with one chart, or with all together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChartValidity {
    /// Number of faces.
    pub faces: usize,
    /// Number of faces that are turned over or have no area in the plane.
    pub flipped: usize,
    /// Smallest signed area in the plane, and the face that has it.
    pub smallest: Option<(FaceId, f64)>,
    /// Number of pairs of faces that overlap. A flipped face overlaps its neighbours.
    pub pairs: usize,
    /// Area in the plane of what all pairs have in common: what is covered k times counts k (k − 1) / 2 times.
    pub overlapping_area: f64,
    /// The pair that has most in common.
    pub worst: Option<FacePair>,
    /// Number of proper crossings of the outline with itself.
    pub crossings: usize,
}

impl ChartValidity {
    /// Whether no face is turned over and none overlaps another one.
    pub fn is_valid(&self) -> bool {
        self.flipped == 0 && self.pairs == 0
    }

    fn add_face(&mut self, face: FaceId, doubled_area: f64) {
        self.faces += 1;
        self.flipped += usize::from(!(doubled_area > 0.0));
        self.add_smallest((face, 0.5 * doubled_area));
    }

    fn add_smallest(&mut self, other: (FaceId, f64)) {
        if self.smallest.is_none_or(|(_, area)| other.1 < area) {
            self.smallest = Some(other);
        }
    }

    fn add_pair(&mut self, pair: FacePair) {
        self.pairs += 1;
        self.overlapping_area += pair.area;
        self.add_worst(pair);
    }

    /// Ties go to the first faces: the order of pairs does not matter.
    fn add_worst(&mut self, pair: FacePair) {
        let is_worse = self.worst.is_none_or(|worst| {
            pair.area.total_cmp(&worst.area).then(worst.faces.cmp(&pair.faces)).is_gt()
        });
        if is_worse {
            self.worst = Some(pair);
        }
    }

    fn merge(&mut self, other: &Self) {
        self.faces += other.faces;
        self.flipped += other.flipped;
        self.pairs += other.pairs;
        self.overlapping_area += other.overlapping_area;
        self.crossings += other.crossings;
        if let Some(smallest) = other.smallest {
            self.add_smallest(smallest);
        }
        if let Some(pair) = other.worst {
            self.add_worst(pair);
        }
    }
}

/// What is wrong with a flattening.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Validity {
    /// For each patch; none without chart.
    pub charts: Vec<Option<ChartValidity>>,
    /// Overlaps between different charts on a sheet: pairs, area, worst pair, crossings. Empty if no sheet was given.
    pub across: ChartValidity,
    /// All charts together, and what lies between them.
    pub totals: ChartValidity,
    /// Faces that overlap another one, in increasing order.
    pub covered_twice: Vec<FaceId>,
}

impl Validity {
    /// Whether no face is turned over and none overlaps another one.
    pub fn is_valid(&self) -> bool {
        self.totals.is_valid()
    }
}

/// Looks for flipped faces and for all pairs of faces that overlap.
///
/// **Takes** charts; where they lie on a sheet, if overlaps between different charts count. Then everything is decided about the places on
/// the sheet. **Costs** O(F log F), and the pairs. **See** [`super::overlap`].
pub fn validate(
    opened: &OpenedMesh,
    flattening: &Flattening,
    packing: Option<&Packing>,
) -> Validity {
    let placed = packing.map(|packing| flattening.place(opened, packing));
    let places = placed.as_deref().unwrap_or(&flattening.uv);
    let mut charts: Vec<Option<ChartValidity>> =
        flattening.charts.iter().map(|c| c.as_ref().ok().map(|_| Default::default())).collect();
    let mut groups: Vec<Vec<FaceId>> =
        vec![Vec::new(); if packing.is_some() { 1 } else { charts.len() }];
    let patch = |f: FaceId| opened.face_patches[f.index()] as usize;
    for f in opened.mesh.faces() {
        if let Some(chart) = &mut charts[patch(f)] {
            // In the chart's own frame: equal charts give equal numbers, wherever they lie on the sheet.
            let [a, b, c] = face_places(opened, &flattening.uv, f);
            chart.add_face(f, orientation(a, b, c));
            groups[if packing.is_some() { 0 } else { patch(f) }].push(f);
        }
    }
    let mut across = ChartValidity::default();
    let mut is_covered_twice = vec![false; opened.mesh.face_count()];
    for faces in &groups {
        let triangles: Vec<_> = faces.iter().map(|&f| face_places(opened, places, f)).collect();
        for_overlapping(
            &triangles,
            |_, _| true,
            |pair| {
                let pair =
                    FacePair { faces: pair.triangles.map(|t| faces[t as usize]), area: pair.area };
                for f in pair.faces {
                    is_covered_twice[f.index()] = true;
                }
                let [p, q] = pair.faces.map(patch);
                match &mut charts[p] {
                    Some(chart) if p == q => chart.add_pair(pair),
                    _ => across.add_pair(pair),
                }
            },
        );
    }
    let outlines: Vec<Vec<Point2<f64>>> = flattening
        .charts
        .iter()
        .map(|rim| {
            let rim = rim.as_deref().unwrap_or_default();
            rim.iter().map(|&h| places[opened.mesh.tail(h).index()]).collect()
        })
        .collect();
    let outlines: Vec<&[Point2<f64>]> = outlines.iter().map(Vec::as_slice).collect();
    if packing.is_some() {
        for [s, t] in contacts(&outlines).crossings {
            match &mut charts[s.outline as usize] {
                Some(chart) if s.outline == t.outline => chart.crossings += 1,
                _ => across.crossings += 1,
            }
        }
    } else {
        for (chart, outline) in charts.iter_mut().zip(&outlines) {
            if let Some(chart) = chart {
                chart.crossings = contacts(&[outline]).crossings.len();
            }
        }
    }
    let mut totals = across;
    for chart in charts.iter().flatten() {
        totals.merge(chart);
    }
    let covered_twice = opened.mesh.faces().filter(|f| is_covered_twice[f.index()]).collect();
    Validity { charts, across, totals, covered_twice }
}

/// Where the corners of a face lie.
pub(super) fn face_places(
    opened: &OpenedMesh,
    places: &[Point2<f64>],
    face: FaceId,
) -> [Point2<f64>; 3] {
    opened.mesh.face_vertices(face).map(|v| places[v.index()])
}
