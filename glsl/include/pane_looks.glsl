#ifndef PANE_LOOKS_GLSL
#define PANE_LOOKS_GLSL
// What a drop of a pane that is out of focus looks like from the middle of the lens: at PANE_PLACES places of the wet face, and on
// the mean. A pixel's light is then a mean over the part of these places that its rays meet, on whichever place of the lens they
// begin.
#include "pane.glsl"

layout(constant_id = 2) const uint PANE_PLACES = 64; // of a drop
// How a drop is drawn; as PANE_MODEL, how those out of focus are. A wide picture has a larger table.
const uint BY_RAYS = 0, BY_PICTURE = 1, BY_COLOR = 2, BY_WIDE_PICTURE = 3;

// Disc over drop from which on its picture stands for rays, and its colour for its picture. (1 to 3 grey levels of 255.)
const float LEAST_BLUR = 0.6, MOST_BLUR = 2.0;
// Discs in pixels under which rays find all that is to be seen.
const float LEAST_DISC_PX = 1.5;

struct PaneLook {
    vec2 from, along; // an ellipse around all places where rays meet the drop: middle, from its disc's; an axis
    vec2 across;      // the other one
    vec2 middle;      // of those places, on the wet face
    vec3 color;       // their mean
    float area;
    uint kind;        // of the four
    float spacing;    // of places
    float reach;      // of its table, in radii of the disc of a pixel's rays
    uint bright;      // numbers of its bright places, the brightest in the lowest byte; 0xff: none
};
#ifndef LOOKS_ACCESS
#define LOOKS_ACCESS readonly
#endif
layout(std430, set = 0, binding = 10) LOOKS_ACCESS buffer PaneLooks { PaneLook looks[]; };
// PANE_WORDS of four halves for each drop. First its places: light; 1 where their ray meets the drop. Then the table of its picture,
// row by row, by where a pixel's rays are around the drop: sums over the places that they meet, over the number of places, without
// the light of bright ones. They make discs with edges, so each pixel adds them by itself.
layout(std430, set = 0, binding = 11) LOOKS_ACCESS buffer PanePlaces { uvec2 places[]; };
// Both for passes that do not write them.
layout(set = 0, binding = 15) uniform usamplerBuffer look_texels;
layout(set = 0, binding = 16) uniform usamplerBuffer place_texels;
// Edge of a table of a drop that is spread over up to so many pixels; that of others is PANE_TABLE.
const uint NARROW = 8u;
const float NARROW_PX = 24.0;
const uint PANE_WORDS = PANE_PLACES + PANE_TABLE * PANE_TABLE;

uint table_edge(PaneLook look) {
    return look.kind == BY_WIDE_PICTURE ? PANE_TABLE : NARROW;
}

PaneLook look_at(uint number) {
    if (BY_TEXELS == 0u) return looks[number];
    int at = int(4u * number);
    vec4 first = uintBitsToFloat(texelFetch(look_texels, at)), second = uintBitsToFloat(texelFetch(look_texels, at + 1));
    vec4 light = uintBitsToFloat(texelFetch(look_texels, at + 2));
    uvec4 rest = texelFetch(look_texels, at + 3);
    return PaneLook(first.xy, first.zw, second.xy, second.zw, light.rgb, light.w, rest.x, uintBitsToFloat(rest.y), uintBitsToFloat(rest.z), rest.w);
}

uvec2 seen_at(uint place) {
    return BY_TEXELS != 0u ? texelFetch(place_texels, int(place)).xy : places[place];
}

// A place of the ellipse, from the disc's middle: the spiral of Vogel, each for an equal area.
vec2 place_in_look(PaneLook look, uint number) {
    float angle = 2.39996323 * float(number), far = sqrt((float(number) + 0.5) / float(PANE_PLACES));
    return look.from + far * (cos(angle) * look.along + sin(angle) * look.across);
}

// By how much places at the edge of the disc of a pixel's rays are met in part, in its radii.
float soft_edge(PaneLook look, mat2 to_disc) {
    return 0.6 * sqrt(abs(determinant(to_disc))) * look.spacing;
}

// Bright places of a drop, at most; none of them; and how much brighter than its mean they are.
const uint MOST_BRIGHT = 4u, NO_BRIGHT = 0xffffffffu;
const float OUTSHINES = 4.0;

bool is_bright(PaneLook look, uint place) {
    return any(equal(uvec4(look.bright, look.bright >> 8, look.bright >> 16, look.bright >> 24) & 0xffu, uvec4(place)));
}

// The share of a place that rays meet whose disc is so far aside of the ellipse's middle, in its radii: all, or a part where the place is
// at the disc's edge.
float weight_of(PaneLook look, mat2 to_disc, vec2 aside, uint place) {
    float edge = soft_edge(look, to_disc), far = length(to_disc * (place_in_look(look, place) - look.from) - aside);
    return clamp((1.0 + edge - far) / (2.0 * edge), 0.0, 1.0);
}

// How a pixel's rays lie on the wet face, as a disc whose axes are columns, of the area of lens and pixel; the pixel's shape is seen where
// the lens is narrower.
mat2 rays_on_pane(Footprint f) {
    float of_lens = 3.14159265 * abs(determinant(f.lens)), of_pixel = abs(determinant(f.step));
    return of_lens > of_pixel ? sqrt(1.0 + of_pixel / of_lens) * f.lens : sqrt((1.0 + of_lens / of_pixel) / 3.14159265) * f.step;
}

// The ray from the middle of the lens that leaves the glass at a place, by Newton's method for the tangent of its angle.
PaneRay ray_to(vec2 place) {
    vec3 eye = pane.eye - 0.5 * pane.motion;
    vec2 apart = place - eye.xy;
    float before = -pane.thickness - eye.z, far = length(apart), tangent = far / (before + pane.thickness);
    for (uint i = 0u; i < 5u; ++i) {
        float cosine2 = 1.0 / (1.0 + tangent * tangent), sine2 = tangent * tangent * cosine2;
        float in_glass2 = pane.glass * pane.glass - sine2;
        float found = before * tangent + pane.thickness * sqrt(sine2 / in_glass2);
        float slope = before + pane.thickness * pane.glass * pane.glass * cosine2 * sqrt(cosine2 / in_glass2) / in_glass2;
        tangent = max(tangent - (found - far) / slope, 0.0);
    }
    vec2 way = far > 0.0 ? apart / far : vec2(1.0, 0.0);
    return PaneRay(eye, normalize(vec3(tangent * way, 1.0)));
}
#endif
