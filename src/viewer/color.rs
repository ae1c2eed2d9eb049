//! Colours: sRGB and OKLab, the palette of the regions, the maps of the fields, the tokens of both themes.
//!
//! Everything here is in *encoded* sRGB, because that is what the canvases hold: shaders decode
//! where they compute light and encode what they write, so that a picture does not depend on
//! whether a backend offers an sRGB surface.

use crate::session::scene::{PALETTE, PatchScene};

/// Signed fields, zero at the centre.
const DIVERGING: [u32; 9] =
    [0x1f4e9e, 0x4d80c4, 0x8db4e0, 0xcfdfef, 0xf6f5f3, 0xf3d3c8, 0xe29c88, 0xc65f52, 0x9c2430];
/// Unsigned fields: viridis.
const SEQUENTIAL: [u32; 9] =
    [0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725];
/// A patch without a palette entry, such as a rejected mesh, and a vertex without a value.
pub const NEUTRAL: Rgb = Rgb([0xc4 as f32 / 255.0, 0xc6 as f32 / 255.0, 0xcb as f32 / 255.0]);
/// Faces that a finding names: lighter than [`WARNING`], so that lines in it stay visible.
pub const MARKED: Rgb = Rgb([0xf0 as f32 / 255.0, 0x8a as f32 / 255.0, 0x80 as f32 / 255.0]);
/// Cuts and chart outlines.
pub const CUT: Rgb = Rgb([0x20 as f32 / 255.0, 0x22 as f32 / 255.0, 0x2b as f32 / 255.0]);
/// The light line beside a cut.
pub const CASING: Rgb = Rgb([1.0, 1.0, 1.0]);
/// Places that an error points at, and triangles that are turned over.
pub const WARNING: Rgb = Rgb([0xd9 as f32 / 255.0, 0x1f as f32 / 255.0, 0x2a as f32 / 255.0]);

/// How much darker the second colour of a piece's texture is, in OKLab lightness. Twice as much competes
/// with the cuts; half as much is lost under the shading of the surface.
const TEXTURE_CONTRAST: f32 = 0.055;

/// An encoded sRGB colour, components 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rgb(pub [f32; 3]);

impl Rgb {
    /// From `0xrrggbb`.
    pub fn from_hex(hex: u32) -> Self {
        Self([16, 8, 0].map(|shift| ((hex >> shift) & 0xff) as f32 / 255.0))
    }

    /// The four bytes of an opaque pixel.
    pub fn bytes(self) -> [u8; 4] {
        let [r, g, b] = self.0.map(unit_to_byte);
        [r, g, b, 255]
    }

    fn to_oklab(self) -> [f32; 3] {
        let [r, g, b] = self.0.map(decode);
        let l = (0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b).cbrt();
        let m = (0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b).cbrt();
        let s = (0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b).cbrt();
        [
            0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
            1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
            0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
        ]
    }

    fn from_oklab([lightness, a, b]: [f32; 3]) -> Self {
        let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
        let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
        let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
        Self(
            [
                4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
                -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
                -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
            ]
            .map(encode),
        )
    }

    /// The darker partner of a piece's colour in its texture.
    pub fn darker(self) -> Self {
        let [lightness, a, b] = self.to_oklab();
        Self::from_oklab([lightness - TEXTURE_CONTRAST, a, b])
    }
}

/// The colour of region `index`; beyond the palette the neutral grey of something that is no region, or the paler red of faces
/// that a finding names.
pub fn region(index: u8) -> Rgb {
    match PALETTE.get(usize::from(index)) {
        Some(&hex) => Rgb::from_hex(hex),
        None if index == PatchScene::MARKED => MARKED,
        None => NEUTRAL,
    }
}

/// The RGBA bytes of a colour map over its range, interpolated in OKLab: `size` pixels.
pub fn ramp(signed: bool, size: usize) -> Vec<u8> {
    let stops = oklab_stops(if signed { &DIVERGING } else { &SEQUENTIAL });
    let at = |pixel: usize| between(&stops, pixel as f32 / (size - 1) as f32);
    (0..size).flat_map(|pixel| at(pixel).bytes()).collect()
}

/// The colour at `place` of the diverging map, 0 to 1.
pub fn diverging(place: f32) -> Rgb {
    between(&oklab_stops(&DIVERGING), place.clamp(0.0, 1.0))
}

fn oklab_stops(table: &[u32; 9]) -> [[f32; 3]; 9] {
    table.map(|hex| Rgb::from_hex(hex).to_oklab())
}

fn between(stops: &[[f32; 3]; 9], place: f32) -> Rgb {
    let x = place * (stops.len() - 1) as f32;
    let left = (x as usize).min(stops.len() - 2);
    let t = x - left as f32;
    Rgb::from_oklab([0, 1, 2].map(|i| stops[left][i] * (1.0 - t) + stops[left + 1][i] * t))
}

/// Where `value` lies on the map over `range`, 0 to 1; [`NO_VALUE`] for NaN.
pub fn place_on_ramp(value: f32, range: [f32; 2]) -> f32 {
    if value.is_nan() {
        return NO_VALUE;
    }
    let width = range[1] - range[0];
    if width > 0.0 { ((value - range[0]) / width).clamp(0.0, 1.0) } else { 0.5 }
}

/// The map of a field of labels: the palette in bands, so that a label has the colour of its region.
pub fn label_ramp(size: usize) -> Vec<u8> {
    let band = |pixel: usize| (pixel * PALETTE.len() / size) as u8;
    (0..size).flat_map(|pixel| region(band(pixel)).bytes()).collect()
}

/// Where a label lies on its map: in the middle of its band. Labels beyond the palette begin it again.
pub fn place_of_label(label: f32) -> f32 {
    if label.is_nan() {
        return NO_VALUE;
    }
    let bands = PALETTE.len() as f32;
    (label.round().rem_euclid(bands) + 0.5) / bands
}

/// Marks a vertex without a value. So far below 0 that a triangle with one such corner is grey
/// almost throughout: shaders must not be handed NaN, which they may assume away.
pub const NO_VALUE: f32 = -1e4;

/// What differs between light and dark.
#[derive(Clone, Copy, Debug)]
pub struct Theme {
    /// The ground behind surface and charts.
    pub background: Rgb,
    /// Outline of the patch under the pointer.
    pub accent: Rgb,
    /// Largest opacity of the ground shadow: black is lost on a dark ground unless it is stronger.
    pub shadow: f32,
}

impl Theme {
    /// The tokens of the page.
    pub fn new(dark: bool) -> Self {
        if dark {
            Self {
                background: Rgb::from_hex(0x101114),
                accent: Rgb::from_hex(0x99a4ff),
                shadow: 0.5,
            }
        } else {
            Self {
                background: Rgb::from_hex(0xf3f4f6),
                accent: Rgb::from_hex(0x4453c9),
                shadow: 0.42,
            }
        }
    }
}

/// 0 to 1 as a byte.
pub fn unit_to_byte(x: f32) -> u8 {
    // `as` saturates and takes NaN to 0.
    (x * 255.0).round() as u8
}

fn decode(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

fn encode(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oklab_there_and_back_returns_every_table_colour() {
        for hex in PALETTE.iter().chain(&DIVERGING).chain(&SEQUENTIAL) {
            let colour = Rgb::from_hex(*hex);
            assert_eq!(Rgb::from_oklab(colour.to_oklab()).bytes(), colour.bytes(), "{hex:06x}");
        }
    }

    #[test]
    fn a_ramp_begins_and_ends_with_its_table_and_is_neutral_in_the_middle() {
        let ramp = ramp(true, 257);
        assert_eq!(ramp[..4], Rgb::from_hex(0x1f4e9e).bytes());
        assert_eq!(ramp[4 * 128..4 * 129], Rgb::from_hex(0xf6f5f3).bytes());
        assert_eq!(ramp[4 * 256..], Rgb::from_hex(0x9c2430).bytes());
    }

    #[test]
    fn a_texture_darkens_lightness_alone() {
        for hex in PALETTE {
            let [light, a, b] = Rgb::from_hex(hex).to_oklab();
            let [dark, a2, b2] = Rgb::from_hex(hex).darker().to_oklab();
            // Looser than rounding: the darkest reds leave the gamut by a hair and are clamped.
            assert!((light - dark - TEXTURE_CONTRAST).abs() < 4e-3, "{hex:06x}");
            assert!((a - a2).abs() < 4e-3 && (b - b2).abs() < 4e-3, "{hex:06x}");
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "exact by construction")]
    fn values_are_placed_on_the_ramp_and_nan_beside_it() {
        assert_eq!(place_on_ramp(0.0, [-2.0, 2.0]), 0.5);
        assert_eq!(place_on_ramp(9.0, [-2.0, 2.0]), 1.0);
        assert_eq!(place_on_ramp(f32::NAN, [-2.0, 2.0]), NO_VALUE);
        assert_eq!(place_on_ramp(3.0, [3.0, 3.0]), 0.5);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "exact by construction")]
    fn a_label_is_painted_in_the_colour_of_its_region() {
        let ramp = label_ramp(256);
        for (label, index) in [(0.0, 0), (3.2, 3), (8.0, 8), (9.0, 0), (14.0, 5)] {
            let pixel = (place_of_label(label) * 255.0).round() as usize;
            assert_eq!(ramp[4 * pixel..][..4], region(index).bytes(), "{label}");
        }
        assert_eq!(place_of_label(f32::NAN), NO_VALUE);
    }

    #[test]
    fn an_unknown_region_is_neutral() {
        assert_eq!(region(200), NEUTRAL);
        assert_eq!(region(8).bytes(), [0xdb, 0x8f, 0xae, 255]);
    }
}
