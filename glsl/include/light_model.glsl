// What a drop does to a ray of light: `Light` in src/plan/mod.rs. A pipeline that includes this has these
// constants first.
layout(constant_id = 0) const uint INTERNAL_REFLECTIONS = 2; // most that are followed
layout(constant_id = 1) const uint CONSERVING = 1; // 1: the last order takes what the omitted carry
layout(constant_id = 2) const uint SCHLICK = 0;
layout(constant_id = 3) const uint REFLECTION = 1;
layout(constant_id = 4) const uint FOOTPRINT = 1; // 0: the environment's finest level always
