//! The reference: against closed forms, other ray tracers and itself.

#[path = "../common/mod.rs"]
mod common;

mod flat_suns;
mod glints;
mod independent;
mod plates;
mod rain_drops;
mod rain_reference;
mod rainbow;
mod reference;
mod shutter;
