"""The model's law as an adapter needs it: what touches at given places, and which laws a program without friction refuses."""
import itertools
import math

from exchange import Refused

THORNTON = (-6.918798, -16.41105, 146.8049, -796.4559, 2928.711, -7206.864, 11494.29, -11342.18, 6276.757, -1489.915)


def stiffness(modulus, radius1, radius2):
    a, b = modulus * radius1, modulus * radius2
    return 2.0 * a * b / (a + b)


def has_friction(job):
    """Whether contacts bear tangential forces."""
    return max(*tangents(job), *(of["friction_angle"] for of in job.model["law"].get("materials", []))) > 0.0


def tangents(job):
    """tan φ between grains, at walls and at the punch."""
    law = job.model["law"]
    angles = [law.get(place) for place in ("friction_angle", "wall_friction_angle", "punch_friction_angle")]
    return [math.tan(angles[0] if angle is None else angle) for angle in angles]


class Solids:
    """Laws in space between grains of several materials; what a grain meets at walls and punch is of the first one and its own radius."""

    def __init__(self, job):
        self.law = job.model["law"]
        self.all = [self.law, *self.law.get("materials", [])]
        self.is_hertz = self.law["contact"].get("springs") == "hertz_mindlin"

    def springs(self, one, two, radius1=None, radius2=None):
        """k_n and k_s of materials and radii; of Hertz's what √R* u^1.5 and √(R* u) are multiplied by."""
        a, b = self.all[one], self.all[two]
        if self.is_hertz:
            (e1, v1), (e2, v2) = ((of["modulus"], of.get("poissons_ratio") or 0.0) for of in (a, b))
            plane = e1 * e2 / ((1.0 - v1 * v1) * e2 + (1.0 - v2 * v2) * e1)
            shear = 1.0 / (2.0 * (2.0 - v1) * (1.0 + v1) / e1 + 2.0 * (2.0 - v2) * (1.0 + v2) / e2)
            return 4.0 / 3.0 * plane, 8.0 * shear
        of = [(solid["modulus"] * radius, solid["stiffness_ratio"]) for solid, radius in ((a, radius1), (b, radius2))]
        return stiffness(1.0, of[0][0], of[1][0]), stiffness(1.0, of[0][0] * of[0][1], of[1][0] * of[1][1])

    def tangent(self, one, two, place=None):
        """tan φ of two materials, or of one at `walls` or `punch`."""
        own = self.law.get("%s_friction_angle" % place)
        return math.tan(min(self.all[one]["friction_angle"], self.all[two]["friction_angle"]) if own is None else own)

    def ratios(self):
        """β of Hertz's dashpots, along the normal and the tangent, or none."""
        viscosity, beside = self.law["contact"]["viscosity"], self.law["contact"].get("tangential_viscosity")
        if viscosity["kind"] == "none":
            return None
        if viscosity["kind"] == "dashpot":
            raise Refused("a constant dashpot beside Hertz's springs")
        if viscosity["kind"] == "ratio":
            return viscosity["ratio"], viscosity["ratio"] if beside is None else beside
        return [hertz_ratio(e, viscosity["tension"]) for e in (viscosity["e_n"], viscosity["e_n"] if beside is None else beside)]


def hertz_ratio(e, tension):
    """β of a restitution; where the dashpot may not pull that of Thornton et al. (2013)."""
    if tension == "unclipped":
        return math.sqrt(5.0 / 6.0) * -math.log(e) / math.hypot(math.pi, math.log(e))
    power = 0.0
    for of in reversed(THORNTON):
        power = e * (of + power)
    return math.sqrt(1.0 / (1.0 - (1.0 + e) ** 2 * math.exp(power)) - 1.0)


def rotates(job):
    return has_friction(job) and job.model["law"]["contact"]["rotation"] == "free"


def dashpot(job, k, mass):
    """c_n of a contact of this stiffness and effective mass."""
    viscosity = job.model["law"]["contact"]["viscosity"]
    if viscosity["kind"] == "restitution":
        return 2.0 * damping_ratio(viscosity) * math.sqrt(mass * k)
    return viscosity.get("c_n", 0.0)


def damping_ratio(viscosity):
    """ζ of a restitution. Where the dashpot may not pull, the grains part as soon as the force is zero (Schwager and Pöschel 2007)."""
    e = viscosity["e_n"]
    low = -math.log(e) / math.hypot(math.pi, math.log(e))
    if viscosity["tension"] == "unclipped" or e == 1.0:
        return low
    high = 1.0
    while clipped_restitution(high) > e:
        low, high = high, 2.0 * high
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if clipped_restitution(middle) > e else (low, middle)
    return 0.5 * (low + high)


def clipped_restitution(ratio):
    off = 1.0 - ratio * ratio
    if abs(off) < 1.0e-12:
        return math.exp(-2.0)
    s = math.sqrt(abs(off))
    angle = math.pi - math.atan2(2.0 * ratio * s, 1.0 - 2.0 * ratio * ratio) if off > 0.0 else 2.0 * math.log(ratio + s)
    return math.exp(-(ratio / s) * angle)


def refuse(job, has_friction=False):
    law = job.model["law"]
    if law["friction_angle"] > 0.0 and not has_friction:
        raise Refused("friction")
    if any(law.get(place) is not None for place in ("wall_friction_angle", "punch_friction_angle")):
        raise Refused("friction of its own at walls or punch")
    if law["contact"]["viscosity"]["kind"] != "none":
        raise Refused("dashpots")


def refuse_inside(job):
    """Faces that push from outside alone."""
    punch = job.asked.get("punch")
    if punch is None:
        return
    for grain in job.grains:
        away = (abs(grain[axis] - centre) for axis, centre in zip("xz", punch["centre"]))
        if all(of <= half for of, half in zip(away, punch["half_extents"])):
            raise Refused("the centre of a grain inside the punch")


def elastic(job):
    """The force of an overlap of two grains, by their numbers, or of one at a flat wall, where the other is none."""
    solids, law, grains = Solids(job), job.model["law"], job.grains

    def push(one, two, overlap):
        radius1, radius2 = (grains[at]["radius"] for at in (one, one if two is None else two))
        if not solids.is_hertz:
            return stiffness(law["modulus"], radius1, radius2) * overlap
        radius = radius1 if two is None else radius1 * radius2 / (radius1 + radius2)
        return solids.springs(0, 0)[0] * math.sqrt(radius) * overlap**1.5

    return push


def pair_contacts(job, push, places):
    """Rows of grains that touch; `push` is the force of two grains, by their numbers, and their overlap."""
    grains, rows, cells = job.grains, [], {}
    size, around = 2.0 * max(grain["radius"] for grain in grains), list(itertools.product((-1, 0, 1), repeat=len(job.axes)))
    for two, place in enumerate(places):
        cell = tuple(math.floor(along / size) for along in place)
        near = (tuple(at + step for at, step in zip(cell, steps)) for steps in around)
        for one in (one for other in near for one in cells.get(other, ())):
            away = [there - here for here, there in zip(places[one], place)]
            distance, radius = math.sqrt(sum(along * along for along in away)), grains[one]["radius"]
            overlap = radius + grains[two]["radius"] - distance
            if overlap >= 0.0:
                normal, arm = [along / distance for along in away], radius - 0.5 * overlap
                point = [here + arm * along for here, along in zip(places[one], normal)]
                rows.append((one, two, overlap, push(one, two, overlap), no_shear(job), *normal, *point))
        cells.setdefault(cell, []).append(two)
    return rows


def no_shear(job):
    return 0.0 if job.axes == "xz" else (0.0, 0.0, 0.0)


def wall_contacts(job, curvature, places, push=None):
    """Rows of what touches a wall, which counts as a grain of this curvature, by the number of the grain, or pushes by this law."""
    rows, grains = [], job.grains
    for index, wall in enumerate(job.model["walls"]):
        axis = job.axes.index(wall["axis"])
        for grain, place in enumerate(places):
            distance = place[axis] - wall["place"]
            overlap = grains[grain]["radius"] - abs(distance)
            if overlap < 0.0:
                continue
            normal, point = [0.0] * len(place), list(place)
            normal[axis], point[axis] = math.copysign(1.0, distance), wall["place"]
            force = push(grain, None, overlap) if push else stiffness(job.model["law"]["modulus"], *2 * [curvature(grain)]) * overlap
            rows.append((len(grains) + index, grain, overlap, force, no_shear(job), *normal, *point))
    return rows


def punch_contacts(job, centre, places, push=None):
    """Rows of what touches the punch, by the law whose formulas `push` gives to the program, or by this one; of `places` the height is the
    last."""
    rows, punch = [], len(job.grains) + len(job.model["walls"])
    for grain, whole in enumerate(places):
        place = (whole[0], whole[-1])
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
        force = push(grain, None, overlap) if push else stiffness(job.model["law"]["modulus"], radius, radius) * overlap
        if job.axes == "xyz":
            normal, point = (normal[0], 0.0, normal[1]), (point[0], whole[1], point[1])
        rows.append((punch, grain, overlap, force, no_shear(job), *normal, *point))
    return rows
