//! What a card draws of contacts in space.

use std::f64::consts::PI;

use super::asked::{Kind, LONG, MORE, Meeting, PLACES, Place, SPEED, STEPS, TENSION};
use crate::document::{Axis as Scale, Colour, Mark, Plot, Point, Shape, Style};
use crate::engine::Description;
use crate::suite::Track;
use grains::scene::Viscosity;
use grains::task::Case;

type Points = Vec<[f64; 2]>;
type Trace = Box<dyn Fn(&Track) -> Points>;

/// A line in a picture: one experiment, and the points that its trajectory goes through.
pub struct Line {
    picture: usize,
    pub name: String,
    pub case: Case,
    pub trace: Trace,
}

/// Of an engine that has spheres with Hertz's law: a normal contact at several places and speeds, and the way of a tangential force
/// while the contact turns, which comes back to where it began only if nothing slides.
pub fn lines(engine: &Description) -> Vec<Line> {
    let kind = Kind::Hertz;
    if !kind.is_in(engine) {
        return Vec::new();
    }
    let mut all = Vec::new();
    let viscosity = Viscosity::restitution(0.5, TENSION);
    let places = PLACES.into_iter().filter(|place| place.is_in(kind, engine));
    for place in places {
        let meeting = Meeting { place, kind };
        let rates = [1.0, MORE];
        let count = 1 + usize::from(place == Place::Equal);
        for rate in rates.into_iter().take(count) {
            let speed = rate * SPEED;
            let law = kind.with_dashpots(meeting.law(1.0, 0.0), viscosity.clone());
            let case = meeting.bounce(law, speed, STEPS, (0..=2 * STEPS).collect());
            let dt = case.model.dt;
            let [stiffness, _] = meeting.stiffness(&case.model.law);
            let depth = (1.25 * meeting.mass() * speed * speed / stiffness).powf(0.4);
            let most = stiffness * depth.powf(1.5);
            let trace = move |track: &Track| {
                let point = |step: u64| {
                    let force = meeting.force(track, step, dt)[0] / most;
                    let overlap = meeting.overlap(track, step) / depth;
                    (overlap >= 0.0).then_some([overlap, force])
                };
                (1..2 * STEPS).filter_map(point).collect()
            };
            let faster = if rate == 1.0 {
                ""
            } else {
                ", 10 times as fast"
            };
            all.push(Line {
                picture: 0,
                name: format!("{}{faster}", place.name()),
                case,
                trace: Box::new(trace),
            });
        }
    }
    for place in [Place::Equal, Place::Wall] {
        let meeting = Meeting { place, kind };
        for (friction, word) in [(1.2, "sticks"), (0.08, "slides")] {
            let case = meeting.turning(friction, 2.0 * PI, (0..=LONG + 1).collect());
            let dt = case.model.dt;
            let trace = move |track: &Track| {
                let point = |step: u64| {
                    let [out, along, across] = meeting.force(track, step, dt);
                    [along / out, across / out]
                };
                (1..=LONG).map(point).collect()
            };
            all.push(Line {
                picture: 1,
                name: format!("{}, {word}", place.name()),
                case,
                trace: Box::new(trace),
            });
        }
    }
    all
}

/// What lines the engine's answers and native's make: points on lines.
pub fn pictures(lines: &[(Line, [Points; 2])]) -> Vec<Plot> {
    let about = [
        (
            "card-normal",
            "Normal force against overlap, over Hertz's largest without a dashpot; restitution 0.5. Points are the engine's, lines the native engine's.",
            ["overlap", "force"],
        ),
        (
            "card-loop",
            "The tangential force over the normal one while the contact turns once about its normal: what sticks comes back, what slides does not.",
            ["along the slip", "across it"],
        ),
    ];
    let plots = about
        .into_iter()
        .enumerate()
        .map(|(at, (name, caption, [x, y]))| {
            let own = lines.iter().filter(|(line, ..)| line.picture == at);
            let colours = Colour::OF_LINES
                .into_iter()
                .chain([Colour::Sky, Colour::Grey])
                .cycle();
            let marks = own
                .zip(colours)
                .flat_map(|((line, [shown, right]), colour)| {
                    let points = shown.iter().step_by(4).map(|[x, y]| Point::at(*x, *y));
                    let line_of = Shape::Line {
                        dashed: false,
                        points: right.clone(),
                    };
                    let points = Shape::Points {
                        style: Style::Hollow,
                        points: points.collect(),
                    };
                    [
                        Mark {
                            name: line.name.clone(),
                            colour,
                            shape: line_of,
                        },
                        Mark {
                            name: String::new(),
                            colour,
                            shape: points,
                        },
                    ]
                });
            Plot {
                name: name.to_owned(),
                caption: caption.to_owned(),
                x: Scale::linear(x),
                y: Scale::linear(y),
                wide: false,
                marks: marks.collect(),
            }
        });
    plots.filter(|plot| !plot.marks.is_empty()).collect()
}
