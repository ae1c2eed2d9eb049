//! Files of patterns, and of meshes with UV maps.

use std::rc::Rc;

use super::super::exporting::stem;
use super::super::layout::Layout;
use super::super::message::File;
use super::super::params::{Settings, whole};
use super::super::text::Problem;
use super::super::work::Work;
use super::super::{nothing_open, picture, size};
use super::Patterning;
use super::pictures::rgb;
use crate::pattern::{
    self, AstmParams, AtlasImageParams, Channels, DxfParams, FileFault, NestShape, PdfParams,
    SvgParams, SvgProfile, Texture, UvPackParams, WriteError, ZipEntry, pack_uv,
};

/// Squares along the side of the baked texture's unit: about as many as the plain checkerboard has.
const SQUARES: f64 = 32.0;
/// Width of the seams in baked textures, pixels.
const SEAM_PX: f64 = 3.0;

/// Everything that one archive holds, besides reports.
const ARCHIVED: [&str; 9] = [
    "Pattern (SVG)",
    "Pattern (DXF)",
    "Pattern (PDF)",
    "UV mesh (OBJ)",
    "UV mesh (GLB)",
    "Flat mesh (OBJ)",
    "Cut surface (PLY)",
    "Cut curves (OBJ)",
    "Cut (JSON)",
];

pub(super) fn svg_params(settings: &Settings) -> SvgParams {
    SvgParams {
        profile: match settings.text("svg_profile") {
            "laser" => SvgProfile::Laser,
            _ => SvgProfile::Print,
        },
        ..SvgParams::default()
    }
}

/// **Takes** for each piece on the sheet whether it is mirrored.
fn dxf_params(settings: &Settings, mirrored: impl Iterator<Item = bool>) -> DxfParams {
    match settings.text("dxf_profile") {
        profile @ ("astm" | "gerber") => DxfParams::Astm(AstmParams {
            is_gerber: profile == "gerber",
            // Every copy is a block of its own.
            quantities: mirrored.map(|is| if is { [0, 1] } else { [1, 0] }).collect(),
            ..AstmParams::default()
        }),
        profile => DxfParams::Plain {
            is_exploded: profile == "exploded",
            is_strict: !settings.is_on("dxf_unit"),
        },
    }
}

pub(super) fn unwritten(name: &str, error: &WriteError) -> Problem {
    let what_to_do = match error {
        WriteError::NoRoom { .. } => "Choose a larger page or a smaller overlap.",
        WriteError::TooManyPages { .. } => "Choose larger paper, one page, or a smaller size.",
        _ => "Choose another size, or reset the run.",
    };
    Problem::new("The pattern cannot be written.", format!("{name}: {error}."), what_to_do)
}

pub(super) fn too_large(name: &str, fault: FileFault) -> Problem {
    Problem::new(
        "The file cannot be written.",
        format!("{name}: {fault}."),
        "Choose another format.",
    )
}

/// The side of the texture, pixels.
fn pixels(settings: &Settings) -> u32 {
    settings.text("uv_pixels").parse().unwrap_or(1024)
}

/// The outlines of all charts.
fn chart_shapes(layout: &Layout) -> Vec<NestShape> {
    let opened = &layout.opened;
    let uv = &layout.flattening.uv;
    let mut shapes = vec![NestShape::default(); opened.patch_count];
    for &outside in opened.mesh.boundary_loops() {
        let mut points: Vec<[f64; 2]> = opened
            .mesh
            .boundary_loop(outside)
            .map(|h| uv[opened.mesh.tail(h).index()])
            .map(|p| [p.x, p.y])
            .collect();
        points.reverse();
        let Some(face) =
            opened.mesh.boundary_loop(outside).find_map(|h| opened.mesh.face(h.twin()))
        else {
            continue;
        };
        shapes[opened.face_patches[face.index()] as usize].outlines.push(points);
    }
    for shape in &mut shapes {
        // The outer outline is the one that encloses most.
        let area = |points: &Vec<[f64; 2]>| {
            let next = points.iter().cycle().skip(1);
            points.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
        };
        shape.outlines.sort_by(|a, b| area(b).total_cmp(&area(a)));
    }
    shapes
}

impl Work {
    /// The charts in the unit square, with a margin that is kept in pixels. Where they lie on the screen is of no account: equal cuts give equal
    /// files. Several files of a layout share one packing, which takes seconds.
    pub(super) fn uv_charts(&mut self) -> Result<Rc<Vec<[f64; 2]>>, Problem> {
        let layout = self.layout.as_mut().ok_or_else(nothing_open)?;
        let params = UvPackParams {
            pixels: pixels(&self.settings),
            margin_px: u32::try_from(whole(self.settings.number("uv_margin"))).unwrap_or(8),
            ..UvPackParams::default()
        };
        if let Some((_, charts)) = layout.uv.as_ref().filter(|(known, _)| *known == params) {
            return Ok(charts.clone());
        }
        let packing = pack_uv(&chart_shapes(layout), &params)
            .map_err(|error| Problem::solve(&self.document.name, &error))?;
        let uv = &layout.flattening.uv;
        let place = |(v, &patch): (usize, &u32)| {
            packing.apply(patch as usize, [uv[v].x, uv[v].y]).map(|x| x / packing.scale)
        };
        let charts: Rc<Vec<[f64; 2]>> =
            Rc::new(layout.vertex_patches.iter().enumerate().map(place).collect());
        layout.uv = Some((params, charts.clone()));
        Ok(charts)
    }

    /// A drawing of the pattern, a mesh with its UV map, or a picture; none for other kinds.
    pub(in super::super) fn pattern_export(&mut self, kind: &str) -> Option<Result<File, Problem>> {
        if let Some(which) =
            ["Surface picture (PNG)", "Pattern picture (PNG)"].iter().position(|&k| k == kind)
        {
            return Some(self.picture_files().map(|files| files[which].clone()));
        }
        let bytes = match kind {
            "Pattern (SVG)" => self.svg_bytes(),
            "Pattern (DXF)" => self.dxf_bytes(),
            "Pattern (PDF)" => self.pdf_bytes(),
            "UV mesh (OBJ)" | "UV mesh (GLB)" | "Cut surface (PLY)" => self.uv_mesh(kind),
            "Flat mesh (OBJ)" => self.flat_mesh(),
            _ => return None,
        };
        let (suffix, mime) = match kind {
            "Pattern (SVG)" => ("pattern.svg", "image/svg+xml"),
            "Pattern (DXF)" => ("pattern_mm.dxf", "image/vnd.dxf"),
            "Pattern (PDF)" => ("pattern.pdf", "application/pdf"),
            "UV mesh (OBJ)" => ("uv.obj", "model/obj"),
            "UV mesh (GLB)" => ("uv.glb", "model/gltf-binary"),
            "Cut surface (PLY)" => ("uv.ply", "application/octet-stream"),
            _ => ("flat.obj", "model/obj"),
        };
        let name = format!("{}-{suffix}", stem(&self.document.name));
        Some(bytes.map(|bytes| File { name, mime, bytes }))
    }

    fn svg_bytes(&mut self) -> Result<Vec<u8>, Problem> {
        let sheet = self.sheet()?;
        pattern::svg(&sheet, &svg_params(&self.settings))
            .map_err(|error| unwritten(&self.document.name, &error))
    }

    fn dxf_bytes(&mut self) -> Result<Vec<u8>, Problem> {
        let sheet = self.sheet()?;
        let made = self.patterning.iter().flat_map(Patterning::mirrored);
        pattern::dxf(&sheet, &dxf_params(&self.settings, made))
            .map_err(|error| unwritten(&self.document.name, &error))
    }

    fn pdf_bytes(&mut self) -> Result<Vec<u8>, Problem> {
        let sheet = self.sheet()?;
        let params = PdfParams { picture: self.cover_picture(), ..self.pdf_params() };
        pattern::pdf(&sheet, &params).map_err(|error| unwritten(&self.document.name, &error))
    }

    fn uv_mesh(&mut self, kind: &str) -> Result<Vec<u8>, Problem> {
        let charts = self.uv_charts()?;
        let document = &*self.document;
        let given = document.surface()?;
        let layout = self.layout.as_ref().ok_or_else(nothing_open)?;
        let scale = size::mm_per_file_unit(document, &self.settings);
        let surface = layout.surface(given, Some(scale));
        let unit = 1.0 / given.frame.scale;
        match kind {
            "UV mesh (OBJ)" => Ok(pattern::uv_obj(&surface, &charts, unit)),
            "Cut surface (PLY)" => Ok(pattern::uv_ply(&surface, &charts, unit)),
            _ => {
                let baked = (self.settings.text("uv_texture") == "atlas")
                    .then(|| self.baked(&charts))
                    .transpose()?;
                let texture = baked.as_deref().map_or(Texture::Checker, Texture::Png);
                pattern::uv_glb(&surface, &charts, unit, &stem(&document.name), texture)
                    .map_err(|fault| too_large(&document.name, fault))
            }
        }
    }

    /// The texture of the UV map: pieces in their colours, in squares, as PNG.
    fn baked(&self, charts: &[[f64; 2]]) -> Result<Vec<u8>, Problem> {
        let layout = self.layout.as_ref().ok_or_else(nothing_open)?;
        let colours = picture::patch_colours(layout, &self.labels());
        let palette: Vec<[u8; 3]> = colours.iter().map(|&colour| rgb(colour)).collect();
        let side = pixels(&self.settings);
        let all = charts.iter().flatten().copied().filter(|x| x.is_finite());
        let extent = all.fold(0.0, f64::max);
        let params = AtlasImageParams {
            size: side,
            colours: &palette,
            square: (extent > 0.0).then_some(extent / SQUARES),
            seam_width: SEAM_PX,
            padding: u32::try_from(whole(self.settings.number("uv_margin")) / 2).unwrap_or(4),
        };
        let pixels = pattern::atlas_image(&layout.opened, charts, &params);
        pattern::png([side; 2], Channels::Rgb, &pixels, None)
            .map_err(|fault| too_large(&self.document.name, fault))
    }

    fn flat_mesh(&mut self) -> Result<Vec<u8>, Problem> {
        let charts = self.uv_charts()?;
        let document = &*self.document;
        let given = document.surface()?;
        let layout = self.layout.as_ref().ok_or_else(nothing_open)?;
        let scale = size::mm_per_file_unit(document, &self.settings);
        Ok(pattern::flat_obj(
            &layout.surface(given, Some(scale)),
            &charts,
            Some(self.mm_per_unit()),
        ))
    }

    /// All files in one, after those that are given.
    pub(in super::super) fn archive(&mut self, mut files: Vec<File>) -> Result<File, Problem> {
        for kind in ARCHIVED {
            files.push(self.export(kind)?);
        }
        files.extend(self.picture_files()?);
        files.push(self.export("Report (JSON)")?);
        let sheet = self.sheet()?;
        let report = self.report_of(&sheet)?;
        let stem = stem(&self.document.name);
        files.push(File {
            name: format!("{stem}-pattern.json"),
            mime: "application/json",
            bytes: self.json(&report)?,
        });
        let entries: Vec<ZipEntry> =
            files.iter().map(|file| ZipEntry { name: &file.name, bytes: &file.bytes }).collect();
        let bytes =
            pattern::zip(&entries).map_err(|fault| too_large(&self.document.name, fault))?;
        Ok(File { name: format!("{stem}-cutflow.zip"), mime: "application/zip", bytes })
    }
}
