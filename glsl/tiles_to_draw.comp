#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
// Which tiles a frame draws, by how much there is to do in them (drawn_tiles.glsl): a CPU's vector of tiles takes as long
// as its longest list, and runs all code that one of them may need. An invocation takes several tiles, so that few add to
// the counters, for which threads of a CPU would wait.
#include "frame.glsl"
#include "tile_buffers.glsl"
#include "drawn_tiles.glsl"
#include "nodes_by_four.glsl"
#include "together.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Push { uint new_sky; } push; // 1: no tile shows it yet

// A bit a tile, list by list.
uvec4 lists_of(uint first, uint tiles) {
    uint filled = 0u;
    for (uint i = 0u; i < tiles; i += 4u) {
        uvec4 bits = uvec4(notEqual(four_of_heads(first + i), uvec4(END))) << uvec4(0, 1, 2, 3);
        filled |= (bits.x | bits.y | bits.z | bits.w) << i;
    }
    uint all = tiles == 0u ? 0u : 0xffffffffu >> (LISTED_TILES - tiles);
    filled &= all;
    uvec4 lists = uvec4(0u, 0u, 0u, filled ^ all);
    for (uint left = filled; left != 0u; left &= left - 1u) {
        uint link = head_of(first + findLSB(left));
        bool one = one_of_nodes(link) == END, block = is_block(link);
        lists.xyz |= uvec3(!one, one && !block, one && block) * (left & -left);
    }
    return lists;
}

void main() {
    uint word = gl_GlobalInvocationID.x, first = word * LISTED_TILES;
    uint tiles = min(max(TILE_COUNT, first) - first, LISTED_TILES);
    uvec4 lists = lists_of(first, tiles);
    if (tiles > 0u) {
        uint had = had_drops(word), drawn = ~lists[SKY_ALONE];
        if (push.new_sky == 0u) lists[SKY_ALONE] &= drawn_tiles[had];
        drawn_tiles[had] = drawn;
    }

    uvec4 mine = uvec4(bitCount(lists)), count = subgroupAdd(mine), before = subgroupExclusiveAdd(mine), at = uvec4(0u);
    bool leads = subgroupElect();
    TAKE_TOGETHER(totals.listed[0], count.x, leads, at.x);
    TAKE_TOGETHER(totals.listed[1], count.y, leads, at.y);
    TAKE_TOGETHER(totals.listed[2], count.z, leads, at.z);
    TAKE_TOGETHER(totals.listed[3], count.w, leads, at.w);
    if (count == uvec4(0u)) return;
    if (leads) {
        for (uint list = 0u; list < LISTS; ++list) {
            // A workgroup takes 64 tiles: the invocation with its first one asks for it.
            uint groups = (at[list] + count[list] + 63u) / 64u - (at[list] + 63u) / 64u;
            atomicAdd(totals.listed_groups[list].x, groups);
        }
    }
    at += before;
    for (uint list = 0u; list < LISTS; ++list) {
        for (uint left = lists[list]; left != 0u; left &= left - 1u) {
            drawn_tiles[listed_at(list, at[list]++)] = first + findLSB(left);
        }
    }
}
