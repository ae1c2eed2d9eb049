//! The atlas as a picture: what to paint on, and a texture that shows pieces, seams and stretching.
//!
//! Each piece has its colour, with squares of a given side in two shades, and a dark line along its seams. Colours go on
//! beyond the outlines, so that a renderer that mixes neighbouring pixels finds no background at the seams.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "pixels are counted: numbers are within the size of the picture; patches are counted in 32 bits"
)]

use super::uv_map::UvMap;
use crate::mesh::OpenedMesh;

/// What the picture is to look like.
#[derive(Clone, Debug, PartialEq)]
pub struct AtlasImageParams<'a> {
    /// Side of the picture in pixels: 1 to 16384.
    pub size: u32,
    /// Colours of the pieces, sRGB: piece `i` has colour `i`, from the beginning again after the last. At least one.
    pub colours: &'a [[u8; 3]],
    /// Side of the squares in units of the charts; `None` for pieces of one shade.
    pub square: Option<f64>,
    /// Width of the lines at seams, pixels, half of it inside each of the two pieces; 0 for none.
    pub seam_width: f64,
    /// How far colours go on beyond the outlines, pixels.
    pub padding: u32,
}

/// Where no piece is near.
const BACKGROUND: [u8; 3] = [0xff; 3];
/// What the darker squares have of the colour.
const SHADE: f64 = 0.82;
/// Seams: most of the colour is gone.
const SEAM: f64 = 0.25;
const NONE: u32 = u32::MAX;

/// Pixels of the atlas, three bytes each, rows from the top (v = 1), as [`super::png`] takes them.
///
/// **Takes** a place for each vertex of the opened surface, NaN in patches without chart; the unit square is that of
/// [`super::uv_obj`]. **Gives** at least one pixel of every piece, however narrow. **Costs** O(pixels + F + length of the
/// outlines in pixels).
pub fn atlas_image(opened: &OpenedMesh, charts: &[[f64; 2]], params: &AtlasImageParams) -> Vec<u8> {
    assert!((1..=16_384).contains(&params.size) && !params.colours.is_empty());
    let map = UvMap::new(opened, charts);
    let mut picture = Picture::new(params.size);
    picture.fill_triangles(opened, charts, &map);
    picture.draw_outlines(opened, charts, &map, params.seam_width);
    picture.paint(&map, params);
    picture.spread(params.padding);
    picture.colours.concat()
}

struct Picture {
    size: usize,
    /// The piece of every pixel.
    pieces: Vec<u32>,
    /// How much of every pixel is seam.
    seams: Vec<f32>,
    colours: Vec<[u8; 3]>,
}

impl Picture {
    fn new(size: u32) -> Self {
        let size = size as usize;
        let count = size * size;
        Self {
            size,
            pieces: vec![NONE; count],
            seams: vec![0.0; count],
            colours: vec![BACKGROUND; count],
        }
    }

    /// A place of the unit square in pixels, y down; the middle of the first pixel is (½, ½).
    fn pixel(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let size = self.size as f64;
        [u * size, (1.0 - v) * size]
    }

    /// Numbers of pixels whose middles lie from `low` to `high`.
    fn range(&self, low: f64, high: f64) -> std::ops::Range<usize> {
        let clamp = |x: f64| x.clamp(0.0, self.size as f64) as usize;
        clamp((low - 0.5).ceil())..clamp((high - 0.5).floor() + 1.0)
    }

    /// Gives pixels to the piece whose triangle has their middle.
    fn fill_triangles(&mut self, opened: &OpenedMesh, charts: &[[f64; 2]], map: &UvMap) {
        for (triangle, &patch) in opened.mesh.triangles().iter().zip(&opened.face_patches) {
            if !map.has_chart[patch as usize] {
                continue;
            }
            let [a, b, c] = triangle.map(|v| self.pixel(map.uv(charts[v.index()])));
            let y = [a[1], b[1], c[1]];
            let low = y.iter().copied().fold(f64::INFINITY, f64::min);
            let high = y.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            for row in self.range(low, high) {
                let y = row as f64 + 0.5;
                let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
                for [p, q] in [[a, b], [b, c], [c, a]] {
                    if (p[1] <= y) == (q[1] <= y) {
                        continue;
                    }
                    let x = p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
                    left = left.min(x);
                    right = right.max(x);
                }
                for column in self.range(left, right) {
                    self.pieces[row * self.size + column] = patch;
                }
            }
        }
    }

    /// Marks seams, and gives free pixels at outlines to their piece: a strip without a pixel's middle is seen all the same.
    fn draw_outlines(
        &mut self,
        opened: &OpenedMesh,
        charts: &[[f64; 2]],
        map: &UvMap,
        seam_width: f64,
    ) {
        let mesh = &opened.mesh;
        for f in mesh.faces() {
            let patch = opened.face_patches[f.index()];
            if !map.has_chart[patch as usize] {
                continue;
            }
            for h in mesh.face_halfedges(f).into_iter().filter(|h| mesh.is_boundary_edge(h.edge()))
            {
                let is_seam = opened.partner(h).is_some();
                let [a, b] =
                    [mesh.tail(h), mesh.tip(h)].map(|v| self.pixel(map.uv(charts[v.index()])));
                self.draw_side(a, b, patch, if is_seam { seam_width } else { 0.0 });
            }
        }
    }

    fn draw_side(&mut self, a: [f64; 2], b: [f64; 2], patch: u32, seam_width: f64) {
        // A pixel is touched by what comes as near as its side from the middle.
        let half = 0.5 * seam_width;
        let reach = half.max(0.0) + 0.5;
        let rows = self.range(a[1].min(b[1]) - reach, a[1].max(b[1]) + reach);
        let columns = self.range(a[0].min(b[0]) - reach, a[0].max(b[0]) + reach);
        for row in rows {
            // Only where the side passes: long diagonals would cost their whole square.
            let y = row as f64 + 0.5;
            let columns = match self.part(a, b, y - reach, y + reach) {
                Some([low, high]) => self.range(low - reach, high + reach),
                None => columns.clone(),
            };
            for column in columns {
                let distance = distance([column as f64 + 0.5, y], a, b);
                let at = row * self.size + column;
                if self.pieces[at] == NONE && distance <= 0.5 {
                    self.pieces[at] = patch;
                }
                if self.pieces[at] == patch && half > 0.0 {
                    let covered = (half - distance + 0.5).clamp(0.0, 1.0) as f32;
                    self.seams[at] = self.seams[at].max(covered);
                }
            }
        }
    }

    /// The range of x of the part of a side between two heights; none where it is level.
    fn part(&self, a: [f64; 2], b: [f64; 2], low: f64, high: f64) -> Option<[f64; 2]> {
        let rise = b[1] - a[1];
        if rise.abs() < 1e-9 {
            return None;
        }
        let at = |y: f64| a[0] + ((y - a[1]) / rise).clamp(0.0, 1.0) * (b[0] - a[0]);
        let [s, t] = [at(low), at(high)];
        Some([s.min(t), s.max(t)])
    }

    fn paint(&mut self, map: &UvMap, params: &AtlasImageParams) {
        let size = self.size as f64;
        let square = params.square.filter(|side| side.is_finite() && *side > 0.0);
        for (at, colour) in self.colours.iter_mut().enumerate() {
            let piece = self.pieces[at];
            if piece == NONE {
                continue;
            }
            let own = params.colours[piece as usize % params.colours.len()];
            let place = [at % self.size, self.size - 1 - at / self.size];
            let is_dark = square.is_some_and(|side| {
                let number = |x: usize| ((x as f64 + 0.5) / size * map.extent / side).floor();
                (number(place[0]) + number(place[1])) % 2.0 > 0.5
            });
            let shade = if is_dark { SHADE } else { 1.0 };
            let seam = f64::from(self.seams[at]);
            let factor = shade * (1.0 - seam) + SEAM * seam;
            *colour = own.map(|x| (f64::from(x) * factor).round() as u8);
        }
    }

    /// Grows all pieces by one pixel at a time, each pixel like a neighbour.
    fn spread(&mut self, padding: u32) {
        let size = self.size;
        let neighbours = move |at: usize| {
            let (x, y) = (at % size, at / size);
            // Sides first: they are nearer than corners.
            let steps =
                [(0, -1), (-1, 0), (1, 0), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1_isize)];
            steps.into_iter().filter_map(move |(dx, dy): (isize, isize)| {
                let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
                (x < size && y < size).then_some(y * size + x)
            })
        };
        let mut front: Vec<usize> = (0..self.pieces.len())
            .filter(|&at| self.pieces[at] != NONE)
            .filter(|&at| neighbours(at).any(|n| self.pieces[n] == NONE))
            .collect();
        for _ in 0..padding {
            let mut next = Vec::new();
            for &at in &front {
                for n in neighbours(at) {
                    if self.pieces[n] == NONE {
                        self.pieces[n] = self.pieces[at];
                        self.colours[n] = self.colours[at];
                        next.push(n);
                    }
                }
            }
            if next.is_empty() {
                break;
            }
            front = next;
        }
    }
}

/// From a point to a segment.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let squared = d[0] * d[0] + d[1] * d[1];
    let along = (p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1];
    let t = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
    (p[0] - a[0] - t * d[0]).hypot(p[1] - a[1] - t * d[1])
}
