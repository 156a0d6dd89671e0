#!/usr/bin/env python3
"""LIGGGHTS as an engine of crossgrain: `model hooke/stiffness`, with `tangential history` where there is friction.

Under springs alone the punch is a formula, under other laws a mesh, and a mesh pushes some grains twice: by a face and by the edge of
the next one, where a grain is within that edge by d and deeper than d^2/2R. A disc of 5 mm that is 1 mm within the edge and 0.3 mm deep
is pushed 1.64 times as hard, one of 0.1 mm depth as hard as it should be. So a grain that slides from a corner below the punch is pushed
twice: of 300 grains one by 1753.73 N instead of 876.87 N, and that bed is 2.1e8 times as far from its native one as replicas.

In space each kind of grains is a type of its own, and no grain is pushed twice (`sides`). Of `model hertz` the tangential spring keeps a
displacement (rule `spring_memory`), R* at walls is R (rule `wall_radius`), and both dashpots are of one restitution (rule
`tangential_restitution`).
Refused are a punch that stops with grains at its sides, linear springs of more than 200 kinds of grains, constant dashpots beside Hertz's
springs, and pouring with friction that goes on into loading.
"""
import math
import os

import granular
from exchange import Refused
from granular import number
from law import Solids, dashpot, has_friction, refuse, rotates, stiffness, tangents

MODEL = "model hooke/stiffness tangential off"
TWICE = (
    "under friction or dashpots the punch is a mesh, which also pushes by its side a grain that is within its edge by d and deeper than d²/2R"
)
# Constants of what is switched off; the program asks for them.
NONE = ("kt", "gamman", "gammat", "coefficientFriction")
# Coefficient of rolling friction of two types.
ROLLS = "coefficientRollingFriction"
# How near to Coulomb's limit a spring is that was cut, over the limit or the force along the tangent.
AT_LIMIT = 1.0e-14
# The restitution of Hertz's dashpots, whatever is asked for.
RESTITUTION = 0.3
# What is asked of pairs of grains: their ids and the force.
PAIRS = "c_pushing[1] c_pushing[2] c_pushing[4] c_pushing[5]"
PAIRS_IN_SPACE = PAIRS + " c_pushing[6]"
RULES = {"slip": "contact_point", "slip_at_walls": "half_overlap", "torque_arms": "half_overlap", "torque_arms_at_walls": "half_overlap",
         "spring_turn": "projected", "moment_limit": "spring", "constant_moment": "share_of_spin", "spring_memory": "displacement", "wall_radius": "flat", "tangential_restitution": "as_normal",
         "new_contact": "whole_step"}  # fmt: skip


def around(axes):
    """It works out the forces of pairs when it writes them, and what dashpots do belongs to the velocities of the half step."""
    before = ["fix whole grains store/state 0 " + " ".join("v" + axis for axis in axes)]
    before += ['variable whole_%s atom "f_whole[%d]"' % (axis, at + 1) for at, axis in enumerate(axes)]
    half, whole = (" ".join([*("v_%s_%s" % (of, axis) for axis in axes), "NULL"][:3]) for of in ("half", "whole"))
    return [*before, "velocity grains set %s units box" % half], ["velocity grains set %s units box" % whole, "unfix whole"]


def script(run):
    """Everything up to the first step."""
    job, classes, space = run.job, run.classes, run.space
    law, radii, solids = job.model["law"], classes.radii, Solids(job)
    # Types of the walls and of the punch: a grain touches them with the stiffness of two grains of its radius, or of its materials.
    grains, walls = len(radii), len(radii) + 1
    types = range(len(radii) + 2)
    # Before the grains, as it gives them masses.
    of_materials = of_hertz(job, classes, solids) if space and solids.is_hertz else []
    weighed = (lambda radius: 4.0 / 3.0 * math.pi * radius**3) if space else (lambda radius: math.pi * radius**2)
    granular.write_data(os.path.join(run.folder, "data"), job, classes, len(types), weighed)
    lines = granular.bed(job, classes, "granular", "communicate single vel yes")
    if has_friction(job):
        # A contact that opens keeps its spring until lists of neighbours are made, and has it again if it closes before.
        lines.append("neigh_modify delay 0 every 1 check no")
    lines += of_materials
    rolling = law["contact"].get("rolling") if rotates(job) else None
    tables = {name: [] for name in (["coefficientFriction"] if of_materials else ["kn", *NONE])}
    if rolling:
        tables[ROLLS] = []
    for one, two in ((one, two) for one in types for two in types):
        low, high = min(one, two), max(one, two)
        first, second = min(low, grains - 1), high if high < grains else min(low, grains - 1)
        if space:
            (solid1, *of1), (solid2, *of2) = classes.all[first], classes.all[second]
            solid2 = solid2 if high < grains else 0
            tangent = solids.tangent(solid1, solid2, None if high < grains else ("wall", "punch")[high - grains])
        else:
            of1, of2 = ((radii[of], classes.masses[of]) for of in (first, second))
            k = stiffness(law["modulus"], of1[0], of2[0])
            k_s, tangent = law["stiffness_ratio"] * k, tangents(job)[0 if high < grains else high - grains + 1]
        tables["coefficientFriction"].append(tangent)
        if rolling:
            # It takes R* of two grains, and R at a wall, where the model has the mean of two radii.
            radius1, radius2 = of1[0], of2[0]
            share = 1.0 if high >= grains else 0.5 * (radius1 + radius2) ** 2 / (radius1 * radius2)
            tables[ROLLS].append(rolling["limit"] * share)
        if of_materials:
            continue
        if space:
            k, k_s = solids.springs(solid1, solid2, of1[0], of2[0])
        mass = of1[1] if high >= grains else of1[1] * of2[1] / (of1[1] + of2[1])
        tables["kn"].append(k)
        tables["kt"].append(k_s)
        tables["gamman"].append(dashpot(job, k, mass) / mass)
        tables["gammat"].append(0.0)
    for name, table in tables.items():
        lines.append("fix %s all property/global %s peratomtypepair %d %s" % (name, name, len(types), " ".join(map(number, table))))
    model = "model %s tangential %s" % ("hertz" if of_materials else "hooke/stiffness", "history" if has_friction(job) else "off")
    model += " rolling_friction cdt" * bool(rolling)
    cut = " limitForce on" * (law["contact"]["viscosity"].get("tension") == "clipped")
    lines += ["pair_style gran " + model + cut, "pair_coeff * *"]
    # The program takes it before its first step only, and a job may begin at a later one.
    lines += ["compute pushing all pair/gran/local id force", "thermo_style custom step", "reset_timestep %d" % job.first]
    for index, wall in enumerate(job.model["walls"]):
        place = "primitive type %d %splane %s" % (walls, dict(zip(job.axes, "xyz"))[wall["axis"]], number(wall["place"]))
        lines.append("fix flat_%d %s wall/gran %s %s store_force yes%s" % (index, "grains" if space else "all", model, place, cut))
        run.flat.append((index, *("f_force_flat_%d[%d]" % (index, at + 1) for at in range(len(job.axes)))))
    if job.asked.get("punch") is not None and not run.rich:
        lines += push(job)
    elif job.asked.get("punch") is not None:
        index = len(job.model["walls"])
        block(job, os.path.join(run.folder, "punch.stl"), [0] if space else range(4))
        lines += sides(run, walls + 1, model, cut) if space else []
        lines += [
            "fix block all mesh/surface/stress file punch.stl type %d curvature 1e-5" % (walls + 1),
            "variable still equal 0.0",
            'variable speed equal "v%s[%d]"' % (run.up(), len(job.grains) + 1),
            "fix sinks all move/mesh mesh block linear/variable v_still " + ("v_still v_speed" if space else "v_speed v_still"),
            "fix flat_%d %s wall/gran %s mesh n_meshes 1 meshes block store_force yes%s" % (index, "grains", model, cut),
        ]
        of_mesh = ["f_force_flat_%d[%d]" % (index, at + 1) for at in range(len(job.axes))]
        if space:
            lines += ['variable mesh_%d atom "(1.0 - v_beside)*%s"' % (at, of) for at, of in enumerate(of_mesh)]
            of_mesh = ["v_mesh_%d" % at for at in range(3)]
            lines.append("compute pushed grains reduce sum f_force_flat_left[3] f_force_flat_right[3] v_mesh_2")
            lines.append("thermo_style custom step c_pushed[1] c_pushed[2] c_pushed[3]")
        lines.append('variable force equal "%s"' % ("-c_pushed[1] - c_pushed[2] - c_pushed[3]" if space else "f_block[2]"))
        run.flat.append((index, *of_mesh))
    return lines


def of_hertz(job, kinds, solids):
    """Commands of Hertz's materials: those of the grains' kinds, and the first one for walls and punch. A restitution of 0.3 stands for
    any dashpot, and the program's masses make it the model's."""
    of_types, ratios, e = [solids.all[kind[0]] for kind in kinds.all] + 2 * [solids.all[0]], solids.ratios(), 1.0
    if ratios and ratios[0] > 0.0:
        e = RESTITUTION
        share = math.log(e) / math.hypot(math.pi, math.log(e))
        kinds.weights = [1.2 * (ratios[0] / share) ** 2 * weight for weight in kinds.weights]
    size = len(of_types)
    tables = {"coefficientRestitution": ("peratomtypepair %d" % size, [e] * size**2)}
    for name, key in (("youngsModulus", "modulus"), ("poissonsRatio", "poissons_ratio")):
        tables[name] = "peratomtype", [solid.get(key) or 0.0 for solid in of_types]
    rows = tables.items()
    return ["soft_particles yes", "hard_particles yes", *("fix %s all property/global %s %s %s" % (name, name, kind, " ".join(map(number, values)))
                                                          for name, (kind, values) in rows)]  # fmt: skip


def acted(run, one, two, *force):
    """A row of a pair with the force that acted on the grain `one`. Forces are worked out anew when they are written, and then a spring
    that was cut is at Coulomb's limit, no longer beyond it, so that a dashpot is told that the contact did not have."""
    solids, told = Solids(run.job), (one, two, *force)
    ratios = solids.ratios() if run.space and solids.is_hertz and has_friction(run.job) else None
    if not ratios:
        return told
    grains = [dict(run.job.grains[at], **dict(zip(run.job.names, run.motion[at]))) for at in (one, two)]
    vector = lambda grain, names: [grain.get(name, 0.0) for name in names]
    places, (radii, masses) = [vector(grain, "xyz") for grain in grains], zip(*((grain["radius"], grain["mass"]) for grain in grains))
    away = [there - here for here, there in zip(*places)]
    distance = math.hypot(*away)
    normal, overlap = [along / distance for along in away], sum(radii) - distance
    if overlap <= 0.0:
        return told
    speeds = []
    for grain, arm in zip(grains, (radii[0] - 0.5 * overlap, 0.5 * overlap - radii[1])):
        (a, b, c), (u, v, w) = vector(grain, ("spin_x", "spin", "spin_z")), (arm * part for part in normal)
        turn = (b * w - c * v, c * u - a * w, a * v - b * u)
        speeds.append([one + other for one, other in zip(vector(grain, ("vx", "vy", "vz")), turn)])
    _, slip = granular.along(normal, [there - here for here, there in zip(*speeds)])
    push, sticking = granular.along(normal, force)
    materials = [run.classes.all[run.classes.of[at]][0] for at in (one, two)]
    k_s = solids.springs(*materials)[1] * math.sqrt(radii[0] * radii[1] / sum(radii) * overlap)
    c_s = 2.0 * ratios[0] * math.sqrt(masses[0] * masses[1] / sum(masses) * k_s)
    spring = [part - c_s * speed for part, speed in zip(sticking, slip)]
    limit = abs(push) * solids.tangent(*materials)
    # The overlap is a small difference of lengths: its rounding is theirs.
    rounding = AT_LIMIT * (1.0 + distance / overlap)
    if abs(math.hypot(*spring) - limit) > rounding * max(limit, math.hypot(*sticking)):
        return told
    return (one, two, *(push * along + across for along, across in zip(normal, spring)))


def push(job):
    """Commands of the punch under springs alone: its force on each grain by its law, a formula of the grain's place.

    Across the plane there are no forces, so that component keeps first the grain's distance from the punch (below 0
    inside), which the formulas would else work out many times over, and then the force upwards, for its sum.
    """
    punch, count = job.asked["punch"], len(job.grains)
    commands = ["compute radius all property/atom radius", 'variable force equal "-f_damp[3]"']
    places = (number(punch["centre"][0]), "y[%d]" % (count + 1))
    for axis, place, half in zip("xy", places, map(number, punch["half_extents"])):
        commands += [
            'variable from_%s atom "%s - (%s)"' % (axis, axis, place),
            'variable past_%s atom "abs(v_from_%s) - %s"' % (axis, axis, half),
            'variable out_%s atom "v_past_%s*(v_past_%s > 0.0)"' % (axis, axis, axis),
        ]
    # Which face is nearest for a grain inside: 1 across, 0 up.
    commands.append('variable across atom "v_past_x >= v_past_y"')
    commands.append(
        'variable apart atom "sqrt(v_out_x*v_out_x + v_out_y*v_out_y)'
        ' + (v_past_x <= 0.0)*(v_past_y <= 0.0)*(v_across*v_past_x + (1.0 - v_across)*v_past_y)"'
    )
    # Outside the force over the distance, which makes a unit vector of `out`; inside the force.
    modulus = number(job.model["law"]["modulus"])
    commands.append('variable strength atom "(fz < c_radius)*%s*c_radius*(c_radius - fz)/(fz + (fz <= 0.0)*(1.0 - fz))"' % modulus)
    for axis, here in zip("xy", ("v_across", "(1.0 - v_across)")):
        commands.append(
            'variable push_%s atom "v_strength*((v_from_%s > 0.0) - (v_from_%s <= 0.0))*(v_out_%s + (fz <= 0.0)*%s)"'
            % (axis, axis, axis, axis, here)
        )
    return commands + [
        "fix apart grains setforce NULL NULL v_apart",
        "fix push grains addforce v_push_x v_push_y 0.0",
        "fix told grains setforce NULL NULL v_push_y",
    ]


def sides(run, kind, model, cut):
    """Commands of the punch's sides in space: walls for grains whose centres are beside it and above its bottom. The bottom, a mesh, acts
    on all grains, whatever the group, so what its edges do to these is taken off again. A grain that comes from below is pushed anew."""
    job, count, index = run.job, len(run.job.grains), len(run.job.model["walls"])
    punch, dt = job.asked["punch"], job.model["dt"]
    (x, _), (across, up) = punch["centre"], punch["half_extents"]
    run.watch = lambda: refuse_at_sides(run)
    # Groups are by where a grain and the punch are after the next step; the very first one moves nothing.
    lines = ["neigh_modify delay 0 every 1 check no", 'variable ahead equal "%s*(step > %d)"' % (number(dt), job.first)]
    next_place = ("z[%d]" % (count + 1), "vz[%d]" % (count + 1), number(up))
    lines.append('variable above atom "z - (%s - %s)"' % next_place[::2])
    lines.append('variable next atom "z + v_ahead*(vz + %s*fz/mass) - (%s + v_ahead*%s - %s)"' % (number(0.5 * dt), *next_place))
    for name, sign, place in (("left", "<", x - across), ("right", ">", x + across)):
        lines.append('variable %s atom "(v_next >= 0.0)*(x %s %s)"' % (name, sign, number(x)))
        run.each += ["group %s subtract all all" % name, "group %s variable %s" % (name, name)]
        lines += run.each[-2:]
        wall = "primitive type %d xplane %s shear z %s" % (kind, number(place), number(punch["velocity"]))
        lines.append("fix flat_%s %s wall/gran %s %s store_force yes%s" % (name, name, model, wall, cut))
        run.flat.append((index, *("f_force_flat_%s[%d]" % (name, at + 1) for at in range(3))))
    edge = [of["radius"] for of in job.grains]
    lines += [granular.of_atoms(run.folder, "radius", [*edge, edge[0]]), 'variable beside atom "v_above >= 0.0"']
    lines.append('variable out atom "x - %s - %s*((x > %s) - (x < %s))"' % (*map(number, (x, across, x, x)),))
    lines.append('variable away atom "sqrt(v_out*v_out + v_above*v_above)"')
    lines.append('variable arm atom "v_beside*0.5*(v_radius + v_away)/v_away"')
    of_mesh = ["f_force_flat_%d[%d]" % (index, at + 1) for at in range(3)]
    run.pushed = [" - v_beside*" + of for of in of_mesh]
    torques = ("-v_above*%s" % of_mesh[1], "v_above*%s - v_out*%s" % (of_mesh[0], of_mesh[2]), "v_out*" + of_mesh[1])
    run.twisted = [" + v_arm*(%s)" % of for of in torques]
    return lines


def refuse_at_sides(run):
    """Sides go on with the velocity that they were given when the punch stops, which no grain may feel."""
    punch, (middle, _, height) = run.job.asked["punch"], run.places[-1]
    across, up = punch["half_extents"]
    for (x, _, z), grain in zip(run.places, run.job.grains):
        near = granular.SKIN * grain["radius"]
        if z >= height - up - near and abs(x - middle) - across < grain["radius"] + near:
            raise Refused("a punch in space that stops with grains at its sides, which have one velocity")


def block(job, path, faces):
    """These faces of the punch as triangles, where it was a step before the first one."""
    punch, deep = job.asked["punch"], 1.1 * max(grain["radius"] for grain in job.grains)
    low, high, plane = -deep, deep, job.axes == "xz"
    if not plane:
        sides = [of["y"] for of in job.grains] + [wall["place"] for wall in job.model["walls"] if wall["axis"] == "y"]
        low, high = min(sides) - deep, max(sides) + deep
    (x, z), (across, up) = punch["centre"], punch["half_extents"]
    z -= punch["velocity"] * job.model["dt"]
    around = [(x - across, z - up), (x + across, z - up), (x + across, z + up), (x - across, z + up)]
    triangles = []
    for one, two in ((around[at], around[(at + 1) % 4]) for at in faces):
        front, back = ([(*of, at) if plane else (of[0], at, of[1]) for of in (one, two)] for at in (low, high))
        triangles += [(front[0], front[1], back[1]), (front[0], back[1], back[0])]
    with open(path, "w", encoding="utf-8") as file:
        file.write("solid punch\n")
        for corners in triangles:
            file.write("facet normal 0 0 0\nouter loop\n")
            file.writelines("vertex %s %s %s\n" % tuple(map(number, corner)) for corner in corners)
            file.write("endloop\nendfacet\n")
        file.write("endsolid punch\n")


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
    turn = "set group grains omegaz v_spin", "set group grains omegax v_spin_x omegay v_spin_y omegaz v_spin_z"
    words = granular.Words("liggghts", script, (PAIRS, PAIRS, PAIRS_IN_SPACE), "format", turn, around, mended=acted)
    granular.serve_program("LIGGGHTS", "liggghts", words, RULES, timing, [TWICE], parts=["hertz_mindlin", "constant_moments"])
