//! How much slip a new contact is given: of the whole step in which it was made, or since the surfaces met.

use super::experiment::{Experiment, view};
use crate::suite::build::{self, Grain};
use crate::suite::line;
use crate::suite::{Line, Track};
use grains::case::Case;
use grains::model::{Axis, Law, Model};
use grains::scene::{ContactLaw, NewContactSlip};

/// A ball that touches a wall between two steps; the friction is too high for it to slide at once.
struct FirstSlip {
    name: &'static str,
    slip: NewContactSlip,
}

/// As in YADE.
pub fn of_whole_steps() -> Vec<Box<dyn Experiment>> {
    let (name, slip) = ("whole step", NewContactSlip::WholeStep);
    vec![Box::new(FirstSlip { name, slip })]
}

/// As it would be without steps.
pub fn since_touch() -> Vec<Box<dyn Experiment>> {
    let (name, slip) = ("since touch", NewContactSlip::SinceTouch);
    vec![Box::new(FirstSlip { name, slip })]
}

/// k_n, N/m.
const STIFFNESS: f64 = 1.0e5;
/// k_s/k_n.
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

impl FirstSlip {
    /// The first step with a contact.
    fn first(&self) -> u64 {
        LEAD.ceil() as u64
    }

    fn place(&self) -> f64 {
        WALL + RADIUS + LEAD * DT * SPEEDS[1]
    }

    /// u at that step, m.
    fn overlap(&self) -> f64 {
        WALL + RADIUS - (self.place() - self.first() as f64 * DT * SPEEDS[1])
    }
}

impl Experiment for FirstSlip {
    fn cases(&self) -> Vec<Case> {
        let plain = build::friction(STIFFNESS / RADIUS, RATIO, 1.5);
        let law = Law {
            contact: ContactLaw {
                new_contact_slip: self.slip,
                ..plain.contact
            },
            ..plain
        };
        let model = Model {
            walls: vec![build::wall(Axis::Z, WALL)],
            ..build::model(law, DT)
        };
        let ball = Grain::sphere([0.0, self.place()], RADIUS, 2500.0);
        let ball = ball.moving([SPEEDS[0], -SPEEDS[1]]);
        vec![build::case(self.name, model, &[ball], vec![self.first()])]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let contact = view(tracks, 0, self.first()).contact();
        let overlap = self.overlap();
        // Slip of the undeformed surface, as the default law has it: stretched, and so is the approach that
        // the time since touch is told from.
        let stretch = 2.0 * RADIUS / (2.0 * RADIUS - overlap);
        let slip = match self.slip {
            NewContactSlip::WholeStep => stretch * SPEEDS[0] * DT,
            NewContactSlip::SinceTouch => SPEEDS[0] / SPEEDS[1] * overlap,
        };
        let force = RATIO * STIFFNESS * slip;
        // Positions of the size of wall and radius make an overlap of a fraction of a step.
        let rounding = 4.0 * f64::EPSILON * (WALL + RADIUS) / overlap;
        vec![line(
            format!("tangential force at first touch, {}", self.name),
            "N",
            contact.map_or(f64::NAN, |contact| contact.tangential_force),
            force,
            force * (rounding + 8.0 * f64::EPSILON),
            "k_s times the slip; rounding of the overlap",
        )]
    }
}
