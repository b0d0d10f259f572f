#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Adds the images of the bright sources to the pixels of the large drops' tile fragments, after their colours are
// there; one workgroup 64 drops. SHARED: of the drops that the others leave, as they take long; a workgroup one drop.
// See src/passes/glints.rs.
//
// llvmpipe ends the loops of a vector of invocations after some 65,000 turns together. So no order of the drops may decide
// how many turns an invocation has: what a drop takes is bounded here, and where it is over a bound, that is counted.
#include "left_lanes.glsl"
#include "frame.glsl"
#include "projection.glsl"
#include "light_model.glsl"
#include "optics.glsl"
#include "tile_buffers.glsl"
#include "shared_exponent.glsl"
#include "appearance.glsl"
#include "behind.glsl"

#include "glint_light.glsl"

layout(local_size_x_id = 26) in;
const uint DROPS = 64 / GLINT_LANES; // that an invocation takes, of 64 together

// The drops that are left to SHARED, where composite.comp lists tiles later.
layout(std430, set = 1, binding = 3) buffer Disordered { uint shared_drops[]; };
#include "by_four.glsl"
#include "glints.glsl"
#include "far_glints.glsl"
#include "lens.glsl"
#include "glint_parts.glsl"
#include "glint_spot.glsl"
#include "glint_turns.glsl"
#include "shape.glsl"
#include "shape_images.glsl"

// Radius in pixels under which a far drop has the images of the nearest direction: a fifth of a pixel off at most.
const float TABLE_PX = 4.0;

// Parts of all sources at most: more than a pixel's worth for images of up to 16 pixels across. Larger ones, of the sun
// in drops of over 900 pixels of radius, are mottled.
const uint MOST_PARTS = 256;

// Drops with more parts of all sources are left to SHARED, and those that move with more than MOVING_PARTS, or over more than
// so many pixels. An invocation has eight of the others, one after the other, each of 24 parts x 8 ways x 3 indices x 11 turns
// at most, or of 8 x 8 x 3 x 24: 51,000 turns of llvmpipe's (glint_turns.glsl).
const uint STILL_PARTS = 24, MOVING_PARTS = 8;
// Fewer sources than so many count as so many: a drop under one sun is left to SHARED as early as under four.
const uint FEW_SOURCES = 4;
const float MOVING_PX = 12.0;

// The spot of an image that is as deep as the drop's centre.
Spot spot_of_drop(uint drop) {
    float blur = HAS_LENS != 0u && is_spread() ? moves[2u * drop + 1u].z : 0.0;
    return Spot(blur * blur * vec3(1.0, 0.0, 1.0), false, vec2(0.0), way_of(drop));
}

vec3 to_view(vec3 world) {
    return vec3(dot(frame.right.xyz, world), dot(frame.up.xyz, world), dot(frame.back.xyz, world));
}

bool is_flat(Large r) {
    return SHAPE != SPHERES && (r.look & FLAT) != 0u;
}

// In how many parts a source is drawn. An image is four times as wide as the source is in the drop's radii, at most but
// for rainbows: about five parts a pixel, or a spot of half the radius `blur`.
uint parts_of(float pixels, float angle, float blur) {
    float wide = 8.0 * pixels * angle / max(0.5 * blur, 1.0);
    return uint(clamp(wide * wide, 1.0, float(MOST_PARTS / max(all_sources, 1u))));
}

// Is a drop of some pixels, not drawn by rays, and each of its images a point?
bool is_small(Large r, float pixels) {
    bool small = SPLAT_PX > 0.0 && (r.look & BY_RAYS) == 0u && pixels <= TABLE_PX;
    uint i = 0u;
    do small = small && parts_of(pixels, source_at(i).toward.w, 0.0) == 1u; while (++i < all_sources);
    return small;
}

// Draws an image (glints.glsl) in the plane of the eye's axis and `aside`: at its place; where the fragments cover nothing of
// that pixel, a quarter of a pixel farther in, as all images at the rim of a drop that is spread. `light`: for an image of 1.
void add_image(uint drop, Large r, Eye e, uint way, float off, vec2 image, vec3 aside, vec4 shape, vec3 light) {
    float focal = frame.image.z, in_by = max(1.0 - 0.25 / (focal * e.sine), 0.75), inner = clamp(image.x, -in_by, in_by);
    bool done = image.y <= 0.0;
    for (uint attempt = is_spread() ? 1u : 0u; !done && attempt < 2u; ++attempt) {
        float sin_a = e.sine * (attempt == 0u ? image.x : inner), cos_a = sqrt(1.0 - sin_a * sin_a);
        vec3 ray = cos_a * e.axis + sin_a * aside;
        float larger = 1.0;
        if (is_flat(r)) ray = cos_a * e.axis + e.sine * flattened(shape, sin_a / e.sine * aside, e.axis, vertical(), larger);
        float depth = max(-ray.z, 0.01);
        // Pixels for each unit of solid angle grow with depth^-3.
        vec2 at = pixel_of(vec2(ray.x, -ray.y) * (focal / depth) + focal * frame.lens.y * vec2(e.place.x, -e.place.y));
        Spot of_lens = Spot(vec3(0.0), false, vec2(0.0), e.way);
#ifdef SHARED
        if (is_lens()) of_lens = spot_of(e, nearness_of(e, way, image.x, off), ray, cos_a * aside - sin_a * e.axis);
#endif
        done = -ray.z < 0.01 || add_light(drop, r, at, light * (larger * image.y / (cos_a * depth * depth * depth)), of_lens);
    }
}

// Draws the images of a far drop of some pixels that come by ways of closed form alone; whether it is one. What `solve`
// does takes CPU drivers the same time for one drop as for eight.
bool add_by_closed_form(uint drop, Large r) {
    Eye e = eye_at(r.sphere, vec2(0.0), 1.0);
    e.way = way_of(drop);
    float pixels = frame.image.z * e.sine;
    bool closed = is_small(r, pixels) && !is_flat(r) && e.sine < far_sine();
    uint i = 0u;
    if (closed) do {
        if (LOSES_LEFT != 0u && i == END) break;
        vec4 source = source_at(i).toward;
        uint ways = ways_of(angle_between(e.axis, to_view(source.xyz)), source.w, e.sine);
        closed = (ways & ~CLOSED_WAYS) == 0u;
    } while (closed && ++i < all_sources);
    i = 0u;
    if (closed) do {
        vec4 source = source_at(i).toward;
        vec3 toward = to_view(source.xyz), aside = aside_of(e.axis, toward);
        vec3 light = source_at(i).light.rgb * (pixels * pixels);
        float off = angle_between(e.axis, toward);
        uint ways = ways_of(off, source.w, e.sine);
        if (ways != 0u) do {
            for (uint k = 0u; k < INDICES; ++k) {
                vec3 color = take_index(k);
                uint way = uint(findLSB(ways));
                add_image(drop, r, e, way, off, far_image_of(way, off, e.sine), aside, ROUND, color * light);
            }
        } while ((ways &= ways - 1u) != 0u);
    } while (++i < all_sources);
    return closed;
}

// Draws the images that a far drop of some pixels shows as splats do; whether it is one.
bool add_by_table(uint drop, Large r) {
    vec4 m = r.to_disc;
    float squared = 1.0 / abs(m.x * m.w - m.y * m.z), radius = sqrt(squared);
    vec2 size = vec2(radius);
    if (is_flat(r)) {
        // Its picture is flattened with its outline.
        LargeShape l = large_shapes[drop];
        radius = l.radius;
        squared = radius * radius;
        size = 0.5 * (l.box.zw - l.box.xy);
        r.center += 0.5 * (l.box.xy + l.box.zw);
    }
    if (!is_small(r, radius)) return false;
    // A quarter of a pixel farther in where nothing is covered.
    float far = length(r.sphere.xyz), sine = r.sphere.w / far, inner = 1.0 - 0.25 / radius;
    vec3 axis = r.sphere.xyz / far;
    Spot disc = spot_of_drop(drop);
    uint i = 0u;
    do {
        vec3 toward = to_view(source_at(i).toward.xyz);
        float cosine = dot(axis, toward), off = angle_between(axis, toward);
        vec2 on_screen = size * inversesqrt(max(-axis.z, 1e-3)) * toward_on_screen(axis, toward);
        uint angles = ANGLES + i * GLINT_ANGLES;
        uvec4 nearest = splat_of(angles + angle_number(cosine));
        for (uint j = 0u; j < 2u; ++j) {
            // The ray to an image is not the axis: the image is that of a farther drop at another angle.
            float place = unpackHalf2x16(nearest.x)[j];
            uvec4 images = splat_of(angles + angle_number(cos(off - sine * place * sin(off))));
            vec2 places = unpackHalf2x16(images.x);
            bool is_first = abs(places.x - place) < abs(places.y - place);
            vec3 light = squared * unpack_radiance(is_first ? images.y : images.z);
            if (j == 1u) light += squared * unpack_radiance(images.w);
            float out_by = is_first ? places.x : places.y;
            if (is_spread()) out_by = clamp(out_by, -inner, inner);
            vec2 at = out_by * on_screen;
            bool done = false;
            for (uint attempt = 0u; !done && attempt < 2u; ++attempt) {
                done = add_light(drop, r, r.center + (attempt == 0u ? at : inner * at), light, disc);
            }
        }
    } while (++i < all_sources);
    return true;
}

// Does a drop show them all over its disc (rays.comp)?
bool spreads_glints(uint drop, Large r) {
    return (r.look & BY_RAYS) != 0u && is_lens() && has_spread_glints(drop, r.sphere);
}

// The ways by which a drop shows a part that is `off` its axis. In a large drop even an image of a thirtieth of the light is
// seen, and of less.
uint ways_in(Large r, float off, float radius, float sine) {
    return ways_of(off, radius, sine) | ((r.look & BY_RAYS) != 0u ? faint_ways(off - radius, sine) : 0u);
}

#ifdef SHARED
// On a GPU a workgroup finds the images of so many parts together, each invocation a way of one part.
const uint FOUND_PARTS = 4, FOUND_WAYS = 16;
const bool FINDS_TOGETHER = GLINT_LANES == FOUND_PARTS * FOUND_WAYS;
shared vec2 found_images[FOUND_PARTS * FOUND_WAYS * 3u];

uint place_found(uint number, uint way, uint index) {
    return (number % FOUND_PARTS * FOUND_WAYS + way) * INDICES + index;
}

void find_images(Parts p, uint first, Large r, vec3 axis, float sine) {
    uint number = first + gl_LocalInvocationID.x / FOUND_WAYS, way = gl_LocalInvocationID.x % FOUND_WAYS;
    barrier();
    if (number < p.count) {
        float off = angle_between(axis, toward_part(p, number));
        if ((ways_in(r, off, p.radius, sine) >> way & 1u) != 0u) {
            for (uint k = 0u; k < INDICES; ++k) {
                take_index(k);
                found_images[place_found(number, way, k)] = image_in(way, off, p.radius, sine);
            }
        }
    }
    barrier();
}
#endif

// Draws the images of a source that the lens's middle sees by ways that all of the lens sees alike, or one of several eyes by the
// others. Of several each looks at another part of it.
void solve_from(uint drop, Large r, uint source, uint eye, uint eyes, Looks looks) {
    Eye e = eye_of(r.sphere, eye, eyes);
    float pixels = frame.image.z * e.sine;
    vec4 shape = ROUND;
    if (is_flat(r)) shape = large_shapes[drop].shape;
    bool is_only = eyes == 1u;
    uint some = is_only ? ~looks.uneven : looks.uneven;
    vec4 disc = source_at(source).toward;
    vec3 toward = to_view(disc.xyz);
    uint count = is_only ? parts_of(pixels, disc.w, looks.least) : eyes;
#ifdef SHARED
    uint among = (all_sources - source) * (looks.uneven != 0u ? 2u : 1u);
    uint wanted = ways_in(r, angle_between(e.axis, toward), disc.w, e.sine) & some;
    if (is_only) count = min(count, parts_in_time(turns_by(wanted, turns_to_show(drop, e, WIDE)), among));
#endif
    Parts p = parts_in(toward, disc.w, e.axis, count);
    vec3 light = source_at(source).light.rgb * (p.part * p.part * pixels * pixels);
    uint first = is_only ? 0u : uint(float(eyes) * fract(0.67104361 * float(eye))), end = is_only ? p.count : first + 1u, j = first;
    do {
#ifdef SHARED
        if (FINDS_TOGETHER && (j == first || j % FOUND_PARTS == 0u)) find_images(p, j, r, e.axis, e.sine);
#endif
        vec3 s = toward_part(p, j), aside = aside_of(e.axis, s);
        float off = angle_between(e.axis, s);
        uint ways = ways_in(r, off, p.radius, e.sine) & some;
#ifdef SHARED
        if (!take_turns(1u + turns_to_find() * INDICES * uint(bitCount(ways)))) ways = 0u;
#endif
        if (ways != 0u) do {
            uint way = uint(findLSB(ways));
            if (is_only) e.slant = unpackHalf2x16(looks.slants[way]);
            for (uint k = 0u; k < INDICES; ++k) {
                vec3 color = take_index(k);
                vec2 image;
#ifdef SHARED
                if (FINDS_TOGETHER) image = found_images[place_found(j, way, k)];
                else
#endif
                image = image_in(way, off, p.radius, e.sine);
                e.way = way_of(drop);
#ifdef SHARED
                if (image.y > 0.0 && moves_otherwise(e) && !is_flat(r) && take_turns(2u * TURNS_SPREAD)) {
                    e.way = way_of_image(drop, r.sphere, way, s, p.radius);
                }
#endif
                add_image(drop, r, e, way, off, image, aside, shape, color * light);
            }
        } while ((ways &= ways - 1u) != 0u);
    } while (++j < end);
}

// Is a drop no sphere, and drawn by rays that are traced? These meet the sources after reflections inside, so that two images
// are left to draw: outside, and straight through (light_in of ray_in_shape.glsl).
bool is_traced(Large r) {
    return SHAPE >= TRACED && is_flat(r) && (r.look & BY_RAYS) != 0u;
}

// Where an image is on the screen, seen from a `place` on the lens, of the drop at a `time`, in parts of the exposure from
// its middle on; and its light over the source's.
vec3 shape_image_at(uint drop, Large r, vec4 shape, bool outside, vec3 toward, float time, vec2 place) {
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    vec3 center = r.sphere.xyz - vec3(place, 0.0);
    if (is_exposed()) center += time * moves[2u * drop].xyz;
    ShapeImage image = image_in_shape(outside, shape, world * center / -r.sphere.w, toward);
    vec3 ray = to_view(image.ray);
    float depth = max(-ray.z, 0.01), focal = frame.image.z;
    vec2 at = pixel_of(vec2(ray.x, -ray.y) * (focal / depth) + focal * frame.lens.y * vec2(place.x, -place.y));
    float pixels = focal * focal / (depth * depth * depth); // a steradian
    return vec3(at, -ray.z < 0.01 ? 0.0 : image.light * pixels);
}

// Draws an image, found in the middle of all; where the drop covers nothing of that pixel, a quarter of a pixel farther
// in. `late` and `early`: at the exposure's ends; `right` and `high`: from two places of the lens's edge, which make a spot.
void add_shape_image(uint drop, Large r, vec3 middle, vec3 late, vec3 early, vec3 right, vec3 high, vec3 light) {
    if (middle.z <= 0.0) return;
    Spot spot = spot_of_drop(drop);
    if (right.z > 0.0 && high.z > 0.0) {
        vec2 a = right.xy - middle.xy, b = high.xy - middle.xy;
        spot.form = vec3(a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
    }
    if (late.z > 0.0 && early.z > 0.0) {
        // From the middle to either end, with the mean of the parabola through the three.
        for (uint i = 0u; i < 2u; ++i) {
            vec3 end = i == 0u ? late : early, other = i == 0u ? early : late;
            spot.way = end.xy - middle.xy;
            float mean = max(8.0 * middle.z + 5.0 * end.z - other.z, 0.0) / 24.0;
            add_light(drop, r, middle.xy + 0.5 * spot.way, mean * light, spot);
        }
        return;
    }
    vec2 at = middle.xy, inward = r.center - at;
    light *= middle.z;
    vec2 farther_in = at + 0.25 * inward * inversesqrt(max(dot(inward, inward), 1e-6));
    if (!add_light(drop, r, at, light, spot)) add_light(drop, r, farther_in, light, spot);
}

// Draws the images in a drop that is traced.
void solve_in_shape(uint drop, Large r) {
    vec4 shape = large_shapes[drop].shape;
    float pixels = frame.image.z * r.sphere.w / length(r.sphere.xyz);
    bool is_blurred = is_lens() && moves[2u * drop].w > 0.0;
    float blur = is_blurred ? moves[2u * drop + 1u].z : 0.0, lens = frame.lens.x;
    uint views = 1u + (is_blurred ? 2u : 0u) + (is_exposed() ? 2u : 0u);
#ifdef SHARED
    // A part has two images of each index, and each is drawn in two halves.
    uint draws = 2u * turns_to_draw(abs(way_of(drop)), is_blurred, blur, WIDE);
    uint turns_of_part = 2u * INDICES * (views * SHAPE_TURNS + draws);
#endif
    for (uint i = 0u; i < all_sources; ++i) {
        vec4 disc = source_at(i).toward;
        uint count = parts_of(pixels, disc.w, blur);
#ifdef SHARED
        count = min(count, parts_in_time(turns_of_part, all_sources - i));
#endif
        Parts p = parts_in(disc.xyz, disc.w, vec3(0.0, 1.0, 0.0), count);
        vec3 light = source_at(i).light.rgb * (p.part * p.part);
        // Each part by both ways and each index.
        for (uint j = 0u; j < p.count * 2u * INDICES; ++j) {
            vec3 color = take_index(j % INDICES), toward = toward_part(p, j / (2u * INDICES));
            bool outside = j / INDICES % 2u == 0u;
            vec3 middle = vec3(0.0), late = vec3(0.0), early = vec3(0.0), right = vec3(0.0), high = vec3(0.0);
#ifdef SHARED
            if (!take_turns(views * SHAPE_TURNS)) return;
#endif
            for (uint k = 0u; k < views; ++k) {
                uint view = k > 0u && !is_blurred ? k + 2u : k;
                vec2 place = lens * vec2(view == 1u, view == 2u);
                float time = view == 3u ? 0.5 : view == 4u ? -0.5 : 0.0;
                vec3 image = shape_image_at(drop, r, shape, outside, toward, time, place);
                if (view == 0u) middle = image;
                if (view == 1u) right = image;
                if (view == 2u) high = image;
                if (view == 3u) late = image;
                if (view == 4u) early = image;
            }
            add_shape_image(drop, r, middle, late, early, right, high, color * light);
        }
    }
}

void solve(uint drop) {
    Large r = large_at(drop);
    if (is_traced(r)) {
        solve_in_shape(drop, r);
        return;
    }
    Looks looks = Looks(0u, uint[WAYS](0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u), 0.0);
    uint i = 0u;
    do {
#ifdef SHARED
        if (is_lens() && moves[2u * drop].w > 0.0) {
            looks.least = moves[2u * drop + 1u].z;
            vec4 source = source_at(i).toward;
            if (is_seen_by_places(r.sphere, looks.least) && take_turns(TURNS_TO_LOOK)) {
                looks = looks_at(r.sphere, vec4(to_view(source.xyz), source.w), looks.least);
            }
        }
#endif
        for (uint eye = 0u, eyes = 1u; eye < eyes; ++eye) {
            solve_from(drop, r, i, eye, eyes, looks);
#ifdef SHARED
            // Then from several, from 0 on, in the same loop: a GPU's compiler writes each call out.
            if (eyes > 1u || looks.uneven == 0u) continue;
            uint draws = turns_to_show(drop, eye_of(r.sphere, 0u, MOST_EYES), WIDE);
            eyes = clamp(parts_in_time(turns_by(looks.uneven, draws), all_sources - i), 2u, MOST_EYES);
            eye = ~0u;
#endif
        }
    } while (++i < all_sources);
}

#ifdef SHARED
void main() {
    read_counts();
    uint number = group_number();
    if (number >= min(totals.shared_drops, MAX_LARGES) || all_sources == 0u) return;
    uint drop = shared_drops[number];
    Large r = large_at(drop);
    if (!add_by_closed_form(drop, r) && !add_by_table(drop, r)) solve(drop);
    if (is_over && gl_LocalInvocationID.x == 0u) atomicAdd(counters.lost, 1u);
}
#else
// May it take so long that one drop after the other does not do?
bool takes_long(uint drop, Large r) {
    uint most = 1u;
    uint i = 0u;
    do {
        most = max(most, parts_of(frame.image.z * min(r.sphere.w / length(r.sphere.xyz), 0.99999), source_at(i).toward.w, 0.0));
    } while (++i < all_sources);
    most *= max(all_sources, FEW_SOURCES);
    if (!is_spread()) return most > STILL_PARTS;
    vec2 way = abs(moves[2u * drop + 1u].xy);
    return most > MOVING_PARTS || max(way.x, way.y) > MOVING_PX || HAS_LENS != 0u && moves[2u * drop].w > 0.0;
}

void share(uint drop) {
    uint number = atomicAdd(totals.shared_drops, 1u);
    shared_drops[number] = drop;
    atomicMax(totals.shared_groups.x, min(number + 1u, ROW));
    atomicMax(totals.shared_groups.y, number / ROW + 1u);
}

void main() {
    read_counts();
    uint first = gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x, todo = 0u;
    uint end = all_sources > 0u ? min(totals.larges, MAX_LARGES) : 0u; // surroundings that are given anew may have no source
    for (uint i = 0u; i < DROPS && first + i * WIDE < end; ++i) {
        uint drop = first + i * WIDE;
        Large r = large_at(drop);
        bool shown = (r.look & AS_SPLATS) == 0u && r.look >> 16 != 0u;
        bool traced = is_traced(r);
        if (traced && SHAPE == WHOLE) shown = false;
        if (HAS_LENS != 0u && is_spread()) shown = shown && (traced ? has_own_spots(drop) : !spreads_glints(drop, r));
        bool shared_by_all = shown && takes_long(drop, r);
        if (shared_by_all) share(drop);
        if (!shown || shared_by_all || add_by_closed_form(drop, r)) continue;
        // One of its images is by no closed form, but it may be small, and the nearest direction's will do.
        if (!add_by_table(drop, r)) todo |= 1u << i;
    }
    if (DROPS > 1u) {
        for (; todo != 0u; todo &= todo - 1u) solve(first + uint(findLSB(todo)) * WIDE);
    } else if (todo != 0u) {
        solve(first);
    }
}
#endif
