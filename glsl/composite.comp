#version 460
#extension GL_GOOGLE_include_directive : require
// Every tile's drops over one another, front to back, the sky behind; one invocation a tile, its
// pixels in registers. See src/passes/composite.rs.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "splat.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 15) const uint LOG_SUMS = 0; // 1: the display needs the log average
// The result: four halves a pixel, row by row.
layout(std430, set = 0, binding = 13) writeonly buffer Radiance { uvec2 radiance_out[]; };
// The environment behind, pixel by pixel of a tile after the other.
layout(std430, set = 0, binding = 14) readonly buffer Sky { uvec2 sky[]; };
// For each tile the sum of its pixels' log(delta + luminance).
layout(std430, set = 0, binding = 15) writeonly buffer LogSums { float log_sums[]; };

#include "by_four.glsl"
#include "tile_order.glsl"

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // Rec. 709

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (tile >= TILE_COUNT) return;
    uvec2 size = uvec2(frame.image.xy);
    uvec2 corner = uvec2(tile % tiles_across(), tile / tiles_across()) * TILE;

    vec3 sum[PIXELS];
    float through[PIXELS]; // transmittance
    for (uint p = 0u; p < PIXELS; ++p) {
        sum[p] = vec3(0.0);
        through[p] = 1.0;
    }
    // Drops alike look larger the nearer they are, so a tile's list is blocks, then splats; placed
    // drops of other sizes may make it change more than once.
    uint link = order_tile(tile);
    do {
        while (link != END && is_block(link)) {
            uint pixels = (link / NODE - FIRST_BLOCK) * BLOCK;
            uvec4 colors[2] = uvec4[2](four_of_blocks(pixels), four_of_blocks(pixels + 4u));
            uvec4 coverage = four_of_blocks(pixels + COVERAGE);
            for (uint p = 0u; p < PIXELS; ++p) {
                uint color = colors[p / 4u][p % 4u];
                float alpha = color == NO_COLOR ? 0.0 : unpackUnorm2x16(coverage[p / 2u])[p % 2u];
                sum[p] += through[p] * alpha * unpack_radiance(color);
                through[p] *= 1.0 - alpha;
            }
            link = nodes[link];
        }
        while (link != END && !is_block(link)) {
            uint node = link & ~(NODE - 1u), which = link & 3u, look = nodes[node + 3u];
            vec2 half_sides = unpack_half_sides(look);
            vec3 color = unpack_radiance(pictures[picture_word(look & 0xfffu, 1u)]);
            // From the centre to the tile's corner.
            vec2 from = vec2(uvec2(which & 1u, which >> 1) * TILE) - unpack_center(nodes[node + 2u]);
            // What each column and each row of pixels has of the box.
            float columns[TILE.x], rows[TILE.y];
            for (uint x = 0u; x < TILE.x; ++x) {
                float at = from.x + float(x);
                columns[x] = max(min(at + 1.0, half_sides.x) - max(at, -half_sides.x), 0.0);
            }
            for (uint y = 0u; y < TILE.y; ++y) {
                float at = from.y + float(y);
                rows[y] = max(min(at + 1.0, half_sides.y) - max(at, -half_sides.y), 0.0);
            }
            for (uint p = 0u; p < PIXELS; ++p) {
                float share = through[p] * columns[p % TILE.x] * rows[p / TILE.x];
                sum[p] += share * color;
                through[p] -= share;
            }
            link = nodes[link];
        }
    } while (link != END);

    float logs = 0.0;
    uvec4 skies[PIXELS / 2u];
    for (uint p = 0u; p < PIXELS; p += 2u) skies[p / 2u] = two_of_sky(tile * PIXELS + p);
    for (uint p = 0u; p < PIXELS; ++p) {
        uvec2 at = corner + uvec2(p % TILE.x, p / TILE.x);
        uvec2 behind = p % 2u == 0u ? skies[p / 2u].xy : skies[p / 2u].zw;
        vec3 c = sum[p] + through[p] * vec3(unpackHalf2x16(behind.x), unpackHalf2x16(behind.y).x);
        if (at.x < size.x && at.y < size.y) {
            radiance_out[at.y * size.x + at.x] = uvec2(packHalf2x16(c.rg), packHalf2x16(vec2(c.b, 1.0)));
            if (LOG_SUMS != 0u) logs += log(frame.tone.y + dot(c, LUMINANCE));
        }
    }
    if (LOG_SUMS != 0u) log_sums[tile] = logs;
}
