//! What a flattening is worth: per face, per chart, in all.
//!
//! A face's map from the surface to the plane is linear with singular values σ₁ ≥ |σ₂|; σ₂ < 0 where it is turned over. With the
//! complex derivatives of the map, f_z and f_z̄, σ₁ = |f_z| + |f_z̄| and σ₂ = |f_z| − |f_z̄|: no cancellation near isometries.
//!
//! Guaranteed: flips and crossings are decided by exact predicates. Not guaranteed: meaning of averages of a chart with
//! flips; flipped faces are counted, not averaged.

use nalgebra::{Complex, Point2};

use super::overlap::{crossings, orientation};
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
    /// Number of crossings of the outline with itself.
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
}

/// Measures all charts. **Costs** O(F + n), n rim edges.
pub fn measure(opened: &OpenedMesh, geometry: &Geometry, flattening: &Flattening) -> Measures {
    let face_count = opened.mesh.face_count();
    let patch_count = flattening.charts.len();
    let mut sums: Vec<Sums> = vec![Sums::default(); patch_count];
    let mut face_angle_distortions = vec![f64::NAN; face_count];
    let mut face_log_scales = vec![f64::NAN; face_count];
    for face in opened.mesh.faces() {
        let patch = opened.face_patches[face.index()] as usize;
        if flattening.charts[patch].is_err() {
            continue;
        }
        let places = opened.mesh.face_vertices(face).map(|v| flattening.uv[v.index()]);
        let map = FaceMap::new(opened, geometry, face, places);
        if map.area > 0.0 {
            face_angle_distortions[face.index()] = map.angle_distortion();
            face_log_scales[face.index()] = map.log_scale();
        }
        sums[patch].add(&map);
    }
    let mut totals = Sums::default();
    let charts = (0..patch_count)
        .map(|patch| {
            flattening.charts[patch].as_ref().ok()?;
            sums[patch].overlaps = crossings(&[&flattening.outline(opened, patch)]).len();
            totals.merge(&sums[patch]);
            Some(sums[patch].measures())
        })
        .collect();
    Measures { charts, totals: totals.measures(), face_angle_distortions, face_log_scales }
}

/// Number of crossings between the outlines of different charts on a sheet.
pub fn overlaps_across(opened: &OpenedMesh, flattening: &Flattening, packing: &Packing) -> usize {
    let outlines: Vec<Vec<Point2<f64>>> = (0..flattening.charts.len())
        .map(|patch| {
            let mut outline = flattening.outline(opened, patch);
            outline.iter_mut().for_each(|p| *p = packing.poses[patch].apply(*p));
            outline
        })
        .collect();
    let outlines: Vec<&[Point2<f64>]> = outlines.iter().map(Vec::as_slice).collect();
    crossings(&outlines).iter().filter(|[s, t]| s.outline != t.outline).count()
}

/// The linear map of one face.
struct FaceMap {
    area: f64,
    /// |f_z| and |f_z̄|.
    conformal: f64,
    anticonformal: f64,
    flipped: bool,
}

impl FaceMap {
    fn new(
        opened: &OpenedMesh,
        geometry: &Geometry,
        face: FaceId,
        [a, b, c]: [Point2<f64>; 3],
    ) -> Self {
        let sides = opened.mesh.face_halfedges(face).map(|h| geometry.edge_length(h.edge()));
        let (sin, cos) = geometry.corner_angles[face.index()][0].sin_cos();
        let as_complex = |p: Point2<f64>| Complex::new(p.x - a.x, p.y - a.y);
        // Corners of the face in its plane: 0, sides[0], sides[2] (cos, sin).
        let f_x = as_complex(b) / sides[0];
        let f_y = (as_complex(c) / sides[2] - f_x * cos) / sin;
        let rotated = Complex::new(-f_y.im, f_y.re);
        Self {
            area: geometry.face_areas[face.index()],
            conformal: 0.5 * (f_x - rotated).norm(),
            anticonformal: 0.5 * (f_x + rotated).norm(),
            flipped: orientation(a, b, c) <= 0.0,
        }
    }

    /// σ₁ and σ₂.
    fn singular_values(&self) -> [f64; 2] {
        [self.conformal + self.anticonformal, self.conformal - self.anticonformal]
    }

    fn angle_distortion(&self) -> f64 {
        let [larger, smaller] = self.singular_values();
        larger / smaller.abs()
    }

    fn log_scale(&self) -> f64 {
        let [larger, smaller] = self.singular_values();
        0.5 * (larger * smaller.abs()).ln()
    }
}

/// What the measures are made of.
#[derive(Clone, Debug, Default)]
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
}

impl Sums {
    fn add(&mut self, map: &FaceMap) {
        self.faces += 1;
        self.flipped += usize::from(map.flipped);
        let [larger, smaller] = map.singular_values();
        if map.area <= 0.0 || !(larger + smaller).is_finite() {
            return;
        }
        let change = larger * smaller - 1.0;
        self.area += map.area;
        self.area_change += map.area * change;
        self.area_change_abs += map.area * change.abs();
        if map.flipped || smaller <= 0.0 {
            return;
        }
        let scale = map.log_scale();
        self.weight += map.area;
        self.angle += map.area * map.angle_distortion();
        self.angle_max = self.angle_max.max(map.angle_distortion());
        self.scale += map.area * scale;
        self.scale_squared += map.area * scale * scale;
        self.stretch_squared += map.area * 0.5 * (larger.powi(-2) + smaller.powi(-2));
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
    }

    /// NaN where there is no face to average.
    fn measures(&self) -> ChartMeasures {
        let mean_scale = self.scale / self.weight;
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
            l2_stretch: (self.stretch_squared / self.weight).sqrt(),
            hencky: self.scale_squared,
        }
    }
}
