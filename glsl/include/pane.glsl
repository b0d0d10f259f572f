#ifndef PANE_GLSL
#define PANE_GLSL
// A pane of glass before the camera and the drops on it: what the passes of src/passes/pane.rs share.
//
// Places are along the pane's u, v and normal, in scene units, from the corner of the grid of its drops, on the wet face.
#include "by_texels.glsl"
#include "frame.glsl"
#include "projection.glsl"

layout(constant_id = 1) const uint PANE_REFLECTIONS = 8; // within a drop, at most
layout(constant_id = 3) const uint PANE_MODEL = 0;       // how drops out of focus are drawn (pane_looks.glsl); 0: by rays, as all others
layout(constant_id = 4) const uint PANE_NEAREST = 0;     // 1: each pixel's nearest drop is noted

struct Pane {
    vec3 u;            // its axes in view space
    float thickness;
    vec3 v;
    float glass;       // its refractive index
    vec3 normal;
    float cell;        // edge of a cell of the grid
    vec3 eye;          // the middle of the lens, as the shutter opens
    float tallest;     // height of the highest drop
    vec3 motion;       // of the pane, as the camera sees it, while the shutter is open
    float overhang;    // least cosine of a contact angle; rays of a larger sine may meet a drop from outside
    vec3 inside;       // radiance on the camera's side, stored units
    float plate;       // stored unit of light a unit of the plate; 0: there is none
    vec3 water;        // refractive index for red, green, blue
    uint indices;      // 3 where these differ, else 1
    uvec2 cells;       // across and down
    uvec2 first_tile;  // of what is drawn
    uint tiles_across;
    uint tiles;
    uint drops;
    uint rays;         // of a pixel that drops touch
};

// A drop: a cap of a sphere.
struct PaneCap {
    vec2 at;      // middle of its contact disc
    float radius; // of the disc
    float reach;  // of the circle that it covers seen square on
    float height;
    float sphere; // radius
    float center; // height of the sphere's centre
    uint number;
};

#ifndef PANE_ACCESS
#define PANE_ACCESS readonly
#endif
layout(std140, set = 0, binding = 3) uniform PaneConstants { Pane pane_constants; };
layout(std430, set = 0, binding = 4) PANE_ACCESS buffer PaneCaps { PaneCap caps[]; };
// For each cell, row by row, where its drops begin, and where the last one's end; then the drops' numbers, rising in each.
layout(std430, set = 0, binding = 5) PANE_ACCESS buffer PaneCells { uint cells[]; };
// Both for passes that do not write them.
layout(set = 0, binding = 13) uniform usamplerBuffer cap_texels;
layout(set = 0, binding = 14) uniform usamplerBuffer cell_words;

PaneCap cap_at(uint number) {
    if (BY_TEXELS == 0u) return caps[number];
    int at = int(2u * number);
    uvec4 rest = texelFetch(cap_texels, at + 1);
    vec4 first = uintBitsToFloat(texelFetch(cap_texels, at)), sizes = uintBitsToFloat(rest);
    return PaneCap(first.xy, first.z, first.w, sizes.x, sizes.y, sizes.z, rest.w);
}

uint cell_word(uint at) {
    return BY_TEXELS != 0u ? texelFetch(cell_words, int(at)).x : cells[at];
}

// A copy that is read once, as `frame` is.
Pane pane = pane_constants;

const uint NO_CAP = 0xffffffffu;

// Reflectance by the cosines on both sides, the index of the far one over that of the near one. Unpolarised.
float pane_fresnel(float near, float far, float index) {
    float s = (near - index * far) / max(near + index * far, 1e-20);
    float p = (index * near - far) / max(index * near + far, 1e-20);
    return 0.5 * (s * s + p * p);
}

// Cosine in a denser substance of a ray in air.
float cosine_in(float cosine, float index) {
    return sqrt(1.0 - (1.0 - cosine * cosine) / (index * index));
}

// (1-F)/(1+F) of the dry pane, for a ray in air: all orders of reflection within it.
float dry_pane(float cosine) {
    float f = pane_fresnel(cosine, cosine_in(cosine, pane.glass), pane.glass);
    return (1.0 - f) / (1.0 + f);
}

struct PaneRay {
    vec3 origin, direction;
};

// From a place on the lens, in its radii, through a place of the picture; `moment`: share of the exposure.
PaneRay pane_ray(vec2 pixel, vec2 on_lens, float moment) {
    vec2 place = frame.lens.x * on_lens;
    vec3 d = normalize(ray_through(pixel) / frame.image.z - vec3(place * frame.lens.y, 0.0));
    PaneRay ray;
    ray.direction = vec3(dot(pane.u, d), dot(pane.v, d), dot(pane.normal, d));
    ray.origin = pane.eye - moment * pane.motion + place.x * vec3(pane.u.x, pane.v.x, pane.normal.x)
        + place.y * vec3(pane.u.y, pane.v.y, pane.normal.y);
    return ray;
}

// Where a ray that points outside leaves the glass, were there no water.
vec2 wet_place(PaneRay ray) {
    vec2 along = ray.direction.xy;
    float cosine = ray.direction.z, to_dry = (-pane.thickness - ray.origin.z) / cosine;
    vec2 through = along / (pane.glass * cosine_in(cosine, pane.glass));
    return ray.origin.xy + to_dry * along + pane.thickness * through;
}

// Where the ray from the middle of the lens through a place of the picture leaves the glass, halfway through the exposure, and how far
// away others do: from the lens's edge to the right and below, and through the next pixel there. `cosine` is that of the ray to the normal,
// times its length where it is as long as 1 along the view axis; under 0 it meets no pane, and the rest means nothing.
struct Footprint {
    vec2 place, slope;
    float cosine;
    mat2 lens, step;
};

Footprint footprint_of(vec2 pixel) {
    vec3 d = ray_through(pixel) / frame.image.z, eye = pane.eye - 0.5 * pane.motion;
    Footprint f;
    f.cosine = dot(pane.normal, d);
    float share = 1.0 / max(f.cosine, 1e-6), before = -pane.thickness - eye.z, more = pane.glass * pane.glass - 1.0;
    f.slope = share * vec2(dot(pane.u, d), dot(pane.v, d));
    float in_glass = inversesqrt(pane.glass * pane.glass + more * dot(f.slope, f.slope));
    f.place = eye.xy + (before + pane.thickness * in_glass) * f.slope;
    // How the place changes with the slope; right and down as far as the lens is moved, or the ray at a distance of 1 is.
    vec2 bent = pane.thickness * more * in_glass * in_glass * in_glass * f.slope;
    mat2 by_slope = (before + pane.thickness * in_glass) * mat2(1.0) - outerProduct(bent, f.slope);
    mat2 aside = mat2(vec2(pane.u.x, pane.v.x) - pane.normal.x * f.slope, pane.normal.y * f.slope - vec2(pane.u.y, pane.v.y));
    mat2 turned = share * by_slope * aside;
    f.step = turned / frame.image.z;
    f.lens = frame.lens.x * (aside - frame.lens.y * turned);
    return f;
}

// The largest radius of the ellipse that a matrix makes of the unit disc.
float longest_axis(mat2 m) {
    float all = dot(m[0], m[0]) + dot(m[1], m[1]), area = determinant(m);
    return sqrt(0.5 * (all + sqrt(max(all * all - 4.0 * area * area, 0.0))));
}

bool is_over_grid(vec2 place) {
    return all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, pane.cell * vec2(pane.cells)));
}

// The cell of a place; one beside the grid is in the nearest.
uvec2 cell_of(vec2 place) {
    return uvec2(clamp(place / pane.cell, vec2(0.0), vec2(pane.cells) - 1.0));
}

// Where the numbers of a cell's drops stand: first, and beyond the last.
uvec2 caps_of(uvec2 cell) {
    uint at = cell.y * pane.cells.x + cell.x;
    return uvec2(cell_word(at), cell_word(at + 1u));
}
#endif
