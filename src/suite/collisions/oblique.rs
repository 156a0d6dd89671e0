//! Oblique impacts on a wall that slide all through: MFiX-DEM's fifth verification case and the forms of
//! Chung and Ooi's tests 4 to 6.

use super::continuum::nominal_ratio;
use super::experiment::{Experiment, rung};
use super::slide::{Arms, Slide};
use crate::suite::build::Grain;
use crate::suite::line;
use crate::suite::{Line, Rung, Track};
use grains::case::Case;

/// The rungs.
pub fn rungs() -> Vec<Rung> {
    vec![
        rung(
            "oblique-impact",
            "MFiX DEM05: oblique impacts that slide all through, ball and disc",
            mfix(),
        ),
        rung(
            "chung-ooi-4-oblique",
            "Chung and Ooi 4: oblique impacts with a dashpot, for the angles that slide all through",
            chung_ooi_4(),
        ),
        rung(
            "gross-sliding",
            "Chung and Ooi 5 and 6 for a linear spring: sliding with spin along and against the way",
            gross_sliding(),
        ),
        rung(
            "spin-impact",
            "A spinning ball or disc that falls on a wall is thrown aside",
            spin_impact(),
        ),
    ]
}

/// What makes a grain of a centre, a radius and a density.
type Shape = fn([f64; 2], f64, f64) -> Grain;

const SHAPES: [(&str, Shape); 2] = [("ball", Grain::sphere), ("disc", Grain::disc)];

/// Velocity along the wall and spin after sliding all through.
struct Sliding(Slide);

impl Experiment for Sliding {
    fn cases(&self) -> Vec<Case> {
        vec![self.0.case(vec![self.0.end()])]
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let of = &self.0;
        let ([velocity, spin], [of_velocity, of_spin]) = (of.seen(tracks), of.expected());
        let [off, off_turning] = of.tolerances();
        vec![
            line(
                format!("velocity along the wall, {}", of.name),
                "m/s",
                velocity,
                of_velocity,
                off,
                "of the change: (ω dt)⁴, as touch and parting fall between two steps, ½|ln e| c dt/m with a \
                 dashpot, and rounding",
            ),
            line(
                format!("spin, {}", of.name),
                "rad/s",
                spin,
                of_spin,
                off_turning,
                "as the velocity; and (ω dt)² + c dt/m of what the overlap takes from the arm",
            ),
        ]
    }
}

/// DEM05 of MFiX's verification manual, with the values printed there: balls of 5 mm at 3.9 m/s, μ = 0.092,
/// e = 1. Angles are from the normal.
struct Published {
    slide: Slide,
    /// Tangential restitution as printed.
    restitution: f64,
    /// Spin as printed, rad/s.
    spin: Option<f64>,
}

/// Steps in a contact time of the published runs: what MFiX takes where it is not told.
const PUBLISHED_STEPS: f64 = 50.0;

fn mfix() -> Vec<Box<dyn Experiment>> {
    let printed = [
        (30.0, 0.6813, None),
        (45.0, 0.8160, Some(505.75)),
        (60.0, 0.8938, Some(357.95)),
    ];
    let mut experiments: Vec<Box<dyn Experiment>> = Vec::new();
    for (angle, restitution, spin) in printed {
        for (what, shape) in SHAPES {
            let grain = shape([0.0; 2], 2.5e-3, 4000.0);
            let ball = Grain::sphere([0.0; 2], 2.5e-3, 4000.0);
            let slide = Slide {
                name: format!("{what}, {angle} degrees"),
                grain: grain.moving(at_angle(3.9, angle)),
                // A disc one metre long weighs more: as stiff for its mass.
                stiffness: 1.72e7 * grain.mass / ball.mass,
                ratio: 1.48 / 1.72,
                tan_phi: 0.092,
                damping_ratio: 0.0,
                arms: Arms::ContactPoint,
                steps: 1000.0,
            };
            if what == "ball" {
                let slide = slide.clone();
                experiments.push(Box::new(Published {
                    slide,
                    restitution,
                    spin,
                }));
            } else {
                experiments.push(Box::new(Sliding(slide)));
            }
        }
    }
    experiments
}

/// So fast towards the wall at this angle from its normal, in degrees.
fn at_angle(speed: f64, degrees: f64) -> [f64; 2] {
    let angle = degrees.to_radians();
    [speed * angle.sin(), -speed * angle.cos()]
}

impl Experiment for Published {
    fn cases(&self) -> Vec<Case> {
        Sliding(self.slide.clone()).cases()
    }

    fn lines(&self, tracks: &[Track]) -> Vec<Line> {
        let of = &self.slide;
        let [velocity, spin] = of.seen(tracks);
        let mut lines = Sliding(of.clone()).lines(tracks);
        lines.push(line(
            format!("tangential restitution as published, {}", of.name),
            "1",
            velocity / of.grain.velocity[0],
            self.restitution,
            0.5e-4,
            "rounding of the printed value; gross sliding does not feel the published run's steps",
        ));
        if let Some(published) = self.spin {
            // What the overlap takes from the arm is all in the spin that feels the steps.
            let shortened = of.tan_phi * of.impact().overlap_impulse() / of.grain.inertia;
            lines.push(line(
                format!("spin as published, {}", of.name),
                "rad/s",
                spin,
                published,
                0.5e-2 + 2.0 * shortened / PUBLISHED_STEPS,
                "rounding of the printed value; steps of 1/50 of the contact time in the published run, one at \
                 touch and one at parting, in what the overlap takes from the arm",
            ));
        }
        lines
    }
}

/// Chung and Ooi, Granular Matter 13 (2011) 643: aluminium oxide, radius 2.5 mm, 3.9 m/s, e = 0.98 (nominal),
/// μ = 0.092. Below 33° from the normal the contact sticks for a while and has no such closed form.
fn chung_ooi_4() -> Vec<Box<dyn Experiment>> {
    let mut experiments: Vec<Box<dyn Experiment>> = Vec::new();
    for (what, shape) in SHAPES {
        for angle in [35.0, 45.0, 60.0, 75.0, 85.0] {
            let grain = shape([0.0; 2], 2.5e-3, 4000.0).moving(at_angle(3.9, angle));
            experiments.push(Box::new(Sliding(Slide {
                name: format!("{what}, {angle} degrees"),
                grain,
                stiffness: 3.8e11 * 2.5e-3,
                // Mindlin's 2(1−ν)/(2−ν) for ν = 0.23.
                ratio: 1.54 / 1.77,
                tan_phi: 0.092,
                damping_ratio: nominal_ratio(0.98),
                arms: Arms::ContactPoint,
                steps: 1000.0,
            })));
        }
    }
    experiments
}

/// Aluminium alloy of Chung and Ooi's materials, with arms of both laws; speeds are our own.
fn aluminium(name: String, grain: Grain, arms: Arms) -> Slide {
    Slide {
        name,
        stiffness: 7.0e10 * grain.radius,
        grain,
        ratio: 0.8,
        tan_phi: 0.3,
        damping_ratio: 0.0,
        arms,
        steps: 1000.0,
    }
}

/// Velocity and spin; each as long as it lasts slides faster than friction can stop.
fn spinning(motions: &[(&str, f64, f64)]) -> Vec<Box<dyn Experiment>> {
    let mut experiments: Vec<Box<dyn Experiment>> = Vec::new();
    for (what, shape) in SHAPES {
        for arms in [Arms::HalfOverlap, Arms::ContactPoint] {
            for (how, velocity, spin) in motions {
                let grain = shape([0.0; 2], 0.01, 2699.0)
                    .moving([*velocity, -0.5])
                    .spinning(*spin);
                let law = match arms {
                    Arms::HalfOverlap => "half overlap",
                    Arms::ContactPoint => "contact point",
                };
                let name = format!("{what}, {how}, {law}");
                experiments.push(Box::new(Sliding(aluminium(name, grain, arms))));
            }
        }
    }
    experiments
}

fn gross_sliding() -> Vec<Box<dyn Experiment>> {
    spinning(&[
        ("no spin", 2.0, 0.0),
        ("spin against", 2.0, -150.0),
        ("spin along", 2.0, 80.0),
        ("overtaken by its spin", 0.5, 250.0),
    ])
}

fn spin_impact() -> Vec<Box<dyn Experiment>> {
    spinning(&[
        ("spin to the right", 0.0, 200.0),
        ("spin to the left", 0.0, -200.0),
    ])
}
