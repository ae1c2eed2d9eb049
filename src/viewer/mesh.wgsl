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
    @location(6) kept: f32,
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
    corner.kept = kept(position);
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
    corner.kept = 1.0;
    return corner;
}

// Encoded colour without light.
fn own_colour(corner: Corner) -> vec3f {
    let place = corner.chart / frame.paint.z;
    let across = dpdx(place);
    let along = dpdy(place);
    let width = max(abs(across) + abs(along), vec2f(1e-4));
    // Where there is no chart both colours are the same.
    let has_chart = any(abs(corner.light - corner.dark) > vec3f(1e-3));
    let value = corner.openness_value.y;
    // Ends of the ramp lie at the centres of its first and last pixel.
    let mapped = textureSampleLevel(ramp, smooth_sampler, vec2f((value * 255.0 + 0.5) / 256.0, 0.5), 0.0);
    let field = select(mapped.rgb, frame.neutral.rgb, value < -1e-3);
    if is_pixels(frame.paint.y) && has_chart {
        let colour = pixels_at(place, across, along);
        // A field keeps its colour: of the pixels it takes the brightness alone.
        let brightness = dot(colour, vec3f(0.299, 0.587, 0.114));
        let shaded = mix(field * (0.6 + 0.4 * brightness), field, 0.35);
        return mix(colour, shaded, frame.paint.x);
    }
    let shares = select(vec2f(0.0), texture_shares(place, width), has_chart);
    let is_grid = frame.paint.y > 1.5 && frame.paint.y < 2.5;
    // Lines are thin: the same contrast as that of areas would be lost in them.
    let piece = mix(corner.light, corner.dark, shares.x * select(1.0, 2.4, is_grid));
    // A field keeps its colour in the mean; darker tells on light colours, lighter on dark ones.
    let amount = select(vec2f(0.09, 0.08), vec2f(0.42, 0.3), is_grid);
    let textured = mix(field, vec3f(0.0), amount.x * shares.x);
    return mix(piece, mix(textured, vec3f(1.0), amount.y * shares.y), frame.paint.x);
}

@fragment
fn surface_fragment(corner: Corner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    // Before anything is discarded: derivatives need their neighbours.
    let colour = own_colour(corner);
    let normal = normalize(corner.normal);
    if corner.kept < 0.0 {
        discard;
    }
    if is_front {
        return vec4f(lit(colour, normal, corner.to_eye, corner.openness_value.x), 1.0);
    }
    if frame.paint.w > 0.5 {
        return vec4f(inside(normal, corner.to_eye), 1.0);
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
