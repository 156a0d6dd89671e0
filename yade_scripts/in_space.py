"""Do a job of the engine protocol in YADE whose grains are in space: as the script of its kind, with other bodies, laws and tables.

Fixed text. Bodies are made in this order: grains, walls, triangles and boxes, and the punch. Hertz's springs are
`Law2_ScGeom_MindlinPhys_Mindlin`, whose `poisson` is Poisson's ratio; for linear ones it is k_s/k_n.
"""
import importlib
import math
import sys
from array import array

import model_in_yade
from model_in_yade import GREY, ModelInYade, read_json
from yadeimport import *  # noqa: F403
from yade import utils  # noqa: E402

AXES = {"x": 0, "y": 1, "z": 2}


def dot(a, b):
    return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2])


def numbers(vector):
    return [float(part) for part in vector]


class ModelInSpace(ModelInYade):
    def __init__(self, model, grains, sorted, verlet_distance):
        self.law = model["law"]
        self.hertz = self.law["contact"].get("springs") == "hertz_mindlin"
        self.rotates = "inertia" in grains[0]
        self.radii = [grain["radius"] for grain in grains]
        # Of grains, walls and punch, and what grains of material 1, 2, … are made of.
        further = [self._material_of(solid) for solid in self.law.get("materials", [])]
        self.materials = [self._material_of(self.law) for _ in range(3)]
        O.materials.append(self.materials + further)
        self.of_grains = self.materials[:1] + further
        self.grains = len(grains)
        self.states = [self._add_grain(grain) for grain in grains]
        self.masses = [grain["mass"] for grain in grains]
        self.inertias = [grain["inertia"] for grain in grains] if self.rotates else []
        for wall in model["walls"]:
            axis = AXES[wall["axis"]]
            position = Vector3(0, 0, 0)
            position[axis] = wall["place"]
            O.bodies.append(utils.wall(position, axis=axis, sense=0, material=self.materials[1], color=GREY))
        obstacles = model.get("obstacles", [])
        for obstacle in obstacles:
            self._add_obstacle(obstacle)
        if any(any(obstacle.get("spin", [])) for obstacle in obstacles):
            # A body that only turns does not make YADE look for neighbours anew, so it looks in every step.
            verlet_distance = 0.0
        self.first_ids = [0, self.grains, self.grains + len(model["walls"]) + len(obstacles)]
        self.punch = None
        gravity = model["gravity"]
        self.newton = NewtonIntegrator(
            gravity=(gravity[0], 0.0, gravity[1]), damping=model["alpha"], dampGravity=True, warnNoForceReset=False
        )
        O.engines = [
            self.newton,
            ForceResetter(),
            InsertionSortCollider(
                [Bo1_Sphere_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb(), Bo1_Facet_Aabb()], verletDist=verlet_distance
            ),
            self._interaction_loop(sorted),
        ]
        O.dt = model["dt"]

    def _material_of(self, solid):
        self.law, whole = dict(self.law, **solid), self.law
        material = self._material()
        self.law = whole
        if self.hertz:
            material.poisson = solid["poissons_ratio"]
        return material

    def _interaction_loop(self, sorted):
        if not self.hertz:
            loop = super()._interaction_loop(sorted)
            functors = loop.geomDispatcher.functors, loop.physDispatcher.functors, loop.lawDispatcher.functors
            return InteractionLoop(
                functors[0] + [Ig2_Facet_Sphere_ScGeom()], *functors[1:], loopOnSortedInteractions=sorted
            )
        contact = self.law["contact"]
        viscosity, along = contact["viscosity"], contact.get("tangential_viscosity")
        names = {"restitution": ("en", "es", "e_n"), "ratio": ("betan", "betas", "ratio")}.get(viscosity["kind"])
        self.physics = Ip2_FrictMat_FrictMat_MindlinPhys()
        if names is not None:
            setattr(self.physics, names[0], MatchMaker(algo="val", val=viscosity[names[2]]))
            if along is not None:
                setattr(self.physics, names[1], MatchMaker(algo="val", val=along))
        self.contact_law = Law2_ScGeom_MindlinPhys_Mindlin()
        rolling = contact.get("rolling")
        if rolling is not None:
            self.contact_law.includeMoment = True
            self.physics.krot = rolling["bending_stiffness"]
            self.physics.ktwist = rolling["twisting_stiffness"]
            self.physics.eta = rolling.get("limit", 0.0)
        if "adhesion" in contact:
            self.contact_law.includeAdhesion = True
            self.physics.gamma = contact["adhesion"]
        self.grain_geometry = Ig2_Sphere_Sphere_ScGeom()
        self.wall_geometry = Ig2_Wall_Sphere_ScGeom()
        self._choose()
        geometries = [self.grain_geometry, self.wall_geometry, Ig2_Box_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom()]
        return InteractionLoop(
            geometries, [self.physics], [self.contact_law], loopOnSortedInteractions=sorted
        )

    def _choose(self):
        contact = self.law["contact"]
        corrected = contact["slip_velocity"] == "ratcheting_corrected"
        self.grain_geometry.avoidGranularRatcheting = corrected
        self.wall_geometry.noRatch = corrected
        if not self.hertz and model_in_yade.dashpot(self.law) is None:
            self.contact_law.sphericalBodies = contact["torque_arms"] == "half_overlap"
        if model_in_yade.dashpot(self.law) is None:
            # By default the smaller angle of two materials holds; walls and punch may have their own.
            keys = ("wall_friction_angle", "punch_friction_angle")
            angles = [(flat, self.law.get(key)) for flat, key in zip(self.materials[1:], keys)]
            matches = [
                (grain.id, flat.id, angle) for flat, angle in angles if angle is not None for grain in self.of_grains
            ]
            self.physics.frictAngle = MatchMaker(matches=matches, algo="min")
        blocked = "" if self.rotates and contact["rotation"] == "free" else "XYZ"
        for state in self.states:
            state.blockedDOFs = blocked

    def _add_grain(self, grain):
        place = (grain["x"], grain["y"], grain["z"])
        material = self.of_grains[int(grain.get("material", 0))]
        body = utils.sphere(place, grain["radius"], material=material, color=GREY)
        state = body.state
        state.mass = grain["mass"]
        state.vel = (grain["vx"], grain["vy"], grain["vz"])
        if self.rotates:
            inertia = grain["inertia"]
            state.inertia = (inertia, inertia, inertia)
            state.angVel = (grain["spin_x"], grain["spin"], grain["spin_z"])
        O.bodies.append(body)
        return state

    def _add_obstacle(self, obstacle):
        shape = obstacle["shape"]
        common = {"fixed": True, "material": self.materials[1], "color": GREY}
        if shape["kind"] == "triangle":
            body = utils.facet([Vector3(*vertex) for vertex in shape["vertices"]], **common)
        else:
            w, x, y, z = shape.get("orientation", (1.0, 0.0, 0.0, 0.0))
            body = utils.box(shape["centre"], shape["half_extents"], Quaternion(w, x, y, z), **common)
        body.state.blockedDOFs = "xyzXYZ"
        body.state.vel = obstacle.get("velocity", (0.0, 0.0, 0.0))
        body.state.angVel = obstacle.get("spin", (0.0, 0.0, 0.0))
        O.bodies.append(body)

    def kinetic_energy(self):
        energy = 0.0
        for mass, state in zip(self.masses, self.states):
            energy += 0.5 * mass * dot(state.vel, state.vel)
        for inertia, state in zip(self.inertias, self.states):
            energy += 0.5 * inertia * dot(state.angVel, state.angVel)
        return energy


class TablesInSpace(model_in_yade.Tables):
    def moment(self, model, stage, step, **more):
        columns = [[numbers(state.pos) for state in model.states], [numbers(state.vel) for state in model.states]]
        spins = [numbers(state.angVel) for state in model.states] if model.rotates else []
        places, velocities = columns
        table = array("d")
        for column, axis in (
            (places, 0), (places, 2), (velocities, 0), (velocities, 2), (spins, 1),
            (places, 1), (velocities, 1), (spins, 0), (spins, 2),
        ):
            table.extend([vector[axis] for vector in column])
        contacts = sorted(model.real_contacts(), key=lambda contact: (contact.id1, contact.id2))
        for contact in contacts:
            geometry, physics = contact.geom, contact.phys
            normal, point = geometry.normal, numbers(geometry.contactPoint)
            force = physics.normalForce + physics.shearForce
            along = float(dot(force, normal))
            tangential = numbers(force - along * normal)
            table.extend((contact.id1, contact.id2, float(geometry.penetrationDepth), along))
            table.append(math.sqrt(dot(tangential, tangential)))
            table.extend((float(normal[0]), float(normal[2]), point[0], point[2], float(normal[1]), point[1], *tangential))
        if sys.byteorder == "big":
            table.byteswap()
        table.tofile(self.binary)
        self.binary.flush()
        at = None
        if model.punch is not None:
            where = model.punch["state"].pos
            at = {
                "centre": [float(where[0]), float(where[2])],
                "start": model.punch["start"],
                "velocity": float(model.punch["state"].vel[2]),
                "force": float(O.forces.f(model.punch["id"])[2]),
            }
        more.pop("loads", None)
        self.line(dict({"stage": stage, "step": step, "punch": at, "contacts": len(contacts)}, **more))


# The script of the kind finds these under the names of those in the plane.
model_in_yade.ModelInYade = ModelInSpace
model_in_yade.Tables = TablesInSpace
KINDS = {"scene": "run_scene", "cases": "run_cases", "timing": "time_steps"}
job = read_json("job.json")
importlib.import_module(job["settings"].get("script", KINDS[job["kind"]]))
