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

// Whether a kind of texture is made of pixels.
fn is_pixels(kind: f32) -> bool {
    return kind > 3.5;
}

// Encoded colour of a texture made of pixels. Derivatives are handed in, so that this may be called anywhere.
fn pixels_at(place: vec2f, across: vec2f, along: vec2f) -> vec3f {
    // Rows of an image run down, charts up.
    let scale = vec2f(1.0, -1.0) / frame.pixels.xy;
    return textureSampleGrad(pixels, repeat_sampler, place * scale, across * scale, along * scale).rgb;
}
