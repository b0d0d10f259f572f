#ifndef SHELTER_GLSL
#define SHELTER_GLSL
// Whether a surface keeps rain off a place: the same as `Roofs` in src/rain/shelter.rs, bit for bit. A texel of the height map
// is a column without a bottom. A drop's line of fall is followed back, upwards, from column to column until it is over all
// that stands along its way. The largest heights of a few texels end most walks before they begin, and change no answer.
#include "constants.glsl"

// Level by level the largest of four texels of the level before.
layout(set = 1, binding = 20) uniform sampler2D height_map;
layout(std140, set = 1, binding = 21) uniform Shelter {
    vec4 origin; // xyz: the map's first corner, at height 0, from the camera; w: its largest height
    vec4 scale;  // xy: texels a scene unit along x and z; zw: columns and rows
    vec4 lines[MOST_CLASSES]; // of drops of each kind: texels that they are farther back a unit of height, and units of height a texel
    vec4 medium; // the same of the medium
} shelter;

// The largest height along a part of a line that is `from` to `to` over its beginning, and of a few texels around.
float highest_along(vec2 at, vec2 across, float from, float to) {
    vec2 a = at + from * across, b = at + to * across, last = shelter.scale.zw - 1.0;
    ivec2 low = ivec2(clamp(floor(min(a, b)) - 1.0, vec2(0.0), last));
    ivec2 high = ivec2(clamp(floor(max(a, b)) + 1.0, vec2(0.0), last));
    ivec2 span = high - low, size = ivec2(shelter.scale.zw);
    // At this level they are two neighbours, or at the last one texel.
    int level = min(findMSB(max(max(span.x, span.y) - 1, 0)) + 1, findMSB(max(size.x, size.y)));
    // A level that has no pair for its last texel has it in the one before. (llvmpipe has one `textureSize` for all lanes.)
    ivec2 most = max(size >> level, 1) - 1;
    low = min(low >> level, most);
    high = min(high >> level, most);
    return max(max(texelFetch(height_map, low, level).r, texelFetch(height_map, ivec2(high.x, low.y), level).r),
               max(texelFetch(height_map, ivec2(low.x, high.y), level).r, texelFetch(height_map, high, level).r));
}

// `relative`: a place from the camera along the world's axes.
bool is_sheltered(vec3 relative, vec4 line) {
    vec2 size = shelter.scale.zw;
    precise vec2 at = (relative.xz - shelter.origin.xz) * shelter.scale.xy;
    precise float height = relative.y - shelter.origin.y;
    // Over the place by so much the line comes in over the map's edges, and goes out.
    bvec2 ahead = greaterThanEqual(line.xy, vec2(0.0));
    precise vec2 comes = (mix(size, vec2(0.0), ahead) - at) * line.zw;
    precise vec2 goes = (mix(vec2(0.0), size, ahead) - at) * line.zw;
    precise float up = max(max(comes.x, comes.y), 0.0);
    precise float begin = height + up;
    float out_at = min(goes.x, goes.y), top = shelter.origin.w;
    if (up > out_at || begin > top) return false;
    precise vec2 first = at + up * line.xy;
    ivec2 cell = ivec2(clamp(floor(first), vec2(0.0), size - 1.0)), edge = ivec2(ahead), forward = 2 * edge - 1;
    if (begin <= texelFetch(height_map, cell, 0).r) return true;
    top = min(top, highest_along(at, line.xy, up, min(out_at, top - height)));
    if (begin > top) return false;
    for (;;) {
        precise vec2 next = (vec2(cell + edge) - at) * line.zw;
        bool along_x = next.x <= next.y;
        up = along_x ? next.x : next.y;
        cell += along_x ? ivec2(forward.x, 0) : ivec2(0, forward.y);
        precise float here = height + up;
        bool is_over = any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, ivec2(size))) || here > top;
        if (is_over) return false;
        if (here <= texelFetch(height_map, cell, 0).r) return true;
    }
}
#endif
