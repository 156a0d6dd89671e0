//! What is not judged of spheres in space is refused or said.

use crossgrain::run::continued::Continued;
use grains::model::Model;
use grains::rules::{NewContact, Rules, Slip, SpringMemory, SpringTurn, TangentialDashpot};
use grains::scene::{AdhesionLaw, Tension, Viscosity};
use grains::task::Case;
use grains::variant::{self, Variant};
use grains::vector::{Vector, hypot, minus, plus, times};
use verdict::envelope::Resolution;

use crate::support::*;

/// A few of the example's spheres.
fn folder_in_space() -> Place {
    let folder = new_folder();
    let text =
        text_of(root("examples/poured-spheres.json")).replace("\"count\": 800", "\"count\": 60");
    fs::write(folder.join("scene.json"), text).expect("writable");
    folder
}

#[test]
fn what_judges_the_plane_alone_refuses_scenes_in_space() {
    let folder = &folder_in_space();
    let commands = [
        "reproduce --scene scene.json --out job",
        "study plan campaign scene.json --members 2 --reduced-stiffness --out campaign",
    ];
    for (command, why) in commands
        .iter()
        .zip(["it is in space (box.depth)", "scenes in the plane"])
    {
        let (_, errors) = ends(folder, 2, &command.words());
        has(&errors, [why]);
    }
}

/// Some spheres in a narrow box.
fn narrow_box() -> Place {
    let folder = folder_in_space();
    let mut scene = json_of(folder.join("scene.json"));
    scene["particles"]["count"] = 90.into();
    scene["box"] = json!({"width": 0.04, "depth": 0.04});
    fs::write(folder.join("scene.json"), scene.to_string()).expect("writable");
    folder
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn campaigns_of_spheres_have_the_bits_of_yade() {
    let folder = &narrow_box();
    for (name, engine) in [("a", "native"), ("b", "yade --loop sorted")] {
        let plan =
            format!("study plan campaign scene.json --members 2 --engine {engine} --out {name}");
        ends(folder, 0, &plan.words());
        ends(folder, 0, &format!("study run {name} --quiet").words());
    }
    let (text, _) = ends(folder, 0, &"study compare a b".words());
    has(&text, ["Identical"]);
}

/// A layer about the middle of the bed bears about the weight of its upper half; campaigns of other clouds are compared by the
/// quantities that spheres have.
#[test]
fn campaigns_of_spheres_are_measured_and_compared() {
    let folder = &narrow_box();
    for (name, seed) in [("a", 1), ("b", 1), ("c", 11)] {
        let plan = format!("study plan campaign scene.json --members 3 --seed {seed} --out {name}");
        ends(folder, 0, &plan.words());
        ends(folder, 0, &format!("study run {name} --quiet").words());
    }
    for row in text_of(folder.join("a/rows.jsonl")).lines() {
        let row: Value = serde_json::from_str(row).expect("a row");
        let measured = |key: &str| row["measured"][key].as_f64().expect(key);
        let height = measured("settled.height.twice_centre_of_mass");
        let solid = 1.0 - measured("settled.porosity.in_layer");
        let weight = 2600.0 * 9.81 * solid * 0.5 * height;
        let share = measured("settled.stress.in_layer.zz") / weight;
        assert!((0.6..1.2).contains(&share), "{share}");
        let across =
            ["xx", "yy"].map(|axis| measured(&format!("settled.stress.in_layer.{axis}")) / weight);
        assert!(
            across.iter().all(|share| (0.2..1.5).contains(share)),
            "{across:?}"
        );
    }
    let (text, _) = ends(folder, 0, &"study compare a b".words());
    has(&text, ["Identical"]);
    let (text, _) = ends(folder, 3, &"study compare a c".words());
    has(
        &text,
        [
            "porosity between floor and surface",
            "mean stress across, along the punch",
        ],
    );
}

#[test]
fn a_column_of_spheres_ends_as_a_heap_the_steeper_the_rougher_they_are() {
    let folder = &new_folder();
    let angle = |friction: f64| {
        let mut scene = json_of(root("examples/column-of-spheres.json"));
        scene["particles"]["count"] = 300.into();
        scene["material"]["friction_angle"] = friction.into();
        scene["box"]["depth"] = 0.04.into();
        scene["settle"]["kinetic_energy_fraction"] = 1e-3.into();
        fs::write(folder.join("scene.json"), scene.to_string()).expect("writable");
        let run = "run scene.json --engine native --until settled --out heap";
        let (text, _) = ends(folder, 0, &run.words());
        has(&text, ["The angle of the heap is"]);
        let record = json_of(folder.join("heap/run.json"));
        fs::remove_dir_all(folder.join("heap")).expect("a folder");
        let measures = record["measures"].as_array().expect("measures").iter();
        let mut angles = measures.filter(|one| one["key"] == "poured.angle");
        angles.next().expect("an angle")["value"]
            .as_f64()
            .expect("a number")
    };
    let [smooth, rough] = [0.1, 0.5].map(angle);
    assert!(
        smooth > 0.0 && rough > smooth + 2.0 && rough < 40.0,
        "{smooth} {rough}"
    );
}

/// A tenth of the example. With the plane's stiffness, 80 times a slab's of this depth, the force is there as an impact.
#[test]
fn the_papers_box_as_a_slab_bears_the_load_after_many_steps_of_the_punch() {
    let folder = &new_folder();
    let mut scene = json_of(root("examples/paper-in-a-slab.json"));
    scene["particles"]["count"] = 500.into();
    scene["box"]["width"] = 0.1.into();
    fs::write(folder.join("scene.json"), scene.to_string()).expect("writable");
    let run = "run scene.json --engine native --quiet --out slab";
    ends(folder, 0, &run.words());
    let record = json_of(folder.join("slab/run.json"));
    let stages = &record["stages"];
    assert_eq!(
        (&stages[0]["stop"], &stages[1]["stop"]),
        (&json!("settled"), &json!("reached"))
    );
    let pressed = stages[1]["steps"].as_u64().expect("a number");
    assert!(pressed > 100, "{pressed}");
}

#[test]
fn runs_in_space_agree_by_their_bits_contacts_across_included() {
    let folder = &folder_in_space();
    for (out, more) in [("a", ""), ("b", ""), ("c", " --perturb stiffness=1e-12")] {
        let run = format!("run scene.json --engine native --steps 1500 --quiet --out {out}{more}");
        ends(folder, 0, &run.words());
    }
    let (text, _) = ends(folder, 0, &"compare a b --quiet".words());
    has(&text, ["Identical", "contacts across"]);
    ends(folder, 1, &"compare a c --quiet".words());
}

/// Judged by an engine that was written from the documents: what contacts remember is taken from their tables. What is wrong late in the
/// run, or in one step between the scene's moments, no first steps show.
#[test]
fn runs_of_spheres_with_friction_and_dashpots_are_followed() {
    let folder = &folder_in_space();
    let path = folder.join("scene.json");
    let mut scene = json_of(&path);
    let mut compile = Command::new("cc");
    compile
        .args(["-std=gnu11", "-O2"])
        .arg(root("tests/corpus/spheres.c"))
        .args(["-lm", "-o"])
        .arg(folder.join("spheres"));
    assert!(compile.status().expect("a C compiler").success());
    let run = "run scene.json --engine native --steps 6000 --quiet --out native";
    ends(folder, 0, &run.words());
    for (name, fault, code, found) in [
        ("right", "", 0, "stretches-b"),
        ("forgets", "history_reset", 1, "from step 0 to 50"),
        (
            "forgets-late",
            "history_late=3000",
            1,
            "from step 3000 to 3050",
        ),
        ("pushed-once", "pushed_at=4321", 1, "from step 4300 to 4350"),
    ] {
        let script = format!(
            "#!/bin/sh\nFAULT='{fault}' exec {} \"$@\"\n",
            folder.join("spheres").display()
        );
        let engine = engine(folder, &format!("{name}.sh"), &script);
        let run = format!("run scene.json --engine {engine} --steps 6000 --quiet --out {name}");
        ends(folder, 0, &run.words());
        let followed = RunFolder::read(&folder.join(name))
            .expect("a run")
            .record
            .continued;
        let double = |continued: &Continued| continued.is_rounding(Resolution::DOUBLE);
        assert!(
            followed.len() == 1 && double(&followed[0]) || code == 1,
            "{followed:?}"
        );
        let last = followed.last().expect("a stretch");
        assert_eq!((followed[0].from, last.to), (0, 6000), "{followed:?}");
        let (text, _) = ends(
            folder,
            code,
            &format!("compare native {name} --quiet").words(),
        );
        has(&text, [["AGREED", "DIFFERENT"][usize::from(code == 1)]]);
        if code == 1 {
            has(&text, ["compare/stretches-b", found]);
        }
    }
    // Moments are in no table.
    scene["contact"]["rolling"] = json!({"bending_stiffness": 0.5, "twisting_stiffness": 0.3});
    fs::write(&path, scene.to_string()).expect("writable");
    let run = format!(
        "run scene.json --engine exec:{} --steps 300 --quiet --out moments",
        folder.join("right.sh").display()
    );
    ends(folder, 0, &run.words());
    assert!(
        RunFolder::read(&folder.join("moments"))
            .expect("a run")
            .record
            .continued
            .is_empty()
    );
}

/// The example with these keys more.
fn with(folder: &Path, more: &str) {
    let scene =
        text_of(root("examples/poured-spheres.json")).replace("\"count\": 800", "\"count\": 60");
    let text = scene.replacen('{', &format!("{{ {more},"), 1);
    fs::write(folder.join("scene.json"), text).expect("writable");
}

const MESH: &str = r#""meshes": [{ "path": "floor.stl", "scale": 0.001, "shift": [0, 0, 0.01] }]"#;

fn binary_stl(triangles: &[[f32; 9]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes[..6].copy_from_slice(b"solid ");
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        triangle
            .iter()
            .for_each(|part| bytes.extend(part.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

const FLOOR: [[f32; 9]; 2] = [
    [0.0, 0.0, 0.0, 100.0, 0.0, 5.0, 0.0, 100.0, 0.0],
    [100.0, 100.0, 5.0, 0.0, 100.0, 0.0, 100.0, 0.0, 5.0],
];

#[test]
fn a_scene_has_the_triangles_of_its_stl_file_and_spheres_lie_on_them() {
    let folder = &new_folder();
    with(folder, MESH);
    let mut text = "solid floor\n".to_owned();
    for t in FLOOR {
        text += "facet normal 0 0 0\nouter loop\n";
        t.chunks(3)
            .for_each(|v| text += &format!("vertex {} {} {}\n", v[0], v[1], v[2]));
        text += "endloop\nendfacet\n";
    }
    text += "endsolid floor\n";
    let floor = folder.join("floor.stl");
    fs::write(&floor, text).expect("writable");
    let (as_text, _) = ends(folder, 0, "scene model scene.json");
    fs::write(&floor, binary_stl(&FLOOR)).expect("writable");
    let (as_bytes, _) = ends(folder, 0, "scene model scene.json");
    assert_eq!(as_text, as_bytes);
    has(&as_text, ["obstacles", "triangle", "0.015"]);
    let run = "run scene.json --engine native --steps 6000 --quiet --out o";
    ends(folder, 0, run);
    // The run has the triangles in itself.
    fs::remove_file(&floor).expect("it is there");
    let run = read_run(folder.join("o"));
    assert_eq!(run.scene.obstacles.len(), 2);
    let (first, lowest) = (run.scene.particles.count + 5, 0.0101);
    assert!(run.last.contacts.iter().any(|contact| contact.id1 >= first));
    assert!(run.last.bodies.z.iter().all(|z| *z > lowest));
    ends(folder, 0, "compare o o --quiet");
}

#[test]
fn stl_files_that_cannot_be_meant_are_refused_with_the_reason() {
    let folder = &new_folder();
    with(folder, MESH);
    let whole = binary_stl(&FLOOR);
    let nan = binary_stl(&[[f32::NAN; 9]]);
    let flat = binary_stl(&[[1.0; 9]]);
    let line = binary_stl(&[[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0]]);
    let many = binary_stl(&vec![FLOOR[0]; 5_001]);
    let text = b"solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
    let files: [(&[u8], &str); 9] = [
        (&[], "an STL file"),
        (&whole[..100], "a whole STL file"),
        (&whole[6..], "an STL file"),
        (&nan, "finite numbers"),
        (&flat, "a triangle with an area"),
        (&line, "a triangle with an area"),
        (&many, "at most 5000 triangles"),
        (&binary_stl(&[]), "a file with triangles"),
        (text, "a whole STL file"),
    ];
    for (bytes, reason) in files {
        fs::write(folder.join("floor.stl"), bytes).expect("writable");
        let (_, errors) = ends(folder, 2, "scene model scene.json");
        has(&errors, [reason]);
    }
    fs::remove_file(folder.join("floor.stl")).expect("it is there");
    let (_, errors) = ends(folder, 2, "scene model scene.json");
    has(&errors, ["a file that can be read"]);
}

#[test]
fn obstacles_that_cannot_be_meant_are_refused_with_the_reason() {
    let folder = &new_folder();
    let plane = |normal: &str| {
        format!(r#""shape": {{ "kind": "plane", "point": [0, 0, 0.01], "normal": {normal} }}"#)
    };
    let body = |half: &str| {
        format!(
            r#""shape": {{ "kind": "box", "centre": [0.05, 0.05, 0], "half_extents": {half} }}"#
        )
    };
    let (good, moving) = (plane("[0.6, 0, 0.8]"), r#""velocity": [0, 0, 1]"#);
    for (obstacle, reason) in [
        (plane("[1, 0, 1]"), "a normal of length 1"),
        (plane("[1, 0, 0]"), "less steep"),
        (body("[0.1, 0, 0.1]"), "half extents above 0"),
        (format!("{good}, {moving}"), "only the punch moves"),
    ] {
        with(folder, &format!(r#""obstacles": [{{ {obstacle} }}]"#));
        let (_, errors) = ends(folder, 2, "scene model scene.json");
        has(&errors, ["/obstacles/0", reason]);
    }
    with(folder, &format!(r#""obstacles": [{{ {good} }}]"#));
    ends(folder, 0, "scene model scene.json");
    let scene = crossgrain::run::folder::read_scene(&folder.join("scene.json")).expect("a scene");
    let lacks = crossgrain::engine::yade::lacking(&scene).expect("YADE has none");
    has(&lacks, ["planes of any direction"]);
    let plane = text_of(folder.join("scene.json")).replace("\"depth\": 0.1", "\"width\": 0.1");
    let flat = plane.replace("\"width\": 0.1, \"width\": 0.1", "\"width\": 0.1");
    fs::write(folder.join("scene.json"), flat).expect("writable");
    let (_, errors) = ends(folder, 2, "scene model scene.json");
    has(&errors, ["left out in the plane"]);
}

/// Two spheres whose overlap goes in this way, m, in so many steps while they slip so far, m, and which are so heavy that nothing changes how
/// they move; with a restitution of LAMMPS they have their masses, and there are no steps.
#[derive(Clone, Copy)]
struct TwoSpheres {
    overlaps: [f64; 2],
    slip: f64,
    steps: u64,
    restitution: Option<f64>,
}

const SIZES: [f64; 2] = [0.005, 0.004];
const ENERGY: f64 = 0.5;
/// N·s/m.
const DASHPOT: f64 = 0.03;
const STEP: f64 = 1.0e-7;

impl TwoSpheres {
    /// The first one's distance, how fast it grows, and the spin about z of both and about y of the first.
    fn motion(&self) -> [f64; 3] {
        let (sum, time) = (SIZES[0] + SIZES[1], self.steps.max(1) as f64 * STEP);
        let [from, to] = self.overlaps;
        [sum - from, (from - to) / time, self.slip / time / sum]
    }

    fn density(&self) -> f64 {
        self.restitution.map_or(1.0e40, |_| 2600.0)
    }

    /// Forces on the second one at each step by LAMMPS with this law, whose numbers are E, a dashpot's, ν and, where there is adhesion, γ.
    fn in_lammps(&self, normal: &str, tangential: &str, friction: f64) -> Vec<Vector> {
        let ([place, velocity, spin], folder) = (self.motion(), &new_folder());
        let (damping, dashpot) = match self.restitution {
            Some(restitution) => ("tsuji", restitution),
            None => ("velocity", DASHPOT),
        };
        let energy = if normal.contains('/') {
            String::new()
        } else {
            format!("{ENERGY:?}")
        };
        let [one, two] = SIZES.map(|radius| 2.0 * radius);
        let (density, steps) = (self.density(), self.steps);
        let text = format!(
            "units si\natom_style sphere\natom_modify map array\nboundary f f f\nnewton off\ncomm_modify vel yes
region space block -0.1 0.1 -0.1 0.1 -0.1 0.1\ncreate_box 1 space
create_atoms 1 single 0 0 0\ncreate_atoms 1 single {place:?} 0 0
set atom 1 diameter {one:?}\nset atom 2 diameter {two:?}\nset group all density {density:?}
set atom 1 omega 0 {spin:?} {spin:?}\nset atom 2 omega 0 0 {spin:?}
pair_style granular\npair_coeff * * {normal} 2e7 {dashpot:?} 0.3 {energy} tangential {tangential} NULL 0 {friction:?} damping {damping}
group second id 2\nvelocity second set {velocity:?} 0 0\nfix move all nve/sphere\ntimestep {STEP:?}
dump forces second custom 1 forces fx fy fz id\ndump_modify forces format line \"%.17g %.17g %.17g %d\"\nrun {steps}\n"
        );
        fs::write(folder.join("job.in"), text).expect("writable");
        let mut lammps = Command::new("lmp");
        lammps
            .args(["-in", "job.in", "-log", "none"])
            .current_dir(folder);
        // No listening sockets, no display, one thread.
        lammps
            .env_remove("DISPLAY")
            .env("OMP_NUM_THREADS", "1")
            .env("HWLOC_COMPONENTS", "-gl");
        lammps.envs([
            ("OMPI_MCA_btl", "self"),
            ("OMPI_MCA_pml", "ob1"),
            ("OMPI_MCA_ess_singleton_isolated", "1"),
        ]);
        lammps.env("OMPI_MCA_orte_tmpdir_base", &**folder);
        let (code, said, _) = told(&lammps.output().expect("LAMMPS"));
        assert_eq!(code, 0, "{said}");
        let rows = text_of(folder.join("forces"));
        let rows = rows.lines().filter_map(|line| line.strip_suffix(" 2"));
        let row = |row: &str| {
            let numbers: Vec<f64> = row
                .split(' ')
                .map(|text| text.parse().expect("a number"))
                .collect();
            [numbers[0], numbers[1], numbers[2]]
        };
        rows.map(row).collect()
    }

    /// The same by the step that is written out.
    fn written_out(&self, adhesion_law: AdhesionLaw, spring_memory: SpringMemory) -> Vec<Vector> {
        let scene =
            parse_scene(&text_of(root("examples/poured-spheres.json"))).expect("an example");
        let mut model = Model::of(&scene);
        (model.gravity, model.dt, model.walls) = ([0.0; 2], STEP, Vec::new());
        model.rules = Rules {
            slip: Slip::Unstretched,
            spring_turn: SpringTurn::KeepsLength,
            new_contact: NewContact::Nothing,
            tangential_dashpot: TangentialDashpot::Within,
            spring_memory,
            ..Rules::default()
        };
        (model.law.modulus, model.law.poissons_ratio) = (2.0e7, Some(0.3));
        let (contact, tension) = (&mut model.law.contact, Tension::Unclipped);
        contact.adhesion = Some(ENERGY).filter(|_| adhesion_law != AdhesionLaw::Pull);
        contact.adhesion_law = adhesion_law;
        contact.viscosity = match self.restitution {
            None => Viscosity::Dashpot {
                c_n: DASHPOT,
                tension,
            },
            Some(e) => {
                let of_tsuji = [1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218];
                // c = α√(4/3 E* a m), and k_n is 2E* a.
                let alpha = of_tsuji
                    .iter()
                    .rev()
                    .fold(0.0, |sum, factor| sum * e + factor);
                let ratio = alpha / (2.0 * 1.5f64.sqrt());
                Viscosity::Ratio { ratio, tension }
            }
        };
        let [place, velocity, spin] = self.motion();
        let mut bodies = Bodies::default();
        for (radius, place, velocity) in [(SIZES[0], 0.0, 0.0), (SIZES[1], place, velocity)] {
            let mass = scene.grain_mass(radius) / scene.material.density * self.density();
            bodies.push([place, 0.0], [velocity, 0.0], radius, mass);
            bodies.inertia.push(0.4 * mass * radius * radius);
        }
        (bodies.y, bodies.vy, bodies.spin_x) = (vec![0.0; 2], vec![0.0; 2], vec![0.0; 2]);
        (bodies.spin, bodies.spin_z) = (vec![spin, 0.0], vec![spin; 2]);
        let case = Case {
            name: "two spheres".to_owned(),
            model,
            bodies,
            punch: None,
            moments: (0..=self.steps).collect(),
        };
        let run = variant::run(&case, &Variant::default());
        let force = |moment: &Snapshot| {
            let both = moment.contacts.iter().zip(&moment.across);
            both.fold([0.0; 3], |_, (contact, across)| {
                let [x, z] = contact.normal;
                plus(
                    times(contact.normal_force, [x, across.normal, z]),
                    across.tangential,
                )
            })
        };
        run.iter().map(force).collect()
    }
}

/// Force by force: while the load rises and falls, with friction that sticks and slides, up to the pull-off, and with the dashpots that a
/// restitution gives. Debian's LAMMPS limits the friction of `dmt` by a number that it has not set, so its contacts do not slide here.
#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs LAMMPS")]
fn lammps_has_the_same_springs_and_adhesion() {
    let pair = |overlaps, slip| TwoSpheres {
        overlaps,
        slip,
        steps: 400,
        restitution: None,
    };
    let sticks = [
        pair([1.0e-5, 9.0e-5], 2.0e-6),
        pair([1.5e-4, 7.0e-5], 2.0e-6),
    ];
    let slides = [
        pair([1.5e-4, 1.0e-5], 2.0e-4),
        pair([2.0e-5, -4.0e-6], 4.0e-6),
    ];
    let at_once = [2.0e-6, 1.2e-4].map(|overlap| TwoSpheres {
        overlaps: [overlap, overlap - 1.0e-8],
        slip: 0.0,
        steps: 0,
        restitution: Some(0.436),
    });
    let (pull, dmt, jkr) = (AdhesionLaw::Pull, AdhesionLaw::Dmt, AdhesionLaw::Jkr);
    let (one, two) = (
        SpringMemory::Displacement,
        SpringMemory::DisplacementRescaled,
    );
    let (hertz, less) = ("hertz/material", SpringMemory::ForceRescaled);
    for (normal, tangential, adhesion, memory) in [
        (hertz, "mindlin", pull, one),
        (hertz, "mindlin_rescale", pull, two),
        (hertz, "mindlin/force", pull, SpringMemory::Force),
        (hertz, "mindlin_rescale/force", pull, less),
        ("dmt", "mindlin_rescale", dmt, two),
        ("jkr", "mindlin", jkr, one),
        ("jkr", "mindlin_rescale/force", jkr, less),
    ] {
        let sliding = slides.iter().filter(|_| normal != "dmt");
        let friction =
            parse_scene(&text_of(root("examples/poured-spheres.json"))).expect("an example");
        let friction = friction.material.friction_angle.tan();
        let mut most = 0.0f64;
        for path in sticks.iter().chain(sliding).chain(&at_once) {
            let theirs = path.in_lammps(normal, tangential, friction);
            let own = path.written_out(adhesion, memory);
            assert_eq!(
                (theirs.len(), own.len()),
                (path.steps as usize + 1, theirs.len())
            );
            let largest = own.iter().map(|force| hypot(*force)).fold(0.0, f64::max);
            let apart = own
                .iter()
                .zip(&theirs)
                .map(|(own, their)| hypot(minus(*own, *their)));
            let apart = apart.fold(0.0, f64::max) / largest;
            assert!(
                apart <= 1.0e-12,
                "{normal} {tangential} {:?}: {apart:e}",
                path.overlaps
            );
            most = most.max(apart);
        }
        println!("{normal} {tangential}: at most {most:e} of the largest force");
    }
}
