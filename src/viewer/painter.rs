//! One view of a [`Stage`] on a texture: pipelines, buffers that only grow, a handful of draw calls.

mod looks;
mod pipelines;

use self::looks::{Look, POINTED, POINTED_BEHIND, POINTED_ON_CHARTS, SEAM, STYLE_STRIDE};
use self::pipelines::{DEPTH_FORMAT, FRAME_BYTES, Groups, Maker, Pipelines};
use super::arrays::{self, RIBBON_STRIDE};
use super::color::{NEUTRAL, WARNING};
use super::cones::GLYPH_STRIDE;
use super::layers::LayerMode;
use super::occlusion::{SHADOW_PIXELS, SHADOW_REACH};
use super::stage::{Part, RAMP_PIXELS, Stage, View};
use glam::UVec2;

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
