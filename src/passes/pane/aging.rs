//! The drops on a scene's pane, at whatever age the pane is.
//!
//! Only the way forwards is short: rain goes on from the last age that was asked for. Back, it falls from the wiped pane on again, at
//! up to a microsecond a drop that arrives. Where no extent is given, rain falls on what the first scene sees of the pane.

use std::sync::Arc;

use super::PaneDrops;
use crate::Result;
use crate::gpu::Device;
use crate::pane::population::Population;
use crate::scene::Scene;

/// The drops as they were last asked for, and what others come from.
#[derive(Default)]
pub(crate) struct AgingDrops {
    wiped: Option<Population>,
    rained: Option<Population>,
    age: f64,
    drops: Option<Arc<PaneDrops>>,
}

impl AgingDrops {
    /// The drops of `scene`, whose pane differs from that of the first scene by its age alone; what the last call gave, if none has
    /// arrived since.
    ///
    /// # Errors
    /// See [`PaneDrops::new`].
    pub fn of(&mut self, device: &Arc<Device>, scene: &Scene) -> Result<Arc<PaneDrops>> {
        let age = scene.pane.as_ref().map_or(0.0, |pane| pane.age());
        if self.drops.is_none() {
            self.wiped = scene.pane_population();
            self.rained.clone_from(&self.wiped);
        } else if age < self.age && self.wiped.is_some() {
            self.rained.clone_from(&self.wiped);
            self.drops = None;
        }
        let arrived = |rained: &Option<Population>| rained.as_ref().map(|all| all.tally.arrived);
        let before = arrived(&self.rained);
        if let Some(rained) = &mut self.rained {
            rained.go_on_to(age);
        }
        self.age = age;
        match &self.drops {
            Some(drops) if arrived(&self.rained) == before => Ok(drops.clone()),
            _ => {
                let caps = scene.pane_caps_of(self.rained.as_ref());
                Ok(self.drops.insert(Arc::new(PaneDrops::new(device, &caps)?)).clone())
            }
        }
    }
}
