// The lines that the brightest source draws along wide streaks of the veil: while a drop falls, each of its images of the
// source stays at one place of its outline. The two brightest are drawn (lines.comp); other light is spread over the
// streak.

// Sums of lines are in whole units, so that no order changes a bit.
const float LINE_UNITS = 1048576.0;
