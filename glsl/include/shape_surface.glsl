// The surface of a drop that is no sphere, as rays meet it. Needs light_model.glsl.
//
// Everything is seen from the middle of the plane that joins the halves, along the world's axes, in radii. A half scaled
// to the unit sphere is met by a quadratic equation; directions and normals stay those of unscaled space. Which half a
// line meets follows from where it crosses the joint's plane, so that one equation is solved a surface.

// Most surfaces that light is followed to beyond the last order, where that carries what is left and is reflected totally.
const uint MOST_MORE = 16;

// Whether it is the upper half that a line enters, and that it leaves.
bvec2 upper_met(vec4 shape, vec3 p, vec3 d) {
    vec2 at = p.xz * d.y - d.xz * p.y; // where it crosses the plane, times d.y
    float across = shape.x * d.y, side = -dot(d.xz, at);
    bool through = dot(at, at) < across * across;
    return bvec2(through ? d.y < 0.0 : side > 0.0, through ? d.y > 0.0 : side > 0.0);
}

// Reciprocal semi-axes of a half.
vec3 scale_of(vec4 shape, bool upper) {
    float across = 1.0 / shape.x;
    return vec3(across, 1.0 / (upper ? shape.y : shape.z), across);
}

// Where a line enters a scaled half, or leaves it: the point, moved onto the surface so that no rounding adds up.
vec3 crossing(vec3 p, vec3 d, vec3 scale, float side, out float along) {
    vec3 from = p * scale, to = d * scale;
    float a = dot(to, to), nearest = -dot(from, to) / a;
    vec3 middle = from + nearest * to;
    along = nearest + side * sqrt(max(1.0 - dot(middle, middle), 1e-12) / a);
    return normalize(from + along * to) / scale;
}

// Exact, or Schlick's, from the cosines on both sides, of which the first is in the substance before.
float reflectance_of(float cos_incidence, float cos_refraction, float index) {
    if (cos_refraction <= 0.0) return 1.0;
    if (SCHLICK != 0u) {
        float normal = (index - 1.0) / (index + 1.0), x = 1.0 - (index > 1.0 ? cos_incidence : cos_refraction);
        return normal * normal + (1.0 - normal * normal) * (x * x) * (x * x) * x;
    }
    float s = (cos_incidence - index * cos_refraction) / (cos_incidence + index * cos_refraction);
    float p = (index * cos_incidence - cos_refraction) / (index * cos_incidence + cos_refraction);
    return 0.5 * (s * s + p * p);
}
