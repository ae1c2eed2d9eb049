//! What a picture needs, as plain arrays: the only thing that the viewer knows of the engine.
//!
//! A scene is one *opened* mesh drawn twice. Its vertices are the corners of the cut surface after
//! opening: a point on a cut occurs once for each side (and once more at a junction), so that every
//! vertex belongs to exactly one patch and has exactly one place on the flattened view. The surface
//! view reads [`Scene::positions`], the flattened view [`Scene::charts`], and both share triangles,
//! patches and values.
//!
//! Guaranteed: all numbers finite except `charts` and `values`, which are NaN where a patch has no
//! chart yet or a field no value; every index in range. Not guaranteed: that charts are free of flips
//! ([`PatchScene::flipped`] says so).

/// Nine region colours of even lightness, sRGB, chosen for distance under the three colour deficiencies.
pub const PALETTE: [u32; 9] =
    [0xefa38f, 0xc3a657, 0xe2cb77, 0xb3deb7, 0x8adfff, 0x92c1fe, 0xa9a0dc, 0xebadcf, 0xdb8fae];

/// One drawable state. All per-vertex arrays have `vertex_count()` entries (times their stride).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// 3 per vertex: recentred and scaled so that the surface fits the unit ball about the origin.
    /// Changes only for points on cuts while a flow runs.
    pub positions: Vec<f32>,
    /// 3 per vertex, unit.
    pub normals: Vec<f32>,
    /// 2 per vertex: place in the packed layout, y up, in the same unit as `positions`; NaN without chart.
    pub charts: Vec<f32>,
    /// 1 per vertex, or empty where no field is shown.
    pub values: Vec<f32>,
    /// 1 per vertex: index into `patches`.
    pub vertex_patches: Vec<u32>,
    /// 3 per triangle, counter-clockwise seen from outside; scene vertices.
    pub triangles: Vec<u32>,
    /// 1 per triangle: the input face that it is a part of.
    pub triangle_faces: Vec<u32>,
    /// 2 per segment: the rims of all patches, patch on the left; scene vertices.
    pub rims: Vec<u32>,
    /// 1 per segment: the segment across the cut, `u32::MAX` on the mesh's own boundary.
    pub rim_partners: Vec<u32>,
    /// One for each patch.
    pub patches: Vec<PatchScene>,
    /// `[x_min, y_min, x_max, y_max]` of the layout.
    pub sheet: [f32; 4],
    /// The field in `values`.
    pub field: Option<FieldScene>,
    /// Places to point at: 3 per point, in the frame of `positions`.
    pub mark_points: Vec<f32>,
    /// Lines to point at: 6 per segment, in the frame of `positions`.
    pub mark_segments: Vec<f32>,
    /// Cones: 3 per cone, in the frame of `positions`.
    pub cone_points: Vec<f32>,
    /// Angle of each cone, radians; positive like a mountain's top.
    pub cone_angles: Vec<f32>,
    /// 2 per place that a cone has on the charts: scene vertex, cone. A cone that several seams meet has several places.
    pub cone_charts: Vec<u32>,
    /// Whether the surface is shown in another shape than its own: soft shade of its hollows would lie in the wrong places.
    pub is_folded: bool,
    /// 0 for the first scene of a mesh, then counting: a viewer refits its camera when this is 0.
    pub revision: u32,
    /// Overlapping charts whose textures blend into each other, where there are any.
    pub layers: Option<LayerScene>,
}

/// Overlapping charts of the same surface, all in one mesh: a place on the surface occurs once in each chart that covers it. Their weights
/// there add up to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerScene {
    /// 3 per vertex, in the frame of [`Scene::positions`]; the same bits in each chart.
    pub positions: Vec<f32>,
    /// 3 per vertex, unit.
    pub normals: Vec<f32>,
    /// 2 per vertex: where the texture is read, in the unit of `positions`. 0 without chart.
    pub uvs: Vec<f32>,
    /// 2 per vertex: place in the packed layout, y up; NaN without chart.
    pub places: Vec<f32>,
    /// 4 per vertex: the weight of its chart, and those of up to three other charts that cover the triangle; −1 for none.
    pub weights: Vec<f32>,
    /// 1 per vertex: index into `charts`.
    pub vertex_charts: Vec<u32>,
    /// 3 per triangle, counter-clockwise seen from outside; vertices of the layers.
    pub triangles: Vec<u32>,
    /// 2 per segment: the rims of all charts, cuts among them.
    pub rims: Vec<u32>,
    /// One for each chart.
    pub charts: Vec<PatchScene>,
    /// `[x_min, y_min, x_max, y_max]` of the layout.
    pub sheet: [f32; 4],
}

/// How one patch is drawn and named.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchScene {
    /// Index into the qualitative palette of nine colours.
    pub color: u8,
    /// Fraction of the surface's area.
    pub area_fraction: f32,
    /// Where its number is written on the flattened view; NaN without chart.
    pub anchor: [f32; 2],
    /// Number of triangles of its chart that are turned over.
    pub flipped: u32,
    /// Whether it has a chart.
    pub has_chart: bool,
}

/// A field's name and range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldScene {
    /// Stable identifier, such as `u`.
    pub id: String,
    /// What the legend says, such as `Scale factor u`.
    pub label: String,
    /// Unit, or empty.
    pub unit: String,
    /// Smallest and largest value shown (the range of the colour map; symmetric when signed).
    pub range: [f32; 2],
    /// Area-weighted mean.
    pub mean: f32,
    /// Smallest and largest value.
    pub extremes: [f32; 2],
    /// Signed fields use the diverging map with zero at its centre.
    pub signed: bool,
    /// Area per bin over `range`, largest bin 1.
    pub histogram: Vec<f32>,
}

impl PatchScene {
    /// Colour of something that is no patch: beyond the palette, drawn in grey.
    pub const NEUTRAL: u8 = u8::MAX;
    /// Colour of faces that a finding names.
    pub const MARKED: u8 = u8::MAX - 1;
}

impl Scene {
    /// Number of scene vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions.len() / 3
    }
}
