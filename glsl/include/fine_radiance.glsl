#ifndef FINE_RADIANCE_GLSL
#define FINE_RADIANCE_GLSL
// The mean of an environment over a small part of a pixel, as exact as float32: beside a sun that is 10^4 times as bright as its sky a
// thousandth of a pixel counts, and the next sample of many may be farther away.

// The integral of a texel's weight between its middle and so many texels beside it.
vec2 weight_to(vec2 aside) {
    vec2 inside = clamp(aside, vec2(-1.0), vec2(1.0));
    return inside - 0.5 * inside * abs(inside);
}

// The mean over a rectangle of the finest level, linear between texels; `middle` and `half_size`, at most 1/2, in texels.
vec3 radiance_over(sampler2D map, vec2 middle, vec2 half_size) {
    ivec2 size = textureSize(map, 0), first = ivec2(ceil(middle - half_size - 1.5));
    vec2 h = max(half_size, vec2(1e-3));
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 9; ++i) {
        ivec2 texel = first + ivec2(i % 3, i / 3);
        vec2 aside = vec2(texel) + 0.5 - middle, weight = (weight_to(aside + h) - weight_to(aside - h)) / (2.0 * h);
        ivec2 at = ivec2((texel.x + size.x) % size.x, clamp(texel.y, 0, size.y - 1));
        sum += weight.x * weight.y * texelFetch(map, at, 0).rgb;
    }
    return sum;
}

// Where a direction is on the map, in texels, and how far it moves for a small way of it, in the columns of `ways`: the axis-parallel
// rectangle that is as wide, by its variance, as these ways make together.
vec3 radiance_around(sampler2D map, vec3 d, mat2x3 ways) {
    vec2 size = vec2(textureSize(map, 0)), scale = size / vec2(6.28318531, 3.14159265);
    float across2 = max(dot(d.xz, d.xz), 1e-12), across = sqrt(across2);
    vec2 angle = vec2(atan(d.x, -d.z), atan(across, d.y));
    vec3 by_azimuth = vec3(-d.z, 0.0, d.x) / across2;
    vec3 by_polar = vec3(d.y * d.x, -across2, d.y * d.z) / (across * dot(d, d));
    vec2 moved = scale * vec2(length(by_azimuth * ways), length(by_polar * ways));
    return radiance_over(map, vec2(0.5 * size.x, 0.0) + scale * angle, min(0.5 * moved, vec2(0.5)));
}
#endif
