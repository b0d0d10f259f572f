// Angles from 0 to a half turn at which bow.comp tells a far drop's light, as in src/passes/glints.rs: 0.09° apart, a
// third of the sun's radius.
const uint BOW_ANGLES = 2048;
