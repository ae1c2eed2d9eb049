//! Pictures that the engine draws itself, so that page and command write the same ones: for covers and archives.

use nalgebra::{Point3, Vector3};

use super::super::exporting::stem;
use super::super::message::File;
use super::super::scene::PALETTE;
use super::super::text::Problem;
use super::super::work::Work;
use super::super::{nothing_open, picture};
use super::exports::too_large;
use crate::pattern::{self, Channels, Picture, PortraitParams, piece_name, portrait, side_by_side};

/// Of each half of the picture on a cover, pixels: 50 mm at 300 dpi.
const COVER: [u32; 2] = [480, 600];
/// Of each half of the picture of the surface in a file.
const SURFACE: [u32; 2] = [900, 900];
/// Of the picture of the pieces.
const PIECES: [u32; 2] = [1200, 1200];
/// Where the page looks from at first: angles about the upright axis and above the ground.
const EYE: [f64; 2] = [0.55, 0.26];

impl Work {
    /// The surface from the front and from the back, its pieces in their colours with their names.
    pub(super) fn surface_picture(&self, half: [u32; 2]) -> Option<Picture> {
        let layout = self.layout.as_ref()?;
        let points = &layout.opened.vertex_points;
        let places: Vec<Point3<f64>> = points.iter().map(|&p| layout.points[p as usize]).collect();
        let [turn, tilt] = EYE;
        let from = |turn: f64| {
            let towards =
                Vector3::new(turn.sin() * tilt.cos(), tilt.sin(), turn.cos() * tilt.cos());
            self.portrait(&places, half, towards, Vector3::y())
        };
        Some(side_by_side(&from(turn)?, &from(turn + std::f64::consts::PI)?))
    }

    /// The picture on the cover of a PDF.
    pub(super) fn cover_picture(&self) -> Option<Picture> {
        self.surface_picture(COVER)
    }

    fn portrait(
        &self,
        places: &[Point3<f64>],
        size: [u32; 2],
        towards: Vector3<f64>,
        up: Vector3<f64>,
    ) -> Option<Picture> {
        let layout = self.layout.as_ref()?;
        let colours = picture::patch_colours(layout, &self.labels());
        let colours: Vec<[u8; 3]> = colours.iter().map(|&colour| rgb(colour)).collect();
        let names: Vec<String> = (0..layout.opened.patch_count).map(piece_name).collect();
        let params = PortraitParams { size, towards, up, colours: &colours, names: &names };
        (!colours.is_empty()).then(|| portrait(&layout.opened, places, &params))
    }

    /// Pictures as PNG files: the surface from two sides, and all pieces.
    pub(super) fn picture_files(&mut self) -> Result<[File; 2], Problem> {
        let surface = self.surface_picture(SURFACE).ok_or_else(nothing_open)?;
        let places: Vec<Point3<f64>> =
            self.uv_charts()?.iter().map(|&[u, v]| Point3::new(u, v, 0.0)).collect();
        let pieces =
            self.portrait(&places, PIECES, Vector3::z(), Vector3::y()).ok_or_else(nothing_open)?;
        Ok([self.png(&surface, "surface")?, self.png(&pieces, "pattern")?])
    }

    fn png(&self, picture: &Picture, what: &str) -> Result<File, Problem> {
        let size = [picture.width, picture.height];
        let bytes = pattern::png(size, Channels::Rgb, &picture.rgb, None)
            .map_err(|fault| too_large(&self.document.name, fault))?;
        let name = format!("{}-{what}.png", stem(&self.document.name));
        Ok(File { name, mime: "image/png", bytes })
    }
}

/// A colour of the palette.
pub(super) fn rgb(colour: u8) -> [u8; 3] {
    let [_, red, green, blue] = PALETTE[usize::from(colour) % PALETTE.len()].to_be_bytes();
    [red, green, blue]
}
