#version 460
// A level of the height map from the next finer one: each texel is the largest of four. The last of a row or column that has
// no pair for it is one of more. The same as `levels` in src/rain/shelter.rs. One invocation a texel.
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32f) uniform readonly image2D fine;
layout(set = 0, binding = 1, r32f) uniform writeonly image2D coarse;

void main() {
    ivec2 of = imageSize(fine), to = imageSize(coarse), at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, to))) return;
    ivec2 end = mix(2 * at + 2, of, equal(at, to - 1));
    float largest = imageLoad(fine, 2 * at).r;
    for (int row = 2 * at.y; row < end.y; ++row) {
        for (int column = 2 * at.x; column < end.x; ++column) {
            largest = max(largest, imageLoad(fine, ivec2(column, row)).r);
        }
    }
    imageStore(coarse, at, vec4(largest));
}
