//! What is no sum of terms and still follows from what is written: where contacts end, where they begin to slide, and which sign local
//! damping goes by.

/// What was seen in some runs.
#[derive(Default)]
pub(super) struct Seen {
    pub(super) held: Vec<Held>,
    /// The spring's force over Coulomb's limit, of contacts beyond it that did not slide before, and whether it is cut.
    pub(super) slid: Vec<(f64, bool)>,
    /// Of contacts that stick well below Coulomb's limit: which kind, the force over that limit and whether it is off.
    pub(super) stuck: Vec<(usize, f64, bool)>,
    pub(super) damped: Vec<Damped>,
}

/// A contact that adhesion holds or held a step before.
#[derive(Clone, Copy)]
pub(super) struct Held {
    /// How far it is on the way to where it is to end.
    pub(super) share: f64,
    pub(super) is_there: bool,
    /// A wall has that of its grain, m.
    pub(super) radii: [f64; 2],
}

/// One component of a grain's force that local damping has made larger or smaller.
#[derive(Clone, Copy)]
pub(super) struct Damped {
    pub(super) axis: usize,
    /// By which sign, 0 if by none, as the engine has moved the grain; none if it is damped by another share.
    pub(super) sign: Option<f64>,
    /// The power of these forces and velocities, in the order of [`FORCES`] and [`VELOCITIES`].
    pub(super) by: [[f64; VELOCITIES.len()]; FORCES.len()],
}

/// Of which the power may have the sign by which damping goes; the model's come first.
pub(super) const FORCES: [&str; 5] = [
    "all forces",
    "contact forces",
    "the weight",
    "all forces of the step before",
    "contact forces of the step before",
];
pub(super) const VELOCITIES: [&str; 11] = [
    "the velocity in the middle of the step",
    "the velocity before it",
    "the velocity after it",
    "the velocity along x in the middle of the step",
    "the velocity along y in the middle of the step",
    "the velocity along z in the middle of the step",
    "the velocity along x before it",
    "the velocity along y before it",
    "the velocity along z before it",
    "the velocity of the grain with the id before it",
    "the velocity of the grain with the id after it",
];

/// Of two grains with these.
type Radius = fn(f64, f64) -> f64;

/// So near to its end a contact may have ended or not.
const END: f64 = 1.0e-6;
/// The last one that is there is so near to where it ends.
const NEAR: f64 = 0.99;
/// Forces that are cut to one limit are so near to each other.
const CUT_TO: f64 = 1.0e-6;
/// Fewer may be so by chance.
const FEWEST: usize = 5;

impl Seen {
    pub(super) fn add(&mut self, other: Seen) {
        self.held.extend(other.held);
        self.slid.extend(other.slid);
        self.stuck.extend(other.stuck);
        self.damped.extend(other.damped);
    }

    /// Where contacts end that adhesion holds, by how far they are on the way to where it lets go and whether they are there: that of the
    /// first that is gone and of the last that is there.
    pub(super) fn ends_elsewhere(&self) -> Option<String> {
        let ends = |share: &dyn Fn(&Held) -> f64| {
            let shares = |there: bool| {
                let held = self.held.iter().filter(move |one| one.is_there == there);
                held.map(share)
            };
            let gone = shares(false).fold(f64::INFINITY, f64::min);
            (gone, shares(true).fold(0.0, f64::max))
        };
        let is_right = |(gone, last): (f64, f64)| gone >= 1.0 - END && last <= 1.0 + END;
        let (gone, last) = ends(&|one| one.share);
        if is_right((gone, last)) {
            return None;
        }
        let apart = self.held.iter().filter(|one| one.share > END);
        if apart.clone().count() >= FEWEST && apart.clone().all(|one| !one.is_there) {
            return Some(
                "contacts that adhesion holds: none is there whose bodies no longer overlap"
                    .to_owned(),
            );
        }
        // An overlap of Johnson, Kendall and Roberts goes by the cube root of the radius.
        let radii: [(&str, Radius); 6] = [
            ("R₁", |one, _| one),
            ("R₂", |_, two| two),
            ("R₁ + R₂", |one, two| one + two),
            ("(R₁ + R₂)/2", |one, two| 0.5 * (one + two)),
            ("min(R₁, R₂)", f64::min),
            ("max(R₁, R₂)", f64::max),
        ];
        let ends_with = |radius: Radius| {
            ends(&|one| {
                let [first, second] = one.radii;
                let usual = first * second / (first + second);
                one.share / (radius(first, second) / usual).cbrt()
            })
        };
        let all = radii.map(|(name, radius)| (name, ends_with(radius)));
        let fitting = all.into_iter().filter(|(_, ends)| is_right(*ends));
        // A larger one is no worse as long as none is gone; it is one that some come near to.
        let fitting = fitting.filter(|(_, (_, last))| *last >= NEAR);
        let fitting: Vec<&str> = fitting.map(|(name, _)| name).collect();
        let by_radius = match fitting.is_empty() {
            true => String::new(),
            false => format!(
                ", as with {} in the place of R₁R₂/(R₁ + R₂) in that overlap",
                fitting.join(" or ")
            ),
        };
        (last <= gone * (1.0 + END) || !fitting.is_empty()).then(|| {
            let none = match gone.is_finite() {
                true => format!(", and some are gone from {gone:.3} of it on"),
                false => String::new(),
            };
            format!("contacts that adhesion holds: some are there until {last:.3} of the overlap at which they are to end{none}{by_radius}")
        })
    }

    /// Up to where beyond Coulomb's limit contacts do not begin to slide, if all do from there on.
    pub(super) fn slides_later(&self) -> Option<String> {
        let shares = |cut: bool| self.slid.iter().filter(move |one| one.1 == cut);
        let last = shares(false).map(|one| one.0).fold(0.0, f64::max);
        let first = shares(true).map(|one| one.0).fold(f64::INFINITY, f64::min);
        let enough = [true, false].map(|cut| shares(cut).count() >= FEWEST);
        (enough == [true; 2] && last <= first).then(|| {
            format!(
                "tangential forces of contacts that begin to slide: none is cut up to {last:.3} of Coulomb's limit, and all are from {first:.3} of it on, to the limit"
            )
        })
    }

    /// At which share of Coulomb's limit all contacts of a kind are cut that should stick, where none has a larger one.
    pub(super) fn slides_early(&self, kind: usize) -> Option<f64> {
        let shares = |is_off: bool| {
            let of_kind = self
                .stuck
                .iter()
                .filter(move |one| one.0 == kind && one.2 == is_off);
            of_kind.map(|one| one.1)
        };
        let most = shares(true).fold(0.0, f64::max);
        let is_at = |share: f64| share >= most * (1.0 - CUT_TO);
        let right = shares(false).fold(0.0, f64::max);
        let is_so = shares(true).count() >= FEWEST
            && shares(true).all(is_at)
            && right <= most * (1.0 + CUT_TO);
        (is_so && most > 0.0).then_some(most)
    }

    /// By the sign of which power all components along some axes are damped, where the model's is not it.
    pub(super) fn damps_otherwise(&self) -> Option<String> {
        let goes_by = |damped: &Damped, force: usize, velocity: usize| {
            let sign = match damped.by[force][velocity] {
                0.0 => 0.0,
                power => power.signum(),
            };
            damped.sign == Some(sign)
        };
        let off_along = |axis: &usize| {
            let mut along = self.damped.iter().filter(|damped| damped.axis == *axis);
            along.any(|damped| !goes_by(damped, 0, 0))
        };
        let axes: Vec<usize> = (0..3).filter(off_along).collect();
        let along = self
            .damped
            .iter()
            .filter(|damped| axes.contains(&damped.axis));
        let along: Vec<&Damped> = along.collect();
        if along.iter().filter(|damped| !goes_by(damped, 0, 0)).count() < FEWEST {
            return None;
        }
        let mut powers =
            (0..FORCES.len()).flat_map(|force| (0..VELOCITIES.len()).map(move |at| (force, at)));
        let (force, velocity) = powers.find(|(force, velocity)| {
            along
                .iter()
                .all(|damped| goes_by(damped, *force, *velocity))
        })?;
        let others = self.damped.len() > along.len();
        let names = axes.iter().map(|axis| ["x", "y", "z"][*axis]);
        let place = match others {
            true => format!(" along {} alone", names.collect::<Vec<_>>().join(" and ")),
            false => String::new(),
        };
        Some(format!(
            "velocities{place}: local damping goes by the sign of ({})·({}) in the place of ({})·({})",
            FORCES[force], VELOCITIES[velocity], FORCES[0], VELOCITIES[0]
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(end: &dyn Fn(f64, f64) -> f64) -> Seen {
        let radii = (0..40).map(|at| {
            (
                1.0 + 0.1 * f64::from(at % 7),
                1.0 + 0.07 * f64::from(at % 5),
            )
        });
        let held = radii.flat_map(|(one, two)| {
            let end = end(one, two);
            (1..60)
                .map(move |at| f64::from(at) / 30.0)
                .map(move |share| Held {
                    share,
                    is_there: share <= end,
                    radii: [one, two],
                })
        });
        Seen {
            held: held.collect(),
            ..Seen::default()
        }
    }

    #[test]
    fn where_adhesion_lets_go_is_told_if_it_is_elsewhere() {
        assert_eq!(held(&|_, _| 1.0).ends_elsewhere(), None);
        for end in [0.5, 1.5] {
            let told = held(&|_, _| end).ends_elsewhere().unwrap_or_default();
            assert!(told.contains(&format!("until {end:.3} of")), "{told}");
            assert!(!told.contains("in the place"), "{told}");
        }
        // Where nothing was asked for beyond the last one that is there, it may be any larger one.
        let mut open = held(&|_, _| 1.4);
        open.held.retain(|one| one.is_there);
        let told = open.ends_elsewhere().unwrap_or_default();
        assert!(
            told.contains("until 1.400 of") && !told.contains("in the place"),
            "{told}"
        );
        let told = held(&|_, _| 0.0).ends_elsewhere().unwrap_or_default();
        assert!(
            told.contains("none is there whose bodies no longer overlap"),
            "{told}"
        );
        let by_second = |one: f64, two: f64| (two * (one + two) / (one * two)).cbrt();
        let told = held(&by_second).ends_elsewhere().unwrap_or_default();
        assert!(told.contains("as with R₂ in the place"), "{told}");
        // Some are gone and others there: it is not where they are.
        assert_eq!(
            held(&|one, _| 0.5 + 0.3 * (one * 10.0).sin()).ends_elsewhere(),
            None
        );
    }

    #[test]
    fn a_smaller_limit_is_told_of_its_kind_alone() {
        let with = |more: &[(usize, f64, bool)]| {
            let stuck = (0..8).map(|_| (2, 0.01, true)).chain(more.iter().copied());
            Seen {
                stuck: stuck.collect(),
                ..Seen::default()
            }
        };
        let seen = with(&[(2, 0.009, false), (1, 0.3, false)]);
        let early = [0, 1, 2].map(|kind| seen.slides_early(kind));
        assert_eq!(early, [None, None, Some(0.01)]);
        // One that is right is beyond it, or one that is off is below: it is no limit.
        assert_eq!(with(&[(2, 0.02, false)]).slides_early(2), None);
        assert_eq!(with(&[(2, 0.005, true)]).slides_early(2), None);
    }

    #[test]
    fn a_contact_that_slides_later_is_told() {
        let slid = |cut: &dyn Fn(f64) -> bool| {
            let shares = (1..40).map(|at| 1.05 + 0.01 * f64::from(at));
            Seen {
                slid: shares.map(|share| (share, cut(share))).collect(),
                ..Seen::default()
            }
        };
        assert_eq!(slid(&|_| true).slides_later(), None);
        assert_eq!(
            slid(&|share| ((share * 50.0) as u32).is_multiple_of(2)).slides_later(),
            None
        );
        let told = slid(&|share| share > 1.2)
            .slides_later()
            .unwrap_or_default();
        assert!(told.contains("up to 1.200 of Coulomb's limit"), "{told}");
    }

    #[test]
    fn a_sign_of_another_power_is_told() {
        let damped = |force: usize, velocity: usize, along_z_alone: bool| {
            let values = (1..31).map(|at| {
                let power = |which: usize| f64::from(at * (1 + which as u32)).sin();
                let number = |force: usize, velocity: usize| VELOCITIES.len() * force + velocity;
                let by = std::array::from_fn(|force| {
                    std::array::from_fn(|velocity| power(number(force, velocity)))
                });
                let axis = [0, 2][at as usize % 2];
                let is_otherwise = !along_z_alone || axis == 2;
                let which = if is_otherwise {
                    number(force, velocity)
                } else {
                    0
                };
                Damped {
                    axis,
                    sign: Some(power(which).signum()),
                    by,
                }
            });
            Seen {
                damped: values.collect(),
                ..Seen::default()
            }
        };
        assert_eq!(damped(0, 0, false).damps_otherwise(), None);
        let told = damped(1, 1, false).damps_otherwise().unwrap_or_default();
        assert!(
            told.contains("(contact forces)·(the velocity before it)"),
            "{told}"
        );
        let told = damped(0, 3, true).damps_otherwise().unwrap_or_default();
        let words = "velocities along z alone: local damping goes by the sign of (all forces)·(the velocity along x";
        assert!(told.contains(words), "{told}");
    }
}
