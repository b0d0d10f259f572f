#ifndef FAR_GLINTS_GLSL
#define FAR_GLINTS_GLSL
// The two brightest images of each source in a far drop, by the angle between the two (far_glints.comp), and the table of
// what splats show that holds them (splat_table.comp).
//
// An angle's four words: the images' impact parameters over the sine of the angle, as halves; their light for a drop with
// a radius of a pixel; that of all further images. Impact parameters so divided are nearly even where images move fastest,
// before the sun.
#include "appearance.glsl"

const uint HALF_ANGLES = GLINT_ANGLES / 2u;

// Where the splats' table has the sources' directions in view space, and the angles of the first source.
const uint TOWARD_SOURCES = SINGLE_TEXELS, ANGLES = TOWARD_SOURCES + MOST_SOURCES;

// Number of an angle by its cosine: even steps of the sine of half the angle, or of half of what it lacks to a half turn.
uint angle_number(float cosine) {
    float half_sine = sqrt(max(1.0 - abs(cosine), 0.0));
    uint number = min(uint(half_sine * float(HALF_ANGLES)), HALF_ANGLES - 1u);
    return cosine > 0.0 ? number : GLINT_ANGLES - 1u - number;
}

// The angle in the middle of those with a number.
float angle_numbered(uint number) {
    bool in_front = number < HALF_ANGLES;
    float half_sine = (float(in_front ? number : GLINT_ANGLES - 1u - number) + 0.5) / float(HALF_ANGLES);
    float angle = 2.0 * asin(half_sine * 0.70710678);
    return in_front ? angle : 3.14159265358979 - angle;
}

// Where on the screen, from its middle, a drop along `axis` shows an image whose impact parameter is the sine of its angle
// to a source; both unit vectors in view space. In the outline's mean radii over the root of the axis' depth: that outline
// is larger by depth^-1.5 than one on the axis of view. (What the source's direction has of the axis falls out.)
vec2 toward_on_screen(vec3 axis, vec3 toward) {
    return -axis.z * vec2(toward.x, -toward.y) + toward.z * vec2(axis.x, -axis.y);
}
#endif
