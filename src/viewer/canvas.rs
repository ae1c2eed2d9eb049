//! Canvases and the devices that draw on them.
//!
//! A canvas is married to its first context, and an instance of wgpu to its first backend. So
//! [`Backend::probe`] really asks for a device before any canvas is touched, and under WebGL2, where a
//! context *is* a canvas, each canvas has a device of its own. Under WebGPU both share one.

use super::camera::Viewport;
use super::painter::Painter;
use super::stage::{Stage, View};
use glam::UVec2;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use wasm_bindgen::JsCast;
use web_sys::{HtmlCanvasElement, WebGl2RenderingContext};

/// A way to the graphics hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The newer one.
    WebGpu,
    /// The one that is everywhere.
    WebGl2,
}

/// Why nothing can be drawn.
#[derive(Clone, Debug, thiserror::Error)]
pub enum CanvasError {
    /// The browser has neither backend, or not the one asked for.
    #[error("this browser gives no {0} device: {1}")]
    NoDevice(&'static str, String),
    /// The canvas does not take a context.
    #[error("the canvas takes no context: {0}")]
    NoContext(String),
    /// The device cannot draw what canvases show.
    #[error("the canvas has no 8-bit format that is not sRGB")]
    NoFormat,
}

impl Backend {
    /// The name that the page knows it by.
    pub fn name(self) -> &'static str {
        match self {
            Self::WebGpu => "webgpu",
            Self::WebGl2 => "webgl2",
        }
    }

    /// The backend of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::WebGpu, Self::WebGl2].into_iter().find(|backend| backend.name() == name)
    }

    /// The best backend that this browser really has: `navigator.gpu` may exist and give no
    /// adapter, and an adapter may give no device.
    pub async fn probe() -> Result<Self, CanvasError> {
        let reason = match open(&Self::WebGpu.instance(), Self::WebGpu, None).await {
            Ok(gpu) => {
                gpu.device.destroy();
                return Ok(Self::WebGpu);
            }
            Err(error) => error.to_string(),
        };
        let has_webgl2 = web_sys::window()
            .and_then(|window| window.document())
            .and_then(|document| document.create_element("canvas").ok())
            .and_then(|canvas| canvas.dyn_into::<HtmlCanvasElement>().ok())
            .is_some_and(|canvas| webgl2_context(&canvas).is_some());
        if has_webgl2 { Ok(Self::WebGl2) } else { Err(CanvasError::NoDevice("WebGL2", reason)) }
    }

    /// Opens the canvases of both views, which must not have been touched before.
    pub async fn open(self, canvases: [HtmlCanvasElement; 2]) -> Result<[Canvas; 2], CanvasError> {
        let [surface, flat] = canvases;
        match self {
            Self::WebGpu => {
                let instance = self.instance();
                let gpu = open(&instance, self, None).await?;
                let surfaces =
                    (create_surface(&instance, &surface)?, create_surface(&instance, &flat)?);
                Ok([
                    Canvas::new(None, View::Surface, surfaces.0, gpu.clone())?,
                    Canvas::new(None, View::Flat, surfaces.1, gpu)?,
                ])
            }
            Self::WebGl2 => Ok([
                Canvas::with_own_device(surface, View::Surface).await?,
                Canvas::with_own_device(flat, View::Flat).await?,
            ]),
        }
    }

    fn instance(self) -> wgpu::Instance {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = match self {
            Self::WebGpu => wgpu::Backends::BROWSER_WEBGPU,
            Self::WebGl2 => wgpu::Backends::GL,
        };
        wgpu::Instance::new(descriptor)
    }
}

/// A device, its queue, and whether it is gone.
#[derive(Clone, Debug)]
struct Gpu {
    adapter: wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    is_lost: Arc<AtomicBool>,
}

/// One view's canvas.
#[derive(Debug)]
pub struct Canvas {
    /// Under WebGL2, where wgpu does not say that a context is lost.
    context: Option<WebGl2RenderingContext>,
    view: View,
    surface: wgpu::Surface<'static>,
    gpu: Gpu,
    format: wgpu::TextureFormat,
    painter: Painter,
    configured: UVec2,
}

impl Canvas {
    async fn with_own_device(element: HtmlCanvasElement, view: View) -> Result<Self, CanvasError> {
        let instance = Backend::WebGl2.instance();
        let surface = create_surface(&instance, &element)?;
        let gpu = open(&instance, Backend::WebGl2, Some(&surface)).await?;
        Self::new(webgl2_context(&element), view, surface, gpu)
    }

    fn new(
        context: Option<WebGl2RenderingContext>,
        view: View,
        surface: wgpu::Surface<'static>,
        gpu: Gpu,
    ) -> Result<Self, CanvasError> {
        use wgpu::TextureFormat::{Bgra8Unorm, Rgba8Unorm};
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        let is_plain = |format: &wgpu::TextureFormat| matches!(format, Bgra8Unorm | Rgba8Unorm);
        let format = formats.into_iter().find(is_plain).ok_or(CanvasError::NoFormat)?;
        let features = gpu.adapter.get_texture_format_features(format).flags;
        let can_resolve = features.contains(wgpu::TextureFormatFeatureFlags::MULTISAMPLE_RESOLVE);
        let samples = if can_resolve && features.sample_count_supported(4) { 4 } else { 1 };
        let painter = Painter::new(gpu.device.clone(), gpu.queue.clone(), view, format, samples);
        Ok(Self { context, view, surface, gpu, format, painter, configured: UVec2::ZERO })
    }

    /// Draws the stage if it has changed; true if it did.
    pub fn draw(&mut self, stage: &mut Stage) -> bool {
        let viewport = stage.viewport(self.view);
        if viewport.is_empty() || self.is_lost() || !stage.take_dirty(self.view) {
            return false;
        }
        let size = self.size(viewport);
        if self.configured != size {
            self.configure(size);
        }
        let texture = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture)
            | wgpu::CurrentSurfaceTexture::Suboptimal(texture) => texture,
            _ => {
                // Ask for the canvas anew with the next frame.
                self.configured = UVec2::ZERO;
                stage.set_dirty(self.view);
                return false;
            }
        };
        let target = texture.texture.create_view(&Default::default());
        self.painter.draw(stage, &target, size);
        self.gpu.queue.present(texture);
        true
    }

    /// Whether the device, or the context that it is, has gone.
    pub fn is_lost(&self) -> bool {
        self.gpu.is_lost.load(Ordering::Relaxed)
            || self.context.as_ref().is_some_and(WebGl2RenderingContext::is_context_lost)
    }

    /// In device pixels, within what the device can do.
    fn size(&self, viewport: Viewport) -> UVec2 {
        let most = self.gpu.device.limits().max_texture_dimension_2d;
        (viewport.size * viewport.scale).round().as_uvec2().clamp(UVec2::ONE, UVec2::splat(most))
    }

    fn configure(&mut self, size: UVec2) {
        let configuration = wgpu::SurfaceConfiguration {
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            format: self.format,
            color_space: wgpu::SurfaceColorSpace::Auto,
            width: size.x,
            height: size.y,
            desired_maximum_frame_latency: 2,
            present_mode: wgpu::PresentMode::Fifo,
            alpha_mode: wgpu::CompositeAlphaMode::Auto,
            view_formats: Vec::new(),
        };
        self.surface.configure(&self.gpu.device, &configuration);
        self.configured = size;
    }
}

fn create_surface(
    instance: &wgpu::Instance,
    element: &HtmlCanvasElement,
) -> Result<wgpu::Surface<'static>, CanvasError> {
    instance
        .create_surface(wgpu::SurfaceTarget::Canvas(element.clone()))
        .map_err(|error| CanvasError::NoContext(error.to_string()))
}

async fn open(
    instance: &wgpu::Instance,
    backend: Backend,
    surface: Option<&wgpu::Surface<'_>>,
) -> Result<Gpu, CanvasError> {
    let refused = |reason: String| CanvasError::NoDevice(backend.name(), reason);
    let options = wgpu::RequestAdapterOptions { compatible_surface: surface, ..Default::default() };
    let adapter =
        instance.request_adapter(&options).await.map_err(|error| refused(error.to_string()))?;
    // Without the adapter's own resolution a canvas on a large screen would not fit.
    let limits = wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits());
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("cutflow"),
        required_limits: limits,
        ..Default::default()
    };
    let (device, queue) =
        adapter.request_device(&descriptor).await.map_err(|error| refused(error.to_string()))?;
    let is_lost = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&is_lost);
    device.set_device_lost_callback(move |_, _| flag.store(true, Ordering::Relaxed));
    let flag = Arc::clone(&is_lost);
    // wgpu's own handler would panic, and a panic ends the instance: say it, and let the page build
    // a new viewer where drawing on makes no sense.
    device.on_uncaptured_error(Arc::new(move |error| {
        web_sys::console::error_1(&format!("viewer: {error}").into());
        if !matches!(error, wgpu::Error::Validation { .. }) {
            flag.store(true, Ordering::Relaxed);
        }
    }));
    Ok(Gpu { adapter, device, queue, is_lost })
}

fn webgl2_context(canvas: &HtmlCanvasElement) -> Option<WebGl2RenderingContext> {
    canvas.get_context("webgl2").ok().flatten()?.dyn_into().ok()
}
