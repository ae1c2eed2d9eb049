// Cones: discs of constant size on the screen, coloured by their angle, in a light ring and a dark one, so that they are
// seen on every field; antialiased by arithmetic like the lines.
struct Style {
    // The accent, for the ring of what is pointed at or chosen.
    colour: vec4f,
    // Width of the light ring and of the dark one in CSS pixels; how far a glyph is lifted towards the eye, in radii;
    // cosine to the eye from which it is seen.
    shape: vec4f,
}
@group(1) @binding(0) var<uniform> style: Style;

struct Corner {
    @builtin(position) clip: vec4f,
    // Device pixels from the middle.
    @location(0) place: vec2f,
    @location(1) @interpolate(flat) radius: f32,
    @location(2) @interpolate(flat) colour: vec4f,
    // 1 pointed at; 1 chosen.
    @location(3) @interpolate(flat) marks: vec2f,
}

// Room for the ring of the chosen one, in CSS pixels beyond the disc.
const ROOM: f32 = 8.0;
const NEAR: f32 = 1e-4;

@vertex
fn cone_vertex(
    @builtin(vertex_index) index: u32,
    @location(0) position: vec3f,
    @location(1) radius: f32,
    @location(2) normal: vec4f,
    @location(3) colour: vec4f,
    @location(4) marks: vec4f,
) -> Corner {
    let to_eye = frame.eye.xyz - position;
    let whole = (radius + style.shape.x + style.shape.y) * frame.viewport.z;
    let lift = min(style.shape.z * whole * frame.viewport.w * frame.eye.w, 0.5);
    let clip = frame.world_to_clip * vec4f(position + to_eye * lift, 1.0);
    var corner: Corner;
    let facing = dot(normal.xyz, normalize(to_eye));
    let seen = select(1.0, smoothstep(style.shape.w - 0.1, style.shape.w + 0.1, facing), normal.w > 0.5);
    if clip.w < NEAR || seen == 0.0 || kept(position) < 0.0 {
        corner.clip = vec4f(2.0, 2.0, 2.0, 1.0);
        return corner;
    }
    let reach = (radius + ROOM) * frame.viewport.z;
    let side = vec2f(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    // The disc has one depth; one that is known to be seen lies before everything.
    let depth = select(clip.z / clip.w, 0.0, marks.z > 0.5);
    corner.clip = vec4f(clip.xy / clip.w + side * reach / (0.5 * frame.viewport.xy), depth, 1.0);
    corner.place = side * reach;
    corner.radius = radius * frame.viewport.z;
    corner.colour = vec4f(colour.rgb, seen);
    corner.marks = marks.xy;
    return corner;
}

// `top` laid over `below`, neither premultiplied.
fn over(top: vec4f, below: vec4f) -> vec4f {
    let alpha = top.a + below.a * (1.0 - top.a);
    let sum = top.rgb * top.a + below.rgb * below.a * (1.0 - top.a);
    return vec4f(sum / max(alpha, 1e-6), alpha);
}

@fragment
fn cone_fragment(corner: Corner) -> @location(0) vec4f {
    let pixel = frame.viewport.z;
    let distance = length(corner.place);
    let light = corner.radius + style.shape.x * pixel;
    let dark = light + style.shape.y * pixel;
    let mark = max(corner.marks.x, corner.marks.y);
    let ring = dark + (1.0 + 1.5 * corner.marks.y) * pixel * mark;
    let edge = ring + pixel * mark;
    let cover = vec4f(edge, ring, dark, light) + 0.5 - distance;
    let covered = clamp(cover, vec4f(0.0), vec4f(1.0));
    // A light hair around the accent, which alone could be lost on a field of its colour.
    var colour = vec4f(1.0, 1.0, 1.0, 0.7 * mark * covered.x);
    colour = over(vec4f(style.colour.rgb, mark * covered.y), colour);
    colour = over(vec4f(0.125, 0.133, 0.169, 0.85 * covered.z), colour);
    colour = over(vec4f(1.0, 1.0, 1.0, covered.w), colour);
    colour = over(vec4f(corner.colour.rgb, clamp(corner.radius + 0.5 - distance, 0.0, 1.0)), colour);
    return vec4f(colour.rgb, colour.a * corner.colour.a);
}
