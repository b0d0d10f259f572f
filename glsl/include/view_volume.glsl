#ifndef VIEW_VOLUME_GLSL
#define VIEW_VOLUME_GLSL
// Whether a box of drops is in view, and where.
#include "projection.glsl"
#include "tile_buffers.glsl"

// May a drop that reaches over a box by `reach` at most be in view? The box from the camera, along the world's axes.
bool meets_view(vec3 center, vec3 half_size, float reach) {
    vec3 planes[5] = vec3[5](
        frame.frustum_x.z * frame.right.xyz + frame.frustum_x.w * frame.back.xyz,
        -frame.frustum_x.x * frame.right.xyz + frame.frustum_x.y * frame.back.xyz,
        frame.frustum_y.x * frame.up.xyz + frame.frustum_y.y * frame.back.xyz,
        -frame.frustum_y.z * frame.up.xyz + frame.frustum_y.w * frame.back.xyz,
        frame.back.xyz);
    bool result = true;
    for (uint i = 0u; i < 5u; ++i) {
        result = result && dot(planes[i], center) - dot(abs(planes[i]), half_size) <= reach;
    }
    return result;
}

// The region where a point is seen, or nearest to it; `depth`: its depth, or `least` if that is more.
uint region_at(vec3 point, float depth, float least) {
    vec2 across = vec2(dot(frame.right.xyz, point), -dot(frame.up.xyz, point));
    vec2 pixel = pixel_of(across * (frame.image.z / max(depth, least)));
    vec2 first = vec2(frame.window.xy), last = vec2(frame.window.xy + frame.window.zw - 1u);
    uvec2 tile = uvec2(clamp(pixel, first, last)) / TILE, region = tile - first_tile() >> region_tile_bits();
    return region.y * REGIONS_ACROSS + region.x;
}
#endif
