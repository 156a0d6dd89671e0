//! Which term of an engine's step is another one, read from what it writes itself: its grains and contact tables at steps that follow
//! each other. Each force, torque, velocity and place is held against what the model makes of the numbers that the engine has
//! written besides, so that nothing which came before plays a part; what is left over is laid onto a few terms. A term is told only if it
//! explains all of that to rounding; else it is told which numbers do not follow, and where.

use std::collections::BTreeMap;

use evidence::in_parallel;
use grains::tables::Snapshot;
use grains::task::Case;
use grains::vector::Vector;

/// Of a number that follows from others no more than this share is rounding.
const ROUNDED: f64 = 1.0e-9;
/// Some row is off by so many times what may be rounding before a term is looked for.
const PLAIN: f64 = 1.0e3;

const NONE: Vector = [0.0; 3];

/// What a number is made of: in words, how often the model has it, and its value.
type Term = (&'static str, f64, Vector);

/// What a dashpot along the tangent has in a step, and had in the one before.
const DASHPOT: &str = "the dashpot's force";
const KEPT_DASHPOT: &str = "the dashpot's force of the step before, which the spring keeps,";

/// Rows of words, how often, and value.
macro_rules! terms {
    ($($words:expr, $usual:expr => $value:expr;)*) => { vec![$(($words, $usual, $value)),*] };
}

mod elsewhere;
mod fit;
mod motion;
mod place;
mod residuals;
mod seen;

/// A number that an engine writes, held against the model's.
struct Row {
    /// Which run and moment, and the contact or the grain there.
    at: (usize, usize),
    subject: Of,
    /// How far it is off the model's, and how far it may be by rounding.
    off: Vector,
    least: f64,
    terms: Vec<Term>,
    /// Lengths, masses, speeds and numbers on which a factor may hang.
    sizes: Vec<(&'static str, f64)>,
    /// What its contact is, or those of its grain are.
    marks: Marks,
    /// What it is between, where that is not the same for all.
    between: String,
    /// By how much it would be another one with each thing from elsewhere, where that is looked at.
    elsewhere: Vec<Vector>,
}

/// What contacts are: some of these.
type Marks = u16;

macro_rules! marks {
    ($($mark:ident = $bit:literal: $first:literal, $($words:literal),+;)+) => {
        $(const $mark: Marks = $bit;)+
        const MARKS: [(Marks, [&str; 4]); [$($bit),+].len()] = [$(($mark, [$first, $($words),+])),+];
        /// Forces and torques of the contacts that are so.
        const OF_MARKED: [[&str; 2]; MARKS.len()] =
            [$([concat!("forces where ", $first), concat!("torques where ", $first)]),+];
    };
}

// In words: of contacts that are so, of those that are not, of grains with such a contact and of grains without one. Moments play no part
// in forces.
marks! {
    SLIDES_NOW = 1: "they slide", "they stick", "one of their contacts slides", "none of their contacts slides";
    SLID = 2: "they slid in one of these steps before", "they slid in none of these steps before",
        "one of their contacts slid in one of these steps before", "none of their contacts slid in these steps before";
    BEGINS = 4: "they have just begun", "they touched before",
        "one of their contacts has just begun", "none of their contacts has just begun";
    PARTS = 8: "their bodies part", "their bodies approach",
        "the bodies of one of their contacts part", "the bodies of all of their contacts approach";
    AT_WALL = 16: "they are at walls", "they are not at walls", "they touch a wall", "they touch no wall";
    AT_PUNCH = 32: "they are at the punch", "they are not at the punch", "they touch the punch", "they do not touch the punch";
    BEYOND_LIMIT = 64: "", "",
        "a moment against rolling at one of their contacts has been at its limit", "no moment against rolling at their contacts has been at its limit";
    ACROSS_X = 128: "they are at walls across x", "they are not at walls across x",
        "they touch a wall across x", "they touch no wall across x";
    ACROSS_Y = 512: "they are at walls across y", "they are not at walls across y",
        "they touch a wall across y", "they touch no wall across y";
    ACROSS_Z = 256: "they are at walls across z", "they are not at walls across z",
        "they touch a wall across z", "they touch no wall across z";
    OF_HALVES = 1024: "their ids are of different halves of all grains", "their ids are of one half of all grains",
        "they touch a grain whose id is in the other half of all", "they touch no grain whose id is in the other half of all";
    EVEN_AND_ODD = 2048: "one of their ids is even and the other odd", "their ids are both even or both odd",
        "they touch one whose id is even where theirs is odd, or the other way round", "they touch none whose id is even where theirs is odd, or the other way round";
}
/// At a wall across x, z and y, as axes are numbered.
const ACROSS: [Marks; 3] = [ACROSS_X, ACROSS_Z, ACROSS_Y];

#[derive(Clone, Copy, PartialEq)]
enum Of {
    Contact(u32, u32),
    Grain(usize),
}

macro_rules! quantities {
    ($($name:ident $words:literal;)+) => {
        const QUANTITIES: [&str; [$($words),+].len()] = [$($words),+];
        quantities! { 0; $($name)+ }
    };
    // Each has the number of its row.
    ($row:expr; $name:ident $($later:ident)*) => {
        const $name: usize = $row;
        quantities! { $row + 1; $($later)* }
    };
    ($rows:expr;) => {};
}

// What is held against the model: first comes what others follow from.
quantities! {
    POINTS "contact points";
    NORMAL "normal forces";
    PULLED "normal forces that the dashpot would make pull";
    NEW_STICKS "tangential forces of contacts that begin and stick";
    NEW_SLIDES "tangential forces of contacts that begin and slide";
    CUT_EARLY "tangential forces at Coulomb's limit of contacts whose spring is below it";
    STICKING "tangential forces of contacts that stick";
    SLIDING "tangential forces of contacts that slide";
    STICKING_AGAIN "tangential forces of contacts that stick again";
    SLIDING_ON "tangential forces of contacts that go on sliding";
    VELOCITIES "velocities";
    SPINS "spins";
    PLACES "places";
    PUNCH "forces on the punch";
    CUT_AWAY "normal forces that are cut to nothing";
    NOT_CUT "tangential forces beyond Coulomb's limit that are not cut";
    SPINS_FIRST_NEAR_LIMIT "spins of grains with a moment near the limit of rolling, beyond which none was before";
    SPINS_NEAR_LIMIT "spins of grains with a moment near the limit of rolling";
}

use fit::{Explained, explained};
use residuals::Follower;
use seen::Seen;

type Rows = BTreeMap<(usize, usize), Vec<Row>>;

/// What does not follow from the rest of what an engine writes.
pub(crate) struct Found {
    /// The terms that are other ones.
    pub(crate) terms: Vec<String>,
    /// Where there are none: which quantities are off, and where.
    pub(crate) unexplained: Vec<String>,
}

/// Of the quantities in each of these groups one tells what is wrong in the others.
const GROUPS: [&[usize]; 7] = [
    &[POINTS],
    &[NORMAL, PULLED],
    &[
        NEW_STICKS,
        STICKING,
        NEW_SLIDES,
        SLIDING,
        STICKING_AGAIN,
        SLIDING_ON,
    ],
    &[VELOCITIES],
    &[SPINS, SPINS_FIRST_NEAR_LIMIT, SPINS_NEAR_LIMIT],
    &[PLACES],
    &[PUNCH],
];

/// Runs of one law, each with moments that follow each other step by step from the start.
/// Motion that follows from forces which are not those that are written is not told. The first moment may have been made under another law.
pub(crate) fn found(
    runs: &[(&Case, &[Snapshot])],
    made_under: Option<&Case>,
    moves: bool,
) -> Found {
    let follow = |looks_elsewhere: bool| {
        let all = in_parallel(runs.len(), |run| {
            let (case, moments) = runs[run];
            let mut rows = Rows::new();
            let mut follower = Follower::new(case, run, looks_elsewhere);
            follower.follow(moments, made_under, &mut rows);
            (rows, follower.seen)
        });
        let (mut rows, mut seen) = (Rows::new(), Seen::default());
        for (of_run, seen_there) in all {
            seen.add(seen_there);
            for (key, of_run) in of_run {
                rows.entry(key).or_default().extend(of_run);
            }
        }
        let keys: Vec<(usize, usize)> = rows.keys().copied().collect();
        let said = in_parallel(keys.len(), |at| {
            explained(keys[at].0, &rows[&keys[at]], runs)
        });
        (rows, seen, keys, said)
    };
    let mut followed = follow(false);
    let (rows, _, keys, said) = &followed;
    // It takes some seconds, and no formula is told by it.
    let lacks_formula = |(key, said): (&(usize, usize), &Option<Explained>)| {
        let is_plain = said.as_ref().is_some_and(|said| said.is_plain);
        !is_plain && rows[key].iter().any(|row| row.ratio() > PLAIN)
    };
    if keys.iter().zip(said).any(lacks_formula) {
        followed = follow(true);
    }
    let (rows, seen, keys, said) = followed;
    let is_off = |quantity: usize| {
        let mut kinds = rows.iter().filter(|(key, _)| key.0 == quantity);
        // Few may have remembered something that is not written.
        kinds
            .any(|(_, rows)| 2 * rows.iter().filter(|row| row.ratio() > PLAIN).count() > rows.len())
    };
    // One row that is plainly off.
    let has_off = |quantity: usize| {
        let mut kinds = rows.iter().filter(|(key, _)| key.0 == quantity);
        kinds.any(|(_, rows)| rows.iter().any(|row| row.ratio() > PLAIN))
    };
    let is_told = |quantity: usize| {
        keys.iter()
            .zip(&said)
            .any(|(key, said)| key.0 == quantity && said.is_some())
    };
    // Where contacts begin without a dashpot, the spring seems to keep it in their second step, and in no other.
    let begins_without_dashpot = {
        let said_of = |quantity: usize| {
            keys.iter()
                .zip(&said)
                .filter(move |(key, _)| key.0 == quantity)
        };
        let lacks = said_of(NEW_STICKS)
            .flat_map(|(_, said)| said)
            .any(|said| said.said.contains(DASHPOT));
        let mut later = said_of(STICKING).flat_map(|(_, said)| said).peekable();
        lacks
            && later.peek().is_some()
            && later.all(|said| said.said.contains(KEPT_DASHPOT) && !said.place.is_empty())
    };
    let slides_later = seen.slides_later().filter(|_| {
        let others = [NEW_STICKS, STICKING, NEW_SLIDES, SLIDING];
        !others
            .into_iter()
            .any(|other| is_off(other) || is_told(other))
    });
    let damps_otherwise = seen.damps_otherwise().filter(|_| moves);
    let damps = damps_otherwise.is_some();
    let mut told: Vec<String> = seen.ends_elsewhere().into_iter().collect();
    let early = [0, 1, 2].map(|kind| seen.slides_early(kind));
    let slides_early = KINDS.iter().zip(&early).filter_map(|(kind, share)| {
        let share = (*share)?;
        Some(format!(
            "tangential forces {kind}: cut to {share:.6} of Coulomb's limit"
        ))
    });
    told.extend(slides_early);
    told.extend(slides_later.into_iter().chain(damps_otherwise));
    for (quantity, name) in QUANTITIES.into_iter().enumerate() {
        // What slides goes the way of what sticks, and contacts that go on have all that new ones have.
        let sticks_otherwise = [NEW_STICKS, STICKING]
            .into_iter()
            .any(|sticking| is_off(sticking) || is_told(sticking));
        let follows = match quantity {
            CUT_AWAY => true,
            PULLED => is_told(NORMAL),
            tangential if (NEW_STICKS..=SLIDING_ON).contains(&tangential) && is_told(NORMAL) => {
                true
            }
            NEW_STICKS => is_told(STICKING) && !begins_without_dashpot,
            STICKING if begins_without_dashpot => true,
            // What slides early may have a stiffer spring.
            CUT_EARLY => sticks_otherwise || has_off(NEW_STICKS) || has_off(STICKING),
            STICKING_AGAIN => sticks_otherwise,
            SLIDING => sticks_otherwise || is_told(CUT_EARLY),
            NEW_SLIDES => {
                is_off(NEW_STICKS) || is_told(NEW_STICKS) || is_told(CUT_EARLY) || is_told(SLIDING)
            }
            SLIDING_ON => (NEW_STICKS..SLIDING_ON).any(|before| is_off(before) || is_told(before)),
            NOT_CUT => {
                let slide = |sliding| keys.iter().any(|key| key.0 == sliding);
                sticks_otherwise || [NEW_SLIDES, SLIDING, SLIDING_ON].into_iter().any(slide)
            }
            VELOCITIES if damps => true,
            VELOCITIES | SPINS => !moves,
            SPINS_FIRST_NEAR_LIMIT | SPINS_NEAR_LIMIT => {
                !moves
                    || (SPINS..quantity)
                        .filter(|other| ![PLACES, PUNCH, CUT_AWAY, NOT_CUT].contains(other))
                        .any(|other| is_off(other) || is_told(other))
            }
            _ => false,
        };
        if follows {
            continue;
        }
        let of_kinds = keys.iter().zip(&said).filter(|(key, _)| key.0 == quantity);
        let of_kinds: Vec<_> = of_kinds.collect();
        let some_right = of_kinds
            .iter()
            .any(|(key, _)| !rows[key].iter().any(Row::is_off));
        let mut seen: Vec<&String> = Vec::new();
        for (_, said) in &of_kinds {
            let is_new = |said: &&Explained| !seen.contains(&&said.said);
            let Some(Explained {
                said,
                place: place_of,
                ..
            }) = said.as_ref().filter(is_new)
            else {
                continue;
            };
            seen.push(said);
            let is_same =
                |other: &Option<Explained>| other.as_ref().is_some_and(|other| other.said == *said);
            let same = of_kinds.iter().filter(|(_, other)| is_same(other));
            let kinds: Vec<&str> = same.map(|(key, _)| KINDS[key.1]).collect();
            let place = match quantity < VELOCITIES || quantity == NOT_CUT {
                true if some_right => format!(" {} alone", kinds.join(" and ")),
                true => format!(" {}", kinds.join(" and ")),
                false => String::new(),
            };
            told.push(format!("{name}{place}: {said}{place_of}"));
        }
    }
    let mut unexplained = Vec::new();
    // Of a group that of which the largest share is off.
    let share = |quantity: usize| {
        let rows = rows.iter().filter(|(key, _)| key.0 == quantity);
        let rows: Vec<&Row> = rows.flat_map(|(_, rows)| rows).collect();
        let off = rows.iter().filter(|row| row.ratio() > PLAIN).count();
        off as f64 / rows.len().max(1) as f64
    };
    for group in GROUPS.into_iter().filter(|_| told.is_empty()) {
        let of_motion = [VELOCITIES, SPINS].contains(&group[0]);
        let mut quantities: Vec<usize> = group
            .iter()
            .copied()
            .filter(|_| moves || !of_motion)
            .collect();
        // The first of those with the same share.
        quantities.sort_by(|one, other| share(*other).total_cmp(&share(*one)));
        let of_group = quantities.into_iter().map(|quantity| {
            let kinds = rows.iter().filter(|(key, _)| key.0 == quantity);
            let kinds = kinds.filter_map(|(key, rows)| {
                let place = match quantity < VELOCITIES {
                    true => format!(" {}", KINDS[key.1]),
                    false => String::new(),
                };
                let off = fit::unexplained(rows, runs)?;
                Some(format!("{}{place}: {off}", QUANTITIES[quantity]))
            });
            kinds.collect::<Vec<String>>()
        });
        unexplained.extend(
            of_group
                .into_iter()
                .find(|kinds| !kinds.is_empty())
                .into_iter()
                .flatten(),
        );
    }
    Found {
        terms: told,
        unexplained,
    }
}

const KINDS: [&str; 3] = ["between grains", "at walls", "at the punch"];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excerpt::{Excerpt, FirstMoments};
    use crate::starts::{Bed, DISPERSION, State};
    use grains::constant::Constant;
    use grains::model::Axis;
    use grains::rules::Choice;
    use grains::tables::Stage;
    use grains::task::Observer;
    use grains::variant::{Form, Variant};

    fn states() -> Vec<State> {
        let bed = Bed::new(100, DISPERSION).expect("a bed");
        let in_space = crate::spheres::reference().expect("a bed");
        bed.states()
            .iter()
            .chain(in_space.states())
            .cloned()
            .collect()
    }

    fn run(state: &State, variant: &Variant) -> (Case, Vec<Snapshot>) {
        let case = state.case.at((0..=8).collect());
        let run = grains::variant::run(&case, variant);
        (case, run)
    }

    fn found_in(runs: &[(Case, Vec<Snapshot>)], moves: bool) -> Found {
        let runs = runs.iter().map(|(case, run)| (case, &run[..]));
        found(&runs.collect::<Vec<_>>(), None, moves)
    }

    /// What the native engine writes follows from the rest, whatever the law is, but for what springs have along the normal.
    #[test]
    fn nothing_is_left_of_a_right_engine() {
        for state in states() {
            let (case, run) = run(&state, &Variant::default());
            let mut rows = Rows::new();
            Follower::new(&case, 0, false).follow(&run, None, &mut rows);
            assert!(!rows.is_empty(), "{}", case.name);
            for ((quantity, kind), rows) in rows {
                let off = rows.iter().filter(|row| row.is_off()).count();
                let (name, kind) = (QUANTITIES[quantity], KINDS[kind]);
                assert!(
                    20 * off <= rows.len().max(20),
                    "{}: {name} {kind}: {off} of {}",
                    case.name,
                    rows.len()
                );
            }
            let found = found(&[(&case, &run)], None, true);
            assert_eq!(found.terms, [""; 0], "{}", case.name);
            assert_eq!(found.unexplained, [""; 0], "{}", case.name);
        }
    }

    /// What a contact is made of makes what the terms of its law make, to the bit.
    #[test]
    fn what_contacts_are_made_of_makes_their_forces() {
        for state in states() {
            let (case, run) = run(&state, &Variant::default());
            let first = &run[0];
            let reference = grains::reference::Reference::holding(
                &case.model,
                &case.bodies,
                case.punch,
                &first.contacts,
            );
            let (contacts, _) = reference.contacts_with_across();
            for contact in &contacts {
                let told = (
                    contact.normal_force,
                    [0.0, 1.0e-3 * contact.normal_force, 0.0],
                );
                let parts = reference
                    .parts(contact.ids(), told, None)
                    .expect("they touch");
                let made = reference
                    .made_of(contact.ids(), told, None)
                    .expect("they touch");
                let makes = reference.makes(&made);
                assert_eq!(makes.normal_force, parts.normal_force, "{}", case.name);
                if case.model.law.has_friction() {
                    assert_eq!(makes.tangential, parts.tangential, "{}", case.name);
                }
            }
        }
    }

    /// Each contact has the stiffness of the first in the table of the same first body.
    #[test]
    fn what_is_taken_from_elsewhere_is_told_with_from_where() {
        let states = states();
        let is_smooth = |state: &&State| {
            let law = &state.case.model.law;
            !state.case.bodies.in_space() && !law.has_friction() && !law.has_dashpots()
        };
        let runs: Vec<(Case, Vec<Snapshot>)> = states
            .iter()
            .filter(is_smooth)
            .map(|state| {
                let (case, mut run) = run(state, &Variant::default());
                let radius = &case.bodies.radius;
                let of_both = |contact: &grains::tables::Contact| {
                    let two = radius[contact.id2 as usize];
                    let one = radius.get(contact.id1 as usize).copied().unwrap_or(two);
                    one * two / (one + two)
                };
                for moment in &mut run {
                    let mut first = (u32::MAX, 0.0);
                    for contact in &mut moment.contacts {
                        let both = of_both(contact);
                        if first.0 != contact.id1 {
                            first = (contact.id1, both);
                        }
                        if (contact.id1 as usize) < radius.len() {
                            contact.normal_force *= first.1 / both;
                        }
                    }
                }
                (case, run)
            })
            .collect();
        let found = found_in(&runs, false);
        let told = found.terms.join("; ");
        let words = "normal forces between grains alone: with k_n of the first contact of the same first body";
        assert!(told.contains(words), "{told}");
    }

    fn first_moments(excerpt: &Excerpt) -> Vec<Snapshot> {
        let mut first = FirstMoments::default();
        for moment in excerpt.step_by_step().native(None).expect("a run") {
            first.snapshot(&moment);
        }
        first.0
    }

    /// Nor where contacts have a history and stages change.
    #[test]
    fn nothing_is_left_of_a_right_engine_in_scenes() {
        let in_space = crate::spheres::reference().expect("a bed");
        let plane = crate::judge::Reference::new(100, DISPERSION, &mut |_| ()).expect("a bed");
        for excerpt in in_space.excerpts.iter().chain(&plane.excerpts) {
            let moments = first_moments(excerpt);
            assert_eq!(excerpt.followed(&moments, true), None, "{}", excerpt.start);
        }
    }

    /// Where no term explains it, what is off is told with where it is.
    #[test]
    fn what_no_term_explains_has_a_place() {
        let states = states();
        // Friction would be cut by a force that is not told.
        let is_smooth =
            |state: &&State| state.case.bodies.in_space() && !state.case.model.law.has_friction();
        let smooth: Vec<&State> = states.iter().filter(is_smooth).collect();
        let law = &smooth.first().expect("a smooth law in space").law;
        let of_law = smooth.iter().filter(|state| state.law == *law);
        let runs: Vec<(Case, Vec<Snapshot>)> = of_law
            .map(|state| {
                let (case, mut run) = run(state, &Variant::default());
                for (step, moment) in run.iter_mut().enumerate() {
                    for (at, contact) in moment.contacts.iter_mut().enumerate() {
                        let wall = case.wall(contact.id1);
                        if wall.is_some_and(|wall| wall.axis == Axis::Y) {
                            contact.normal_force *= 1.2 + 0.1 * ((at * at + step) as f64).sin();
                        }
                    }
                }
                (case, run)
            })
            .collect();
        let found = found_in(&runs, false);
        assert_eq!(found.terms, [""; 0]);
        let told = found.unexplained.join("; ");
        let words = "normal forces at walls: where they are at walls across y";
        assert!(told.contains(words), "{told}");
    }

    #[test]
    fn what_is_wrong_in_one_stage_is_told_with_it() {
        let plane = crate::judge::Reference::new(100, DISPERSION, &mut |_| ()).expect("a bed");
        let mut excerpts = plane.excerpts.iter();
        let into_loading = excerpts.find(|excerpt| excerpt.start.contains("then loading"));
        let excerpt = into_loading.expect("one that pours into loading");
        let mut moments = first_moments(excerpt);
        let of_loading = moments.iter_mut().filter(|one| one.stage == Stage::Load);
        for contact in of_loading.flat_map(|moment| &mut moment.contacts) {
            contact.normal_force *= 1.5;
        }
        let cause = excerpt.followed(&moments, false).expect("a cause");
        let told = cause.sentence();
        assert!(
            told.contains("in loading from step 0 on: normal forces"),
            "{told}"
        );
        assert!(told.contains("the spring's force × 1.5"), "{told}");
    }

    /// Moments are not written: they follow from how an engine's grains have turned.
    #[test]
    fn another_moment_is_told() {
        let states = states();
        let rolls = |state: &&State| state.case.model.law.contact.rolling.is_some();
        let rolling: Vec<&State> = states.iter().filter(rolls).collect();
        let law = &rolling.first().expect("a law with moments").law;
        let of_law: Vec<&&State> = rolling.iter().filter(|state| state.law == *law).collect();
        for (fault, words) in [
            ("rolling-stiffness", "moments against rolling"),
            ("twisting-stiffness", "moments against twisting"),
        ] {
            let constant = Constant::faults().find(|constant| constant.to_string() == fault);
            let variant = Variant::default().and(constant.expect("a fault"), 0.5);
            let runs: Vec<(Case, Vec<Snapshot>)> =
                of_law.iter().map(|state| run(state, &variant)).collect();
            let told = found_in(&runs, true).terms;
            assert!(
                told.iter()
                    .any(|told| told.starts_with("spins") && told.contains(words)),
                "{fault}: {told:?}"
            );
        }
    }

    /// Forces of 24 bits are off either way, and so are overlaps by a distance of 24 bits; no term is another one.
    #[test]
    fn single_precision_is_told() {
        fn single(number: f64) -> f64 {
            f64::from(number as f32)
        }
        let force = |force: f64, _: [f64; 2]| single(force);
        let distance = |force: f64, [both, overlap]: [f64; 2]| {
            force * (both - single(both - overlap)) / overlap
        };
        let states = states();
        type Change = fn(f64, [f64; 2]) -> f64;
        let changes: [(Change, &str); 2] = [
            (force, "normal forces between grains alone: rounded"),
            (
                distance,
                "the distance of both bodies in the overlap is rounded",
            ),
        ];
        for (change, words) in changes {
            let of_law = states.iter().filter(|state| state.law == "friction");
            let runs = of_law.map(|state| {
                let (case, mut run) = run(state, &Variant::default());
                let grains = case.bodies.len() as u32;
                for contact in run.iter_mut().flat_map(|moment| &mut moment.contacts) {
                    if contact.id1 < grains {
                        let radii =
                            [contact.id1, contact.id2].map(|id| case.bodies.radius[id as usize]);
                        let lengths = [radii[0] + radii[1], contact.overlap];
                        contact.normal_force = change(contact.normal_force, lengths);
                    }
                }
                (case, run)
            });
            let runs: Vec<(Case, Vec<Snapshot>)> = runs.collect();
            let told = found_in(&runs, false).terms.join("; ");
            assert!(
                told.contains(words) && told.contains("single precision"),
                "{told}"
            );
        }
    }

    #[test]
    fn a_term_that_is_another_one_is_told() {
        let drift = Choice::of("integration", "drift_kick").expect("a rule");
        let faults = [
            (
                Form::HistoryReset,
                "contacts that stick between grains and at walls",
                "without the spring's force of the step before",
            ),
            (
                Form::SlipOfCentres,
                "contacts that stick",
                "without k_s·Δt·slip of the spins",
            ),
            (Form::TorqueSign, "spins", "of the other sign"),
            (
                Form::OneSided(1),
                "velocities",
                "without forces on the first of a pair",
            ),
            (
                Form::Rule(drift),
                "places",
                "without the kick of this step in Δt·v",
            ),
        ];
        let states = states();
        for law in ["friction", "linear springs and friction in space"] {
            let of_law: Vec<&State> = states.iter().filter(|state| state.law == law).collect();
            for (form, what, words) in faults {
                let runs = of_law.iter().map(|state| run(state, &Variant::of(form)));
                let runs: Vec<(Case, Vec<Snapshot>)> = runs.collect();
                let told = found_in(&runs, true).terms.join("; ");
                assert!(
                    told.contains(what) && told.contains(words),
                    "{law}: {form:?}: {told}"
                );
            }
        }
    }
}
