//! What a flattening is worth: per face, per chart, in all.
//!
//! A face's map from the surface to the plane is linear with singular values σ₁ ≥ |σ₂|; σ₂ < 0 where it is turned over. With the
//! complex derivatives of the map, f_z and f_z̄, σ₁ = |f_z| + |f_z̄| and σ₂ = |f_z| − |f_z̄|: no cancellation near isometries.
//!
//! Guaranteed: flips and overlaps are decided by exact predicates. Not guaranteed: meaning of averages of a chart with
//! flips; flipped faces are counted, not averaged.

mod maps;

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point2;

use maps::{BLOCK, Face, FaceMap, Maps};

use super::overlap::{Bounds, Tree, contacts, for_overlapping, winding};
use super::validity::face_places;
use super::{Flattening, Packing};
use crate::geometry::Geometry;
use crate::mesh::{FaceId, OpenedMesh};

/// Distortion of one chart, or of all together. Weights are areas on the surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartMeasures {
    /// Number of faces.
    pub faces: usize,
    /// Area on the surface, A.
    pub area: f64,
    /// Number of faces that are turned over or have no area in the plane.
    pub flipped: usize,
    /// Number of crossings of the outline with itself, or of pairs of faces that overlap if it only touches itself: a chart without
    /// flips is injective if and only if it is 0. (A flipped face overlaps its neighbours, which `flipped` tells.)
    pub overlaps: usize,
    /// Mean of σ₁ / σ₂ over the area; 1 is conformal.
    pub angle_distortion: f64,
    /// Largest σ₁ / σ₂.
    pub angle_distortion_max: f64,
    /// Root mean square of s − s̄, where s = ½ log(A′ / A) per face and s̄ is its mean: 0 where all areas scale alike.
    pub area_distortion: f64,
    /// Σ (A′ − A) / Σ A with A′ the signed area in the plane.
    pub area_change: f64,
    /// Σ |A′ − A| / Σ A.
    pub area_change_abs: f64,
    /// L² stretch of [SSGH01], raw: √(Σ A ½ (σ₁⁻² + σ₂⁻²) / Σ A); 1 is isometric, larger where the chart is too small.
    pub l2_stretch: f64,
    /// L² stretch of [SSGH01] times √(Σ A′ / Σ A): at least 1, and 1 for similarities only.
    pub l2_stretch_normalized: f64,
    /// L^∞ stretch of [SSGH01], raw: the largest 1 / σ₂.
    pub linf_stretch: f64,
    /// L^∞ stretch times √(Σ A′ / Σ A).
    pub linf_stretch_normalized: f64,
    /// Symmetric Dirichlet energy, Σ A ¼ (σ₁² + σ₂² + σ₁⁻² + σ₂⁻²) / Σ A: at least 1, and 1 for isometries only.
    pub symmetric_dirichlet: f64,
    /// Smallest signed area of a face in the plane; ∞ without faces.
    pub smallest_signed_area: f64,
    /// Hencky energy Σ A s², the integral of u² with the scale that the chart really has.
    pub hencky: f64,
}

/// All measures of a flattening.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    /// For each patch; none without chart.
    pub charts: Vec<Option<ChartMeasures>>,
    /// All charts together. Means are over all areas, and the mean scale s̄ is one for all.
    pub totals: ChartMeasures,
    /// σ₁ / |σ₂| of each face; NaN without chart or area.
    pub face_angle_distortions: Vec<f64>,
    /// s = ½ log(|A′| / A) of each face; NaN without chart or area.
    pub face_log_scales: Vec<f64>,
    /// √(½ (σ₁⁻² + σ₂⁻²)) of each face, whose root mean square is the L² stretch; NaN without chart or area.
    pub face_stretches: Vec<f64>,
    /// ¼ (σ₁² + σ₂² + σ₁⁻² + σ₂⁻²) of each face; NaN without chart or area.
    pub face_symmetric_dirichlet: Vec<f64>,
}

/// Measures all charts. **Costs** O(F + n log n), n rim edges; O(F log F) for charts whose outlines touch themselves.
pub fn measure(opened: &OpenedMesh, geometry: &Geometry, flattening: &Flattening) -> Measures {
    let face_count = opened.mesh.face_count();
    let patch_count = flattening.charts.len();
    let mut sums: Vec<Sums> = vec![Sums::default(); patch_count];
    let mut face_angle_distortions = vec![f64::NAN; face_count];
    let mut face_log_scales = vec![f64::NAN; face_count];
    let mut face_stretches = vec![f64::NAN; face_count];
    let mut face_symmetric_dirichlet = vec![f64::NAN; face_count];
    let mut maps = Maps::new();
    for start in (0..face_count).step_by(BLOCK) {
        let block = start..face_count.min(start + BLOCK);
        for face in block.clone() {
            let f = FaceId::from(face);
            let sides = opened.mesh.face_halfedges(f).map(|h| geometry.edge_length(h.edge()));
            let on_surface = Face {
                area: geometry.face_areas[face],
                sides,
                angle: geometry.corner_angles[face][0],
                cotangent: geometry.corner_cotangents[face][0],
            };
            maps.put(face - start, &on_surface, face_places(opened, &flattening.uv, f));
        }
        maps.compute();
        for face in block {
            let patch = opened.face_patches[face] as usize;
            if flattening.charts[patch].is_err() {
                continue;
            }
            let map = maps.get(face - start);
            if map.area > 0.0 {
                face_angle_distortions[face] = map.angle;
                face_log_scales[face] = map.log_scale;
                face_stretches[face] = map.stretch;
                face_symmetric_dirichlet[face] = map.symmetric_dirichlet;
            }
            sums[patch].add(&map);
        }
    }
    let mut totals = Sums::default();
    let charts = (0..patch_count)
        .map(|patch| {
            flattening.charts[patch].as_ref().ok()?;
            let is_flipped = sums[patch].flipped > 0;
            sums[patch].overlaps = overlaps_within(opened, flattening, patch, is_flipped);
            totals.merge(&sums[patch]);
            Some(sums[patch].measures())
        })
        .collect();
    Measures {
        charts,
        totals: totals.measures(),
        face_angle_distortions,
        face_log_scales,
        face_stretches,
        face_symmetric_dirichlet,
    }
}

/// How often a chart overlaps itself, as [`ChartMeasures::overlaps`] counts.
fn overlaps_within(
    opened: &OpenedMesh,
    flattening: &Flattening,
    patch: usize,
    is_flipped: bool,
) -> usize {
    let contacts = contacts(&[&flattening.outline(opened, patch)]);
    if is_flipped || !contacts.crossings.is_empty() {
        return contacts.crossings.len();
    }
    if contacts.touches.is_empty() {
        return 0;
    }
    pairs_among(opened, &flattening.uv, |p| p == patch, |_, _| true)
}

/// Number of pairs of faces that overlap, among some patches, of which certain pairs count.
fn pairs_among(
    opened: &OpenedMesh,
    places: &[Point2<f64>],
    is_there: impl Fn(usize) -> bool,
    counts: impl Fn(u32, u32) -> bool,
) -> usize {
    let patch = |f: &FaceId| opened.face_patches[f.index()];
    let faces: Vec<FaceId> = opened.mesh.faces().filter(|f| is_there(patch(f) as usize)).collect();
    let triangles: Vec<_> = faces.iter().map(|&f| face_places(opened, places, f)).collect();
    let mut pairs = 0;
    let is_wanted = |s: u32, t: u32| counts(patch(&faces[s as usize]), patch(&faces[t as usize]));
    for_overlapping(&triangles, is_wanted, |_| pairs += 1);
    pairs
}

/// How often different charts overlap on a sheet: 0 if and only if none does.
///
/// **Gives** the number of crossings between their outlines, and 1 for each pair of charts whose outlines do not cross but that overlap
/// all the same, because one contains the other or their sides run along each other. **Costs** O(n log n), n rim edges.
pub fn overlaps_across(opened: &OpenedMesh, flattening: &Flattening, packing: &Packing) -> usize {
    let outlines: Vec<Vec<Point2<f64>>> = (0..flattening.charts.len())
        .map(|patch| {
            let mut outline = flattening.outline(opened, patch);
            let (turn, shift) = (packing.poses[patch].turn(), packing.poses[patch].shift);
            outline.iter_mut().for_each(|p| *p = turn * *p + shift);
            outline
        })
        .collect();
    let outlines: Vec<&[Point2<f64>]> = outlines.iter().map(Vec::as_slice).collect();
    let boxes: Vec<Bounds> = outlines.iter().map(|outline| Bounds::of(outline)).collect();
    let mut candidates = Vec::new();
    Tree::new(&boxes).for_pairs(|p, q| candidates.push([p as usize, q as usize]));
    if candidates.is_empty() {
        return 0;
    }
    let contacts = contacts(&outlines);
    let charts = |pairs: &[[super::overlap::Side; 2]]| {
        let mut counts: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        for pair in pairs.iter().map(|pair| pair.map(|side| side.outline as usize)) {
            *counts.entry([pair[0].min(pair[1]), pair[0].max(pair[1])]).or_default() += 1;
        }
        counts.retain(|[p, q], _| p != q);
        counts
    };
    let crossed = charts(&contacts.crossings);
    let touched: BTreeSet<[usize; 2]> = charts(&contacts.touches).into_keys().collect();
    let mut overlaps = crossed.values().sum();
    candidates.retain(|pair| !crossed.contains_key(pair));
    candidates.sort_unstable();
    let mut places = None;
    for pair in candidates {
        let [p, q] = pair;
        overlaps += usize::from(if touched.contains(&pair) {
            let places = places.get_or_insert_with(|| flattening.place(opened, packing));
            pairs_among(opened, places, |patch| pair.contains(&patch), |s, t| s != t) > 0
        } else {
            winding(outlines[p], outlines[q][0]) != 0 || winding(outlines[q], outlines[p][0]) != 0
        });
    }
    overlaps
}

/// What the measures are made of.
#[derive(Clone, Debug)]
struct Sums {
    faces: usize,
    flipped: usize,
    overlaps: usize,
    area: f64,
    area_change: f64,
    area_change_abs: f64,
    /// Area of the faces that are averaged.
    weight: f64,
    angle: f64,
    angle_max: f64,
    /// Sums of s and s².
    scale: f64,
    scale_squared: f64,
    stretch_squared: f64,
    stretch_max: f64,
    symmetric_dirichlet: f64,
    /// Area in the plane of the faces that are averaged.
    flat_weight: f64,
    smallest_signed_area: f64,
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            faces: 0,
            flipped: 0,
            overlaps: 0,
            area: 0.0,
            area_change: 0.0,
            area_change_abs: 0.0,
            weight: 0.0,
            angle: 0.0,
            angle_max: 0.0,
            scale: 0.0,
            scale_squared: 0.0,
            stretch_squared: 0.0,
            stretch_max: 0.0,
            symmetric_dirichlet: 0.0,
            flat_weight: 0.0,
            smallest_signed_area: f64::INFINITY,
        }
    }
}

impl Sums {
    fn add(&mut self, map: &FaceMap) {
        let is_flipped = map.flat_area <= 0.0;
        self.faces += 1;
        self.flipped += usize::from(is_flipped);
        self.smallest_signed_area = self.smallest_signed_area.min(map.flat_area);
        let [larger, smaller] = map.singular_values;
        if map.area <= 0.0 || !(larger + smaller).is_finite() {
            return;
        }
        let change = larger * smaller - 1.0;
        self.area += map.area;
        self.area_change += map.area * change;
        self.area_change_abs += map.area * change.abs();
        if is_flipped || smaller <= 0.0 {
            return;
        }
        let scale = map.log_scale;
        self.weight += map.area;
        self.angle += map.area * map.angle;
        self.angle_max = self.angle_max.max(map.angle);
        self.scale += map.area * scale;
        self.scale_squared += map.area * scale * scale;
        self.stretch_squared += map.area * map.stretch_squared;
        self.stretch_max = self.stretch_max.max(1.0 / smaller);
        self.symmetric_dirichlet += map.area * map.symmetric_dirichlet;
        self.flat_weight += map.area * larger * smaller;
    }

    fn merge(&mut self, other: &Self) {
        self.faces += other.faces;
        self.flipped += other.flipped;
        self.overlaps += other.overlaps;
        self.area += other.area;
        self.area_change += other.area_change;
        self.area_change_abs += other.area_change_abs;
        self.weight += other.weight;
        self.angle += other.angle;
        self.angle_max = self.angle_max.max(other.angle_max);
        self.scale += other.scale;
        self.scale_squared += other.scale_squared;
        self.stretch_squared += other.stretch_squared;
        self.stretch_max = self.stretch_max.max(other.stretch_max);
        self.symmetric_dirichlet += other.symmetric_dirichlet;
        self.flat_weight += other.flat_weight;
        self.smallest_signed_area = self.smallest_signed_area.min(other.smallest_signed_area);
    }

    /// NaN where there is no face to average.
    fn measures(&self) -> ChartMeasures {
        let mean_scale = self.scale / self.weight;
        let l2_stretch = (self.stretch_squared / self.weight).sqrt();
        let size = (self.flat_weight / self.weight).sqrt();
        ChartMeasures {
            faces: self.faces,
            area: self.area,
            flipped: self.flipped,
            overlaps: self.overlaps,
            angle_distortion: self.angle / self.weight,
            angle_distortion_max: self.angle_max,
            area_distortion: (self.scale_squared / self.weight - mean_scale * mean_scale)
                .max(0.0)
                .sqrt(),
            area_change: self.area_change / self.area,
            area_change_abs: self.area_change_abs / self.area,
            l2_stretch,
            l2_stretch_normalized: l2_stretch * size,
            linf_stretch: self.stretch_max,
            linf_stretch_normalized: self.stretch_max * size,
            symmetric_dirichlet: self.symmetric_dirichlet / self.weight,
            smallest_signed_area: self.smallest_signed_area,
            hencky: self.scale_squared,
        }
    }
}
