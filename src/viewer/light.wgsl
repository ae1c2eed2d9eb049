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


// What is seen of the inside where a part is cut away: one plain dark colour, with just the light that tells its form.
fn inside(normal: vec3f, to_eye: vec3f) -> vec3f {
    return lit(vec3f(0.46, 0.47, 0.51), -normal, to_eye, 0.7);
}
