//! What is left over of velocities, spins and places after a step, by the forces that an engine wrote before it.

use grains::rules::{
    DampedGravity, DampedSpins, DampingComponents, DampingVelocity, GivenVelocities, Integration,
};
use grains::tables::Snapshot;
use grains::vector::{Vector, each, hypot, minus, plus, sum, times};

use super::residuals::{Follower, Loads};
use super::seen::Damped;
use super::{
    NONE, OF_MARKED, Of, PLACES, ROUNDED, Row, Rows, SPINS, SPINS_FIRST_NEAR_LIMIT,
    SPINS_NEAR_LIMIT, Term, VELOCITIES,
};

/// A force is known so many times better than what local damping makes of it.
const CLEAR: f64 = 1.0e3;

impl Follower<'_> {
    /// Velocities, spins and places after a step, from the forces that are written before it.
    pub(super) fn motion(
        &mut self,
        (was, now): (&Snapshot, &Snapshot),
        (loads, before): (&[Loads], Option<&[Loads]>),
        at: usize,
        rows: &mut Rows,
    ) {
        let model = &self.case.model;
        let rules = model.law.resolved(model.rules);
        let first_is_half = rules.given_velocities != GivenVelocities::HalfStepBefore && at == 1;
        let plain = rules.damping_velocity == DampingVelocity::Middle
            && rules.damped_gravity == DampedGravity::Damped
            && rules.damping_components == DampingComponents::Each;
        if now.step != was.step + 1 || first_is_half || !(plain || model.alpha == 0.0) {
            return;
        }
        let (dt, bodies) = (model.dt, &self.case.bodies);
        let (damped, kept) = (&mut self.seen.damped, &mut self.kept);
        let before_this = std::mem::take(&mut self.was_off);
        let was_off = &mut self.was_off;
        // In the first step nothing was off; where it is not known how far, what it is off by now is not either.
        let off_before = |quantity: usize, id: usize| match before_this.get(&(quantity, id)) {
            None if at == 1 => Some(NONE),
            known => known.copied(),
        };
        for (id, load) in loads.iter().enumerate() {
            let (mass, radius) = (bodies.mass[id], bodies.radius[id]);
            let mut add = |quantity: usize, off: Vector, least: f64, terms: Vec<Term>| {
                // A program may read the numbers of another one.
                let (before, after) = (id.saturating_sub(1), (id + 1).min(bodies.len() - 1));
                let of_others = |numbers: &[f64], [own, of_before, of_after]: [&'static str; 3]| {
                    [(own, id), (of_before, before), (of_after, after)]
                        .map(|(name, id)| (name, numbers[id]))
                };
                let masses = [
                    "m",
                    "m of the grain with the id before it",
                    "m of the grain with the id after it",
                ];
                let inertias = [
                    "I",
                    "I of the grain with the id before it",
                    "I of the grain with the id after it",
                ];
                let mut sizes = Vec::new();
                if ![VELOCITIES, PLACES].contains(&quantity) {
                    sizes.extend(of_others(&bodies.inertia, inertias));
                }
                sizes.extend(of_others(&bodies.mass, masses));
                sizes.push(("R", radius));
                sizes.push(("the speed before the step", hypot(was.bodies.velocity(id))));
                if !bodies.inertia.is_empty() {
                    sizes.push((
                        "the spin before the step",
                        hypot(was.bodies.angular_velocity(id)),
                    ));
                }
                let mut row = Row {
                    at: (self.run, at),
                    subject: Of::Grain(id),
                    off,
                    least,
                    terms,
                    sizes,
                    marks: load.marks,
                    between: String::new(),
                    elsewhere: Vec::new(),
                };
                if quantity != PLACES && kept.takes((quantity, 0), &row) {
                    row.elsewhere
                        .clone_from(&load.elsewhere[usize::from(quantity != VELOCITIES)]);
                }
                rows.entry((quantity, 0)).or_default().push(row);
            };
            let [x0, x1] = [was, now].map(|moment| moment.bodies.position(id));
            let [v0, v1] = [was, now].map(|moment| moment.bodies.velocity(id));
            if rules.integration == Integration::KickDrift {
                let gone = times(1.0 / dt, minus(x1, x0));
                let least =
                    ROUNDED * hypot(v1).max(hypot(gone)) + 4.0 * f64::EPSILON * hypot(x1) / dt;
                add(
                    PLACES,
                    minus(gone, v1),
                    least,
                    terms! {
                        "Δt·v after the kick", 1.0 => v1;
                        "the kick of this step in Δt·v", 1.0 => minus(v1, v0);
                        "Δt·v before the kick", 0.0 => v0;
                    },
                );
            }
            // The acceleration before local damping, from the change after it: of both signs the one that it follows from.
            let undamped = |change: Vector, before: Vector, is_damped: bool| {
                each([0, 1, 2], |axis| {
                    let a = change[axis] / dt;
                    let acceleration = |sign: f64| a / (1.0 - model.alpha * sign);
                    let follows = |sign: &f64| {
                        sign * acceleration(*sign) * (before[axis] + 0.5 * dt * acceleration(*sign))
                            > 0.0
                    };
                    // Where both do, nothing is known.
                    match [1.0, -1.0].map(|sign| follows(&sign)) {
                        _ if !is_damped || model.alpha == 0.0 => (a, 0.0),
                        [true, true] => (f64::NAN, 0.0),
                        [true, false] => (acceleration(1.0), 1.0),
                        [false, true] => (acceleration(-1.0), -1.0),
                        [false, false] => (a, 0.0),
                    }
                })
            };
            let damping = |acting: Vector, signs: Vector, axes: &[usize]| {
                each([0, 1, 2], |axis| {
                    let share = model.alpha * signs[axis];
                    acting[axis] * share / (1.0 - share) * f64::from(u8::from(axes.contains(&axis)))
                })
            };
            let weight = times(mass, [model.gravity[0], 0.0, model.gravity[1]]);
            let of_kind =
                |kind: usize| plus(load.kinds[kind].forces[0], load.kinds[kind].forces[1]);
            let forces = load.force();
            let acting = plus(forces, weight);
            let a = undamped(minus(v1, v0), v0, true);
            let (gained, signs) = (times(mass, a.map(|a| a.0)), a.map(|a| a.1));
            let largest = load
                .kinds
                .iter()
                .flat_map(|kind| kind.forces)
                .map(hypot)
                .fold(hypot(weight), f64::max);
            let least =
                ROUNDED * largest + 4.0 * f64::EPSILON * mass * hypot(v1).max(hypot(v0)) / dt;
            if let (true, Some(before)) = (model.alpha != 0.0, before) {
                let before = before[id].force();
                let forces = [acting, forces, weight, plus(before, weight), before];
                let is_clear = |axis: &usize| model.alpha * acting[*axis].abs() > CLEAR * least;
                damped.extend([0, 1, 2].into_iter().filter(is_clear).map(|axis| {
                    let (force, gained) = (acting[axis], mass * (v1[axis] - v0[axis]) / dt);
                    let mut signs = [1.0, -1.0, 0.0].into_iter();
                    let is_so =
                        |sign: &f64| (gained - force * (1.0 - model.alpha * sign)).abs() <= least;
                    let middle = plus(v0, times(0.5 * dt / mass, acting));
                    let beside = [id.saturating_sub(1), (id + 1).min(bodies.len() - 1)];
                    let [before, after] = beside.map(|id| was.bodies.velocity(id)[axis]);
                    let ([x, y, z], [of_x, of_y, of_z]) = (middle, v0);
                    let velocities = [
                        middle[axis],
                        v0[axis],
                        v1[axis],
                        x,
                        y,
                        z,
                        of_x,
                        of_y,
                        of_z,
                        before,
                        after,
                    ];
                    Damped {
                        axis,
                        sign: signs.find(is_so),
                        by: forces.map(|force| velocities.map(|velocity| force[axis] * velocity)),
                    }
                }));
            }
            let of_marked = |which: usize| {
                let marked = OF_MARKED.iter().zip(&load.marked);
                marked.map(move |(words, sums)| (words[which], 1.0, sums[which]))
            };
            let mut terms: Vec<Term> = terms! {
                "all contact forces", 1.0 => forces;
                "the weight", 1.0 => weight;
                "normal forces", 1.0 => sum(load.kinds.map(|kind| kind.forces[0]));
                "tangential forces", 1.0 => sum(load.kinds.map(|kind| kind.forces[1]));
                "forces on the first of a pair", 1.0 => of_kind(0);
                "forces on the second of a pair", 1.0 => of_kind(1);
                "forces of walls", 1.0 => of_kind(2);
                "forces of the punch", 1.0 => of_kind(3);
                "tangential forces of walls", 1.0 => load.kinds[2].forces[1];
                "tangential forces of the punch", 1.0 => load.kinds[3].forces[1];
                "tangential forces on the first of a pair", 1.0 => load.kinds[0].forces[1];
                "tangential forces on the second of a pair", 1.0 => load.kinds[1].forces[1];
                "the normal dashpots' forces", 1.0 => load.dashpots[0];
                "the tangential dashpots' forces", 1.0 => load.dashpots[1];
                "local damping", -1.0 => damping(acting, signs, &[0, 1, 2]);
                "local damping along x", -1.0 => damping(acting, signs, &[0]);
                "local damping along y", -1.0 => damping(acting, signs, &[1]);
                "local damping along z", -1.0 => damping(acting, signs, &[2]);
                "contact forces of the step before", 0.0 => before.map_or(NONE, |before| before[id].force());
                "m·v/Δt", 0.0 => times(mass / dt, v0);
                "all contact forces and the weight", 1.0 => acting;
                "what it was off by in the step before", 0.0 => off_before(VELOCITIES, id).unwrap_or(NONE);
            };
            terms.extend(of_marked(0));
            if gained.iter().all(|component| component.is_finite()) {
                let off = minus(gained, acting);
                was_off.insert((VELOCITIES, id), off);
                if off_before(VELOCITIES, id).is_some() {
                    add(VELOCITIES, off, least, terms);
                }
            }
            if !model.law.rotates() || self.forgets_moments {
                continue;
            }
            let [w0, w1] = [was, now].map(|moment| moment.bodies.angular_velocity(id));
            let inertia = bodies.inertia[id];
            let is_damped = rules.damped_spins == DampedSpins::Damped;
            let torque = plus(load.torque(), plus(load.moments[0], load.moments[1]));
            let a = undamped(minus(w1, w0), w0, is_damped);
            let (gained, signs) = (times(inertia, a.map(|a| a.0)), a.map(|a| a.1));
            let largest = load
                .kinds
                .iter()
                .map(|kind| hypot(kind.torque))
                .chain(load.moments.map(hypot));
            let least = ROUNDED * largest.fold(radius * 1.0e-6 * hypot(weight), f64::max)
                + 4.0 * f64::EPSILON * inertia * hypot(w1).max(hypot(w0)) / dt;
            let of_kind = |kind: usize| load.kinds[kind].torque;
            let all_before = before.map_or(NONE, |before| {
                let before = &before[id];
                sum([before.torque(), before.moments[0], before.moments[1]])
            });
            let mut terms: Vec<Term> = terms! {
                "all torques of forces", 1.0 => load.torque();
                "moments against rolling", 1.0 => load.moments[0];
                "moments against twisting", 1.0 => load.moments[1];
                "moments against rolling on the first of a pair", 1.0 => load.moments_on_first[0];
                "moments against twisting on the first of a pair", 1.0 => load.moments_on_first[1];
                "moments against rolling at walls", 1.0 => load.moments_at_walls[0];
                "moments against twisting at walls", 1.0 => load.moments_at_walls[1];
                "moments against rolling at their limit", 1.0 => load.limited;
                "moments against rolling without a limit", 0.0 => load.without_limit;
                "moments against rolling with a limit of each component by itself", 0.0 => load.by_component;
                "moments against the rolling of the first's spin alone", 0.0 => load.rolling_alone[0];
                "moments against the rolling of the second's spin alone", 0.0 => load.rolling_alone[1];
                "the twist with the stiffness against rolling", 0.0 => load.twist_as_rolling;
                "what this step adds to moments against rolling", 0.0 => load.added[0];
                "what this step adds to moments against twisting", 0.0 => load.added[1];
                "moments of the step before", 0.0 => before.map_or(NONE, |before| {
                    plus(before[id].moments[0], before[id].moments[1])
                });
                "torques on the first of a pair", 1.0 => of_kind(0);
                "torques on the second of a pair", 1.0 => of_kind(1);
                "torques at walls", 1.0 => of_kind(2);
                "torques at the punch", 1.0 => of_kind(3);
                "the tangential dashpots' torques", 1.0 => load.braking;
                "the tangential force times u/2, of grains,", 0.0 => load.half[0];
                "the tangential force times u/2, at walls,", 0.0 => load.half[1];
                "the tangential force times u/2, at the punch,", 0.0 => load.half[2];
                "the torques of what Coulomb's limit cuts", 0.0 => load.cut;
                "torques of the step before", 0.0 => before.map_or(NONE, |before| before[id].torque());
                "what the other grain's arm gives it more than its own", 0.0 => load.others[0];
                "what the first one's arm gives the second more than its own", 0.0 => load.others[1];
                "R·(normal force) against the spin", 0.0 => load.rolling;
                "local damping of spins", -1.0 => damping(torque, signs, &[0, 1, 2]);
                "I·ω/Δt", 0.0 => times(inertia / dt, w0);
                "torques that the forces of the step before have by this step's arms", 0.0 => load.late;
                "what is kept of moments against rolling", 1.0 => load.kept[0];
                "what is kept of moments against twisting", 1.0 => load.kept[1];
                "what moments against rolling would keep of those against twisting", 0.0 => load.exchanged[0];
                "what moments against twisting would keep of those against rolling", 0.0 => load.exchanged[1];
                "all torques and moments", 1.0 => torque;
                "torques and moments of the step before about x", 0.0 => [all_before[0], 0.0, 0.0];
                "torques and moments of the step before about y", 0.0 => [0.0, all_before[1], 0.0];
                "torques and moments of the step before about z", 0.0 => [0.0, 0.0, all_before[2]];
                "what it was off by in the step before", 0.0 => off_before(SPINS, id).unwrap_or(NONE);
            };
            terms.extend(of_marked(1));
            if gained.iter().all(|component| component.is_finite()) {
                let quantity = match (load.near_limit, load.was_beyond_limit) {
                    (false, _) => SPINS,
                    (true, false) => SPINS_FIRST_NEAR_LIMIT,
                    (true, true) => SPINS_NEAR_LIMIT,
                };
                let off = minus(gained, torque);
                was_off.insert((SPINS, id), off);
                if off_before(SPINS, id).is_some() {
                    add(quantity, off, least, terms);
                }
            }
        }
    }
}
