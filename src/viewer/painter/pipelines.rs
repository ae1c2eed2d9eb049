//! Shaders, layouts and the pipelines made of them.

use super::super::arrays::{CHART_STRIDE, GEOMETRY_STRIDE, PAINT_STRIDE, RIBBON_STRIDE};
use super::super::cones::GLYPH_STRIDE;
use super::super::layers::LAYER_STRIDE;
use super::super::stage::View;
use super::looks::STYLE_BYTES;
use wgpu::{VertexFormat as Format, VertexStepMode as Step};

const FRAME_SHADER: &str = include_str!("../frame.wgsl");
const TEXTURE_SHADER: &str = include_str!("../texture.wgsl");
const LIGHT_SHADER: &str = include_str!("../light.wgsl");
const MESH_SHADER: &str = include_str!("../mesh.wgsl");
const LAYER_SHADER: &str = include_str!("../layer.wgsl");
const RIBBON_SHADER: &str = include_str!("../ribbon.wgsl");
const CONE_SHADER: &str = include_str!("../cone.wgsl");
const GROUND_SHADER: &str = include_str!("../ground.wgsl");

pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth24Plus;

/// Two matrices and eight vectors.
pub(super) const FRAME_BYTES: u64 = 2 * 64 + 8 * 16;

/// The pipelines of one view.
#[derive(Debug)]
pub(super) enum Pipelines {
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

/// The two layouts of bound things that all shaders share.
#[derive(Debug)]
pub(super) struct Groups {
    frame: wgpu::BindGroupLayout,
    style: wgpu::BindGroupLayout,
}

impl Groups {
    pub(super) fn new(device: &wgpu::Device) -> Self {
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

    pub(super) fn bind_frame(
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

    pub(super) fn bind_styles(
        &self,
        device: &wgpu::Device,
        styles: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
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
pub(super) struct Maker<'a> {
    pub(super) device: &'a wgpu::Device,
    pub(super) groups: &'a Groups,
    pub(super) format: wgpu::TextureFormat,
    pub(super) samples: u32,
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
    pub(super) fn make(&self, view: View) -> Pipelines {
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
    use super::super::looks::Look;
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
