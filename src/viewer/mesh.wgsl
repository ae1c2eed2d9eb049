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

// Textures. Each gives the fraction of a pixel that it covers, so that far cells fade to their mean in
// place of flickering. A pixel is a box with sides `width` along the axes of the charts, and lengths
// are in cells.

// The fraction of an interval that bars around all whole numbers cover: exact.
fn bars(at: f32, width: f32, half_bar: f32) -> f32 {
    let low = at - 0.5 * width;
    let high = at + 0.5 * width;
    let low_cell = round(low);
    let high_cell = round(high);
    let whole = 2.0 * half_bar * (high_cell - low_cell);
    let rest = clamp(high - high_cell, -half_bar, half_bar) - clamp(low - low_cell, -half_bar, half_bar);
    return (whole + rest) / width;
}

// Squares, each second one covered: exact.
fn squares(place: vec2f, width: vec2f) -> f32 {
    let low = abs(fract((place - 0.5 * width) * 0.5) - 0.5);
    let high = abs(fract((place + 0.5 * width) * 0.5) - 0.5);
    let mean = 2.0 * (low - high) / width;
    return 0.5 - 0.5 * mean.x * mean.y;
}

// Lines through all whole numbers of both axes: exact.
fn lines(place: vec2f, width: vec2f, half_line: vec2f) -> f32 {
    let x = bars(place.x, width.x, min(half_line.x, 0.5));
    let y = bars(place.y, width.y, min(half_line.y, 0.5));
    return 1.0 - (1.0 - x) * (1.0 - y);
}

// Discs around the middles of all cells: exact in the direction that the edge faces, four strips across it.
fn discs(place: vec2f, width: vec2f, radius: f32) -> f32 {
    let moved = place - 0.5;
    let from_middle = abs(moved - round(moved));
    let is_flat = from_middle.x < from_middle.y;
    let at = select(moved.yx, moved, is_flat);
    let size = select(width.yx, width, is_flat);
    var sum = 0.0;
    for (var strip = 0; strip < 4; strip += 1) {
        let x = at.x + (0.25 * f32(strip) - 0.375) * size.x;
        let across = x - round(x);
        sum += bars(at.y, size.y, sqrt(max(radius * radius - across * across, 0.0)));
    }
    // Where four strips are no fair sample of the cells in a pixel, their mean is.
    let far = smoothstep(0.6, 1.2, max(width.x, width.y));
    return mix(0.25 * sum, 3.14159265 * radius * radius, far);
}

// How much of the texture's dark and of its light colour a pixel has.
fn texture_shares(place: vec2f, width: vec2f) -> vec2f {
    let kind = frame.paint.y;
    if kind < 0.5 {
        return vec2f(0.0);
    }
    if kind < 1.5 {
        let dark = squares(place, width);
        return vec2f(dark, 1.0 - dark);
    }
    if kind < 2.5 {
        // As wide on the screen as they look from near, in chart and on the surface alike; beside a dark line
        // a light one, as fields have every colour.
        let pixel = width * frame.viewport.z;
        let dark = lines(place, width, max(vec2f(0.02), 0.55 * pixel));
        let both = lines(place, width, max(vec2f(0.035), 1.05 * pixel));
        return vec2f(dark, both - dark);
    }
    let dark = discs(place, width, 0.36);
    return vec2f(dark, 1.0 - dark);
}

// Encoded colour without light.
fn own_colour(corner: Corner) -> vec3f {
    let place = corner.chart / frame.paint.z;
    let width = max(abs(dpdx(place)) + abs(dpdy(place)), vec2f(1e-4));
    // Where there is no chart both colours are the same.
    let has_chart = any(abs(corner.light - corner.dark) > vec3f(1e-3));
    let shares = select(vec2f(0.0), texture_shares(place, width), has_chart);
    let is_grid = frame.paint.y > 1.5 && frame.paint.y < 2.5;
    // Lines are thin: the same contrast as that of areas would be lost in them.
    let piece = mix(corner.light, corner.dark, shares.x * select(1.0, 2.4, is_grid));
    let value = corner.openness_value.y;
    // Ends of the ramp lie at the centres of its first and last pixel.
    let mapped = textureSampleLevel(ramp, smooth_sampler, vec2f((value * 255.0 + 0.5) / 256.0, 0.5), 0.0);
    let field = select(mapped.rgb, frame.neutral.rgb, value < -1e-3);
    // A field keeps its colour in the mean; darker tells on light colours, lighter on dark ones.
    let amount = select(vec2f(0.09, 0.08), vec2f(0.42, 0.3), is_grid);
    let textured = mix(field, vec3f(0.0), amount.x * shares.x);
    return mix(piece, mix(textured, vec3f(1.0), amount.y * shares.y), frame.paint.x);
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
