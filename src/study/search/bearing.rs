//! What friction a punch needs that is no impact: by the classical formula, and by the settings of a search that were run. A setting is the
//! unit; its beds were poured in ways of its own.

use crate::document::{Axis, Colour, Plot, Point, Section, Table};
use crate::paper::bearing::needed;
use crate::paper::continuum::table::Setup;
use crate::study::search::matching::{REACHED, Search};
use crate::study::search::space::{AXES, LOADING_FRICTION, PUNCH_SPEED};
use evidence::Interval;
use evidence::proportion::wilson;

/// Friction angles of loading in classes, each up to this, rad: none, then more.
const UP_TO: [f64; 6] = [0.0, 0.1, 0.2, 0.3, 0.45, 0.6];
/// Speeds of the punch, each class from this to the next, m/s; slow ones first.
const FROM: [f64; 4] = [0.02, 0.04, 0.08, 0.2];

/// Settings of a class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Class {
    /// Above the first, up to the second, rad; zero alone in the first class.
    pub friction: [f64; 2],
    /// m/s.
    pub speed: [f64; 2],
    pub settings: usize,
    /// Those of which every punch got the force.
    pub borne: usize,
}

impl Class {
    pub fn share(&self) -> Option<Interval> {
        wilson(self.borne, self.settings, 0.95)
    }
}

impl Search {
    /// By speed, then by friction.
    pub fn borne(&self) -> Vec<Class> {
        let mut classes = Vec::new();
        for speed in FROM.windows(2) {
            for (index, high) in UP_TO.iter().enumerate() {
                let low = index.checked_sub(1).map_or(-1.0, |before| UP_TO[before]);
                let own = self.observed.iter().filter_map(|observed| {
                    let value = |axis: usize| AXES[axis].scale.value(observed.at[axis]);
                    let (friction, own) = (value(LOADING_FRICTION), value(PUNCH_SPEED));
                    let within = low < friction
                        && friction <= high + 1e-9
                        && (speed[0]..speed[1] + 1e-9).contains(&own);
                    Some(observed.sampled.get(REACHED)?.mean).filter(|_| within)
                });
                let shares: Vec<f64> = own.collect();
                classes.push(Class {
                    friction: [low.max(0.0), *high],
                    speed: [speed[0], speed[1]],
                    settings: shares.len(),
                    borne: shares.iter().filter(|share| **share >= 1.0).count(),
                });
            }
        }
        classes
    }

    pub(super) fn bearing(&self) -> Section {
        let classes = self.borne();
        let middle = |class: &Class| 0.5 * (class.friction[0] + class.friction[1]);
        let x = Axis::linear("friction angle between grains in loading, rad");
        let y = Axis::linear("settings of which every punch got the force").within(0.0, 1.0);
        let caption = "Share of settings of which every punch got the force, with 95 % intervals";
        let mut plot = Plot::new("bearing", caption, x, y);
        for (speed, colour) in FROM.windows(2).zip(Colour::OF_LINES) {
            let own = classes.iter().filter(|class| class.speed[0] == speed[0]);
            let points = own.filter_map(|class| {
                let share = class.share()?;
                Some(Point::at(middle(class), share.estimate).between(share.low, share.high))
            });
            plot = plot.points(&format!("{} to {} m/s", speed[0], speed[1]), colour, points);
        }
        let table = Table::of("bearing", "Settings by friction and speed", classes)
            .column("friction, rad", |class| match class.friction {
                [_, 0.0] => "none".to_owned(),
                [low, high] => format!("above {low}, up to {high}"),
            })
            .column("speed, m/s", |class| {
                format!("{} to {}", class.speed[0], class.speed[1])
            })
            .column("settings", |class| class.settings)
            .column("every punch got the force", |class| class.borne)
            .column("share (95 %)", |class| class.share());
        let setup = Setup::published();
        let angle = |depth| needed(&setup, depth).to_degrees();
        let words = format!(
            "A strip on ground without cohesion bears γ (d N_q + a N_γ) before it sinks, d the depth of its base, with the factors of Prandtl, \
             Reissner and Vesić. The published load needs ground of {:.1}° at the surface, {:.1}° at 40 mm and {:.1}° at 110 mm, where a punch gives up. \
             The friction of ground is not that of its grains, so that the two are not to be equal; but discs without friction are no such \
             ground. What a fast punch gets beyond that is inertia.",
            angle(0.0),
            angle(0.04),
            angle(0.11)
        );
        Section::new("Which friction bears the load?", words)
            .with(plot)
            .with(table)
    }
}
