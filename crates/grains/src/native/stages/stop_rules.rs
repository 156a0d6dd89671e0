//! The rules by which a stage ends.

use super::{LOOK_UP_EVERY, Runner};
use crate::tables::{Punch, StopReason};

impl Runner<'_> {
    /// Settled when the kinetic energy is at most the scene's share of its peak.
    pub(super) fn settle_rule(&mut self) -> Option<StopReason> {
        let settle = &self.scene.settle;
        if self.step.is_multiple_of(settle.check_every) {
            let energy = self.dynamics.kinetic_energy();
            let peak = self.seen.energy.max(energy);
            self.seen.energy = peak;
            if energy <= settle.kinetic_energy_fraction * peak {
                return Some(StopReason::Settled);
            }
            // The energy falls about exponentially, so its logarithm tells how far settling is.
            let share = (energy / peak).ln() / settle.kinetic_energy_fraction.ln();
            self.observer.progress(self.stage, self.step, share);
        }
        (self.step >= settle.max_steps).then_some(StopReason::MaxSteps)
    }

    /// The force is reached, or the punch is too deep.
    pub(super) fn load_rule(&mut self) -> Option<StopReason> {
        let punch = self.dynamics.state.punch?;
        let of_force = punch.force / self.scene.target_force();
        let of_depth = punch.depth() / self.scene.loading.give_up_depth;
        if self.step.is_multiple_of(LOOK_UP_EVERY) {
            self.observer
                .progress(self.stage, self.step, of_force.max(of_depth));
        }
        if let Some(since) = self.seen.standing_since {
            let long_enough = self.scene.steps_standing_still().unwrap_or(0);
            return (self.step >= since + long_enough).then_some(StopReason::Reached);
        }
        if punch.force >= self.scene.target_force() {
            if self.scene.steps_standing_still().is_none() {
                return Some(StopReason::Reached);
            }
            self.seen.standing_since = Some(self.step);
            self.dynamics.state.punch = Some(Punch {
                velocity: 0.0,
                ..punch
            });
            return None;
        }
        let too_deep = punch.depth() >= self.scene.loading.give_up_depth;
        too_deep.then_some(StopReason::TargetLoadNotReached)
    }
}
