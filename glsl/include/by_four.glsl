// What composite.comp reads, as texels, most of four words. CPU drivers charge for each word that a lane reads from
// a storage buffer, and hardly more for the four of a texel than for one of those; but not every driver
// takes texel buffers so large. Needs tile_buffers.glsl, `sky` and
// `splat_table`.
#ifdef TEXELS
layout(set = 0, binding = 25) uniform usamplerBuffer node_texels;
layout(set = 0, binding = 26) uniform usamplerBuffer sky_texels;
layout(set = 0, binding = 27) uniform usamplerBuffer splat_texels;
uvec4 four_of_nodes(uint word) { return texelFetch(node_texels, int(word / 4u)); }
uint one_of_nodes(uint word) {
    uvec4 four = four_of_nodes(word);
    uvec2 pair = (word & 2u) == 0u ? four.xy : four.zw;
    return (word & 1u) == 0u ? pair.x : pair.y;
}
uvec4 two_of_sky(uint pixel) { return texelFetch(sky_texels, int(pixel / 2u)); }
uvec4 splat_of(uint direction, uint part) { return texelFetch(splat_texels, int(2u * direction + part)); }
#else
uvec4 four_of_nodes(uint word) {
    return uvec4(nodes[word], nodes[word + 1u], nodes[word + 2u], nodes[word + 3u]);
}
uint one_of_nodes(uint word) { return nodes[word]; }
uvec4 two_of_sky(uint pixel) { return uvec4(sky[pixel], sky[pixel + 1u]); }
uvec4 splat_of(uint direction, uint part) { return splat_table[2u * direction + part]; }
#endif
