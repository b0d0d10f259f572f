#ifndef TOGETHER_GLSL
#define TOGETHER_GLSL
// What the invocations of a subgroup take together from a counter: one atomic for all of them, as a counter that every lane
// adds to is fought over.
//
// Vulkan does not promise that invocations come together again after a branch that only some of them took: then each would
// have another `first`. Where nothing else promises it (src/gpu/promises.rs) there is no branch, and all add, all but one of
// them nothing. Nothing may branch between the subgroup's operations from which `count` is and this either.

layout(constant_id = 27) const uint RECONVERGES = 0; // 1: they do come together

// In effect the leader's `first = atomicAdd(counter, count)`, for all. `first`: set before to what it is where nothing is taken.
// `leads`: subgroupElect().
#define TAKE_TOGETHER(counter, count, leads, first) \
    if (RECONVERGES == 0u) first = atomicAdd(counter, uint(leads) * count); \
    else if (leads && count > 0u) first = atomicAdd(counter, count); \
    first = subgroupBroadcastFirst(first)

// After TAKE_TOGETHER from a counter of what there is room for `most` of: once there is none the counter stays just beyond, so that it
// does not wrap, and nothing is given out twice.
#define STAY_BEYOND(counter, most, leads, first) \
    if (leads && first > most) atomicMin(counter, most + 1u)
#endif
