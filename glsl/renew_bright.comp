#version 460
#extension GL_GOOGLE_include_directive : require
// The small bright parts of an environment, found on the GPU and taken out of what drops see of it as a texture:
// src/environment/bright.rs, but that a part is what is too bright within a cap, not what touches. In steps, with a barrier
// between; each sum is first of strides or lanes, and whoever needs it adds those up: no shared memory, no atomics, so the
// same bits on every run. See src/passes/renewal.rs.
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, rgba16f) uniform image2D rest;
struct Source {
    vec4 toward; // w: angular radius
    vec4 light;  // radiance times solid angle
};
layout(std430, set = 0, binding = 1) buffer Sources {
    uvec4 source_count;
    Source sources[];
};

#include "constants.glsl"

// What the lanes have of the part that is looked at, beyond a bound.
struct Part {
    vec4 light;  // excess times solid angle; w: of its luminance
    vec4 offset; // luminance times direction, from the brightest; w: times its square
    float square; // luminance squared, times solid angle
    float farthest; // from the brightest
};
struct Found {
    vec4 toward; // w: the bound, what a texel has beyond it is the source's; 0 if it is none
};
layout(std430, set = 0, binding = 2) buffer Work {
    float means[2][STRIDES]; // of one round and the next
    vec2 brightest[STRIDES]; // luminance over the threshold, and which texel
    Part parts[STRIDES]; // of each bound its lanes
    Found found[MOST_SOURCES];
};

layout(push_constant) uniform Push { uint step_number, round_number; };

const float PI = 3.14159265358979;
const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
const float THRESHOLD = 30.0;  // means above which a texel is too bright
const float LARGEST = 0.035;   // angular radius of the disc that stands for a part, at most
const float WORTHWHILE = 1.0;  // mean square of an excess over that of the mean, from which it is taken out
const uint BOUNDS = 16u;       // that are tried, each twice the one before
const uint LANES = STRIDES / BOUNDS;

vec3 direction_of(uint texel, uvec2 size) {
    vec2 uv = (vec2(texel % size.x, texel / size.x) + 0.5) / vec2(size);
    float azimuth = 2.0 * PI * (uv.x - 0.5), polar = PI * uv.y;
    return vec3(sin(polar) * sin(azimuth), cos(polar), -sin(polar) * cos(azimuth));
}

float solid_angle_of(uint texel, uvec2 size) {
    float high = PI / float(size.y);
    return 2.0 * PI / float(size.x) * high * sin((float(texel / size.x) + 0.5) * high);
}

vec3 texel_at(uint texel, uvec2 size) {
    return imageLoad(rest, ivec2(texel % size.x, texel / size.x)).rgb;
}

// What is too bright, from the sums that a round of means left.
float threshold(uint which) {
    float sum = 0.0;
    for (uint i = 0u; i < STRIDES; ++i) sum += means[which][i];
    return THRESHOLD * sum / (4.0 * PI);
}

// Within the cap of a part: so wide that it is seen to be no disc where it goes on.
bool is_in(vec3 d, vec3 toward, float texel) {
    return distance(d, toward) < 2.0 * (LARGEST + texel);
}

// A round of the mean of the rest.
void sum_rest(uint stride, uvec2 size) {
    uint texels = size.x * size.y;
    float most = round_number == 0u ? 3e38 : threshold((round_number + 1u) % 2u), sum = 0.0;
    for (uint i = stride; i < texels; i += STRIDES) {
        sum += solid_angle_of(i, size) * dot(min(texel_at(i, size), most), LUMINANCE);
    }
    means[round_number % 2u][stride] = sum;
}

// The brightest texel in no part that was found.
void find_brightest(uint stride, uvec2 size, float most) {
    uint texels = size.x * size.y;
    float texel = PI / float(size.y);
    vec2 best = vec2(0.0);
    for (uint i = stride; i < texels; i += STRIDES) {
        vec3 c = texel_at(i, size);
        float over = dot(c - min(c, most), LUMINANCE);
        if (over <= best.x) continue;
        vec3 d = direction_of(i, size);
        bool is_new = true;
        for (uint k = 0u; k < round_number; ++k) is_new = is_new && !is_in(d, found[k].toward.xyz, texel);
        if (is_new) best = vec2(over, uintBitsToFloat(i));
    }
    brightest[stride] = best;
}

// What is around it, beyond each bound.
void sum_part(uint stride, uvec2 size, float most) {
    float texel = PI / float(size.y);
    vec2 best = brightest[0];
    for (uint i = 1u; i < STRIDES; ++i) if (brightest[i].x > best.x) best = brightest[i];
    vec3 toward = direction_of(floatBitsToUint(best.y), size);
    if (stride == 0u) found[round_number].toward = vec4(best.x > 0.0 ? toward : vec3(0.0), 0.0);
    float bound = exp2(float(stride / LANES)) * most;
    int row = int(floatBitsToUint(best.y) / size.x), rows = int(2.0 * LARGEST / texel) + 4; // of the cap, on either side
    uint end = best.x > 0.0 ? uint(min(row + rows, int(size.y))) * size.x : 0u;
    Part part = Part(vec4(0.0), vec4(0.0), 0.0, 0.0);
    for (uint i = uint(max(row - rows, 0)) * size.x + stride % LANES; i < end; i += LANES) {
        vec3 c = texel_at(i, size), excess = c - min(c, bound);
        if (excess == vec3(0.0)) continue;
        vec3 d = direction_of(i, size);
        bool is_new = is_in(d, toward, texel);
        for (uint k = 0u; k < round_number; ++k) is_new = is_new && !is_in(d, found[k].toward.xyz, texel);
        if (!is_new) continue;
        float angle = solid_angle_of(i, size), luminance = dot(excess, LUMINANCE);
        part.light += angle * vec4(excess, luminance);
        part.offset += angle * luminance * vec4(d - toward, dot(d - toward, d - toward));
        part.square += angle * luminance * luminance;
        part.farthest = max(part.farthest, distance(d, toward));
    }
    parts[stride] = part;
}

// Beyond which bound it is a source.
void choose_bound(uint stride, uvec2 size, float most) {
    float texel = PI / float(size.y);
    if (stride != 0u) return;
    if (round_number == 0u) source_count = uvec4(0u);
    vec3 toward = found[round_number].toward.xyz;
    float mean = most / THRESHOLD;
    for (uint k = 0u; k < BOUNDS; ++k) {
        Part all = Part(vec4(0.0), vec4(0.0), 0.0, 0.0);
        for (uint i = k * LANES; i < (k + 1u) * LANES; ++i) {
            all.light += parts[i].light;
            all.offset += parts[i].offset;
            all.square += parts[i].square;
            all.farthest = max(all.farthest, parts[i].farthest);
        }
        // Beyond a higher bound it would be the less worth while.
        if (all.light.w <= 0.0 || all.square < WORTHWHILE * 4.0 * PI * mean * mean) return;
        vec3 to_middle = all.offset.xyz / all.light.w;
        // A texel's own light is spread as interpolation does it, by a sixth of its square along each axis.
        float mean_square = max(all.offset.w / all.light.w - dot(to_middle, to_middle), 0.0) + texel * texel / 3.0;
        float radius = sqrt(2.0 * mean_square);
        // A sun in its halo goes on beyond the disc; the brightest texel may lie at the disc's edge.
        if (radius > LARGEST || all.farthest > 2.0 * radius + texel) continue;
        found[round_number].toward.w = exp2(float(k)) * most;
        sources[source_count.x] = Source(vec4(normalize(toward + to_middle), radius), vec4(all.light.rgb, 0.0));
        source_count.x += 1u;
        return;
    }
}

// Takes the sources out. The place beyond the strides is not of them.
void take_out(uint stride, uvec2 size, float most) {
    uint texels = size.x * size.y;
    float texel = PI / float(size.y);
    uint i = stride;
    if (i >= texels) return;
    vec3 c = texel_at(i, size);
    if (all(lessThanEqual(c, vec3(most)))) return;
    vec3 d = direction_of(i, size);
    for (uint k = 0u; k < MOST_SOURCES; ++k) {
        float bound = found[k].toward.w;
        if (bound != 0.0 && is_in(d, found[k].toward.xyz, texel)) {
            imageStore(rest, ivec2(i % size.x, i / size.x), vec4(min(c, bound), 1.0));
            return;
        }
    }
}

void main() {
    uvec2 size = uvec2(imageSize(rest));
    uint stride = gl_GlobalInvocationID.x;
    if (step_number == 0u) {
        sum_rest(stride, size);
        return;
    }
    float most = threshold(1u); // the last round's number is odd
    switch (step_number) {
    case 1u: find_brightest(stride, size, most); break;
    case 2u: sum_part(stride, size, most); break;
    case 3u: choose_bound(stride, size, most); break;
    default: take_out(stride, size, most);
    }
}
