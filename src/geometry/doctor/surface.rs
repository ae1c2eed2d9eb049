//! A soup measured: its polygons as triangles, in a box of size 1 about the origin.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use nalgebra::Vector3;

use crate::geometry::FLAT;
use crate::geometry::polygon::triangulate;
use crate::mesh::Soup;

/// The triangles of a soup, with points that can be squared whatever the unit of the file is.
pub(super) struct Surface {
    /// Positions about the centre of the box of the used vertices, in units of its longest side.
    pub points: Vec<Vector3<f64>>,
    /// Longest side of the box in model units; 0 where it is none that can be computed with.
    pub extent: f64,
    /// Diagonal of the box in model units.
    pub diagonal: f64,
    /// Distance of the centre of the box from the origin in model units.
    pub distance: f64,
    /// Triangles by their corners: indices into [`Soup::corners`].
    pub triangles: Vec<[u32; 3]>,
    /// Where the triangles of each polygon begin, and their number at the end.
    starts: Vec<u32>,
}

impl Surface {
    pub fn new(soup: &Soup) -> Self {
        let (mut low, mut high) =
            (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for &v in &soup.corners {
            let p = Vector3::from(soup.positions[v as usize]);
            (low, high) = (low.inf(&p), high.sup(&p));
        }
        let mut extent = (high - low).max();
        if !(extent > 1e-100 && extent < 1e100) {
            extent = 0.0;
        }
        let centre = if extent > 0.0 { (low + high) / 2.0 } else { Vector3::zeros() };
        let place = |&p: &[f64; 3]| {
            if extent > 0.0 { (Vector3::from(p) - centre) / extent } else { Vector3::zeros() }
        };
        let diagonal = if extent > 0.0 { (high - low).norm() } else { 0.0 };
        let mut surface = Self {
            points: soup.positions.iter().map(place).collect(),
            extent,
            diagonal,
            distance: centre.norm(),
            triangles: Vec::with_capacity(
                soup.corners.len().saturating_sub(2 * soup.polygon_count()),
            ),
            starts: vec![0],
        };
        for polygon in 0..soup.polygon_count() {
            let begin = soup.starts[polygon];
            let local = local_triangles(soup, soup.polygon(polygon));
            surface.triangles.extend(local.into_iter().map(|t| t.map(|k| begin + k)));
            surface.starts.push(surface.triangles.len() as u32);
        }
        surface
    }

    /// The triangles of a polygon.
    pub fn of(&self, polygon: usize) -> &[[u32; 3]] {
        &self.triangles[self.starts[polygon] as usize..self.starts[polygon + 1] as usize]
    }

    /// The corners of a triangle in space.
    pub fn corners(&self, soup: &Soup, triangle: [u32; 3]) -> [Vector3<f64>; 3] {
        triangle.map(|corner| self.points[soup.corners[corner as usize] as usize])
    }

    /// Whether a polygon has no triangle with area.
    pub fn is_degenerate(&self, soup: &Soup, polygon: usize) -> bool {
        self.of(polygon).iter().all(|&t| is_flat(self.corners(soup, t)))
    }

    /// Sum of the triangles' normals, twice their area long.
    pub fn normal(&self, soup: &Soup, polygon: usize) -> Vector3<f64> {
        self.of(polygon).iter().map(|&t| doubled_normal(self.corners(soup, t))).sum()
    }

    /// Area of a polygon, in units of the box.
    pub fn area(&self, soup: &Soup, polygon: usize) -> f64 {
        let doubled = |&t: &[u32; 3]| doubled_normal(self.corners(soup, t)).norm();
        self.of(polygon).iter().map(doubled).sum::<f64>() / 2.0
    }

    /// Volume of the cone from the centre of the box over a polygon, filled from its middle: they add up to that of a
    /// closed surface, and turning the polygon changes nothing but the sign.
    pub fn volume(&self, soup: &Soup, polygon: usize) -> f64 {
        let point = |&v: &u32| self.points[v as usize];
        let corners = soup.polygon(polygon);
        let middle = corners.iter().map(point).sum::<Vector3<f64>>() / corners.len() as f64;
        let spans = corners
            .windows(2)
            .map(|side| doubled_normal([point(&corners[0]), point(&side[0]), point(&side[1])]));
        middle.dot(&spans.sum::<Vector3<f64>>()) / 6.0
    }
}

/// Whether a closed surface of this volume and area (in units of the box) faces inward beyond rounding.
pub(super) fn faces_inward(volume: f64, area: f64) -> bool {
    volume < -1e-12 * area
}

/// The triangles of a polygon by the numbers of its corners: those of [`triangulate`], which looks at places only.
pub(super) fn local_triangles(soup: &Soup, polygon: &[u32]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    if polygon.len() == 3 {
        triangles.push([0, 1, 2]);
    } else {
        let places = Vec::from_iter(polygon.iter().map(|&v| soup.positions[v as usize]));
        triangulate(&places, &Vec::from_iter(0..polygon.len() as u32), &mut triangles);
    }
    triangles
}

/// The normal of a triangle, twice its area long.
pub(super) fn doubled_normal([a, b, c]: [Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Whether a triangle has no area, within rounding.
pub(super) fn is_flat(corners: [Vector3<f64>; 3]) -> bool {
    let [a, b, c] = corners;
    let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
    !(doubled_normal(corners).norm() > FLAT * longest)
}
