//! Two grains that collide spinning or obliquely and slide all through: the forms of Chung and Ooi's
//! tests 5, 7 and 8.

use std::f64::consts::PI;

use super::analytic::SpringDashpot;
use super::build::{self, Grain};
use super::{CaseGroup, Figures, Track, View, at};
use grains::task::Case;

/// The groups.
pub fn groups() -> Vec<CaseGroup> {
    vec![gross_sliding(), opposite_spins()]
}

/// Two grains side by side that approach each other at their centre of mass.
#[derive(Debug, Clone)]
struct Couple {
    id: String,
    grains: [Grain; 2],
    /// N/m.
    stiffness: f64,
    /// m/s.
    approach: f64,
}

const TAN_PHI: f64 = 0.2;
/// Steps in a contact time.
const STEPS: f64 = 1000.0;
/// Steps before touch.
const LEAD: f64 = 5.5;
const EQUAL: [f64; 2] = [0.01, 0.01];
const UNEQUAL: [f64; 2] = [0.01, 0.02];

impl Couple {
    /// Glass balls or discs of Chung and Ooi's test 1, with these radii, velocities across and spins.
    fn glass(id: &str, disc: bool, radii: [f64; 2], across: [f64; 2], spins: [f64; 2]) -> Self {
        let shape = if disc { Grain::disc } else { Grain::sphere };
        let of = |index: usize| {
            shape([0.0; 2], radii[index], 2800.0)
                .moving([0.0, across[index]])
                .spinning(spins[index])
        };
        // Discs one metre long weigh more: as stiff for their mass.
        let heavier = of(0).mass / Grain::sphere([0.0; 2], radii[0], 2800.0).mass;
        Couple {
            id: format!("{}/{id}", if disc { "discs" } else { "balls" }),
            grains: [of(0), of(1)],
            stiffness: heavier * 2.0 * 4.8e10 * radii[0] * radii[1] / (radii[0] + radii[1]),
            approach: 2.0,
        }
    }

    /// The contact along the line of centres at this speed.
    fn contact(&self, approach: f64) -> SpringDashpot {
        let [one, two] = self.grains.map(|grain| grain.mass);
        SpringDashpot {
            approach,
            ..SpringDashpot::spring(one * two / (one + two), self.stiffness, 0.0)
        }
    }

    fn dt(&self) -> f64 {
        PI / (self.contact(0.0).frequency() * STEPS)
    }

    fn reach(&self) -> f64 {
        self.grains[0].radius + self.grains[1].radius
    }

    /// In the middle of the contact, and when it is over.
    fn moments(&self) -> [u64; 2] {
        [
            (LEAD + 0.5 * STEPS).round() as u64,
            (LEAD + 1.02 * STEPS + 3.0).ceil() as u64,
        ]
    }

    fn case(&self) -> Case {
        let [one, two] = self.grains;
        let share = two.mass / (one.mass + two.mass);
        let distance = self.reach() + LEAD * self.dt() * self.approach;
        let placed = |grain: Grain, x: f64, speed: f64| {
            grain.at([x, 0.0]).moving([speed, grain.velocity[1]])
        };
        let grains = [
            placed(one, 0.0, share * self.approach),
            placed(two, distance, (share - 1.0) * self.approach),
        ];
        let modulus = self.stiffness * self.reach() / (2.0 * one.radius * two.radius);
        let law = build::friction(modulus, 0.8, TAN_PHI.atan());
        let [middle, end] = self.moments();
        let model = build::model(law, self.dt());
        build::case(&self.id, model, &grains, vec![0, middle, end])
    }

    /// What rounding may do to a velocity or spin, as a share of it.
    fn rounding(&self) -> f64 {
        2.0 * self.moments()[1] as f64 * f64::EPSILON
    }

    /// Velocity across of the surface of the second grain against that of the first, before touch, m/s.
    fn slip(&self) -> f64 {
        let [one, two] = self.grains;
        let turning = one.spin * one.radius + two.spin * two.radius;
        two.velocity[1] - one.velocity[1] + turning
    }

    /// How fast the grains pass each other at most, before or after the impact, m/s.
    fn passing(&self) -> f64 {
        let before = (self.grains[1].velocity[1] - self.grains[0].velocity[1]).abs();
        before.max((before - 2.0 * TAN_PHI * self.approach * self.slip().signum()).abs())
    }

    /// How far the line of centres turns while the grains touch, rad, at most.
    fn turn(&self) -> f64 {
        STEPS * self.dt() * self.passing() / self.reach()
    }

    /// Components of a vector along the line of centres in the middle of the contact, and across.
    fn components(&self, track: &Track, of: [f64; 2]) -> [f64; 2] {
        let middle = at(track, self.moments()[0]);
        let (one, two) = (middle.position(0), middle.position(1));
        let (x, z) = (two[0] - one[0], two[1] - one[1]);
        let length = x.hypot(z);
        [
            (of[0] * x + of[1] * z) / length,
            (of[1] * x - of[0] * z) / length,
        ]
    }

    /// Momentum of both grains and angular momentum about the origin, Σ m z v_x − m x v_z + Iω. The scheme
    /// keeps all three, with velocities of half a step before the positions.
    fn momenta(&self, view: View) -> [f64; 3] {
        let of = |id: usize| {
            let ([x, z], [vx, vz]) = (view.position(id), view.velocity(id));
            let Grain { mass, inertia, .. } = self.grains[id];
            let angular = mass * (z * vx - x * vz) + inertia * view.spin(id);
            [mass * vx, mass * vz, angular]
        };
        let (one, two) = (of(0), of(1));
        [0, 1, 2].map(|index| one[index] + two[index])
    }

    /// Impulses and turns along the line of centres in the middle of the contact.
    fn impulses(&self, track: &Track, figures: &mut Figures) {
        let start = at(track, 0);
        let (one, two) = (start.velocity(0), start.velocity(1));
        let [approach, _] = self.components(track, [one[0] - two[0], one[1] - two[1]]);
        let contact = self.contact(approach);
        let end = at(track, self.moments()[1]);
        let (before, after) = (start.velocity(1), end.velocity(1));
        let push = [0, 1].map(|axis| self.grains[1].mass * (after[axis] - before[axis]));
        let [normal, tangential] = self.components(track, push);
        let turn = self.turn();
        let small = turn * turn + (PI / STEPS).powi(2);
        let of_normal = 0.25 * turn * self.passing() / self.approach + small;
        let impulse = 2.0 * contact.mass * contact.approach;
        figures.because(
            "the mean normal of the contact is a quarter of its turn off the middle one at most; \
             second order in turn and step",
        );
        let what = "tangential-impulse: tangential over normal impulse, 1";
        let ratio = tangential.abs() / normal;
        figures.is(what, ratio, TAN_PHI, 0.25 * turn + small);
        figures.because(
            "a quarter of the turn of the normal times passing over approach speed; second order in turn \
             and step",
        );
        let what = "normal-impulse: normal impulse over 2 m_eff v, 1";
        figures.is(what, normal / impulse, 1.0, of_normal);
        // Both grains are turned by μJ at the arms R − u/2.
        figures.because("as the normal impulse");
        for (id, grain) in self.grains.iter().enumerate() {
            let turning = grain.radius * impulse - 0.5 * contact.overlap_impulse();
            let expected = -self.slip().signum() * TAN_PHI * turning / grain.inertia;
            let what = format!("spin-change-{0}: change of spin {0}, rad/s", id + 1);
            let off = expected.abs() * of_normal;
            figures.is(&what, end.spin(id) - grain.spin, expected, off);
        }
    }

    fn conservation(&self, track: &Track, figures: &mut Figures) {
        let [before, after] = [0, self.moments()[1]].map(|step| self.momenta(at(track, step)));
        let momentum = |grain: &Grain| grain.mass * (self.approach + grain.velocity[1].abs());
        let angular =
            |grain: &Grain| self.reach() * momentum(grain) + grain.inertia * grain.spin.abs();
        let angular: f64 = self.grains.iter().map(angular).sum();
        let momentum: f64 = self.grains.iter().map(momentum).sum();
        figures.because("the scheme keeps it; rounding in every step");
        for (index, (what, scale)) in [
            ("momentum-across, N·s", momentum),
            ("momentum-up, N·s", momentum),
            ("angular-momentum, N·m·s", angular),
        ]
        .into_iter()
        .enumerate()
        {
            let off = scale * self.rounding();
            figures.is(what, after[index], before[index], off);
        }
    }
}

fn gross_sliding() -> CaseGroup {
    let mut group = CaseGroup::new(
        "gross-sliding-pair",
        "Chung and Ooi 5 and 8 for a linear spring: two grains slide on each other, momenta are kept",
    );
    for (id, radii, across, spins) in [
        ("equal-oblique", EQUAL, [-2.0, 2.0], [0.0; 2]),
        ("equal-spins", EQUAL, [0.0; 2], [300.0, 300.0]),
        ("unequal-one-spins", UNEQUAL, [0.0; 2], [500.0, 0.0]),
        (
            "unequal-oblique-and-spinning",
            UNEQUAL,
            [1.0, -2.0],
            [-200.0, 50.0],
        ),
    ] {
        for disc in [false, true] {
            let of = Couple::glass(id, disc, radii, across, spins);
            group = group.with([of.case()], move |tracks| {
                let mut figures = Figures::of(&of.id);
                of.impulses(&tracks[0], &mut figures);
                of.conservation(&tracks[0], &mut figures);
                figures.done()
            });
        }
    }
    group
}

/// Spins of opposite sign and equal surface speed.
fn opposite_spins() -> CaseGroup {
    let mut group = CaseGroup::new(
        "opposite-spins",
        "Chung and Ooi 7: surfaces that run alike do not rub, spins stay",
    );
    for (id, radii, spins) in [
        ("equal", EQUAL, [300.0, -300.0]),
        ("one-twice-as-large", UNEQUAL, [300.0, -150.0]),
    ] {
        for disc in [false, true] {
            let of = Couple::glass(id, disc, radii, [0.0; 2], spins);
            group = group.with([of.case()], move |tracks| {
                let end = at(&tracks[0], of.moments()[1]);
                let mut figures = Figures::of(&of.id);
                figures.because("no slip, no tangential force; rounding in every step");
                for (id, grain) in of.grains.iter().enumerate() {
                    let off = grain.spin.abs() * of.rounding();
                    let number = id + 1;
                    let what = format!("spin-{number}, rad/s");
                    figures.is(&what, end.spin(id), grain.spin, off);
                    let what = format!("velocity-{number}-across: velocity {number} across, m/s");
                    let across = end.velocity(id)[1];
                    figures.is(&what, across, 0.0, of.approach * of.rounding());
                }
                figures.done()
            });
        }
    }
    group
}
