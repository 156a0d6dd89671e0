//! What a benchmark says: its checks, what of it travels between machines, and the whole for people.

use super::Bench;
use super::bed::PAPER;
use super::contender::{Contender, Contest};
use super::scaling::{Point as Size, SpeedUp};
use super::timing::Spread;
use crate::checks::{Check, Outcome, Speed};
use crate::compare::bits::TableBits;
use crate::document::plot::Point;
use crate::document::{Axis, Colour, Document, Plot, Section, Table, rounded};
use grains::native::timing::Share;

impl Bench {
    /// Every check: beds, bits, and what was missed. No time counts.
    pub fn checks(&self) -> Vec<Check> {
        let mut checks: Vec<Check> = self.contests.iter().flat_map(of_bed).collect();
        let ways = [
            ("bench/bits", "", &self.sorted_bits),
            (
                "bench/bits-friction",
                ", with friction",
                &self.friction_bits,
            ),
            ("bench/bits-space", ", spheres in space", &self.space_bits),
        ];
        for (id, with, bits) in ways {
            let Some(bits) = bits else { continue };
            let what = format!("native against YADE's sorted loop{with}");
            let outcome = Outcome::pass_if(bits.agrees());
            let check = Check::of_words(id, &what, outcome, &bits.to_string());
            let mut check = check.with_limits(bits.differing as f64, 0.0, Some(0.0));
            check.n = bits.numbers as u64;
            checks.push(check.judged_by(
                "how many numbers differ in any bit after the same steps",
                "both engines do the same operations in the same order (docs/determinism.md)",
            ));
        }
        checks.extend(self.missed.iter().map(|missed| {
            let outcome = [Outcome::Skipped, Outcome::Fail][usize::from(missed.failed)];
            let id = format!("bench/missed/{}", missed.id);
            let mut check = Check::of_words(id, &missed.what, outcome, &missed.why);
            check.required = missed.needed;
            check.engine_failed = missed.failed;
            check
        }));
        checks
    }

    /// The other engines that were timed beside native, with their times over its.
    fn others_over_native(&self) -> impl Iterator<Item = (&Contest, &Spread)> {
        let others = self
            .contests
            .iter()
            .filter(|contest| !contest.contender.is_native());
        others.filter_map(|contest| Some((contest, contest.over_native.as_ref()?)))
    }

    /// Times over native's, and what friction costs native.
    pub fn speeds(&self) -> Vec<Speed> {
        // What others take longer is to native's credit.
        let speed = |id: &str, what: String, unit: &str, ratio: &Spread, less_is_better| Speed {
            id: format!("time/{id}"),
            what,
            unit: unit.to_owned(),
            value: ratio.median,
            range: Some([ratio.least, ratio.most]),
            less_is_better,
        };
        let ratios = self.others_over_native().map(|(contest, over)| {
            let what = format!("time a step of {} over native", contest.name);
            speed(contest.contender.id(), what, "times native", over, false)
        });
        let friction = self.friction_cost.as_ref().map(|cost| {
            let what = "time a step of native with friction over that without".to_owned();
            speed("friction", what, "times without friction", cost, true)
        });
        ratios.chain(friction).collect()
    }

    pub fn document(&self) -> Document {
        let differ = |bits: &TableBits| format!("{} of {}", bits.differing, bits.numbers);
        let [sorted, friction, space] = [&self.sorted_bits, &self.friction_bits, &self.space_bits]
            .map(|bits| bits.as_ref().map(differ));
        let mut answer = match sorted {
            Some(differ) => format!(
                "Native against YADE's sorted loop, timed on the same bed: {differ} positions and velocities differ."
            ),
            None => "The bits of YADE's sorted loop were not compared.".to_owned(),
        };
        answer
            .extend(friction.map(|differ| format!(" With friction, spins too: {differ} differ.")));
        answer.extend(space.map(|differ| format!(" Of spheres in space {differ}.")));
        let disturbed = " The machine was busy with other things: some engine had the processor for less than 95 % of the time. Measure again \
             on an idle machine before believing any ratio.";
        answer += if self.disturbed { disturbed } else { "" };
        Document::new("What a step costs", answer, self.checks()).with([
            self.side_by_side(),
            self.stages(),
            self.sizes(),
            self.machine(),
        ])
    }

    fn side_by_side(&self) -> Section {
        let micro =
            |measure: fn(&Spread) -> f64| move |row: &Contest| 1e6 * measure(&row.seconds_per_step);
        let table = Table::of("engines", "", &self.contests)
            .column("engine", |contest| &contest.name)
            .column("time a step, median, µs", micro(|spread| spread.median))
            .column("least, µs", micro(|spread| spread.least))
            .column("most, µs", micro(|spread| spread.most))
            .column("steps", |contest| contest.steps)
            .column("least share of the processor", |contest| {
                contest.processor_share
            })
            .column("times native", |row| Some(row.over_native.as_ref()?.median))
            .column("95 % interval", |row| {
                row.over_native.as_ref()?.median_interval()
            })
            .column("contacts", |contest| contest.state_check.contacts)
            .column("moved, R", |contest| contest.state_check.displacement)
            .column("kinetic energy, mJ", |contest| {
                1e3 * contest.state_check.energy
            })
            .column("bed", |contest| Outcome::pass_if(contest.state_check.holds));
        let answer = "Every engine takes a turn in every round, on one thread, from the same bed; every second round goes backwards. \
                      Times are processor time of steps alone, without start, reading and tables.";
        let grains = self.bed.grains;
        let title = format!("Side by side on the settled bed of {grains} grains");
        let section = Section::new(&title, answer).with_all(self.ratios());
        let mut section = section.with(table).with(
            "The bed: contacts between grains, the largest distance of a grain from its place in native after the same steps, \
             kinetic energy. YADE runs with verletDist 1e-4 m, its best on this bed, frictionless as the scene is; it computes spheres \
             in three dimensions with friction and rotation at hand, and a good part of the ratio is what is not computed. With \
             friction (angle 0.5, grains free to turn) nothing is left out in any, and engines are held against native \
             with friction. LAMMPS and LIGGGHTS know one stiffness for all pairs and have a drag force in place of Cundall's \
             damping, and without friction do not integrate rotation, so their bed is a slightly other one, and their time is that of \
             a general code over the same pairs. Spheres in space have Hertz's and Mindlin's springs, friction and Cundall's damping; LAMMPS's \
             springs at walls are stiffer, and its tangential springs keep a displacement.",
        );
        if let Some(cost) = &self.friction_cost {
            let rounds = (cost.least, cost.most);
            let (words, (low, high)) = (cost.median_interval())
                .map_or(("rounds", rounds), |median| {
                    ("95 % interval", (median.low, median.high))
                });
            let [times, low, high] = [cost.median, low, high].map(|times| rounded(times, 3));
            section = section.with(format!(
                "A step of native with friction takes {times} times as long as one without ({words} {low}–{high})."
            ));
        }
        let external = self.contests.iter();
        for contest in external.filter(|contest| contest.contender == Contender::External) {
            let said = match contest.approximations.as_slice() {
                [] => "nothing else than the model.".to_owned(),
                said => said.join("; "),
            };
            section = section.with(format!(
                "{} is a process a run: its time is that of {} steps less that of {}. It says of itself: {said}",
                contest.name,
                2 * contest.steps,
                contest.steps
            ));
        }
        section
    }

    /// Each round's ratio to native, and the median with the middle half.
    fn ratios(&self) -> Option<Plot> {
        let rows: Vec<_> = self.others_over_native().collect();
        let rounds = rows.iter().enumerate().flat_map(|(row, (_, over))| {
            let points = over.all.iter();
            points.map(move |ratio| Point::at(*ratio, row as f64))
        });
        let medians = rows.iter().enumerate().map(|(row, (_, over))| {
            Point::at(over.median, row as f64)
                .between(over.low_quartile, over.high_quartile)
                .labelled(format!("{} ×", rounded(over.median, 3)))
        });
        let names = rows.iter().map(|(contest, _)| contest.name.as_str());
        let caption = "Time a step over native's in the same round: a dot a round, and the median with half of the rounds";
        let x = Axis::logarithmic("times native");
        let y = Axis::of_names("", names);
        let plot = Plot::new("ratios", caption, x, y);
        let plot = plot.points("a round", Colour::Sky, rounds);
        let plot = plot.points("median", Colour::Blue, medians);
        (!rows.is_empty()).then_some(plot)
    }

    fn stages(&self) -> Section {
        let table = Table::of("stages", "", &self.stages)
            .column("part of a native step", |share| &share.stage)
            .column("share", |share| share.share);
        let mut answer = format!(
            "{} pairs are listed, {} of them touch; a list lasts {:.0} steps.",
            self.bed.listed_pairs, self.bed.touching_pairs, self.bed.steps_per_build
        );
        for contest in self
            .contests
            .iter()
            .filter(|contest| !contest.shares.is_empty())
        {
            let part = |share: &Share| format!("{} {:.0} %", share.stage, 100.0 * share.share);
            let parts: Vec<String> = contest.shares.iter().map(part).collect();
            answer += &format!(
                " {} by its own account: {}.",
                contest.name,
                parts.join(", ")
            );
        }
        Section::new("Where the time of a step goes", answer).with(table)
    }

    fn sizes(&self) -> Section {
        let mut names: Vec<&str> = Vec::new();
        for point in &self.scaling {
            if !names.contains(&point.name.as_str()) {
                names.push(&point.name);
            }
        }
        let colours = [Colour::Blue, Colour::Grey, Colour::Vermilion];
        let draw = |name: &str, caption: &str, y: &str, value: fn(&Size) -> Option<f64>| {
            let (x, y) = (Axis::logarithmic("grains"), Axis::logarithmic(y));
            let plot = Plot::new(name, caption, x, y);
            let series = names.iter().zip(colours);
            series.fold(plot, |plot, (name, colour)| {
                let points = self.scaling.iter().filter(|point| point.name == *name);
                let points =
                    points.filter_map(|point| Some([f64::from(point.grains), value(point)?]));
                plot.line(name, colour, points)
            })
        };
        let time = draw(
            "time-and-size",
            "Cost of a grain in a step. Flat is what a method that only looks at neighbours can do; what rises is memory: the bed no \
             longer fits into the caches.",
            "time a step and grain, ns",
            |point| Some(1e9 * point.seconds_per_grain),
        );
        let memory = draw(
            "memory-and-size",
            "Largest resident memory of the whole process, reading the bed included.",
            "peak memory, MB",
            |point| Some(point.peak_memory? as f64 / 1e6),
        );
        let growth = |size: &Size| {
            let paper = |few: &&Size| few.name == size.name && few.grains == PAPER;
            let few = self.scaling.iter().find(paper)?;
            let grains = f64::from(size.grains) / f64::from(few.grains);
            let times = Spread::ratio(&size.seconds_per_step, &few.seconds_per_step)?;
            Spread::of(times.all.iter().map(|times| times / grains).collect())
        };
        let table = Table::of("sizes", "", &self.scaling)
            .column("engine", |point| &point.name)
            .column("grains", |point| point.grains)
            .column("time a step and grain, ns", |size| {
                1e9 * size.seconds_per_grain
            })
            .column("times that at 5,000", |size| Some(growth(size)?.median))
            .column("95 % interval", |size| growth(size)?.median_interval())
            .column("memory, MB", |size| Some(size.peak_memory? as f64 / 1e6))
            .column("memory a grain, B", |size| {
                Some(size.peak_memory? as f64 / f64::from(size.grains))
            });
        let micro = |spread: fn(&SpeedUp) -> &Spread| move |row: &SpeedUp| 1e6 * spread(row).median;
        let on_two = Table::of("two", "", &self.speed_ups)
            .column("one bed on two", |row| &row.name)
            .column("grains", |row| row.grains)
            .column("time a step on one, µs", micro(|row| &row.one))
            .column("on two, µs", micro(|row| &row.two))
            .column("times as fast, median", |row| row.times.median)
            .column("95 % interval", |row| row.times.median_interval())
            .column("least", |row| row.times.least)
            .column("most", |row| row.times.most)
            .column("times native on two", |row| {
                Some(row.over_native.as_ref()?.median)
            });
        let answer = "Beds up to 5,000 grains are poured and settled, as deep as the paper's and as wide as they need. Larger ones are \
                      copies of the settled bed side by side, every second one mirrored, and some steps of rest. Grains are numbered \
                      row by row across the whole width, as a poured cloud is; shuffled ones without any order, the worst case.";
        Section::new("Cost and memory against size", answer)
            .with(time)
            .with(memory)
            .with(table)
            .with(on_two)
            .with(
                "Times on two are on the clock, taken in turns; another program on the second processor spoils them. A bed of 5,000 \
                 grains stays on one thread.",
            )
    }

    fn machine(&self) -> Section {
        let machine = &self.machine;
        let load = machine.load.map(|load| format!(" Load {load} before."));
        let machine = format!(
            "{}, {} processors, {}; caches {} KiB; memory {:.0} GB; {}.{}",
            machine.processor,
            machine.processors,
            machine.vector_unit,
            machine
                .caches
                .map(|bytes| (bytes / 1024).to_string())
                .join(", "),
            machine.memory as f64 / 1e9,
            machine.system,
            load.unwrap_or_default()
        );
        let engine = |contest: &Contest| format!("{}: {}", contest.name, contest.version);
        let engines: Vec<String> = self.contests.iter().map(engine).collect();
        Section::new("Machine and commands", machine).with(format!(
            "crossgrain {}: `{}`, {} rounds, {:.0} s. {}. Bed: scene `{}`, state `{}`.",
            self.crossgrain,
            self.command,
            self.rounds,
            self.seconds,
            engines.join("; "),
            &self.bed.scene_digest[..16],
            self.bed.state
        ))
    }
}

/// The three ways in which an engine's bed must still be the bed.
fn of_bed(contest: &Contest) -> impl Iterator<Item = Check> {
    let ways = [
        (
            "displacement",
            "largest displacement over the mean radius",
            "1",
        ),
        ("contacts", "contacts between grains", "1"),
        ("kinetic-energy", "kinetic energy", "J"),
    ];
    let ways = ways.into_iter().zip(contest.state_check.limits());
    ways.map(|((part, quantity, unit), (value, limits))| {
        let [expected, lower, upper] = limits;
        let id = format!("bench/bed/{}/{part}", contest.contender.id());
        let what = format!("{quantity} of the bed of {}", contest.name);
        let outcome = Outcome::pass_if(lower <= value && value <= upper);
        Check {
            unit: unit.to_owned(),
            lower: Some(lower),
            upper: Some(upper),
            ..Check::of_words(id, &what, outcome, "")
                .with_limits(value, expected, None)
                .judged_by(
                    "against native's bed after the same steps",
                    "how far rounding or the other law may take it (docs/benchmark.md)",
                )
        }
    })
}
