#ifndef LENS_RAYS_GLSL
#define LENS_RAYS_GLSL
// The light of a drop through a lens, by rays: each from a place on the lens, through a place in the pixel.
//
// All rays of a place in the pixel pass through one point of the plane in focus. Those of them that meet a sphere are
// within a cone, and so is an ellipse on the lens: places are taken within that where it is smaller than the lens, so
// that of a drop that is spread over hundreds of pixels each finds as many rays as of one in focus.
#include "lens.glsl"
#include "moving_rays.glsl"
#include "source_light.glsl"
#include "spread_glints.glsl"

// Fewest rays of a pixel: they are a mean over the lens.
const uint LEAST_LENS_RAYS = 16 * SURER;
// Behind a sphere the environment is blurred by this part of their spacing on it. They take other places in each pixel, so that
// noise averages out; what is blurred too much does not (by the whole spacing a near drop's light is off by up to a quarter).
const float LENS_SPACING = 0.2;

// The places on the lens from which a sphere is met; axes along `axis` and across it. Not `is_ellipse`: it comes to the
// plane in focus, so that they are none.
struct LensPlaces {
    vec2 center, axis, axes;
    bool is_ellipse;
    bool is_beyond; // the plane in focus
};

// `d`: the pinhole's ray, 1 along the view axis. From the ray through the sphere's middle on, with the place M from its
// own: it meets the sphere if (1 - z/f)² |d' x M|² <= r² |d' - M/f|², d' its direction, z the middle's depth, f the focus's.
LensPlaces places_that_meet(vec3 d, vec3 center, float radius) {
    float y = frame.lens.y, depth = -center.z, q = 1.0 - depth * y, ry2 = radius * radius * y * y;
    LensPlaces p;
    p.is_ellipse = q * q > 1.02 * ry2;
    p.is_beyond = q < 0.0;
    float held = p.is_ellipse ? q : 1.0;
    vec2 middle = (center.xy - depth * d.xy) / held, aside = d.xy - middle * y;
    float aside2 = dot(aside, aside), length2 = 1.0 + aside2;
    p.axis = aside2 > 1e-12 ? aside * inversesqrt(aside2) : vec2(1.0, 0.0);
    float along = max(q * q - ry2, 1e-12), across = max(q * q * length2 - ry2, 1e-12);
    float shift = radius * radius * y * sqrt(aside2) / along;
    float level = radius * radius * (length2 + radius * radius * y * y * aside2 / along);
    p.center = middle - shift * p.axis;
    p.axes = sqrt(level / vec2(along, across));
    return p;
}

// A place of the unit square in a box on the lens, `along` and across; `share` as of `lens_place`.
vec2 place_in_box(vec2 square, vec2 along, vec2 from, vec2 to, out float share) {
    vec2 sides = max(to - from, 0.0), at = from + sides * square, place = at.x * along + at.y * vec2(-along.y, along.x);
    float lens2 = frame.lens.x * frame.lens.x;
    share = dot(place, place) <= lens2 ? sides.x * sides.y / (3.14159265 * lens2) : 0.0;
    return place;
}

// Where on the lens a ray begins, for a place of the unit square; `share`: the part of the lens that it stands for, 0 beside
// the lens. Places are where rays meet the drop, as far as that has a simple form.
vec2 lens_place(vec2 square, vec3 d, vec3 center, vec3 motion, float radius, out float share) {
    float lens = frame.lens.x;
    share = 1.0;
    if (motion == vec3(0.0)) {
        LensPlaces p = places_that_meet(d, center, radius);
        float far = length(p.center), wide = max(p.axes.x, p.axes.y);
        if (!p.is_ellipse || far + lens <= min(p.axes.x, p.axes.y)) return lens * on_unit_disc(square);
        if (far + wide <= lens) {
            vec2 from = p.axes * on_unit_disc(square);
            share = p.axes.x * p.axes.y / (lens * lens);
            return p.center + from.x * p.axis + from.y * vec2(-p.axis.y, p.axis.x);
        }
        // Lens and ellipse overlap: the box of that, as if the ellipse were a circle around it.
        float crossing = (far * far + lens * lens - wide * wide) / (2.0 * max(far, 1e-12)), high = min(wide, lens);
        if (crossing > 0.0 && crossing < far) high = sqrt(max(lens * lens - crossing * crossing, 0.0));
        vec2 along = far > 0.0 ? p.center / far : vec2(1.0, 0.0);
        return place_in_box(square, along, vec2(max(far - wide, -lens), -high), vec2(min(far + wide, lens), high), share);
    }
    // Rays meet a sphere that moves within a strip along the way of its ellipse, as far as that crosses the lens.
    LensPlaces a = places_that_meet(d, center - 0.5 * motion, radius), b = places_that_meet(d, center + 0.5 * motion, radius);
    if (!a.is_ellipse || !b.is_ellipse || a.is_beyond != b.is_beyond) return lens * on_unit_disc(square);
    vec2 way = b.center - a.center;
    float length2 = dot(way, way), wide = max(max(a.axes.x, a.axes.y), max(b.axes.x, b.axes.y));
    vec2 along = length2 > 1e-12 * wide * wide ? way * inversesqrt(length2) : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x);
    vec2 from = vec2(max(dot(a.center, along) - wide, -lens), max(dot(a.center, across) - wide, -lens));
    vec2 to = vec2(min(dot(b.center, along) + wide, lens), min(dot(a.center, across) + wide, lens));
    vec2 sides = max(to - from, 0.0);
    if (sides.x * sides.y >= 3.14159265 * lens * lens) return lens * on_unit_disc(square);
    return place_in_box(square, along, from, to, share);
}

// Does what `moving_color` does: the drop's light in a pixel from `corner` on, with that of bright sources if it `spreads` over the drop, or
// if the rays meet them themselves;
// `covered`: part of the lens and of the time for which it covers the pixel.
uint lens_color(vec2 corner, vec4 sphere, Body body, vec3 motion, float pixels, float blur, vec2 moved, float behind, bool spreads,
                out float covered) {
    float radius = sphere.w, focal = frame.image.z;
    // A drop that is no sphere is within a sphere of this radius.
    float reach = body.is_flat ? radius * reach_of_shape(body.shape) : radius;
    mat3 world = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz);
    uint least = max(SAMPLES, LEAST_LENS_RAYS), rays = 0u;
    vec2 turned = turned_of(corner, moved);
    // Rays are spread over the pixel and the disc around it, but over no more than the drop has; being surer makes them no sharper.
    uint apart = max(SAMPLES, least / SURER);
    float disc = 3.14159265 * blur * blur, whole = 3.14159265 * pixels * pixels;
    float step = LENS_SPACING * sqrt((1.0 + min(disc, whole)) / float(apart)) / pixels;
    float way = way_across(normalize(ray_through(corner + 0.5)), motion, radius, pixels);
    // How deep what is behind the pixel is.
    float deep = behind * focal / length(ray_through(corner + 0.5));
    covered = 0.0;
    Rays mean = Rays(vec3(0.0), 0.0, 0.0, 0.0);
    for (; rays < (ARE_FEW ? UNSURE_RAYS : MOST_LENS_RAYS) && (rays < least || !is_known(mean, rays)); ++rays) {
        vec2 in_pixel = fract(vec2(0.81917251, 0.67104361) * float(rays) + turned.yx);
        vec3 through = ray_through(corner + in_pixel) / focal;
        float share;
        vec2 square = fract(vec2(0.75487767, 0.56984029) * float(rays) + turned);
        vec2 place = lens_place(square, through, sphere.xyz, motion, reach, share);
        vec3 d = normalize(through - vec3(place * frame.lens.y, 0.0)), from = sphere.xyz - vec3(place, 0.0);
        vec3 center = from;
        float passed = 0.0; // by its way before the ray, pixels
        if (motion != vec3(0.0)) {
            float nearest;
            vec2 times = times_met(d, from, motion, reach, nearest);
            float part = max(times.y - times.x, 0.0);
            share *= part;
            passed = part * way;
            float moment = part > 0.0 ? mix(times.x, times.y, fract(0.61803399 * float(rays) + turned.y)) : nearest;
            center = from + moment * motion;
        }
        vec3 to_ray = cross(cross(d, center), d) / -radius, light;
        if (body.is_flat) {
            RayInShape flat_ray = ray_in_shape(body, to_ray, d);
            if (!flat_ray.hits || dot(d, center) <= 0.0) share = 0.0;
            float front = dot(d, center) + radius * front_in(flat_ray, body);
            if (HAS_DEPTH != 0u && front >= deep / max(-d.z, 1e-6)) share = 0.0;
            light = light_in(flat_ray, body, world, ray_spacing(1.0, min(disc + passed, whole), pixels, apart), spreads);
        } else {
            float b = length(to_ray), held = min(b, 0.99999), cosine = sqrt((1.0 - held) * (1.0 + held));
            if (b >= 1.0 || dot(d, center) <= 0.0) share = 0.0;
            if (HAS_DEPTH != 0u && dot(d, center) - radius * cosine >= deep / max(-d.z, 1e-6)) share = 0.0;
            // Beyond the rim, the rim, for pixels that no ray hits but the outline touches.
            light = drop_light(environment_map, Intersection(d, to_ray / max(b, 1e-9), held, cosine), world, step);
        }
        add(mean, light, share);
        covered += share;
    }
    covered /= float(rays);
    vec3 light = mean.sum / mean.shares;
    // Rays through what is no sphere meet the sources themselves.
    if (!(SHAPE >= TRACED && body.is_flat) && spreads) light += light_of_sources(world * normalize(sphere.xyz));
    return pack_radiance(light);
}
#endif
