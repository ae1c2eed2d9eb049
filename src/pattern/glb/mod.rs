//! The cut surface as GLB (glTF 2), with texture coordinates and a texture inside.
//!
//! Guaranteed: POSITION is the file's coordinates in single precision, nothing else: real size is the scale of the node above,
//! metres as glTF has them. One vertex for each point and place in the map (and normal, where the file has normals), in the
//! order in which the faces use them; `_SOURCE_VERTEX` tells which vertex of the file each is, because glTF keeps no order
//! (vertices on the cut go on from the last of the file; left out beyond 2²⁴, where single precision no longer counts).
//! `_PIECE` is the piece, from 1. A primitive for each material, a node for each group of the file. Faces without a chart are
//! primitives of their own, without texture. v runs down, as glTF has it.
//!
//! ```json
//! {"cutflow": 1, "uv_scale": 2.5, "uv_scale_mm": 512.0, "mm_per_unit": 204.8, "pieces": 7, "input_vertices": 2930}
//! ```
//! are the `extras` of the root node: `uv_scale` is the length of 1 in u and v in units of the file; what is in mm is left out
//! where the real size is not known.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "indices are compared with 16 bits, vertex numbers with 2²⁴, before they are narrowed"
)]

mod parts;
mod singles;

use self::parts::{Part, materials, parts};
use super::bytes::{FileFault, length_u32, push_singles, single};
use super::number::exact;
use super::obj::CutSurface;
use super::png::{Channels, png};
use super::split::Split;
use super::uv_map::UvMap;

/// What is drawn on the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Texture<'a> {
    /// A checker of 32 × 32 squares: shows stretching at once.
    Checker,
    /// A PNG file that covers the unit square, its first row at v = 1.
    Png(&'a [u8]),
}

/// Largest number of vertices whose indices have 16 bits: 65535 itself means "restart".
const SHORT: usize = 65_534;
/// Whole numbers are exact in single precision up to here.
const COUNTABLE: usize = 1 << 24;
/// Squares of the checker along each side, one pixel each.
const SQUARES: u32 = 32;

const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;

/// Bytes of a GLB file.
///
/// **Takes** a place for each vertex of the opened surface (NaN for patches without chart), the length of that unit in units
/// of the file, a name for the model, and its texture. **Fails** beyond 4 GiB. **Costs** O(F).
pub fn uv_glb(
    surface: &CutSurface,
    charts: &[[f64; 2]],
    chart_unit: f64,
    name: &str,
    texture: Texture,
) -> Result<Vec<u8>, FileFault> {
    let map = UvMap::new(surface.opened, charts);
    let split = Split::new(surface);
    let parts = parts(surface, &map);
    let mut file = File::default();
    file.write_parts(&split, &parts);
    let attributes = file.write_attributes(surface, charts, &map, &split);
    if parts.iter().any(|part| part.has_chart) {
        file.write_texture(texture)?;
    }
    file.write_materials(&parts);
    file.write_nodes(surface, &map, chart_unit, name, &parts, &attributes);
    file.finish()
}

/// The two chunks of a GLB while they grow: JSON arrays without their brackets, and bytes.
#[derive(Default)]
struct File {
    binary: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
    materials: Vec<String>,
    meshes: Vec<String>,
    nodes: Vec<String>,
    image: Option<usize>,
    sampler: &'static str,
}

impl File {
    /// A stretch of the binary chunk from `start`, padded to four bytes. **Gives** its number.
    fn view(&mut self, start: usize, target: Option<u32>) -> usize {
        let length = self.binary.len() - start;
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let target = target.map_or(String::new(), |target| format!(", \"target\": {target}"));
        self.views.push(format!(
            "{{\"buffer\": 0, \"byteOffset\": {start}, \"byteLength\": {length}{target}}}"
        ));
        self.views.len() - 1
    }

    /// Indices of all parts; the accessor of part `i` is number `i`.
    fn write_parts(&mut self, split: &Split, parts: &[Part]) {
        let is_short = split.vertices.len() <= SHORT;
        let mut offset = 0;
        for part in parts {
            for v in part.faces.iter().flat_map(|&face| split.triangles[face]) {
                if is_short {
                    self.binary.extend((v as u16).to_le_bytes());
                } else {
                    self.binary.extend(v.to_le_bytes());
                }
            }
            let kind = if is_short { UNSIGNED_SHORT } else { UNSIGNED_INT };
            let count = 3 * part.faces.len();
            self.accessors.push(format!(
                "{{\"bufferView\": 0, \"byteOffset\": {offset}, \"componentType\": {kind}, \
                 \"count\": {count}, \"type\": \"SCALAR\"}}"
            ));
            offset = self.binary.len();
        }
        if !parts.is_empty() {
            self.view(0, Some(ELEMENT_ARRAY_BUFFER));
        }
    }

    /// One attribute of all vertices. **Gives** its entry in a list of attributes.
    fn attribute(&mut self, name: &str, kind: &str, rows: &[f32], limits: &str) -> String {
        let start = self.binary.len();
        push_singles(&mut self.binary, rows.iter().copied());
        let view = self.view(start, Some(ARRAY_BUFFER));
        let columns = match kind {
            "VEC3" => 3,
            "VEC2" => 2,
            _ => 1,
        };
        let count = rows.len() / columns;
        self.accessors.push(format!(
            "{{\"bufferView\": {view}, \"componentType\": {FLOAT}, \"count\": {count}, \
             \"type\": \"{kind}\"{limits}}}"
        ));
        format!("\"{name}\": {}", self.accessors.len() - 1)
    }

    /// All attributes; the last is that of texture coordinates, where there are any.
    fn write_attributes(
        &mut self,
        surface: &CutSurface,
        charts: &[[f64; 2]],
        map: &UvMap,
        split: &Split,
    ) -> Attributes {
        if split.vertices.is_empty() {
            return Attributes::default();
        }
        let places: Vec<[f32; 3]> =
            split.places(surface).into_iter().map(|place| place.map(single)).collect();
        let limits = limits(&places);
        let mut common = vec![self.attribute("POSITION", "VEC3", &places.concat(), &limits)];
        if !split.normals.is_empty() {
            common.push(self.attribute("NORMAL", "VEC3", &split.normals.concat(), ""));
        }
        let sources = split.source_vertices(surface);
        if sources.iter().all(|&v| v <= COUNTABLE) {
            let sources: Vec<f32> = sources.into_iter().map(|v| v as f32).collect();
            common.push(self.attribute("_SOURCE_VERTEX", "SCALAR", &sources, ""));
        }
        let patches = surface.opened.vertex_patches();
        let patch = |&v: &u32| patches[v as usize];
        let pieces: Vec<f32> = split.vertices.iter().map(|v| (patch(v) + 1) as f32).collect();
        common.push(self.attribute("_PIECE", "SCALAR", &pieces, ""));
        let uv = |(v, place): (usize, &[f64; 2])| {
            let [u, v] = match map.has_chart[patches[v] as usize] {
                true => map.uv(*place),
                false => [0.0, 1.0],
            };
            [u, 1.0 - v]
        };
        let places: Vec<[f64; 2]> = charts.iter().enumerate().map(uv).collect();
        let places = singles::rounded(&surface.opened.mesh, &places);
        let uvs: Vec<f32> = split.vertices.iter().flat_map(|v| places[*v as usize]).collect();
        let has_map = !map.placed.is_empty();
        let uv = has_map.then(|| self.attribute("TEXCOORD_0", "VEC2", &uvs, ""));
        Attributes { common: common.join(", "), uv: uv.unwrap_or_default() }
    }

    fn write_texture(&mut self, texture: Texture) -> Result<(), FileFault> {
        let start = self.binary.len();
        self.sampler = match texture {
            Texture::Png(bytes) => {
                self.binary.extend(bytes);
                SMOOTH
            }
            Texture::Checker => {
                self.binary.extend(checker()?);
                SHARP
            }
        };
        self.image = Some(self.view(start, None));
        Ok(())
    }

    /// A material for each name, and twice where some of its faces have no chart.
    fn write_materials(&mut self, parts: &[Part]) {
        for (name, has_chart) in materials(parts) {
            let name =
                name.map_or(String::new(), |name| format!("\"name\": {}, ", json_string(name)));
            let texture = if has_chart { "\"baseColorTexture\": {\"index\": 0}, " } else { "" };
            self.materials.push(format!(
                "{{{name}\"pbrMetallicRoughness\": {{{texture}\"metallicFactor\": 0, \
                 \"roughnessFactor\": 0.9}}, \"doubleSided\": true}}"
            ));
        }
    }

    /// The root node with the real size, and below it one for each group where the file has groups.
    fn write_nodes(
        &mut self,
        surface: &CutSurface,
        map: &UvMap,
        chart_unit: f64,
        name: &str,
        parts: &[Part],
        attributes: &Attributes,
    ) {
        let materials = materials(parts);
        let primitive = |(i, part): (usize, &Part)| {
            let material = materials.iter().position(|m| *m == (part.material, part.has_chart));
            let uv = if part.has_chart { format!(", {}", attributes.uv) } else { String::new() };
            format!(
                "{{\"attributes\": {{{}{uv}}}, \"indices\": {i}, \"material\": {}}}",
                attributes.common,
                material.unwrap_or(0)
            )
        };
        let numbered: Vec<(usize, &Part)> = parts.iter().enumerate().collect();
        let mut children = Vec::new();
        for same in numbered.chunk_by(|(_, a), (_, b)| a.group == b.group) {
            let primitives: Vec<String> = same.iter().copied().map(primitive).collect();
            let label = json_string(same[0].1.group.unwrap_or(name));
            self.meshes.push(format!(
                "{{\"name\": {label}, \"primitives\": [\n{}\n]}}",
                primitives.join(",\n")
            ));
            children.push(format!("{{\"name\": {label}, \"mesh\": {}}}", self.meshes.len() - 1));
        }
        let mut root = format!("{{\"name\": {}", json_string(name));
        let has_groups = parts.iter().any(|part| part.group.is_some());
        if has_groups {
            let list: Vec<String> = (1..=children.len()).map(|i| i.to_string()).collect();
            root += &format!(", \"children\": [{}]", list.join(", "));
        } else if !children.is_empty() {
            root += ", \"mesh\": 0";
        }
        if let Some(mm) = surface.mm_per_unit {
            let mut scale = String::new();
            exact(&mut scale, 0.001 * mm);
            root += &format!(", \"scale\": [{scale}, {scale}, {scale}]");
        }
        root += &format!(", \"extras\": {}}}", extras(surface, map, chart_unit));
        self.nodes.push(root);
        if has_groups {
            self.nodes.extend(children);
        }
    }

    fn finish(self) -> Result<Vec<u8>, FileFault> {
        let mut json = String::from(
            "{\"asset\": {\"version\": \"2.0\", \"generator\": \"Cutflow\"},\n\
             \"scene\": 0,\n\"scenes\": [{\"nodes\": [0]}]",
        );
        let image = self.image.map(|view| {
            format!("{{\"bufferView\": {view}, \"mimeType\": \"image/png\", \"name\": \"atlas\"}}")
        });
        let has_image = image.is_some();
        let only = |text: &str| if has_image { vec![text.to_owned()] } else { Vec::new() };
        let buffer = format!("{{\"byteLength\": {}}}", self.binary.len());
        let buffers = if self.binary.is_empty() { Vec::new() } else { vec![buffer] };
        for (key, items) in [
            ("nodes", self.nodes),
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("textures", only("{\"sampler\": 0, \"source\": 0}")),
            ("images", image.into_iter().collect()),
            ("samplers", only(self.sampler)),
            ("accessors", self.accessors),
            ("bufferViews", self.views),
            ("buffers", buffers),
        ] {
            // An empty array is against the format.
            if !items.is_empty() {
                json += &format!(",\n\"{key}\": [\n{}\n]", items.join(",\n"));
            }
        }
        json += "}";
        while json.len() % 4 > 0 {
            json.push(' ');
        }
        let chunk = |bytes: usize| if bytes > 0 { 8 + bytes } else { 0 };
        let total = 12 + chunk(json.len()) + chunk(self.binary.len());
        let mut out = Vec::with_capacity(total);
        out.extend(b"glTF");
        out.extend(2u32.to_le_bytes());
        out.extend(length_u32(total)?.to_le_bytes());
        for (kind, bytes) in [(b"JSON", json.as_bytes()), (b"BIN\0", &self.binary)] {
            if !bytes.is_empty() {
                out.extend(length_u32(bytes.len())?.to_le_bytes());
                out.extend(kind);
                out.extend(bytes);
            }
        }
        Ok(out)
    }
}

/// Nearest pixels, repeated: squares with sharp edges.
const SHARP: &str =
    "{\"magFilter\": 9728, \"minFilter\": 9728, \"wrapS\": 10497, \"wrapT\": 10497}";
/// Mixed pixels, smaller pictures from afar, and no colour of the other side at the rim.
const SMOOTH: &str =
    "{\"magFilter\": 9729, \"minFilter\": 9987, \"wrapS\": 33071, \"wrapT\": 33071}";

/// Entries of a primitive's list of attributes.
#[derive(Default)]
struct Attributes {
    common: String,
    uv: String,
}

/// Smallest and largest coordinates of what is written, as glTF demands for POSITION.
fn limits(places: &[[f32; 3]]) -> String {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for place in places {
        for i in 0..3 {
            low[i] = low[i].min(place[i]);
            high[i] = high[i].max(place[i]);
        }
    }
    let list = |bound: [f32; 3]| {
        bound.map(|x| {
            let mut text = String::new();
            exact(&mut text, f64::from(x));
            text
        })
    };
    format!(", \"min\": [{}], \"max\": [{}]", list(low).join(", "), list(high).join(", "))
}

fn extras(surface: &CutSurface, map: &UvMap, chart_unit: f64) -> String {
    let mut out = String::from("{\"cutflow\": 1");
    let mut number = |key: &str, x: f64| {
        if x.is_finite() {
            out += &format!(", \"{key}\": ");
            exact(&mut out, x);
        }
    };
    let scale = map.extent * chart_unit;
    if !map.placed.is_empty() {
        number("uv_scale", scale);
        if let Some(mm) = surface.mm_per_unit {
            number("uv_scale_mm", scale * mm);
        }
    }
    if let Some(mm) = surface.mm_per_unit {
        number("mm_per_unit", mm);
    }
    let (pieces, vertices) = (surface.opened.patch_count, surface.soup.positions.len());
    out += &format!(", \"pieces\": {pieces}, \"input_vertices\": {vertices}}}");
    out
}

/// A PNG file of light and dark squares, one pixel each.
fn checker() -> Result<Vec<u8>, FileFault> {
    let colour = |i: u32| match (i % SQUARES + i / SQUARES) % 2 {
        0 => [0xf2, 0xf2, 0xf0],
        _ => [0x8a, 0x97, 0xa6],
    };
    let pixels: Vec<u8> = (0..SQUARES * SQUARES).flat_map(colour).collect();
    png([SQUARES; 2], Channels::Rgb, &pixels, None)
}

/// Text as JSON has it, quotes included.
fn json_string(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out += "\\\"",
            '\\' => out += "\\\\",
            c if c.is_control() => out += &format!("\\u{:04x}", u32::from(c)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
