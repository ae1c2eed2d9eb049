// Triangles: lit on the surface, plain on the charts.
struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) normal: vec3f,
    // Seen sky, 0 to 1, and place on the ramp.
    @location(1) openness_value: vec2f,
    @location(2) light: vec3f,
    @location(3) dark: vec3f,
    @location(4) chart: vec2f,
    @location(5) to_eye: vec3f,
}

@vertex
fn surface_vertex(
    @location(0) position: vec3f,
    @location(1) normal_openness: vec4f,
    @location(2) light: vec4f,
    @location(3) dark: vec4f,
    @location(4) value: f32,
    @location(5) chart: vec2f,
) -> Corner {
    var corner: Corner;
    corner.clip = frame.world_to_clip * vec4f(position, 1.0);
    corner.normal = (frame.world_to_view * vec4f(normal_openness.xyz, 0.0)).xyz;
    corner.openness_value = vec2f(normal_openness.w, value);
    corner.light = light.rgb;
    corner.dark = dark.rgb;
    corner.chart = chart;
    corner.to_eye = (frame.world_to_view * vec4f(frame.eye.xyz - position, 0.0)).xyz;
    return corner;
}

@vertex
fn chart_vertex(
    @location(2) light: vec4f,
    @location(3) dark: vec4f,
    @location(4) value: f32,
    @location(5) chart: vec2f,
) -> Corner {
    var corner: Corner;
    corner.clip = frame.world_to_clip * vec4f(chart, 0.0, 1.0);
    corner.normal = vec3f(0.0, 0.0, 1.0);
    corner.openness_value = vec2f(1.0, value);
    corner.light = light.rgb;
    corner.dark = dark.rgb;
    corner.chart = chart;
    corner.to_eye = vec3f(0.0, 0.0, 1.0);
    return corner;
}

// The fraction of a pixel that the dark cells of a checker cover: exact for a pixel of sides `width`
// along the axes, so that far cells fade to grey in place of flickering.
fn checker(place: vec2f, width: vec2f) -> f32 {
    let low = abs(fract((place - 0.5 * width) * 0.5) - 0.5);
    let high = abs(fract((place + 0.5 * width) * 0.5) - 0.5);
    let mean = 2.0 * (low - high) / width;
    return 0.5 - 0.5 * mean.x * mean.y;
}

// Encoded colour without light.
fn own_colour(corner: Corner) -> vec3f {
    let place = corner.chart / frame.paint.z;
    let width = max(abs(dpdx(place)) + abs(dpdy(place)), vec2f(1e-4));
    let share = frame.paint.y * checker(place, width);
    let piece = mix(corner.light, corner.dark, share);
    let value = corner.openness_value.y;
    // Ends of the ramp lie at the centres of its first and last pixel.
    let mapped = textureSampleLevel(ramp, smooth_sampler, vec2f((value * 255.0 + 0.5) / 256.0, 0.5), 0.0);
    let field = select(mapped.rgb, frame.neutral.rgb, value < -1e-3);
    return mix(piece, field, frame.paint.x);
}

// Key light from the upper left and a weak fill from the right, both fixed to the viewer so that
// form shows from everywhere; a sky above and the ground's bounce below.
fn lit(colour: vec3f, normal: vec3f, to_eye: vec3f, openness: f32) -> vec3f {
    let up = (frame.world_to_view * vec4f(0.0, 1.0, 0.0, 0.0)).xyz;
    let key = normalize(vec3f(-0.42, 0.62, 0.66));
    let fill = normalize(vec3f(0.75, -0.05, 0.55));
    let sky = 0.5 + 0.5 * dot(normal, up);
    // Wrapped, squared: a large soft lamp without a hard terminator.
    let wrapped = max(dot(normal, key) * 0.72 + 0.28, 0.0);
    // Creases are darker in the ambient light than in the key light, which comes from one side.
    let closed = 1.0 - openness;
    let ambient = (0.30 + 0.26 * sky) * (1.0 - 0.92 * closed);
    let direct = 0.52 * wrapped * (0.4 + 0.6 * wrapped) * (1.0 - 0.65 * closed);
    let side = 0.10 * max(dot(normal, fill), 0.0) * openness;
    let light = ambient + direct + side;
    let linear_colour = decode(colour);
    let half_way = normalize(key + normalize(to_eye));
    let highlight = 0.025 * pow(max(dot(normal, half_way), 0.0), 24.0) * openness;
    return encode(linear_colour * light + highlight);
}

@fragment
fn surface_fragment(corner: Corner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let colour = own_colour(corner);
    let normal = normalize(corner.normal);
    if is_front {
        return vec4f(lit(colour, normal, corner.to_eye, corner.openness_value.x), 1.0);
    }
    // The inside of an open surface: paler, as lining.
    let lining = mix(colour, vec3f(0.5), 0.45);
    return vec4f(lit(lining, -normal, corner.to_eye, 0.75), 1.0);
}

@fragment
fn chart_fragment(corner: Corner) -> @location(0) vec4f {
    return vec4f(own_colour(corner), 1.0);
}

// Triangles that are turned over: hatched, 8 CSS pixels from line to line.
@fragment
fn flipped_fragment(corner: Corner) -> @location(0) vec4f {
    let colour = own_colour(corner);
    let across = (corner.clip.x + corner.clip.y) / (8.0 * frame.viewport.z);
    let distance = abs(fract(across) - 0.5) * 8.0 * frame.viewport.z * 0.7071;
    let line = clamp(1.2 * frame.viewport.z + 0.5 - distance, 0.0, 1.0);
    return vec4f(mix(colour, frame.warning.rgb, mix(0.35, 1.0, line)), 1.0);
}
