"""The model's law as an adapter needs it: what touches at given places, and which laws a program without friction refuses."""
import math

from exchange import Refused


def stiffness(modulus, radius1, radius2):
    a, b = modulus * radius1, modulus * radius2
    return 2.0 * a * b / (a + b)


def refuse(job, has_friction=False):
    law = job.model["law"]
    if law["friction_angle"] > 0.0 and not has_friction:
        raise Refused("friction")
    if any(law.get(place) is not None for place in ("wall_friction_angle", "punch_friction_angle")):
        raise Refused("friction of its own at walls or punch")
    if law["contact"]["viscosity"]["kind"] != "none":
        raise Refused("dashpots")


def pair_contacts(job, between, places):
    """Rows of grains that touch; `between` is the stiffness of two grains, by their numbers."""
    grains, rows, cells = job.grains, [], {}
    size = 2.0 * max(grain["radius"] for grain in grains)
    for two, (x, z) in enumerate(places):
        across, up = math.floor(x / size), math.floor(z / size)
        for one in (one for i in (-1, 0, 1) for k in (-1, 0, 1) for one in cells.get((across + i, up + k), ())):
            dx, dz = x - places[one][0], z - places[one][1]
            distance, radius = math.sqrt(dx * dx + dz * dz), grains[one]["radius"]
            overlap = radius + grains[two]["radius"] - distance
            if overlap >= 0.0:
                normal, arm = (dx / distance, dz / distance), radius - 0.5 * overlap
                point = [place + arm * of for place, of in zip(places[one], normal)]
                rows.append((one, two, overlap, between(one, two) * overlap, 0.0, *normal, *point))
        cells.setdefault((across, up), []).append(two)
    return rows


def wall_contacts(job, curvature, places):
    """Rows of what touches a wall, which counts as a grain of this curvature, by the number of the grain."""
    rows, grains = [], job.grains
    for index, wall in enumerate(job.model["walls"]):
        axis = "xz".index(wall["axis"])
        for grain, place in enumerate(places):
            distance = place[axis] - wall["place"]
            overlap = grains[grain]["radius"] - abs(distance)
            if overlap < 0.0:
                continue
            normal, point = [0.0, 0.0], list(place)
            normal[axis], point[axis] = math.copysign(1.0, distance), wall["place"]
            force = stiffness(job.model["law"]["modulus"], curvature(grain), curvature(grain)) * overlap
            rows.append((len(grains) + index, grain, overlap, force, 0.0, *normal, *point))
    return rows


def punch_contacts(job, centre, places):
    """Rows of what touches the punch, by the law whose formulas `push` gives to the program."""
    rows, punch = [], len(job.grains) + len(job.model["walls"])
    for grain, place in enumerate(places):
        radius = job.grains[grain]["radius"]
        away = [here - there for here, there in zip(place, centre)]
        past = [abs(of) - half for of, half in zip(away, job.asked["punch"]["half_extents"])]
        nearest = 0 if past[0] >= past[1] else 1
        if past[nearest] <= 0.0:
            apart, share = past[nearest], [1.0 - nearest, float(nearest)]
        else:
            out = [max(of, 0.0) for of in past]
            apart = math.hypot(*out)
            share = [of / apart for of in out]
        overlap = radius - apart
        if overlap < 0.0:
            continue
        normal = [of if here > 0.0 else -of for of, here in zip(share, away)]
        # In the middle between the punch's nearest point and the grain's deepest one.
        point = [here - 0.5 * (apart + radius) * of for here, of in zip(place, normal)]
        force = stiffness(job.model["law"]["modulus"], radius, radius) * overlap
        rows.append((punch, grain, overlap, force, 0.0, *normal, *point))
    return rows
