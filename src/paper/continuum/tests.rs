use std::f64::consts::PI;

use super::*;

fn close(found: f64, wanted: f64, within: f64) {
    assert!(
        (found - wanted).abs() <= within,
        "{found} instead of {wanted}"
    );
}

fn load(spread: Spread) -> Load {
    Load {
        spread,
        pressure: 44.4e3,
        half_width: 0.0225,
    }
}

const SPREADS: [Spread; 2] = [Spread::Uniform, Spread::RigidPunch];
const PLACES: [[f64; 2]; 5] = [
    [0.0, 0.11],
    [0.08, 0.11],
    [0.15, 0.11],
    [0.3, 0.3],
    [0.01, 0.45],
];

fn largest_difference(a: Components, b: Components) -> f64 {
    let parts = [a.zz - b.zz, a.xx - b.xx, a.xz - b.xz];
    parts.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// Textbook form of the strip load: (p/π)(α + sinα cos(α+2β)) and so on, α the angle in which the load is seen and β from the
/// vertical to its nearer edge (Newcastle, Fundamentals of Foundation Engineering, eqs. 3.10 to 3.12).
#[test]
fn the_strip_load_is_the_textbooks() {
    let field = Field::new(Model::HalfSpace, load(Spread::Uniform));
    for [x, z] in PLACES {
        let angle = |edge: f64| ((x - edge) / z).atan();
        let (far, near) = (angle(-0.0225), angle(0.0225));
        let alpha = far - near;
        let (sum, scale) = (alpha + 2.0 * near, 44.4e3 / PI);
        let stress = field.stress(x, z);
        close(stress.zz, scale * (alpha + alpha.sin() * sum.cos()), 1e-8);
        close(stress.xx, scale * (alpha - alpha.sin() * sum.cos()), 1e-8);
        close(stress.xz, scale * alpha.sin() * sum.sin(), 1e-8);
        close(stress.zz, strip_load(44.4e3, 0.0225, x, z), 1e-4);
    }
}

/// p = P/(π√(a²−x²)) of a punch on a half-space, summed as line loads at x = a cos θ.
#[test]
fn the_punch_on_the_half_space_is_sadowskys() {
    let field = Field::new(Model::HalfSpace, load(Spread::RigidPunch));
    close(field.pressure(0.0), 2.0 / PI * 44.4e3, 1e-6);
    for [x, z] in PLACES {
        let of = |part: fn(f64, f64) -> f64| {
            integrate(0.0, PI, 20, |angle| {
                let x = x - 0.0225 * angle.cos();
                2.0 * 1998.0 / (PI * PI) * part(x, z) / (x * x + z * z).powi(2)
            })
        };
        let stress = field.stress(x, z);
        close(stress.zz, of(|_, z| z.powi(3)), 1e-8);
        close(stress.xx, of(|x, z| x * x * z), 1e-8);
        close(stress.xz, of(|x, z| x * z * z), 1e-8);
    }
}

/// A line load on a layer with a smooth base, after Timoshenko and Goodier, Theory of Elasticity, article 24: the base bears
/// 0.918 P/H under the load, 44 % more than the half-space there, and nothing at about 1.35 H beside it. Theirs are
/// sums by hand; the integral is 0.9195.
#[test]
fn the_pressure_on_a_smooth_base_is_the_textbooks() {
    let narrow = Load {
        spread: Spread::Uniform,
        pressure: 1e6,
        half_width: 0.5e-6,
    };
    let layer = Field::new(Model::Layer { depth: 1.0 }, narrow);
    close(layer.stress(0.0, 1.0).zz, 0.918, 2e-3);
    let open = Field::new(Model::HalfSpace, narrow);
    close(
        layer.stress(0.0, 1.0).zz / open.stress(0.0, 1.0).zz,
        1.44,
        5e-3,
    );
    assert!(layer.stress(1.33, 1.0).zz > 0.0 && layer.stress(1.36, 1.0).zz < 0.0);
}

#[test]
fn a_deep_layer_is_the_half_space_and_a_wide_box_the_layer() {
    for spread in SPREADS {
        for [x, z] in PLACES {
            let at = |model| stress(model, load(spread), x, z);
            let error =
                |depth: f64| largest_difference(at(Model::Layer { depth }), at(Model::HalfSpace));
            // What the base adds to σ_xx falls as force/depth, to the others faster.
            assert!(error(1e4) < 0.6 * load(spread).force() / 1e4);
            assert!((error(1e3) / error(2e3) - 2.0).abs() < 0.01);
            let zz = at(Model::Layer { depth: 1e3 }).zz - at(Model::HalfSpace).zz;
            close(zz, 0.0, 1e-3);
            let width = 20.0;
            let wide = at(Model::Box { width, depth: 0.46 });
            let layer = at(Model::Layer { depth: 0.46 });
            assert!(largest_difference(wide, layer) < 1e-6);
        }
    }
}

/// Every horizontal cut carries the load. In the box the walls are smooth, so this holds from wall to wall.
#[test]
fn every_cut_carries_the_load() {
    for spread in SPREADS {
        for z in [0.05, 0.2, 0.46] {
            let carried = |model, reach: f64| {
                let field = Field::new(model, load(spread));
                let zz = |x: f64| field.stress(x, z).zz;
                let far = (8.0 * (reach - 0.25)).ceil() as u32;
                2.0 * (integrate(0.0, 0.25, 10, zz) + integrate(0.25, reach, far, zz))
            };
            let force = load(spread).force();
            let bounded = Model::Box {
                width: 1.0,
                depth: 0.46,
            };
            close(carried(bounded, 0.5), force, 1e-5 * force);
            let layer = Model::Layer { depth: 0.46 };
            close(carried(layer, 4.0), force, 1e-5 * force);
        }
    }
}

#[test]
fn smooth_planes_bear_no_shear_and_both_sides_are_alike() {
    let depth = 0.46;
    let bounded = Model::Box { width: 1.0, depth };
    for model in [Model::HalfSpace, Model::Layer { depth }, bounded] {
        for spread in SPREADS {
            let field = Field::new(model, load(spread));
            for [x, z] in PLACES {
                let (right, left) = (field.stress(x, z), field.stress(-x, z));
                close(right.zz, left.zz, 1e-7);
                close(right.xx, left.xx, 1e-7);
                close(right.xz, -left.xz, 1e-7);
                if model != Model::HalfSpace {
                    close(field.stress(x, depth).xz, 0.0, 1e-7);
                }
                // The surface beside the load is free.
                let surface = field.stress(0.05 + x, 1e-9);
                close(surface.zz, 0.0, 1e-2);
                close(surface.xz, 0.0, 1e-2);
            }
            if model == bounded {
                close(field.stress(0.5, 0.11).xz, 0.0, 1e-7);
            }
        }
    }
}

/// ∂σ_xx/∂x + ∂σ_xz/∂z = 0 and ∂σ_xz/∂x + ∂σ_zz/∂z = 0, and σ_xx + σ_zz is harmonic: equilibrium and compatibility.
#[test]
fn the_stresses_are_an_elastic_field() {
    let depth = 0.46;
    for model in [
        Model::HalfSpace,
        Model::Layer { depth },
        Model::Box { width: 1.0, depth },
    ] {
        for spread in SPREADS {
            let field = Field::new(model, load(spread));
            let h = 1e-3;
            for [x, z] in [[0.02, 0.11], [0.15, 0.2], [0.3, 0.4]] {
                let at = |i: f64, k: f64| field.stress(x + i * h, z + k * h);
                let [east, west, down, up] =
                    [at(1.0, 0.0), at(-1.0, 0.0), at(0.0, 1.0), at(0.0, -1.0)];
                let scale = 2.0 * h * 44.4e3;
                close((east.xx - west.xx + down.xz - up.xz) / scale, 0.0, 2e-3);
                close((east.xz - west.xz + down.zz - up.zz) / scale, 0.0, 2e-3);
                let sum = |of: Components| of.xx + of.zz;
                let laplace = sum(east) + sum(west) + sum(down) + sum(up) - 4.0 * sum(at(0.0, 0.0));
                close(laplace / (h * h * 44.4e3), 0.0, 5e-3);
            }
        }
    }
}

/// The box by another route: the cosine series of its load, with hyperbolic functions as they stand.
#[test]
fn the_images_are_the_cosine_series() {
    let (width, depth) = (1.0, 0.46);
    let field = Field::new(Model::Box { width, depth }, load(Spread::Uniform));
    for [x, z] in PLACES {
        let mut zz = load(Spread::Uniform).force() / width;
        for m in 1..200 {
            let k = 2.0 * PI * f64::from(m) / width;
            let (h, y) = (k * depth, k * (depth - z));
            let amplitude = 2.0 / width * 2.0 * 44.4e3 * (k * 0.0225).sin() / k;
            let shape = (h.sinh() + h * h.cosh()) * y.cosh() - y * h.sinh() * y.sinh();
            zz += amplitude * shape / (h.sinh() * h.cosh() + h) * (k * x).cos();
            if h > 300.0 {
                break;
            }
        }
        close(field.stress(x, z).zz, zz, 1e-6);
    }
}

/// The surface under the punch is flat: its sinking by another route, from the pressure's transform and the layer's
/// answer L(k)/k, against a half-space that is far deeper.
#[test]
fn a_punch_leaves_the_surface_flat() {
    let wide = Load {
        spread: Spread::RigidPunch,
        pressure: 1.0,
        half_width: 1.0,
    };
    let depth = 1.0;
    for model in [Model::Layer { depth }, Model::Box { width: 3.0, depth }] {
        let field = Field::new(model, wide);
        let answer = Answer::of(model).expect("not the half-space");
        // ∫p(s)(−ln|x−s| + K(x−s))ds with s = cos θ, the logarithm's singular point cut out on both sides alike.
        let sinking = |x: f64| {
            let density = |angle: f64| {
                let s = f64::cos(angle);
                field.pressure(s) * angle.sin() * (answer.difference(x - s) - (x - s).abs().ln())
            };
            let pole = x.acos();
            let (mut sum, mut from, mut to) = (0.0, pole, PI - pole);
            while from.max(to) > 1e-9 {
                sum += integrate(pole - from, pole - 0.5 * from, 1, |angle| {
                    density(angle.max(1e-4))
                });
                sum += integrate(pole + 0.5 * to, pole + to, 1, |angle| {
                    density(angle.min(PI - 1e-4))
                });
                (from, to) = (0.5 * from, 0.5 * to);
            }
            sum
        };
        let middle = sinking(0.0);
        for x in [0.2, 0.55, 0.83, 0.97] {
            close(sinking(x) / middle, 1.0, 1e-5);
        }
        let force = integrate(0.0, PI, 10, |angle| {
            let inner = angle.clamp(1e-4, PI - 1e-4);
            field.pressure(inner.cos()) * inner.sin()
        });
        close(force, 2.0, 1e-6);
    }
}

/// On a thin layer each place bears by its own sinking, so the pressure is even but for the rims (Johnson,
/// Contact Mechanics, 5.8); under it the half-space has 2/π of the mean in the middle.
#[test]
fn the_thinner_the_layer_the_more_even_the_pressure() {
    let wide = Load {
        spread: Spread::RigidPunch,
        pressure: 1.0,
        half_width: 1.0,
    };
    let middle = |depth: f64| Field::new(Model::Layer { depth }, wide).pressure(0.0);
    close(middle(1e3), 2.0 / PI, 1e-4);
    close(middle(0.25), 1.0, 0.1);
    assert!(middle(2.0) > 2.0 / PI && middle(2.0) < middle(1.0) && middle(1.0) < middle(0.5));
}

#[test]
fn a_load_at_the_surface_is_flamants() {
    let load = Load {
        spread: Spread::Uniform,
        pressure: 3.0,
        half_width: 0.2,
    };
    for (x, z) in [(0.0, 0.1), (0.5, 0.3), (1.5, 2.0)] {
        for poisson in [0.1, 0.5] {
            let flamant = strip_load(3.0, 0.2, x, z);
            close(within(load, 0.0, poisson, x, z), flamant, 1e-7);
        }
    }
}

/// Every horizontal cut below the load carries all of it, and one above carries nothing; the surface is free.
#[test]
fn equilibrium_above_and_below() {
    for poisson in [0.1, 0.3, 0.5] {
        let carried = |z: f64| {
            // x = tan u: the tails fall as 1/x⁴ and 1/x².
            integrate(-0.5 * PI, 0.5 * PI, 2_000, |u| {
                let x = u.tan();
                melan(1.0, poisson, x, z) / u.cos().powi(2)
            })
        };
        close(carried(1.5), 1.0, 1e-4);
        close(carried(3.0), 1.0, 1e-4);
        close(carried(0.5), 0.0, 1e-4);
        for x in [0.0, 0.3, 2.0] {
            close(melan(1.0, poisson, x, 0.0), 0.0, 1e-14);
        }
    }
}

/// Deep inside, half of the force hangs above: Kelvin's line load, whose σ_zz on the axis is (3−2ν)/(4π(1−ν)r).
#[test]
fn deep_inside_it_is_kelvins() {
    for poisson in [0.0f64, 0.3, 0.5] {
        let nu = poisson.max(1e-9);
        let kelvin = (3.0 - 2.0 * nu) / (4.0 * PI * (1.0 - nu));
        close(melan(1e5, nu, 0.0, 1e5 + 1.0), kelvin, 1e-4);
        close(melan(1e5, nu, 0.0, 1e5 - 1.0), -kelvin, 1e-4);
    }
}
