#ifndef RAY_COUNT_GLSL
#define RAY_COUNT_GLSL
// How many rays a pixel of a drop at rest has: one for each of the environment's texels over which light fans out along the drop's
// radius. Across it light fans out less, so that one footprint for both blurs what is seen, most towards the rim.
#include "environment.glsl"
#include "optics.glsl"
#include "tile_buffers.glsl"

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
#endif
