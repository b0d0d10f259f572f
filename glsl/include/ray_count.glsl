#ifndef RAY_COUNT_GLSL
#define RAY_COUNT_GLSL
// How many rays a pixel of a drop at rest has: one for each of the environment's texels over which light fans out along the drop's
// radius. Across it light fans out less, so that one footprint for both blurs what is seen, most towards the rim.
#include "environment.glsl"
#include "optics.glsl"
#include "tile_buffers.glsl"

// Whether `exact` draws so few drops that a pixel may have UNSURE_RAYS.
const bool ARE_FEW = UNSURE_RAYS > MOST_RAYS;
// How many times as many rays at least a pixel has of a drop that moves or is out of focus, where drops are few: by `exact`, and by `fast`.
// Where none of the first meets what is bright no more follow, and black dots stand in a bright disc.
const uint SURER = ARE_FEW ? 4u : SAMPLES == 1u && MOST_RAYS > 1u ? 2u : 1u;

// A pixel has MOST_RAYS where light fans out over so many texels.
const float MOST_TEXELS = 32.0;
// Radius in pixels under which drops have half of them: each is a pixel or two, so that chance is seen as flicker.
const float LEAST_PX = 1.5;
// Radius in pixels over which a pixel has fewer than MOST_RAYS: the rim, where light fans out most, is more pixels wide.
const float MANY_PX = 16.0;

// `b`: impact parameter at the pixel's middle; `pixels`: the drop's radius; `tells_cover`: rays find what it covers, too.
uint rays_at(float b, float pixels, bool tells_cover) {
    if (MOST_RAYS == SAMPLES) return SAMPLES;
    if (pixels < LEAST_PX) return max(SAMPLES, MOST_RAYS / 2u);
    float farthest = min(b + 0.5 / pixels, 0.9999), inside = min(farthest / WATER, 0.99);
    float fan = 2.0 * inversesqrt(1.0 - farthest * farthest) - 2.0 / WATER * inversesqrt(1.0 - inside * inside);
    float texels = abs(fan) / (pixels * frame.environment.x);
    float part = tells_cover ? 1.0 : min(1.0, MANY_PX * MANY_PX / (pixels * pixels));
    uint most = max(SAMPLES, uint(float(MOST_RAYS) * part));
    return clamp(uint(texels * (float(MOST_RAYS) / MOST_TEXELS)), SAMPLES, most);
}

float luminance(vec3 light) {
    return dot(light, vec3(0.2126, 0.7152, 0.0722));
}

// The light that a pixel's rays find of a drop at rest.
struct RestingRays {
    vec3 sum;
    float weights, squares; // of rays; of their luminance
};

void add(inout RestingRays r, vec3 light, float weight) {
    float bright = luminance(light);
    r.sum += weight * light;
    r.weights += weight;
    r.squares += weight * bright * bright;
}

// By how much a pixel's light may be off by chance, of its own, as independent rays would have it: these are spread evenly, and off by a
// third of that. A lamp in a drop of a few pixels is a small part of one, so that the next ray of 16 beside it may be the first to miss it.
const float KNOWN = 0.1;

// How many rays would tell a pixel's light so well, by those that it has.
uint rays_for(RestingRays r) {
    float mean = luminance(r.sum) / r.weights, variance = r.squares / r.weights - mean * mean;
    return uint(clamp(variance / (KNOWN * KNOWN * mean * mean + 1e-30), 0.0, 1e6));
}
#endif
