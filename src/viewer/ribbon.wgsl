// Lines of constant width on the screen with round ends and joints, antialiased by arithmetic, so that
// they are as clean without multisampling.
struct Style {
    // Colour and opacity.
    colour: vec4f,
    // Half the width in CSS pixels; 1 for a band in the ribbon's own colour, left of the line only; how far
    // the line is lifted towards the eye, in half widths; cosine to the eye from which it is seen whole.
    shape: vec4f,
}
@group(1) @binding(0) var<uniform> style: Style;

struct Corner {
    @builtin(position) clip: vec4f,
    // Device pixels along the line from its start, and to its left.
    @location(0) place: vec2f,
    @location(1) @interpolate(flat) length: f32,
    // Directions that halve the joints at start and end, in the frame of `place`; 0 without joint.
    @location(2) @interpolate(flat) joints: vec4f,
    @location(3) colour: vec4f,
    @location(4) kept: f32,
}

fn lifted(place: vec3f, half_width: f32) -> vec4f {
    let to_eye = frame.eye.xyz - place;
    let lift = style.shape.z * half_width * frame.viewport.w * frame.eye.w;
    return frame.world_to_clip * vec4f(place + to_eye * min(lift, 0.5), 1.0);
}

fn to_pixels(clip: vec4f) -> vec2f {
    return clip.xy / clip.w * 0.5 * frame.viewport.xy;
}

// The unit direction that halves the way from `before` to `after`, or 0 where the line turns back on itself.
fn halving(before: vec2f, after: vec2f) -> vec2f {
    let sum = before + after;
    let size = length(sum);
    return select(vec2f(0.0), sum / size, size > 0.05);
}

fn direction(from_place: vec2f, to_place: vec2f) -> vec2f {
    let way = to_place - from_place;
    let size = length(way);
    return select(vec2f(0.0), way / size, size > 1e-3);
}

const NEAR: f32 = 1e-4;

@vertex
fn ribbon_vertex(
    @builtin(vertex_index) index: u32,
    @location(0) before: vec3f,
    @location(1) start: vec3f,
    @location(2) end: vec3f,
    @location(3) after: vec3f,
    @location(4) start_normal: vec4f,
    @location(5) end_normal: vec4f,
    @location(6) colour: vec4f,
) -> Corner {
    let half_width = style.shape.x * frame.viewport.z;
    var a = lifted(start, half_width);
    var b = lifted(end, half_width);
    var corner: Corner;
    if a.w < NEAR && b.w < NEAR {
        corner.clip = vec4f(2.0, 2.0, 2.0, 1.0);
        return corner;
    }
    // Cut off what lies behind the eye.
    if a.w < NEAR { a = mix(b, a, (b.w - NEAR) / (b.w - a.w)); }
    if b.w < NEAR { b = mix(a, b, (a.w - NEAR) / (a.w - b.w)); }
    let from_place = to_pixels(a);
    let to_place = to_pixels(b);
    var along = direction(from_place, to_place);
    if dot(along, along) < 0.5 { along = vec2f(1.0, 0.0); }
    let left = vec2f(-along.y, along.x);

    let clip_before = lifted(before, half_width);
    let clip_after = lifted(after, half_width);
    var joint_start = vec2f(0.0);
    var joint_end = vec2f(0.0);
    if clip_before.w > NEAR {
        let arriving = direction(to_pixels(clip_before), from_place);
        if dot(arriving, arriving) > 0.5 { joint_start = halving(arriving, along); }
    }
    if clip_after.w > NEAR {
        let leaving = direction(to_place, to_pixels(clip_after));
        if dot(leaving, leaving) > 0.5 { joint_end = halving(along, leaving); }
    }

    let reach = half_width + 1.0;
    let is_end = (index & 1u) == 1u;
    let side = select(-1.0, 1.0, index >= 2u);
    let pixels = select(from_place - along * reach, to_place + along * reach, is_end)
        + left * side * reach;
    let near_end = select(a, b, is_end);
    // Straight in the screen: no perspective between the corners.
    corner.clip = vec4f(pixels / (0.5 * frame.viewport.xy), near_end.z / near_end.w, 1.0);
    corner.length = distance(from_place, to_place);
    corner.place = vec2f(select(-reach, corner.length + reach, is_end), side * reach);
    corner.joints = vec4f(
        dot(joint_start, along), dot(joint_start, left),
        dot(joint_end, along), dot(joint_end, left),
    );
    // Away where the surface under it turns from the eye; there the surface is too steep for the lift
    // to be told from a line behind it.
    let place = select(start, end, is_end);
    let normal = select(start_normal, end_normal, is_end);
    let facing = dot(normal.xyz, normalize(frame.eye.xyz - place));
    let seen = select(1.0, smoothstep(style.shape.w - 0.15, style.shape.w, facing), normal.w > 0.5);
    corner.kept = kept(place);
    let own = select(style.colour.rgb, colour.rgb, style.shape.y > 0.5);
    corner.colour = vec4f(own, style.colour.a * seen);
    return corner;
}

@fragment
fn ribbon_fragment(corner: Corner) -> @location(0) vec4f {
    // Beyond a joint the neighbour draws; a hair of overlap, since both round in their own way.
    let from_start = corner.place;
    let from_end = corner.place - vec2f(corner.length, 0.0);
    if dot(from_start, corner.joints.xy) < -0.03 || dot(from_end, corner.joints.zw) > 0.03 {
        discard;
    }
    if corner.kept < 0.0 {
        discard;
    }
    let nearest = vec2f(corner.place.x - clamp(corner.place.x, 0.0, corner.length), corner.place.y);
    let half_width = style.shape.x * frame.viewport.z;
    var coverage = clamp(half_width + 0.5 - length(nearest), 0.0, 1.0);
    // A band ends under the middle of the line that is drawn over it.
    if style.shape.y > 0.5 { coverage *= clamp(corner.place.y + 0.5, 0.0, 1.0); }
    return vec4f(corner.colour.rgb, corner.colour.a * coverage);
}
