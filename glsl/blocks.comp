#version 460
#extension GL_GOOGLE_include_directive : require
// The blocks, each a tile of a large drop: what the drop covers of its pixels, its colours there from
// the prefiltered pictures, and its entry into the tile's list; one invocation a block. See
// src/passes/tiles.rs.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "appearance.glsl"

layout(local_size_x = 64) in;

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= min(totals.blocks, MAX_BLOCKS)) return;
    uint node = (FIRST_BLOCK + at) * NODE, owner = nodes[node + 2u];
    Large r = larges[owner];
    uint number = at - r.first_block;
    uvec2 at_tile = uvec2(r.first_tile & 0xffffu, r.first_tile >> 16)
        + uvec2(number % r.across, number / r.across);
    bool rays = (r.look & BY_RAYS) != 0u;

    vec4 m = r.to_disc;
    float det = abs(m.x * m.w - m.y * m.z), radius = inversesqrt(det);
    vec2 half_side = box_of_equal_area(vec2(length(m.wz), length(m.yx)) / det, radius);
    float fade = float(r.look >> 16) / 65535.0;
    // A picture whose texels are about as large as a pixel: of small drops rather larger ones, which
    // need no filter, of larger drops rather smaller ones, which keep their detail (by FLIP against
    // the truth on 60,000 and 3,000 drops).
    float finer = clamp(radius - 1.0, -0.5, 0.5);
    float edge = exp2(clamp(ceil(log2(2.0 * radius) + finer), 0.0, 4.0));
    uint picture = picture_word(r.look & 0xfffu, uint(edge));
    vec2 from = vec2(at_tile * TILE) + 0.5 - r.center;

    float alpha[PIXELS], most = 0.0;
    for (uint p = 0u; p < PIXELS; ++p) {
        vec2 offset = from + vec2(p % TILE.x, p / TILE.x);
        vec2 st = m.xy * offset.x + m.zw * offset.y;

        // Part of the pixel's square that the drop covers. Under a pixel of radius: its box of
        // equal area against the square, which keeps the sum over all pixels exact at every
        // place. Above: a ramp of one pixel across the edge, 1/(24 R) inside it, which keeps
        // the disc's area.
        vec2 overlap = max(min(offset + 0.5, half_side) - max(offset - 0.5, -half_side), 0.0);
        float disc = length(st);
        vec2 slope = vec2(dot(m.xy, st), dot(m.zw, st));
        float edge_px = (1.0 - disc) * disc * inversesqrt(max(dot(slope, slope), 1e-20));
        float ramp = clamp(edge_px + 0.5 - 1.0 / (24.0 * radius), 0.0, 1.0);
        alpha[p] = fade * (radius < 1.0 ? overlap.x * overlap.y : disc < 1e-3 ? 1.0 : ramp);
        most = max(most, alpha[p]);

        uvec2 texel = uvec2(clamp((0.5 * st + 0.5) * edge, 0.0, edge - 1.0));
        if (!rays) block_pixels[at * BLOCK + p] = pictures[picture + texel.y * uint(edge) + texel.x];
    }
    uint pairs[4] = uint[4](
        packUnorm2x16(vec2(alpha[0], alpha[1])), packUnorm2x16(vec2(alpha[2], alpha[3])),
        packUnorm2x16(vec2(alpha[4], alpha[5])), packUnorm2x16(vec2(alpha[6], alpha[7])));
    for (uint w = 0u; w < 4u; ++w) block_pixels[at * BLOCK + COVERAGE + w] = pairs[w];

    // The outline's box has corners that the outline does not reach.
    if (most > 0.0) {
        uint slot = (at_tile.y * tiles_across() + at_tile.x) * SLABS
            + slab_of(uintBitsToFloat(r.distance2));
        nodes[node] = r.distance2;
        nodes[node + 1u] = r.index;
        nodes[node + LINKS] = atomicExchange(heads[slot], node + LINKS);
    }
    if (most > 0.0 && rays) {
        uint place = atomicAdd(totals.ray_blocks, 1u);
        ray_blocks[place] = at;
        atomicMax(totals.ray_groups.x, place / (256u / PIXELS) + 1u);
    }
}
