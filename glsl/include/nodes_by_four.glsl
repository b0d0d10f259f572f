#ifndef NODES_BY_FOUR_GLSL
#define NODES_BY_FOUR_GLSL
// The tiles' lists, four words at a time.
#include "tile_buffers.glsl"

layout(set = 1, binding = 11) uniform usamplerBuffer node_texels;
layout(set = 1, binding = 12) uniform usamplerBuffer head_texels;

uvec4 four_of_nodes(uint word) {
    if (BY_TEXELS != 0u) return texelFetch(node_texels, int(word / 4u));
    return nodes_by_four[word / 4u];
}

// Four tiles' links.
uvec4 four_of_heads(uint tile) {
    if (BY_TEXELS != 0u) return texelFetch(head_texels, int(tile / 4u));
    return uvec4(heads[tile], heads[tile + 1u], heads[tile + 2u], heads[tile + 3u]);
}

uint one_of_four(uvec4 four, uint word) {
    uvec2 pair = (word & 2u) == 0u ? four.xy : four.zw;
    return (word & 1u) == 0u ? pair.x : pair.y;
}

uint one_of_nodes(uint word) {
    return BY_TEXELS != 0u ? one_of_four(four_of_nodes(word), word) : nodes[word];
}

uint head_of(uint tile) {
    return BY_TEXELS != 0u ? one_of_four(four_of_heads(tile), tile) : heads[tile];
}
#endif
