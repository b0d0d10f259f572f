#version 460
// The finest level of the height map from a host's image: texels in the map's order, what is stored as heights in scene units.
// One invocation a texel of the map. See src/passes/heights.rs.
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2D host_heights;
layout(set = 0, binding = 1, r32f) uniform writeonly image2D finest;
layout(push_constant) uniform HeightsPush {
    ivec2 first;      // the host's texel that is the map's first
    ivec2 per_column; // from a column of the map to the next so many texels of the host's
    ivec2 per_row;    // and from a row to the next
    float base;       // height of a stored 0
    float slope;      // height of a stored 1 over that
    float empty;      // what is stored where no surface is
} push;

// src/picture/heights.rs has these too: the height where nothing is, and between what heights something may be.
const float NOTHING = -1e30, MOST = 1e9;

// A compiler may take it that no float is NaN; it cannot of bits.
bool is_finite(float number) {
    return (floatBitsToUint(number) & 0x7f800000u) != 0x7f800000u;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(finest)))) return;
    float stored = texelFetch(host_heights, push.first + at.x * push.per_column + at.y * push.per_row, 0).r;
    precise float height = push.base + push.slope * stored;
    bool is_there = is_finite(stored) && stored != push.empty && abs(height) <= MOST;
    imageStore(finest, at, vec4(is_there ? height : NOTHING));
}
