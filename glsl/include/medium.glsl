// Far rain as a medium (src/rain/medium.rs): it takes light out of a ray and puts in that of a far drop. Drops that are
// shown by themselves have the same mean light, so all of the medium may stand behind them. Needs projection.glsl,
// octahedron.glsl, appearance.glsl, rain_field.glsl, sources.glsl and the table `bow`.

// Optical depth from the camera along the view axis.
float optical_depth(float depth) {
    float starts = field.medium.x, at = 63.0 * min(depth / starts, 1.0);
    uint below = min(uint(at), 62u), above = below + 1u;
    float low = field.depths[below / 4u][below % 4u], high = field.depths[above / 4u][above % 4u];
    return mix(low, high, at - float(below)) + field.medium.y * max(depth - starts, 0.0);
}

// Number of the texel at a place of the octahedral map, of which one beyond an edge is another within.
uint wrapped_texel(ivec2 at) {
    const int LAST = int(DIRECTIONS) - 1;
    if (at.x < 0 || at.x > LAST) at = ivec2(clamp(at.x, 0, LAST), LAST - at.y);
    if (at.y < 0 || at.y > LAST) at = ivec2(LAST - at.x, clamp(at.y, 0, LAST));
    return uint(at.y) * DIRECTIONS + uint(at.x);
}

// Mean light of a far drop in a direction: of the environment without its bright sources between those of the four
// nearest texels; of each source by its angle.
vec3 far_light(vec3 d) {
    vec2 at = (0.5 * octahedral(d) + 0.5) * float(DIRECTIONS) - 0.5, from = floor(at), share = at - from;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1);
        vec2 weights = mix(1.0 - share, share, vec2(step));
        uint texel = wrapped_texel(ivec2(from) + step);
        sum += weights.x * weights.y * unpack_radiance(pictures[picture_word(texel, 1u)]);
    }
    for (uint i = 0u; i < source_count.x; ++i) {
        vec3 toward = sources[i].toward.xyz;
        float turn = atan(length(cross(d, toward)), dot(d, toward)) / 3.14159265 * float(BOW_ANGLES - 1u);
        uint below = min(uint(turn), BOW_ANGLES - 2u), entry = i * BOW_ANGLES + below;
        sum += mix(bow[entry].rgb, bow[entry + 1u].rgb, turn - float(below));
    }
    return sum;
}

// The share of light that passes the medium along a unit direction in view space, up to a distance.
float medium_passes(vec3 view, float distance) {
    float cosine = max(-view.z, 1e-6);
    return exp(-optical_depth(min(distance, field.medium.z) * cosine) / cosine);
}

// What is seen of `behind` through the medium along a unit direction in view space, up to a distance.
vec3 through_medium(vec3 behind, vec3 view, vec3 world, float distance) {
    float passes = medium_passes(view, distance);
    return passes * behind + (1.0 - passes) * far_light(world);
}
