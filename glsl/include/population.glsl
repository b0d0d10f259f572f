#ifndef POPULATION_GLSL
#define POPULATION_GLSL
// The drops of a frame: how they are walked, and what each is. Drops in boxes and placed ones stand in clusters; CELLS: those
// of real rain in cells. Both includes have the same functions.
#if defined(CELLS) || defined(CELLS_SHELTER)
#include "cell_population.glsl"
#else
#include "box_population.glsl"
#endif

const uint GATHER_GROUP = 256, CLUSTERS_A_GROUP = GATHER_GROUP / CLUSTER; // of gather.comp

Drop drop_of(uint index) {
    Drop drop = random_drop(index);
    if (is_by_hand(index)) {
        Placed by_hand = placed_at(by_hand_number(index));
        drop.relative = relative_placed(by_hand);
        drop.radius = by_hand.high.w;
    }
    drop.view = view_space(drop.relative);
    return drop;
}
#endif
