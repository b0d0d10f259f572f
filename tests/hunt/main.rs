//! The search over random scenes (`examples/hunt`, `docs/hunt.md`): it draws the same scenes each time and all that a scene
//! can have; its figures are right on pictures whose error is known; what it makes smaller still fails; and a short run.

#![allow(dead_code, reason = "the tests use a part of what the example has")]

#[path = "../common/mod.rs"]
mod common;
mod drawn;
mod figures_known;
mod kinds;
mod pictures;
mod scenes;
mod smaller;

#[path = "../../examples/hunt/bounds.rs"]
mod bounds;
#[path = "../../examples/hunt/bytes.rs"]
mod bytes;
#[path = "../../examples/hunt/drops.rs"]
mod drops;
#[path = "../../examples/hunt/figures.rs"]
mod figures;
#[path = "../../examples/hunt/folder.rs"]
mod folder;
#[path = "../../examples/hunt/keep.rs"]
mod keep;
#[path = "../../examples/hunt/measure.rs"]
mod measure;
#[path = "../../examples/hunt/models.rs"]
mod models;
#[path = "../../examples/hunt/random.rs"]
mod random;
#[path = "../../examples/hunt/report.rs"]
mod report;
#[path = "../../examples/hunt/row.rs"]
mod row;
#[path = "../../examples/hunt/scene.rs"]
mod scene;
#[path = "../../examples/hunt/shrink.rs"]
mod shrink;
#[path = "../../examples/hunt/skies.rs"]
mod skies;
#[path = "../../examples/hunt/sweep.rs"]
mod sweep;
#[path = "../../examples/hunt/text.rs"]
mod text;
#[path = "../../examples/hunt/trace.rs"]
mod trace;
