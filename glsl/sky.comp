#version 460
#extension GL_GOOGLE_include_directive : require
// What is behind the drops of tiles, MEDIUM: through far rain; one invocation a pixel. The environment, or BEFORE: a
// picture, and how far it is at each pixel. SHELTER: surfaces keep a part of the medium off. See src/passes/background.rs.
#ifdef MEDIUM_BEFORE
#define MEDIUM
#define BEFORE
#endif
#ifdef MEDIUM_SHELTER
#define MEDIUM
#define SHELTER
#endif
#ifdef MEDIUM_BEFORE_SHELTER
#define MEDIUM
#define BEFORE
#define SHELTER
#endif
#include "frame.glsl"
#include "projection.glsl"
#include "environment.glsl"
#include "fine_radiance.glsl"
#ifdef BEFORE
#define BEHIND_ACCESS writeonly
#endif
#include "tile_buffers.glsl"
#include "lens.glsl"
#include "rounded.glsl"

#ifdef MEDIUM
#include "octahedron.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"
#include "splat_table.glsl"
#include "medium.glsl"
#ifdef SHELTER
#include "sheltered_medium.glsl"
#endif
#endif

layout(local_size_x = 16, local_size_y = 4) in;
#ifdef MEDIUM
layout(constant_id = 23) const uint GRAIN = 0; // 1: the medium has the noise of its single drops
#endif

#include "maps.glsl"
layout(std430, set = 1, binding = 1) writeonly buffer Sky { uvec2 sky[]; };

#ifdef BEFORE
layout(constant_id = 20) const uint LAYERS = 0; // 1: nothing is behind; what the medium hides of it stands in the fourth half
layout(constant_id = 31) const uint HAS_COLOR = 0; // 1: there is a picture; 0: the environment is behind, at the distance of the depth
// Both images show the whole picture, a texel a pixel.
layout(set = 1, binding = 18) uniform sampler2D color_image;
layout(set = 1, binding = 19) uniform sampler2D depth_image;
// `Convention` in src/passes/background.rs.
layout(push_constant) uniform BackgroundPush {
    vec4 depth;        // a, b, c, d: a stored s is at (a s + b) / (c s + d) scene units; where c s + d is not over 0, nothing is
    float color_scale; // stored unit of light a unit of the image
    uint depth_kind;   // 1: along the view axis, 2: along the ray
} push;
// Farther than all; its square is a float.
const float FARTHEST = 1e18;

float distance_at(ivec2 pixel, vec3 ray) {
    if (HAS_DEPTH == 0u) return FARTHEST;
    float stored = texelFetch(depth_image, min(pixel, textureSize(depth_image, 0) - 1), 0).r;
    float below = push.depth.z * stored + push.depth.w;
    float depth = below > 0.0 ? (push.depth.x * stored + push.depth.y) / below : FARTHEST;
    float far = push.depth_kind == 1u ? depth * length(ray) / -ray.z : depth;
    // A host may store NaN, which is as far as the sky; squares of distances are compared.
    return far < FARTHEST ? max(far, 0.0) : FARTHEST;
}
#endif

// Samples along an edge of a pixel: a third of a texel apart, so that their mean is that of the pixel's square and
// not of a blurred neighbourhood; four at most, between which the levels do the rest. Powers of two, so that
// equal radiances keep their last bit. src/plan/background.rs tells the error of the same.
uint samples_along(float focal) {
    float thirds = 3.0 / (focal * frame.environment.x);
    return thirds <= 1.0 ? 1u : thirds <= 2.0 ? 2u : 4u;
}

// Places on a lens's disc that the sky is the mean of, each for its share of it: usually, and beside something much brighter.
const uint LENS_PLACES = 64, LENS_PLACES_BRIGHT = 512;
// Parts along an edge of such a pixel.
const uint BRIGHT_EDGE = 4;
// How much brighter what is around is then.
const float MUCH_BRIGHTER = 1.5;

// The mean of the environment over a pixel: over so many places on the lens, or, if it is sharp, so many parts along an edge.
vec3 mean_of_sky(uvec2 pixel, mat3 world, uint edge, float blur, uint on_lens) {
    float focal = frame.image.z, share = 1.0 / float(edge);
    uint places = blur > 0.0 ? on_lens : edge * edge;
    float spread = blur > 0.0 ? sqrt((1.0 + PI * blur * blur) / float(on_lens)) : share;
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < places; ++i) {
        vec2 at = share * (vec2(i % edge, i / edge) + 0.5);
        if (HAS_LENS != 0u && blur > 0.0) {
            at = fract(vec2(0.75487767, 0.56984029) * float(i)) + blur * place_on_unit_disc(i, places, 0.0);
        }
        vec3 ray = ray_through(vec2(pixel) + at);
        float far = length(ray);
        sum += radiance(whole_map, world * ray / far, spread * sqrt(focal / far) / far);
    }
    return sum / float(places);
}

// The exact mean over a sharp pixel that is under two texels wide.
vec3 exact_mean_of_sky(uvec2 pixel, mat3 world) {
    const float SHARE = 1.0 / float(BRIGHT_EDGE);
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < BRIGHT_EDGE * BRIGHT_EDGE; ++i) {
        vec2 at = SHARE * (vec2(i % BRIGHT_EDGE, i / BRIGHT_EDGE) + 0.5);
        sum += radiance_around(whole_map, world * ray_through(vec2(pixel) + at), SHARE * mat2x3(world[0], world[1]));
    }
    return SHARE * SHARE * sum;
}

// The light of the environment behind a pixel; `pixel`: of the whole picture.
vec3 light_of_sky(uvec2 pixel, mat3 world) {
    float focal = frame.image.z, blur = is_lens() && frame.lens.w >= LEAST_BLUR_PX ? frame.lens.w : 0.0;
    uint edge = samples_along(focal);
    vec3 light = mean_of_sky(pixel, world, edge, blur, LENS_PLACES);
    // Where a pixel has one ray: a look around takes as long as all else.
    if (SAMPLES == 1u) return light;
    // What is around, as far as three texels or twice the lens's disc.
    vec3 middle = ray_through(vec2(pixel) + 0.5);
    float far = length(middle), around = max(3.0 * frame.environment.x, 2.0 * blur / focal);
    bool is_outshone = any(greaterThan(radiance(whole_map, world * middle / far, around), MUCH_BRIGHTER * light));
    if (is_outshone && blur > 0.0) return mean_of_sky(pixel, world, edge, blur, LENS_PLACES_BRIGHT);
    return is_outshone && 1.0 < 2.0 * focal * frame.environment.x ? exact_mean_of_sky(pixel, world) : light;
}

// The light behind a pixel.
vec3 light_behind(uvec2 pixel, mat3 world) {
#ifdef BEFORE
    if (LAYERS != 0u) return vec3(0.0);
    // A picture is sharp, whatever the lens.
    if (HAS_COLOR != 0u) {
        return push.color_scale * texelFetch(color_image, min(ivec2(pixel), textureSize(color_image, 0) - 1), 0).rgb;
    }
#endif
    return light_of_sky(pixel, world);
}

void main() {
    uvec2 place = gl_GlobalInvocationID.xy, in_tile = place % TILE, pixel = place + first_tile() * TILE;
    uint tile = place.y / TILE.y * tiles_across() + place.x / TILE.x;
    if (place.x >= tiles_across() * TILE.x || tile >= TILE_COUNT) return;
    uint at = tile * PIXELS + in_tile.y * TILE.x + in_tile.x;
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    float hidden = 0.0;
#ifdef BEFORE
    float farthest = distance_at(ivec2(pixel), ray_through(vec2(pixel) + 0.5));
    // Without a depth there is no buffer of distances, and the binding is another.
    if (HAS_DEPTH != 0u) distance_behind[at] = farthest;
#elif defined(MEDIUM)
    float farthest = field.medium.z;
#endif
    vec3 c = light_behind(pixel, world);
#ifdef MEDIUM
    // The medium hardly changes over a pixel.
    if (field.medium.w > 0.0) {
        vec3 middle = normalize(ray_through(vec2(pixel) + 0.5));
        float grain = 1.0;
        vec2 depth = medium_depth(middle, farthest);
#ifdef SHELTER
        depth.y = max(depth.y - sheltered_depth(middle, world * middle, farthest), 0.0);
#endif
        if (GRAIN != 0u) grain = medium_grain(middle, world * middle, depth);
        float passes = medium_passes(depth.y, grain);
        c = passes * c + (1.0 - passes) * far_light(world * middle, false);
#ifdef BEFORE
        hidden = 1.0 - passes;
#endif
    }
#endif
#ifdef BEFORE
    // A picture's colours may be more than a half holds, and a host's no light at all: negative, or NaN.
    c = mix(vec3(0.0), min(c, 65504.0), greaterThan(c, vec3(0.0)));
#endif
    uvec4 halves = half_bits(vec4(c, hidden));
    sky[at] = uvec2(halves.x | halves.y << 16, halves.z | halves.w << 16);
}
