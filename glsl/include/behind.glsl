#ifndef BEHIND_GLSL
#define BEHIND_GLSL
// What hides drops: `distance_behind` of tile_buffers.glsl, and drops that cut it.
#include "projection.glsl"
#include "tile_buffers.glsl"

// Squared, of the tile that an invocation of composite.comp draws.
vec4 upper_behind2, lower_behind2;

// Reads the distances of a row of a tile's pixels.
vec4 behind_of_row(uint tile, uint row) {
    uint at = tile * PIXELS + row * TILE.x;
    return vec4(distance_behind[at], distance_behind[at + 1u], distance_behind[at + 2u], distance_behind[at + 3u]);
}

// Share of what a sphere covers around a point of the image that is nearer than `far`. The sphere's front within half a
// pixel runs from its distance that much nearer its middle to that nearer its rim, and is taken to rise evenly.
float share_before(vec4 sphere, vec2 pixel, float far) {
    vec3 ray = ray_through(pixel);
    float length2 = dot(ray, ray), inverse = inversesqrt(length2);
    vec3 d = ray * inverse;
    float along = dot(d, sphere.xyz), b = length(cross(d, sphere.xyz)) / sphere.w;
    float half_pixel = 0.5 * abs(along) * inverse / sphere.w;
    float inner = clamp(b - half_pixel, 0.0, 1.0), outer = clamp(b + half_pixel, 0.0, 1.0);
    float nearest = along - sphere.w * sqrt((1.0 - inner) * (1.0 + inner));
    float farthest = along - sphere.w * sqrt((1.0 - outer) * (1.0 + outer));
    return clamp((far - nearest) / max(farthest - nearest, 1e-6 * abs(along)), 0.0, 1.0);
}

// Finds the shares of a row of pixels, from the middle of the first on.
vec4 row_before(vec4 sphere, vec2 first, vec4 far) {
    return vec4(share_before(sphere, first, far.x), share_before(sphere, first + vec2(1.0, 0.0), far.y),
                share_before(sphere, first + vec2(2.0, 0.0), far.z), share_before(sphere, first + vec2(3.0, 0.0), far.w));
}
#endif
