#!/usr/bin/env python3
"""LIGGGHTS as an engine of crossgrain: `model hooke/stiffness` without tangential forces."""
import math
import os

import granular
from granular import number
from law import refuse, stiffness

MODEL = "model hooke/stiffness tangential off"
# Constants of what is switched off; the program asks for them.
NONE = ("kt", "gamman", "gammat", "coefficientFriction")
# What is asked of pairs of grains: their ids and the force.
PAIRS = "c_pushing[1] c_pushing[2] c_pushing[4] c_pushing[5]"


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
    # The program takes it before its first step only, and a job may begin at a later one.
    lines += ["compute pushing all pair/gran/local id force"]
    return lines + granular.motion(job)


def timing(job, classes, folder, k):
    """The same model with one stiffness, and what is asked for after the timed steps."""
    refuse(job)
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
    lines += ["compute pushing all pair/gran/local id force", "fix move all nve"]
    return lines, ["run 0 post no", *granular.dumps(PAIRS, "format", "vx vy")]


if __name__ == "__main__":
    written = granular.dumps(PAIRS, "format")
    granular.serve_program("LIGGGHTS", "liggghts", "liggghts", script, written, timing)
