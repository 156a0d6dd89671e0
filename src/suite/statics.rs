//! Grains at rest, against statics: piles of frictionless discs, and the disc of the paper's Figure 4.

use crate::paper::disc_field::{BALANCE, DiscField, RimForce};
use crate::suite::{self, CaseGroup, Figures, Grain, Track, furthest};
use grains::measure::{Bed, stress};
use grains::tables::{BodyIds, Contact, Snapshot};
use grains::task::Case;

pub fn groups() -> Vec<CaseGroup> {
    vec![column(), pyramid(), disc(), field()]
}

/// m.
const RADIUS: f64 = 1.0;
/// kg/m³.
const DENSITY: f64 = 1000.0;
/// m/s².
const GRAVITY: f64 = 9.81;
/// ER over the weight of a disc.
const STIFF: f64 = 1.0e3;
/// Half the pitch of a row over R: more than 1, so that its discs do not touch.
const OPENED: f64 = 1.1;

/// Weight of a disc of this radius.
fn weight(radius: f64) -> f64 {
    Grain::disc([0.0; 2], radius, DENSITY).mass * GRAVITY
}

fn modulus() -> f64 {
    STIFF * weight(RADIUS) / RADIUS
}

/// How far one row of equal discs stands above the other.
fn rise() -> f64 {
    RADIUS * (4.0 - OPENED * OPENED).sqrt()
}

/// A pile between walls at these places on the floor z = 0.
///
/// The lattice is opened sideways, so that only diagonal neighbours touch. From the top down, each disc
/// then rests on two bodies, and its equilibrium gives their forces from those above, as in Oron and
/// Herrmann 1998 (Phys. Rev. E 58:2079–2089). Overlaps change the angles a little: the normals are those of
/// the pile.
struct Pile {
    grains: Vec<Grain>,
    walls: [f64; 2],
    /// Contacts whose forces statics does not give, taken as they are.
    given: Vec<(u32, u32)>,
    /// Each disc with the two bodies that bear it, those above first.
    rests: Vec<(u32, [u32; 2])>,
}

impl Pile {
    fn case(&self) -> Case {
        // Strong local damping, so that the pile comes to rest.
        const ALPHA: f64 = 0.7;
        const STEPS: u64 = 8000;
        let disc = Grain::disc([0.0; 2], RADIUS, DENSITY);
        let period = (disc.mass / (modulus() * RADIUS)).sqrt();
        let (law, gravity) = (suite::springs(modulus()), [0.0, -GRAVITY]);
        let model = suite::world(law, 0.3 * period, gravity, ALPHA, [&self.walls, &[0.0]]);
        suite::case("pile", model, &self.grains, vec![STEPS])
    }

    /// Rounding of a position, which is up to so high, makes that much of the smallest force, half a
    /// weight: eight roundings of half a unit in the last place.
    fn tolerance(&self) -> f64 {
        let top = self.grains.iter().map(|grain| grain.position[1]);
        let height = top.fold(0.0, f64::max);
        8.0 * 0.5 * f64::EPSILON * height * STIFF / RADIUS / 0.5
    }

    fn judge(&self, at: &Snapshot, figures: &mut Figures) {
        figures.because("two a disc, and those that are given");
        let expected = 2 * self.rests.len() + self.given.len();
        let found = at.contacts.len() as f64;
        figures.is("contacts, 1", found, expected as f64, 0.0);
        figures.because("eight roundings of a height, times k_n, over half a weight");
        let off = self.tolerance();
        let what =
            "statics: force over that of statics of the contact where it is furthest from 1, 1";
        figures.is(what, furthest(1.0, self.statics(at)), 1.0, off);
        let ratios = at.contacts.iter().map(|contact| self.spring(at, contact));
        let what = "springs: force over k_n u of the contact where it is furthest from 1, 1";
        figures.is(what, furthest(1.0, ratios), 1.0, off);
    }

    /// Every contact force that statics gives: as it is over as it should be.
    fn statics(&self, at: &Snapshot) -> Vec<f64> {
        let is_given = |contact: &&Contact| self.given.contains(&contact.ids());
        let given = at.contacts.iter().filter(is_given);
        let mut solved: Vec<(&Contact, f64)> = given
            .map(|contact| (contact, contact.normal_force))
            .collect();
        let given = solved.len();
        for &(disc, bearers) in &self.rests {
            let [Some(a), Some(b)] = bearers.map(|bearer| between(at, disc, bearer)) else {
                return vec![f64::NAN];
            };
            let mut load = [0.0, -weight(self.grains[disc as usize].radius)];
            for (contact, force) in &solved {
                let towards = direction(contact, disc);
                load[0] += force * towards[0];
                load[1] += force * towards[1];
            }
            let ([ax, az], [bx, bz]) = (direction(a, disc), direction(b, disc));
            let area = ax * bz - az * bx;
            solved.push((a, (load[1] * bx - load[0] * bz) / area));
            solved.push((b, (load[0] * az - load[1] * ax) / area));
        }
        let ratio = |(contact, force): &(&Contact, f64)| contact.normal_force / force;
        solved.iter().skip(given).map(ratio).collect()
    }

    /// The force of a contact over k_n u, both from positions and radii.
    fn spring(&self, at: &Snapshot, contact: &Contact) -> f64 {
        let place = |id: u32| [at.bodies.x[id as usize], at.bodies.z[id as usize]];
        let two = self.grains[contact.id2 as usize].radius;
        let (one, distance) = match self.grains.get(contact.id1 as usize) {
            Some(one) => {
                let (a, b) = (place(contact.id1), place(contact.id2));
                (one.radius, (a[0] - b[0]).hypot(a[1] - b[1]) - one.radius)
            }
            None => {
                let axis = usize::from(contact.normal[1] != 0.0);
                let walls = [self.walls[0], self.walls[1], 0.0];
                let wall = walls.get(contact.id1 as usize - self.grains.len());
                let wall = wall.copied().unwrap_or(f64::NAN);
                (two, (place(contact.id2)[axis] - wall).abs())
            }
        };
        let stiffness = 2.0 * modulus() * one * two / (one + two);
        contact.normal_force / (stiffness * (two - distance))
    }
}

fn between(at: &Snapshot, a: u32, b: u32) -> Option<&Contact> {
    let is = |contact: &&Contact| [(a, b), (b, a)].contains(&(contact.id1, contact.id2));
    at.contacts.iter().find(is)
}

/// Which way a contact pushes this disc; nowhere if it is not the disc's.
fn direction(contact: &Contact, disc: u32) -> [f64; 2] {
    let sign = f64::from(u8::from(contact.id2 == disc)) - f64::from(u8::from(contact.id1 == disc));
    contact.normal.map(|component| sign * component)
}

/// Rows of two discs at the walls and of one in the middle by turns, numbered from below. Half of the
/// weight above goes down on each side, so the upright part of every force is known to the last digit.
fn column() -> CaseGroup {
    const PAIRS: u32 = 5;
    let half_pitch = OPENED * RADIUS;
    let place = half_pitch + RADIUS;
    let mut grains = Vec::new();
    let mut rests = Vec::new();
    let count = 3 * PAIRS - 1;
    let ids = BodyIds::of_box(count);
    for row in 0..PAIRS {
        let low = RADIUS + 2.0 * f64::from(row) * rise();
        let first = 3 * row;
        let below = if row == 0 { ids.floor() } else { first - 1 };
        for (side, wall) in [(-1.0, ids.left()), (1.0, ids.right())] {
            rests.push((grains.len() as u32, [wall, below]));
            grains.push(Grain::disc([side * half_pitch, low], RADIUS, DENSITY));
        }
        if row + 1 < PAIRS {
            rests.push((first + 2, [first, first + 1]));
            grains.push(Grain::disc([0.0, low + rise()], RADIUS, DENSITY));
        }
    }
    rests.reverse();
    let pile = Pile {
        grains,
        walls: [-place, place],
        given: Vec::new(),
        rests,
    };
    let upright = move |contact: &Contact| {
        // The lowest of the discs above.
        let first = match contact.id2 % 3 {
            _ if contact.id1 == ids.floor() => 0,
            2 => contact.id2,
            side => contact.id2 - side,
        };
        let above = f64::from(count - first) * weight(RADIUS);
        contact.force()[1].abs() / (0.5 * above)
    };
    let title = "In a column between walls each side bears half of the weight above";
    CaseGroup::new("column-of-discs", title).with("", pile.case(), move |track, figures| {
        let Some(at) = track.first() else {
            return;
        };
        pile.judge(at, figures);
        let borne = at.contacts.iter();
        let borne = borne.filter(|contact| contact.normal[1] != 0.0);
        let what = "sides: upright part of a force over half the weight above where it is furthest from 1, 1";
        let found = furthest(1.0, borne.map(upright));
        figures.is(what, found, 1.0, pile.tolerance());
    })
}

/// A pyramid on a row of larger discs that are wedged between walls, so that nothing else touches sideways.
/// How hard they are wedged is no matter of statics: the left wall's force is given.
fn pyramid() -> CaseGroup {
    const BASE: u32 = 5;
    let base_radius = OPENED * RADIUS;
    // Five weights of thrust: more than the pyramid's, which would open the base at two.
    let squeeze = 5.0 * RADIUS / STIFF;
    let pitch = 2.0 * base_radius - squeeze;
    let first = base_radius - squeeze;
    let rise_from_base = RADIUS * ((1.0 + OPENED).powi(2) - OPENED * OPENED).sqrt();
    let mut grains = Vec::new();
    let mut rows = Vec::new();
    for row in 0..BASE {
        let above = base_radius + rise_from_base + (f64::from(row) - 1.0) * rise();
        let (radius, height) = match row {
            0 => (base_radius, base_radius),
            _ => (RADIUS, above),
        };
        rows.push(grains.len() as u32);
        for place in 0..BASE - row {
            let x = first + pitch * (f64::from(place) + 0.5 * f64::from(row));
            grains.push(Grain::disc([x, height], radius, DENSITY));
        }
    }
    let ids = BodyIds::of_box(grains.len() as u32);
    let mut rests = Vec::new();
    for row in (1..BASE).rev() {
        for place in 0..BASE - row {
            let below = rows[row as usize - 1] + place;
            rests.push((rows[row as usize] + place, [below, below + 1]));
        }
    }
    for place in 0..BASE {
        let last = place + 1 == BASE;
        let next = if last { ids.right() } else { place + 1 };
        rests.push((place, [ids.floor(), next]));
    }
    let pile = Pile {
        grains,
        walls: [0.0, first + f64::from(BASE - 1) * pitch + first],
        given: vec![(ids.left(), 0)],
        rests,
    };
    let title = "In a pyramid every contact bears what statics says";
    CaseGroup::new("pyramid-of-discs", title).with("", pile.case(), move |track, figures| {
        if let Some(at) = track.first() {
            pile.judge(at, figures);
        }
    })
}

/// A disc of radius 1 m between two pairs of walls, with these overlaps across and up.
fn squeezed(overlaps: [f64; 2], stiffness: f64, dt: f64, moments: Vec<u64>) -> Case {
    let [across, up] = overlaps.map(|overlap| RADIUS - overlap);
    let law = suite::springs(stiffness / RADIUS);
    let walls: [&[f64]; 2] = [&[-across, across], &[-up, up]];
    let model = suite::world(law, dt, [0.0; 2], 0.0, walls);
    let grain = Grain::disc([0.0; 2], RADIUS, 1.0);
    suite::case("disc of Figure 4", model, &[grain], moments)
}

/// Σ of the first grain, J.
fn extensive(at: &Snapshot) -> Option<[[f64; 2]; 2]> {
    let bed = Bed {
        bodies: &at.bodies,
        contacts: &at.contacts,
        across: &at.across,
    };
    let stress = stress::of_grains(bed).first().copied()?;
    Some([0, 2].map(|row| [0, 2].map(|column| stress[(row, column)])))
}

/// Figure 4 and Table 3 of the paper: a disc between two pairs of opposite forces.
fn disc() -> CaseGroup {
    /// Forces across and up, N per metre of depth.
    const FORCES: [f64; 2] = [0.5, 1.0];
    /// Σ_xx and Σ_zz of Table 3, J.
    const PUBLISHED: [f64; 2] = [1.0, 2.0];
    /// Of all four contacts, N/m: a power of two, so that overlaps and forces have no rounding.
    const STIFFNESS: f64 = 1024.0;
    /// Steps to the moments that are looked at; nothing may move meanwhile.
    const MOMENTS: [u64; 2] = [0, 100];
    let overlaps = FORCES.map(|force| force / STIFFNESS);
    let case = squeezed(overlaps, STIFFNESS, 1.0e-3, MOMENTS.to_vec());
    let title = "The disc of the paper's Figure 4 has the extensive stress of Table 3";
    CaseGroup::new("extensive-stress-of-a-disc", title).with("", case, move |track, figures| {
        for (moment, steps) in MOMENTS.into_iter().enumerate() {
            let stress = track.get(moment).and_then(extensive);
            let stress = stress.unwrap_or([[f64::NAN; 2]; 2]);
            figures.because("Table 3; eight roundings");
            for (axis, name) in ["xx", "zz"].into_iter().enumerate() {
                // The contact points are at the distance R − u, the paper's rigid disc has them at R.
                let rigid = RADIUS / (RADIUS - overlaps[axis]);
                let what = format!("{name}/{steps}-steps: Σ_{name}·R/(R−u) after {steps} steps, J");
                let published = PUBLISHED[axis];
                let off = 8.0 * f64::EPSILON * published;
                figures.is(&what, stress[axis][axis] * rigid, published, off);
            }
            figures.because("Table 3; each term is zero");
            let shear = 0.5 * (stress[0][1] + stress[1][0]);
            let what = format!("xz/{steps}-steps: Σ_xz after {steps} steps, J");
            figures.is(&what, shear, 0.0, 0.0);
        }
    })
}

/// The elastic field inside the same disc under the contact forces that an engine gives it: its
/// average over the disc is the engine's Σ/V.
fn field() -> CaseGroup {
    /// At the walls across and up, m: powers of two, so that forces are in exact balance, and so
    /// small that contact points are on the rim to far below the tolerance.
    const OVERLAPS: [f64; 2] = [1.0 / 67_108_864.0, 1.0 / 33_554_432.0];
    /// N; Figure 4's vertical force.
    const FORCE: f64 = 1.0;
    let case = squeezed(OVERLAPS, FORCE / OVERLAPS[1], 1.0e-6, vec![0]);
    let title = "The elastic field inside Figure 4's disc, under the engine's contact forces, averages to its Σ/V";
    CaseGroup::new("field-inside-a-disc", title).with("", case, |track, figures| {
        field_average(track, figures);
    })
}

/// Of forces that are not in balance there is no field to average.
fn field_average(track: &Track, figures: &mut Figures) -> Option<()> {
    let moment = track.first()?;
    let sum = extensive(moment)?;
    let rim = moment.contacts.iter().map(|contact| {
        let [x, z] = contact.point;
        RimForce {
            angle: z.atan2(x),
            radial: -contact.normal_force,
            // The normal points inward and (−n_z, n_x) with it, so along is turned too.
            tangential: -contact.tangential_force,
        }
    });
    let rim: Vec<RimForce> = rim.collect();
    figures.because("the field is that of forces in balance");
    let left = DiscField::imbalance_of(RADIUS, &rim);
    figures.is(
        "balance: what is left of the forces over their sum, 1",
        left,
        0.0,
        BALANCE,
    );
    let field = DiscField::new(RADIUS, &rim)?;
    let average = field.average_over_disc();
    let volume = std::f64::consts::PI * RADIUS * RADIUS;
    let largest = sum.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs())) / volume;
    figures.because("the engine's Σ/V; contact points are within 3e-8 R of the rim");
    for (name, row, column) in [("xx", 0, 0), ("zz", 1, 1), ("xz", 0, 1)] {
        let what = format!("{name}: σ_{name} averaged over the disc, Pa");
        let expected = sum[row][column] / volume;
        figures.is(&what, -average[(row, column)], expected, 1.0e-6 * largest);
    }
    Some(())
}
