// The shadow on the ground: a square that darkens whatever is behind it.
struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) place: vec2f,
}

@vertex
fn ground_vertex(@builtin(vertex_index) index: u32) -> Corner {
    let place = vec2f(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    let reach = frame.ground.y;
    var corner: Corner;
    corner.clip = frame.world_to_clip * vec4f(place.x * reach, frame.ground.x, place.y * reach, 1.0);
    corner.place = place * 0.5 + 0.5;
    return corner;
}

@fragment
fn ground_fragment(corner: Corner) -> @location(0) vec4f {
    let darkness = textureSampleLevel(shadow, smooth_sampler, corner.place, 0.0).r;
    // Nothing may end at the edge of the view.
    let room = min(corner.clip.xy, frame.viewport.xy - corner.clip.xy) / frame.viewport.xy;
    let inside = smoothstep(0.0, 0.2, room.x) * smoothstep(0.0, 0.12, room.y);
    return vec4f(0.0, 0.0, 0.0, darkness * frame.ground.z * frame.ground.w * inside);
}
