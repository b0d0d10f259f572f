#ifndef FRAME_GLSL
#define FRAME_GLSL
// What every pass of a frame needs to know: `Frame` in src/passes/frame.rs, member for member.
// Everything is a vec4, so that std140 and Rust's repr(C) agree.
struct Frame {
    vec4 right;         // xyz: the camera's axes in world space
    vec4 up;
    vec4 back;
    vec4 units;         // xyz: scene units a unit of place; w: radius of the rain's drops
    uvec4 camera_place; // xyz: the camera's place in the first population's box; w: index of the first drop placed by hand
    uvec4 shift;        // xyz: how far the rain has moved; w: number of all drops
    uvec4 seed;         // xy: low and high half; z: 1 to restart the stored positions; w: number of the recording, for the CPU
    vec4 motion;        // xyz: stored positions: displacement since the last frame, scene units
    vec4 camera_high;   // xyz: camera position, float32 part; w: near
    vec4 camera_low;    // xyz: what float32 lost of it; w: near fade
    vec4 extent;        // xyz: half extent of the rain box, the largest of several, and on tiles of what holds all drops;
                        // w: depth reference, the least radius
    vec4 image;         // of the whole picture: width, height, focal length, all in pixels; w: largest point, pixels
    uvec4 window;       // the part that is drawn: xy: its first pixel in the whole picture; zw: its size
    vec4 principal;     // where the view axis meets the picture: xy: pixels of the whole; zw: device coordinates
    vec4 frustum_x;     // cos and sin of the angle from the view axis to the left edge, then to the right one
    vec4 frustum_y;     // the same of the upper and the lower edge
    vec4 environment;   // x: angle of a texel, radians; y: radiance of a stored 1; z: least share of light that is followed
    vec4 tone;          // x: key; y: delta of the log average, stored units; z: fixed factor on stored
                        // units, 0 to derive it; w: pixels that the log average is of
    uvec4 tiles;        // of the part that is drawn: tiles, or sums of log luminance; regions, how many times 2 along both axes, across, in all
    uvec4 room;         // of the tiles' lists: nodes, blocks, large drops; w: bands of depth
    uvec4 clusters;     // x: clusters of drops, or room for those in view; y: clusters of random drops, or room for cells;
                        // z: blocks that one dispatch draws by rays; w: tiles whose lists take several dispatches, at most
    vec4 moved;         // xyz: how far drops of the rain's box move while the shutter is open, as the camera sees them;
                        // w: 1 where drops of any kind may
    uvec4 streaks;      // words of its first links, room for links and for parts of lines (streak_layer.glsl); w: radius of those, bits
    vec4 lens;          // x: its radius, scene units, 0: a pinhole; y: inverse distance of the focus; z: radius in pixels of
                        // the disc that a point at depth 1 becomes, focused at infinity; w: that a point at infinity becomes
};
// A population of drops in a box, after the first, of which `Frame` has the same.
struct Population {
    vec4 units;         // xyz: scene units a unit of place; w: radius
    uvec4 camera_place; // xyz: the camera's place in its box; w: index of its first drop
    uvec4 shift;        // xyz: how far it has moved
    uvec4 seed;         // xy: low and high half
    vec4 moved;         // xyz: how far its drops move while the shutter is open
};
#include "constants.glsl"
layout(std140, set = 0, binding = 0) uniform Constants {
    Frame constants;
    Population others[MOST_POPULATIONS - 1u];
};
// Read at the very start of a shader: behind a branch llvmpipe, which sees that lanes may have left, fetches a
// constant for each lane by itself, 30 instructions instead of 3. (`gather`: a sixth of its time.)
Frame frame = constants;
#endif
