//! A grain that touches a wall obliquely or spinning: it slides all through, or its tangential spring holds.

use super::analytic::{ROUNDING, SpringDashpot, State, random_rounding, rounding_of_phase};
use super::collisions::HeadOn;
use crate::suite::{self, CaseGroup, Figures, Grain, Track, at, furthest};
use grains::model::Law;
use grains::scene::{NewContactSlip, Tension};
use grains::task::Case;

pub fn groups() -> Vec<CaseGroup> {
    vec![
        mfix(),
        spinning(
            "gross-sliding",
            "Impacts that slide all through, with spin along and against the way, arms of both laws",
            &[
                ("no-spin", 2.0, 0.0),
                ("spin-against", 2.0, -150.0),
                ("spin-along", 2.0, 80.0),
                ("overtaken-by-its-spin", 0.5, 250.0),
            ],
        ),
        spinning(
            "spin-impact",
            "A spinning ball or disc that falls on a wall is thrown aside",
            &[
                ("spin-to-the-right", 0.0, 200.0),
                ("spin-to-the-left", 0.0, -200.0),
            ],
        ),
        recurrence(),
        sticking(),
        first_slip(
            "first-slip",
            "A new contact is given the slip of the whole step in which it was made",
            NewContactSlip::WholeStep,
        ),
        first_slip(
            "first-slip-since-touch",
            "A new contact is given the slip since the surfaces met",
            NewContactSlip::SinceTouch,
        ),
    ]
}

/// What makes a grain of a centre, a radius and a density.
type Shape = fn([f64; 2], f64, f64) -> Grain;

const SHAPES: [(&str, Shape); 2] = [("ball", Grain::sphere), ("disc", Grain::disc)];

/// Where a contact's force acts, and the slip that goes with it.
#[derive(Debug, Clone, Copy)]
pub struct Arms {
    pub id: &'static str,
    /// The share of the overlap that the arm is shorter than the radius.
    pub shortening: f64,
    /// The law with these arms.
    pub law: fn(Law) -> Law,
}

/// Slip without ratcheting.
pub const HALF_OVERLAP: Arms = Arms {
    id: "half-overlap",
    shortening: 0.5,
    law: |law| law,
};

pub const CONTACT_POINT: Arms = Arms {
    id: "contact-point",
    shortening: 1.0,
    law: suite::at_contact_point,
};

/// A grain that hits a wall and slides on it all through.
#[derive(Debug, Clone)]
struct Slide {
    /// Across the wall; the grain moves to the right. With a dashpot, the arms end at the contact point.
    impact: HeadOn,
    /// k_s/k_n.
    ratio: f64,
    tan_phi: f64,
    arms: Arms,
}

impl Slide {
    /// Without a dashpot.
    fn new(id: String, grain: Grain, arms: Arms, k_n: f64, [ratio, tan_phi]: [f64; 2]) -> Self {
        let mut impact = HeadOn::new(id, grain, None, k_n, -grain.velocity[1]);
        impact.lead = 5.5;
        Slide {
            impact,
            ratio,
            tan_phi,
            arms,
        }
    }

    /// With a clipped dashpot of this ζ.
    fn damped(mut self, ratio: f64) -> Self {
        self.impact.viscosity = self.impact.damped(ratio, Tension::Clipped);
        self
    }

    /// A step by which the contact is over.
    fn end(&self) -> u64 {
        self.impact.end(self.impact.contact().release().parted())
    }

    /// Velocity along the wall and spin that follow from the impulse J = ∫N dt and from ∫u N dt: the
    /// tangential impulse is μJ and acts at the arm R − s·u, against the slip of the surface.
    fn sliding(&self, impulse: f64, overlap_impulse: f64) -> [f64; 2] {
        let grain = self.impact.grain;
        let friction = (grain.velocity[0] - grain.radius * grain.spin).signum() * self.tan_phi;
        let turning = grain.radius * impulse - self.arms.shortening * overlap_impulse;
        let velocity = grain.velocity[0] - friction * impulse / grain.mass;
        [velocity, grain.spin + friction * turning / grain.inertia]
    }

    /// The same in continuous time: J = m(1+e)v.
    fn expected(&self) -> [f64; 2] {
        let contact = self.impact.contact();
        let impulse = contact.mass * (contact.approach + contact.release().speed);
        self.sliding(impulse, contact.overlap_impulse())
    }

    /// How far velocity and spin may be off that: the impulse, as touch and parting fall into the middle
    /// between two steps, by (ω dt)⁴, and with a dashpot, which lags by half a step and so acts on a mass
    /// smaller by ½c dt, by twice ¼|ln e|·c dt/m; the overlap by (ω dt)² and c dt/m. And rounding.
    fn tolerances(&self) -> [f64; 2] {
        let contact = self.impact.contact();
        let (angle, share) = (self.impact.angle(), contact.share());
        let rebound = contact.release().speed / contact.approach;
        let reach = self.impact.floor() + self.impact.grain.radius;
        let rounding = random_rounding(self.end(), reach, contact.approach / contact.frequency());
        let of_impulse = angle.powi(4) + 0.5 * rebound.ln().abs() * share + rounding;
        let impulse = contact.mass * (1.0 + rebound) * contact.approach * of_impulse;
        let shortening = self.arms.shortening * contact.overlap_impulse() * (angle * angle + share);
        let grain = self.impact.grain;
        let turning = grain.radius * impulse + shortening;
        let [push, turn] = [impulse, turning].map(|normal| self.tan_phi * normal);
        [push / grain.mass, turn / grain.inertia]
    }

    fn case(&self, moments: Vec<u64>) -> Case {
        let angle = self.tan_phi.atan();
        let law = |modulus| (self.arms.law)(suite::friction(modulus, self.ratio, angle));
        self.impact.case_of(law, moments)
    }

    /// Velocity along the wall and spin at the end.
    fn seen(&self, track: &Track) -> [f64; 2] {
        let end = at(track, self.end());
        [end.velocity(0)[0], end.spin(0)]
    }

    /// Adds the experiment, judged by velocity along the wall and spin after it, and by what `more` says.
    fn add_to(
        self,
        group: CaseGroup,
        more: impl Fn(&Slide, &Track, &mut Figures) + Send + Sync + 'static,
    ) -> CaseGroup {
        group.with(self.impact.id.clone(), self.case(vec![self.end()]), move |track, figures| {
            let ([velocity, spin], [of_velocity, of_spin]) = (self.seen(track), self.expected());
            let [off, off_turning] = self.tolerances();
            figures.because(
                "of the change: (ω dt)⁴, as touch and parting fall between two steps, ½|ln e| c dt/m with a \
                 dashpot, and rounding",
            );
            let what = "velocity: velocity along the wall, m/s";
            figures.is(what, velocity, of_velocity, off);
            figures.because("as the velocity; and (ω dt)² + c dt/m of what the overlap takes from the arm");
            figures.is("spin, rad/s", spin, of_spin, off_turning);
            more(&self, track, figures);
        })
    }
}

/// So fast towards the wall at this angle from its normal, in degrees.
fn at_angle(speed: f64, degrees: f64) -> [f64; 2] {
    let angle = degrees.to_radians();
    [speed * angle.sin(), -speed * angle.cos()]
}

/// DEM05 of MFiX's verification manual, with the values printed there: balls of 5 mm at 3.9 m/s, μ = 0.092,
/// e = 1. Angles are from the normal.
fn mfix() -> CaseGroup {
    /// Steps in a contact time of the published runs: what MFiX takes where it is not told.
    const PUBLISHED_STEPS: f64 = 50.0;
    let title = "MFiX DEM05: oblique impacts that slide all through, ball and disc";
    let mut group = CaseGroup::new("oblique-impact", title);
    for (angle, restitution, spin) in [
        (30.0, 0.6813, None),
        (45.0, 0.8160, Some(505.75)),
        (60.0, 0.8938, Some(357.95)),
    ] {
        for (what, shape) in SHAPES {
            let grain = shape([0.0; 2], 2.5e-3, 4000.0);
            let ball = Grain::sphere([0.0; 2], 2.5e-3, 4000.0);
            let id = format!("{what}/{angle}-degrees");
            let grain = grain.moving(at_angle(3.9, angle));
            // A disc one metre long weighs more: as stiff for its mass.
            let stiffness = 1.72e7 * grain.mass / ball.mass;
            let slide = Slide::new(id, grain, CONTACT_POINT, stiffness, [1.48 / 1.72, 0.092]);
            group = slide.add_to(group, move |slide, track, figures| {
                if what != "ball" {
                    return;
                }
                let [velocity, found] = slide.seen(track);
                let found_restitution = velocity / slide.impact.grain.velocity[0];
                figures.because(
                    "rounding of the printed value; gross sliding does not feel the published run's steps",
                );
                let what = "published-restitution: tangential restitution as published, 1";
                figures.is(what, found_restitution, restitution, 0.5e-4);
                figures.because(
                    "rounding of the printed value; steps of 1/50 of the contact time in the published run, one at \
                     touch and one at parting, in what the overlap takes from the arm",
                );
                if let Some(published) = spin {
                    // What the overlap takes from the arm is all in the spin that feels the steps.
                    let shortened =
                        slide.tan_phi * slide.impact.contact().overlap_impulse() / slide.impact.grain.inertia;
                    let off = 0.5e-2 + 2.0 * shortened / PUBLISHED_STEPS;
                    let what = "published-spin: spin as published, rad/s";
                    figures.is(what, found, published, off);
                }
            });
        }
    }
    group
}

/// Aluminium alloy with a velocity and a spin, as long as it lasts sliding faster than friction can
/// stop, with arms of both laws; speeds are our own.
fn spinning(id: &'static str, title: &'static str, motions: &[(&str, f64, f64)]) -> CaseGroup {
    let mut group = CaseGroup::new(id, title);
    for (what, shape) in SHAPES {
        for arms in [HALF_OVERLAP, CONTACT_POINT] {
            for (how, velocity, spin) in motions {
                let id = format!("{what}/{how}/{}", arms.id);
                let grain = shape([0.0; 2], 0.01, 2699.0);
                let grain = grain.moving([*velocity, -0.5]).spinning(*spin);
                let slide = Slide::new(id, grain, arms, 7.0e10 * grain.radius, [0.8, 0.3]);
                group = slide.add_to(group, |_, _, _| ());
            }
        }
    }
    group
}

/// Sliding as the scheme has it: in every step the tangential force is tan φ of the normal one, so the changes of velocity are,
/// whatever the step. ∫N dt and ∫u N dt are sums over its steps.
fn recurrence() -> CaseGroup {
    let title = "Sliding contacts push along by tan φ of what they push apart, to rounding";
    let mut group = CaseGroup::new("leapfrog-sliding", title);
    let ball = Grain::sphere([0.0; 2], 0.01, 5.0e4);
    let disc = Grain::disc([0.0; 2], 0.01, 2000.0);
    for (id, grain, arms, damping_ratio) in [
        ("ball/half-overlap", ball, HALF_OVERLAP, 0.0),
        ("disc/contact-point", disc, CONTACT_POINT, 0.0),
        ("disc/dashpot", disc, CONTACT_POINT, 0.2),
    ] {
        let stiffness = 3.0e5;
        let speed = 0.2 * grain.radius * (stiffness / grain.mass).sqrt();
        let spin = -8.0 * speed / grain.radius;
        let grain = grain.moving([0.0, -speed]).spinning(spin);
        let mut slide = Slide::new(id.to_owned(), grain, arms, stiffness, [0.7, 0.4]);
        slide.impact.steps = 100.0;
        if damping_ratio != 0.0 {
            slide = slide.damped(damping_ratio);
        }
        let case = slide.case(vec![0, slide.end()]);
        group = group.with(slide.impact.id.clone(), case, move |track, figures| {
            let contact = slide.impact.contact();
            let last = slide.end();
            let states = contact.track(slide.impact.start(), &(0..last).collect::<Vec<u64>>());
            let normal = |state: &State| slide.impact.dt() * contact.force(state);
            let impulse: f64 = states.iter().map(normal).sum();
            let overlaps = states.iter().map(|state| state.overlap * normal(state));
            let [_, of_spin] = slide.sliding(impulse, overlaps.sum());
            let start = at(track, 0).velocity(0);
            let end = at(track, last).velocity(0);
            let [_, spin] = slide.seen(track);
            let amplitude = contact.approach / contact.frequency();
            let off = random_rounding(last, 1.5 * grain.radius, amplitude);
            figures.because(
                "true of every step that slides; rounding of two velocities in every step",
            );
            let found = (end[0] - start[0]).abs() / (end[1] - start[1]);
            let of_ratio = slide.tan_phi * 2.0 * f64::EPSILON * last as f64;
            let what = "push: change of velocity along the wall over that across, 1";
            figures.is(what, found, slide.tan_phi, of_ratio);
            figures.because(ROUNDING);
            let expected = impulse / grain.mass - contact.approach;
            let what = "rebound: velocity across after the impact, m/s";
            figures.is(what, end[1], expected, contact.approach * off);
            figures.is("spin, rad/s", spin, of_spin, grain.spin.abs() * off);
        });
    }
    group
}

/// A grain that rests on a floor and rocks on its tangential spring, below Coulomb's limit.
///
/// The force S along the floor obeys S_n = S_{n−1} − k_s σ_{n−1/2} dt with the slip rate σ, and changes the slip
/// rate by Γ S dt, Γ = a/m + bR′/I. So S is the recurrence of a spring of stiffness k_s on the mass 1/Γ.
/// Corrected slip has a = 2R/(2R − u), R′ = R and the arm b = R − u/2; the contact point a = 1,
/// R′ = b = R − u.
struct Rocking {
    grain: Grain,
    /// Slip rate per velocity along the floor, a.
    of_velocity: f64,
    /// Arm of the force, b, m.
    arm: f64,
    /// Γ, 1/kg.
    mobility: f64,
    /// k_n, N/m; the weight rests on it: k_n u = mg.
    stiffness: f64,
}

impl Rocking {
    const GRAVITY: f64 = 9.81;
    /// k_s/k_n.
    const RATIO: f64 = 0.6;
    /// Velocity along the floor at the start, m/s; small enough that nothing slides.
    const SPEED: f64 = 0.02;
    /// k_s Γ dt² = 4 sin²(θ/2) with about 30 steps in a swing.
    const ANGLE: f64 = 0.2;

    fn new(grain: Grain, arms: Arms) -> Self {
        let (radius, overlap) = (grain.radius, 0.1 * grain.radius);
        let stretch = 2.0 * radius / (2.0 * radius - overlap);
        let arm = radius - arms.shortening * overlap;
        let (of_velocity, of_spin) = match arms.shortening {
            1.0 => (1.0, arm),
            _ => (stretch, radius),
        };
        Rocking {
            grain,
            of_velocity,
            arm,
            mobility: of_velocity / grain.mass + arm * of_spin / grain.inertia,
            stiffness: grain.mass * Self::GRAVITY / overlap,
        }
    }

    fn tangential(&self) -> f64 {
        Self::RATIO * self.stiffness
    }

    fn dt(&self) -> f64 {
        2.0 * (0.5 * Self::ANGLE).sin() / (self.tangential() * self.mobility).sqrt()
    }

    /// The slip −S/k_s as a swing. At the start the contact is new and given the slip of one step.
    fn swing(&self, step: u64) -> State {
        let rate = self.of_velocity * Self::SPEED;
        let spring = SpringDashpot::spring(1.0 / self.mobility, self.tangential(), self.dt());
        spring.in_touch(&State::new(0, rate * self.dt(), rate), step)
    }

    /// Way, velocity, spin and force along the floor after so many steps: σ tells ∫S dt = (σ − σ₀)/Γ, and S
    /// tells ∫σ dt.
    fn expected(&self, step: u64) -> [f64; 4] {
        let (now, start) = (self.swing(step), self.swing(0));
        let (mobility, mass) = (self.mobility, self.grain.mass);
        let impulse = (now.approach - start.approach) / mobility;
        // What S does not stop: the velocity at which the grain rolls.
        let rolling = Self::SPEED - start.approach / (mobility * mass);
        let time = step as f64 * self.dt();
        [
            time * rolling + (now.overlap - start.overlap) / (mobility * mass),
            Self::SPEED + impulse / mass,
            -self.arm * impulse / self.grain.inertia,
            -self.tangential() * now.overlap,
        ]
    }
}

fn sticking() -> CaseGroup {
    const FLOOR: f64 = 0.005;
    const STEPS: u64 = 2000;
    const MOMENTS: [u64; 7] = [0, 1, 5, 40, 333, STEPS - 9, STEPS];
    let title =
        "A tangential spring below Coulomb's limit swings as the leapfrog recurrence, to rounding";
    let mut group = CaseGroup::new("leapfrog-sticking", title);
    let ball = Grain::sphere([0.0; 2], 0.01, 5.0e4);
    let disc = Grain::disc([0.0; 2], 0.01, 2000.0);
    for (what, grain) in [("ball", ball), ("disc", disc)] {
        for arms in [HALF_OVERLAP, CONTACT_POINT] {
            let rocking = Rocking::new(grain, arms);
            let modulus = rocking.stiffness / grain.radius;
            let law = (arms.law)(suite::friction(modulus, Rocking::RATIO, 1.2));
            let gravity = [0.0, -Rocking::GRAVITY];
            let model = suite::world(law, rocking.dt(), gravity, 0.0, [&[], &[FLOOR]]);
            let height = FLOOR + grain.radius - 0.1 * grain.radius;
            let grains = [grain.at([0.0, height]).moving([Rocking::SPEED, 0.0])];
            let id = format!("{what}/{}", arms.id);
            let case = suite::case(&id, model, &grains, MOMENTS.to_vec());
            group = group.with(id, case, move |track, figures| {
                let seen = |step: u64| {
                    let view = at(track, step);
                    // Along (−n_z, n_x), so to the left.
                    let force = view.contact(|contact| -contact.tangential_force);
                    let (way, velocity) = (view.position(0)[0], view.velocity(0)[0]);
                    [way, velocity, view.spin(0), force]
                };
                let rate = (rocking.tangential() * rocking.mobility).sqrt();
                let amplitude = rocking.swing(0).approach / rate;
                let tolerance = random_rounding(STEPS, amplitude, amplitude)
                    + rounding_of_phase(STEPS as f64 * Rocking::ANGLE);
                figures.because(ROUNDING);
                let scales = [
                    ("way", rocking.dt() * Rocking::SPEED * STEPS as f64),
                    ("velocity", Rocking::SPEED),
                    ("spin", Rocking::SPEED / rocking.grain.radius),
                    ("force", rocking.tangential() * amplitude),
                ];
                for (i, (what, scale)) in scales.into_iter().enumerate() {
                    let off =
                        |step: u64| ((seen(step)[i] - rocking.expected(step)[i]) / scale).abs();
                    let what = format!("{what}: largest deviation of the {what} over its size, 1");
                    figures.is(&what, furthest(0.0, MOMENTS.map(off)), 0.0, tolerance);
                }
            });
        }
    }
    group
}

/// How much slip a new contact is given, of a ball that touches a wall between two steps; the friction is too high for it to
/// slide at once.
fn first_slip(id: &'static str, title: &'static str, given: NewContactSlip) -> CaseGroup {
    /// k_n, N/m, and k_s over it.
    const STIFFNESS: f64 = 1.0e5;
    const RATIO: f64 = 0.4;
    /// s.
    const DT: f64 = 1.0e-5;
    /// Along the wall and towards it, m/s.
    const SPEEDS: [f64; 2] = [0.3, 0.5];
    /// Steps from the start to touch.
    const LEAD: f64 = 3.4;
    /// Place of the wall, m.
    const WALL: f64 = 0.005;
    const RADIUS: f64 = 0.01;
    // The first step with a contact, and u there.
    let first = LEAD.ceil() as u64;
    let place = WALL + RADIUS + LEAD * DT * SPEEDS[1];
    let overlap = WALL + RADIUS - (place - first as f64 * DT * SPEEDS[1]);
    let mut law = suite::friction(STIFFNESS / RADIUS, RATIO, 1.5);
    law.contact.new_contact_slip = given;
    let model = suite::world(law, DT, [0.0; 2], 0.0, [&[], &[WALL]]);
    let ball = Grain::sphere([0.0, place], RADIUS, 2500.0).moving([SPEEDS[0], -SPEEDS[1]]);
    let case = suite::case("first slip", model, &[ball], vec![first]);
    CaseGroup::new(id, title).with("", case, move |track, figures| {
        // Slip of the undeformed surface, as the default law has it: stretched, and so is the approach that
        // the time since touch is told from.
        let stretch = 2.0 * RADIUS / (2.0 * RADIUS - overlap);
        let slip = match given {
            NewContactSlip::WholeStep => stretch * SPEEDS[0] * DT,
            NewContactSlip::SinceTouch => SPEEDS[0] / SPEEDS[1] * overlap,
        };
        let force = RATIO * STIFFNESS * slip;
        // Positions of the size of wall and radius make an overlap of a fraction of a step.
        let rounding = 4.0 * f64::EPSILON * (WALL + RADIUS) / overlap;
        let found = at(track, first).contact(|contact| contact.tangential_force);
        figures.because("k_s times the slip; rounding of the overlap");
        let off = force * (rounding + 8.0 * f64::EPSILON);
        let what = "force: tangential force at first touch, N";
        figures.is(what, found, force, off);
    })
}
