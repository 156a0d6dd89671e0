//! A frictionless engine in Rust for small beds, to begin with. It looks at all pairs; a larger bed wants a grid. The protocol:
//! docs/engine-protocol.md.

use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

struct Grain {
    x: [f64; 2],
    v: [f64; 2],
    radius: f64,
    mass: f64,
    force: [f64; 2],
}

struct Wall {
    axis: usize,
    place: f64,
}

struct Contact {
    bodies: [usize; 2],
    numbers: [f64; 7],
}

struct Bed {
    grains: Vec<Grain>,
    walls: Vec<Wall>,
    contacts: Vec<Contact>,
    modulus: f64,
    alpha: f64,
    dt: f64,
    gravity: [f64; 2],
}

fn number(of: &Value, place: &str) -> Result<f64> {
    let found = of.pointer(place).and_then(Value::as_f64);
    Ok(found.ok_or_else(|| format!("job.json has no number at {place}"))?)
}

fn list<'a>(of: &'a Value, place: &str) -> &'a [Value] {
    of.pointer(place).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

impl Bed {
    fn read(folder: &Path, job: &Value) -> Result<Bed> {
        let mut grains = Vec::new();
        for line in fs::read_to_string(folder.join("initial.csv"))?.lines().skip(1) {
            let row: Vec<f64> = line.split(',').map(str::parse).collect::<std::result::Result<_, _>>()?;
            let &[_, x, z, vx, vz, radius, mass, ..] = &row[..] else {
                return Err("a row of initial.csv is too short".into());
            };
            grains.push(Grain { x: [x, z], v: [vx, vz], radius, mass, force: [0.0; 2] });
        }
        let wall = |of: &Value| {
            let axis = usize::from(of["axis"] == "z");
            Ok(Wall { axis, place: number(of, "/place")? })
        };
        Ok(Bed {
            grains,
            walls: list(job, "/model/walls").iter().map(wall).collect::<Result<_>>()?,
            contacts: Vec::new(),
            modulus: number(job, "/model/law/modulus")?,
            alpha: number(job, "/model/alpha")?,
            dt: number(job, "/model/dt")?,
            gravity: [number(job, "/model/gravity/0")?, number(job, "/model/gravity/1")?],
        })
    }

    /// A spring between body `one`, a grain or a wall, which bears nothing, and grain `two`.
    fn push(&mut self, one: usize, two: usize, overlap: f64, k: f64, n: [f64; 2], x: [f64; 2]) {
        let f = n.map(|n| k * overlap * n);
        for axis in 0..2 {
            self.grains[two].force[axis] += f[axis];
            if let Some(grain) = self.grains.get_mut(one) {
                grain.force[axis] -= f[axis];
            }
        }
        let normal = f[0] * n[0] + f[1] * n[1];
        let tangential = f[1] * n[0] - f[0] * n[1];
        self.contacts.push(Contact {
            bodies: [one, two],
            numbers: [overlap, normal, tangential, n[0], n[1], x[0], x[1]],
        });
    }

    /// Each pair once, in the order of their ids, then wall by wall.
    fn add_forces(&mut self) {
        self.contacts.clear();
        self.grains.iter_mut().for_each(|of| of.force = [0.0; 2]);
        let count = self.grains.len();
        for i in 0..count {
            for j in i + 1..count {
                let (one, two) = (&self.grains[i], &self.grains[j]);
                let [dx, dz] = [two.x[0] - one.x[0], two.x[1] - one.x[1]];
                let distance = (dx * dx + dz * dz).sqrt();
                let overlap = one.radius + two.radius - distance;
                if overlap >= 0.0 {
                    let (a, b) = (self.modulus * one.radius, self.modulus * two.radius);
                    let (n, arm) = ([dx / distance, dz / distance], one.radius - 0.5 * overlap);
                    let x = [one.x[0] + arm * n[0], one.x[1] + arm * n[1]];
                    self.push(i, j, overlap, 2.0 * a * b / (a + b), n, x);
                }
            }
        }
        for index in 0..self.walls.len() {
            for j in 0..count {
                let (wall, grain) = (&self.walls[index], &self.grains[j]);
                let distance = grain.x[wall.axis] - wall.place;
                let overlap = grain.radius - distance.abs();
                if overlap >= 0.0 {
                    let a = self.modulus * grain.radius;
                    let (mut n, mut x) = ([0.0; 2], grain.x);
                    n[wall.axis] = 1.0f64.copysign(distance);
                    x[wall.axis] = wall.place;
                    self.push(count + index, j, overlap, 2.0 * a * a / (a + a), n, x);
                }
            }
        }
    }

    /// Leapfrog: velocities belong to the half step before the positions.
    fn step(&mut self) {
        for of in &mut self.grains {
            for axis in 0..2 {
                let mut a = of.force[axis] / of.mass + self.gravity[axis];
                let power = a * (of.v[axis] + 0.5 * self.dt * a);
                let sign = f64::from(i8::from(power > 0.0) - i8::from(power < 0.0));
                a *= 1.0 - self.alpha * sign;
                of.v[axis] += self.dt * a;
                of.x[axis] += self.dt * of.v[axis];
            }
        }
    }

    /// `{:?}` writes as many digits as it takes to read the same bits back.
    fn write(&self, folder: &Path, step: u64) -> Result<()> {
        let mut text = "id,x,z,vx,vz,radius,mass\n".to_owned();
        for (id, of) in self.grains.iter().enumerate() {
            let ([x, z], [vx, vz]) = (of.x, of.v);
            writeln!(text, "{id},{x:?},{z:?},{vx:?},{vz:?},{:?},{:?}", of.radius, of.mass)?;
        }
        fs::write(folder.join(format!("settle-{step}-bodies.csv")), text)?;
        let mut text = "id1,id2,overlap,fn,ft,nx,nz,x,z\n".to_owned();
        for of in &self.contacts {
            write!(text, "{},{}", of.bodies[0], of.bodies[1])?;
            of.numbers.iter().try_for_each(|number| write!(text, ",{number:?}"))?;
            text.push('\n');
        }
        fs::write(folder.join(format!("settle-{step}-contacts.csv")), text)?;
        line(folder, &json!({"stage": "settle", "step": step}))
    }
}

fn line(folder: &Path, value: &Value) -> Result<()> {
    let mut file = OpenOptions::new().create(true).append(true).open(folder.join("moments.jsonl"))?;
    Ok(writeln!(file, "{value}")?)
}

/// Does the job in a folder; the steps that were done.
fn run(folder: &Path) -> Result<u64> {
    let job: Value = serde_json::from_str(&fs::read_to_string(folder.join("job.json"))?)?;
    if job["kind"] == "cases" {
        let cases = list(&job, "/folders").iter().filter_map(Value::as_str);
        return cases.map(|of| run(&folder.join(of))).sum();
    }
    let start = Instant::now();
    let mut bed = Bed::read(folder, &job)?;
    let is_scene = job["kind"] == "scene";
    let moments: Vec<u64> = list(&job, "/moments").iter().filter_map(Value::as_u64).collect();
    let (first, last, every) = match is_scene {
        true => {
            let last = job["until_step"].as_u64().ok_or("it has no rules that end a stage")?;
            (number(&job, "/step")? as u64, last, number(&job, "/moments_every")? as u64)
        }
        false => (0, moments.last().copied().unwrap_or(0), u64::MAX),
    };
    for step in first..=last {
        if step > first {
            bed.step();
        }
        bed.add_forces();
        let is_asked = is_scene && (step == first || step == last || step % every == 0);
        if is_asked || moments.contains(&step) {
            bed.write(folder, step)?;
        }
        if step % 100 == 0 {
            println!("settle {step}");
        }
    }
    if is_scene {
        let seconds = start.elapsed().as_secs_f64();
        let end = json!({"end": "settle", "steps": last, "stop": "steps_done", "wall_seconds": seconds, "cpu_seconds": seconds});
        line(folder, &end)?;
    }
    Ok(last - first)
}

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["describe"] => {
            let parts = ["normal_spring", "local_damping", "gravity", "walls", "cases"];
            println!("{}", json!({"protocol": 1, "name": "engine-rust", "version": "1", "parts": parts}));
        }
        ["run", folder] => {
            let steps = run(Path::new(folder))?;
            fs::write(Path::new(folder).join("done.json"), json!({"steps": steps}).to_string())?;
        }
        _ => return Err("usage: engine describe | run FOLDER".into()),
    }
    Ok(())
}
