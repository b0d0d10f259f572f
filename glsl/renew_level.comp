#version 460
// A level of the environment from the next finer one: the mean over the same solid angle from equator to pole. The
// same as `coarser` in src/environment/levels.rs, in float32. One invocation a texel.
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, rgba16f) uniform readonly image2D fine;
layout(set = 0, binding = 1, rgba16f) uniform writeonly image2D coarse;

const float PI = 3.14159265358979;

// The part of a cell that an interval holds.
float share_of(int cell, float start, float end) {
    return min(end, float(cell) + 1.0) - max(start, float(cell));
}

void main() {
    ivec2 of = imageSize(fine), to = imageSize(coarse);
    int number = int(gl_GlobalInvocationID.x);
    if (number >= to.x * to.y) return;
    ivec2 at = ivec2(number % to.x, number / to.x);
    vec2 scale = vec2(of) / vec2(to);
    float sine = sin(PI * (float(at.y) + 0.5) / float(to.y));
    // Columns to average: the level's own, widened by 1/sin θ, all around at most.
    float reach = min(scale.x / sine, float(of.x));
    float left = (float(at.x) + 0.5) * scale.x - 0.5 * reach, right = left + reach;
    float top = float(at.y) * scale.y, bottom = top + scale.y;
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int row = int(floor(top)); row < int(ceil(bottom)); ++row) {
        float height = share_of(row, top, bottom);
        if (height <= 1e-6) continue;
        int held = clamp(row, 0, of.y - 1);
        float weight = height * sin(PI * (float(held) + 0.5) / float(of.y));
        vec3 mean = vec3(0.0);
        for (int column = int(floor(left)); column < int(ceil(right)); ++column) {
            float share = share_of(column, left, right);
            int around = (column % of.x + of.x) % of.x;
            if (share > 0.0) mean += share * imageLoad(fine, ivec2(around, held)).rgb;
        }
        sum += weight * mean / reach;
        weights += weight;
    }
    imageStore(coarse, at, vec4(sum / weights, 1.0));
}
