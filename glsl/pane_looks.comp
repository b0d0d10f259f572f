#version 460
#extension GL_GOOGLE_include_directive : require
// What drops of a pane that are out of focus look like: one invocation a place, PANE_PLACES a drop. MEAN: what is left
// of these, one invocation a drop. TABLE: their sums by where rays are, one workgroup a drop. See src/passes/pane/mod.rs.
#define LOOKS_ACCESS
#include "pane.glsl"
#include "pane_light.glsl"
#include "pane_looks.glsl"
#include "shared_halves.glsl"

layout(local_size_x = 64) in;

uint invocation() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}

// Where a direction is in the picture.
vec2 pixel_towards(vec3 d) {
    vec3 view = d.x * pane.u + d.y * pane.v + d.z * pane.normal;
    return pixel_of(frame.image.z / max(-view.z, 1e-3) * vec2(view.x, -view.y));
}

#ifdef MEAN
// The brightest places so far, brightest first, and how bright they are.
struct Brightest {
    vec4 light;
    uvec4 places;
};

void take(inout Brightest b, float light, uint place) {
    for (uint i = 0u; i < MOST_BRIGHT; ++i) {
        bool is_more = light > b.light[i];
        float other = b.light[i];
        uint its = b.places[i];
        b.light[i] = is_more ? light : other;
        b.places[i] = is_more ? place : its;
        light = is_more ? other : light;
        place = is_more ? its : place;
    }
}

void main() {
    uint number = invocation(), from = number * PANE_WORDS;
    if (number >= pane.drops) return;
    PaneLook look = looks[number];
    if (look.kind == BY_RAYS) return;
    vec3 color = vec3(0.0);
    vec2 middle = vec2(0.0);
    float met = 0.0;
    Brightest b = Brightest(vec4(0.0), uvec4(0u));
    for (uint i = 0u; i < PANE_PLACES; ++i) {
        vec4 seen = halves_of(seen_at(from + i));
        color += seen.rgb;
        middle += seen.a * place_in_look(look, i);
        met += seen.a;
        take(b, seen.r + seen.g + seen.b, i);
    }
    float share = 1.0 / max(met, 1.0), least = OUTSHINES * share * (color.r + color.g + color.b);
    uvec4 bright = mix(uvec4(0xffu), b.places, greaterThan(b.light, vec4(least)));
    PaneCap cap = cap_at(number);
    mat2 to_disc = inverse(rays_on_pane(footprint_of(pixel_towards(ray_to(cap.at).direction))));
    looks[number].color = share * color;
    looks[number].middle = cap.at + share * middle;
    looks[number].area = met * look.spacing * look.spacing;
    looks[number].reach = 1.0 + soft_edge(look, to_disc) + max(length(to_disc * look.along), length(to_disc * look.across));
    looks[number].bright = bright.x | bright.y << 8 | bright.z << 16 | bright.w << 24;
}
#elif defined(TABLE)
void main() {
    uint number = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, from = number * PANE_WORDS;
    if (number >= pane.drops) return;
    PaneLook look = look_at(number);
    uint edge = table_edge(look), entries = look.kind == BY_PICTURE || look.kind == BY_WIDE_PICTURE ? edge * edge : 0u;
    mat2 to_disc = inverse(rays_on_pane(footprint_of(pixel_towards(ray_to(cap_at(number).at).direction))));
    for (uint entry = gl_LocalInvocationID.x; entry < entries; entry += gl_WorkGroupSize.x) {
        vec2 aside = look.reach * (2.0 * vec2(entry % edge, entry / edge) / float(edge - 1u) - 1.0);
        vec4 sum = vec4(0.0);
        for (uint i = 0u; i < PANE_PLACES; ++i) {
            vec4 seen = halves_of(seen_at(from + i));
            if (is_bright(look, i)) seen.rgb = vec3(0.0);
            sum += weight_of(look, to_disc, aside, i) * seen;
        }
        places[from + PANE_PLACES + entry] = halves(sum / float(PANE_PLACES));
    }
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
    return look;
}

// By the disc that the lens makes of a point of it, over its radius.
uint kind_of(PaneCap cap, vec3 d) {
    // Nothing is known of a drop beside the camera.
    if (dot(d, vec3(pane.u.z, pane.v.z, pane.normal.z)) >= -1e-3) return BY_RAYS;
    Footprint f = footprint_of(pixel_towards(d));
    float lens2 = abs(determinant(f.lens)), step2 = abs(determinant(f.step)), lens = sqrt(lens2);
    if (lens2 < LEAST_DISC_PX * LEAST_DISC_PX * step2 || lens < LEAST_BLUR * cap.radius) return BY_RAYS;
    bool is_even = PANE_MODEL == BY_COLOR || sqrt(lens2 + step2 / PI) > MOST_BLUR * cap.radius;
    bool is_wide = 2.0 * (lens + cap.radius) > NARROW_PX * sqrt(step2);
    return is_even ? BY_COLOR : is_wide ? BY_WIDE_PICTURE : BY_PICTURE;
}

void main() {
    uint number = invocation() / PANE_PLACES, place = invocation() % PANE_PLACES;
    if (number >= pane.drops) return;
    PaneCap cap = cap_at(number);
    // In the place of what is no drop of a host's there is nothing to see, and no ray goes towards it.
    if (cap.radius == 0.0) {
        looks[number].kind = BY_RAYS;
        return;
    }
    vec3 towards = ray_to(cap.at).direction;
    PaneLook look = look_of(cap, towards);
    look.kind = kind_of(cap, towards);
    look.spacing = sqrt(PI * length(look.along) * length(look.across) / float(PANE_PLACES));
    look.color = vec3(0.0);
    look.middle = cap.at;
    look.area = look.reach = 0.0;
    look.bright = NO_BRIGHT;
    if (place == 0u) looks[number] = look;
    if (look.kind == BY_RAYS) return;
    Passed p = pass_pane(ray_to(cap.at + place_in_look(look, place)), look.spacing);
    places[number * PANE_WORDS + place] = halves(p.cap == number ? vec4(p.light, 1.0) : vec4(0.0));
}
#endif
