#ifndef SPRITE_GLSL
#define SPRITE_GLSL
// The paper's section 3.3, vertex half: where a drop's square stands, how large it is, which mask
// level it reads and how the mask is turned. Shared by drops_point.vert and drops_quad.vert.
#include "projection.glsl"

struct Sprite {
    vec2 center;    // normalised device coordinates of the part that is drawn
    float diameter; // pixels
    float depth;    // reversed: 1 at the nearest, 0 far away
    float level;    // of the mask
    float opacity;  // of the whole drop: near fade, and the area that a one-pixel point lacks
    mat3 rotation;  // from the pose of the preprocessing to world space
};

// `center`: drop's centre in view space; its depth -z is over its radius.
Sprite sprite(vec3 center, float radius) {
    float z = -center.z, d2 = dot(center, center), r2 = radius * radius;
    float flat2 = z * z - r2;
    Sprite s;
    // The sphere's silhouette is an ellipse of semi-axes r √(d²-r²) / (z²-r²) and r / √(z²-r²)
    // focal lengths about this point. The square takes the side that keeps the ellipse's area; on
    // the axis that is the paper's tangent cone.
    s.center = device_of(vec2(center.x, -center.y) * z / flat2 * frame.image.z);
    float root = sqrt(flat2);
    s.diameter = 2.0 * frame.image.z * radius * sqrt(sqrt(d2 - r2)) / (root * sqrt(root));
    s.depth = frame.extent.w / z;
    // tan a = r / √(d²-r²); the level is minus its logarithm: a distance, not a size on the screen.
    s.level = 0.5 * log2((d2 - r2) / r2);

    // Below a pixel the point stays one pixel: its alpha carries the area.
    float shrink = min(s.diameter, 1.0);
    float distance = sqrt(d2), near = frame.camera_high.w, fade = frame.camera_low.w;
    float faded = fade > 0.0 ? smoothstep(near, near + fade, distance) : 1.0;
    s.opacity = shrink * shrink * faded;

    // Equations 1 to 4: columns u, v, n. n points from the drop to the eye. Any v and u serve a
    // sphere if (s, t) turns with them; (s, t) stays on the screen's axes, so they are those axes
    // carried to n by the least rotation (Frisvad's basis, in view space). Its pole is n = -z,
    // straight behind the camera, where no drop is seen.
    vec3 n = -center / distance;
    float a = 1.0 / (1.0 + n.z);
    vec3 u = vec3(1.0 - n.x * n.x * a, -n.x * n.y * a, -n.x);
    vec3 v = vec3(-n.x * n.y * a, 1.0 - n.y * n.y * a, -n.y);
    s.rotation = mat3(frame.right.xyz, frame.up.xyz, frame.back.xyz) * mat3(u, v, n);
    return s;
}
#endif
