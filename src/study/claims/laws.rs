//! Theory against theory: which of the laws that are said to hold for single-grain stresses describes them best, by likelihood.
//! Grains that bear nothing are a share of their own, the same under every law, so the laws are compared by the others.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::sample::{self, Moment};
use super::{LEVEL, adjust};
use crate::document::{Axis, Colour, Plot, Point, Section, Table};
use crate::paper::published::POINTS;
use crate::study::campaign::Member;
use evidence::distribution::{Distribution, Family};
use evidence::moments::mean;
use evidence::{Interval, goodness, likelihood, proportion};
use grains::measure::neighbourhood::SINGLY;

/// Samples drawn of a law that may be possible.
const DRAWN: usize = 999;
/// Laws against each other in one sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contest {
    pub moment: Moment,
    pub point: Cow<'static, str>,
    /// Grains of each packing, the nearest to the point.
    pub grains: usize,
    pub packings: usize,
    /// Share of grains that bear nothing, or are pulled.
    pub nothing: Option<Interval>,
    /// The likeliest first.
    pub laws: Vec<Contender>,
    /// Independent grains of the best law of which nine samples in ten show, by the same test, that it is nearer than an exponential;
    /// none where thousands do not, and for several grains a packing.
    pub seen_from: Option<usize>,
    /// Stresses over their mean, from small to large, of the nearest grain in each packing.
    pub values: Vec<f64>,
}

/// A law in a contest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contender {
    /// Its likeliest parameters, of stresses over their mean.
    pub law: Distribution,
    /// Mean of ln f(best)/f(this) of a grain.
    pub behind: f64,
    /// p of both being equally far from the truth, by packing (Vuong), after Holm's correction over all contests; none for the
    /// best.
    pub as_near: Option<f64>,
    /// p of a distance D as large if the law were true, parameters fitted to drawn samples too, after Holm's correction; for a
    /// grain a packing.
    pub possible: Option<f64>,
}

impl Contender {
    fn title(&self) -> &'static str {
        self.law.family().title()
    }

    /// The parameter that gives the form.
    fn form(&self) -> Option<f64> {
        match self.law {
            Distribution::Gamma { shape, .. }
            | Distribution::Weibull { shape, .. }
            | Distribution::GaussianTail { shape, .. } => Some(shape),
            Distribution::StretchedExponential { power, .. } => Some(power),
            _ => None,
        }
    }

    /// Whether it is not told from the best.
    fn is_level(&self) -> bool {
        self.as_near.is_none_or(|p| p >= 1.0 - LEVEL)
    }
}

/// All contests of a campaign: the nearest grain and the nearest [`SINGLY`], each point, before and under the load.
pub fn contests(members: &[Member]) -> Vec<Contest> {
    let mut all = Vec::new();
    for moment in Moment::BOTH {
        for point in POINTS {
            for grains in [1, SINGLY] {
                all.extend(contest(members, moment, point, grains));
            }
        }
    }
    let laws = all.iter_mut().flat_map(|contest| &mut contest.laws);
    adjust(laws.filter_map(|contender| contender.as_near.as_mut()));
    let laws = all.iter_mut().flat_map(|contest| &mut contest.laws);
    adjust(laws.filter_map(|contender| contender.possible.as_mut()));
    all
}

fn contest(
    members: &[Member],
    moment: Moment,
    point: &'static str,
    grains: usize,
) -> Option<Contest> {
    let around = sample::nearest(members, moment, point, grains);
    let stress = around.iter().map(|cells| {
        let own = cells.iter().map(|one| one.zz / one.cell);
        own.filter(|value| *value > 0.0).collect::<Vec<f64>>()
    });
    let mut stress: Vec<Vec<f64>> = stress.collect();
    let middle = mean(&stress.concat());
    stress
        .iter_mut()
        .flatten()
        .for_each(|value| *value /= middle);
    let mut pooled = stress.concat();
    let all = around.len() * grains;
    let fits = Family::OF_STRESSES.iter().map(|family| family.fit(&pooled));
    let mut fits: Vec<Distribution> = fits.collect::<Option<_>>()?;
    fits.sort_by(|one, other| {
        let [one, other] = [one, other].map(|law| law.log_likelihood(&pooled));
        other.total_cmp(&one)
    });
    let best = fits[0];
    let contender = |law: &Distribution| {
        let groups = stress.iter().map(Vec::as_slice);
        let difference = best.log_likelihood(&pooled) - law.log_likelihood(&pooled);
        let test = |family| goodness::fitted(family, &pooled, DRAWN);
        Contender {
            law: *law,
            behind: difference / pooled.len() as f64,
            as_near: likelihood::between(best, *law, groups).map(|found| found.p),
            possible: (grains == 1)
                .then(|| test(law.family()))
                .flatten()
                .map(|fit| fit.kolmogorov_p),
        }
    };
    let laws = fits.iter().map(contender).collect();
    let seen = || likelihood::seen_from(&best, Family::Exponential);
    pooled.sort_by(f64::total_cmp);
    Some(Contest {
        moment,
        point: point.into(),
        grains,
        packings: around.len(),
        nothing: proportion::wilson(all - pooled.len(), all, LEVEL).filter(|_| grains == 1),
        laws,
        seen_from: (grains == 1).then(seen).flatten(),
        values: if grains == 1 { pooled } else { Vec::new() },
    })
}

impl Contest {
    fn title(&self) -> String {
        let grains = match self.grains {
            1 => "nearest grain".to_owned(),
            many => format!("{many} nearest grains"),
        };
        format!("{}, {grains}, {}", self.point, self.moment.words())
    }

    /// The best law and those that are not told from it, for people.
    fn level(&self) -> String {
        let level = self.laws.iter().filter(|contender| contender.is_level());
        let level: Vec<&str> = level.map(Contender::title).collect();
        level.join(", ")
    }

    fn of(&self, family: Family) -> Option<&Contender> {
        self.laws
            .iter()
            .find(|contender| contender.law.family() == family)
    }

    /// Shares of grains above multiples of the mean, on a scale where an exponential is a straight line.
    fn tails(&self) -> Plot {
        const POINTS: usize = 60;
        const UP_TO: f64 = 6.0;
        let n = self.values.len();
        let title = self.title();
        let name = format!("tail-{}-{}", self.moment.key(), self.point.to_lowercase());
        let caption = format!("{title}: share of {n} stresses above multiples of their mean");
        let x = Axis::linear("stress over its mean");
        let y = Axis::logarithmic("share above");
        let plot = Plot::new(&name, caption, x, y);
        let plot = self.laws.iter().fold(plot, |plot, contender| {
            let place = Family::OF_STRESSES
                .iter()
                .position(|own| *own == contender.law.family());
            let colour = place.map_or(Colour::Grey, |place| Colour::OF_LINES[place]);
            let places = (0..=POINTS).map(|index| UP_TO * index as f64 / POINTS as f64);
            let line = places.map(|at| [at, contender.law.survival(at)]);
            plot.line(
                contender.title(),
                colour,
                line.filter(|[_, share]| *share * n as f64 > 0.2),
            )
        });
        // The largest one by one, the others thinned.
        let shown = (0..n).filter(|rank| n - rank < 20 || rank % (n / 40).max(1) == 0);
        let share = |rank: usize| (n as f64 - rank as f64 - 0.5) / n as f64;
        let within = shown.filter(|rank| self.values[*rank] <= UP_TO);
        let points = within.map(|rank| Point::at(self.values[rank], share(rank)));
        plot.points("packings", Colour::Grey, points)
    }
}

/// What the contests say: an answer a place, every number, and the tails.
pub fn section(contests: &[Contest]) -> Section {
    const TITLE: &str = "Theory against theory";
    if contests.is_empty() {
        return Section::new(TITLE, "Too few packings to tell laws apart.");
    }
    let best = |family: Family| {
        let is_level = |contest: &&Contest| contest.of(family).is_some_and(Contender::is_level);
        contests.iter().filter(is_level).count()
    };
    let counts = Family::OF_STRESSES.map(|family| format!("{} {}", family.title(), best(family)));
    let words = format!(
        "Each law is the best, or not told from the best, in so many of {} samples: {}. Two laws are told apart where packings show which of \
         them is nearer to the truth (Vuong's test with packings as the unit, 5 % over all comparisons). \"Told apart from\" is the number of \
         independent grains of the best law of which nine samples in ten show it, drawn and tested in the same way (5 % each); none \
         where 2,048 do not. A law is possible where drawn samples of it are as often as far from it (Kolmogorov's D, fitted \
         anew, one grain a packing; p-values count all tests, so that none is below 0.03). A law with more parameters may be nearer and \
         yet not possible: its own samples lie nearer still. A stretched exponential is exp(−xᵃ), a Gaussian tail a power of x times exp(−x²). Grains that bear \
         nothing are a share of their own, the same under every law.",
        contests.len(),
        counts.join(", ")
    );
    let exponential = |contest: &Contest| contest.of(Family::Exponential).cloned();
    let answers = Table::of("laws", "Which law holds where", contests)
        .column("sample", Contest::title)
        .column("best, or not told from it", Contest::level)
        .column("exponential: as near as the best, p", move |contest| {
            exponential(contest)?.as_near
        })
        .column("exponential: possible, p", move |contest| {
            exponential(contest)?.possible
        })
        .column("best: possible, p", |contest| {
            contest.laws.first()?.possible
        })
        .column("exponential: told apart from, grains", |contest| {
            contest.seen_from
        })
        .column("bear nothing", |contest| contest.nothing);
    let rows = contests
        .iter()
        .flat_map(|contest| contest.laws.iter().map(move |law| (contest, law)));
    let every = Table::of("every-law", "Every law in every sample", rows)
        .column("sample", |(contest, _)| contest.title())
        .column("law", |(_, law)| law.title())
        .column("shape or power", |(_, law)| law.form())
        .column(
            "behind the best, mean logarithm of the density",
            |(_, law)| law.behind,
        )
        .column("as near as the best, p", |(_, law)| law.as_near)
        .column("possible, p", |(_, law)| law.possible)
        .column("packings", |(contest, _)| contest.packings);
    let tails = contests
        .iter()
        .filter(|contest| !contest.values.is_empty())
        .map(Contest::tails);
    Section::new(TITLE, words)
        .with(answers)
        .with_all(tails)
        .with(every)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::campaign::Fields;
    use crate::study::realization::Ending;
    use evidence::random::{Key, Source};
    use grains::measure::neighbourhood::{Neighbour, Neighbourhood};

    const KEY: Key = *b"crossgrain: tests of many theory";

    /// Packings whose grains bear stresses of this law, one in ten nothing.
    fn packings(law: Distribution, count: u64) -> Vec<Member> {
        let mut source = Source::new(&KEY, 0);
        let mut neighbour = || Neighbour {
            from_point: [0.0; 2],
            contacts: 3,
            cell: 2.0,
            xx: 0.0,
            zz: match source.uniform() < 0.1 {
                true => 0.0,
                false => law.draw(&mut source),
            },
            xz: 0.0,
        };
        let mut member = |realization| Member {
            loaded: Some(Fields {
                across: Vec::new(),
                down: Vec::new(),
                points: vec![Neighbourhood {
                    point: "O".to_owned(),
                    singly: (0..SINGLY).map(|_| neighbour()).collect(),
                    together: Vec::new(),
                }],
            }),
            member: realization,
            realization,
            ending: Ending::Reached,
            ..Member::default()
        };
        (1..=count).map(&mut member).collect()
    }

    /// The law that they have is level with the best, and the others fall behind as they must.
    #[test]
    fn the_law_of_the_packings_is_found() {
        let half_normal = Distribution::GaussianTail {
            shape: 0.5,
            scale: 3.0,
        };
        let exponential = Distribution::Exponential { mean: 3.0 };
        for (law, told) in [
            (exponential, Family::GaussianTail),
            (half_normal, Family::Exponential),
        ] {
            let members = packings(law, 400);
            let found = contest(&members, Moment::Loaded, "O", SINGLY).expect("all laws fit");
            let own = found.of(law.family()).expect("one of the laws");
            assert!(own.is_level(), "{found:?}");
            let other = found.of(told).expect("one of the laws");
            // An exponential is ½ − ln(π/2) = 0.048 behind half of a normal law.
            assert!(!other.is_level() && other.behind > 0.03, "{found:?}");
            let singly = contest(&members, Moment::Loaded, "O", 1).expect("all laws fit");
            let nothing = singly.nothing.expect("a grain each");
            assert!(nothing.low < 0.1 && nothing.high > 0.1, "{nothing:?}");
            let possible = |family| singly.of(family).and_then(|contender| contender.possible);
            assert!(possible(law.family()).is_some_and(|p| p > 0.01));
            assert!(possible(told).is_some_and(|p| p < 0.01));
            let best_is_other = law != exponential;
            let seen = singly
                .seen_from
                .is_some_and(|grains| (100..400).contains(&grains));
            assert_eq!(seen, best_is_other, "{:?}", singly.seen_from);
        }
        assert!(contest(&[], Moment::Loaded, "O", 1).is_none());
    }
}
