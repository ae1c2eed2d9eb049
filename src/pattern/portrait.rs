//! Pictures of the cut surface without a graphics processor: for covers, archives and the command line.
//!
//! Parallel projection, a depth buffer, each piece in its colour under a soft light, seams as dark lines of even width, the
//! names of the pieces where there is room. Two samples for each pixel and direction smooth the edges.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "pixels are counted: numbers are within the size of the picture; patches are counted in 32 bits"
)]

use nalgebra::{Point3, Vector3};

use super::pdf::Picture;
use super::stroke_font;
use crate::mesh::OpenedMesh;

/// From where, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct PortraitParams<'a> {
    /// Pixels across and down: 16 to 8192 each.
    pub size: [u32; 2],
    /// From the surface to the eye.
    pub towards: Vector3<f64>,
    /// What is up in the picture; not along `towards`.
    pub up: Vector3<f64>,
    /// Colours of the pieces, sRGB: piece `i` has colour `i`, from the beginning again after the last. At least one.
    pub colours: &'a [[u8; 3]],
    /// What is written on the pieces, where it has room; may be shorter.
    pub names: &'a [String],
}

/// Samples for each pixel and direction.
const FINE: usize = 2;
/// Of the picture, on each side.
const MARGIN: f64 = 0.04;
/// Width of seams, of the longer side of the picture.
const SEAM: f64 = 1.0 / 420.0;
/// Height of names, of the longer side of the picture.
const NAME: f64 = 1.0 / 45.0;
/// By how much lines lie before the surface that they are on, of its size.
const LIFT: f64 = 4e-3;
const PAPER: [f64; 3] = [255.0; 3];
const INK: [f64; 3] = [30.0, 34.0, 46.0];
/// The inner side of the surface, seen through a hole.
const INSIDE: [f64; 3] = [120.0, 124.0, 134.0];
const NONE: u32 = u32::MAX;

/// A picture of the opened surface.
///
/// **Takes** a place for each vertex of the opened surface; triangles with a place that is not finite are left out. **Gives** the
/// surface as large as the picture allows, in its middle; a white picture where there is nothing to see. **Costs** O(pixels + F).
pub fn portrait(
    opened: &OpenedMesh,
    places: &[Point3<f64>],
    params: &PortraitParams<'_>,
) -> Picture {
    let [width, height] = params.size;
    assert!((16..=8192).contains(&width) && (16..=8192).contains(&height));
    assert!(!params.colours.is_empty() && places.len() == opened.mesh.vertex_count());
    let mut canvas = Canvas::new(params.size);
    if let Some(points) = projected(places, params) {
        canvas.fill(opened, &points, params.colours);
        canvas.draw_seams(opened, &points);
        canvas.write_names(params.names);
    }
    Picture { width, height, rgb: canvas.reduced() }
}

/// Two pictures of equal height side by side.
pub fn side_by_side(left: &Picture, right: &Picture) -> Picture {
    assert_eq!(left.height, right.height, "they stand on one line");
    let rows = |picture: &Picture| {
        picture.rgb.chunks(3 * picture.width as usize).map(<[u8]>::to_vec).collect::<Vec<_>>()
    };
    let joined = rows(left).into_iter().zip(rows(right));
    Picture {
        width: left.width + right.width,
        height: left.height,
        rgb: joined.flat_map(|(left, right)| [left, right].concat()).collect(),
    }
}

/// Places in samples, y down, and how near they are; none where nothing is finite.
fn projected(places: &[Point3<f64>], params: &PortraitParams<'_>) -> Option<Vec<[f64; 3]>> {
    let near = params.towards.try_normalize(0.0)?;
    let right = params.up.cross(&near).try_normalize(0.0)?;
    let up = near.cross(&right);
    let seen: Vec<[f64; 3]> =
        places.iter().map(|p| [right, -up, near].map(|axis| axis.dot(&p.coords))).collect();
    let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for point in seen.iter().filter(|p| p.iter().all(|x| x.is_finite())) {
        for (bound, x) in bounds.iter_mut().zip(point) {
            *bound = [bound[0].min(*x), bound[1].max(*x)];
        }
    }
    let extent = bounds.map(|[low, high]| high - low);
    let size = params.size.map(|n| f64::from(n) * FINE as f64);
    let room = |a: usize| size[a] * (1.0 - 2.0 * MARGIN) / extent[a];
    let scale = room(0).min(room(1));
    if !(scale.is_finite() && scale > 0.0) {
        return None;
    }
    let middle = bounds.map(|[low, high]| 0.5 * (low + high));
    let place = |[x, y, z]: [f64; 3]| {
        [
            0.5 * size[0] + scale * (x - middle[0]),
            0.5 * size[1] + scale * (y - middle[1]),
            scale * z,
        ]
    };
    Some(seen.into_iter().map(place).collect())
}

/// Samples of the picture.
struct Canvas {
    width: usize,
    height: usize,
    depths: Vec<f32>,
    patches: Vec<u32>,
    colours: Vec<[f32; 3]>,
}

impl Canvas {
    fn new(size: [u32; 2]) -> Self {
        let [width, height] = size.map(|n| n as usize * FINE);
        Self {
            width,
            height,
            depths: vec![f32::NEG_INFINITY; width * height],
            patches: vec![NONE; width * height],
            colours: vec![PAPER.map(|x| x as f32); width * height],
        }
    }

    fn longer_side(&self) -> f64 {
        self.width.max(self.height) as f64
    }

    /// Samples whose middles lie from `low` to `high`, of `count`.
    fn range(count: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        let clamp = |x: f64| x.clamp(0.0, count as f64) as usize;
        clamp((low - 0.5).ceil())..clamp((high - 0.5).floor() + 1.0)
    }

    fn fill(&mut self, opened: &OpenedMesh, points: &[[f64; 3]], palette: &[[u8; 3]]) {
        let normals = normals(opened, points);
        for (triangle, &patch) in opened.mesh.triangles().iter().zip(&opened.face_patches) {
            let corners = triangle.map(|v| points[v.index()]);
            let [a, b, c] = corners;
            // Twice the area, positive where the outer side is seen; y goes down.
            let area = (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1]);
            if area == 0.0 || !corners.as_flattened().iter().all(|x| x.is_finite()) {
                continue;
            }
            let colour = palette[patch as usize % palette.len()].map(f64::from);
            let lights = triangle.map(|v| light(&normals[v.index()]));
            let extreme = |a: usize, pick: fn(f64, f64) -> f64| {
                pick(pick(corners[0][a], corners[1][a]), corners[2][a])
            };
            let columns = Self::range(self.width, extreme(0, f64::min), extreme(0, f64::max));
            for row in Self::range(self.height, extreme(1, f64::min), extreme(1, f64::max)) {
                for column in columns.clone() {
                    let [x, y] = [column as f64 + 0.5, row as f64 + 0.5];
                    let share = |p: [f64; 3], q: [f64; 3]| {
                        ((q[0] - x) * (p[1] - y) - (p[0] - x) * (q[1] - y)) / area
                    };
                    let shares = [share(b, c), share(c, a), share(a, b)];
                    if shares.iter().any(|&s| s < 0.0) {
                        continue;
                    }
                    let mix = |values: [f64; 3]| -> f64 {
                        values.iter().zip(&shares).map(|(value, share)| value * share).sum()
                    };
                    let at = row * self.width + column;
                    let depth = mix(corners.map(|p| p[2])) as f32;
                    if depth <= self.depths[at] {
                        continue;
                    }
                    self.depths[at] = depth;
                    let is_outside = area > 0.0;
                    self.patches[at] = if is_outside { patch } else { NONE };
                    self.colours[at] = if is_outside {
                        colour.map(|x| (x * mix(lights)).min(255.0) as f32)
                    } else {
                        INSIDE.map(|x| x as f32)
                    };
                }
            }
        }
    }

    /// Rims of the pieces, where nothing is before them.
    fn draw_seams(&mut self, opened: &OpenedMesh, points: &[[f64; 3]]) {
        let lift = LIFT * self.longer_side();
        // Thinner lines would miss samples.
        let radius = (0.5 * SEAM * self.longer_side()).max(0.75);
        for &outside in opened.mesh.boundary_loops() {
            for h in opened.mesh.boundary_loop(outside) {
                let [p, q] =
                    [opened.mesh.tail(h), opened.mesh.tail(h.twin())].map(|v| points[v.index()]);
                self.draw_line(p, q, radius, lift);
            }
        }
    }

    fn draw_line(&mut self, p: [f64; 3], q: [f64; 3], radius: f64, lift: f64) {
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        if !length.is_finite() || !(p[2] + q[2]).is_finite() {
            return;
        }
        let count = (2.0 * length).ceil().max(1.0) as usize;
        for k in 0..=count {
            let t = k as f64 / count as f64;
            let [x, y, z] = [0, 1, 2].map(|a| p[a] + t * (q[a] - p[a]));
            let rows = Self::range(self.height, y - radius, y + radius);
            let columns = Self::range(self.width, x - radius, x + radius);
            let near = (z + lift) as f32;
            let middle = [x, y].map(|c| c.max(0.0) as usize);
            let at = middle[1].min(self.height - 1) * self.width + middle[0].min(self.width - 1);
            if self.depths[at] > near {
                continue;
            }
            for row in rows {
                for column in columns.clone() {
                    let from = (column as f64 + 0.5 - x).hypot(row as f64 + 0.5 - y);
                    let at = row * self.width + column;
                    if from <= radius && self.depths[at] <= near {
                        self.colours[at] = INK.map(|x| x as f32);
                    }
                }
            }
        }
    }

    /// Names on the pieces that show enough of themselves.
    fn write_names(&mut self, names: &[String]) {
        let height = NAME * self.longer_side();
        let mut middles = vec![([0.0; 2], 0usize); names.len()];
        for (at, &patch) in self.patches.iter().enumerate() {
            if let Some((sum, count)) = middles.get_mut(patch as usize) {
                sum[0] += (at % self.width) as f64;
                sum[1] += (at / self.width) as f64;
                *count += 1;
            }
        }
        for (patch, (name, (sum, count))) in names.iter().zip(middles).enumerate() {
            if count == 0 || name.is_empty() {
                continue;
            }
            let middle = sum.map(|x| x / count as f64);
            let half = [0.5 * stroke_font::width(name, height), 0.5 * height];
            let Some(at) = self.free_place(patch as u32, middle, half.map(|x| 1.3 * x)) else {
                continue;
            };
            // The strokes have y up.
            for (radius, colour) in [(0.17 * height, PAPER), (0.07 * height, INK)] {
                for stroke in stroke_font::strokes(name, [0.0; 2], height, false) {
                    for pair in stroke.windows(2) {
                        let ends = [pair[0], pair[1]].map(|[x, y]| [at[0] + x, at[1] - y]);
                        self.write_line(ends, radius, colour);
                    }
                }
            }
        }
    }

    /// Where a box lies on its piece alone, as near to a place as may be; none where it is nowhere.
    fn free_place(&self, patch: u32, near: [f64; 2], half: [f64; 2]) -> Option<[f64; 2]> {
        let step = half[1].max(1.0);
        let counts = [self.width, self.height].map(|n| (n as f64 / step) as usize);
        let mut best: Option<(f64, [f64; 2])> = None;
        let places = (0..=counts[0]).flat_map(|i| (0..=counts[1]).map(move |j| [i, j]));
        let grid = places.map(|[i, j]| [step * i as f64, step * j as f64]);
        for at in std::iter::once(near).chain(grid) {
            let from = (at[0] - near[0]).hypot(at[1] - near[1]);
            if best.is_none_or(|(least, _)| from < least) && self.is_on(patch, at, half) {
                best = Some((from, at));
            }
        }
        best.map(|(_, at)| at)
    }

    fn is_on(&self, patch: u32, at: [f64; 2], half: [f64; 2]) -> bool {
        let grid = [-1.0, -0.5, 0.0, 0.5, 1.0];
        grid.iter().all(|s| {
            grid.iter().all(|t| {
                let [x, y] = [at[0] + s * half[0], at[1] + t * half[1]];
                let is_inside =
                    x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
                is_inside && self.patches[y as usize * self.width + x as usize] == patch
            })
        })
    }

    fn write_line(&mut self, [p, q]: [[f64; 2]; 2], radius: f64, colour: [f64; 3]) {
        let along = [q[0] - p[0], q[1] - p[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        let rows = Self::range(self.height, p[1].min(q[1]) - radius, p[1].max(q[1]) + radius);
        for row in rows {
            let low = p[0].min(q[0]) - radius;
            for column in Self::range(self.width, low, p[0].max(q[0]) + radius) {
                let [x, y] = [column as f64 + 0.5 - p[0], row as f64 + 0.5 - p[1]];
                let t = if squared > 0.0 { (x * along[0] + y * along[1]) / squared } else { 0.0 };
                let t = t.clamp(0.0, 1.0);
                if (x - t * along[0]).hypot(y - t * along[1]) <= radius {
                    self.colours[row * self.width + column] = colour.map(|x| x as f32);
                }
            }
        }
    }

    /// The pixels: means of their samples.
    fn reduced(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(3 * self.colours.len() / (FINE * FINE));
        for row in 0..self.height / FINE {
            for column in 0..self.width / FINE {
                for channel in 0..3 {
                    let mut sum = 0.0;
                    for k in 0..FINE * FINE {
                        let at = (row * FINE + k / FINE) * self.width + column * FINE + k % FINE;
                        sum += self.colours[at][channel];
                    }
                    out.push((sum / (FINE * FINE) as f32).round() as u8);
                }
            }
        }
        out
    }
}

/// Outer normals at the vertices as the picture sees them: right, down, near.
fn normals(opened: &OpenedMesh, points: &[[f64; 3]]) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); points.len()];
    for triangle in opened.mesh.triangles() {
        let [a, b, c] = triangle.map(|v| Vector3::from(points[v.index()]));
        // Right, down and near make a left-handed frame.
        let normal = (c - a).cross(&(b - a));
        if normal.iter().all(|x| x.is_finite()) {
            triangle.iter().for_each(|v| normals[v.index()] += normal);
        }
    }
    normals
}

/// How bright a colour is: soft light from above and the left, none of it black.
fn light(normal: &Vector3<f64>) -> f64 {
    let Some(normal) = normal.try_normalize(0.0) else { return 1.0 };
    let from = Vector3::new(-0.35, -0.6, 0.72).normalize();
    0.66 + 0.42 * normal.dot(&from).max(-0.4)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CutMesh, Mesh};

    const RED: [u8; 3] = [200, 40, 40];

    fn picture(places: &[[f64; 3]], triangles: &[[u32; 3]], names: &[String]) -> Picture {
        let mesh = Mesh::new(places.len(), triangles).expect("a surface");
        let opened = CutMesh::uncut(&mesh).open().expect("it opens");
        let places: Vec<Point3<f64>> = opened
            .vertex_points
            .iter()
            .map(|&point| Point3::from(places[point as usize]))
            .collect();
        let params = PortraitParams {
            size: [120, 90],
            towards: Vector3::z(),
            up: Vector3::y(),
            colours: &[RED],
            names,
        };
        portrait(&opened, &places, &params)
    }

    fn pixel(picture: &Picture, x: usize, y: usize) -> [u8; 3] {
        let at = 3 * (y * picture.width as usize + x);
        [picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]]
    }

    fn is_red([red, green, blue]: [u8; 3]) -> bool {
        red > 120 && green < 90 && blue < 90
    }

    const SQUARE: [[f64; 3]; 4] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn a_square_fills_the_height_but_for_the_margin_and_has_a_dark_rim() {
        let picture = picture(&SQUARE, &[[0, 1, 2], [0, 2, 3]], &[]);
        let red = (0..90)
            .flat_map(|y| (0..120).map(move |x| (x, y)))
            .filter(|&(x, y)| is_red(pixel(&picture, x, y)))
            .count();
        // (90 − 2 · 3.6)² less half the rim of 120 / 420 pixels; a pixel more or less along each side.
        let side = 90.0 * (1.0 - 2.0 * MARGIN);
        assert!((red as f64).sqrt() <= side && (red as f64).sqrt() >= side - 2.5, "{red}");
        assert_eq!(pixel(&picture, 2, 2), [255; 3]);
        let left = 60 - (0.5 * side) as usize;
        assert!((left - 1..=left + 1).any(|x| pixel(&picture, x, 45)[0] < 150), "no rim");
    }

    #[test]
    fn the_inner_side_is_grey() {
        let picture = picture(&SQUARE, &[[0, 2, 1], [0, 3, 2]], &[]);
        assert_eq!(pixel(&picture, 60, 45), INSIDE.map(|x| x as u8));
    }

    #[test]
    fn what_is_nearer_hides_what_is_behind() {
        // The second square turns its inner side to the eye and stands behind the first, of which it shows only the right half.
        let mut places = SQUARE.to_vec();
        places.extend(SQUARE.map(|[x, y, _]| [x + 0.5, y, -1.0]));
        let picture = picture(&places, &[[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]], &[]);
        assert!(is_red(pixel(&picture, 60, 45)));
        assert_eq!(pixel(&picture, 95, 45), INSIDE.map(|x| x as u8));
    }

    #[test]
    fn a_name_is_written_where_it_has_room() {
        let dark = |names: &[String]| {
            let picture = picture(&SQUARE, &[[0, 1, 2], [0, 2, 3]], names);
            (40..80)
                .flat_map(|x| (25..65).map(move |y| (x, y)))
                .filter(|&(x, y)| !is_red(pixel(&picture, x, y)))
                .count()
        };
        assert_eq!(dark(&[]), 0);
        assert!(dark(&["8".into()]) > 3);
        // 60 letters are wider than the picture.
        assert_eq!(dark(&["W".repeat(60)]), 0);
    }

    #[test]
    fn a_surface_without_places_is_a_white_picture() {
        let picture = picture(&[[f64::NAN; 3]; 3], &[[0, 1, 2]], &[]);
        assert!(picture.rgb.iter().all(|&x| x == 255));
    }
}
