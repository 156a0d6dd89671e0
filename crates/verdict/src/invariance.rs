//! An engine held against itself: what is true of any contact law, also of one that this program does not know. No reference is
//! asked. The [table](RELATIONS) says how a case is changed, how the answer is changed back, and what must hold then.
//!
//! How far rounding takes an engine apart is measured by the engine's own runs from starts that differ in their last digits.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::f64::consts::PI;

use evidence::random::Source;
use grains::model::{Axis, Law, Wall};
use grains::native::NativeError;
use grains::rules::{Arms, GivenVelocities, Integration, Rules, WrittenVelocities};
use grains::scene::Springs;
use grains::tables::{Bodies, Contact, Snapshot};
use grains::task::Case;
use grains::vector::{cross, dot, minus, norm, plus, times};
use serde::{Deserialize, Serialize};

use crate::contacts::Table;
use crate::envelope::{Envelope, FACTOR, Resolution, largest};
use crate::frame::Frame;
use crate::starts::{MOMENTS, Start, State};
use crate::{Answer, Engine};

/// What an engine with a law of its own says of it, so that nothing is asked that cannot hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Own {
    /// It has constants with units that no job names.
    Constants,
    /// Contacts remember, so that a table does not tell how a run goes on.
    Memory,
    /// There are forces that no contact table tells: of the air, or at a distance.
    Unlisted,
    /// Something drives grains, so that two of them may part faster than they met.
    Active,
}

/// Something that must be true of any engine.
pub struct Relation {
    /// For identifiers.
    pub key: &'static str,
    /// What is done to a case.
    pub name: &'static str,
    asks: Asks,
    holds: Holds,
    /// What usually breaks it.
    pub breaks: &'static str,
}

/// The cases that a relation asks for, none where it says nothing, and what was answered as if the case had been asked for as it is.
enum Asks {
    /// Its answers are as they are.
    Cases(fn(&Known) -> Vec<Case>),
    /// The case as it is in each of these frames.
    Frames(fn(&Known) -> Vec<Frame>),
    /// There, and back.
    Changed(fn(&Known) -> Vec<Case>, fn(&Known, Vec<Run>) -> Vec<Run>),
}

impl Asks {
    fn there(&self, known: &Known) -> Vec<Case> {
        match self {
            Asks::Cases(there) | Asks::Changed(there, _) => there(known),
            Asks::Frames(frames) => {
                let there = |frame: Frame| frame.case(&known.state.case);
                frames(known).into_iter().map(there).collect()
            }
        }
    }

    fn back(&self, known: &Known, runs: Vec<Run>) -> Vec<Run> {
        match self {
            Asks::Cases(_) => runs,
            Asks::Changed(_, back) => back(known, runs),
            Asks::Frames(frames) => {
                let each = frames(known).into_iter().zip(&runs);
                each.map(|(frame, run)| told_here(&frame, run)).collect()
            }
        }
    }
}

/// What must hold between the answers and the run of the case as it is.
#[derive(PartialEq)]
enum Holds {
    EveryBit,
    /// Every bit, or what rounding leaves of it where a function of the machine's library is used.
    Exactly,
    /// In coordinates that are at most so many times as large.
    Rounding(f64),
    /// The last answer is the first one up to rounding; those between are from starts with other last digits.
    Together,
    /// Answers come closer to each other as the time step is halved.
    Converges,
    /// Grains and walls press each other, so that there is something to judge.
    Touches,
    /// Two grains have no more kinetic energy after they met.
    Passive,
    /// Each grain gains the momentum that written forces and gravity give it.
    Account,
    /// All grains together keep momentum and angular momentum.
    Conserved,
    /// Contacts are written where grains and walls overlap, as they do.
    Written,
}

type Run = Vec<Snapshot>;

/// All of them.
pub const RELATIONS: [Relation; 17] = [
    Relation {
        key: "contacts",
        name: "contacts between grains and at walls that bear a force, in one state at least",
        asks: Asks::Cases(|known| vec![known.state.case.clone()]),
        holds: Holds::Touches,
        breaks: "",
    },
    Relation {
        key: "again",
        name: "run twice, the second time in another order of cases",
        asks: Asks::Cases(|known| vec![known.state.case.clone()]),
        holds: Holds::EveryBit,
        breaks: "memory that is never set or is kept from the case before, threads that add in the order in which they come, or random numbers without a fixed seed",
    },
    Relation {
        key: "output",
        name: "told of at every step, or at the last one alone",
        asks: Asks::Cases(|known| {
            let last = MOMENTS[MOMENTS.len() - 1];
            let every = (0..=EVERY_STEP).chain([last]).collect();
            vec![known.state.case.at(every), known.state.case.at(vec![last])]
        }),
        holds: Holds::EveryBit,
        breaks: "output that changes the run: a table that is sorted in place, contacts or velocities that are made anew for it",
    },
    Relation {
        key: "resumed",
        name: "stopped and resumed from its own table",
        asks: Asks::Changed(resumed, |_, mut runs| {
            let moments = runs.iter_mut().flatten();
            moments.for_each(|moment| moment.step += STOPPED);
            runs
        }),
        holds: Holds::Rounding(1.0),
        breaks: "something that is remembered and not written, such as neighbours found at the start, or a first step that is not as the others",
    },
    Relation {
        key: "renumbered",
        name: "grains renumbered",
        asks: Asks::Frames(|known| vec![Frame::renumbered(known.state.case.bodies.len())]),
        holds: Holds::Rounding(1.0),
        breaks: "forces that depend on which of two grains comes first, pairs that are lost by their order, or one grain that is treated otherwise",
    },
    Relation {
        key: "mirrored",
        name: "mirrored, left for right and in space front for back",
        asks: Asks::Frames(mirrors),
        holds: Holds::Rounding(1.0),
        breaks: "a torque, a spin or a tangential force with the wrong sign, or coordinates below zero that are cut to whole cells",
    },
    Relation {
        key: "turned",
        name: "turned by a quarter, with gravity and walls",
        asks: Asks::Frames(quarters),
        holds: Holds::Rounding(1.0),
        breaks: "gravity or walls that are taken to lie along one axis, or a term that is missing along one of them",
    },
    Relation {
        key: "askew",
        name: "left alone, and turned by an angle that is no quarter",
        asks: Asks::Changed(askew, |known, mut runs| {
            let last = runs.pop().unwrap_or_default();
            runs.push(told_here(&no_quarter(known), &last));
            runs
        }),
        holds: Holds::Together,
        breaks: "a component of a tangential force or a moment that is taken along an axis of the box instead of the contact's, or is not turned with the contact",
    },
    Relation {
        key: "moving",
        name: "left alone, and seen by one who moves past",
        asks: Asks::Changed(from_moving, |known, mut runs| {
            let last = runs.pop().unwrap_or_default();
            runs.push(
                last.into_iter()
                    .map(|moment| drifted(known, moment, -1.0))
                    .collect(),
            );
            runs
        }),
        holds: Holds::Together,
        breaks: "a force that depends on a velocity itself and on no difference of two, as a drag does",
    },
    Relation {
        key: "shifted",
        name: "shifted to the side and up, and back and down",
        asks: Asks::Frames(|known| [1.0, -1.0].map(|sign| shifted(known, sign)).to_vec()),
        holds: Holds::Rounding(2.5),
        breaks: "a wall or a cell grid that is taken to begin at zero, or a tolerance that is a share of a coordinate",
    },
    Relation {
        key: "units",
        name: "in other units of length, mass and time",
        // No product of small powers of the three is one, or a constant with its unit would stay hidden. Shorter metres: an engine
        // that counts from a corner of its own rounds what is small there.
        asks: Asks::Frames(|_| vec![Frame::in_units([11, -17, 3])]),
        holds: Holds::Exactly,
        breaks: "a constant with a unit that stands in the program, such as gravity or a time step, or an absolute tolerance in metres",
    },
    Relation {
        key: "copies",
        name: "twice and once at rest, far apart, in one job",
        asks: Asks::Changed(doubled, one_by_one),
        holds: Holds::Rounding(1.0 + FAR[0]),
        breaks: "a cell list that ends before the second copy does, buffers that are used again, or a sum over all grains that acts on each",
    },
    Relation {
        key: "step",
        name: "time step halved, and halved again",
        asks: Asks::Cases(|known| match known.state.case.punch {
            Some(_) => Vec::new(),
            None => HALVED.map(|times| stack(known, times)).to_vec(),
        }),
        holds: Holds::Converges,
        breaks: "a time step that is not read everywhere, or a force that is a jump a step and no rate",
    },
    Relation {
        key: "passive",
        name: "kinetic energy of two grains that meet and part",
        asks: Asks::Cases(|known| vec![impact(known)]),
        holds: Holds::Passive,
        breaks: "a dashpot or friction with the wrong sign, a force of the step before, or a spring that gives more than it took, as one along \
            the tangent does that keeps its force while the contact opens",
    },
    Relation {
        key: "account",
        name: "momentum that each grain gains, against the forces that are written",
        asks: Asks::Cases(|known| vec![undamped(known, (0..=ACCOUNTED).collect())]),
        holds: Holds::Account,
        breaks: "forces that act on one of two bodies only, forces that act and are not in the table, or gravity that is not the job's",
    },
    Relation {
        key: "written",
        name: "contacts that are written, against the places of grains and walls",
        asks: Asks::Cases(|known| vec![undamped(known, (0..=ACCOUNTED).collect())]),
        holds: Holds::Written,
        breaks: "overlaps or normals of another step or of another contact, contacts that are not found, or a table that is cut off",
    },
    Relation {
        key: "conserved",
        name: "momentum and angular momentum of grains that are left alone",
        asks: Asks::Cases(|known| vec![alone(known)]),
        holds: Holds::Conserved,
        breaks: "a force on one of two grains only, or a torque with the wrong sign or arm",
    },
];

/// Grains of the bed: each of some states is run two dozen times.
pub const GRAINS: u32 = 60;
/// Steps each of which is told of.
const EVERY_STEP: u64 = 30;
/// A run is stopped after so many steps: a prime, for what is made anew every so many steps is made anew at the start too.
const STOPPED: u64 = 37;
/// Steps whose momentum is accounted for.
const ACCOUNTED: u64 = 12;
/// The bed, one without velocities, so that what is a mean of all is another one, and its copy with ids of its own.
const COPIES: usize = 3;
/// How many times as far as the bed reaches its copy is, in double and in single precision.
const FAR: [f64; 2] = [16.0, 4.0];
/// The shares of a time step that are compared.
const HALVED: [u64; 4] = [1, 2, 4, 8];
/// Steps of the undivided length after which they are, and a static overlap over the radius.
const COMPARED: [u64; 5] = [0, 8, 16, 24, 32];
const PRESSED: f64 = 1.0e-3;
/// An order of this much counts as convergence, and two in turn below that as none: a grain that begins to slide may spoil one.
const CONVERGES: f64 = 0.6;
const DOES_NOT: f64 = 0.3;
/// The engine's own runs from starts that differ in their last digits, and by how many times its resolution in double and in single precision.
const REPLICAS: u64 = 5;
const FEW_REPLICAS: u64 = 2;
const DIGITS: [f64; 2] = [64.0, 12.0];
/// Where these part by more than this share of a radius nothing is told of a difference.
const CHAOS: f64 = 0.05;
/// In coordinates of a frame that is turned by no quarter each is a sum of three, there and back.
const ASKEW_ROUNDS: f64 = 4.0;
/// In single precision contacts open and slide a step earlier or later now and then: so many times as much is rounding there.
const COARSER: f64 = 10.0;
/// How many roundings a sum may have at their worst.
const ROUNDINGS: f64 = 16.0;
/// Under these laws a bed under the punch is looked at beside one that pours.
const PRESSED_LAWS: [&str; 4] = [
    "springs",
    "friction-and-dashpots",
    "friction-with-other-constants",
    "Hertz–Mindlin with moments",
];

/// What a relation came to.
#[derive(Debug, Clone, PartialEq)]
pub enum Held {
    /// In so many states; what was seen.
    Holds(String),
    /// Where and how far it does not.
    Breaks(String),
    /// Why nothing is said.
    Open(String),
}

/// A state, the engine's run of it and the runs from starts that differ in their last digits.
pub struct Known {
    state: State,
    run: Run,
    replicas: Vec<Run>,
    resolution: Resolution,
    /// Contacts have what no table tells.
    remembers: bool,
}

/// What an engine makes of the states as they are.
pub struct Itself<'a> {
    known: Vec<Known>,
    /// What its law has, where it is one of its own.
    own: &'a [Own],
    /// Rules that it declares.
    rules: Rules,
    lacks: &'a dyn Fn(&Case) -> Option<String>,
}

/// How much an engine is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Depth {
    /// All of a bed's states.
    All,
    /// The one whose law has most terms, of an engine whose resolution is known.
    Richest(Resolution),
}

impl<'a> Itself<'a> {
    /// Runs those of a bed's states that the engine has the parts for; what it refuses is left out.
    pub fn new<E: From<NativeError>>(
        states: Vec<State>,
        depth: Depth,
        own: Option<&'a [Own]>,
        lacks: &'a dyn Fn(&Case) -> Option<String>,
        engine: &mut Engine<'_, E>,
    ) -> Result<Self, E> {
        let asked = |mut state: State| {
            let case = &mut state.case;
            let start = |one: Start| state.start == one.name();
            let is_rich = PRESSED_LAWS.contains(&state.law.as_str());
            // A bed that was pressed and is let go has contacts all over, so an engine without a punch is asked for it too.
            if start(Start::UnderPunch) && lacks(case).is_some() {
                case.punch = None;
            }
            let is_told = start(Start::Pouring)
                || is_rich && (start(Start::UnderPunch) || start(Start::AtRest) && own.is_some());
            let moves_along = case.model.obstacles.is_empty();
            case.moments.push(STOPPED);
            case.moments.sort_unstable();
            let is_asked = !state.drawn && is_told && moves_along && lacks(case).is_none();
            is_asked.then_some(state)
        };
        let mut states: Vec<State> = states.into_iter().filter_map(asked).collect();
        let (mut resolution, mut replicas) = (Resolution::DOUBLE, REPLICAS);
        if let Depth::Richest(known) = depth {
            (resolution, replicas) = (known, FEW_REPLICAS);
            let terms = |state: &State| {
                let law = &state.case.model.law;
                let moments = law.contact.rolling.is_some();
                let terms = [
                    law.has_friction(),
                    law.rotates(),
                    law.has_dashpots(),
                    moments,
                ];
                (
                    terms.into_iter().filter(|has| *has).count(),
                    state.case.punch.is_none(),
                )
            };
            // One in the plane and one in space.
            states.sort_by_key(|state| (state.case.bodies.in_space(), Reverse(terms(state))));
            states.dedup_by_key(|state| state.case.bodies.in_space());
        }
        let probed: Vec<&Case> = states
            .iter()
            // Where contacts hardly change an engine seems coarser than it is.
            .filter(|state| state.start == Start::Pouring.name())
            .filter(|state| state.probed && depth == Depth::All)
            .map(|state| &state.case)
            .collect();
        for case in probed {
            let cases = Resolution::cases(case);
            let answers = engine(&cases.iter().collect::<Vec<_>>())?;
            let measured = Resolution::measured(case, &answers);
            resolution = measured.map_or(resolution, |measured| resolution.coarser(measured));
        }
        let one = |state: &State| {
            let changed =
                (1..=replicas).map(|replica| last_digits(&state.case, resolution, replica));
            [state.case.clone()].into_iter().chain(changed).collect()
        };
        let asked: Vec<Vec<Case>> = states.iter().map(one).collect();
        let answers = in_one_start(engine, &asked, false)?;
        let known = states.into_iter().zip(answers).filter_map(|(state, runs)| {
            let mut runs = runs.ok()?.into_iter();
            Some(Known {
                run: runs.next()?,
                replicas: runs.collect(),
                remembers: own.is_none() && state.case.model.law.has_history(),
                state,
                resolution,
            })
        });
        Ok(Itself {
            known: known.collect(),
            own: own.unwrap_or_default(),
            rules: Rules::default(),
            lacks,
        })
    }

    /// Of an engine with these rules.
    pub fn under(self, rules: Rules) -> Self {
        Itself { rules, ..self }
    }
}

/// For each list of cases the runs, or why one of them was refused; all backwards where that is asked for.
fn in_one_start<E>(
    engine: &mut Engine<'_, E>,
    asked: &[Vec<Case>],
    backwards: bool,
) -> Result<Vec<Result<Vec<Run>, String>>, E> {
    let mut all: Vec<&Case> = asked.iter().flatten().collect();
    if backwards {
        all.reverse();
    }
    let mut answers: Vec<Answer> = match all.is_empty() {
        true => Vec::new(),
        false => engine(&all)?,
    };
    if backwards {
        answers.reverse();
    }
    let mut answers = answers.into_iter();
    let mut next = |cases: &Vec<Case>| answers.by_ref().take(cases.len()).collect();
    Ok(asked.iter().map(&mut next).collect())
}

impl Relation {
    /// Whether it is asked for so; shorter steps cost most, and are left out where an engine is held against a reference too.
    pub fn is_asked(&self, depth: Depth) -> bool {
        let is_dear = [Holds::Converges, Holds::Passive].contains(&self.holds);
        !is_dear || depth == Depth::All
    }

    /// Whether it holds in every state; the first one in which it does not is told of.
    pub fn held<E>(&self, itself: &Itself<'_>, engine: &mut Engine<'_, E>) -> Result<Held, E> {
        if let Some((_, why)) = self.unless().filter(|(own, _)| itself.own.contains(own)) {
            return Ok(Held::Open(format!("the engine says that {why}")));
        }
        if let Some(why) = self.broken_by(&itself.rules) {
            return Ok(Held::Open(format!("by the engine's rules {why}")));
        }
        let mut asked = Vec::new();
        for known in &itself.known {
            let cases = self.asks.there(known);
            if !cases.is_empty() && cases.iter().all(|case| (itself.lacks)(case).is_none()) {
                asked.push((known, cases));
            }
        }
        let cases: Vec<Vec<Case>> = asked.iter().map(|(_, cases)| cases.clone()).collect();
        let (mut holds, mut opened) = (Vec::new(), Vec::new());
        for ((known, cases), answer) in asked.into_iter().zip(in_one_start(engine, &cases, true)?) {
            let state = &known.state.case.name;
            let found = match answer {
                Err(why) => Held::Open(format!("the engine refused: {why}")),
                Ok(runs) => {
                    let runs = self.asks.back(known, runs);
                    match self.found(known, &cases, runs.clone(), &itself.rules) {
                        Held::Breaks(said) if self.holds == Holds::EveryBit => {
                            known.unless_it_never_repeats(said, &runs, engine)?
                        }
                        found => found,
                    }
                }
            };
            match found {
                Held::Holds(said) => holds.push(said),
                Held::Open(why) => opened.push(format!("{state}: {why}")),
                Held::Breaks(said) => return Ok(Held::Breaks(format!("{state}: {said}"))),
            }
        }
        let none = || "the engine has no state for it".to_owned();
        let undecided = |(count, why): (usize, String)| match count {
            0 => String::new(),
            _ => format!("; not decided in {count}, first in {why}"),
        };
        let count = opened.len();
        let first = opened.into_iter().next();
        Ok(match holds.last() {
            Some(said) => {
                let more = undecided((count, first.unwrap_or_default()));
                Held::Holds(format!("in {} states {said}{more}", holds.len()))
            }
            None => Held::Open(first.unwrap_or_else(none)),
        })
    }

    /// It is not asked of a law that has this.
    fn unless(&self) -> Option<(Own, &'static str)> {
        match self.key {
            "units" => Some((
                Own::Constants,
                "its law has constants of its own, with units",
            )),
            "resumed" => Some((Own::Memory, "its contacts remember what tables do not tell")),
            "passive" => Some((Own::Active, "something drives its grains")),
            "account" | "conserved" | "moving" => {
                Some((Own::Unlisted, "it has forces that no contact table tells"))
            }
            _ => None,
        }
    }

    /// Why it cannot hold of a right engine with these rules.
    fn broken_by(&self, rules: &Rules) -> Option<&'static str> {
        let is_start = rules.given_velocities == GivenVelocities::HalfStepBefore
            && rules.written_velocities == WrittenVelocities::HalfStep;
        match self.key {
            "resumed" if !is_start => Some("the velocities that are written are no start"),
            "conserved" if rules.integration != Integration::KickDrift => {
                Some("a step keeps no angular momentum")
            }
            "conserved" if rules.torque_arms == Arms::WholeRadii => {
                Some("the two torques of a pair are more than its force has")
            }
            _ => None,
        }
    }

    fn found(&self, known: &Known, cases: &[Case], runs: Vec<Run>, rules: &Rules) -> Held {
        let bits = || runs.iter().find_map(|run| known.other_bits(run));
        match self.holds {
            Holds::EveryBit => match bits() {
                None => Held::Holds("every bit is the same".to_owned()),
                Some(said) => Held::Breaks(said),
            },
            Holds::Exactly if bits().is_none() => Held::Holds("every bit is the same".to_owned()),
            Holds::Exactly => known.rounding(&runs, 1.0),
            Holds::Rounding(larger) => known.rounding(&runs, larger),
            Holds::Together => known.together(&cases[0], runs),
            Holds::Converges => converges(&runs, known.resolution),
            Holds::Touches => touches(&runs[0]),
            Holds::Passive => passive(&cases[0], &runs[0]),
            Holds::Account => account(&cases[0], &runs[0], known.resolution, rules),
            Holds::Written => written(&cases[0], &runs[0], known.resolution),
            Holds::Conserved => conserved(&runs[0], cases[0].model.dt, known.resolution),
        }
    }
}

impl Known {
    /// The moments of a run of this state that another one has too.
    fn common(run: &[Snapshot], with: &[Snapshot]) -> Run {
        let is_in = |moment: &&Snapshot| with.iter().any(|other| other.step == moment.step);
        run.iter().filter(is_in).cloned().collect()
    }

    /// Where a run has other bits than this one.
    fn other_bits(&self, run: &[Snapshot]) -> Option<String> {
        let own = Known::common(&self.run, run);
        let theirs = Known::common(run, &self.run);
        let mut pairs = own.iter().zip(&theirs);
        let (own, _) = pairs.find(|(own, their)| own.digest() != their.digest())?;
        Some(format!("after {} steps bits are others", own.step))
    }

    /// Where bits are others by rounding alone, and are so whenever the engine runs, that is no fault of what was changed.
    fn unless_it_never_repeats<E>(
        &self,
        said: String,
        runs: &[Run],
        engine: &mut Engine<'_, E>,
    ) -> Result<Held, E> {
        let rounding = self.rounding(runs, 1.0);
        if matches!(rounding, Held::Breaks(_)) {
            return Ok(Held::Breaks(said));
        }
        let again = engine(&[&self.state.case])?.into_iter().next();
        let repeats = again.is_some_and(|run| run.is_ok_and(|run| self.other_bits(&run).is_none()));
        Ok(match (repeats, rounding) {
            (true, _) => Held::Breaks(said),
            (_, Held::Holds(_)) => Held::Holds(
                "what differs is rounding, and bits are others whenever it runs, as where threads add in the order in which they come"
                    .to_owned(),
            ),
            (_, open) => open,
        })
    }

    /// Whether runs are as far from this one as those from starts with other last digits.
    fn rounding(&self, runs: &[Run], larger: f64) -> Held {
        self.among(&self.state.case, &self.run, &self.replicas, runs, larger)
    }

    /// Whether the last of a case's runs is as far from the first one as those between are.
    fn together(&self, case: &Case, mut runs: Vec<Run>) -> Held {
        let last = runs.pop().unwrap_or_default();
        match runs.split_first() {
            Some((own, replicas)) => self.among(case, own, replicas, &[last], ASKEW_ROUNDS),
            None => Held::Open("nothing is told".to_owned()),
        }
    }

    /// Whether runs are as far from a case's own as its replicas are, in coordinates that are at most so many times as large.
    fn among(&self, case: &Case, own: &Run, replicas: &[Run], runs: &[Run], larger: f64) -> Held {
        let mut noise = self.resolution.noise();
        noise.position *= larger;
        let allowed = match self.resolution.is_double() {
            true => FACTOR,
            false => COARSER * FACTOR,
        };
        if self.resolution.is_too_coarse(reach(&case.bodies)) {
            return Held::Open(
                "it takes no notice of changes of its start that single precision notices"
                    .to_owned(),
            );
        }
        let mut most = 0.0f64;
        for run in runs {
            let theirs = Known::common(run, own);
            let common = |replica: &Run| Known::common(replica, run);
            let replicas: Vec<Run> = replicas.iter().map(common).collect();
            let envelope = Envelope::of(case.clone(), Known::common(own, run), &replicas, noise);
            if envelope.widest() > CHAOS {
                return Held::Open("runs from starts with other last digits part too fast".into());
            }
            let Some(far) = envelope.farthest(&theirs) else {
                return Held::Breaks("other moments are told".to_owned());
            };
            if far.ratio > allowed {
                let (quantity, unit) = far.quantity.name();
                let after = far.left_after.unwrap_or(far.step);
                let said = format!(
                    "after {after} steps it is farther off than rounding takes it; it is farthest after {}: the {quantity} of {} is off by {:.1e} \
                     {unit}, {:.1e} times as far as with other last digits",
                    far.step, far.body, far.apart, far.ratio
                );
                return Held::Breaks(said);
            }
            most = most.max(far.ratio);
        }
        Held::Holds(format!(
            "at most {most:.1} times as far off as with other last digits"
        ))
    }
}

/// The case from a start that differs by some of the last digits that the engine has.
fn last_digits(case: &Case, resolution: Resolution, replica: u64) -> Case {
    let digits = DIGITS[usize::from(!resolution.is_double())];
    let mut source = Source::new(b"crossgrain: other last digits   ", replica);
    let mut noise = || 2.0 * source.uniform() - 1.0;
    let mut changed = case.clone();
    let length = digits * (resolution.position * reach(&case.bodies)).max(resolution.overlap);
    let bodies = &mut changed.bodies;
    let places = [&mut bodies.x, &mut bodies.z, &mut bodies.y];
    for coordinate in places.into_iter().flatten() {
        *coordinate += length * noise();
    }
    let speeds = [&mut bodies.vx, &mut bodies.vz, &mut bodies.spin];
    let across = [&mut bodies.vy, &mut bodies.spin_x, &mut bodies.spin_z];
    for speed in speeds.into_iter().chain(across).flatten() {
        *speed *= 1.0 + digits * resolution.velocity * noise();
    }
    changed
}

/// How far the grains reach from where coordinates are zero, m.
fn reach(bodies: &Bodies) -> f64 {
    let places = [&bodies.x, &bodies.z, &bodies.y].into_iter().flatten();
    let all = places.zip(bodies.radius.iter().cycle());
    all.fold(0.0, |most, (place, radius)| most.max(place.abs() + radius))
}

fn told_here(frame: &Frame, run: &[Snapshot]) -> Run {
    run.iter().map(|moment| frame.told_here(moment)).collect()
}

fn mirrors(known: &Known) -> Vec<Frame> {
    match known.state.case.bodies.in_space() {
        true => vec![Frame::MIRRORED, Frame::FRONT_TO_BACK],
        false => vec![Frame::MIRRORED],
    }
}

/// Grains that are left alone as they are, with other last digits, and as this makes of them.
fn beside(known: &Known, changed: impl Fn(&Case) -> Case) -> Vec<Case> {
    let here = alone(known);
    let mut all = vec![here.clone()];
    let replicas = 1..=known.replicas.len() as u64;
    all.extend(replicas.map(|replica| last_digits(&here, known.resolution, replica)));
    all.push(changed(&here));
    all
}

fn askew(known: &Known) -> Vec<Case> {
    beside(known, |here| no_quarter(known).case(here))
}

fn from_moving(known: &Known) -> Vec<Case> {
    beside(known, |here| {
        let mut moves = here.clone();
        for (column, speed) in moves.bodies.columns_mut()[3..6]
            .iter_mut()
            .zip(drift(known))
        {
            column.iter_mut().for_each(|velocity| *velocity += speed);
        }
        moves
    })
}

/// About as fast as the fastest grain, so that no more is rounded, m/s along x, y and z.
fn drift(known: &Known) -> [f64; 3] {
    let bodies = &known.state.case.bodies;
    let speeds = (0..bodies.len()).map(|id| norm(bodies.velocity(id)));
    let fastest = speeds.fold(0.0, f64::max);
    [0.5, -0.2, 0.3].map(|share| share * fastest)
}

/// What one sees who moves so many times as fast as the drift against it.
fn drifted(known: &Known, mut moment: Snapshot, times: f64) -> Snapshot {
    let (speed, time) = (drift(known), known.state.case.model.dt * moment.step as f64);
    let columns = moment.bodies.columns_mut();
    for (axis, column) in columns.into_iter().take(6).enumerate() {
        let by = times * speed[axis % 3] * if axis < 3 { time } else { 1.0 };
        column.iter_mut().for_each(|value| *value += by);
    }
    for contact in &mut moment.contacts {
        contact.point[0] += times * speed[0] * time;
        contact.point[1] += times * speed[2] * time;
    }
    for across in &mut moment.across {
        across.point += times * speed[1] * time;
    }
    moment
}

fn no_quarter(known: &Known) -> Frame {
    match known.state.case.bodies.in_space() {
        true => Frame::ASKEW,
        false => Frame::ASLANT,
    }
}

/// A punch goes down, and gravity has no component along y.
fn quarters(known: &Known) -> Vec<Frame> {
    let case = &known.state.case;
    let mut frames = Vec::new();
    if case.punch.is_none() {
        frames.push(Frame::TURNED);
        if case.bodies.in_space() && case.model.gravity[0] == 0.0 {
            frames.push(Frame::ABOUT_UP);
        }
    }
    frames
}

fn shifted(known: &Known, sign: f64) -> Frame {
    let case = &known.state.case;
    let across = f64::from(u8::from(case.bodies.in_space()));
    let way = [0.37, -1.3 * across, 0.71];
    Frame::shifted(way.map(|share| sign * share * reach(&case.bodies)))
}

/// From the middle of its own run on, where positions and velocities tell all.
fn resumed(known: &Known) -> Vec<Case> {
    let case = &known.state.case;
    let middle = known.run.iter().find(|moment| moment.step == STOPPED);
    let Some(middle) = middle.filter(|_| !known.remembers) else {
        return Vec::new();
    };
    let later = case.moments.iter().filter(|step| **step >= STOPPED);
    vec![Case {
        bodies: middle.bodies.clone(),
        punch: middle.punch,
        moments: later.map(|step| step - STOPPED).collect(),
        ..case.clone()
    }]
}

/// How far the copy is, m: no power of two.
fn far(known: &Known) -> f64 {
    FAR[usize::from(!known.resolution.is_double())] * reach(&known.state.case.bodies)
}

/// The last copy is to the right, and the one at rest to the left.
fn away(copy: usize) -> f64 {
    [0.0, -1.0, 1.0][copy]
}

/// With copies of its grains far away, between copies of its upright walls.
fn doubled(known: &Known) -> Vec<Case> {
    let mut both = known.state.case.clone();
    if both.punch.is_some() {
        return Vec::new();
    }
    let here = both.clone();
    for copy in 1..COPIES {
        let mut there = Frame::shifted([away(copy) * far(known), 0.0, 0.0]).case(&here);
        if copy == 1 {
            let moving = &mut there.bodies.columns_mut()[3..9];
            moving.iter_mut().for_each(|column| column.fill(0.0));
        }
        both.bodies.append(there.bodies);
        let upright = |wall: &Wall| wall.axis == Axis::X;
        let walls = there.model.walls.into_iter().filter(upright);
        both.model.walls.extend(walls);
    }
    vec![both]
}

/// The bed and its copy, each as if it had been alone.
fn one_by_one(known: &Known, runs: Vec<Run>) -> Vec<Run> {
    let case = &known.state.case;
    let (grains, walls) = (case.bodies.len(), case.model.walls.len());
    let is_upright = |wall: &usize| case.model.walls[*wall].axis == Axis::X;
    let upright: Vec<usize> = (0..walls).filter(is_upright).collect();
    let mut alone = Vec::new();
    for which in [0, COPIES - 1] {
        let frame = Frame::shifted([away(which) * far(known), 0.0, 0.0]);
        let first = which * grains;
        let part = |moment: &Snapshot| {
            let mut part = moment.clone();
            for column in part.bodies.columns_mut() {
                *column = column.iter().skip(first).take(grains).copied().collect();
            }
            let material = part.bodies.material.into_iter().skip(first).take(grains);
            part.bodies.material = material.collect();
            let here = first..first + grains;
            let is_here = |contact: &Contact| here.contains(&(contact.id2 as usize));
            let across = moment.across.iter().zip(&moment.contacts);
            let across = across.filter(|(_, contact)| is_here(contact));
            part.across = across.map(|(across, _)| *across).collect();
            part.contacts.retain(is_here);
            for contact in &mut part.contacts {
                contact.id2 -= first as u32;
                let one = contact.id1 as usize;
                contact.id1 = match one.checked_sub(COPIES * grains) {
                    None => one.saturating_sub(first),
                    Some(wall) if wall < walls => grains + wall,
                    Some(copy) => {
                        let of_copy = (copy - walls).checked_rem(upright.len());
                        grains + of_copy.map_or(walls, |at| upright[at])
                    }
                } as u32;
            }
            frame.told_here(&part)
        };
        alone.extend(runs.iter().map(|run| run.iter().map(part).collect()));
    }
    alone
}

/// Without damping, looked at after these steps.
fn undamped(known: &Known, moments: Vec<u64>) -> Case {
    let mut case = known.state.case.at(moments);
    case.model.alpha = 0.0;
    case
}

/// Without damping, gravity, walls and punch.
fn alone(known: &Known) -> Case {
    let mut alone = undamped(known, MOMENTS.to_vec());
    alone.model.gravity = [0.0; 2];
    alone.model.walls.clear();
    alone.punch = None;
    alone
}

/// The springs' force at an overlap: this times a power of it.
struct Spring {
    factor: f64,
    power: f64,
}

impl Spring {
    fn force(&self, overlap: f64) -> f64 {
        self.factor * overlap.powf(self.power)
    }
}

/// Of the first grain on the floor, and on the second.
fn springs(law: &Law, bodies: &Bodies) -> [Spring; 2] {
    let r = &bodies.radius;
    let (factors, power) = match law.contact.springs {
        Springs::Linear => ([law.modulus * r[0], law.normal_stiffness(r[0], r[1])], 1.0),
        Springs::HertzMindlin => {
            let solid = |id: usize| law.solid(bodies.material.get(id).copied().unwrap_or(0));
            let middle = r[0] * r[1] / (r[0] + r[1]);
            let [floor, _] = solid(0).hertz_mindlin(law.solid(0), r[0]);
            let [pair, _] = solid(0).hertz_mindlin(solid(1), middle);
            ([floor, pair], 1.5)
        }
    };
    factors.map(|factor| Spring { factor, power })
}

/// The time of a contact in steps of the case, at least, and by how much these are divided.
const SHARE: u64 = 64;
/// So many contacts' times are waited for until two grains have parted.
const CONTACTS: f64 = 3.0;

/// The first two grains, alone, run into each other across, and spin; with the local damping of the state.
fn impact(known: &Known) -> Case {
    let mut case = alone(known);
    case.model.alpha = known.state.case.model.alpha;
    case.model.dt /= SHARE as f64;
    let all = &known.state.case.bodies;
    let (speed, time) = speed_and_time(&case.model.law, all);
    let steps = (CONTACTS * time / case.model.dt).ceil() as u64;
    case.moments = vec![0, steps];
    let apart = all.radius[0] + all.radius[1] + 0.5 * speed * case.model.dt;
    let mut two = all.clone();
    for column in two.columns_mut() {
        column.truncate(2);
    }
    two.material.truncate(2);
    // Towards each other, and across that.
    let (towards, along) = ([0.6, 0.8], [-0.8, 0.6]);
    for id in 0..2 {
        let side = [-0.5, 0.5][id];
        [two.x[id], two.z[id]] = towards.map(|way| side * apart * way);
        let velocity = [0, 1].map(|at| -side * speed * (towards[at] + 0.7 * along[at]));
        [two.vx[id], two.vz[id]] = velocity;
        if let Some(spin) = two.spin.get_mut(id) {
            *spin = [0.3, 0.5][id] * speed / all.radius[0];
        }
        for none in [&mut two.y, &mut two.vy, &mut two.spin_x, &mut two.spin_z] {
            if let Some(value) = none.get_mut(id) {
                *value = 0.0;
            }
        }
    }
    case.bodies = two;
    case
}

/// How fast two grains meet that the springs let overlap by ten times what presses them in a stack, and how long they touch, m/s and s.
fn speed_and_time(law: &Law, bodies: &Bodies) -> (f64, f64) {
    let [_, pair] = springs(law, bodies);
    let m = &bodies.mass;
    let overlap = 10.0 * PRESSED * bodies.radius[0];
    let energy = pair.force(overlap) * overlap / (pair.power + 1.0);
    let speed = (2.0 * energy * (m[0] + m[1]) / (m[0] * m[1])).sqrt();
    (speed, PI * overlap / speed)
}

/// A step of a contact's time over its length is what a method of first order is off by, tenfold.
fn passive(case: &Case, run: &Run) -> Held {
    let [before, after] = [&run[0], &run[run.len() - 1]];
    let touch = |moment: &Snapshot| !moment.contacts.is_empty();
    if touch(after) || run.len() < 2 {
        return Held::Open("two grains that met do not part".to_owned());
    }
    let energy = |moment: &Snapshot| -> f64 {
        let bodies = &moment.bodies;
        let of_grain = |id: usize| {
            let inertia = bodies.inertia.get(id).copied().unwrap_or(0.0);
            let [v, w] = [bodies.velocity(id), bodies.angular_velocity(id)];
            0.5 * (bodies.mass[id] * dot(v, v) + inertia * dot(w, w))
        };
        (0..bodies.len()).map(of_grain).sum()
    };
    let gain = energy(after) / energy(before) - 1.0;
    let [here, there] = [before, after].map(|moment| moment.bodies.velocity(0));
    if here == there {
        return Held::Open("two grains that meet do not feel each other".to_owned());
    }
    let allowed = 10.0 * case.model.dt / speed_and_time(&case.model.law, &case.bodies).1;
    match gain <= allowed {
        true => Held::Holds(format!("they lose {:.3} of it", -gain)),
        false => Held::Breaks(format!(
            "two grains that met have {gain:.1e} of their kinetic energy more than before, and {allowed:.0e} is what steps so short may cost"
        )),
    }
}

/// One grain on another on the floor, a little beside where they would stand still, under a weight that keeps them together; a step is
/// divided by so much.
fn stack(known: &Known, divided: u64) -> Case {
    let mut case = undamped(known, COMPARED.map(|step| step * divided).to_vec());
    let (model, all) = (&mut case.model, &known.state.case.bodies);
    let (r, m) = (&all.radius, &all.mass);
    let [floor, pair] = springs(&model.law, all);
    let force = floor.force(PRESSED * r[0]);
    let overlap = |force: f64| (force / pair.factor).powf(1.0 / pair.power);
    let gravity = force / (m[0] + m[1]);
    let pressed = 1.3 * PRESSED * r[0];
    let above = 1.3 * overlap(m[1] * gravity);
    let mut two = Bodies::default();
    two.push([0.0, r[0] - pressed], [0.0; 2], r[0], m[0]);
    let lean = 0.1 * r[0];
    let height = (r[0] + r[1] - above).powi(2) - lean * lean;
    two.push([lean, two.z[0] + height.sqrt()], [0.0; 2], r[1], m[1]);
    if all.rotate() {
        two.spin = vec![0.0; 2];
        two.inertia = all.inertia[..2].to_vec();
    }
    if all.in_space() {
        (two.y, two.vy) = (vec![0.0; 2], vec![0.0; 2]);
        (two.spin_x, two.spin_z) = (two.spin.clone(), two.spin.clone());
        two.material = all.material.iter().take(2).copied().collect();
    }
    model.gravity = [0.0, -gravity];
    model.dt /= divided as f64;
    model.walls = vec![Wall::at(Axis::Z, 0.0)];
    case.bodies = two;
    case
}

/// How many contacts of each kind bear a force at most, and how many of them one grain has.
fn touches(run: &Run) -> Held {
    let mut most = [0; 3];
    for moment in run {
        let grains = moment.bodies.len();
        let mut of_grain = vec![0; grains];
        let mut kinds = [0; 2];
        let bears = |contact: &&Contact| contact.normal_force != 0.0;
        for contact in moment.contacts.iter().filter(bears) {
            kinds[usize::from(contact.id1 as usize >= grains)] += 1;
            for id in [contact.id1, contact.id2] {
                if let Some(count) = of_grain.get_mut(id as usize) {
                    *count += 1;
                }
            }
        }
        let here = [kinds[0], kinds[1], of_grain.into_iter().max().unwrap_or(0)];
        most = [0, 1, 2].map(|at| most[at].max(here[at]));
    }
    let [pairs, walls, of_one] = most;
    if pairs == 0 || walls == 0 {
        return Held::Open(format!(
            "{pairs} between grains and {walls} at walls bear a force, so nothing is known of the others"
        ));
    }
    Held::Holds(format!(
        "there are at most {pairs} between grains and {walls} at walls, and {of_one} of one grain"
    ))
}

/// How much closer the second pair of runs is than the first.
fn converges(runs: &[Run], resolution: Resolution) -> Held {
    let pairs = |moment: &Snapshot| moment.contacts.iter().map(Contact::ids).collect::<Vec<_>>();
    let together = pairs(&runs[0][0]);
    let parted = |moment: &Snapshot| pairs(moment) != together;
    if together.len() != 2 || runs.iter().flatten().any(parted) {
        return Held::Open("the grains do not stay together".to_owned());
    }
    let apart = |one: &Run, two: &Run| {
        let moments = one.iter().zip(two);
        let apart = moments.flat_map(|(a, b)| {
            let apart = |id: usize| minus(a.bodies.position(id), b.bodies.position(id));
            (0..a.bodies.len().min(b.bodies.len())).flat_map(apart)
        });
        apart.fold(0.0f64, |most, apart| most.max(apart.abs()))
    };
    let apart: Vec<f64> = runs.windows(2).map(|two| apart(&two[0], &two[1])).collect();
    if apart.iter().any(|apart| !apart.is_finite()) {
        return Held::Breaks("places are no numbers".to_owned());
    }
    let (extent, _) = largest(&runs[0]);
    let rounding = 1.0e3 * (resolution.position * extent).max(resolution.overlap);
    if apart.iter().any(|apart| *apart < rounding) {
        return Held::Open("rounding hides what a time step changes".to_owned());
    }
    let orders = [0, 1].map(|at| (apart[at] / apart[at + 1]).log2());
    let most = orders[0].max(orders[1]);
    if orders[1] >= CONVERGES {
        return Held::Holds(format!("the error falls with order {:.2}", orders[1]));
    }
    if most > DOES_NOT {
        return Held::Open("something begins in between, such as sliding".to_owned());
    }
    let said = format!(
        "places change by {:.1e}, {:.1e} and {:.1e} m as the step is halved three times: at best order {most:.2}, and at least 1 is expected",
        apart[0], apart[1], apart[2]
    );
    Held::Breaks(said)
}

/// How large a force is rounding, N, on each grain: of the velocity that tells it, of the place that makes it, and of the sum.
fn rounding(moment: &Snapshot, dt: f64, resolution: Resolution) -> Vec<f64> {
    let bodies = &moment.bodies;
    let speeds = [&bodies.vx, &bodies.vz, &bodies.vy].into_iter().flatten();
    let fastest = speeds.fold(0.0f64, |most, speed| most.max(speed.abs()));
    let length = (resolution.position * reach(bodies)).max(resolution.overlap);
    let of_grain =
        |mass: &f64| mass * (resolution.velocity * fastest / dt + 0.25 * length / (dt * dt));
    let mut all: Vec<f64> = bodies.mass.iter().map(of_grain).collect();
    for contact in &moment.contacts {
        let force = contact.normal_force.hypot(contact.tangential_force);
        for id in [contact.id1, contact.id2] {
            if let Some(of_grain) = all.get_mut(id as usize) {
                *of_grain += resolution.velocity.max(resolution.position) * force;
            }
        }
    }
    all.iter().map(|force| ROUNDINGS * force).collect()
}

/// m Δv against Δt times forces and weight: the work of all forces is then the kinetic energy that is gained, too. Where velocities
/// of whole steps are written, half of a gain is of the forces at its end.
fn account(case: &Case, run: &Run, resolution: Resolution, rules: &Rules) -> Held {
    let at_end = match rules.written_velocities {
        WrittenVelocities::HalfStep => 0.0,
        WrittenVelocities::WholeStep => 0.5,
    };
    let begins_whole = rules.given_velocities == GivenVelocities::AtStart;
    let (dt, gravity) = (case.model.dt, case.model.gravity);
    // Moments against rolling are in no table.
    let turns = run[0].bodies.rotate() && case.model.law.contact.rolling.is_none();
    let mut worst = Worst::default();
    for pair in run.windows(2) {
        let (now, next) = (&pair[0], &pair[1]);
        let mass = &now.bodies.mass;
        let at_begin = match now.step {
            0 if begins_whole => 0.5,
            0 => 1.0,
            _ => 1.0 - at_end,
        };
        let weight = |m: &f64| [gravity[0], 0.0, gravity[1]].map(|g| (at_begin + at_end) * m * g);
        let mut forces: Vec<[f64; 3]> = mass.iter().map(weight).collect();
        let mut torques = vec![[0.0; 3]; mass.len()];
        // Arms may be whole radii.
        let mut of_arms = vec![0.0; mass.len()];
        for (share, moment) in [(at_begin, now), (at_end, next)] {
            for row in Table::from(moment).rows() {
                let (contact, more) = (row.contact, row.force());
                for (id, sign) in [(contact.id1, -share), (contact.id2, share)] {
                    let id = id as usize;
                    if let Some(force) = forces.get_mut(id) {
                        let more = times(sign, more);
                        *force = plus(*force, more);
                        let arm = minus(row.point(), moment.bodies.position(id));
                        torques[id] = plus(torques[id], cross(arm, more));
                        of_arms[id] += share * (contact.overlap * contact.tangential_force).abs();
                    }
                }
            }
        }
        for (id, least) in rounding(now, dt, resolution).into_iter().enumerate() {
            let [before, after] = [now, next].map(|moment| moment.bodies.velocity(id));
            let shown = [0, 1, 2].map(|axis| mass[id] * (after[axis] - before[axis]) / dt);
            let told = forces[id];
            let off = minus(shown, told);
            worst.see(norm(off) / least, || {
                format!(
                    "in step {} grain {id} gains what a force of {} N gives it, and table and gravity tell of {} N: it has {} N more",
                    next.step,
                    in_words(shown, &now.bodies),
                    in_words(told, &now.bodies),
                    in_words(off, &now.bodies)
                )
            });
            if !turns {
                continue;
            }
            let [before, after] = [now, next].map(|moment| moment.bodies.angular_velocity(id));
            let shown = times(now.bodies.inertia[id] / dt, minus(after, before));
            let off = minus(shown, torques[id]);
            let least = least * now.bodies.radius[id] + of_arms[id];
            worst.see(norm(off) / least, || {
                format!(
                    "in step {} the spin of grain {id} changes by {:.1e} of what its forces do at the points where they are written",
                    next.step,
                    norm(shown) / norm(torques[id])
                )
            });
        }
    }
    let turned = if turns { " and turn" } else { "" };
    worst.held(&format!(
        "the written forces are those that act{turned}, to rounding"
    ))
}

/// Where grains are so near to each other and to walls that they overlap, how far, along which normal and about which point.
fn written(case: &Case, run: &Run, resolution: Resolution) -> Held {
    let mut worst = Worst::default();
    for moment in run {
        let (bodies, ids) = (&moment.bodies, case.ids());
        let grains = bodies.len() as u32;
        let least = (resolution.position * reach(bodies)).max(resolution.overlap);
        let length = ROUNDINGS * least;
        let place = |id: u32| bodies.position(id as usize);
        let radius = |id: u32| bodies.radius[id as usize];
        // From the first body to the grain, and how far they overlap.
        let between = |first: u32, grain: u32| -> Option<([f64; 3], f64)> {
            let Some(wall) = case.wall(first) else {
                let way = (first < grains).then(|| minus(place(grain), place(first)))?;
                return Some((way, radius(first) + radius(grain) - norm(way)));
            };
            let (axis, mut way) = (wall.axis.in_space(), [0.0; 3]);
            way[axis] = place(grain)[axis] - wall.place;
            Some((way, radius(grain) - norm(way)))
        };
        let mut listed = BTreeSet::new();
        for row in Table::from(moment).rows() {
            let (first, grain) = row.ids();
            listed.insert((first, grain));
            let Some((way, overlap)) = between(first, grain) else {
                continue;
            };
            let (step, distance) = (moment.step, norm(way));
            let (told, normal) = (row.contact.overlap, times(1.0 / distance, way));
            worst.see((told - overlap).abs() / length, || {
                format!("in step {step} {first} and {grain} overlap by {overlap:.6e} m, and the table tells of {told:.6e} m")
            });
            let askew = norm(minus(row.normal(), normal));
            worst.see(askew * distance / (2.0 * length), || {
                format!("in step {step} the normal of {first} and {grain} is off by {askew:.1e} of its length")
            });
            let point = minus(place(grain), times(radius(grain) - 0.5 * overlap, normal));
            let beside = norm(minus(row.point(), point));
            worst.see((beside - overlap.abs()) / length, || {
                format!("in step {step} the contact point of {first} and {grain} is {beside:.1e} m from where they overlap by {overlap:.1e} m")
            });
        }
        let walls = (0..case.model.walls.len()).map(|index| ids.wall(index));
        for first in (0..grains).chain(walls) {
            let others = if first < grains { first + 1 } else { 0 };
            for grain in others..grains {
                let overlap = between(first, grain).map_or(0.0, |both| both.1);
                if !listed.contains(&(first, grain)) {
                    worst.see(overlap / length, || {
                        format!("in step {} {first} and {grain} overlap by {overlap:.6e} m, and are in no table", moment.step)
                    });
                }
            }
        }
    }
    worst.held("overlaps, normals and points are those of the places, to rounding, and no contact is left out")
}

/// How many times as far off as rounding allows something is at most, and what.
#[derive(Default)]
struct Worst(f64, String);

impl Worst {
    fn see(&mut self, off: f64, said: impl FnOnce() -> String) {
        let off = if off.is_nan() { f64::INFINITY } else { off };
        if off > self.0 {
            *self = Worst(off, said());
        }
    }

    fn held(self, well: &str) -> Held {
        match self.0 <= 1.0 {
            true => Held::Holds(well.to_owned()),
            false => Held::Breaks(self.1),
        }
    }
}

/// A vector with the components that these grains have.
fn in_words([x, y, z]: [f64; 3], bodies: &Bodies) -> String {
    match bodies.in_space() {
        true => format!("({x:.6e}, {y:.6e}, {z:.6e})"),
        false => format!("({x:.6e}, {z:.6e})"),
    }
}

/// Momentum along x, z and y, and angular momentum about those of y, x and z through the origin, with positions at the end of the step in
/// which velocities held.
fn momenta(bodies: &Bodies) -> [f64; 6] {
    let mut sums = [0.0; 6];
    for id in 0..bodies.len() {
        let m = bodies.mass[id];
        let [px, py, pz] = bodies.velocity(id).map(|speed| m * speed);
        let [x, y, z] = bodies.position(id);
        let inertia = bodies.inertia.get(id).copied().unwrap_or(0.0);
        let [lx, ly, lz] = bodies.angular_velocity(id).map(|spin| inertia * spin);
        let turning = [
            z * px - x * pz + ly,
            y * pz - z * py + lx,
            x * py - y * px + lz,
        ];
        for (sum, more) in sums.iter_mut().zip([px, pz, py].into_iter().chain(turning)) {
            *sum += more;
        }
    }
    sums
}

fn conserved(run: &Run, dt: f64, resolution: Resolution) -> Held {
    const NAMES: [&str; 6] = [
        "momentum along x",
        "momentum along z",
        "momentum along y",
        "angular momentum about y",
        "angular momentum about x",
        "angular momentum about z",
    ];
    let Some(start) = run.first() else {
        return Held::Open("nothing is told".to_owned());
    };
    let began = momenta(&start.bodies);
    // Grains that are kept from turning take torques up.
    let rubs = |moment: &Snapshot| {
        moment
            .contacts
            .iter()
            .any(|contact| contact.tangential_force != 0.0)
    };
    let turns = start.bodies.rotate() || !run.iter().any(rubs);
    let mut worst = Worst::default();
    for moment in &run[1..] {
        let forces: f64 = rounding(moment, dt, resolution).iter().sum();
        let least = forces * dt * moment.step as f64;
        let far = least * reach(&moment.bodies);
        let least = [least, least, least, far, far, far];
        let now = momenta(&moment.bodies);
        for at in 0..if turns { 6 } else { 3 } {
            // Nothing moves across the plane.
            if now[at] == began[at] {
                continue;
            }
            worst.see((now[at] - began[at]).abs() / least[at], || {
                let (name, before, after) = (NAMES[at], began[at], now[at]);
                let steps = moment.step;
                format!(
                    "{name} is {before:.9e} at the start and {after:.9e} after {steps} steps (SI)"
                )
            });
        }
    }
    worst.held("both stay what they were, to rounding")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::starts::{Bed, DISPERSION};
    use grains::variant::{Form, Variant, run};

    type Error = Box<dyn std::error::Error>;

    /// What each relation came to in these states.
    fn relations(states: Vec<State>, run: &dyn Fn(&Case) -> Run) -> Vec<(&'static str, Held)> {
        let mut engine = |cases: &[&Case]| -> Result<Vec<Answer>, Error> {
            Ok(cases.iter().map(|case| Ok(run(case))).collect())
        };
        let itself = Itself::new(states, Depth::All, None, &|_| None, &mut engine).expect("runs");
        let held = |relation: &Relation| {
            let held = relation.held(&itself, &mut engine).expect("runs");
            (relation.key, held)
        };
        RELATIONS.iter().map(held).collect()
    }

    /// Those that an engine breaks.
    fn broken(states: Vec<State>, run: &dyn Fn(&Case) -> Run) -> Vec<&'static str> {
        let mut broken = Vec::new();
        for (key, held) in relations(states, run) {
            match held {
                Held::Breaks(_) => broken.push(key),
                Held::Holds(_) => {}
                Held::Open(why) => panic!("{key}: {why}"),
            }
        }
        broken
    }

    fn planar() -> Vec<State> {
        Bed::new(GRAINS, DISPERSION).expect("a bed").states()
    }

    fn spheres() -> Vec<State> {
        crate::spheres::for_itself().expect("a bed")
    }

    #[test]
    fn the_native_engine_agrees_with_itself_in_the_plane_and_in_space() {
        let native = |case: &Case| grains::native::run_case(case, None).expect("a run");
        assert_eq!(broken(planar(), &native), [""; 0]);
        assert_eq!(broken(spheres(), &native), [""; 0]);
    }

    #[test]
    fn an_engine_whose_second_grain_turns_the_wrong_way_does_not() {
        let wrong = Variant::of(Form::TorqueSign);
        for states in [planar(), spheres()] {
            let found = broken(states, &|case| run(case, &wrong));
            assert!(found.contains(&"conserved"), "{found:?}");
        }
    }

    /// Velocities along y alone are slowed down.
    #[test]
    fn an_engine_with_a_term_along_one_axis_does_not() {
        let slowed = |case: &Case| {
            let mut run = grains::native::run_case(case, None).expect("a run");
            let late = run.iter_mut().filter(|moment| moment.step > 0);
            for moment in late {
                let drag = |vy: &mut f64| *vy *= 1.0 - 1.0e-6;
                moment.bodies.vy.iter_mut().for_each(drag);
            }
            run
        };
        let found = broken(spheres(), &slowed);
        assert!(
            found.contains(&"askew") && found.contains(&"turned"),
            "{found:?}"
        );
        assert!(!found.contains(&"mirrored"), "{found:?}");
    }

    /// Engines with a law that no reference knows: each is right in the tables that it writes but for what is done to it here.
    #[test]
    fn what_no_reference_is_needed_for_is_found() {
        let native = |case: &Case| grains::native::run_case(case, None).expect("a run");
        let faster = |case: &Case| {
            let mut case = case.clone();
            case.model.alpha = -case.model.alpha;
            native(&case)
        };
        let dragged = |case: &Case| {
            let mut run = native(case);
            let late = run.iter_mut().filter(|moment| moment.step > 0);
            for moment in late {
                for column in &mut moment.bodies.columns_mut()[3..6] {
                    column.iter_mut().for_each(|speed| *speed *= 1.0 - 1.0e-6);
                }
            }
            run
        };
        let of_all = |case: &Case| {
            let mut case = case.clone();
            let bodies = &case.bodies;
            let fast = |id: usize| norm(bodies.velocity(id));
            let all: f64 = (0..bodies.len()).map(fast).sum();
            case.model.law.modulus *= 1.0 + 1.0e-3 * all / bodies.len() as f64;
            native(&case)
        };
        let turning = |case: &Case| {
            let mut run = native(case);
            for moment in &mut run {
                let factor = 1.0 + 1.0e-3 * moment.step as f64;
                moment
                    .bodies
                    .spin
                    .iter_mut()
                    .for_each(|spin| *spin *= factor);
            }
            run
        };
        let feeble = |case: &Case| {
            let mut run = native(case);
            run.iter_mut().for_each(|moment| moment.contacts.clear());
            run
        };
        let deeper = |case: &Case| {
            let mut run = native(case);
            let contacts = run.iter_mut().flat_map(|moment| &mut moment.contacts);
            contacts.for_each(|contact| contact.overlap *= 1.0 + 1.0e-6);
            run
        };
        type Fault<'a> = (&'a str, &'a dyn Fn(&Case) -> Run);
        let faults: [Fault; 7] = [
            ("written", &deeper),
            ("written", &feeble),
            ("passive", &faster),
            ("moving", &dragged),
            ("copies", &of_all),
            ("account", &turning),
            ("account", &feeble),
        ];
        for (relation, fault) in faults {
            let found = relations(planar(), fault);
            let broken =
                |(key, held): &(&str, Held)| *key == relation && matches!(held, Held::Breaks(_));
            assert!(found.iter().any(broken), "{relation}: {found:?}");
        }
        let nothing = relations(planar(), &feeble);
        let open = |(key, held): &(&str, Held)| *key == "contacts" && matches!(held, Held::Open(_));
        assert!(nothing.iter().any(open), "{nothing:?}");
    }

    /// Threads that add in the order in which they come give other last digits each time.
    #[test]
    fn rounding_that_never_repeats_is_no_fault() {
        let times = std::cell::Cell::new(0);
        let threads = |case: &Case| {
            times.set(times.get() + 1);
            let digits = last_digits(case, Resolution::DOUBLE, 1000 + times.get());
            let mut run = grains::native::run_case(&digits, None).expect("a run");
            if run[0].step == 0 {
                run[0].bodies = case.bodies.clone();
            }
            run
        };
        let found = relations(planar(), &threads);
        let repeats = |key| found.iter().find(|(one, _)| *one == key);
        for key in ["again", "output"] {
            let (_, held) = repeats(key).expect("asked");
            assert!(
                matches!(held, Held::Holds(said) if said.contains("whenever it runs")),
                "{held:?}"
            );
        }
    }
}
