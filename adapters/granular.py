"""What LAMMPS and LIGGGHTS share: a crossgrain model in their words, and their tables in ours.

The programs integrate by velocity Verlet, with half a kick before and half a kick after the forces; crossgrain's
leapfrog gives a whole kick. Between the two halves the velocity is the one of the half step, so forces are damped
there, and the very first force, which is used for one half only, is doubled.
"""
import math
import os
import re
import shutil
import subprocess
import tempfile

import apart
from exchange import Refused, serve
from law import Solids, has_friction, punch_contacts, refuse_inside, rotates, stiffness, tangents, wall_contacts
from stages import run_case, run_scene

# The most classes of radii; LAMMPS has 32 groups, and LIGGGHTS a square table of classes in one line.
MOST_CLASSES = 20
# The most in space, where each pair of them has constants of its own.
MOST_KINDS = 200
# Distance within which neighbours are listed, beyond touching, over the largest radius.
SKIN = 0.2
# Between a force that a program says and the one of the law, over the stiffness times the distance of the centres.
ROUNDING = 1.0e-14
APPROXIMATION = (
    "at most %d stiffnesses of grains: a bed of more radii has that many classes of radius, and a pair the k_n of its "
    "classes' middle radii" % MOST_CLASSES
)
FORMS = [{"classes_of_radius": MOST_CLASSES}]
PARTS = [
    "normal_spring", "tangential_spring", "wall_friction", "rotation", "dashpots", "local_damping", "gravity", "walls", "punch",
    "stop_rules", "cases", "timing", "space", "materials",
]  # fmt: skip
# Columns of atoms in space, by the model's names.
IN_SPACE = ("x", "y", "z", "vx", "vy", "vz", "spin_x", "spin", "spin_z")
# Steps that the programs make before the first one.
BEFORE = 1
# Drag over the root of mean mass times stiffness: about the dissipation that Cundall's damping gives a settled bed.
DRAG = 0.016


def number(value):
    return "%.17g" % value


class Classes:
    """Grains by radius: exact where there are few radii, of equal widths where there are many."""

    def __init__(self, grains):
        radii = sorted({grain["radius"] for grain in grains})
        self.exact = len(radii) <= MOST_CLASSES
        if self.exact:
            self.radii = radii
            self.of = [radii.index(grain["radius"]) for grain in grains]
        else:
            low, width = radii[0], (radii[-1] - radii[0]) / MOST_CLASSES
            self.radii = [low + (index + 0.5) * width for index in range(MOST_CLASSES)]
            self.of = [min(int((grain["radius"] - low) / width), MOST_CLASSES - 1) for grain in grains]
        of_class = [[grain["mass"] for grain, kind in zip(grains, self.of) if kind == one] for one in range(len(self.radii))]
        self.masses = [max(of, default=1.0) for of in of_class]
        # Whether a class has grains of several masses.
        self.mixed = any(min(of) < max(of) for of in of_class if of)

    def __len__(self):
        return len(self.radii)


class Kinds:
    """Grains in space that have one law: those of a material, with moments of a radius too, or under linear springs those of a radius,
    mass and material. `weights` are masses that the program is given, where others than the grains' make its dashpots those of the law."""

    def __init__(self, job):
        has_moments = rotates(job) and job.model["law"]["contact"].get("rolling")
        names = ("radius",) * bool(has_moments) if Solids(job).is_hertz else ("radius", "mass")
        of = [(int(grain.get("material", 0)), *(grain[name] for name in names)) for grain in job.grains]
        self.all = sorted(set(of))
        if len(self.all) > MOST_KINDS:
            raise Refused("linear springs in space of more than %d kinds of grains" % MOST_KINDS)
        at = {kind: index for index, kind in enumerate(self.all)}
        self.of = [at[kind] for kind in of]
        self.radii = [max(grain["radius"] for grain in job.grains)] * len(self.all)
        self.weights = [grain["mass"] for grain in job.grains]

    def __len__(self):
        return len(self.all)


class OneClass:
    """All grains as one class of the mean radius."""

    def __init__(self, grains):
        self.radii = [sum(grain["radius"] for grain in grains) / len(grains)]
        self.of = [0] * len(grains)

    def __len__(self):
        return 1


def surroundings(folder):
    """Without these Open MPI opens sockets that listen on every address and looks for networks, which takes longer than most jobs, and
    hwloc asks for a display.

    Its files are kept in the folder: in the common one, a program that ends removes what another one needs to begin.
    """
    given = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
    return dict(
        given, OMP_NUM_THREADS="1", OMPI_MCA_btl="self", OMPI_MCA_pml="ob1", OMPI_MCA_ess_singleton_isolated="1",
        HWLOC_COMPONENTS="-gl", OMPI_MCA_orte_tmpdir_base=folder,
    )  # fmt: skip


class Program:
    """The program, told commands line by line and heard until it has done them."""

    def __init__(self, name, arguments, folder):
        self.name, self.folder = name, folder
        self.marks = 0
        # Lines come when they are whole, not when a block is full.
        self.child = subprocess.Popen(
            ["stdbuf", "-oL", name, *arguments], cwd=folder, env=surroundings(folder), text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        self.heard = []

    def does(self, commands):
        """Have it do the commands; what it prints meanwhile."""
        self.marks += 1
        mark = "crossgrain: done %d" % self.marks
        # From a file: what it prints meanwhile could fill a pipe that nobody reads while this one is written.
        with open(os.path.join(self.folder, "commands"), "w", encoding="utf-8") as file:
            file.write(commands + "\n")
        self.tell('include commands\nprint "%s"\n' % mark)
        heard = []
        for line in self.child.stdout:
            if line.strip() == mark:
                return heard
            heard.append(line)
            if line.startswith("ERROR"):
                break
        self.heard += heard
        raise RuntimeError("%s gave up:\n%s" % (self.name, "".join(self.heard[-12:])))

    def tell(self, commands):
        try:
            self.child.stdin.write(commands)
            self.child.stdin.flush()
        except BrokenPipeError:
            pass  # What it said before it ended tells more.

    def ends(self):
        self.child.stdin.close()
        self.child.stdout.read()
        self.child.wait()


def find(name, package):
    if shutil.which(name) is None:
        raise SystemExit(
            "there is no program `%s` on the path; on Debian: apt-get install --no-install-recommends %s" % (name, package)
        )


def version(name):
    """The program's version, as it says."""
    # LIGGGHTS leaves a log where it is started, even for this.
    with tempfile.TemporaryDirectory() as folder:
        asked = subprocess.run(
            [name, "-h"], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60
        )
    text = asked.stdout
    found = re.search(r"Simulator - (.+)|LIGGGHTS-PUBLIC ([^,\s]+)", text)
    return (found[1] or found[2]).strip() if found else "unknown"


def write_data(path, job, classes, types, density):
    """A data file: in the plane x across, y up, so that spins have the other sign; ids from 1. Densities are about right; masses are set
    afterwards, to the bit."""
    grains = job.grains
    largest = max(grain["radius"] for grain in grains)
    places, plane = {axis: [grain[axis] for grain in grains] for axis in job.axes}, job.axes == "xz"
    for wall in job.model["walls"]:
        places[wall["axis"]].append(wall["place"])
    bodies = list(zip(grains, classes.of))
    punch = job.asked.get("punch")
    if punch is not None:
        bodies.append((body_of(punch, grains[0]), classes.of[0]))
        for axis, centre, half in zip("xz", punch["centre"], punch["half_extents"]):
            places[axis] += [centre - half, centre + half]
    rise = 0.0
    if job.kind == "scene":
        fastest = max(grain["vx"] ** 2 + grain["vz"] ** 2 for grain in grains)
        rise = 0.5 * fastest / max(-job.model["gravity"][1], 1.0e-3)
    low = [min(places[axis]) - 4.0 * largest for axis in job.axes]
    high = [max(places[axis]) + 4.0 * largest + rise for axis in job.axes]
    if plane:
        # LIGGGHTS wants room around the punch, or fails in setting it up.
        deep = 1.2 * largest if punch is None else 4.0 * max(largest, *punch["half_extents"])
        low, high = [*low, -deep], [*high, deep]
    lines = ["crossgrain", "", "%d atoms" % len(bodies), "%d atom types" % types, ""]
    lines += ["%s %s %slo %shi" % (number(one), number(other), name, name) for one, other, name in zip(low, high, "xyz")]
    lines += ["", "Atoms", ""]
    for index, (grain, kind) in enumerate(bodies):
        radius = grain["radius"]
        numbers = (2.0 * radius, grain["mass"] / density(radius), *(grain[axis] for axis in job.axes))
        lines.append("%d %d %s" % (index + 1, kind + 1, " ".join(map(number, numbers))) + " 0" * plane)
    lines += ["", "Velocities", ""]
    for index, (grain, _) in enumerate(bodies):
        motion = [grain["vx"], grain["vz"], 0.0, 0.0, 0.0, -grain.get("spin", 0.0)]
        if not plane:
            motion = [grain.get(name, 0.0) for name in IN_SPACE[3:]]
        lines.append("%d %s" % (index + 1, " ".join(map(number, motion))))
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def body_of(punch, grain):
    """The punch as a grain like this one that nothing pushes, so that the program moves its centre step by step."""
    (x, z) = punch["centre"]
    return dict(grain, x=x, z=z, vx=0.0, vy=0.0, vz=punch["velocity"])


def masses(job, classes):
    """Commands that give each grain its mass; one for all of a class that have the same."""
    if job.axes == "xyz":
        return ["set atom %d mass %s" % (index + 1, number(weight)) for index, weight in enumerate(classes.weights)]
    by_class = [set() for _ in range(len(classes))]
    for grain, kind in zip(job.grains, classes.of):
        by_class[kind].add(grain["mass"])
    commands = ["set type %d mass %s" % (kind + 1, number(max(of))) for kind, of in enumerate(by_class) if of]
    for index, (grain, kind) in enumerate(zip(job.grains, classes.of)):
        if len(by_class[kind]) > 1:
            commands.append("set atom %d mass %s" % (index + 1, number(grain["mass"])))
    return commands


def bed(job, classes, style, communication):
    """Commands that read the grains from the data file."""
    edges = " ".join(len(job.axes) * ["m" if job.kind == "case" else "f"] + ["p"] * (job.axes == "xz"))
    lines = ["clear", "units si", "dimension %d" % len(job.axes), "atom_style " + style, "atom_modify map array sort 0 0"]
    lines += ["boundary " + edges, "newton off", communication, "read_data data"]
    lines += [*masses(job, classes), "group grains id <= %d" % len(job.grains)]
    if job.asked.get("punch") is not None:
        lines += ["group punch id %d" % (len(job.grains) + 1), "neigh_modify exclude group punch all"]
        lines.append("fix alone punch setforce 0.0 0.0 0.0")
    lines += ["timestep %s" % number(job.model["dt"]), "thermo 1000000000"]
    return lines + ["neighbor %s bin" % number(SKIN * max(classes.radii)), "neigh_modify delay 0 every 1 check yes"]


def of_atoms(folder, name, values):
    """A variable of these values, one an atom."""
    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
        file.write("%d\n" % len(values))
        file.writelines("%d %s\n" % (index + 1, number(of)) for index, of in enumerate(values))
    return "variable %s atomfile %s" % (name, name)


def spins(job, folder, twisted):
    """Formulas of what turns the grains between two steps, as the programs' own integrators know neither damping nor other inertias
    than those of balls and discs. `twisted` are torques that are added to the program's."""
    inertias = [grain["inertia"] for grain in job.grains] + [1.0] * (job.asked.get("punch") is not None)
    dt, alpha = (number(job.model[name]) for name in ("dt", "alpha"))
    commands, about = [of_atoms(folder, "inertia", inertias)], [""] if job.axes == "xz" else ["_x", "_y", "_z"]
    for at, name in enumerate(about):
        torque = "(f_kept[%d]%s)" % (at + 1, twisted[at]) if twisted else "f_kept[%d]" % (at + 1)
        spin = "f_kept[%d]" % (at + 1 + len(about))
        commands += [
            'variable turn%s atom "%s/v_inertia"' % (name, torque),
            'variable turning%s atom "v_turn%s*(%s + 0.5*%s*v_turn%s)"' % (name, name, spin, dt, name),
            'variable spin%s atom "%s + %s*v_turn%s*(1.0 - %s*((v_turning%s > 0.0) - (v_turning%s < 0.0)))"'
            % (name, spin, dt, name, alpha, name, name),
        ]
    return commands


def motion(job, folder, looks=False, pushed=None, twisted=None):
    """Commands of the leapfrog with Cundall's damping: the force is given its sign rule at the half step's velocity, where forces of
    pairs may be looked at too. In a first step nothing moves yet: the programs give contacts the slip
    of a step within whole steps alone, and the model does so at the start too. From then on the program is one step ahead.
    In space `pushed` and `twisted` are forces and torques that are added to the program's."""
    model, begun = job.model, job.first + BEFORE
    half, alpha = number(0.5 * model["dt"]), number(model["alpha"])
    plane, across, up = job.axes == "xz", *model["gravity"]
    kept = "tqz omegaz" if plane else "tqx tqy tqz omegax omegay omegaz"
    commands = ["group moving subtract all all", "fix move moving nve", "fix kept grains store/state 1 " + kept]
    mass, weighed = ("mass", "") if plane else ("v_true", "*mass/v_true")
    if not plane:
        commands.append(of_atoms(folder, "true", [of["mass"] for of in job.grains] + [1.0] * (job.asked.get("punch") is not None)))
    commands += ["variable looked equal c_known[1]"] * looks + ['variable once equal "1.0 + (step < %d)"' % (begun + 1)]
    for axis, pull, further in zip("xyz", (across, up) if plane else (across, 0.0, up), pushed or 3 * [""]):
        commands += [
            'variable force_%s atom "f%s + %s*(%s)%s%s"' % (axis, axis, mass, number(pull), further, " + 0.0*v_looked" * looks),
            'variable power_%s atom "v_force_%s*(v%s + %s*v_force_%s/%s)"' % (axis, axis, axis, half, axis, mass),
            'variable damped_%s atom "v_once*v_force_%s*(1.0 - %s*((v_power_%s > 0.0) - (v_power_%s < 0.0)))%s"'
            % (axis, axis, alpha, axis, axis, weighed),
            'variable half_%s atom "v%s - %s*f%s/mass"' % (axis, axis, half, axis),
        ]
    commands += ["fix damp grains setforce v_damped_x v_damped_y " + ("NULL" if plane else "v_damped_z")]
    commands += ["fix plane all enforce2d"] * plane
    return [*commands, *(spins(job, folder, twisted) if rotates(job) else []), "run %d post no" % BEFORE]


def read_rows(path):
    """The rows of a dump as lists of words."""
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    at = next(index for index, line in enumerate(lines) if line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")))
    return [line.split() for line in lines[at + 1 :]]


def dumps(pairs, form, motion, places="x y "):
    """Commands that write a moment: the atoms, and `pairs`, the columns of two ids and what acts between them."""
    atoms, of_pairs = places + motion, " ".join(["%.17g"] * len(pairs.split()))
    return [
        'write_dump all custom grains id %s modify %s "%%d%s"' % (atoms, form, " %.17g" * len(atoms.split())),
        'write_dump all local pairs %s modify %s "%s"' % (pairs, form, of_pairs),
    ]


def read_moment(job, folder):
    """What `dumps` wrote: of each atom by its id, the grains first, its place and what follows, and of pairs (i, j) and what follows."""
    atoms, pairs = (read_rows(os.path.join(folder, name)) for name in ("grains", "pairs"))
    if len(atoms) < len(job.grains):
        raise RuntimeError("grains were lost: %d of %d are left" % (len(atoms), len(job.grains)))
    atoms.sort(key=lambda row: int(row[0]))
    pairs = [(int(row[0]) - 1, int(row[1]) - 1, *map(float, row[2:])) for row in pairs]
    return [tuple(map(float, row[1:])) for row in atoms], pairs


def contacts(job, classes, places, pairs, rich=False):
    """Rows of contacts of grains. `pairs` has (i, j, force) as the program says. The rows have the force that the law gives to the
    overlap, so that both programs write the same bits, and it must be the program's up to rounding; of a rich law `pairs` has the
    force on the grain j across and up, before it what belongs to the normal if that is told apart, and the rows have these."""
    grains, rows, modulus = job.grains, [], job.model["law"]["modulus"]
    for one, two, *said in pairs:
        sign = -1.0 if one < two else 1.0
        one, two = min(one, two), max(one, two)
        away = [there - here for here, there in zip(places[one], places[two])]
        distance = math.sqrt(sum(of * of for of in away))
        overlap = grains[one]["radius"] + grains[two]["radius"] - distance
        if overlap < 0.0:
            continue
        normal, arm = [of / distance for of in away], grains[one]["radius"] - 0.5 * overlap
        if rich:
            push, told = said[: -len(away)], said[-len(away) :]
            force = along(normal, [sign * of for of in told])
            force = (force[0] + sum(push), force[1])
        else:
            k = stiffness(modulus, classes.radii[classes.of[one]], classes.radii[classes.of[two]])
            force = [k * overlap, 0.0]
            # The overlap is a small difference of lengths: its rounding is theirs.
            if not abs(math.hypot(*said) - force[0]) <= ROUNDING * k * distance:
                raise RuntimeError("grains %d and %d push with %r N, and the law says %r N" % (one, two, said, force[0]))
        rows.append((one, two, overlap, *force, *normal, *(here + arm * of for here, of in zip(places[one], normal))))
    return rows


def along(normal, force):
    """The parts of a force along a normal and across it, of which the latter is a vector in space."""
    if len(normal) == 2:
        return force[0] * normal[0] + force[1] * normal[1], force[1] * normal[0] - force[0] * normal[1]
    push = sum(one * other for one, other in zip(force, normal))
    return push, [of - push * n for of, n in zip(force, normal)]


class Run:
    """A job in the program; `words` are what the program calls things."""

    def __init__(self, job, words, folder):
        refuse_inside(job)
        self.job, self.words, self.folder, self.step = job, words, folder, job.first
        self.space = job.axes == "xyz"
        self.classes, self.turns = Kinds(job) if self.space else Classes(job.grains), rotates(job)
        viscosity = job.model["law"]["contact"]["viscosity"]["kind"]
        self.dashes = viscosity != "none"
        self.looks = self.dashes and words.looks
        self.rich = self.dashes or has_friction(job) or self.space
        if not self.space and self.classes.mixed and viscosity == "restitution":
            raise Refused("a restitution of grains of one radius and several masses, or of more than %d radii" % MOST_CLASSES)
        self.program = Program(words.program, ["-log", "none", "-nocite"], folder)
        # The columns of what walls and punch do, by their numbers, what is summed at the last step of each run, and what is added to
        # forces and torques.
        self.flat, self.sums, self.pushed, self.twisted = [], [], None, None
        # Commands before each step, whether the punch was stopped, and what is looked at from then on.
        self.each, self.stopped, self.watch = [], False, None
        # The model's names of what the program writes of each atom.
        self.columns = ["x", "z", "vx", "vz"] + ["spin"] * self.turns
        if self.space:
            self.columns = [name for name in IN_SPACE if name in job.names]
        # The velocities that a start gives are those of the half step.
        script = words.script(self)
        self.does([*script, *motion(job, folder, self.looks, self.pushed, self.twisted)], "v%s")
        self.program.does("group moving union all" + "\nvariable looked equal 0.0" * self.looks)

    def does(self, commands, moves="v_half_%s"):
        """Commands, and then those that write the moment."""
        axes, turns = "xyz"[: len(self.job.axes)], "spin" in self.columns
        shown = [moves % axis for axis in axes] + (["omegax", "omegay", "omegaz"] if self.space else ["omegaz"]) * turns
        shown += [column for _, *columns in self.flat for column in columns] * self.rich
        shown = dumps(self.words.pairs[self.rich + self.space], self.words.form, " ".join(shown), " ".join([*axes, ""]))
        if self.dashes and moves != "v%s":
            before, after = self.words.around(axes)
            shown[1:] = [*before, shown[1], *after]
        heard = self.program.does("\n".join([*commands, *shown]))
        moved, self.pairs = read_moment(self.job, self.folder)
        at = len(self.columns)
        self.on_flat = [of[at:] for of in moved]
        if self.space:
            order = [self.columns.index(name) for name in self.job.names]
            self.motion = [[of[at] for at in order] for of in moved]
        else:
            # Across the plane spins have the other sign.
            self.motion = [(*of[:4], *(-spin for spin in of[4:at])) for of in moved]
        self.places = [of[: len(axes)] for of in moved]
        if self.stopped and self.watch is not None:
            self.watch()
        return heard

    def steps(self, count):
        """Commands of so many steps; spins are turned before each, and at the last one forces of pairs are looked at."""
        run = ["run %d pre no post no" % count]
        if self.turns or self.each:
            run = count * [*self.each, *[self.words.turn[self.space]] * self.turns, "run 1 pre no post no"]
        elif self.looks and count > 1:
            run = ["run %d pre no post no" % (count - 1), "run 1 pre no post no"]
        if self.looks:
            run.insert(-1, 'variable looked equal "c_known[1]"')
            run += ["variable looked equal 0.0"]
        return run

    def to(self, step):
        if step > self.step:
            self.does(self.steps(step - self.step))
            self.step = step

    def to_rule(self, step):
        """Go on to this step, or to an earlier one where the punch has its force or is too deep: whether it has the force,
        whether it is too deep, and the force."""
        loading, punch = self.job.asked["loading"], self.job.asked["punch"]
        depth = "%s - (%s[%d] - %s)" % (number(punch["start"]), self.up(), len(self.job.grains) + 1, number(punch["half_extents"][1]))
        heard = self.does(
            [
                'variable reached equal "v_force >= %s"' % number(loading["target_force"]),
                'variable deep equal "%s >= %s"' % (depth, number(loading["give_up_depth"])),
                'variable goes equal "(step < %d)*(1 - v_reached)*(1 - v_deep)"' % (step + BEFORE),
                "variable now equal step",
                "label again",
                *self.steps(1),
                'if "${goes} > 0" then "jump commands again"',
                'print "crossgrain: at ${now} ${reached} ${deep} ${force}"',
            ]
        )
        now, reached, deep, force = next(line.split()[2:] for line in heard if line.startswith("crossgrain: at"))
        self.step = int(now) - BEFORE
        return reached != "0", deep != "0", float(force)

    def stop_punch(self):
        self.stopped = True
        self.does(["velocity punch set NULL %s" % ("NULL 0.0" if self.space else "0.0 NULL")])

    def up(self):
        """The program's name of the vertical axis."""
        return "z" if self.space else "y"

    def ends(self):
        self.program.ends()

    def show(self):
        """Write the moment."""
        job, grains, punch = self.job, self.job.grains, None
        motion, places = self.motion[: len(grains)], self.places
        rows = wall_contacts(job, lambda grain: self.classes.radii[self.classes.of[grain]], places[: len(grains)])
        if job.asked["punch"] is not None:
            centre = (places[-1][0], places[-1][-1])
            rows += punch_contacts(job, centre, places[: len(grains)])
        if self.rich:
            rows = [self.told(row) for row in rows]
        if job.asked["punch"] is not None:
            of_punch = [row for row in rows if row[0] == len(grains) + len(job.model["walls"])]
            force = -sum(row[3] * row[7] + row[4][2] if self.space else row[3] * row[6] + row[4] * row[5] for row in of_punch)
            punch = {"centre": centre, "start": job.asked["punch"]["start"], "velocity": self.motion[-1][3], "force": force}
        pairs = [self.words.mended(self, *of) for of in self.pairs] if self.words.mended else self.pairs
        rows += contacts(job, self.classes, places[: len(grains)], pairs, self.rich)
        job.moment(job.asked.get("stage", "settle"), self.step, motion, rows, punch)

    def told(self, row):
        """A row of a wall or the punch with the force that the program tells."""
        of, grain, overlap, _, _, *where = row
        size, told = len(self.job.axes), self.on_flat[grain]
        force, told = size * [0.0], [told[at : at + size] for at in range(0, len(told), size)]
        for (index, *_), on in zip(self.flat, told):
            if index == of - len(self.job.grains):
                force = [one + other for one, other in zip(force, on)]
        return (of, grain, overlap, *along(where[:size], force), *where)


def steps_by_its_clock(job, name, script):
    """Time steps of a bed by the program's own clock, with its usual law: one stiffness for all pairs, k = E times the mean
    radius, and a drag force for Cundall's damping, which it does not have. `script` are the commands up to the first step
    and those that write a moment after the last one."""
    asked, classes = job.asked, OneClass(job.grains)
    after = asked["warm_up"] + asked["steps"]
    k = stiffness(job.model["law"]["modulus"], *2 * classes.radii)
    drag = DRAG * math.sqrt(k * sum(grain["mass"] for grain in job.grains) / len(job.grains))
    with tempfile.TemporaryDirectory(dir=job.folder) as folder:
        before, shown = script(job, classes, folder, k)
        (across, up) = job.model["gravity"]
        pull = (number(math.hypot(across, up)), number(across), number(up))
        motion = ["timestep %s" % number(job.model["dt"]), "fix fall all gravity %s vector %s %s 0" % pull]
        motion += ["fix drag all viscous %s" % number(drag), "fix plane all enforce2d", "thermo_style custom step", "thermo 1000000000"]
        runs = ["run %d" % steps for steps in (asked["warm_up"], asked["steps"]) if steps > 0]
        wall, share = loop_of(job, name, folder, [*before, *motion, *runs, *shown])
        moved, pairs = read_moment(job, folder)
        moved = [(*of[:4], *(-spin for spin in of[4:])) for of in moved]
        job.moment("settle", after, moved, contacts(job, classes, [of[:2] for of in moved], pairs))
    return {"steps": after, "wall_seconds": wall, "cpu_seconds": share and share * wall}


def loop_of(job, name, folder, commands):
    """Have the program do these commands; what `loop_time` finds."""
    asked = job.asked
    with open(os.path.join(folder, "in.bed"), "w", encoding="utf-8") as file:
        file.write("\n".join(commands) + "\n")
    command, environment = [shutil.which(name), "-in", "in.bed", "-log", "none"], surroundings(folder)
    if asked["processes"] > 1:
        command, environment = apart.alone([*apart.mpirun(asked["processes"]), *command]), apart.surroundings(folder)
    told = subprocess.run(
        command, cwd=folder, env=environment,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    if told.returncode != 0:
        raise RuntimeError("%s ended with %d:\n%s" % (name, told.returncode, told.stdout[-2000:]))
    return loop_time(told.stdout, asked["steps"])


def refuse_space(_):
    raise Refused("spheres in space")


def loop_time(log, steps):
    """Seconds of the last run of so many steps, and the processor's share of them where the program tells; the kernel's clock of
    processor time may not tick in a short run, which the program calls 0 %."""
    found = re.findall(r"Loop time of (\S+) on .* for (\d+) steps.*((?:\n(?!Loop time).*)*)", log)
    times = [(float(seconds), rest) for seconds, count, rest in found if int(count) == steps]
    if not times:
        raise RuntimeError("its log has no loop time of %d steps" % steps)
    seconds, rest = times[-1]
    share = re.search(r"([\d.]+)% CPU use", rest)
    return seconds, share and float(share[1]) / 100.0 or None


class Words:
    """What a program calls things: its name, the commands of a bed up to the first step (`script`), columns of pairs under springs
    alone, under another law and in space (`pairs`), how it is told digits (`form`) and spins in the plane and in space (`turn`), and
    commands before and after those that write pairs under a law with dashpots (`around`, of the axes), where
    they are not looked at while velocities are those of the half step (`looks`), and what makes of a row of pairs the force that acted
    (`mended`, of the run), where the program writes another one."""

    def __init__(self, program, script, pairs, form, turn, around, looks=False, mended=None):
        self.program, self.script, self.pairs, self.form, self.turn = program, script, pairs, form, turn
        self.around, self.looks, self.mended = around, looks, mended


def serve_program(title, package, words, rules, timing, more=(), in_space=refuse_space, parts=()):
    """Be the engine; `timing` is that of `steps_by_its_clock`, `in_space` the whole of it for spheres in space, `more` and `parts` are
    approximations and parts of this program alone."""
    name = words.program

    def description():
        find(name, package)
        said = {"protocol": 2, "name": title, "version": version(name), "parts": [*PARTS, *parts], "approximations": [APPROXIMATION, *more]}
        return dict(said, forms=FORMS, rules=rules)

    def in_folder(runs):
        def run(job):
            with tempfile.TemporaryDirectory(dir=job.folder) as folder:
                return runs(job, lambda of: Run(of, words, folder))

        return run

    def timed(job):
        return in_space(job) if "y" in job.rows[0] else steps_by_its_clock(job, name, timing)

    serve(description, in_folder(run_scene), in_folder(run_case), timed)
