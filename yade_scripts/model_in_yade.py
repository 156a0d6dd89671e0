"""What the scripts share: a crossgrain model (bodies, contact law, engines) in YADE, and the tables of the protocol.

The plane is YADE's x-z plane. The model is that of `src/model.rs`, as JSON.
"""
import csv
import gc
import json
import math
import os
import sys
import time
from array import array

from yadeimport import *  # noqa: F403  starts YADE without any listening socket
from yade import config, utils  # noqa: E402

# Half-extent of the punch across the plane, m: so large that this face never is the nearest.
PUNCH_HALF_DEPTH = 10.0
# verletDist of a case over its smallest radius; in sorted mode the bits do not depend on it.
VERLET_OVER_RADIUS = 0.1

gc.disable()  # nothing here is in a circle; looking for circles takes a quarter of the time of a moment

GREY = (0.7, 0.7, 0.7)  # without a colour, YADE reseeds Python's random numbers

folder = os.environ.get("CROSSGRAIN_JOB", os.getcwd())
# Named by whoever started it, who may be gone before this line is reached.
parent = int(os.environ.get("CROSSGRAIN_PARENT", os.getppid()))


def place(name):
    return os.path.join(folder, name)


def read_json(name):
    with open(place(name), encoding="utf-8") as file:
        return json.load(file)


def write_json(name, value):
    aside = place(name + ".part")
    with open(aside, "w", encoding="utf-8") as file:
        json.dump(value, file)
    os.replace(aside, place(name))


def read_grains(name="initial.csv"):
    """The grains of a table as dictionaries of floats."""
    with open(place(name), encoding="utf-8", newline="") as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def case_in_yade(name, settings=None):
    """The job of the case in this folder, and its model in an empty YADE scene, forces at the start evaluated."""
    O.reset()
    job = read_json(os.path.join(name, "job.json"))
    grains = read_grains(os.path.join(name, "initial.csv"))
    if settings is None or settings["sorted"]:
        order = (True, VERLET_OVER_RADIUS * min(grain["radius"] for grain in grains))
    else:
        order = (False, settings["verlet_distance"])
    model = ModelInYade(job["model"], grains, *order)
    if job["punch"] is not None:
        punch = job["punch"]
        model.add_punch(punch["centre"], punch["half_extents"], punch["velocity"], punch["start"])
    return job, grains, model


def dashpot(law):
    viscosity = law["contact"]["viscosity"]
    return viscosity["c_n"] if viscosity["kind"] == "dashpot" else None


def compliances_in_series(a, b):
    """The stiffness of two springs, or the constant of two dashpots, one behind the other."""
    return 1.0 / (1.0 / a + 1.0 / b)


def friction_angles(law):
    """Between grains, at walls, at the punch."""
    own = (law.get(place + "_friction_angle") for place in ("wall", "punch"))
    return [law["friction_angle"]] + [law["friction_angle"] if angle is None else angle for angle in own]


def rotates(law):
    return max(friction_angles(law)) > 0.0 and law["contact"]["rotation"] == "free"


class ModelInYade:
    """Bodies and engines of a model in an empty YADE scene, `grains` as dictionaries of floats."""

    def __init__(self, model, grains, sorted, verlet_distance):
        self.law = model["law"]
        # Whether grains rotate in any stage.
        self.rotates = "inertia" in grains[0]
        self.radii = [grain["radius"] for grain in grains]
        # Of grains, walls and punch: alike but for what touches them.
        self.materials = [self._material() for _ in range(3)]
        O.materials.append(self.materials)
        self.grains = len(grains)
        self.states = [self._add_grain(grain) for grain in grains]
        self.masses = [grain["mass"] for grain in grains]
        self.inertias = [grain["inertia"] for grain in grains] if self.rotates else []
        for wall in model["walls"]:
            axis = {"x": 0, "z": 2}[wall["axis"]]
            position = Vector3(0, 0, 0)
            position[axis] = wall["place"]
            O.bodies.append(
                utils.wall(position, axis=axis, sense=0, material=self.materials[1], color=GREY)
            )
        # Of the first grain, the first wall, and the punch.
        self.first_ids = [0, self.grains, self.grains + len(model["walls"])]
        self.punch = None
        gravity = model["gravity"]
        # Integration stands first, so that after each step forces and contacts belong to the positions.
        self.newton = NewtonIntegrator(
            gravity=(gravity[0], 0.0, gravity[1]),
            damping=model["alpha"],
            dampGravity=True,
            warnNoForceReset=False,
        )
        O.engines = [
            self.newton,
            ForceResetter(),
            InsertionSortCollider(
                [Bo1_Sphere_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb()],
                verletDist=verlet_distance,
            ),
            self._interaction_loop(sorted),
        ]
        O.dt = model["dt"]

    def _material(self):
        law = self.law
        common = {
            "young": law["modulus"],
            "poisson": law["stiffness_ratio"],
            "frictionAngle": law["friction_angle"],
            "density": 1.0,  # masses are set grain by grain
        }
        c_n = dashpot(law)
        if c_n is None:
            return FrictMat(**common)
        # Two dashpots act in series.
        return ViscElMat(cn=2.0 * c_n, cs=0.0, **common)

    def _interaction_loop(self, sorted):
        self.grain_geometry = Ig2_Sphere_Sphere_ScGeom()
        self.wall_geometry = Ig2_Wall_Sphere_ScGeom()
        geometries = [self.grain_geometry, self.wall_geometry, Ig2_Box_Sphere_ScGeom()]
        if dashpot(self.law) is None:
            self.physics = Ip2_FrictMat_FrictMat_FrictPhys()
            self.contact_law = Law2_ScGeom_FrictPhys_CundallStrack()
        else:
            self.physics = Ip2_ViscElMat_ViscElMat_ViscElPhys()
            self.contact_law = Law2_ScGeom_ViscElPhys_Basic()
        self._choose()
        return InteractionLoop(
            geometries, [self.physics], [self.contact_law], loopOnSortedInteractions=sorted
        )

    def _choose(self):
        """What the contact law leaves open, and whether grains rotate."""
        contact = self.law["contact"]
        corrected = contact["slip_velocity"] == "ratcheting_corrected"
        self.grain_geometry.avoidGranularRatcheting = corrected
        self.wall_geometry.noRatch = corrected
        if dashpot(self.law) is None:
            self.contact_law.sphericalBodies = contact["torque_arms"] == "half_overlap"
            # By default the smaller angle of two materials holds.
            angles = zip(self.materials, friction_angles(self.law))
            matches = [(self.materials[0].id, other.id, angle) for other, angle in angles]
            self.physics.frictAngle = MatchMaker(matches=matches)
        for state in self.states:
            state.blockedDOFs = "yXZ" if rotates(self.law) else "yXYZ"

    def change(self, model):
        """Go on with the constants of another model; contacts keep their shear forces."""
        if not rotates(self.law):
            # Normal forces have torques, of rounding, that nothing has felt so far.
            for grain in range(self.grains):
                O.forces.addT(grain, -O.forces.t(grain))
        self.law = model["law"]
        self.newton.damping = model["alpha"]
        new, c_n = self._material(), dashpot(self.law)
        for material in self.materials:
            material.young, material.poisson, material.frictionAngle = new.young, new.poisson, new.frictionAngle
            if c_n is not None:
                material.cn = new.cn
        self._choose()
        tangents = [math.tan(angle) for angle in friction_angles(self.law)]
        for contact in self.real_contacts():
            # A flat body counts as a grain of the same radius.
            radii = [self.radii[of if of < self.grains else contact.id2] for of in (contact.id1, contact.id2)]
            kind = next(kind for kind in (2, 1, 0) if max(contact.id1, contact.id2) >= self.first_ids[kind])
            normal = [self.law["modulus"] * radius for radius in radii]
            tangential = [of * self.law["stiffness_ratio"] for of in normal]
            physics = contact.phys
            physics.kn, physics.ks = self._in_series(*normal), self._in_series(*tangential)
            physics.tangensOfFrictionAngle = tangents[kind]
            if c_n is not None:
                physics.cn = compliances_in_series(2.0 * c_n, 2.0 * c_n)

    def _in_series(self, a, b):
        """The law with dashpots adds compliances, which rounds in another way."""
        if dashpot(self.law) is None:
            return 2.0 * a * b / (a + b)
        return compliances_in_series(2.0 * a, 2.0 * b)

    def _add_grain(self, grain):
        body = utils.sphere(
            (grain["x"], 0.0, grain["z"]), grain["radius"], material=self.materials[0], color=GREY
        )
        state = body.state
        state.mass = grain["mass"]
        state.vel = (grain["vx"], 0.0, grain["vz"])
        if self.rotates:
            inertia = grain["inertia"]
            state.inertia = (inertia, inertia, inertia)
            state.angVel = (0.0, grain["spin"], 0.0)
        O.bodies.append(body)
        return state

    def add_punch(self, centre, half_extents, velocity, start):
        body = utils.box(
            (centre[0], 0.0, centre[1]),
            (half_extents[0], PUNCH_HALF_DEPTH, half_extents[1]),
            fixed=True,
            material=self.materials[2],
            color=GREY,
        )
        body.state.blockedDOFs = "xyzXYZ"
        body.state.vel = (0.0, 0.0, velocity)
        self.punch = {"id": O.bodies.append(body), "state": body.state, "start": start}

    def evaluate_at_start(self):
        """Evaluate the forces at the start without moving anything."""
        self.newton.dead = True
        O.step()
        self.newton.dead = False

    def kinetic_energy(self):
        energy = 0.0
        for mass, state in zip(self.masses, self.states):
            v = state.vel
            energy += 0.5 * mass * (v[0] * v[0] + v[2] * v[2])
        for inertia, state in zip(self.inertias, self.states):
            spin = state.angVel[1]
            energy += 0.5 * inertia * (spin * spin)
        return energy

    def real_contacts(self):
        return [contact for contact in O.interactions if contact.isReal]


class Tables:
    """`tables.bin` and `moments.jsonl` in this folder of the job: the moments of a run."""

    def __init__(self, name=""):
        self.binary = open(place(os.path.join(name, "tables.bin")), "wb")
        self.index = open(place(os.path.join(name, "moments.jsonl")), "w", encoding="utf-8")

    def line(self, value):
        self.index.write(json.dumps(value) + "\n")
        self.index.flush()

    def moment(self, model, stage, step, **more):
        """Write the present moment."""
        positions = [state.pos for state in model.states]
        velocities = [state.vel for state in model.states]
        table = array("d")
        for column, axis in ((positions, 0), (positions, 2), (velocities, 0), (velocities, 2)):
            table.extend([float(vector[axis]) for vector in column])
        if model.rotates:
            table.extend([float(state.angVel[1]) for state in model.states])
        contacts = sorted(model.real_contacts(), key=lambda contact: (contact.id1, contact.id2))
        for contact in contacts:
            geometry, physics = contact.geom, contact.phys
            normal, point = geometry.normal, geometry.contactPoint
            force = physics.normalForce + physics.shearForce
            nx, nz, fx, fz = float(normal[0]), float(normal[2]), float(force[0]), float(force[2])
            forces = fx * nx + fz * nz, fz * nx - fx * nz
            place = float(point[0]), float(point[2])
            table.extend((contact.id1, contact.id2, float(geometry.penetrationDepth), *forces, nx, nz, *place))
        if sys.byteorder == "big":
            table.byteswap()
        table.tofile(self.binary)
        self.binary.flush()
        out_of_plane = max(abs(p[1]) + abs(v[1]) for p, v in zip(positions, velocities))
        at = None
        if model.punch is not None:
            where = model.punch["state"].pos
            at = {
                "centre": [float(where[0]), float(where[2])],
                "start": model.punch["start"],
                "velocity": float(model.punch["state"].vel[2]),
                "force": float(O.forces.f(model.punch["id"])[2]),
            }
        moment = {"stage": stage, "step": step, "punch": at, "contacts": len(contacts)}
        self.line(dict(moment, out_of_plane=float(out_of_plane), **more))

    def close(self):
        self.binary.close()
        self.index.close()


def beat(stage, step, share):
    """A sign of life, and how far the run is."""
    if os.getppid() != parent:
        os._exit(1)  # whoever asked for this run is gone
    print("%s %d %.4f" % (stage, step, share), flush=True)


def say_hello():
    write_json("hello.json", {"version": str(config.version), "python": sys.version.split()[0]})


def one_after_the_other(count):
    """Go on as the process of each of so many jobs, in the folders 0, 1, … of this one: starting YADE takes longer than most jobs."""
    global folder, parent
    above, parent = parent, os.getpid()
    for job in range(count):
        child = os.fork()
        if child == 0:
            folder = place(str(job))
            return
        done, status = 0, 0
        while done == 0:
            if os.getppid() != above:
                os._exit(1)
            time.sleep(0.005)
            done, status = os.waitpid(child, os.WNOHANG)
        if status != 0:
            os._exit(1)
    os._exit(0)


if "CROSSGRAIN_JOBS" in os.environ:
    say_hello()
    one_after_the_other(int(os.environ["CROSSGRAIN_JOBS"]))
