#!/usr/bin/env python3
"""LAMMPS as an engine of crossgrain: `pair_style granular` with Hookean springs, without friction.

Its friction with history is another one than the model's, whatever law.contact says, so there is none here. Of version 29 Sep 2021,
`hooke` with `tangential linear_history`, at the overlap u:

- Slip is (v2 - v1) - R1 w1 x n - R2 w2 x n along the surface. Corrected slip has (R1 + R2)/(R1 + R2 - u) times the difference of the
  velocities, contact point slip has arms shorter by u/2 on the spins: both differ by the share u/2R, some 3e-5 in a bed at rest.
- The tangential spring keeps its length when the normal turns by an angle o in a step; the model's grows by the factor sqrt(1 + o^2).
- `fix wall/gran` has the whole radius as the arm of the torque, where the model has R - u/2 or R - u.
- Arms between grains are R - u/2; the stiffnesses, the Coulomb limit and what a contact does in its first step are the model's.

A trial with friction, spins damped by formulas and no friction at the punch was judged by `engine check --dispersion 0`: in the loose
cloud, pouring and at rest it was 3.3e7, 2.6e7 and 4.7e6 times as far from the native engine as replicas. From a native engine that was
given these three rules it was 1.46, 0.012 and 0.045 times as far: nothing else differs. Without rotation and with contact point slip
the turning alone is left: 2.1e3, 3.7e3 and, at rest, where contacts hardly turn, 0.36 times.

`gran/hooke/history` of the timed beds has the same slip, whole radii as arms everywhere, and projects the spring: it shrinks by cos o.
"""
import math
import os

import granular
from granular import number
from law import refuse, stiffness

SPRING = "hooke %s 0.0 tangential linear_nohistory 0.0 0.0 damping mass_velocity"

# What is asked of pairs of grains. The sum is never looked at: with it in the line of the last step, they can be written.
PAIRS = "c_between[1] c_between[2] c_pushing"
COMPUTES = [
    "compute between all property/local patom1 patom2 cutoff radius",
    "compute pushing all pair/local force cutoff radius",
    "compute known all reduce sum c_between[1] c_pushing",
    "thermo_style custom step c_known[1]",
]


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
    lines += granular.motion(job)
    return lines + COMPUTES


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
    return lines, [*COMPUTES, "run 0 post no", *granular.dumps(PAIRS, "format line", motion)]


if __name__ == "__main__":
    written = granular.dumps(PAIRS, "format line")
    granular.serve_program("LAMMPS", "lmp", "lammps", script, written, timing)
