#version 460
#extension GL_GOOGLE_include_directive : require
// The drops of the cells in view: where each is, whether it is in view, which tiles it touches.
// See src/passes/tiles.rs.
#include "frame.glsl"
#include "rain.glsl"
#include "octahedron.glsl"
#include "tile_buffers.glsl"

layout(local_size_x = 32) in;
layout(constant_id = 0) const uint MAX_LARGE = 1;
layout(constant_id = 1) const uint MAX_RECORDS = 1;
layout(constant_id = 2) const float LARGEST_PX = 32.0; // diameter of the largest drop of the tiles

layout(std430, set = 0, binding = 15) readonly buffer PlacedDrops { Placed placed[]; };
#define COUNTERS_BINDING 16
#include "counters.glsl"

// Half the sides of the box around the unit disc's preimage, in pixels.
vec2 half_box(vec4 m) {
    float det = m.x * m.w - m.y * m.z;
    return vec2(length(vec2(m.w, m.z)), length(vec2(m.y, m.x))) / abs(det);
}

// Enters the drop into the lists of the tiles that it touches.
uvec4 enter_tiles(Record r) {
    vec2 box = half_box(r.to_disc);
    // Pixels whose squares the outline's box meets, smoothed over one pixel.
    ivec2 size = ivec2(frame.image.xy);
    ivec2 low = clamp(ivec2(ceil(r.center - box - 1.0)), ivec2(0), size);
    ivec2 high = clamp(ivec2(floor(r.center + box)), ivec2(-1), size - 1);
    uvec4 bin = uvec4(0u);
    if (any(greaterThan(low, high))) return bin;
    uvec2 first = uvec2(low) / TILE, count = uvec2(high) / TILE - first + 1u;
    bool wide = count.x > 2u || count.y > 2u;
    bin.x = first.x | first.y << 16;
    bin.y = count.x | count.y << 8 | uint(wide) << 31;
    uint tiles_across = (uint(size.x) + TILE - 1u) / TILE;
    // Slabs of equal volume: a tile sees about as many drops in each.
    float far = r.distance2 * frame.tone.z;
    uint slab = uint(min(far * sqrt(far) * float(SLABS), float(SLABS) - 1.0));
    uint number = 0u;
    for (uint y = 0u; y < count.y; ++y) {
        for (uint x = 0u; x < count.x; ++x, ++number) {
            uint at = ((first.y + y) * tiles_across + first.x + x) * SLABS + slab;
            if (wide) {
                atomicAdd(slab_wide[at], 1u);
            } else {
                uint place = min(atomicAdd(slab_small[at], 1u), 0xffffu);
                if (number < 2u) bin.z |= place << (16u * number);
                else bin.w |= place << (16u * (number - 2u));
            }
        }
    }
    return bin;
}

void main() {
    uint in_view = 0u;
    for (uint c = 0u; c < CELLS_A_GROUP; ++c) {
        uint slot = gl_WorkGroupID.x * CELLS_A_GROUP + c;
        uint count = 0u;
        uvec4 cell = uvec4(0u);
        if (slot < totals.visible_cells) {
            cell = visible_cells[slot];
            count = cell.y;
        }
        for (uint i = gl_LocalInvocationID.x; i < count; i += gl_WorkGroupSize.x) {
            uint index = drop_order[cell.x + i], at = cell.z + i;
            vec3 p;
            float radius;
            if (index < frame.camera_place.w) {
                p = relative_integer(index);
                radius = frame.units.w;
            } else {
                Placed drop = placed[index - frame.camera_place.w];
                p = relative_placed(drop);
                radius = drop.high.w;
            }
            vec3 v = view_space(p);
            float distance2;
            uint what = sighting(v, radius, distance2);
            if (what == CAMERA_INSIDE) atomicAdd(counters.camera_inside, 1u);
            if (what == BESIDE_CAMERA) atomicAdd(counters.beside_camera, 1u);
            bool visible = what == VISIBLE;
            in_view += uint(visible);

            // The outline: an ellipse about this point (see sprite.glsl).
            float radius2 = radius * radius, flat2 = v.z * v.z - radius2;
            float focal = frame.image.z;
            vec2 offset = v.xy * (-v.z / flat2) * focal;
            vec2 center = 0.5 * frame.image.xy + vec2(offset.x, -offset.y);
            float widest = 2.0 * focal * radius * sqrt(distance2 - radius2) / flat2; // major axis
            bool fits = at < MAX_RECORDS;
            bool small = visible && fits && widest <= LARGEST_PX;
            if (what == BESIDE_CAMERA || visible && fits && !small) {
                uint place = atomicAdd(counters.large_count, 1u);
                if (place < MAX_LARGE) {
                    large[place] = vec4(v, radius);
                    large_index[place] = index;
                }
            }
            if (visible && !fits) atomicAdd(counters.lost, 1u);

            Record r;
            r.center = center;
            r.distance2 = small ? distance2 : 1.0 / 0.0;
            uint texel = direction_texel(p * inversesqrt(distance2));
            vec3 n = texel_direction(texel), u, w;
            basis(n, u, w);
            float near = frame.camera_high.w, fade = frame.camera_low.w;
            float opacity = fade > 0.0 ? smoothstep(near, near + fade, sqrt(distance2)) : 1.0;
            r.look = texel | uint(opacity * 65535.0 + 0.5) << 16;
            // A pixel's offset turns the ray by that much over its length; (s, t) are the turns
            // along u and w over the drop's half-angle.
            float scale = sqrt(distance2 - radius2) / (radius * length(vec3(offset, focal)));
            r.to_disc = scale * vec4(dot(frame.right.xyz, u), dot(frame.right.xyz, w),
                                     -dot(frame.up.xyz, u), -dot(frame.up.xyz, w));
            // Loops rather than branches: CPU drivers run both sides of a branch, but leave a loop
            // that no lane is in.
            uvec4 bin = uvec4(0u);
            for (bool once = small; once; once = false) {
                records[at] = r;
                spheres[at] = vec4(v, radius);
                record_index[at] = index;
                bin = enter_tiles(r);
            }
            for (bool once = fits; once; once = false) bins[at] = bin;
        }
    }
    atomicAdd(counters.visible[gl_WorkGroupID.x & 63u], in_view);
}
