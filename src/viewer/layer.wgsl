// Overlapping charts: each place once for each chart that covers it, added up.
struct Corner {
    @builtin(position) @invariant clip: vec4f,
    @location(0) normal: vec3f,
    @location(1) openness: f32,
    @location(2) light: vec3f,
    @location(3) dark: vec3f,
    @location(4) uv: vec2f,
    @location(5) weights: vec4f,
    @location(6) to_eye: vec3f,
    @location(7) kept: f32,
}

@vertex
fn layer_vertex(
    @location(0) position: vec3f,
    @location(1) normal_openness: vec4f,
    @location(2) light: vec4f,
    @location(3) dark: vec4f,
    @location(4) uv: vec2f,
    @location(6) weights: vec4f,
) -> Corner {
    var corner: Corner;
    corner.clip = frame.world_to_clip * vec4f(position, 1.0);
    corner.normal = (frame.world_to_view * vec4f(normal_openness.xyz, 0.0)).xyz;
    corner.openness = normal_openness.w;
    corner.light = light.rgb;
    corner.dark = dark.rgb;
    corner.uv = uv;
    corner.weights = weights;
    corner.to_eye = (frame.world_to_view * vec4f(frame.eye.xyz - position, 0.0)).xyz;
    corner.kept = kept(position);
    return corner;
}

@vertex
fn layer_chart_vertex(
    @location(2) light: vec4f,
    @location(3) dark: vec4f,
    @location(4) uv: vec2f,
    @location(5) place: vec2f,
    @location(6) weights: vec4f,
) -> Corner {
    var corner: Corner;
    corner.clip = frame.world_to_clip * vec4f(place, 0.0, 1.0);
    corner.normal = vec3f(0.0, 0.0, 1.0);
    corner.openness = 1.0;
    corner.light = light.rgb;
    corner.dark = dark.rgb;
    corner.uv = uv;
    corner.weights = weights;
    corner.to_eye = vec3f(0.0, 0.0, 1.0);
    corner.kept = 1.0;
    return corner;
}

// The share of a chart: its weight, or all where it is the largest. Borders are one pixel wide: there the shares of
// two charts add up to 1 as well.
fn share(weights: vec4f) -> f32 {
    let lead = weights.xxx - weights.yzw;
    let width = max(abs(dpdx(lead)) + abs(dpdy(lead)), vec3f(1e-6));
    let wins = clamp(0.5 + lead / width, vec3f(0.0), vec3f(1.0));
    return select(clamp(weights.x, 0.0, 1.0), min(wins.x, min(wins.y, wins.z)), frame.pixels.z > 0.5);
}

// Encoded colour without light. Lines and areas are dark and light in the chart's own colour.
fn layer_colour(corner: Corner) -> vec3f {
    let place = corner.uv / frame.paint.z;
    let across = dpdx(place);
    let along = dpdy(place);
    let width = max(abs(across) + abs(along), vec2f(1e-4));
    let has_chart = any(abs(corner.light - corner.dark) > vec3f(1e-3));
    if is_pixels(frame.paint.y) && has_chart {
        return pixels_at(place, across, along);
    }
    let shares = select(vec2f(0.0), texture_shares(place, width), has_chart);
    let is_grid = frame.paint.y > 1.5 && frame.paint.y < 2.5;
    // Several charts share the contrast: more than one alone has.
    return mix(corner.light, corner.dark, shares.x * select(2.2, 3.6, is_grid));
}

// What shares are added to.
@fragment
fn layer_ground_fragment(corner: Corner) -> @location(0) vec4f {
    if corner.kept < 0.0 {
        discard;
    }
    return vec4f(0.0, 0.0, 0.0, 1.0);
}

@fragment
fn layer_fragment(corner: Corner, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let colour = layer_colour(corner);
    let part = share(corner.weights);
    let normal = normalize(corner.normal);
    if corner.kept < 0.0 {
        discard;
    }
    if is_front {
        return vec4f(part * lit(colour, normal, corner.to_eye, corner.openness), 0.0);
    }
    if frame.paint.w > 0.5 {
        return vec4f(part * inside(normal, corner.to_eye), 0.0);
    }
    let lining = mix(colour, vec3f(0.5), 0.45);
    return vec4f(part * lit(lining, -normal, corner.to_eye, 0.75), 0.0);
}

// Side by side the weight is the opacity; what another chart has the most of is seen faintly still.
@fragment
fn layer_chart_fragment(corner: Corner) -> @location(0) vec4f {
    let colour = layer_colour(corner);
    let part = share(corner.weights);
    return vec4f(colour, select(part, mix(0.12, 1.0, part), frame.pixels.z > 0.5));
}
