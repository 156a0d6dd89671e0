//! How the trajectory of a meeting shows each constant of a law.

use std::f64::consts::PI;

use super::OF_BOTH;
use super::asked::{
    About, DT, HEAVY, Kind, LONG, Local, MORE, Meeting, Named, OVERLAP, Place, Quantity, Read,
    SPEED, STEPS, TENSION, vector,
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
        named: Named<'_>,
        case: Case,
        asked: f64,
        read: impl Fn(&Track) -> f64 + Send + Sync + 'static,
    ) {
        self.add_at(None, named, case, asked, read);
    }

    /// The same, where what it is read at is one of several values.
    fn add_at(
        &mut self,
        rate: Option<(&'static str, f64)>,
        named: Named<'_>,
        case: Case,
        asked: f64,
        read: impl Fn(&Track) -> f64 + Send + Sync + 'static,
    ) {
        let Meeting { place, kind } = self.meeting;
        self.all.push(Quantity {
            about: About {
                rate,
                meeting: Some(self.meeting),
                ..About::new(kind, place.name(), named, asked)
            },
            case,
            read: Box::new(read),
        });
    }

    /// The same for one value of something, and in space for a larger one: a law may depend on it otherwise than it says.
    fn add_at_rates(
        &mut self,
        (key, name, unit): Named<'_>,
        (what, more): (&'static str, &str),
        mut one: impl FnMut(f64) -> (Case, f64, Read),
    ) {
        let rates = [1.0, MORE];
        let count = 1 + usize::from(self.meeting.kind.in_space());
        for rate in rates.into_iter().take(count) {
            let (case, asked, read) = one(rate);
            let named = match rate == 1.0 {
                true => (key.to_owned(), name.to_owned()),
                false => (
                    format!("{key}-more"),
                    format!("{name}, {rate} times as {more}"),
                ),
            };
            let named = (&*named.0, &*named.1, unit);
            self.add_at(Some((what, rate)), named, case, asked, read);
        }
    }

    /// How much of something the first grain of a pair has over the last one; asked for below 0 where both have it the same way.
    fn add_share(
        &mut self,
        (key, what): (&str, &str),
        case: Case,
        asked: f64,
        vector: impl Fn(usize, &Track) -> Local + Send + Sync + 'static,
    ) {
        let name = format!("{what} {OF_BOTH}");
        self.add((key, &name, ""), case, asked.abs(), move |track| {
            let [one, two] = [0, 1].map(|id| vector(id, track));
            -asked.signum() * dot(one, two) / dot(two, two)
        });
    }

    /// Of a spring's constant.
    fn unit(&self) -> &'static str {
        match self.meeting.kind {
            Kind::Hertz => "N/m^1.5",
            _ => "N/m",
        }
    }

    fn overlap(&self) -> f64 {
        OVERLAP * self.meeting.last().radius
    }

    fn springs(&mut self) {
        let (meeting, overlap, unit) = (self.meeting, self.overlap(), self.unit());
        // A spring may be another one while bodies part, as they do where they start at rest.
        let both = [
            ("k-n", "normal stiffness", 0.0),
            (
                "k-n-approach",
                "normal stiffness while bodies approach",
                SPEED,
            ),
        ];
        for (key, name, inward) in both {
            self.add_at_rates((key, name, unit), ("overlap", "deep"), |rate| {
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
        self.add_at_rates(("c-n", "dashpot", "N s/m"), ("speed", "fast"), |rate| {
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
        for (key, name, of_its_own) in [
            ("c-s", "dashpot along the tangent", None),
            ("c-s-own", "dashpot along the tangent of its own", Some(0.8)),
        ] {
            let mut law = law(1.2);
            law.contact.tangential_viscosity = of_its_own;
            let case = meeting.meeting(law, overlap, [SPEED, 0.0], vec![0, 1, 2, 3]);
            let [_, stiffness] = meeting.stiffness(&case.model.law);
            let asked = constant(&case.model.law, 1, stiffness * overlap.sqrt());
            self.add((key, name, "N s/m"), case, asked, move |track| {
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
            let is_hertz = meeting.kind == Kind::Hertz;
            let of_hertz = is_hertz.then_some(("ratio", "ratio", ratio));
            let of_all = [
                ("constant", "constant", Viscosity::dashpot(c_n, tension)),
                (
                    "restitution",
                    "restitution",
                    Viscosity::restitution(0.5, tension),
                ),
            ];
            for (key, named, viscosity) in of_all.into_iter().chain(of_hertz) {
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
                let how = if pulls {
                    "that may pull"
                } else {
                    "that may not pull"
                };
                let name = format!("force of parting bodies, by a {named} {how}");
                let key = format!("parting-{key}-{}", if pulls { "pulls" } else { "cut" });
                self.add((&key, &name, ""), case, asked, move |track| {
                    1.0 + meeting.force(track, 1, DT)[0] / braked
                });
            }
        }
    }

    fn friction(&mut self) {
        let (meeting, overlap, unit) = (self.meeting, self.overlap(), self.unit());
        let ratio = if meeting.kind == Kind::Hertz {
            1.0
        } else {
            0.5
        };
        self.add_at_rates(
            ("k-s", "tangential stiffness", unit),
            ("overlap", "deep"),
            |rate| {
                let law = meeting.law(ratio, 1.2);
                let case = meeting.meeting(law, rate * overlap, [SPEED, 0.0], vec![0, 1, 2, 3]);
                let [_, asked] = meeting.stiffness(&case.model.law);
                let read = move |track: &Track| {
                    let [one, two] = [1, 2].map(|step| meeting.force(track, step, DT)[1]);
                    let way = meeting.velocity(track, 2)[1] * DT;
                    (one - two) / way / meeting.overlap(track, 2).powf(meeting.power() - 1.0)
                };
                (case, asked, Box::new(read))
            },
        );
        let plain = meeting.law(1.0, 0.5f64.atan());
        let mut aside = plain.clone();
        aside.wall_friction_angle = Some(0.3f64.atan());
        aside.punch_friction_angle = Some(0.7f64.atan());
        for (key, name, law) in [
            ("friction", "friction coefficient", plain),
            (
                "friction-own",
                "friction coefficient where walls and punch have their own",
                aside,
            ),
        ] {
            let body = match meeting.place {
                Place::Punch => Body::Punch,
                place if place.is_pair() => Body::Grain,
                _ => Body::Wall,
            };
            let own = law.friction_of_its_own(body);
            let asked = own.unwrap_or_else(|| angle_of_last(&law)).tan();
            let sliding = meeting.meeting(law, overlap, [3.0, 0.0], vec![0, 1, 2, 3]);
            self.add((key, name, ""), sliding, asked, move |track| {
                let [out, along, across] = meeting.force(track, 2, DT);
                along.hypot(across) / out.abs()
            });
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
        let named = (
            "friction-damped",
            "friction coefficient beside a dashpot",
            "",
        );
        self.add(named, case, asked, move |track| {
            let [out, along, across] = meeting.force(track, 2, DT);
            along.hypot(across) / out.abs()
        });
    }

    /// What sticks may bear more than what slides: the largest share of the normal force on the way to sliding.
    fn friction_before_sliding(&mut self) {
        let (meeting, overlap) = (self.meeting, self.overlap());
        let law = meeting.law(1.0, 0.5f64.atan());
        let asked = angle_of_last(&law).tan();
        let [k_n, k_s] = meeting.stiffness(&law);
        let speed = SHARE_OF_LIMIT * asked * k_n / k_s * overlap / DT;
        let case = meeting.meeting(law, overlap, [speed, 0.0], (0..=STEPS_TO_SLIDE).collect());
        let named = (
            "friction-before-sliding",
            "largest friction before it slides",
            "",
        );
        self.add(named, case, asked, move |track| {
            let shares = (1..STEPS_TO_SLIDE).map(|step| {
                let [out, along, across] = meeting.force(track, step, DT);
                along.hypot(across) / out.abs()
            });
            shares.fold(0.0, f64::max)
        });
    }

    /// What the law's own keys choose of slips.
    fn choices(&mut self) {
        let (meeting, overlap, unit) = (self.meeting, self.overlap(), self.unit());
        let ratio = if meeting.kind == Kind::Hertz {
            1.0
        } else {
            0.5
        };
        let read = move |track: &Track| {
            let [one, two] = [1, 2].map(|step| meeting.force(track, step, DT)[1]);
            let way = meeting.velocity(track, 2)[1] * DT;
            (one - two) / way / meeting.overlap(track, 2).powf(meeting.power() - 1.0)
        };
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
        let named = (
            "k-s-blocked",
            "tangential stiffness, grains that do not turn",
            unit,
        );
        self.add(named, case, asked, move |track| {
            let [from, to] = [0, long].map(|step| meeting.place_of_last(track, step)[1]);
            // Slip counts from the velocity before the first step on.
            let way = to - from + speed * DT;
            let root = meeting.overlap(track, long).powf(meeting.power() - 1.0);
            -meeting.force(track, long, DT)[1] / way / root
        });
        let case = meeting.meeting(at_point, overlap, [SPEED, 0.0], vec![0, 1, 2, 3]);
        let [_, asked] = meeting.stiffness(&case.model.law);
        let named = (
            "k-s-point",
            "tangential stiffness, slip of the contact point",
            unit,
        );
        self.add(named, case, asked, read);
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
            let name = format!("share of its first step's slip that a new contact has ({key})");
            self.add((key, &name, ""), case, asked, move |track| {
                let way = meeting.velocity(track, 1)[1] * dt;
                let root = meeting.overlap(track, 1).powf(meeting.power() - 1.0);
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
            let name = match rate == 1.0 {
                true => "restitution".to_owned(),
                false => format!("restitution, {rate} times as fast"),
            };
            // Of 0.5 alone there are two speeds.
            let is_twice = key.starts_with("e-05") && meeting.kind == Kind::Hertz;
            let at = is_twice.then_some(("speed", rate));
            self.add_at(at, (key, &name, ""), case, e_n, move |track| {
                let [before, after] = [0, end].map(|step| meeting.velocity(track, step)[0]);
                -after / before
            });
        }
        let case = meeting.bounce(plain, SPEED, STEPS, (0..=STEPS + 10).collect());
        let (dt, asked) = (case.model.dt, meeting.contact_time(&case.model.law));
        self.add(
            ("contact-time", "contact time", "s"),
            case,
            asked,
            move |track| {
                let pushes = |step: &u64| meeting.force(track, *step, dt)[0] != 0.0;
                (0..STEPS + 10).filter(pushes).count() as f64 * dt
            },
        );
    }

    /// How the tangential spring turns: about the normal with the spins, and with the normal.
    fn turns(&mut self) {
        let meeting = self.meeting;
        let moments = vec![0, LONG, LONG + 1];
        let case = meeting.turning(1.2, 1.0, moments.clone());
        let dt = case.model.dt;
        let name = "turn of the tangential spring about the normal";
        // Slip along one line, which a spring sees that turns by an angle of 1, lags by half of it.
        self.add(("turn-spin", name, ""), case, 0.5f64.tan(), move |track| {
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
        let named = (
            "turn-normal",
            "normal stiffness, sheared and rolling over",
            self.unit(),
        );
        self.add(named, case, asked, move |track| {
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
        for (key, name, arms, less) in [
            (
                "arm",
                "arm of the tangential force",
                TorqueArms::HalfOverlap,
                0.5,
            ),
            (
                "arm-point",
                "arm of the tangential force at the contact point",
                TorqueArms::ContactPoint,
                if at_surface { 1.0 } else { 0.5 },
            ),
        ] {
            let mut law = meeting.law(0.5, 1.2);
            law.contact.torque_arms = arms;
            let case = meeting.meeting(law, overlap, [SPEED, 0.0], vec![0, 1, 2]);
            let case = meeting.spinning(case, [[0.0; 3]; 2], 1.0);
            let asked = meeting.last().radius - less * overlap;
            self.add((key, name, "m"), case, asked, move |track| {
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
        self.add_share(("reaction", "force"), dragged(), 1.0, move |id, track| {
            meeting.force_on(id, track, 1, DT)
        });
        let [r1, r2] = meeting.radii().map(|radius| radius - 0.5 * overlap);
        let named = ("torques", "torque of friction");
        self.add_share(named, dragged(), -r1 / r2, move |id, track| {
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
        for (key, how, begin, end) in [
            ("load-up", "growing", overlap, more),
            ("load-down", "falling", more, overlap),
        ] {
            let name = format!("tangential force kept under a {how} load");
            let law = meeting.law(1.0, 1.2);
            let inward = 0.5 * SPEED * (end - begin).signum();
            let case = meeting.meeting(law, begin, [0.2 * SPEED, inward], vec![0, long, long + 1]);
            let [_, stiffness] = meeting.stiffness(&case.model.law);
            let mean = 2.0 / 3.0 * (end.powf(1.5) - begin.powf(1.5)) / (end - begin);
            self.add((key, &name, ""), case, mean / end.sqrt(), move |track| {
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
        const BY_DMT: &str = "by Derjaguin, Muller and Toporov";
        const BY_JKR: &str = "by Johnson, Kendall and Roberts";
        for (key, by, adhesion_law) in [
            ("adhesion", "of a constant pull", AdhesionLaw::Pull),
            ("dmt", BY_DMT, AdhesionLaw::Dmt),
        ] {
            let name = format!("surface energy {by}");
            let law = sticky(adhesion_law, 0.0);
            let case = meeting.meeting(law, overlap, [0.0; 2], vec![0, 1, 2]);
            let [stiffness, _] = meeting.stiffness(&case.model.law);
            self.add((key, &name, "J/m²"), case, energy, move |track| {
                let spring = stiffness * meeting.overlap(track, 1).powf(1.5);
                (spring - meeting.force(track, 1, DT)[0]) / (4.0 * PI * radius)
            });
        }
        // What presses besides the force: |N| + A, or N + 2A.
        for (key, by, adhesion_law, pulls) in [
            (
                "friction-pulled",
                "under a constant pull",
                AdhesionLaw::Pull,
                4.0,
            ),
            ("friction-dmt", BY_DMT, AdhesionLaw::Dmt, 8.0),
            ("friction-jkr", BY_JKR, AdhesionLaw::Jkr, 6.0),
        ] {
            let name = format!("friction coefficient {by}");
            let law = sticky(adhesion_law, 0.5f64.atan());
            let asked = angle_of_last(&law).tan();
            let pull = pulls * PI * radius * energy;
            let case = meeting.meeting(law, overlap, [3.0, 0.0], vec![0, 1, 2, 3, 4]);
            self.add((key, &name, ""), case, asked, move |track| {
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
        let name = format!("surface energy {BY_JKR}");
        self.add(("jkr", &name, "J/m²"), case, energy, move |track| {
            let forces = (1..LONG - 1).map(|step| meeting.force(track, step, DT)[0]);
            -forces.fold(f64::INFINITY, f64::min) / (3.0 * PI * radius)
        });
        let apart = meeting.meeting(
            sticky(AdhesionLaw::Jkr, 0.0),
            -NEARLY,
            [0.0; 2],
            vec![0, 1, 2],
        );
        let name = format!("force before bodies touch, {BY_JKR}");
        self.add(("jkr-before", &name, ""), apart, 1.0, move |track| {
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
        for (key, name, component, asked) in [
            ("bending", "bending stiffness", 1, BENDING),
            (
                "twisting",
                "twisting stiffness",
                0,
                ROLLING.twisting_stiffness,
            ),
        ] {
            self.add_at_rates((key, name, "N m"), ("spin", "fast"), |rate| {
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
        let times_as_stiff = if meeting.kind == Kind::Hertz {
            1.0e3
        } else {
            1.0e5
        };
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
        self.add_at_rates(
            ("limit", "limit of rolling", ""),
            ("spin", "fast"),
            |rate| {
                let case = turning(law(stiff), 0.0, [0.0, 3.0 * rate, 0.0], 0.25);
                (case, limit, Box::new(of_both))
            },
        );
        let damped = meeting
            .kind
            .with_dashpots(law(stiff), weak_dashpot(meeting.kind));
        let case = turning(damped, 0.2 * SPEED, [0.0, 3.0, 0.0], 0.25);
        let named = ("limit-damped", "limit of rolling, beside a dashpot", "");
        self.add(named, case, limit, of_both);
        let constant = Rolling {
            bending_stiffness: None,
            twisting_stiffness: 0.0,
            limit: Some(limit),
        };
        let case = turning(law(constant), 0.0, [4.0, 3.0, 0.0], 0.25);
        let named = (
            "constant-moment",
            "limit of rolling, as a constant torque",
            "",
        );
        self.add(named, case, limit, move |track| {
            over_force(track, meeting.torque(track, 2)[1].abs())
        });
        if !meeting.place.is_pair() {
            return;
        }
        let case = turning(law(ROLLING), 0.0, [1.0, 2.0, 0.0], 0.25);
        self.add_share(("moments", "moment"), case, 1.0, move |id, track| {
            meeting.torque_on(id, track, 2)
        });
    }
}
