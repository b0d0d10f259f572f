#version 460
#extension GL_GOOGLE_include_directive : require
// What drops of a pane that are out of focus look like: one invocation a place, PANE_PLACES a drop. MEAN: what is left of these,
// one invocation a drop. See src/passes/pane/mod.rs.
#define LOOKS_ACCESS
#include "pane.glsl"
#include "pane_light.glsl"
#include "pane_looks.glsl"
#include "shared_halves.glsl"

layout(local_size_x = 64) in;

uint invocation() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}

#ifdef MEAN
void main() {
    uint number = invocation();
    if (number >= pane.drops) return;
    PaneLook look = looks[number];
    vec3 color = vec3(0.0);
    vec2 middle = vec2(0.0);
    float met = 0.0;
    uint turns = look.kind == BY_RAYS ? 0u : PANE_PLACES;
    for (uint i = 0u; i < turns; ++i) {
        vec4 seen = halves_of(places[number * PANE_PLACES + i]);
        color += seen.rgb;
        middle += seen.a * place_in_look(look, i);
        met += seen.a;
    }
    float share = 1.0 / max(met, 1.0);
    looks[number].color = share * color;
    looks[number].middle = cap_at(number).at + share * middle;
    looks[number].area = met * look.spacing * look.spacing;
}
#else
// Where rays along a direction meet a drop: its disc and, where they meet it from outside, the shadow of its sphere.
PaneLook look_of(PaneCap cap, vec3 d) {
    PaneLook look;
    float sine = length(d.xy), low = -cap.radius, high = cap.radius, across = cap.radius;
    vec2 way = sine > 1e-6 ? d.xy / sine : vec2(1.0, 0.0);
    if (sine > -cap.center / cap.sphere) {
        float shift = -cap.center * sine / d.z, wide = cap.sphere / d.z;
        low = min(low, shift - wide);
        high = max(high, cap.center > 0.0 ? shift + wide : high);
        across = 1.1 * cap.reach;
        float middle = 0.5 * (low + high), half_way = 0.55 * (high - low);
        low = middle - half_way;
        high = middle + half_way;
    }
    look.from = 0.5 * (low + high) * way;
    look.along = 0.5 * (high - low) * way;
    look.across = across * vec2(-way.y, way.x);
    look.spacing = sqrt(PI * 0.5 * (high - low) * across / float(PANE_PLACES));
    return look;
}

// By the disc that the lens makes of a point of it, over its radius.
uint kind_of(PaneCap cap, vec3 d) {
    vec3 view = d.x * pane.u + d.y * pane.v + d.z * pane.normal;
    if (view.z >= -1e-3 || frame.lens.x <= 0.0) return BY_RAYS;
    vec2 pixel = pixel_of(frame.image.z / -view.z * vec2(view.x, -view.y));
    float lens = sqrt(abs(determinant(lens_on_pane(pixel)))), step = sqrt(abs(determinant(pixel_on_pane(pixel))));
    if (lens < LEAST_DISC_PX * step || lens < LEAST_BLUR * cap.radius) return BY_RAYS;
    return PANE_MODEL == BY_COLOR || lens > MOST_BLUR * cap.radius ? BY_COLOR : BY_PICTURE;
}

void main() {
    uint number = invocation() / PANE_PLACES, place = invocation() % PANE_PLACES;
    if (number >= pane.drops) return;
    PaneCap cap = cap_at(number);
    vec3 towards = ray_to(cap.at).direction;
    PaneLook look = look_of(cap, towards);
    look.kind = kind_of(cap, towards);
    look.color = vec3(0.0);
    look.middle = cap.at;
    look.area = 0.0;
    if (place == 0u) looks[number] = look;
    if (look.kind == BY_RAYS) return;
    Passed p = pass_pane(ray_to(cap.at + place_in_look(look, place)), look.spacing);
    places[number * PANE_PLACES + place] = halves(p.cap == number ? vec4(p.light, 1.0) : vec4(0.0));
}
#endif
