//! What an engine's parameters really mean: each constant is asked for in an experiment of one or two grains, and read from how
//! the last grain moves. Forces that the engine writes play no part.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use serde::Serialize;

use crate::checks::{Check, Outcome, verdict};
use crate::document::table::Table;
use crate::document::{Document, Section};
use crate::engine::{Description, Engine, EngineError, ProgramError};
use crate::files::work_folder;
use crate::suite::{
    Grain, Track, at, case, friction, model, punch, springs, with_viscosity, world,
};
use grains::constant::Constant;
use grains::model::Law;
use grains::rules::{Choice, Rules};
use grains::scene::{Tension, Viscosity};
use grains::task::Case;
use grains::variant::{Form, Variant, run};
use verdict::forms::{candidates, in_words, other_rules};

/// Radii of the grains, m; both are R of the first where grains are equal.
const RADII: [f64; 2] = [0.005, 0.003];
const DENSITY: f64 = 2600.0;
/// E, Pa, so that k_n of two equal grains is E·R.
const MODULUS: f64 = 1.0e7;
const DT: f64 = 1.0e-6;
/// The overlap that springs are read at, over the radius of the last grain.
const OVERLAP: f64 = 1.0e-3;
/// m/s.
const SPEED: f64 = 0.1;
/// Steps in a contact time.
const STEPS: u64 = 100;
/// How far what is read may be from what it should be, as a share of it: single precision, in differences of velocities.
const TOLERANCE: f64 = 1.0e-4;
/// What constants are multiplied by where somebody halves, doubles or takes a root.
const FACTORS: [(f64, &str); 6] = [
    (0.0, "0"),
    (0.5, "1/2"),
    (FRAC_1_SQRT_2, "1/√2"),
    (SQRT_2, "√2"),
    (2.0, "2"),
    (4.0, "4"),
];

/// What an engine may have otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Otherwise {
    Form(Form),
    Times(Constant, f64, &'static str),
}

impl Otherwise {
    /// All that makes a difference in this case.
    fn all(case: &Case) -> Vec<Otherwise> {
        let rules = other_rules(case).map(Form::Rule);
        let is_rule = |form: &Form| matches!(form, Form::Rule(_));
        let others = candidates(case).into_iter().filter(|form| !is_rule(form));
        let forms = rules.chain(others).map(Otherwise::Form);
        let angle = case.model.law.friction_angle;
        let of_angle = [
            (angle.tan().tan() / angle.tan(), "tan tan φ / tan φ"),
            (angle / angle.tan(), "φ / tan φ"),
        ];
        let alone = Constant::faults().filter(|constant| constant.symbol().is_empty());
        let constants = Constant::all().chain(alone);
        let times = constants
            .filter(|constant| constant.is_in(case))
            .flat_map(|constant| {
                let of_angle = of_angle
                    .into_iter()
                    .filter(move |_| constant.symbol() == "tan φ");
                let all = FACTORS.into_iter().chain(of_angle);
                all.map(move |(factor, name)| Otherwise::Times(constant, factor, name))
            });
        forms.chain(times).collect()
    }

    fn name(self) -> String {
        match self {
            Otherwise::Form(Form::Rule(choice)) => choice.name(),
            Otherwise::Form(form) => in_words(form),
            Otherwise::Times(constant, _, name) => format!("{} × {name}", constant.name()),
        }
    }

    fn beside(self, others: &Variant) -> Variant {
        let mut variant = others.clone();
        match self {
            Otherwise::Form(form) => variant.forms.push(form),
            Otherwise::Times(constant, factor, _) => return others.and(constant, factor - 1.0),
        }
        variant
    }
}

/// What the last grain meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Equal,
    Unequal,
    Wall,
    Punch,
}

const PLACES: [Place; 4] = [Place::Equal, Place::Unequal, Place::Wall, Place::Punch];

impl Place {
    fn name(self) -> &'static str {
        ["two equal grains", "two unequal grains", "wall", "punch"][self as usize]
    }

    fn last(self) -> Grain {
        let radius = RADII[usize::from(self == Place::Unequal)];
        Grain::disc([0.0; 2], radius, DENSITY)
    }

    /// k_n, N/m (Eq. 4); flat bodies count as a grain of the same radius.
    fn stiffness(self) -> f64 {
        let [one, two] = [RADII[0], self.last().radius];
        MODULUS * 2.0 * one * two / (one + two)
    }

    /// m₁m₂/(m₁ + m₂), or the whole mass at flat bodies, kg.
    fn mass(self) -> f64 {
        let (one, two) = (Place::Equal.last().mass, self.last().mass);
        match self {
            Place::Equal | Place::Unequal => one * two / (one + two),
            Place::Wall | Place::Punch => two,
        }
    }

    /// The last grain this deep in what is below it, or above it for the punch, and approaching at this velocity.
    fn meeting(self, law: Law, overlap: f64, [along, inward]: [f64; 2], moments: Vec<u64>) -> Case {
        let mut last = self.last();
        // Spins stay so small that nothing is seen of them; their own experiment asks for them.
        last.inertia *= 1.0e6;
        let grains = match self {
            Place::Equal | Place::Unequal => vec![Place::Equal.last()],
            Place::Wall | Place::Punch => Vec::new(),
        };
        let side = if self == Place::Punch { -1.0 } else { 1.0 };
        let below = grains.first().map_or(0.0, |grain: &Grain| grain.radius);
        let place = [0.0, side * (below + last.radius - overlap)];
        last = last.at(place).moving([along, -side * inward]);
        let floor: &[f64] = if self == Place::Wall { &[0.0] } else { &[] };
        let world = world(law, DT, [0.0; 2], 0.0, [&[], floor]);
        let grains: Vec<Grain> = grains.into_iter().chain([last]).collect();
        let mut made = case("card", world, &grains, moments);
        if self == Place::Punch {
            made.punch = Some(punch(0.0, 0.0, [0.05, 0.05], 0.0));
        }
        made
    }

    /// Along and out of the contact: of the force on the last grain between this moment and the next, N.
    fn force(self, track: &Track, step: u64) -> [f64; 2] {
        let id = usize::from(matches!(self, Place::Equal | Place::Unequal));
        let [before, after] = [step, step + 1].map(|step| at(track, step).velocity(id));
        let side = if self == Place::Punch { -1.0 } else { 1.0 };
        let mass = self.last().mass;
        [
            mass * (after[0] - before[0]) / DT,
            side * mass * (after[1] - before[1]) / DT,
        ]
    }

    /// How deep the last grain is, m.
    fn overlap(self, track: &Track, step: u64) -> f64 {
        let radii = self.last().radius;
        match self {
            Place::Equal | Place::Unequal => {
                let [[x, z], [x2, z2]] = [0, 1].map(|id| at(track, step).position(id));
                RADII[0] + radii - (x2 - x).hypot(z2 - z)
            }
            Place::Wall | Place::Punch => radii - at(track, step).position(0)[1].abs(),
        }
    }

    fn velocity(self, track: &Track, step: u64) -> [f64; 2] {
        match self {
            Place::Equal | Place::Unequal => {
                let [[vx, vz], [x, z]] = [0, 1].map(|id| at(track, step).velocity(id));
                [x - vx, z - vz]
            }
            Place::Wall => at(track, step).velocity(0),
            Place::Punch => at(track, step).velocity(0).map(|part| -part),
        }
    }
}

type Read = Box<dyn Fn(&Track) -> f64 + Send + Sync>;

/// Something that is asked for, and how a trajectory shows it.
struct Quantity {
    key: &'static str,
    name: &'static str,
    unit: &'static str,
    place: &'static str,
    case: Case,
    /// What the model says.
    asked: f64,
    read: Read,
}

fn quantities() -> Vec<Quantity> {
    let mut all = Vec::new();
    let slope = 0.5_f64;
    for place in PLACES {
        let mut add = |key, name, unit, case, asked, read: Read| {
            let place = place.name();
            all.push(Quantity {
                key,
                name,
                unit,
                place,
                case,
                asked,
                read,
            });
        };
        let overlap = OVERLAP * place.last().radius;
        let spring = place.meeting(springs(MODULUS), overlap, [0.0; 2], vec![0, 1, 2]);
        let stiffness = move |track: &Track| place.force(track, 1)[1] / place.overlap(track, 1);
        add(
            "k-n",
            "normal stiffness",
            "N/m",
            spring,
            place.stiffness(),
            Box::new(stiffness),
        );
        let law = with_viscosity(
            springs(MODULUS),
            Viscosity::Dashpot {
                c_n: 10.0,
                tension: Tension::Clipped,
            },
        );
        let braked = place.meeting(law, overlap, [0.0, SPEED], vec![0, 1, 2]);
        let dashpot = move |track: &Track| {
            let spring = place.stiffness() * place.overlap(track, 1);
            let side = if place == Place::Punch { -1.0 } else { 1.0 };
            (spring - place.force(track, 1)[1]) / (side * place.velocity(track, 1)[1]) * side
        };
        add("c-n", "dashpot", "N s/m", braked, 10.0, Box::new(dashpot));
        let law = friction(MODULUS, 0.5, 1.2);
        let dragged = place.meeting(law, overlap, [SPEED, 0.0], vec![0, 1, 2, 3]);
        let shear = move |track: &Track| {
            let [one, two] = [1, 2].map(|step| place.force(track, step)[0]);
            (one - two) / (place.velocity(track, 2)[0].abs() * DT)
        };
        add(
            "k-s",
            "tangential stiffness",
            "N/m",
            dragged,
            0.5 * place.stiffness(),
            Box::new(shear),
        );
        let sliding = place.meeting(
            friction(MODULUS, 1.0, slope.atan()),
            overlap,
            [3.0, 0.0],
            vec![0, 1, 2, 3],
        );
        let ratio = move |track: &Track| {
            let [along, out] = place.force(track, 2);
            (along / out).abs()
        };
        add(
            "friction",
            "friction coefficient",
            "",
            sliding,
            slope,
            Box::new(ratio),
        );
        for (e_n, key) in [(0.2, "e-02"), (0.5, "e-05"), (0.8, "e-08")] {
            let viscosity = Viscosity::Restitution {
                e_n,
                tension: Tension::Clipped,
            };
            let law = with_viscosity(springs(MODULUS), viscosity);
            let end = collision(place) as u64 * 3;
            let bounce = place.meeting(law, -0.5 * SPEED * DT, [0.0, SPEED], vec![0, end]);
            let rebound = move |track: &Track| {
                let [before, after] = [0, end].map(|step| place.velocity(track, step)[1]);
                -after / before
            };
            add(key, "restitution", "", bounce, e_n, Box::new(rebound));
        }
        let dt = collision(place) / STEPS as f64 * DT;
        let mut bounce = place.meeting(
            springs(MODULUS),
            -0.5 * SPEED * dt,
            [0.0, SPEED],
            (0..=STEPS + 10).collect(),
        );
        bounce.model.dt = dt;
        let duration = move |track: &Track| {
            let pushed = (0..STEPS + 10).filter(|step| place.force(track, *step)[1] != 0.0);
            pushed.count() as f64 * dt
        };
        add(
            "contact-time",
            "contact time",
            "s",
            bounce,
            collision(place) * DT,
            Box::new(duration),
        );
    }
    all.extend(alone());
    all
}

/// π√(m/k) over Δt.
fn collision(place: Place) -> f64 {
    std::f64::consts::PI * (place.mass() / place.stiffness()).sqrt() / DT
}

/// Of one grain: gravity, local damping on the way down and up, and how it is turned.
fn alone() -> Vec<Quantity> {
    let gravity = [0.7, -9.81];
    let fall = move |axis: usize| -> Read {
        Box::new(move |track| {
            let [before, after] = [1, 2].map(|step| at(track, step).velocity(0)[axis]);
            (after - before) / DT
        })
    };
    let grain = Place::Equal.last();
    let thrown = |velocity: [f64; 2], alpha: f64| {
        let world = world(springs(MODULUS), DT, gravity, alpha, [&[], &[]]);
        case("card", world, &[grain.moving(velocity)], vec![0, 1, 2])
    };
    let row = |key, name, unit, case, asked, read| Quantity {
        key,
        name,
        unit,
        place: "one grain",
        case,
        asked,
        read,
    };
    let [down, up] = [-1.0, 1.0].map(|side: f64| -> Read {
        Box::new(move |track| {
            let [before, after] = [1, 2].map(|step| at(track, step).velocity(0)[1]);
            side * ((after - before) / DT / gravity[1] - 1.0)
        })
    });
    let turned = {
        let world = {
            let mut made = model(friction(MODULUS, 1.0, 0.5), DT);
            made.walls = vec![super::wall(grains::model::Axis::Z, 0.0)];
            made
        };
        let place = [0.0, grain.radius * (1.0 - OVERLAP)];
        case(
            "card",
            world,
            &[grain.at(place).moving([3.0, 0.0])],
            vec![0, 1, 2, 3],
        )
    };
    let inertia = Box::new(move |track: &Track| {
        let force = Place::Wall.force(track, 2)[0];
        let [before, after] = [2, 3].map(|step| at(track, step).spin(0));
        (force * DT * grain.radius / (after - before)).abs()
    });
    vec![
        row(
            "g-x",
            "gravity across",
            "m/s²",
            thrown([0.0; 2], 0.0),
            gravity[0],
            fall(0),
        ),
        row(
            "g-z",
            "gravity upwards",
            "m/s²",
            thrown([0.0; 2], 0.0),
            gravity[1],
            fall(1),
        ),
        row(
            "alpha-down",
            "local damping, falling",
            "",
            thrown([0.1, -1.0], 0.3),
            0.3,
            down,
        ),
        row(
            "alpha-up",
            "local damping, rising",
            "",
            thrown([-0.1, 1.0], 0.3),
            0.3,
            up,
        ),
        row(
            "inertia",
            "moment of inertia",
            "kg m²",
            turned,
            grain.inertia,
            inertia,
        ),
    ]
}

/// A row of the card.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    pub key: String,
    pub name: String,
    pub unit: String,
    pub place: String,
    /// What the model says.
    pub asked: f64,
    /// What the native engine's trajectory shows under the model's rules; it is not exactly what was asked where time has steps.
    pub right: f64,
    /// What this engine's shows; none where it was not asked.
    pub shown: Option<f64>,
    /// The rules that it declares, what would explain the difference, or why it was not asked.
    pub why: String,
    pub outcome: Outcome,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Card {
    pub engine: Description,
    pub rows: Vec<Row>,
}

/// Asks the engine for everything.
pub fn card(engine: &dyn Engine) -> Result<Card, EngineError> {
    let described = engine.describe()?;
    let all = quantities();
    let lacking: Vec<Option<String>> = all.iter().map(|of| engine.lacks_for(&of.case)).collect();
    let asked = all
        .iter()
        .zip(&lacking)
        .filter(|(_, lacks)| lacks.is_none());
    let cases: Vec<&Case> = asked.map(|(of, _)| &of.case).collect();
    let work = work_folder().map_err(ProgramError::File)?;
    let mut answers = engine.run_cases(&cases, work.path())?.into_iter();
    let rows = all.iter().zip(lacking).map(|(quantity, lacks)| {
        let answer = match lacks {
            Some(lacks) => Err(format!("it has no {lacks}")),
            None => answers
                .next()
                .unwrap_or_else(|| Err("it did not answer".to_owned())),
        };
        quantity.row(answer, described.rules)
    });
    let mut rows: Vec<Row> = rows.collect();
    tell_causes(&all, &mut rows, described.rules);
    Ok(Card {
        engine: described,
        rows,
    })
}

impl Quantity {
    fn row(&self, answer: Result<Track, String>, declared: Rules) -> Row {
        let mut row = Row {
            key: format!("{}/{}", self.key, self.place.replace(' ', "-")),
            name: self.name.to_owned(),
            unit: self.unit.to_owned(),
            place: self.place.to_owned(),
            asked: self.asked,
            right: self.of(&Variant::default()),
            shown: None,
            why: String::new(),
            outcome: Outcome::Skipped,
        };
        match answer {
            Err(why) => row.why = why,
            Ok(track) => {
                row.shown = Some((self.read)(&track));
                (row.outcome, row.why) = self.explained(&row, declared);
            }
        }
        row
    }

    /// What a variant's trajectory shows.
    fn of(&self, variant: &Variant) -> f64 {
        (self.read)(&run(&self.case, variant))
    }

    /// Whether this is right, or right by the rules that are declared.
    fn explained(&self, row: &Row, declared: Rules) -> (Outcome, String) {
        if row.is(row.right) {
            return (Outcome::Pass, "as asked".to_owned());
        }
        let under = variant(declared);
        if !row.is(self.of(&under)) {
            let times = row.shown.unwrap_or(f64::NAN) / row.right;
            return (Outcome::Fail, format!("{times:.6} times what is right"));
        }
        // Those without which it would not be.
        let needed = |choice: &Choice| {
            let mut without = under.clone();
            without.forms.retain(|form| *form != Form::Rule(*choice));
            !row.is(self.of(&without))
        };
        let names = declared.unusual().filter(needed);
        let names: Vec<String> = names.map(Choice::name).collect();
        (
            Outcome::Pass,
            format!("as it declares: {}", names.join(", ")),
        )
    }
}

impl Row {
    /// Whether the engine's trajectory shows this.
    fn is(&self, value: f64) -> bool {
        let near = |shown: f64| (shown - value).abs() <= TOLERANCE * self.right.abs();
        self.shown.is_some_and(near)
    }
}

/// With these rules.
fn variant(rules: Rules) -> Variant {
    Variant {
        forms: rules.unusual().map(Form::Rule).collect(),
        ..Variant::default()
    }
}

/// With what native would show a wrong row too: what leaves no row that is right wrong, and explains most of those that are wrong.
fn tell_causes(all: &[Quantity], rows: &mut [Row], declared: Rules) {
    let under = variant(declared);
    let with = |quantity: &Quantity, one: Otherwise| quantity.of(&one.beside(&under));
    let mut counted: Vec<(Otherwise, usize)> = Vec::new();
    let mut told: Vec<(usize, String)> = Vec::new();
    let wrong = |row: &Row| row.outcome == Outcome::Fail;
    for (at, quantity) in all.iter().enumerate().filter(|(at, _)| wrong(&rows[*at])) {
        let mut case = quantity.case.clone();
        case.model.rules = declared;
        let mut explains: Vec<(Otherwise, usize)> = Vec::new();
        for one in Otherwise::all(&case) {
            if !rows[at].is(with(quantity, one)) {
                continue;
            }
            let known = counted.iter().find(|(other, _)| *other == one);
            let count = known.map_or_else(
                || {
                    let pairs = || all.iter().zip(rows.iter());
                    let mut right = pairs().filter(|(_, row)| row.outcome == Outcome::Pass);
                    let keeps = right.all(|(of, row)| row.is(with(of, one)));
                    let others = pairs().filter(|(_, row)| wrong(row));
                    let count = others.filter(|(of, row)| row.is(with(of, one))).count();
                    if keeps { count } else { 0 }
                },
                |(_, count)| *count,
            );
            counted.push((one, count));
            explains.push((one, count));
        }
        let most = explains.iter().map(|(_, count)| *count).max().unwrap_or(0);
        let best = explains
            .iter()
            .filter(|(_, count)| *count == most && most > 0);
        let best: Vec<String> = best.map(|(one, _)| one.name()).collect();
        if !best.is_empty() {
            told.push((at, format!("as with {}", best.join(", or "))));
        }
    }
    for (at, why) in told {
        rows[at].why = why;
    }
}

impl Card {
    pub fn checks(&self) -> Vec<Check> {
        let check = |row: &Row| {
            let words = format!("{}, {}", row.name, row.place);
            let check = Check::of_words(format!("card/{}", row.key), &words, row.outcome, &row.why);
            let mut check = check.with_limits(
                row.shown.unwrap_or(f64::NAN),
                row.right,
                Some(TOLERANCE * row.right.abs()),
            );
            check.unit.clone_from(&row.unit);
            check
        };
        self.rows.iter().map(check).collect()
    }

    pub fn document(&self) -> Document {
        let checks = self.checks();
        let other = self.rows.iter().filter(|row| row.outcome == Outcome::Fail);
        let other: Vec<String> = other
            .map(|row| format!("{} at {}: {}", row.name, row.place, row.why))
            .collect();
        let asked = self.rows.iter().filter(|row| row.shown.is_some()).count();
        let answer = match (other.is_empty(), asked) {
            (_, 0) => "It has nothing of what is asked for.".to_owned(),
            (true, _) => {
                format!("All {asked} constants that it was asked for are what its grains show.")
            }
            (false, _) => format!(
                "{} of {asked} constants are not what was asked for: {}.",
                other.len(),
                other.join("; ")
            ),
        };
        let table = Table::of("card", "Asked and shown", &self.rows)
            .column("constant", |row: &Row| &row.name)
            .column("at", |row: &Row| &row.place)
            .column("asked", |row: &Row| row.asked)
            .column("right", |row: &Row| row.right)
            .column("shown", |row: &Row| row.shown)
            .column("unit", |row: &Row| &row.unit)
            .column("which is", |row: &Row| &row.why);
        let about = "Read from how a grain moves from one step to the next; forces that the engine writes play no part. Right is what the same \
                     reading gives of the native engine, whose steps are the same.";
        Document {
            title: format!("Card of {}", self.engine.label()),
            verdict: if asked == 0 {
                Outcome::Skipped
            } else {
                verdict(&checks)
            },
            answer,
            sections: vec![Section::new("Constants", about).with(Table::from(table))],
            checks,
        }
    }
}
