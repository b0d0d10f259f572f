//! The drops on a scene's pane from frame to frame: at whatever age the pane is, or, where no rain falls on it, whichever are placed.
//! Where no extent is given, rain falls on what the first scene sees of it.

use std::sync::Arc;

use super::PaneDrops;
use crate::Result;
use crate::gpu::Device;
use crate::pane::keyframes::Keyframes;
use crate::scene::Scene;
use crate::scene::pane::PaneDrop;

/// The drops as they were last asked for, and what others come from.
#[derive(Default)]
pub(crate) struct AgingDrops {
    rained: Option<Keyframes>,
    shown: Option<Shown>,
}

/// Drops on the device.
struct Shown {
    /// How many had arrived.
    arrived: u64,
    placed: Vec<PaneDrop>,
    drops: Arc<PaneDrops>,
}

impl AgingDrops {
    /// The drops of `scene`, whose pane is that of the first scene but for its age, or for the drops that are placed; what the last
    /// call gave, if these are the same.
    ///
    /// # Errors
    /// See [`PaneDrops::new`].
    pub fn of(&mut self, device: &Arc<Device>, scene: &Scene) -> Result<Arc<PaneDrops>> {
        if self.shown.is_none() {
            let wiped = scene.pane_population();
            self.rained = wiped.map(|wiped| Keyframes::new(wiped, scene.pane_arrivals_a_second()));
        }
        let (age, placed) =
            scene.pane.as_ref().map_or((0.0, &[][..]), |pane| (pane.age(), &pane.drops));
        let rained = self.rained.as_mut().map(|rained| rained.at(age));
        let arrived = rained.map_or(0, |rained| rained.tally.arrived);
        match &self.shown {
            Some(shown) if shown.arrived == arrived && shown.placed == placed => {
                Ok(shown.drops.clone())
            }
            _ => {
                let drops = Arc::new(PaneDrops::new(device, &scene.pane_caps_of(rained))?);
                let shown = Shown { arrived, placed: placed.to_vec(), drops };
                Ok(self.shown.insert(shown).drops.clone())
            }
        }
    }
}
