#version 460
#extension GL_GOOGLE_include_directive : require
// The picture through the dry pane, one invocation a pixel. See src/passes/pane/mod.rs.
#include "pane.glsl"
#include "pane_pictures.glsl"

layout(local_size_x = 16, local_size_y = 4) in;

void main() {
    uvec2 at = gl_GlobalInvocationID.xy, size = frame.window.zw;
    if (any(greaterThanEqual(at, size))) return;
    uint number = at.y * size.x + at.x;
    float cosine = dot(pane.normal, normalize(ray_through(vec2(frame.window.xy + at) + 0.5)));
    float through = cosine > 0.0 ? dry_pane(cosine) : 1.0;
    radiance_out[number] = before_picture(number, (1.0 - through) * pane.inside, through);
    if (PANE_NEAREST != 0u) nearest_caps[number] = uvec2(NO_CAP, 0u);
}
