//! One view of a [`Stage`] on a texture: pipelines, buffers that only grow, a handful of draw calls.

use super::arrays::{self, CHART_STRIDE, GEOMETRY_STRIDE, PAINT_STRIDE, RIBBON_STRIDE};
use super::color::{CASING, CUT, NEUTRAL, Rgb, WARNING};
use super::cones::{self, GLYPH_STRIDE};
use super::layers::{LAYER_STRIDE, LayerMode};
use super::occlusion::{SHADOW_PIXELS, SHADOW_REACH};
use super::stage::{Part, RAMP_PIXELS, Stage, View};
use glam::UVec2;
use wgpu::{VertexFormat as Format, VertexStepMode as Step};

const FRAME_SHADER: &str = include_str!("frame.wgsl");
const TEXTURE_SHADER: &str = include_str!("texture.wgsl");
const LIGHT_SHADER: &str = include_str!("light.wgsl");
const MESH_SHADER: &str = include_str!("mesh.wgsl");
const LAYER_SHADER: &str = include_str!("layer.wgsl");
const RIBBON_SHADER: &str = include_str!("ribbon.wgsl");
const CONE_SHADER: &str = include_str!("cone.wgsl");
const GROUND_SHADER: &str = include_str!("ground.wgsl");

const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth24Plus;
/// Two matrices and eight vectors.
const FRAME_BYTES: u64 = 2 * 64 + 8 * 16;
/// Two vectors.
const STYLE_BYTES: u64 = 32;
/// Distance between styles in their buffer: the alignment that every device accepts.
const STYLE_STRIDE: u32 = 256;

/// How ribbons of a kind look; the order is that of the styles in their buffer.
#[derive(Clone, Copy, Debug)]
enum Look {
    Wire,
    Casing,
    Cut,
    Outline,
    /// The band in a piece's own colour inside a chart's rim.
    Band,
    MarkLine,
    MarkLineBehind,
    MarkPoint,
    MarkPointBehind,
    BrushEdge,
    Brush,
    BrushBehind,
    Cone,
    /// Rim of a chart that fades towards it.
    Hem,
    /// Cuts of what is hidden beside the one piece that is shown.
    Ghost,
    /// The edge and the middle of the place that the pointer has in the other view.
    MarkerEdge,
    Marker,
    MarkerBehind,
    /// The seam beside the pointer, its light edge, and the thread between its sides.
    SeamEdge,
    Seam,
    Thread,
    /// A measured way and its ends.
    PathEdge,
    Path,
    PathBehind,
    PathEndEdge,
    PathEnd,
}

impl Look {
    const ALL: [Self; 26] = [
        Self::Wire,
        Self::Casing,
        Self::Cut,
        Self::Outline,
        Self::Band,
        Self::MarkLine,
        Self::MarkLineBehind,
        Self::MarkPoint,
        Self::MarkPointBehind,
        Self::BrushEdge,
        Self::Brush,
        Self::BrushBehind,
        Self::Cone,
        Self::Hem,
        Self::Ghost,
        Self::MarkerEdge,
        Self::Marker,
        Self::MarkerBehind,
        Self::SeamEdge,
        Self::Seam,
        Self::Thread,
        Self::PathEdge,
        Self::Path,
        Self::PathBehind,
        Self::PathEndEdge,
        Self::PathEnd,
    ];

    /// Colour, opacity, width in CSS pixels.
    fn paint(self, accent: Rgb) -> (Rgb, f32, f32) {
        match self {
            Self::Wire => (CUT, 0.3, 0.8),
            Self::Casing => (CASING, 0.55, 2.2 + 2.0 * 0.8),
            Self::Cut => (CUT, 1.0, 2.2),
            Self::Outline => (accent, 1.0, 3.6),
            Self::Band => (CUT, 1.0, 6.2),
            Self::MarkLine => (WARNING, 1.0, 4.0),
            Self::MarkLineBehind => (WARNING, 0.35, 4.0),
            Self::MarkPoint => (WARNING, 1.0, 10.0),
            Self::MarkPointBehind => (WARNING, 0.35, 10.0),
            // Fields have every colour: a light line beside a dark one is seen on all of them.
            Self::BrushEdge => (CASING, 0.8, 4.4),
            Self::Brush => (CUT, 1.0, 2.0),
            Self::BrushBehind => (CUT, 0.25, 2.0),
            Self::Cone => (accent, 1.0, 0.0),
            // Grey is seen on both grounds.
            Self::Hem => (NEUTRAL.darker(), 0.9, 1.3),
            Self::Ghost => (NEUTRAL.darker(), 0.45, 1.4),
            Self::MarkerEdge | Self::PathEndEdge => (CASING, 0.95, 11.0),
            Self::Marker => (accent, 1.0, 7.0),
            Self::MarkerBehind => (accent, 0.4, 7.0),
            Self::SeamEdge => (CASING, 0.9, 6.4),
            Self::Seam => (accent, 1.0, 4.0),
            Self::Thread => (accent, 0.9, 1.6),
            Self::PathEdge => (CASING, 0.9, 5.0),
            Self::Path => (CUT, 1.0, 2.4),
            Self::PathBehind => (CUT, 0.3, 2.4),
            Self::PathEnd => (CUT, 1.0, 7.0),
        }
    }

    fn bytes(self, accent: Rgb) -> Vec<u8> {
        let (colour, opacity, width) = self.paint(accent);
        let is_band = f32::from(u8::from(matches!(self, Self::Band)));
        // Higher than the surface rises within the width of a line on a slope of about 70°; what
        // turns further away than that is faded out by the shader.
        let lift = 3.0;
        // A casing fades earlier, since along an outline it would be a halo on the ground.
        let whole_from = if matches!(self, Self::Casing) { 0.3 } else { 0.03 };
        let shape = if matches!(self, Self::Cone) {
            [cones::RINGS[0], cones::RINGS[1], cones::LIFT, cones::TURNED]
        } else {
            [width / 2.0, is_band, lift, whole_from]
        };
        let mut bytes = Vec::with_capacity(STYLE_STRIDE as usize);
        arrays::push_floats(&mut bytes, &arrays::opaque(colour, opacity));
        arrays::push_floats(&mut bytes, &shape);
        bytes.resize(STYLE_STRIDE as usize, 0);
        bytes
    }
}

/// What the pointer shows, from below to above.
const SEAM: [(Part, Look); 2] = [(Part::Seam, Look::SeamEdge), (Part::Seam, Look::Seam)];
const POINTED_BEHIND: [(Part, Look); 2] =
    [(Part::Path, Look::PathBehind), (Part::Marker, Look::MarkerBehind)];
const POINTED: [(Part, Look); 6] = [
    (Part::Path, Look::PathEdge),
    (Part::Path, Look::Path),
    (Part::PathEnds, Look::PathEndEdge),
    (Part::PathEnds, Look::PathEnd),
    (Part::Marker, Look::MarkerEdge),
    (Part::Marker, Look::Marker),
];
const POINTED_ON_CHARTS: [(Part, Look); 9] = [
    (Part::ChartSeam, Look::SeamEdge),
    (Part::ChartSeam, Look::Seam),
    (Part::SeamThread, Look::Thread),
    (Part::ChartPath, Look::PathEdge),
    (Part::ChartPath, Look::Path),
    (Part::ChartPathEnds, Look::PathEndEdge),
    (Part::ChartPathEnds, Look::PathEnd),
    (Part::ChartMarker, Look::MarkerEdge),
    (Part::ChartMarker, Look::Marker),
];

/// The device's copy of a [`Part`].
#[derive(Debug, Default)]
struct Copy {
    stamp: u64,
    bytes: u64,
    buffer: Option<wgpu::Buffer>,
}

/// Textures as large as the view.
#[derive(Debug)]
struct Targets {
    size: UVec2,
    colour: Option<wgpu::TextureView>,
    depth: Option<wgpu::TextureView>,
}

/// The pipelines of one view.
#[derive(Debug)]
enum Pipelines {
    Surface {
        ground: wgpu::RenderPipeline,
        mesh: wgpu::RenderPipeline,
        layer_ground: wgpu::RenderPipeline,
        layer: wgpu::RenderPipeline,
        ribbon: wgpu::RenderPipeline,
        ribbon_behind: wgpu::RenderPipeline,
        cone: wgpu::RenderPipeline,
    },
    Flat {
        chart: wgpu::RenderPipeline,
        flipped: wgpu::RenderPipeline,
        layer: wgpu::RenderPipeline,
        ribbon: wgpu::RenderPipeline,
        cone: wgpu::RenderPipeline,
    },
}

/// Draws one view with one device.
#[derive(Debug)]
pub struct Painter {
    device: wgpu::Device,
    queue: wgpu::Queue,
    view: View,
    format: wgpu::TextureFormat,
    samples: u32,
    pipelines: Pipelines,
    groups: Groups,
    frame: wgpu::Buffer,
    styles: wgpu::Buffer,
    ramp: wgpu::Texture,
    shadow: wgpu::Texture,
    pixels: wgpu::Texture,
    frame_group: wgpu::BindGroup,
    style_group: wgpu::BindGroup,
    copies: [Copy; Part::COUNT],
    targets: Targets,
}

impl Painter {
    /// Makes pipelines for textures of `format`, which must not be sRGB: shaders encode.
    ///
    /// `samples` is 4 where the format can be multisampled, else 1: lines are smooth either way,
    /// outlines of the surface are not.
    pub fn new(
        device: wgpu::Device,
        queue: wgpu::Queue,
        view: View,
        format: wgpu::TextureFormat,
        samples: u32,
    ) -> Self {
        let uniform = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let frame = uniform("frame", FRAME_BYTES);
        let styles = uniform("styles", Look::ALL.len() as u64 * u64::from(STYLE_STRIDE));
        let rgba = wgpu::TextureFormat::Rgba8Unorm;
        let ramp = texture(&device, "ramp", RAMP_SIZE, rgba, 1);
        let shadow = texture(&device, "shadow", SHADOW_SIZE, wgpu::TextureFormat::R8Unorm, 1);
        let pixels = texture(&device, "pixels", UVec2::ONE, rgba, 1);
        let groups = Groups::new(&device);
        let frame_group = groups.bind_frame(&device, &frame, [&ramp, &shadow, &pixels]);
        let style_group = groups.bind_styles(&device, &styles);
        let pipelines = Maker { device: &device, groups: &groups, format, samples }.make(view);
        Self {
            device,
            queue,
            view,
            format,
            samples,
            pipelines,
            groups,
            frame,
            styles,
            ramp,
            shadow,
            pixels,
            frame_group,
            style_group,
            copies: std::array::from_fn(|_| Copy::default()),
            targets: Targets { size: UVec2::ZERO, colour: None, depth: None },
        }
    }

    /// Draws the stage on `target`, a texture of `size` pixels.
    pub fn draw(&mut self, stage: &mut Stage, target: &wgpu::TextureView, size: UVec2) {
        self.prepare_targets(size);
        self.write_uniforms(stage, size);
        self.write_textures(stage);
        for part in self.parts(stage) {
            self.write_part(stage, part);
        }
        let shows_layers = stage.shows_layers();
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let [r, g, b] = stage.theme().background.0.map(f64::from);
            let background = wgpu::Color { r, g, b, a: 1.0 };
            let (view, resolve_target, store) = match &self.targets.colour {
                Some(colour) => (colour, Some(target), wgpu::StoreOp::Discard),
                None => (target, None, wgpu::StoreOp::Store),
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("view"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Clear(background), store },
                })],
                depth_stencil_attachment: self.targets.depth.as_ref().map(|view| {
                    wgpu::RenderPassDepthStencilAttachment {
                        view,
                        depth_ops: Some(wgpu::Operations {
                            load: wgpu::LoadOp::Clear(1.0),
                            store: wgpu::StoreOp::Discard,
                        }),
                        stencil_ops: None,
                    }
                }),
                ..Default::default()
            });
            pass.set_bind_group(0, &self.frame_group, &[]);
            // All pipelines share one layout, so those without a style have one as well.
            pass.set_bind_group(1, &self.style_group, &[0]);
            match &self.pipelines {
                Pipelines::Surface {
                    ground,
                    mesh,
                    layer_ground,
                    layer,
                    ribbon,
                    ribbon_behind,
                    cone,
                } => {
                    pass.set_pipeline(ground);
                    pass.draw(0..4, 0..1);
                    if shows_layers {
                        for pipeline in [layer_ground, layer] {
                            pass.set_pipeline(pipeline);
                            let corners = [Part::LayerVertices];
                            self.draw_triangles(&mut pass, &corners, Part::LayerTriangles);
                        }
                    } else {
                        pass.set_pipeline(mesh);
                        let corners = [Part::Geometry, Part::Paint, Part::Charts];
                        self.draw_triangles(&mut pass, &corners, Part::Triangles);
                    }
                    pass.set_pipeline(ribbon);
                    if stage.shows_wireframe() {
                        self.draw_ribbons(&mut pass, Part::Wires, Look::Wire);
                    }
                    if !shows_layers {
                        // What blends has no cuts.
                        self.draw_ribbons(&mut pass, Part::Ghost, Look::Ghost);
                        self.draw_ribbons(&mut pass, Part::Cuts, Look::Casing);
                        self.draw_ribbons(&mut pass, Part::Cuts, Look::Cut);
                    }
                    self.draw_ribbons(&mut pass, Part::Outline, Look::Outline);
                    self.draw_all(&mut pass, &SEAM);
                    pass.set_pipeline(cone);
                    self.draw_cones(&mut pass, Part::Cones);
                    pass.set_pipeline(ribbon_behind);
                    self.draw_ribbons(&mut pass, Part::Brush, Look::BrushBehind);
                    self.draw_ribbons(&mut pass, Part::MarkSegments, Look::MarkLineBehind);
                    self.draw_ribbons(&mut pass, Part::MarkPoints, Look::MarkPointBehind);
                    self.draw_all(&mut pass, &POINTED_BEHIND);
                    pass.set_pipeline(ribbon);
                    self.draw_all(&mut pass, &POINTED);
                    self.draw_ribbons(&mut pass, Part::MarkSegments, Look::MarkLine);
                    self.draw_ribbons(&mut pass, Part::MarkPoints, Look::MarkPoint);
                    self.draw_ribbons(&mut pass, Part::Brush, Look::BrushEdge);
                    self.draw_ribbons(&mut pass, Part::Brush, Look::Brush);
                }
                Pipelines::Flat { layer, ribbon, .. } if shows_layers => {
                    pass.set_pipeline(layer);
                    let corners = [Part::LayerVertices];
                    self.draw_triangles(&mut pass, &corners, Part::LayerChartTriangles);
                    pass.set_pipeline(ribbon);
                    self.draw_ribbons(&mut pass, Part::LayerRims, Look::Hem);
                }
                Pipelines::Flat { chart, flipped, ribbon, cone, .. } => {
                    let corners = [Part::Paint, Part::Charts];
                    pass.set_pipeline(chart);
                    self.draw_triangles(&mut pass, &corners, Part::ChartTriangles);
                    pass.set_pipeline(flipped);
                    self.draw_triangles(&mut pass, &corners, Part::FlippedTriangles);
                    pass.set_pipeline(ribbon);
                    if stage.shows_wireframe() {
                        self.draw_ribbons(&mut pass, Part::ChartWires, Look::Wire);
                    }
                    if stage.shows_field() {
                        self.draw_ribbons(&mut pass, Part::ChartRims, Look::Band);
                    }
                    if stage.is_dark() {
                        // Dark outlines need a light edge to be seen on a dark ground.
                        self.draw_ribbons(&mut pass, Part::ChartRims, Look::Casing);
                    }
                    self.draw_ribbons(&mut pass, Part::ChartRims, Look::Cut);
                    self.draw_ribbons(&mut pass, Part::ChartOutline, Look::Outline);
                    pass.set_pipeline(cone);
                    self.draw_cones(&mut pass, Part::ChartCones);
                    pass.set_pipeline(ribbon);
                    self.draw_all(&mut pass, &POINTED_ON_CHARTS);
                }
            }
        }
        self.queue.submit([encoder.finish()]);
    }

    /// The parts that this view draws; edges only when they are shown.
    fn parts(&self, stage: &Stage) -> Vec<Part> {
        let (parts, wires): (&[Part], Part) = match self.view {
            View::Surface => (
                &[
                    Part::Geometry,
                    Part::Paint,
                    Part::Charts,
                    Part::Triangles,
                    Part::Cuts,
                    Part::Ghost,
                    Part::Outline,
                    Part::MarkPoints,
                    Part::MarkSegments,
                    Part::Brush,
                    Part::Cones,
                ],
                Part::Wires,
            ),
            View::Flat => (
                &[
                    Part::Paint,
                    Part::Charts,
                    Part::ChartTriangles,
                    Part::FlippedTriangles,
                    Part::ChartRims,
                    Part::ChartOutline,
                    Part::ChartCones,
                ],
                Part::ChartWires,
            ),
        };
        let layers: &[Part] = match self.view {
            _ if !stage.shows_layers() => &[],
            View::Surface => &[Part::LayerVertices, Part::LayerTriangles],
            View::Flat => &[Part::LayerVertices, Part::LayerChartTriangles, Part::LayerRims],
        };
        let wires = stage.shows_wireframe().then_some(wires);
        let pointed: Vec<Part> = match self.view {
            View::Surface => SEAM.iter().chain(&POINTED).map(|(part, _)| *part).collect(),
            View::Flat => POINTED_ON_CHARTS.iter().map(|(part, _)| *part).collect(),
        };
        parts.iter().chain(layers).copied().chain(wires).chain(pointed).collect()
    }

    fn draw_all(&self, pass: &mut wgpu::RenderPass, ribbons: &[(Part, Look)]) {
        for &(part, look) in ribbons {
            self.draw_ribbons(pass, part, look);
        }
    }

    fn draw_triangles(&self, pass: &mut wgpu::RenderPass, corners: &[Part], triangles: Part) {
        let indices = &self.copies[triangles as usize];
        let Some(buffer) = indices.buffer.as_ref().filter(|_| indices.bytes > 0) else { return };
        for (slot, &part) in (0..).zip(corners) {
            let copy = &self.copies[part as usize];
            let Some(buffer) = copy.buffer.as_ref().filter(|_| copy.bytes > 0) else { return };
            pass.set_vertex_buffer(slot, buffer.slice(..copy.bytes));
        }
        pass.set_index_buffer(buffer.slice(..indices.bytes), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..count(indices.bytes, 4), 0, 0..1);
    }

    fn draw_ribbons(&self, pass: &mut wgpu::RenderPass, part: Part, look: Look) {
        let ribbons = &self.copies[part as usize];
        let Some(buffer) = ribbons.buffer.as_ref().filter(|_| ribbons.bytes > 0) else { return };
        pass.set_bind_group(1, &self.style_group, &[look as u32 * STYLE_STRIDE]);
        pass.set_vertex_buffer(0, buffer.slice(..ribbons.bytes));
        pass.draw(0..4, 0..count(ribbons.bytes, RIBBON_STRIDE));
    }

    fn draw_cones(&self, pass: &mut wgpu::RenderPass, part: Part) {
        let glyphs = &self.copies[part as usize];
        let Some(buffer) = glyphs.buffer.as_ref().filter(|_| glyphs.bytes > 0) else { return };
        pass.set_bind_group(1, &self.style_group, &[Look::Cone as u32 * STYLE_STRIDE]);
        pass.set_vertex_buffer(0, buffer.slice(..glyphs.bytes));
        pass.draw(0..4, 0..count(glyphs.bytes, GLYPH_STRIDE));
    }

    fn prepare_targets(&mut self, size: UVec2) {
        if self.targets.size == size {
            return;
        }
        let target = |label, format| {
            let texture = self.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: extent(size),
                mip_level_count: 1,
                sample_count: self.samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        self.targets = Targets {
            size,
            colour: (self.samples > 1).then(|| target("multisampled", self.format)),
            depth: (self.view == View::Surface).then(|| target("depth", DEPTH_FORMAT)),
        };
    }

    fn write_uniforms(&self, stage: &Stage, size: UVec2) {
        let projection = stage.projection(self.view);
        let viewport = stage.viewport(self.view);
        let theme = stage.theme();
        let switch = |on: bool| f32::from(u8::from(on));
        let eye = projection.eye;
        let cells = stage.pixels().map_or([1.0; 2], |pixels| pixels.cells);
        // The ground is not seen from below.
        let above = ((eye.y - stage.ground()) * 4.0).clamp(0.0, 1.0);
        let mut bytes = Vec::with_capacity(FRAME_BYTES as usize);
        for numbers in [projection.world_to_clip, projection.world_to_view] {
            arrays::push_floats(&mut bytes, &numbers.to_cols_array());
        }
        for numbers in [
            [eye.x, eye.y, eye.z, switch(projection.perspective)],
            [size.x as f32, size.y as f32, viewport.scale, projection.pixel],
            [stage.ground(), SHADOW_REACH, theme.shadow, above],
            [
                switch(stage.shows_field()),
                stage.texture().number(),
                stage.cell(),
                switch(stage.is_clipped() && self.view == View::Surface),
            ],
            [cells[0], cells[1], switch(stage.layer_mode() == LayerMode::Hard), 0.0],
            arrays::opaque(NEUTRAL, 1.0),
            arrays::opaque(WARNING, 1.0),
            match self.view {
                View::Surface => stage.clip_plane().to_array(),
                // Nothing is cut away from the sheet.
                View::Flat => [0.0, 0.0, 0.0, 1.0],
            },
        ] {
            arrays::push_floats(&mut bytes, &numbers);
        }
        self.queue.write_buffer(&self.frame, 0, &bytes);
        let styles: Vec<u8> = Look::ALL.iter().flat_map(|look| look.bytes(theme.accent)).collect();
        self.queue.write_buffer(&self.styles, 0, &styles);
    }

    fn write_textures(&mut self, stage: &mut Stage) {
        for (part, texture, size, pixel_bytes) in
            [(Part::Ramp, &self.ramp, RAMP_SIZE, 4), (Part::Shadow, &self.shadow, SHADOW_SIZE, 1)]
        {
            let copy = &mut self.copies[part as usize];
            if copy.stamp == stage.stamp_of(part) {
                continue;
            }
            copy.stamp = stage.stamp_of(part);
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(size.x * pixel_bytes),
                rows_per_image: None,
            };
            let bytes = stage.bytes(part);
            self.queue.write_texture(texture.as_image_copy(), &bytes, layout, extent(size));
        }
        self.write_pixels(stage);
    }

    /// The pixels of the texture; old ones stay while none are wanted.
    fn write_pixels(&mut self, stage: &Stage) {
        let copy = &mut self.copies[Part::Pixels as usize];
        if copy.stamp == stage.stamp_of(Part::Pixels) {
            return;
        }
        copy.stamp = stage.stamp_of(Part::Pixels);
        let Some(&[(width, height, _), ..]) = stage.pixels().map(|p| &*p.levels) else { return };
        let levels = stage.pixels().map_or(&[][..], |pixels| &pixels.levels);
        let size = UVec2::new(width, height);
        let format = wgpu::TextureFormat::Rgba8Unorm;
        self.pixels = texture(&self.device, "pixels", size, format, levels.len() as u32);
        for ((width, height, bytes), mip_level) in levels.iter().zip(0..) {
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * width),
                rows_per_image: None,
            };
            let target = wgpu::TexelCopyTextureInfo { mip_level, ..self.pixels.as_image_copy() };
            let size = extent(UVec2::new(*width, *height));
            self.queue.write_texture(target, bytes, layout, size);
        }
        let textures = [&self.ramp, &self.shadow, &self.pixels];
        self.frame_group = self.groups.bind_frame(&self.device, &self.frame, textures);
    }

    fn write_part(&mut self, stage: &mut Stage, part: Part) {
        let copy = &mut self.copies[part as usize];
        if copy.stamp == stage.stamp_of(part) {
            return;
        }
        copy.stamp = stage.stamp_of(part);
        let bytes = stage.bytes(part);
        copy.bytes = bytes.len() as u64;
        if bytes.is_empty() {
            return;
        }
        let is_large_enough =
            copy.buffer.as_ref().is_some_and(|buffer| buffer.size() >= copy.bytes);
        if !is_large_enough {
            let kind = match part {
                Part::Triangles
                | Part::ChartTriangles
                | Part::FlippedTriangles
                | Part::LayerTriangles
                | Part::LayerChartTriangles => wgpu::BufferUsages::INDEX,
                _ => wgpu::BufferUsages::VERTEX,
            };
            // Half as much again, so that a growing cut does not ask for a buffer each frame.
            let size = (copy.bytes + copy.bytes / 2).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
            copy.buffer = Some(self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("part"),
                size,
                usage: kind | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }));
        }
        if let Some(buffer) = &copy.buffer {
            self.queue.write_buffer(buffer, 0, &bytes);
        }
    }
}

const RAMP_SIZE: UVec2 = UVec2::new(RAMP_PIXELS as u32, 1);
const SHADOW_SIZE: UVec2 = UVec2::splat(SHADOW_PIXELS as u32);

/// A texture to read from.
fn texture(
    device: &wgpu::Device,
    label: &str,
    size: UVec2,
    format: wgpu::TextureFormat,
    mip_level_count: u32,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent(size),
        mip_level_count,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

fn extent(size: UVec2) -> wgpu::Extent3d {
    wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 }
}

fn count(bytes: u64, stride: u64) -> u32 {
    u32::try_from(bytes / stride).unwrap_or(u32::MAX)
}

/// The two layouts of bound things that all shaders share.
#[derive(Debug)]
struct Groups {
    frame: wgpu::BindGroupLayout,
    style: wgpu::BindGroupLayout,
}

impl Groups {
    fn new(device: &wgpu::Device) -> Self {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty,
            count: None,
        };
        let uniform = |size, has_dynamic_offset| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset,
            min_binding_size: wgpu::BufferSize::new(size),
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            let label = Some(label);
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries })
        };
        Self {
            frame: layout(
                "frame",
                &[
                    entry(0, uniform(FRAME_BYTES, false)),
                    entry(1, sampler),
                    entry(2, texture),
                    entry(3, texture),
                    entry(4, texture),
                    entry(5, sampler),
                ],
            ),
            style: layout("style", &[entry(0, uniform(STYLE_BYTES, true))]),
        }
    }

    fn bind_frame(
        &self,
        device: &wgpu::Device,
        frame: &wgpu::Buffer,
        textures: [&wgpu::Texture; 3],
    ) -> wgpu::BindGroup {
        let smooth = wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        };
        let sampler = device.create_sampler(&smooth);
        let repeating = device.create_sampler(&wgpu::SamplerDescriptor {
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..smooth
        });
        let [ramp, shadow, pixels] = textures.map(|t| t.create_view(&Default::default()));
        let resources = [
            frame.as_entire_binding(),
            wgpu::BindingResource::Sampler(&sampler),
            wgpu::BindingResource::TextureView(&ramp),
            wgpu::BindingResource::TextureView(&shadow),
            wgpu::BindingResource::TextureView(&pixels),
            wgpu::BindingResource::Sampler(&repeating),
        ];
        let entries: Vec<wgpu::BindGroupEntry> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &self.frame,
            entries: &entries,
        })
    }

    fn bind_styles(&self, device: &wgpu::Device, styles: &wgpu::Buffer) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("style"),
            layout: &self.style,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: styles,
                    offset: 0,
                    size: wgpu::BufferSize::new(STYLE_BYTES),
                }),
            }],
        })
    }
}

/// What the pipelines of a view have in common.
struct Maker<'a> {
    device: &'a wgpu::Device,
    groups: &'a Groups,
    format: wgpu::TextureFormat,
    samples: u32,
}

/// What tells one pipeline from another.
struct Recipe<'a> {
    shader: &'a wgpu::ShaderModule,
    entries: [&'a str; 2],
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    is_strip: bool,
    blend: Option<wgpu::BlendState>,
    /// The depth test, and whether depth is written; none where there is no depth buffer.
    depth: Option<(wgpu::CompareFunction, bool)>,
}

const GEOMETRY: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: GEOMETRY_STRIDE,
    step_mode: Step::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x4],
};
const PAINT: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: PAINT_STRIDE,
    step_mode: Step::Vertex,
    attributes: &wgpu::vertex_attr_array![2 => Unorm8x4, 3 => Unorm8x4, 4 => Float32],
};
const CHART: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: CHART_STRIDE,
    step_mode: Step::Vertex,
    attributes: &[wgpu::VertexAttribute {
        format: Format::Float32x2,
        offset: 0,
        shader_location: 5,
    }],
};
const RIBBON: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: RIBBON_STRIDE,
    step_mode: Step::Instance,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x3,
        4 => Snorm8x4, 5 => Snorm8x4, 6 => Unorm8x4
    ],
};

const GLYPH: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: GLYPH_STRIDE,
    step_mode: Step::Instance,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Float32, 2 => Snorm8x4, 3 => Unorm8x4, 4 => Unorm8x4
    ],
};

const LAYER: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: LAYER_STRIDE,
    step_mode: Step::Vertex,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Snorm16x4, 2 => Unorm8x4, 3 => Unorm8x4,
        4 => Float32x2, 5 => Float32x2, 6 => Float32x4
    ],
};

/// Adds colours and leaves opacity as it is.
const ADDING: wgpu::BlendState = wgpu::BlendState {
    color: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    },
    alpha: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    },
};

impl Maker<'_> {
    fn make(&self, view: View) -> Pipelines {
        let mesh = self.shader("mesh", &[TEXTURE_SHADER, LIGHT_SHADER, MESH_SHADER]);
        let ribbon = self.shader("ribbon", &[RIBBON_SHADER]);
        let layer = self.shader("layer", &[TEXTURE_SHADER, LIGHT_SHADER, LAYER_SHADER]);
        let layers = |entries, blend, depth| Recipe {
            shader: &layer,
            entries,
            buffers: &[Some(LAYER)],
            is_strip: false,
            blend,
            depth,
        };
        let ribbons = |depth| Recipe {
            shader: &ribbon,
            entries: ["ribbon_vertex", "ribbon_fragment"],
            buffers: &[Some(RIBBON)],
            is_strip: true,
            blend: Some(wgpu::BlendState::ALPHA_BLENDING),
            depth,
        };
        let cone = self.shader("cone", &[CONE_SHADER]);
        let glyphs = |depth| Recipe {
            shader: &cone,
            entries: ["cone_vertex", "cone_fragment"],
            buffers: &[Some(GLYPH)],
            is_strip: true,
            blend: Some(wgpu::BlendState::ALPHA_BLENDING),
            depth,
        };
        let always = wgpu::CompareFunction::Always;
        let nearer = wgpu::CompareFunction::LessEqual;
        match view {
            View::Surface => {
                let ground = self.shader("ground", &[GROUND_SHADER]);
                Pipelines::Surface {
                    ground: self.pipeline(Recipe {
                        shader: &ground,
                        entries: ["ground_vertex", "ground_fragment"],
                        buffers: &[],
                        is_strip: true,
                        blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                        depth: Some((always, false)),
                    }),
                    mesh: self.pipeline(Recipe {
                        shader: &mesh,
                        entries: ["surface_vertex", "surface_fragment"],
                        buffers: &[Some(GEOMETRY), Some(PAINT), Some(CHART)],
                        is_strip: false,
                        blend: None,
                        depth: Some((wgpu::CompareFunction::Less, true)),
                    }),
                    layer_ground: self.pipeline(layers(
                        ["layer_vertex", "layer_ground_fragment"],
                        None,
                        Some((wgpu::CompareFunction::Less, true)),
                    )),
                    layer: self.pipeline(layers(
                        ["layer_vertex", "layer_fragment"],
                        Some(ADDING),
                        Some((wgpu::CompareFunction::Equal, false)),
                    )),
                    ribbon: self.pipeline(ribbons(Some((nearer, false)))),
                    ribbon_behind: self.pipeline(ribbons(Some((always, false)))),
                    cone: self.pipeline(glyphs(Some((nearer, false)))),
                }
            }
            View::Flat => {
                let charts = |fragment| Recipe {
                    shader: &mesh,
                    entries: ["chart_vertex", fragment],
                    buffers: &[Some(PAINT), Some(CHART)],
                    is_strip: false,
                    blend: None,
                    depth: None,
                };
                Pipelines::Flat {
                    chart: self.pipeline(charts("chart_fragment")),
                    flipped: self.pipeline(charts("flipped_fragment")),
                    layer: self.pipeline(layers(
                        ["layer_chart_vertex", "layer_chart_fragment"],
                        Some(wgpu::BlendState::ALPHA_BLENDING),
                        None,
                    )),
                    ribbon: self.pipeline(ribbons(None)),
                    cone: self.pipeline(glyphs(None)),
                }
            }
        }
    }

    fn shader(&self, label: &str, sources: &[&str]) -> wgpu::ShaderModule {
        let source = [FRAME_SHADER].iter().chain(sources).copied().collect::<String>();
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        })
    }

    fn pipeline(&self, recipe: Recipe) -> wgpu::RenderPipeline {
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&self.groups.frame), Some(&self.groups.style)],
            immediate_size: 0,
        });
        let [vertex, fragment] = recipe.entries;
        let topology = if recipe.is_strip {
            wgpu::PrimitiveTopology::TriangleStrip
        } else {
            wgpu::PrimitiveTopology::TriangleList
        };
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: recipe.shader,
                entry_point: Some(vertex),
                compilation_options: Default::default(),
                buffers: recipe.buffers,
            },
            primitive: wgpu::PrimitiveState { topology, ..Default::default() },
            depth_stencil: recipe.depth.map(|(compare, write)| wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(write),
                depth_compare: Some(compare),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: wgpu::MultisampleState { count: self.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: recipe.shader,
                entry_point: Some(fragment),
                compilation_options: Default::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: self.format,
                    blend: recipe.blend,
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::naga;

    #[test]
    fn every_shader_is_valid_without_any_capability_beyond_webgl2() {
        for (name, source) in [
            ("mesh", [TEXTURE_SHADER, LIGHT_SHADER, MESH_SHADER].concat()),
            ("layer", [TEXTURE_SHADER, LIGHT_SHADER, LAYER_SHADER].concat()),
            ("ribbon", RIBBON_SHADER.into()),
            ("cone", CONE_SHADER.into()),
            ("ground", GROUND_SHADER.into()),
        ] {
            let source = [FRAME_SHADER, &source].concat();
            let module = naga::front::wgsl::parse_str(&source)
                .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&source)));
            let mut validator = naga::valid::Validator::new(
                naga::valid::ValidationFlags::all(),
                naga::valid::Capabilities::empty(),
            );
            validator
                .validate(&module)
                .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&source)));
            let uses_storage = module
                .global_variables
                .iter()
                .any(|(_, variable)| matches!(variable.space, naga::AddressSpace::Storage { .. }));
            assert!(!uses_storage, "{name} uses a storage buffer");
        }
    }

    #[test]
    fn the_uniforms_are_as_large_as_the_shaders_say() {
        let source = [FRAME_SHADER, RIBBON_SHADER].concat();
        let module = naga::front::wgsl::parse_str(&source).expect("valid");
        let size = |name: &str| {
            let find = |(_, ty): &(_, &naga::Type)| ty.name.as_deref() == Some(name);
            match module.types.iter().find(find).map(|(_, ty)| &ty.inner) {
                Some(naga::TypeInner::Struct { span, .. }) => u64::from(*span),
                other => panic!("{name} is {other:?}"),
            }
        };
        assert_eq!((size("Frame"), size("Style")), (FRAME_BYTES, STYLE_BYTES));
        assert!(Look::ALL.iter().enumerate().all(|(i, look)| *look as usize == i));
    }

    #[test]
    fn no_vertex_is_wider_than_webgl2_allows() {
        let limits = wgpu::Limits::downlevel_webgl2_defaults();
        for layout in [GEOMETRY, PAINT, CHART, RIBBON, GLYPH, LAYER] {
            assert!(layout.array_stride <= u64::from(limits.max_vertex_buffer_array_stride));
            let end = layout.attributes.iter().map(|a| a.offset + a.format.size()).max();
            assert_eq!(end, Some(layout.array_stride));
        }
    }
}
