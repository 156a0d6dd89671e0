#!/usr/bin/env python3
"""LAMMPS as an engine of crossgrain: `pair_style granular` with Hookean springs."""
import math
import os

import granular
from granular import number, stiffness

SPRING = "hooke %s 0.0 tangential linear_nohistory 0.0 0.0 damping mass_velocity"

# The step of the next dump, which is asked for before a run and again when that dump is written.
NEXT = 'variable next equal "%d + 1000000000*(step >= %d)"'


def script(job, classes, folder):
    """Everything up to the first step."""
    modulus, radii = job.model["law"]["modulus"], classes.radii
    granular.write_data(
        os.path.join(folder, "data"), job, classes, len(classes), lambda radius: 4.0 / 3.0 * math.pi * radius**3
    )
    lines = granular.bed(job, classes, "sphere", "comm_modify vel yes")
    lines.append("pair_style granular")
    for one, radius1 in enumerate(radii):
        for two in range(one, len(radii)):
            spring = SPRING % number(stiffness(modulus, radius1, radii[two]))
            lines.append("pair_coeff %d %d %s" % (one + 1, two + 1, spring))
    for kind in range(len(radii)):
        lines.append("group class_%d type %d" % (kind, kind + 1))
    for index, wall in enumerate(job.model["walls"]):
        axis, place = {"x": "x", "z": "y"}[wall["axis"]], number(wall["place"])
        for kind, radius in enumerate(radii):
            spring = SPRING % number(stiffness(modulus, radius, radius))
            lines.append("fix wall_%d_%d class_%d wall/gran granular %s %splane %s NULL" % (index, kind, kind, spring, axis, place))
    lines += granular.motion(job.model, job.first)
    lines += ["compute between all property/local patom1 patom2 cutoff radius"]
    lines += ["compute pushing all pair/local force cutoff radius"]
    lines += ["dump grains all custom 1 grains.* id x y v_half_x v_half_y"]
    lines += ["dump pairs all local 1 pairs.* c_between[1] c_between[2] c_pushing"]
    lines += [NEXT % (job.first + 1, job.first + 1)]
    lines += ["dump_modify grains every v_next first yes sort id format float %.17g"]
    lines += ["dump_modify pairs every v_next first yes format float %.17g"]
    return lines


def timing(job, classes, folder, k):
    """gran/hooke, and what is asked for after the timed steps."""
    # An old law without history: the leanest that it has.
    law = "hooke %s NULL 0 NULL 0 0" % number(k)
    granular.write_data(os.path.join(folder, "data"), job, classes, 1, lambda radius: 4.0 / 3.0 * math.pi * radius**3)
    lines = ["units si", "dimension 2", "boundary f f p", "atom_style sphere", "newton off", "comm_modify vel yes", "read_data data"]
    lines += ["pair_style gran/" + law, "pair_coeff * *"]
    # The fastest of 0.06 to 0.4 of the radius on the settled bed; the others are within some per cent.
    lines += ["neighbor %s bin" % number(granular.SKIN * classes.radii[0]), "neigh_modify delay 0 every 1 check yes"]
    for index, wall in enumerate(job.model["walls"]):
        axis, place = {"x": "x", "z": "y"}[wall["axis"]], number(wall["place"])
        lines.append("fix wall_%d all wall/gran %s %splane %s NULL" % (index, law, axis, place))
    shown = ["compute between all property/local patom1 patom2 cutoff radius", "compute pushing all pair/local force cutoff radius"]
    shown += ["dump grains all custom 1 grains.* id x y vx vy", "dump pairs all local 1 pairs.* c_between[1] c_between[2] c_pushing"]
    shown += ["dump_modify grains first yes sort id format float %.17g", "dump_modify pairs first yes format float %.17g"]
    return lines, [*shown, "run 0 post no"]


def advance(step, to):
    return ["run 0 post no"] if to == step else [NEXT % (to, to), "run %d pre no post no" % (to - step)]


def look(job, step, folder):
    names = [os.path.join(folder, "%s.%d" % (name, step)) for name in ("grains", "pairs")]
    grains, pairs = map(granular.read_rows, names)
    for name in names:
        os.remove(name)
    forces = [(int(row[0]) - 1, int(row[1]) - 1, float(row[2])) for row in pairs]
    return step, granular.motion_in(job, grains), forces


if __name__ == "__main__":
    granular.serve_program("LAMMPS", "lmp", "lammps", script, advance, look, timing)
