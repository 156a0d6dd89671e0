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

from exchange import Clock, Refused, progress, serve

# The most classes of radii; LAMMPS has 32 groups, and LIGGGHTS a square table of classes in one line.
MOST_CLASSES = 20
# Distance within which neighbours are listed, beyond touching, over the largest radius.
SKIN = 0.2
# Between a force that a program says and the one of the law, over the stiffness times the distance of the centres.
ROUNDING = 1.0e-14
APPROXIMATION = (
    "at most %d stiffnesses of grains: a bed of more radii has that many classes of radius, and a pair the k_n of its "
    "classes' middle radii" % MOST_CLASSES
)
PARTS = ["normal_spring", "local_damping", "gravity", "walls", "stop_rules", "cases", "timing"]
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

    def __len__(self):
        return len(self.radii)


def stiffness(modulus, radius1, radius2):
    a, b = modulus * radius1, modulus * radius2
    return 2.0 * a * b / (a + b)


class OneClass:
    """All grains as one class of the mean radius."""

    def __init__(self, grains):
        self.radii = [sum(grain["radius"] for grain in grains) / len(grains)]
        self.of = [0] * len(grains)

    def __len__(self):
        return 1


def surroundings(folder):
    """Without these Open MPI opens sockets that listen on every address, and hwloc asks for a display.

    Its files are kept in the folder: in the common one, a program that ends removes what another one needs to begin.
    """
    given = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
    return dict(
        given, OMP_NUM_THREADS="1", OMPI_MCA_btl="self", OMPI_MCA_ess_singleton_isolated="1", HWLOC_COMPONENTS="-gl",
        OMPI_MCA_orte_tmpdir_base=folder,
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


def refuse(job):
    law = job.model["law"]
    if law["friction_angle"] > 0.0:
        raise Refused("friction")
    if law["contact"]["viscosity"]["kind"] != "none":
        raise Refused("dashpots")
    if job.asked.get("punch") is not None:
        raise Refused("a punch")


def write_data(path, job, classes, types, density):
    """A data file: x across, y up; ids from 1. Densities are about right; masses are set afterwards, to the bit."""
    grains = job.grains
    largest = max(grain["radius"] for grain in grains)
    places = {"x": [grain["x"] for grain in grains], "z": [grain["z"] for grain in grains]}
    for wall in job.model["walls"]:
        places[wall["axis"]].append(wall["place"])
    rise = 0.0
    if job.kind == "scene":
        fastest = max(grain["vx"] ** 2 + grain["vz"] ** 2 for grain in grains)
        rise = 0.5 * fastest / max(-job.model["gravity"][1], 1.0e-3)
    low = [min(places[axis]) - 4.0 * largest for axis in "xz"]
    high = [max(places[axis]) + 4.0 * largest + rise for axis in "xz"]
    lines = ["crossgrain", "", "%d atoms" % len(grains), "%d atom types" % types, ""]
    lines += ["%s %s xlo xhi" % (number(low[0]), number(high[0])), "%s %s ylo yhi" % (number(low[1]), number(high[1]))]
    lines += ["%s %s zlo zhi" % (number(-1.2 * largest), number(1.2 * largest)), "", "Atoms", ""]
    for index, (grain, kind) in enumerate(zip(grains, classes.of)):
        radius = grain["radius"]
        numbers = (2.0 * radius, grain["mass"] / density(radius), grain["x"], grain["z"])
        lines.append("%d %d %s 0" % (index + 1, kind + 1, " ".join(map(number, numbers))))
    lines += ["", "Velocities", ""]
    for index, grain in enumerate(grains):
        lines.append("%d %s %s 0 0 0 0" % (index + 1, number(grain["vx"]), number(grain["vz"])))
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def masses(job, classes):
    """Commands that give each grain its mass; one for all of a class that have the same."""
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
    edges = "m m p" if job.kind == "case" else "f f p"
    lines = ["clear", "units si", "dimension 2", "atom_style " + style, "atom_modify map array sort 0 0", "boundary " + edges]
    lines += ["newton off", communication, "read_data data"]
    lines += masses(job, classes)
    return lines + ["neighbor %s bin" % number(SKIN * max(classes.radii)), "neigh_modify delay 0 every 1 check yes"]


def motion(model, first):
    """Commands of the leapfrog with Cundall's damping: the force is given its sign rule at the half step's velocity."""
    half, alpha = number(0.5 * model["dt"]), number(model["alpha"])
    commands = ["timestep %s" % number(model["dt"]), "fix move all nve"]
    commands.append('variable once equal "1.0 + (step < %d)"' % (first + 1))
    for axis, pull in zip("xy", model["gravity"]):
        commands += [
            'variable force_%s atom "f%s + mass*(%s)"' % (axis, axis, number(pull)),
            'variable power_%s atom "v_force_%s*(v%s + %s*v_force_%s/mass)"' % (axis, axis, axis, half, axis),
            'variable damped_%s atom "v_once*v_force_%s*(1.0 - %s*((v_power_%s > 0.0) - (v_power_%s < 0.0)))"'
            % (axis, axis, alpha, axis, axis),
            'variable half_%s atom "v%s - %s*f%s/mass"' % (axis, axis, half, axis),
        ]
    commands += ["fix damp all setforce v_damped_x v_damped_y NULL", "fix plane all enforce2d"]
    return commands + ["reset_timestep %d" % first, "thermo_style custom step", "thermo 1000000000"]


def read_rows(path):
    """The rows of a dump as lists of words."""
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    at = next(index for index, line in enumerate(lines) if line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")))
    return [line.split() for line in lines[at + 1 :]]


def contacts(job, classes, places, pairs):
    """Rows of contacts. `pairs` has (i, j, force) of grains as the program says; the rows have the force that the law
    gives to the overlap, so that both programs write the same bits, and it must be the program's up to rounding."""
    grains, rows, modulus = job.grains, [], job.model["law"]["modulus"]
    for one, two, said in pairs:
        one, two = min(one, two), max(one, two)
        (x1, z1), (x2, z2) = places[one], places[two]
        dx, dz = x2 - x1, z2 - z1
        distance = math.sqrt(dx * dx + dz * dz)
        overlap = grains[one]["radius"] + grains[two]["radius"] - distance
        if overlap < 0.0:
            continue
        normal, arm = (dx / distance, dz / distance), grains[one]["radius"] - 0.5 * overlap
        k = stiffness(modulus, classes.radii[classes.of[one]], classes.radii[classes.of[two]])
        force = k * overlap
        # The overlap is a small difference of lengths: its rounding is theirs.
        if not abs(said - force) <= ROUNDING * k * distance:
            raise RuntimeError("grains %d and %d push with %r N, and the law says %r N" % (one, two, said, force))
        rows.append((one, two, overlap, force, 0.0, *normal, x1 + arm * normal[0], z1 + arm * normal[1]))
    for index, wall in enumerate(job.model["walls"]):
        axis = "xz".index(wall["axis"])
        for grain, place in enumerate(places):
            distance, radius = place[axis] - wall["place"], grains[grain]["radius"]
            overlap = radius - abs(distance)
            if overlap < 0.0:
                continue
            normal, point = [0.0, 0.0], list(place)
            normal[axis], point[axis] = math.copysign(1.0, distance), wall["place"]
            curvature = classes.radii[classes.of[grain]]
            force = stiffness(modulus, curvature, curvature) * overlap
            rows.append((len(grains) + index, grain, overlap, force, 0.0, *normal, *point))
    return rows


def show(job, classes, of):
    """Write the moment of `of`: (step, motion, pairs)."""
    step, motion, pairs = of
    if step == job.first:  # The force there is the doubled one, and the start is known.
        motion = [(grain["x"], grain["z"], grain["vx"], grain["vz"]) for grain in job.grains]
    job.moment("settle", step, motion, contacts(job, classes, [of[:2] for of in motion], pairs))
    return motion


def scene_moments(job):
    """Steps at which a scene is looked at, rising; without an end where a rule decides."""
    every = job.asked["moments_every"]
    until = job.asked["until_step"]
    check = job.asked["settle"]["check_every"] if until is None else every
    last = job.asked["settle"]["max_steps"] if until is None else until
    step = job.first
    yield step
    while step < last:
        step = min((step // every + 1) * every, (step // check + 1) * check, last)
        yield step


def follow(job, classes, program, moments):
    """Show a scene's moments until its rule ends it; `moments` gives (step, motion, pairs)."""
    clock = Clock()
    asked = job.asked
    memory, stop, last = {}, None, None
    for of in moments:
        step = of[0]
        shown = step == job.first or step % asked["moments_every"] == 0
        motion = show(job, classes, of) if shown else of[1]
        if step > job.first and asked["until_step"] is None:
            stop = job.settle_rule(step, motion, memory)
        elif step == asked["until_step"]:
            stop = "steps_done"
        if stop is not None:
            if not shown:
                show(job, classes, of)
            last = step
            break
        share = step / asked["until_step"] if asked["until_step"] else memory.get("share", 0.0)
        progress("settle", step, share)
    program.ends()
    job.line(clock.end("settle", last, stop))
    return last - job.first


def runners(start, run):
    """What `serve` is given, of `start`, which starts the program in a folder, and `run`, which gives moments."""

    def run_scene(job):
        refuse(job)
        if job.asked["stage"] != "settle" or not (job.asked["ends_settled"] or job.asked["until_step"] is not None):
            raise Refused("a punch")
        with tempfile.TemporaryDirectory(dir=job.folder) as folder:
            program, classes = start(folder), Classes(job.grains)
            return follow(job, classes, program, run(job, classes, scene_moments(job), program, folder))

    def run_case(job):
        refuse(job)
        moments = job.asked["moments"]
        with tempfile.TemporaryDirectory(dir=job.folder) as folder:
            program, classes = start(folder), Classes(job.grains)
            for of in run(job, classes, moments if moments[0] == 0 else [0, *moments], program, folder):
                if of[0] in moments:
                    show(job, classes, of)
            program.ends()
        return moments[-1]

    return run_scene, run_case


def moments_of(job, moments, program, folder, script, advance, look):
    """(step, motion, pairs) at each of these moments: `script` are the commands up to the first, `advance(from, to)`
    those to the next, `look` reads what was written."""
    step = None
    for to in moments:
        commands = [*script, *advance(to, to)] if step is None else advance(step, to)
        program.does("\n".join(commands))
        step = to
        yield look(job, step, folder)


def motion_in(job, rows):
    """The grains' motion in the rows of a dump sorted by id."""
    if len(rows) != len(job.grains):
        raise RuntimeError("grains were lost: %d of %d are left" % (len(rows), len(job.grains)))
    return [tuple(map(float, row[1:])) for row in rows]


def steps_by_its_clock(job, name, script, look):
    """Time steps of a bed by the program's own clock, with its usual law: one stiffness for all pairs, k = E times the mean
    radius, and a drag force for Cundall's damping, which it does not have. `script` are the commands up to the first step
    and those that write a moment after the last one."""
    refuse(job)
    asked, classes = job.asked, OneClass(job.grains)
    after = asked["warm_up"] + asked["steps"]
    k = stiffness(job.model["law"]["modulus"], *2 * classes.radii)
    drag = DRAG * math.sqrt(k * sum(grain["mass"] for grain in job.grains) / len(job.grains))
    with tempfile.TemporaryDirectory(dir=job.folder) as folder:
        before, shown = script(job, classes, folder, k)
        (across, up) = job.model["gravity"]
        pull = (number(math.hypot(across, up)), number(across), number(up))
        motion = ["timestep %s" % number(job.model["dt"]), "fix move all nve", "fix fall all gravity %s vector %s %s 0" % pull]
        motion += ["fix drag all viscous %s" % number(drag), "fix plane all enforce2d", "thermo_style custom step", "thermo 1000000000"]
        runs = ["run %d" % steps for steps in (asked["warm_up"], asked["steps"]) if steps > 0]
        with open(os.path.join(folder, "in.bed"), "w", encoding="utf-8") as file:
            file.write("\n".join([*before, *motion, *runs, *shown]) + "\n")
        told = subprocess.run(
            [*asked["under"], shutil.which(name), "-in", "in.bed", "-log", "none"], cwd=folder, env=surroundings(folder),
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip
        if told.returncode != 0:
            raise RuntimeError("%s ended with %d:\n%s" % (name, told.returncode, told.stdout[-2000:]))
        wall, share = loop_time(told.stdout, asked["steps"])
        _, moved, pairs = look(job, after, folder)
        job.moment("settle", after, moved, contacts(job, classes, [of[:2] for of in moved], pairs))
    return {"steps": after, "wall_seconds": wall, "cpu_seconds": share and share * wall}


def loop_time(log, steps):
    """Seconds of the last run of so many steps, and the processor's share of them where the program tells."""
    found = re.findall(r"Loop time of (\S+) on .* for (\d+) steps.*((?:\n(?!Loop time).*)*)", log)
    times = [(float(seconds), rest) for seconds, count, rest in found if int(count) == steps]
    if not times:
        raise RuntimeError("its log has no loop time of %d steps" % steps)
    seconds, rest = times[-1]
    share = re.search(r"([\d.]+)% CPU use", rest)
    return seconds, float(share[1]) / 100.0 if share else None


def serve_program(title, name, package, script, advance, look, timing):
    """Be the engine: `script` are the commands up to the first step; `advance` and `look` as `moments_of` has them, `timing`
    as `steps_by_its_clock` has its script."""

    def description():
        find(name, package)
        return {"name": title, "version": version(name), "parts": PARTS, "approximations": [APPROXIMATION]}

    def start(folder):
        return Program(name, ["-log", "none", "-nocite"], folder)

    def run(job, classes, moments, program, folder):
        return moments_of(job, moments, program, folder, script(job, classes, folder), advance, look)

    serve(description, *runners(start, run), lambda job: steps_by_its_clock(job, name, timing, look))
