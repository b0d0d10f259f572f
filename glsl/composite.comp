#version 460
#extension GL_GOOGLE_include_directive : require
// Every tile's drops over one another, front to back, the sky behind; one invocation a tile, its
// pixels in registers. See src/passes/composite.rs.
#include "frame.glsl"
#include "environment.glsl"
#include "tile_buffers.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint TILE_COUNT = 1;
layout(constant_id = 1) const uint MAX_ENTRIES = 1;
layout(constant_id = 2) const uint MAX_BLOCKS = 1;

layout(set = 0, binding = 15) uniform sampler2D environment_map;
layout(std430, set = 0, binding = 16) readonly buffer Pictures { uint pictures[]; };
// The result: four halves a pixel, row by row.
layout(std430, set = 0, binding = 17) writeonly buffer Radiance { uvec2 radiance_out[]; };

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
    uint first = tiles[tile].x, end = min(first + tiles[tile].y, MAX_ENTRIES);
    for (uint i = first; i < end; ++i) {
        uint what = entries[i].y;
        bool is_block = (what & IS_BLOCK) != 0u;
        uint block = what & ~IS_BLOCK;
        uint record = is_block ? blocks[min(block, MAX_BLOCKS - 1u)].x : record_of[what];
        Record r = records[record];
        vec4 m = r.to_disc;
        float radius = radius_of(m);
        // Half sides of a box of the disc's area, in the shape of the box around it.
        vec2 box = half_box(m);
        vec2 half_side = box * (0.8862269 * radius * inversesqrt(box.x * box.y));
        float fade = float(r.look >> 16) / 65535.0;
        if (block >= MAX_BLOCKS && is_block) fade = 0.0; // found no room, and was counted
        // A picture whose texels are about as large as a pixel: of small drops rather larger ones,
        // which need no filter, of larger drops rather smaller ones, which keep their detail (by
        // FLIP against the truth on 60,000 and 3,000 drops).
        float finer = clamp(radius - 1.0, -0.5, 0.5);
        float edge = exp2(clamp(ceil(log2(2.0 * radius) + finer), 0.0, 4.0));
        uint base = picture_word(r.look & 0xfffu, uint(edge));
        vec2 from = vec2(corner) + 0.5 - r.center;

        for (uint p = 0u; p < PIXELS; ++p) {
            vec2 offset = from + vec2(p % TILE.x, p / TILE.x);
            vec2 st = m.xy * offset.x + m.zw * offset.y;
            uvec2 texel = uvec2(clamp((0.5 * st + 0.5) * edge, 0.0, edge - 1.0));
            uint word = base + texel.y * uint(edge) + texel.x;
            if (is_block) word = BLOCKS_BASE + min(block, MAX_BLOCKS - 1u) * PIXELS + p;

            // Part of the pixel's square that the drop covers. Under a pixel of radius: its box of
            // equal area against the square, which keeps the sum over all pixels exact at every
            // place. Above: a ramp of one pixel across the edge, 1/(24 R) inside it, which keeps
            // the disc's area.
            vec2 overlap = max(min(offset + 0.5, half_side) - max(offset - 0.5, -half_side), 0.0);
            float disc = length(st);
            vec2 slope = vec2(dot(m.xy, st), dot(m.zw, st));
            float edge_px = (1.0 - disc) * disc * inversesqrt(max(dot(slope, slope), 1e-20));
            float ramp = clamp(edge_px + 0.5 - 1.0 / (24.0 * radius), 0.0, 1.0);
            float alpha = radius < 1.0 ? overlap.x * overlap.y : disc < 1e-3 ? 1.0 : ramp;
            alpha *= fade;
            uint color = pictures[word];
            if (color == NO_COLOR) alpha = 0.0;
            sum[p] += through[p] * alpha * unpack_radiance(color);
            through[p] *= 1.0 - alpha;
        }
    }

    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    float focal = frame.image.z;
    for (uint p = 0u; p < PIXELS; ++p) {
        uvec2 at = corner + uvec2(p % TILE.x, p / TILE.x);
        vec2 offset = vec2(at) + 0.5 - 0.5 * frame.image.xy;
        vec3 ray = vec3(offset.x, -offset.y, -focal);
        float far = length(ray);
        vec3 sky = radiance(environment_map, world * ray / far, sqrt(focal / far) / far);
        vec3 c = sum[p] + through[p] * sky;
        if (at.x < size.x && at.y < size.y) {
            radiance_out[at.y * size.x + at.x] = uvec2(packHalf2x16(c.rg), packHalf2x16(vec2(c.b, 1.0)));
        }
    }
}
