#version 460
// What is computed from specialization constants alone, one word each; see tests/drawn/specialized.rs.
layout(constant_id = 90) const uint A = 5;
layout(constant_id = 91) const uint B = 9;
layout(constant_id = 92) const bool YES = true;
layout(constant_id = 93) const bool NO = false;
layout(constant_id = 94) const float X = 0.25;

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 2) writeonly buffer Found { uvec4 found[]; };

void main() {
    if (gl_GlobalInvocationID.x > 0u) return;
    const bool SAME = A == B, OTHER = A != B, MORE = A > B;
    const bool NEITHER = !(YES || NO), BOTH = YES && NO, ODD = OTHER && !MORE;
    const uint SUM = A + B, LESS = A - B, CHOSEN = MORE ? A + 1u : B + 2u;
    found[0] = uvec4(A, B, uint(YES), uint(NO));
    found[1] = uvec4(SUM, LESS, CHOSEN, floatBitsToUint(X));
    found[2] = uvec4(uint(SAME), uint(OTHER), uint(MORE), uint(NEITHER));
    found[3] = uvec4(uint(BOTH), uint(ODD), 0u, 0u);
}
