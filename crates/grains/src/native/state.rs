//! The state of the native engine, what a step reads and changes; and the constants of a run, which it never changes.

use super::contact::{self, ContactRules, Motion, Parameters, Touch};
use crate::model::{Kernel, Law, Model, Wall};
use crate::obstacle::Obstacle;
use crate::rules::Rules;
use crate::scene::Viscosity;
use crate::tables::{Bodies, Body, BodyIds, Contact, Punch, tangential};

/// Positions, velocities and forces, a pair of components a grain. Grains stand at places in memory that neighbour lists
/// choose; whatever leaves the engine and every sum over grains is in the order of their numbers, which are their ids.
#[derive(Debug, Clone)]
pub struct State {
    /// Of the grain at each place.
    pub number: Vec<u32>,
    /// Of the grain with each number.
    pub place: Vec<u32>,
    pub position: Vec<[f64; 2]>,
    pub velocity: Vec<[f64; 2]>,
    pub force: Vec<[f64; 2]>,
    pub radius: Vec<f64>,
    pub mass: Vec<f64>,
    /// The mass of each grain twice, once for each of its components: what vector lanes divide by, kg.
    pub component_mass: Vec<[f64; 2]>,
    /// rad/s; empty for the frictionless kernel, zeros where grains do not rotate.
    pub spin: Vec<f64>,
    /// N·m; empty for the frictionless kernel.
    pub torque: Vec<f64>,
    /// kg·m²; empty where grains do not rotate.
    pub inertia: Vec<f64>,
    pub punch: Option<Punch>,
}

impl State {
    /// The state of these grains for this kernel; forces are still to be evaluated.
    pub fn new(bodies: &Bodies, punch: Option<Punch>, kernel: Kernel) -> Self {
        let pairs = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| [*a, *b]).collect();
        let numbers: Vec<u32> = (0..bodies.len() as u32).collect();
        let mut state = State {
            place: numbers.clone(),
            number: numbers,
            position: pairs(&bodies.x, &bodies.z),
            velocity: pairs(&bodies.vx, &bodies.vz),
            force: vec![[0.0; 2]; bodies.len()],
            radius: bodies.radius.clone(),
            mass: bodies.mass.clone(),
            component_mass: bodies.mass.iter().map(|mass| [*mass; 2]).collect(),
            // Kept even where nothing turns a grain in this stage.
            spin: bodies.spin.clone(),
            torque: Vec::new(),
            inertia: bodies.inertia.clone(),
            punch,
        };
        state.suit(kernel);
        state
    }

    /// Makes room for what this kernel needs; what is there stays.
    pub fn suit(&mut self, kernel: Kernel) {
        let grains = self.position.len();
        if kernel == Kernel::General {
            self.spin.resize(grains, 0.0);
            self.torque.resize(grains, 0.0);
        } else {
            self.torque.clear();
        }
    }

    /// Puts the grains at other places: to each the one of the place that is told for it.
    pub fn rearrange(&mut self, order: &[u32], spare: &mut Spare) {
        let Spare(pairs, numbers) = spare;
        let State {
            position,
            velocity,
            force,
            component_mass,
            radius,
            mass,
            spin,
            torque,
            inertia,
            ..
        } = self;
        for column in [position, velocity, force, component_mass] {
            put(column, order, pairs);
        }
        for column in [radius, mass, spin, torque, inertia] {
            put(column, order, numbers);
        }
        put(&mut self.number, order, &mut self.place);
        for (place, number) in (0..).zip(&self.number) {
            self.place[*number as usize] = place;
        }
    }

    /// Puts the grains in the order of their numbers.
    pub fn rearrange_by_number(&mut self, spare: &mut Spare) {
        if !self.number.is_sorted() {
            let order = self.place.clone();
            self.rearrange(&order, spare);
        }
    }

    /// The grains as a table.
    pub fn bodies(&self) -> Bodies {
        let components =
            |values: &[[f64; 2]], axis: usize| self.by_number(values).map(|v| v[axis]).collect();
        let column = |values: &[f64]| self.by_number(values).collect();
        Bodies {
            x: components(&self.position, 0),
            z: components(&self.position, 1),
            vx: components(&self.velocity, 0),
            vz: components(&self.velocity, 1),
            radius: column(&self.radius),
            mass: column(&self.mass),
            spin: if self.inertia.is_empty() {
                Vec::new()
            } else {
                column(&self.spin)
            },
            inertia: column(&self.inertia),
            ..Bodies::default()
        }
    }

    /// A column in the order of numbers; nothing of one that is empty.
    pub fn by_number<T: Copy>(&self, column: &[T]) -> impl Iterator<Item = T> {
        self.place
            .iter()
            .filter_map(|at| column.get(*at as usize))
            .copied()
    }

    /// Σ ½mv², then Σ ½Iω², grain by grain, J. Both engines add in this order, so a stop rule on it
    /// stops both at the same step.
    pub fn kinetic_energy(&self) -> f64 {
        let mut energy = 0.0;
        let moving = self
            .by_number(&self.mass)
            .zip(self.by_number(&self.velocity));
        for (mass, [vx, vz]) in moving {
            energy += 0.5 * mass * (vx * vx + vz * vz);
        }
        let turning = self
            .by_number(&self.inertia)
            .zip(self.by_number(&self.spin));
        for (inertia, spin) in turning {
            energy += 0.5 * inertia * (spin * spin);
        }
        energy
    }

    /// How the grain at this place moves.
    pub fn motion(&self, id: usize) -> Motion {
        Motion {
            position: self.position[id],
            velocity: self.velocity[id],
            spin: self.spin.get(id).copied().unwrap_or_default(),
        }
    }

    /// Where the grains at places `a` and `b` touch.
    pub fn grain_touch(&self, a: usize, b: usize) -> Option<Touch> {
        let (position, radius) = (&self.position, &self.radius);
        contact::grains([position[a], position[b]], [radius[a], radius[b]])
    }

    /// Where the grain at this place touches a wall.
    pub fn wall_touch(&self, wall: &Wall, id: usize) -> Option<Touch> {
        contact::wall(wall, self.position[id], self.radius[id])
    }

    /// Where the grain at this place touches the punch.
    pub fn punch_touch(&self, punch: &Punch, id: usize) -> Option<Touch> {
        contact::punch(punch, self.position[id], self.radius[id])
    }
}

/// Room for [`State::rearrange`].
#[derive(Debug, Default)]
pub struct Spare(Vec<[f64; 2]>, Vec<f64>);

fn put<T: Copy>(column: &mut Vec<T>, order: &[u32], spare: &mut Vec<T>) {
    if column.is_empty() {
        return;
    }
    spare.clear();
    spare.extend(order.iter().map(|place| column[*place as usize]));
    std::mem::swap(column, spare);
}

/// A row of the table of contacts.
pub fn contact_row(id1: u32, id2: u32, touch: &Touch, force: [f64; 2]) -> Contact {
    let [nx, nz] = touch.normal;
    let [fx, fz] = force;
    Contact {
        id1,
        id2,
        overlap: touch.overlap,
        normal_force: fx * nx + fz * nz,
        tangential_force: tangential(fz * nx - fx * nz),
        normal: touch.normal,
        point: touch.point,
    }
}

/// Constants of a run, taken from the model once.
#[derive(Debug, Clone, PartialEq)]
pub struct Constants {
    /// Moduli, angles and options of the contact law.
    pub law: Law,
    /// Conventions; with any but the usual ones the step is the written-out one.
    pub rules: Rules,
    /// What every k_n is multiplied by between grains, at walls and at the punch; 1 unless it is perturbed.
    pub normal_factors: [f64; 3],
    /// Relative change of every k_s; 1 unless it is perturbed.
    pub tangential_factor: f64,
    /// Damping ratios of the dashpots along the normal and the tangent, where a restitution or a ratio is asked for.
    pub damping_ratios: [f64; 2],
    /// m/s².
    pub gravity: [f64; 2],
    /// Cundall's α.
    pub alpha: f64,
    /// s.
    pub dt: f64,
    pub walls: Vec<Wall>,
    /// Those of any direction, where they are at the start.
    pub obstacles: Vec<Obstacle>,
    /// Ids of walls and punch.
    pub ids: BodyIds,
    /// Inner width of the box that grains must stay in, m; none where there is no box.
    pub box_width: Option<f64>,
    /// Pairs of a grain are summed from the highest partner down instead of from the lowest up.
    pub reversed_sums: bool,
    /// The initial velocities are taken for those at the start instead of half a step before it.
    pub half_step_start: bool,
}

impl Constants {
    /// The wall with this id.
    pub fn wall_of(&self, id: u32) -> &Wall {
        &self.walls[(id - self.ids.grains) as usize]
    }

    /// The id of the first obstacle; the punch's where there is none.
    pub fn first_obstacle(&self) -> u32 {
        self.ids.wall(self.walls.len())
    }

    /// The model's constants for so many grains.
    pub fn new(model: &Model, grains: u32) -> Self {
        Constants {
            law: model.law.clone(),
            rules: model.rules,
            normal_factors: [1.0; 3],
            tangential_factor: 1.0,
            damping_ratios: model.law.damping_ratios(),
            gravity: model.gravity,
            alpha: model.alpha,
            dt: model.dt,
            walls: model.walls.clone(),
            obstacles: model.obstacles.clone(),
            ids: BodyIds {
                grains,
                walls: model.walls_and_obstacles(),
            },
            box_width: None,
            reversed_sums: false,
            half_step_start: false,
        }
    }

    /// Changes the law, and with it what was worked out of it.
    pub fn change_law(&mut self, change: impl FnOnce(&mut Law)) {
        change(&mut self.law);
        self.damping_ratios = self.law.damping_ratios();
    }

    /// The cheapest kernel that has every term of the law.
    pub fn kernel(&self) -> Kernel {
        Kernel::of(&self.law)
    }

    /// The contact law's rules.
    pub fn contact_rules(&self) -> ContactRules {
        ContactRules::new(&self.law, self.dt)
    }

    /// k_n of two grains, N/m.
    pub fn stiffness(&self, radius1: f64, radius2: f64) -> f64 {
        self.normal_stiffness(Body::Grain, radius1, radius2)
    }

    /// k_n of a grain of this radius and such a flat body, N/m.
    pub fn flat_stiffness(&self, flat: Body, radius: f64) -> f64 {
        self.normal_stiffness(flat, radius, radius)
    }

    fn normal_stiffness(&self, first: Body, radius1: f64, radius2: f64) -> f64 {
        let side = |radius: f64| self.law.modulus * radius;
        self.in_series(side(radius1), side(radius2)) * self.normal_factors[first as usize]
    }

    /// Stiffness of two grains' springs k = E·R in series, N/m: 2 k_a k_b/(k_a + k_b), which for equal moduli is Eq. 4,
    /// k_n = 2E R_i R_j/(R_i + R_j). YADE's law with dashpots adds compliances, which rounds in another way.
    fn in_series(&self, a: f64, b: f64) -> f64 {
        if self.law.has_dashpots() {
            1.0 / (1.0 / (2.0 * a) + 1.0 / (2.0 * b))
        } else {
            2.0 * a * b / (a + b)
        }
    }

    /// k_s, N/m: two springs k_s/k_n·E·R in series.
    fn tangential_stiffness(&self, radius1: f64, radius2: f64) -> f64 {
        let side = |radius: f64| self.law.modulus * radius * self.law.stiffness_ratio;
        self.in_series(side(radius1), side(radius2)) * self.tangential_factor
    }

    /// The parameters of a contact of the grains at these places, the lower number first.
    pub fn of_pair(&self, state: &State, first: usize, second: usize) -> Parameters {
        let [(r1, m1), (r2, m2)] = [first, second].map(|at| (state.radius[at], state.mass[at]));
        self.parameters(Body::Grain, [r1, r2], m1 * m2 / (m1 + m2))
    }

    /// Those of such a flat body and the grain at this place.
    pub fn of_flat(&self, state: &State, flat: Body, at: usize) -> Parameters {
        self.parameters(flat, [state.radius[at]; 2], state.mass[at])
    }

    /// The parameters of a contact with the effective mass m_eff, kg: m_1 m_2/(m_1 + m_2) of two
    /// grains, the grain's own at a wall or the punch.
    fn parameters(&self, first: Body, radii: [f64; 2], effective_mass: f64) -> Parameters {
        let [radius1, radius2] = radii;
        let k_n = self.normal_stiffness(first, radius1, radius2);
        Parameters {
            k_n,
            k_s: self.tangential_stiffness(radius1, radius2),
            c_n: match self.law.contact.viscosity {
                Viscosity::None => 0.0,
                // Each body has twice the constant, and two dashpots act in series, as in YADE.
                Viscosity::Dashpot { c_n, .. } => self.in_series(c_n, c_n),
                Viscosity::Restitution { .. } | Viscosity::Ratio { .. } => {
                    2.0 * self.damping_ratios[0] * (effective_mass * k_n).sqrt()
                }
            },
        }
    }
}
