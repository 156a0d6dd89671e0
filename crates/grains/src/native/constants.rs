//! What a step reads and never changes.

use super::contact::{self, Axis};
use super::friction::{ContactRules, Parameters};
use crate::model::Kernel;
use crate::model::{Law, Model, damping_ratio};
use crate::scene::Viscosity;
use crate::tables::BodyIds;

/// Constants of a run, taken from the model once.
#[derive(Debug, Clone, PartialEq)]
pub struct Constants {
    /// Moduli, angles and options of the contact law.
    pub law: Law,
    /// Relative change of every k_n; 1 unless it is perturbed.
    pub normal_factor: f64,
    /// Relative change of every k_s; 1 unless it is perturbed.
    pub tangential_factor: f64,
    /// Damping ratio of the dashpots, where a restitution is asked for.
    damping_ratio: f64,
    /// m/s².
    pub gravity: [f64; 2],
    /// Cundall's α.
    pub alpha: f64,
    /// s.
    pub dt: f64,
    /// The walls, with ids in rising order.
    pub walls: Vec<Wall>,
    /// Ids of walls and punch.
    pub ids: BodyIds,
    /// Inner width of the box that grains must stay in, m; none where there is no box.
    pub box_width: Option<f64>,
    /// Pairs of a grain are summed from the highest partner down instead of from the lowest up.
    pub reversed_sums: bool,
    /// The initial velocities are taken for those at the start instead of half a step before it.
    pub half_step_start: bool,
}

/// An infinite wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    pub id: u32,
    pub axis: Axis,
    /// Its coordinate on that axis, m.
    pub place: f64,
}

impl Constants {
    /// The model's constants for so many grains.
    pub fn new(model: &Model, grains: u32) -> Self {
        let ids = BodyIds {
            grains,
            walls: model.walls.len() as u32,
        };
        let walls = model.walls.iter().enumerate();
        Constants {
            law: model.law.clone(),
            normal_factor: 1.0,
            tangential_factor: 1.0,
            damping_ratio: ratio(&model.law),
            gravity: model.gravity,
            alpha: model.alpha,
            dt: model.dt,
            walls: walls
                .map(|(index, wall)| Wall {
                    id: ids.wall(index),
                    axis: wall.axis,
                    place: wall.place,
                })
                .collect(),
            ids,
            box_width: None,
            reversed_sums: false,
            half_step_start: false,
        }
    }

    /// Changes the law, and with it what was worked out of it.
    pub fn change_law(&mut self, change: impl FnOnce(&mut Law)) {
        change(&mut self.law);
        self.damping_ratio = ratio(&self.law);
    }

    /// The cheapest kernel that has every term of the law.
    pub fn kernel(&self) -> Kernel {
        Kernel::of(&self.law)
    }

    /// The contact law's rules.
    pub fn rules(&self) -> ContactRules {
        ContactRules::new(&self.law, self.dt)
    }

    /// k_n of two grains, or of a grain and a flat body (give its radius twice), N/m.
    pub fn stiffness(&self, radius1: f64, radius2: f64) -> f64 {
        let side = |radius: f64| self.law.modulus * radius;
        self.in_series(side(radius1), side(radius2)) * self.normal_factor
    }

    /// 2ab/(a + b). YADE's law with dashpots adds compliances, which rounds in another way.
    fn in_series(&self, a: f64, b: f64) -> f64 {
        if self.law.has_dashpots() {
            contact::compliances_in_series(2.0 * a, 2.0 * b)
        } else {
            contact::in_series(a, b)
        }
    }

    /// k_s of the same, N/m: two springs k_s/k_n·E·R in series.
    pub fn tangential_stiffness(&self, radius1: f64, radius2: f64) -> f64 {
        let side = |radius: f64| self.law.modulus * radius * self.law.stiffness_ratio;
        self.in_series(side(radius1), side(radius2)) * self.tangential_factor
    }

    /// The parameters of a contact with the effective mass m_eff, kg: m_1 m_2/(m_1 + m_2) of two
    /// grains, the grain's own at a wall or the punch.
    pub fn parameters(&self, radius1: f64, radius2: f64, effective_mass: f64) -> Parameters {
        let k_n = self.stiffness(radius1, radius2);
        Parameters {
            k_n,
            k_s: self.tangential_stiffness(radius1, radius2),
            c_n: match self.law.contact.viscosity {
                Viscosity::None => 0.0,
                // Each body has twice the constant, and two dashpots act in series, as in YADE.
                Viscosity::Dashpot { c_n, .. } => {
                    contact::compliances_in_series(2.0 * c_n, 2.0 * c_n)
                }
                Viscosity::Restitution { .. } => {
                    2.0 * self.damping_ratio * (effective_mass * k_n).sqrt()
                }
            },
        }
    }
}

fn ratio(law: &Law) -> f64 {
    match law.contact.viscosity {
        Viscosity::None | Viscosity::Dashpot { .. } => 0.0,
        Viscosity::Restitution { e_n, tension } => damping_ratio(e_n, tension),
    }
}
