#version 460
// Work that takes a while, in steps. See src/gpu/probe/clock.rs.
layout(push_constant) uniform Push { uint steps; };
layout(location = 0) out vec4 color;

void main() {
    vec2 z = gl_FragCoord.xy * 1e-3;
    for (uint i = 0u; i < steps; ++i) z = fract(z.yx * 1.618 + 0.31);
    color = vec4(z, 0.0, 1.0);
}
