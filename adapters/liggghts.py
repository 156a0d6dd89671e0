#!/usr/bin/env python3
"""LIGGGHTS as an engine of crossgrain: `model hooke/stiffness` without tangential forces."""
import math
import os

import granular
from granular import number, stiffness

MODEL = "model hooke/stiffness tangential off"
# Constants of what is switched off; the program asks for them.
NONE = ("kt", "gamman", "gammat", "coefficientFriction")


def script(job, classes, folder):
    """Everything up to the first step."""
    modulus, radii = job.model["law"]["modulus"], classes.radii
    # A wall's own type: a grain touches it with the stiffness of two grains of its radius.
    types = len(radii) + 1
    granular.write_data(os.path.join(folder, "data"), job, classes, types, lambda radius: math.pi * radius**2)
    lines = granular.bed(job, classes, "granular", "communicate single vel yes")
    # With a wall both radii are the grain's.
    met = lambda one, two: radii[one] if one < len(radii) else radii[min(two, len(radii) - 1)]
    pairs = [(one, two) for one in range(types) for two in range(types)]
    table = [number(stiffness(modulus, met(one, two), met(two, one))) for one, two in pairs]
    lines.append("fix kn all property/global kn peratomtypepair %d %s" % (types, " ".join(table)))
    for name in NONE:
        lines.append("fix %s all property/global %s peratomtypepair %d %s" % (name, name, types, "0 " * types**2))
    lines += ["pair_style gran " + MODEL, "pair_coeff * *"]
    for index, wall in enumerate(job.model["walls"]):
        axis, place = {"x": "x", "z": "y"}[wall["axis"]], number(wall["place"])
        lines.append("fix wall_%d all wall/gran %s primitive type %d %splane %s" % (index, MODEL, types, axis, place))
    lines += granular.motion(job.model, job.first)
    lines += ["compute pushing all pair/gran/local id force"]
    return lines


def timing(job, classes, folder, k):
    """The same model with one stiffness, and what is asked for after the timed steps."""
    granular.write_data(os.path.join(folder, "data"), job, classes, 1, lambda radius: math.pi * radius**2)
    lines = ["units si", "dimension 2", "atom_style granular", "atom_modify map array", "boundary f f p", "newton off"]
    lines += ["communicate single vel yes", "read_data data"]
    lines += ["neighbor %s bin" % number(granular.SKIN * classes.radii[0]), "neigh_modify delay 0"]
    lines.append("fix kn all property/global kn peratomtypepair 1 %s" % number(k))
    lines += ["fix %s all property/global %s peratomtypepair 1 0" % (name, name) for name in NONE]
    lines += ["pair_style gran " + MODEL, "pair_coeff * *"]
    for index, wall in enumerate(job.model["walls"]):
        axis, place = {"x": "x", "z": "y"}[wall["axis"]], number(wall["place"])
        lines.append("fix wall_%d all wall/gran %s primitive type 1 %splane %s" % (index, MODEL, axis, place))
    # The program takes it before its first step only; it computes nothing until it is asked.
    lines.append("compute pushing all pair/gran/local id force")
    after = job.asked["warm_up"] + job.asked["steps"]
    return lines, [line.replace("v_half_", "v") for line in advance(after, after)]


def advance(step, to):
    run = "run 0 post no" if to == step else "run %d pre no post no" % (to - step)
    grains = "write_dump all custom grains id x y v_half_x v_half_y modify format \"%d %.17g %.17g %.17g %.17g\""
    pushing = " ".join("c_pushing[%d]" % column for column in (1, 2, 4, 5))
    return [run, grains, "write_dump all local pairs %s modify format \"%%.17g %%.17g %%.17g %%.17g\"" % pushing]


def look(job, step, folder):
    grains, pairs = (granular.read_rows(os.path.join(folder, name)) for name in ("grains", "pairs"))
    grains.sort(key=lambda row: int(row[0]))
    forces = [(int(row[0]) - 1, int(row[1]) - 1, math.hypot(float(row[2]), float(row[3]))) for row in pairs]
    return step, granular.motion_in(job, grains), forces


if __name__ == "__main__":
    granular.serve_program("LIGGGHTS", "liggghts", "liggghts", script, advance, look, timing)
