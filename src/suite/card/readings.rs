//! How the trajectory of a meeting shows each constant of a law.

use std::f64::consts::PI;

use super::asked::{
    About, DT, HEAVY, Kind, LONG, Local, MORE, Meeting, OVERLAP, Place, Quantity, Read, SPEED,
    STEPS, TENSION, vector,
};
use crate::suite::Track;
use grains::model::Law;
use grains::scene::{
    AdhesionLaw, NewContactSlip, Rolling, Rotation, SlipVelocity, Tension, TorqueArms, Viscosity,
};
use grains::tables::{Bodies, Body};
use grains::task::Case;
use grains::vector::{dot, hypot, minus, times};

/// Steps in a contact time where a rebound is read.
const STEPS_OF_BOUNCE: u64 = 1000;
/// Of Coulomb's limit a step adds so much where a grain begins to slide, in so many steps.
const SHARE_OF_LIMIT: f64 = 0.04;
const STEPS_TO_SLIDE: u64 = 50;
/// N·m/rad.
const BENDING: f64 = 2.0e-3;
/// Between bodies that do not touch yet, m.
const NEARLY: f64 = 1.0e-8;
const ROLLING: Rolling = Rolling {
    bending_stiffness: Some(BENDING),
    twisting_stiffness: 1.0e-3,
    limit: None,
};

impl Meeting {
    pub fn quantities(self) -> Vec<Quantity> {
        let mut list = List {
            meeting: self,
            all: Vec::new(),
        };
        list.springs();
        list.dashpots();
        list.pulls();
        list.friction();
        list.damped_friction();
        list.friction_before_sliding();
        list.rebounds();
        list.choices();
        list.arms();
        if self.kind.in_space() {
            list.turns();
            list.reactions();
        }
        if self.kind == Kind::Hertz {
            list.loads();
            list.adhesion();
        }
        if self.kind.in_space() {
            list.moments();
        }
        list.all
    }
}

/// The quantities of a meeting, as they are added.
struct List {
    meeting: Meeting,
    all: Vec<Quantity>,
}

/// The friction angle of the last grain, whose material is the only other one and slides more easily, rad.
fn angle_of_last(law: &Law) -> f64 {
    let other = law.materials.first();
    other.map_or(law.friction_angle, |solid| solid.friction_angle)
}

/// One that presses by a share of what the spring does.
fn weak_dashpot(kind: Kind) -> Viscosity {
    match kind {
        Kind::Plane => Viscosity::dashpot(1.0, TENSION),
        Kind::Linear => Viscosity::dashpot(0.05, TENSION),
        Kind::Hertz => Viscosity::restitution(0.5, TENSION),
    }
}

impl List {
    fn add(
        &mut self,
        key: &str,
        case: Case,
        asked: f64,
        read: impl Fn(&Track) -> f64 + Send + Sync + 'static,
    ) {
        self.add_at(None, key, case, asked, read);
    }

    /// The same, where what it is read at is one of several values.
    fn add_at(
        &mut self,
        rate: Option<(&'static str, f64)>,
        key: &str,
        case: Case,
        asked: f64,
        read: impl Fn(&Track) -> f64 + Send + Sync + 'static,
    ) {
        let Meeting { place, kind } = self.meeting;
        self.all.push(Quantity {
            about: About {
                rate,
                meeting: Some(self.meeting),
                ..About::new(kind, place.name(), key, asked)
            },
            case,
            read: Box::new(read),
        });
    }

    /// The same for one value of something, and in space for a larger one: a law may depend on it otherwise than it says.
    fn add_at_rates(
        &mut self,
        key: &str,
        what: &'static str,
        mut one: impl FnMut(f64) -> (Case, f64, Read),
    ) {
        let more = self.meeting.kind.in_space().then_some((MORE, "-more"));
        for (rate, end) in [(1.0, "")].into_iter().chain(more) {
            let (case, asked, read) = one(rate);
            let key = format!("{key}{end}");
            self.add_at(Some((what, rate)), &key, case, asked, read);
        }
    }

    /// How much of something the first grain of a pair has over the last one; asked for below 0 where both have it the same way.
    fn add_share(
        &mut self,
        key: &str,
        case: Case,
        asked: f64,
        vector: impl Fn(usize, &Track) -> Local + Send + Sync + 'static,
    ) {
        self.add(key, case, asked.abs(), move |track| {
            let [one, two] = [0, 1].map(|id| vector(id, track));
            -asked.signum() * dot(one, two) / dot(two, two)
        });
    }

    fn overlap(&self) -> f64 {
        OVERLAP * self.meeting.last().radius
    }

    fn springs(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        // A spring may be another one while bodies part, as they do where they start at rest.
        for (key, inward) in [("k-n", 0.0), ("k-n-approach", SPEED)] {
            self.add_at_rates(key, "overlap", |rate| {
                let law = meeting.law(1.0, 0.0);
                let case = meeting.meeting(law, rate * overlap, [0.0, inward], vec![0, 1, 2]);
                let [asked, _] = meeting.stiffness(&case.model.law);
                let read = move |track: &Track| {
                    let power = meeting.power();
                    meeting.force(track, 1, DT)[0] / meeting.overlap(track, 1).powf(power)
                };
                (case, asked, Box::new(read))
            });
        }
    }

    fn dashpots(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        let viscosity = match meeting.kind {
            Kind::Plane => Viscosity::dashpot(10.0, TENSION),
            Kind::Linear => Viscosity::dashpot(0.5, TENSION),
            Kind::Hertz => Viscosity::restitution(0.5, TENSION),
        };
        let law = |angle| {
            meeting
                .kind
                .with_dashpots(meeting.law(1.0, angle), viscosity.clone())
        };
        // 2β√(m k) where it is no constant.
        let constant = move |law: &Law, which: usize, stiffness: f64| match law.contact.viscosity {
            Viscosity::Dashpot { c_n, .. } => c_n,
            _ => 2.0 * law.damping_ratios()[which] * (meeting.mass() * stiffness).sqrt(),
        };
        self.add_at_rates("c-n", "speed", |rate| {
            let velocity = [0.0, rate * SPEED];
            let case = meeting.meeting(law(0.0), overlap, velocity, vec![0, 1, 2]);
            let law = &case.model.law;
            let [stiffness, _] = meeting.stiffness(law);
            // By the overlap in which it is read.
            let asked = constant(law, 0, meeting.slope(law, overlap + rate * SPEED * DT));
            let read = move |track: &Track| {
                let spring = stiffness * meeting.overlap(track, 1).powf(meeting.power());
                (spring - meeting.force(track, 1, DT)[0]) / meeting.velocity(track, 1)[0]
            };
            (case, asked, Box::new(read))
        });
        if meeting.kind != Kind::Hertz {
            return;
        }
        for (key, of_its_own) in [("c-s", None), ("c-s-own", Some(0.8))] {
            let mut law = law(1.2);
            law.contact.tangential_viscosity = of_its_own;
            let case = meeting.meeting(law, overlap, [SPEED, 0.0], vec![0, 1, 2, 3]);
            let [_, stiffness] = meeting.stiffness(&case.model.law);
            let asked = constant(&case.model.law, 1, stiffness * overlap.sqrt());
            self.add(key, case, asked, move |track| {
                // The spring has got the slip of two steps.
                let [one, two] = [1, 2].map(|step| meeting.force(track, step, DT)[1]);
                (2.0 * (two - one) - one) / meeting.velocity(track, 1)[1]
            });
        }
    }

    /// What is left of a spring's push where its dashpot pulls twice as strongly, and whether it may.
    fn pulls(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        let c_n = if meeting.kind == Kind::Plane {
            10.0
        } else {
            0.5
        };
        for (tension, pulls) in [(Tension::Clipped, false), (Tension::Unclipped, true)] {
            let ratio = Viscosity::Ratio {
                ratio: 0.2,
                tension,
            };
            let of_hertz = (meeting.kind == Kind::Hertz).then_some(("ratio", ratio));
            let of_all = [
                ("constant", Viscosity::dashpot(c_n, tension)),
                ("restitution", Viscosity::restitution(0.5, tension)),
            ];
            for (named, viscosity) in of_all.into_iter().chain(of_hertz) {
                let law = meeting.kind.with_dashpots(meeting.law(1.0, 0.0), viscosity);
                let [stiffness, _] = meeting.stiffness(&law);
                let braking = |u: f64| match law.contact.viscosity {
                    Viscosity::Dashpot { c_n, .. } => c_n,
                    _ => {
                        let both = meeting.mass() * meeting.slope(&law, u);
                        2.0 * law.damping_ratios()[0] * both.sqrt()
                    }
                };
                let spring = |u: f64| stiffness * u.powf(meeting.power());
                let speed = 2.0 * spring(overlap) / braking(overlap);
                let left = overlap - speed * DT;
                let case = meeting.meeting(law.clone(), overlap, [0.0, -speed], vec![0, 1, 2]);
                let asked = if pulls {
                    spring(left) / (braking(left) * speed)
                } else {
                    1.0
                };
                let braked = braking(left) * speed;
                let key = format!("parting-{named}-{}", if pulls { "pulls" } else { "cut" });
                self.add(&key, case, asked, move |track| {
                    1.0 + meeting.force(track, 1, DT)[0] / braked
                });
            }
        }
    }

    fn friction(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        let ratio = meeting.kind.choose(0.5, 1.0);
        self.add_at_rates("k-s", "overlap", |rate| {
            let law = meeting.law(ratio, 1.2);
            let case = meeting.meeting(law, rate * overlap, [SPEED, 0.0], vec![0, 1, 2, 3]);
            let [_, asked] = meeting.stiffness(&case.model.law);
            let read = move |track: &Track| meeting.tangential_stiffness(track);
            (case, asked, Box::new(read))
        });
        let plain = meeting.law(1.0, 0.5f64.atan());
        let mut aside = plain.clone();
        aside.wall_friction_angle = Some(0.3f64.atan());
        aside.punch_friction_angle = Some(0.7f64.atan());
        for (key, law) in [("friction", plain), ("friction-own", aside)] {
            let body = match meeting.place {
                Place::Punch => Body::Punch,
                place if place.is_pair() => Body::Grain,
                _ => Body::Wall,
            };
            let own = law.friction_of_its_own(body);
            let asked = own.unwrap_or_else(|| angle_of_last(&law)).tan();
            let sliding = meeting.meeting(law, overlap, [3.0, 0.0], vec![0, 1, 2, 3]);
            self.add(key, sliding, asked, move |track| meeting.friction(track, 2));
        }
    }

    /// Coulomb's limit is that of the whole normal force, and of the whole tangential one.
    fn damped_friction(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        let law = meeting.law(1.0, 0.5f64.atan());
        let mut law = meeting.kind.with_dashpots(law, weak_dashpot(meeting.kind));
        if meeting.kind == Kind::Hertz {
            // A dashpot along the tangent would brake what sticks.
            law.contact.tangential_viscosity = Some(1.0);
        }
        let asked = angle_of_last(&law).tan();
        let case = meeting.meeting(law, overlap, [9.0, 0.2 * SPEED], vec![0, 1, 2, 3]);
        let read = move |track: &Track| meeting.friction(track, 2);
        self.add("friction-damped", case, asked, read);
    }

    /// What sticks may bear more than what slides: the largest share of the normal force on the way to sliding.
    fn friction_before_sliding(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        let law = meeting.law(1.0, 0.5f64.atan());
        let asked = angle_of_last(&law).tan();
        let [k_n, k_s] = meeting.stiffness(&law);
        let speed = SHARE_OF_LIMIT * asked * k_n / k_s * overlap / DT;
        let case = meeting.meeting(law, overlap, [speed, 0.0], (0..=STEPS_TO_SLIDE).collect());
        self.add("friction-before-sliding", case, asked, move |track| {
            let shares = (1..STEPS_TO_SLIDE).map(|step| meeting.friction(track, step));
            shares.fold(0.0, f64::max)
        });
    }

    /// What the law's own keys choose of slips.
    fn choices(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        let ratio = meeting.kind.choose(0.5, 1.0);
        let mut at_point = meeting.law(ratio, 1.2);
        at_point.contact.slip_velocity = SlipVelocity::ContactPoint;
        let mut blocked = meeting.law(ratio, 1.2);
        blocked.contact.rotation = Rotation::Blocked;
        // So long that grains would turn, and light ones do not part.
        let long = LONG / 2;
        let speed = 0.5 * overlap / (long as f64 * DT);
        let moments = vec![0, long, long + 1];
        let case = meeting.meeting(blocked, overlap, [speed, 0.0], moments);
        let [_, asked] = meeting.stiffness(&case.model.law);
        self.add("k-s-blocked", case, asked, move |track| {
            let [from, to] = [0, long].map(|step| meeting.place_of_last(track, step)[1]);
            // Slip counts from the velocity before the first step on.
            let way = to - from + speed * DT;
            -meeting.force(track, long, DT)[1] / way / meeting.root(track, long)
        });
        let case = meeting.meeting(at_point, overlap, [SPEED, 0.0], vec![0, 1, 2, 3]);
        let [_, asked] = meeting.stiffness(&case.model.law);
        let read = move |track: &Track| meeting.tangential_stiffness(track);
        self.add("k-s-point", case, asked, read);
        for (key, choice, asked) in [
            ("new-whole", NewContactSlip::WholeStep, 1.0),
            ("new-touch", NewContactSlip::SinceTouch, 0.5),
        ] {
            let mut law = meeting.law(ratio, 1.2);
            law.contact.new_contact_slip = choice;
            let mut case = meeting.bounce(law, SPEED, STEPS, vec![0, 1, 2, 3]);
            let velocity = meeting.in_space([-SPEED, 0.2 * SPEED, 0.0]);
            let last = meeting.id_of_last();
            case.bodies.vx[last] = velocity[0];
            case.bodies.vz[last] = velocity[2];
            if let Some(vy) = case.bodies.vy.get_mut(last) {
                *vy = velocity[1];
            }
            let dt = case.model.dt;
            let [_, stiffness] = meeting.stiffness(&case.model.law);
            self.add(key, case, asked, move |track| {
                let way = meeting.velocity(track, 1)[1] * dt;
                let root = meeting.root(track, 1);
                -meeting.force(track, 1, dt)[1] / (stiffness * root * way)
            });
        }
    }

    /// Normal collisions.
    fn rebounds(&mut self) {
        let meeting = self.meeting;
        let plain = meeting.law(1.0, 0.0);
        let mut rebounds = vec![("e-02", 0.2, 1.0), ("e-05", 0.5, 1.0), ("e-08", 0.8, 1.0)];
        if meeting.kind == Kind::Hertz {
            rebounds.push(("e-05-more", 0.5, MORE));
        }
        for (key, e_n, rate) in rebounds {
            let viscosity = Viscosity::restitution(e_n, TENSION);
            let law = meeting.kind.with_dashpots(plain.clone(), viscosity);
            let end = 3 * STEPS_OF_BOUNCE;
            let case = meeting.bounce(law, rate * SPEED, STEPS_OF_BOUNCE, vec![0, end]);
            // Of 0.5 alone there are two speeds.
            let is_twice = key.starts_with("e-05") && meeting.kind == Kind::Hertz;
            let at = is_twice.then_some(("speed", rate));
            self.add_at(at, key, case, e_n, move |track| {
                let [before, after] = [0, end].map(|step| meeting.velocity(track, step)[0]);
                -after / before
            });
        }
        let case = meeting.bounce(plain, SPEED, STEPS, (0..=STEPS + 10).collect());
        let (dt, asked) = (case.model.dt, meeting.contact_time(&case.model.law));
        self.add("contact-time", case, asked, move |track| {
            let pushes = |step: &u64| meeting.force(track, *step, dt)[0] != 0.0;
            (0..STEPS + 10).filter(pushes).count() as f64 * dt
        });
    }

    /// How the tangential spring turns: about the normal with the spins, and with the normal.
    fn turns(&mut self) {
        let meeting = self.meeting;
        let moments = vec![0, LONG, LONG + 1];
        let case = meeting.turning(1.2, 1.0, moments.clone());
        let dt = case.model.dt;
        // Slip along one line, which a spring sees that turns by an angle of 1, lags by half of it.
        self.add("turn-spin", case, 0.5f64.tan(), move |track| {
            let [_, along, across] = meeting.force(track, LONG, dt);
            across / along
        });
        if !meeting.place.is_pair() {
            return;
        }
        // So far that the normal turns by a hundredth, and overlaps stay about what they are.
        let law = meeting.law(0.5, 1.2);
        let speed = 0.02 * meeting.last().radius / (LONG as f64 * dt);
        let rolls = [0.0, 0.0, 0.97 * speed / meeting.last().radius];
        let case = meeting.meeting(law, self.overlap(), [speed, 0.0], moments);
        let mut case = meeting.spinning(case, [[0.0; 3], rolls], HEAVY);
        case.model.dt = dt;
        let [asked, _] = meeting.stiffness(&case.model.law);
        self.add("turn-normal", case, asked, move |track| {
            let [one, two] = [0, 1].map(|id| vector(track, LONG, id, Bodies::position));
            let apart = minus(two, one);
            let normal = times(1.0 / hypot(apart), apart);
            let force = meeting.in_space(meeting.force(track, LONG, dt));
            dot(force, normal) / meeting.overlap(track, LONG).powf(meeting.power())
        });
    }

    /// By which arm a tangential force turns the last grain.
    fn arms(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        // The contact point is on the surface of what is flat and endless.
        let at_surface = matches!(
            meeting.place,
            Place::Wall | Place::Below | Place::Apart | Place::Plane
        );
        let less = if at_surface { 1.0 } else { 0.5 };
        for (key, arms, less) in [
            ("arm", TorqueArms::HalfOverlap, 0.5),
            ("arm-point", TorqueArms::ContactPoint, less),
        ] {
            let mut law = meeting.law(0.5, 1.2);
            law.contact.torque_arms = arms;
            let case = meeting.meeting(law, overlap, [SPEED, 0.0], vec![0, 1, 2]);
            let case = meeting.spinning(case, [[0.0; 3]; 2], 1.0);
            let asked = meeting.last().radius - less * overlap;
            self.add(key, case, asked, move |track| {
                meeting.torque(track, 1)[2].abs() / meeting.force(track, 1, DT)[1].abs()
            });
        }
    }

    /// What the other grain of a pair feels.
    fn reactions(&mut self) {
        if !self.meeting.place.is_pair() {
            return;
        }
        let (meeting, overlap) = (self.meeting, self.overlap());
        let mut law = meeting.law(0.5, 1.2);
        if meeting.kind == Kind::Hertz {
            let viscosity = Viscosity::restitution(0.5, TENSION);
            law = meeting.kind.with_dashpots(law, viscosity);
        }
        let dragged = || {
            let case = meeting.meeting(law.clone(), overlap, [SPEED, 0.0], vec![0, 1, 2]);
            meeting.spinning(case, [[0.0; 3]; 2], 1.0)
        };
        self.add_share("reaction", dragged(), 1.0, move |id, track| {
            meeting.force_on(id, track, 1, DT)
        });
        let [r1, r2] = meeting.radii().map(|radius| radius - 0.5 * overlap);
        self.add_share("torques", dragged(), -r1 / r2, move |id, track| {
            meeting.torque_on(id, track, 1)
        });
    }

    /// What a tangential spring keeps while the load grows and falls.
    fn loads(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        // So short that a light grain keeps its speed.
        let long = LONG / 2;
        let way = 0.5 * SPEED * long as f64 * DT;
        let more = overlap + way;
        for (key, begin, end) in [("load-up", overlap, more), ("load-down", more, overlap)] {
            let law = meeting.law(1.0, 1.2);
            let inward = 0.5 * SPEED * (end - begin).signum();
            let case = meeting.meeting(law, begin, [0.2 * SPEED, inward], vec![0, long, long + 1]);
            let [_, stiffness] = meeting.stiffness(&case.model.law);
            let mean = 2.0 / 3.0 * (end.powf(1.5) - begin.powf(1.5)) / (end - begin);
            self.add(key, case, mean / end.sqrt(), move |track| {
                let slip = 0.2 * SPEED * (long + 1) as f64 * DT;
                let spring = stiffness * meeting.overlap(track, long).sqrt() * slip;
                -meeting.force(track, long, DT)[1] / spring
            });
        }
    }

    fn adhesion(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        let energy = 0.05;
        let sticky = |adhesion_law, friction_angle| {
            let mut law = meeting.law(1.0, friction_angle);
            law.contact.adhesion = Some(energy);
            law.contact.adhesion_law = adhesion_law;
            law
        };
        let [r1, r2] = meeting.radii();
        let radius = r1 * r2 / (r1 + r2);
        for (key, adhesion_law) in [("adhesion", AdhesionLaw::Pull), ("dmt", AdhesionLaw::Dmt)] {
            let law = sticky(adhesion_law, 0.0);
            let case = meeting.meeting(law, overlap, [0.0; 2], vec![0, 1, 2]);
            let [stiffness, _] = meeting.stiffness(&case.model.law);
            self.add(key, case, energy, move |track| {
                let spring = stiffness * meeting.overlap(track, 1).powf(1.5);
                (spring - meeting.force(track, 1, DT)[0]) / (4.0 * PI * radius)
            });
        }
        // What presses besides the force: |N| + A, or N + 2A.
        for (key, adhesion_law, pulls) in [
            ("friction-pulled", AdhesionLaw::Pull, 4.0),
            ("friction-dmt", AdhesionLaw::Dmt, 8.0),
            ("friction-jkr", AdhesionLaw::Jkr, 6.0),
        ] {
            let law = sticky(adhesion_law, 0.5f64.atan());
            let asked = angle_of_last(&law).tan();
            let pull = pulls * PI * radius * energy;
            let case = meeting.meeting(law, overlap, [3.0, 0.0], vec![0, 1, 2, 3, 4]);
            self.add(key, case, asked, move |track| {
                let [out, along, across] = meeting.force(track, 3, DT);
                let pressing = match adhesion_law {
                    AdhesionLaw::Pull => out.abs(),
                    AdhesionLaw::Dmt | AdhesionLaw::Jkr => out,
                };
                along.hypot(across) / (pressing + pull)
            });
        }
        // Parts from a fifth of the overlap on; the largest pull.
        let case = meeting.meeting(
            sticky(AdhesionLaw::Jkr, 0.0),
            0.2 * overlap,
            [0.0, -0.5 * SPEED],
            (0..LONG).collect(),
        );
        self.add("jkr", case, energy, move |track| {
            let forces = (1..LONG - 1).map(|step| meeting.force(track, step, DT)[0]);
            -forces.fold(f64::INFINITY, f64::min) / (3.0 * PI * radius)
        });
        let law = sticky(AdhesionLaw::Jkr, 0.0);
        let apart = meeting.meeting(law, -NEARLY, [0.0; 2], vec![0, 1, 2]);
        self.add("jkr-before", apart, 1.0, move |track| {
            1.0 + meeting.force(track, 1, DT)[0] / (3.0 * PI * radius * energy)
        });
    }

    /// Against rolling and twisting; friction is as small as it can be, so that torques are theirs.
    fn moments(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        let law = |rolling: Rolling| {
            let mut law = meeting.law(1.0, 1.0e-9);
            law.contact.rolling = Some(rolling);
            law
        };
        // What counts is the difference of the spins, not their sum; the first one turns the other way, by this share.
        let turning = move |law: Law, inward: f64, spin: Local, first: f64| {
            let case = meeting.meeting(law, overlap, [0.0, inward], vec![0, 1, 2, 3]);
            meeting.spinning(case, [spin.map(|part| -first * part), spin], 1.0)
        };
        for (key, component, asked) in [
            ("bending", 1, BENDING),
            ("twisting", 0, ROLLING.twisting_stiffness),
        ] {
            self.add_at_rates(key, "spin", |rate| {
                let first = if rate == 1.0 { 0.25 } else { 0.5 };
                let of_first = if meeting.place.is_pair() { first } else { 0.0 };
                let difference = 3.0 * rate;
                let mut spin = [0.0; 3];
                spin[component] = difference / (1.0 + of_first);
                let case = turning(law(ROLLING), 0.0, spin, first);
                let read = move |track: &Track| {
                    let [one, two] = [1, 2].map(|step| meeting.torque(track, step)[component]);
                    // What a step adds, and all that two steps have added.
                    let added = if rate == 1.0 { one - two } else { -0.5 * one };
                    added / (difference * DT)
                };
                (case, asked, Box::new(read))
            });
        }
        // So stiff that the limit is reached at once; linear springs push harder.
        let times_as_stiff = meeting.kind.choose(1.0e5, 1.0e3);
        let limit = 0.05;
        let stiff = Rolling {
            bending_stiffness: Some(times_as_stiff * BENDING),
            limit: Some(limit),
            ..ROLLING
        };
        let over_force = move |track: &Track, torque: f64| {
            let [r1, r2] = meeting.radii();
            torque / (meeting.force(track, 2, DT)[0] * 0.5 * (r1 + r2))
        };
        let of_both = move |track: &Track| {
            let [_, along, across] = meeting.torque(track, 2);
            over_force(track, along.hypot(across))
        };
        self.add_at_rates("limit", "spin", |rate| {
            let case = turning(law(stiff), 0.0, [0.0, 3.0 * rate, 0.0], 0.25);
            (case, limit, Box::new(of_both))
        });
        let damped = meeting
            .kind
            .with_dashpots(law(stiff), weak_dashpot(meeting.kind));
        let case = turning(damped, 0.2 * SPEED, [0.0, 3.0, 0.0], 0.25);
        self.add("limit-damped", case, limit, of_both);
        let constant = Rolling {
            bending_stiffness: None,
            twisting_stiffness: 0.0,
            limit: Some(limit),
        };
        let case = turning(law(constant), 0.0, [4.0, 3.0, 0.0], 0.25);
        self.add("constant-moment", case, limit, move |track| {
            over_force(track, meeting.torque(track, 2)[1].abs())
        });
        if !meeting.place.is_pair() {
            return;
        }
        let case = turning(law(ROLLING), 0.0, [1.0, 2.0, 0.0], 0.25);
        self.add_share("moments", case, 1.0, move |id, track| {
            meeting.torque_on(id, track, 2)
        });
    }
}
