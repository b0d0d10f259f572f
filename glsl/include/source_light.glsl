// The light of bright sources in far drops. Needs sources.glsl, bow.glsl and the table `bow`.

// Mean light of all their images in a far drop in a unit direction in world space.
vec3 light_of_sources(vec3 d) {
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < source_count.x; ++i) {
        vec3 toward = sources[i].toward.xyz;
        float turn = atan(length(cross(d, toward)), dot(d, toward)) / 3.14159265 * float(BOW_ANGLES - 1u);
        uint below = min(uint(turn), BOW_ANGLES - 2u), entry = i * BOW_ANGLES + below;
        sum += mix(bow[entry].rgb, bow[entry + 1u].rgb, turn - float(below));
    }
    return sum;
}
