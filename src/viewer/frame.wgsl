// What every pass is told of the view. Kept within WebGL2: uniform buffers, no storage.
struct Frame {
    world_to_clip: mat4x4f,
    world_to_view: mat4x4f,
    // Eye, and 1 for a perspective view.
    eye: vec4f,
    // Width and height in device pixels, device pixels per CSS pixel, world length of a device pixel.
    viewport: vec4f,
    // Height of the ground, half its side, opacity of its shadow, 1 seen from above and 0 from below.
    ground: vec4f,
    // 1 with a field; the texture: 0 none, 1 checkerboard, 2 grid, 3 circles, above 3 pixels; side of its cells; 1 where a
    // part of the surface is cut away.
    paint: vec4f,
    // Cells that the texture's pixels take across and up; 1 where the chart of the largest weight is drawn alone.
    pixels: vec4f,
    // Colour of a place without value.
    neutral: vec4f,
    warning: vec4f,
    // Places whose dot product with the first three is more than the last are cut away.
    clip: vec4f,
}
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var smooth_sampler: sampler;
@group(0) @binding(2) var ramp: texture_2d<f32>;
@group(0) @binding(3) var shadow: texture_2d<f32>;
@group(0) @binding(4) var pixels: texture_2d<f32>;
@group(0) @binding(5) var repeat_sampler: sampler;

// Below 0 where a place is cut away.
fn kept(place: vec3f) -> f32 {
    return frame.clip.w - dot(frame.clip.xyz, place);
}

// Canvases hold encoded sRGB on both backends: decode to compute light, encode to write.
fn decode(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

fn encode(c: vec3f) -> vec3f {
    let clamped = clamp(c, vec3f(0.0), vec3f(1.0));
    return select(
        1.055 * pow(clamped, vec3f(1.0 / 2.4)) - 0.055,
        clamped * 12.92,
        clamped <= vec3f(0.0031308),
    );
}
