//! Textures made of pixels, which repeat: a person's image, and two that are made here.
//!
//! Pixels are encoded sRGB. Smaller levels are means of four in linear light, so that far cells keep their brightness.

/// The most pixels along a side: what every device takes, and more than a screen shows of one repeat.
const MOST: u32 = 2048;
/// Pixels along a side of the generated textures.
const SIDE: u32 = 512;

/// Why pixels are no image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PixelsError {
    /// No pixels.
    #[error("the image has no pixels")]
    Empty,
    /// More pixels along a side than textures have.
    #[error("the image has {width} × {height} pixels; textures have up to {MOST} along a side")]
    TooLarge {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
    },
    /// The bytes are not four for each pixel.
    #[error("the image of {width} × {height} pixels has {bytes} bytes in place of four a pixel")]
    Length {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// The bytes.
        bytes: usize,
    },
}

/// A texture that repeats, with all its smaller levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    /// Width, height and RGBA bytes, opaque; each level half as large as the one before, down to one pixel.
    pub levels: Vec<(u32, u32, Vec<u8>)>,
    /// Cells of the texture that one repeat takes, across and up.
    pub cells: [f32; 2],
}

impl Pixels {
    /// The size that an image has to be scaled to.
    pub fn fit(width: u32, height: u32) -> Result<[u32; 2], PixelsError> {
        let longer = width.max(height);
        if width.min(height) == 0 {
            return Err(PixelsError::Empty);
        }
        let side = |pixels: u32| {
            let scaled = u64::from(pixels) * u64::from(MOST) / u64::from(longer.max(MOST));
            u32::try_from(scaled).unwrap_or(MOST).max(1)
        };
        Ok([side(width), side(height)])
    }

    /// From RGBA bytes, row by row from the top; what is transparent lies on white.
    pub fn from_rgba(width: u32, height: u32, rgba: &[u8]) -> Result<Self, PixelsError> {
        if width.min(height) == 0 {
            return Err(PixelsError::Empty);
        }
        if width.max(height) > MOST {
            return Err(PixelsError::TooLarge { width, height });
        }
        let bytes = rgba.len();
        if bytes != 4 * width as usize * height as usize {
            return Err(PixelsError::Length { width, height, bytes });
        }
        let on_white = |&[r, g, b, a]: &[u8; 4]| {
            let over = |c: u8| ((u32::from(c) * u32::from(a) + 127) / 255) as u8 + (255 - a);
            [over(r), over(g), over(b), 255]
        };
        let pixels = rgba.as_chunks().0.iter().flat_map(on_white).collect();
        // Ten cells along the longer side: a motif is about as large as a piece of a dozen.
        let longer = width.max(height) as f32;
        let cells = [width, height].map(|side| 10.0 * side as f32 / longer);
        Ok(Self { levels: levels(width, height, pixels), cells })
    }

    /// The coat of a leopard: rosettes about scattered centres.
    pub fn spots() -> Self {
        Self::generate(9.0, spots_at)
    }

    /// Veins where noise, bent by other noise, passes through its mean.
    pub fn marble() -> Self {
        Self::generate(14.0, marble_at)
    }

    /// **Takes** the colour at a place, which repeats after 1 in both directions.
    fn generate(cells: f32, colour: impl Fn([f32; 2]) -> [f32; 3]) -> Self {
        let mut pixels = Vec::with_capacity(4 * (SIDE * SIDE) as usize);
        for y in 0..SIDE {
            for x in 0..SIDE {
                let place = [x, y].map(|i| (i as f32 + 0.5) / SIDE as f32);
                pixels.extend(colour(place).map(super::color::unit_to_byte));
                pixels.push(255);
            }
        }
        Self { levels: levels(SIDE, SIDE, pixels), cells: [cells; 2] }
    }
}

/// All levels, from the pixels of the largest.
fn levels(width: u32, height: u32, pixels: Vec<u8>) -> Vec<(u32, u32, Vec<u8>)> {
    let linear: Vec<f32> = (0..=255u8).map(|byte| decode(f32::from(byte) / 255.0)).collect();
    let encoded: Vec<u8> =
        (0..4096).map(|i| super::color::unit_to_byte(encode(i as f32 / 4095.0))).collect();
    let mut all = vec![(width, height, pixels)];
    while let Some((w, h, pixels)) = all.last().filter(|(w, h, _)| w.max(h) > &1) {
        let [nw, nh] = [w / 2, h / 2].map(|side| side.max(1));
        let mut next = Vec::with_capacity(4 * (nw * nh) as usize);
        for y in 0..nh {
            for x in 0..nw {
                let at = |dx: u32, dy: u32| {
                    let (x, y) = ((2 * x + dx).min(w - 1), (2 * y + dy).min(h - 1));
                    4 * (y * w + x) as usize
                };
                let corners = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
                for c in 0..3 {
                    let sum: f32 =
                        corners.iter().map(|&i| linear[usize::from(pixels[i + c])]).sum();
                    next.push(encoded[(sum * (4095.0 / 4.0)).round() as usize]);
                }
                next.push(255);
            }
        }
        all.push((nw, nh, next));
    }
    all
}

fn decode(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

fn encode(x: f32) -> f32 {
    if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// A number from 0 to 1 for a cell of a grid that repeats after `period` cells.
fn hash(x: i32, y: i32, period: i32, salt: u32) -> f32 {
    let [x, y] = [x, y].map(|i| i.rem_euclid(period).cast_unsigned());
    let mut h =
        x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ salt.wrapping_mul(0xc2b2_ae3d);
    for (shift, factor) in [(16, 0x7feb_352d), (15, 0x846c_a68b)] {
        h = (h ^ (h >> shift)).wrapping_mul(factor);
    }
    ((h ^ (h >> 16)) >> 8) as f32 / 16_777_216.0
}

/// Smooth noise from 0 to 1 on a grid of `period` cells.
fn noise([x, y]: [f32; 2], period: i32, salt: u32) -> f32 {
    let [x, y] = [x, y].map(|i| i * period as f32);
    let (i, j) = (x.floor(), y.floor());
    let ease = |t: f32| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let (s, t) = (ease(x - i), ease(y - j));
    let at = |dx, dy| hash(i as i32 + dx, j as i32 + dy, period, salt);
    let row = |dy| at(0, dy) * (1.0 - s) + at(1, dy) * s;
    row(0) * (1.0 - t) + row(1) * t
}

/// Octaves of noise, each half as strong and half as large as the one before, from 0 to 1.
fn octaves(place: [f32; 2], period: i32, count: i32, salt: u32) -> f32 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for octave in 0..count {
        let strength = 0.5f32.powi(octave);
        sum += strength * noise(place, period << octave, salt + octave as u32);
        weight += strength;
    }
    sum / weight
}

fn mix(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t.clamp(0.0, 1.0))
}

/// 0 below `low`, 1 above `high`.
fn step(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn spots_at([x, y]: [f32; 2]) -> [f32; 3] {
    const GRID: i32 = 7;
    let bend = |salt| (octaves([x, y], 9, 3, salt) - 0.5) * 0.11;
    let place = [x + bend(11), y + bend(23)].map(|i| i * GRID as f32);
    let cell = place.map(|i| i.floor() as i32);
    // The two nearest centres, and the name of the nearest.
    let (mut near, mut second, mut name, mut from) = (9.0f32, 9.0f32, 0.0, [0.0; 2]);
    for dy in -1..=1 {
        for dx in -1..=1 {
            let at = [cell[0] + dx, cell[1] + dy];
            let jitter = |salt| 0.5 + 0.62 * (hash(at[0], at[1], GRID, salt) - 0.5);
            let to = [place[0] - at[0] as f32 - jitter(3), place[1] - at[1] as f32 - jitter(5)];
            let distance = to[0].hypot(to[1]);
            if distance < near {
                (second, near, from) = (near, distance, to);
                name = hash(at[0], at[1], GRID, 7);
            } else {
                second = second.min(distance);
            }
        }
    }
    let rough = octaves([x, y], 24, 2, 41) - 0.5;
    let fur = mix([0.93, 0.80, 0.55], [0.80, 0.56, 0.29], octaves([x, y], 4, 3, 2));
    let fur = mix(fur, [0.99, 0.94, 0.83], 0.5 * octaves([x, y], 60, 2, 90));
    let size = 0.33 + 0.10 * name;
    let inside = mix(fur, [0.64, 0.39, 0.17], 0.85 * step(size, 0.6 * size, near));
    // A ring in pieces: gaps at angles that each rosette has for itself.
    let angle = from[1].atan2(from[0]);
    let gaps = (3.0 * angle + 6.3 * name).sin() + 0.6 * (5.0 * angle + 17.0 * name).sin();
    let width = 0.085 + 0.05 * rough + 0.02 * name;
    let ring = step(width, 0.6 * width, (near - size).abs()) * step(-0.75, -0.45, gaps + rough);
    // Small dots where three rosettes leave room.
    let room = step(0.66, 0.72, near) * step(0.10, 0.05, second - near);
    mix(inside, [0.13, 0.09, 0.07], ring.max(room))
}

fn marble_at([x, y]: [f32; 2]) -> [f32; 3] {
    let bend = |salt| (octaves([x, y], 3, 4, salt) - 0.5) * 0.42;
    let bent = [x + bend(101), y + bend(131)];
    let vein = |period, salt, width: f32| {
        let distance = (octaves(bent, period, 5, salt) - 0.5).abs();
        step(width, 0.0, distance)
    };
    let clouds = octaves(bent, 4, 5, 7);
    let stone = mix([0.96, 0.95, 0.93], [0.74, 0.76, 0.79], step(0.35, 0.75, clouds));
    let strong =
        0.85 * vein(3, 61, 0.015) * (0.35 + 0.65 * step(0.3, 0.6, octaves([x, y], 5, 2, 17)));
    let stone = mix(stone, [0.55, 0.58, 0.62], 0.55 * vein(3, 61, 0.09));
    let stone = mix(stone, [0.72, 0.60, 0.40], 0.6 * vein(6, 83, 0.016));
    mix(stone, [0.16, 0.18, 0.22], strong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_halve_down_to_one_pixel_and_keep_the_mean_in_linear_light() {
        // Black and white columns: half the light, which is no middle grey.
        let row: Vec<u8> = [[0, 0, 0, 255], [255; 4]].concat().repeat(6);
        let pixels = Pixels::from_rgba(12, 5, &row.repeat(5)).expect("an image");
        let sizes: Vec<[u32; 2]> = pixels.levels.iter().map(|&(w, h, _)| [w, h]).collect();
        assert_eq!(sizes, [[12, 5], [6, 2], [3, 1], [1, 1]]);
        assert_eq!(pixels.levels[3].2, [188, 188, 188, 255]);
        assert!(pixels.levels.iter().all(|(w, h, p)| p.len() == 4 * (w * h) as usize));
        assert!((pixels.cells[0] / pixels.cells[1] - 12.0 / 5.0).abs() < 1e-6);
    }

    #[test]
    fn what_is_transparent_lies_on_white_and_what_is_no_image_is_refused() {
        let glass = Pixels::from_rgba(1, 1, &[200, 0, 100, 0]).expect("an image");
        assert_eq!(glass.levels[0].2, [255; 4]);
        let half = Pixels::from_rgba(1, 1, &[0, 0, 255, 128]).expect("an image");
        assert_eq!(half.levels[0].2, [127, 127, 255, 255]);
        assert_eq!(Pixels::from_rgba(0, 4, &[]), Err(PixelsError::Empty));
        let length = PixelsError::Length { width: 2, height: 2, bytes: 15 };
        assert_eq!(Pixels::from_rgba(2, 2, &[0; 15]), Err(length));
        let large = PixelsError::TooLarge { width: 2049, height: 1 };
        assert_eq!(Pixels::from_rgba(2049, 1, &[0; 8196]), Err(large));
    }

    #[test]
    fn large_images_are_to_be_scaled_and_small_ones_are_left_as_they_are() {
        assert_eq!(Pixels::fit(640, 480), Ok([640, 480]));
        assert_eq!(Pixels::fit(8192, 4096), Ok([2048, 1024]));
        assert_eq!(Pixels::fit(100_000, 1), Ok([2048, 1]));
        assert_eq!(Pixels::fit(0, 7), Err(PixelsError::Empty));
    }

    #[test]
    fn generated_textures_repeat_without_a_seam_and_have_contrast() {
        for pixels in [Pixels::spots(), Pixels::marble()] {
            let (w, h, bytes) = &pixels.levels[0];
            let grey = |x: u32, y: u32| i32::from(bytes[4 * (y * w + x) as usize + 1]);
            // A seam is a column that differs from the next by far more than columns do elsewhere.
            let column = |x: u32| -> i32 {
                (0..*h).map(|y| (grey(x, y) - grey((x + 1) % w, y)).abs()).sum()
            };
            let row = |y: u32| -> i32 {
                (0..*w).map(|x| (grey(x, y) - grey(x, (y + 1) % h)).abs()).sum()
            };
            let most = |line: &dyn Fn(u32) -> i32| (0..w - 1).map(line).max().unwrap_or(0);
            assert!(column(w - 1) <= most(&column) && row(h - 1) <= most(&row));
            let all: Vec<i32> = (0..w * h).map(|i| grey(i % w, i / w)).collect();
            let range = all.iter().max().zip(all.iter().min()).map_or(0, |(a, b)| a - b);
            assert!(range > 150, "{range}");
        }
    }
}
