//! Where a folded surface lies beside the original: best rigid alignment, distances.

use nalgebra::{Matrix3, Point3, Vector3};

use super::sheet::Sheet;

/// How far a folded surface is from what its pieces were cut from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FoldMeasures {
    /// RMS of ln (length / flat length) over the edges, weighted by the area beside them: the stretch that is left.
    pub stretch: f64,
    /// Mean distance of points from their own original places, weighted by area, in units of √area.
    pub distance_mean: f64,
    /// Largest such distance.
    pub distance_max: f64,
}

/// Distances of aligned points from their own original places: mean and largest, in units of √area.
pub(super) fn distances(sheet: &Sheet, points: &[Point3<f64>]) -> [f64; 2] {
    let unit = sheet.area.sqrt();
    let (mut sum, mut largest) = (0.0, 0.0f64);
    for (p, point) in points.iter().enumerate().filter(|(p, _)| sheet.point_areas[*p] > 0.0) {
        let distance = (point.coords - place(&sheet.origin, p)).norm() / unit;
        sum += sheet.point_areas[p] * distance;
        largest = largest.max(distance);
    }
    [sum / sheet.area, largest]
}

/// Point `p` of three arrays in one.
pub(super) fn place(x: &[f64], p: usize) -> Vector3<f64> {
    let n = x.len() / 3;
    Vector3::new(x[p], x[n + p], x[2 * n + p])
}

/// Moves every component rigidly to where its points are nearest to their original places (least squares by area).
///
/// **Costs** O(V). **From** Kabsch: *A solution for the best rotation to relate two sets of vectors*, 1976.
pub(super) fn align(sheet: &Sheet, x: &[f64]) -> Vec<Point3<f64>> {
    let n = sheet.point_areas.len();
    let count = sheet.component_count;
    let mut areas = vec![0.0; count];
    let mut centres = vec![[Vector3::zeros(); 2]; count];
    for p in 0..n {
        let (c, area) = (sheet.components[p] as usize, sheet.point_areas[p]);
        areas[c] += area;
        centres[c][0] += place(x, p) * area;
        centres[c][1] += place(&sheet.origin, p) * area;
    }
    for (centre, area) in centres.iter_mut().zip(&areas) {
        // A component without area stays where it is.
        *centre = if *area > 0.0 { centre.map(|v| v / *area) } else { [Vector3::zeros(); 2] };
    }
    let mut products = vec![Matrix3::zeros(); count];
    for p in 0..n {
        let c = sheet.components[p] as usize;
        let [from, to] = [place(x, p) - centres[c][0], place(&sheet.origin, p) - centres[c][1]];
        products[c] += to * from.transpose() * (sheet.point_areas[p] / sheet.area);
    }
    let turns: Vec<Matrix3<f64>> = products.into_iter().map(best_rotation).collect();
    (0..n)
        .map(|p| {
            let c = sheet.components[p] as usize;
            Point3::from(turns[c] * (place(x, p) - centres[c][0]) + centres[c][1])
        })
        .collect()
}

/// The rotation R with the largest tr (Rᵀ M).
fn best_rotation(product: Matrix3<f64>) -> Matrix3<f64> {
    if !(product.norm_squared() > 0.0 && product.norm_squared().is_finite()) {
        return Matrix3::identity();
    }
    let svd = product.svd(true, true);
    let (Some(mut u), Some(v)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    if (u * v).determinant() < 0.0 {
        // Singular values need not come sorted: the least one gives way.
        let last = svd.singular_values.imin();
        u.column_mut(last).neg_mut();
    }
    u * v
}
