#version 460
#extension GL_GOOGLE_include_directive : require
// The sum of log luminance of each tile's pixels, of a picture that has a pane: in the order and the places of composite.comp's,
// so that an exposure is derived from either. One invocation a tile.
#include "pane.glsl"
#include "pane_pictures.glsl"
#include "divided.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 9) writeonly buffer LogSums { float log_sums[]; };

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709

void main() {
    uint tile = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (tile >= pane.tiles) return;
    const uvec2 TILE = uvec2(TILE_ACROSS, TILE_DOWN);
    uvec2 first = (divided(tile, pane.tiles_across).yx + pane.first_tile) * TILE - frame.window.xy, size = frame.window.zw;
    float sum = 0.0;
    for (uint i = 0u; i < TILE.x * TILE.y; ++i) {
        uvec2 at = first + uvec2(i % TILE.x, i / TILE.x);
        // Modulo 2^32: pixels before the first that is drawn are beyond the size.
        if (all(lessThan(at, size))) sum += log(frame.tone.y + dot(halves_of(radiance_out[at.y * size.x + at.x]).rgb, LUMINANCE));
    }
    log_sums[tile] = sum;
}
