#!/usr/bin/env python3
"""Kratos DEM as an engine of crossgrain: spheres that do not turn, in one plane or in space, with the springs of
`DEM_D_Linear_Simple_Coulomb` or, in space, of `DEM_D_Hertz_viscous_Coulomb`.

There is no friction: turns of grains make slip by finite rotations, and a dashpot beside a spring is limited along its own direction, which
no rule says.

Its step is the leapfrog, with velocities of the half step before the positions, as crossgrain has it. Of two parallel
faces on one side of a grain its search keeps the nearer one alone, in whatever order they are given: a disc that is 0.1 mm deep in two
walls at one place is pushed as by one of them. It comes as wheels for one version of Python, so it has an environment of its own, in whose Python this file runs.
"""
import functools
import os
import sys

from exchange import Refused, serve
from law import Solids, elastic, pair_contacts, punch_contacts, refuse, refuse_inside, wall_contacts
from stages import run_case, run_scene

# Where the environment is, if not in the usual place.
ENVIRONMENT = "CROSSGRAIN_KRATOS"
USUAL = os.path.expanduser("~/.local/share/crossgrain/kratos")
PACKAGES = "KratosMultiphysics==10.4.4 KratosDEMApplication==10.4.4"
PARTS = ["normal_spring", "local_damping", "gravity", "walls", "punch", "stop_rules", "cases", "space", "hertz_mindlin"]
APPROXIMATIONS = [
    "local damping goes by the sign of the velocity before the kick, not of that halfway through it, and spares what is at rest"
]
RULES = {"damping_velocity": "before", "wall_radius": "flat"}
# How far walls reach beyond the grains, over the largest radius.
BEYOND = 40.0


def in_its_python():
    """Go on in the Python that has Kratos."""
    python = os.path.join(os.environ.get(ENVIRONMENT, USUAL), "bin", "python")
    if not os.path.exists(python):
        raise SystemExit(
            "there is no %s; in a folder of your own: python3.11 -m venv FOLDER && FOLDER/bin/pip install %s, and say %s=FOLDER"
            % (python, PACKAGES, ENVIRONMENT)
        )
    if os.path.realpath(sys.prefix) != os.path.realpath(os.path.dirname(os.path.dirname(python))):
        os.execv(python, [python, os.path.abspath(__file__), *sys.argv[1:]])


class Program:
    """Kratos, which prints about itself where an engine answers."""

    def __init__(self):
        answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
        os.dup2(2, 1)
        sys.stdout = answers
        import KratosMultiphysics as core

        core.Logger.GetDefaultOutput().SetSeverity(core.Logger.Severity.WARNING)
        from KratosMultiphysics import DEMApplication as dem
        from KratosMultiphysics.DEMApplication import DEM_procedures
        from KratosMultiphysics.DEMApplication.dem_default_input_parameters import GetDefaultInputParameters
        from KratosMultiphysics.DEMApplication.sphere_strategy import ExplicitStrategy

        self.core, self.dem, self.procedures = core, dem, DEM_procedures
        self.defaults, self.strategy = GetDefaultInputParameters, ExplicitStrategy

    def variable(self, name):
        return getattr(self.core, name) if hasattr(self.core, name) else getattr(self.dem, name)

    def vector(self, parts):
        """In the plane across and up."""
        return self.core.Array3([*parts, 0.0][:3])


# Started once, and only where there is something to do.
program = functools.cache(Program)


class Bed:
    """The grains in the program, which has the plane as x and y, and space as it is."""

    def __init__(self, job, program):
        self.job, self.program, self.step = job, program, job.first
        core, model = program.core, job.model
        settings = self.settings()
        self.model = core.Model()
        names = ["SpheresPart", "RigidFacePart", "ClusterPart", "DEMInletPart", "MappingPart", "ContactPart"]
        parts = program.procedures.SetOfModelParts([self.model.CreateModelPart(name) for name in names])
        spheres, self.faces = parts.Get("SpheresPart"), parts.Get("RigidFacePart")
        of_kratos, creator = program.procedures.Procedures(settings), program.dem.ParticleCreatorDestructor()
        self.solver = program.strategy(parts, creator, program.dem.DEM_FEM_Search(), settings, of_kratos)
        scheme = program.dem.SymplecticEulerScheme()
        of_kratos.AddAllVariablesInAllModelParts(self.solver, scheme, scheme, parts, settings)
        of_grains, self.of_walls = self.properties(spheres, self.faces)
        velocity = core.VELOCITY
        for index, grain in enumerate(job.grains):
            node = spheres.CreateNewNode(index + 1, *program.vector([grain[axis] for axis in job.axes]))
            node.SetSolutionStepValue(core.RADIUS, grain["radius"])
            node.SetSolutionStepValue(velocity, program.vector([grain["v" + axis] for axis in job.axes]))
            spheres.CreateNewElement("SphericParticle3D", index + 1, [index + 1], of_grains)
        self.corners, self.conditions = len(job.grains), 0
        self.walls()
        self.punch = self.block() if job.asked.get("punch") is not None else None
        for name in names:
            parts.Get(name).SetBufferSize(1)
        self.solver.AddDofs()
        parts.ComputeMaxIds()
        creator.SetMaxNodeId(parts.MaxNodeId)
        self.solver.BeforeInitialize()
        self.solver.Initialize()
        self.nodes, self.time = [spheres.Nodes[index + 1] for index in range(len(job.grains))], 0.0
        # The program makes masses of densities of spheres; these are the job's to the bit, and so are the weights.
        force = core.EXTERNAL_APPLIED_FORCE
        for node, grain in zip(self.nodes, job.grains):
            node.SetSolutionStepValue(core.NODAL_MASS, grain["mass"])
            across, up = (grain["mass"] * of for of in model["gravity"])
            node.SetSolutionStepValue(force, program.vector((across, up) if job.axes == "xz" else (across, 0.0, up)))

    def settings(self):
        given = self.program.defaults()
        given["solver_settings"].AddString("strategy", "sphere_strategy")
        given["RotationOption"].SetBool(False)
        given["MaxTimeStep"].SetDouble(self.job.model["dt"])
        given["NeighbourSearchFrequency"].SetInt(1)
        given["GlobalDamping"].SetDouble(self.job.model["alpha"])
        for axis in "XYZ":
            given["Gravity" + axis].SetDouble(0.0)
        return given

    def properties(self, spheres, faces):
        """Those of grains and of walls, and of what touches."""
        of, made, is_hertz = self.program.variable, [], Solids(self.job).is_hertz
        law = "DEM_D_Hertz_viscous_Coulomb" if is_hertz else "DEM_D_Linear_Simple_Coulomb"
        for part in (spheres, faces):
            made.append(part.CreateNewProperties(len(made) + 1))
            made[-1][of("YOUNG_MODULUS")] = self.job.model["law"]["modulus"]
            made[-1][of("POISSON_RATIO")] = self.job.model["law"].get("poissons_ratio") or 0.0 if is_hertz else 0.0
            made[-1][of("COMPUTE_WEAR")] = False
            touching = self.program.core.Properties(len(made))
            touching[of("DEM_DISCONTINUUM_CONSTITUTIVE_LAW_NAME")] = law
            touching[of("DEM_ROLLING_FRICTION_MODEL_NAME")] = "DEMRollingFrictionModelBounded"
            for name, value in {"STATIC_FRICTION": 0.0, "DYNAMIC_FRICTION": 0.0, "ROLLING_FRICTION": 0.0}.items():
                touching[of(name)] = value
            touching[of("COEFFICIENT_OF_RESTITUTION")] = 1.0
            made[0].AddSubProperties(touching)
        made[0][of("PARTICLE_DENSITY")] = 1.0
        made[0][of("PARTICLE_MATERIAL")] = 1
        return made

    def corner(self, x, y, z):
        self.corners += 1
        return self.faces.CreateNewNode(self.corners, x, y, z)

    def face(self, corners):
        self.conditions += 1
        self.faces.CreateNewCondition("RigidFace3D4N", self.conditions, [corner.Id for corner in corners], self.of_walls)

    def point(self, x, y, z):
        """A corner; in the plane y is across it."""
        return self.corner(*((x, z, y) if self.job.axes == "xz" else (x, y, z)))

    def walls(self):
        """Faces so large that no grain comes to their edges."""
        job, largest = self.job, max(grain["radius"] for grain in self.job.grains)
        places = {axis: [grain.get(axis, 0.0) for grain in job.grains] for axis in "xyz"}
        for wall in job.model["walls"]:
            places[wall["axis"]].append(wall["place"])
        margin = BEYOND * largest + sum(max(of) - min(of) for of in places.values())
        for wall in job.model["walls"]:
            one, two = (axis for axis in "xyz" if axis != wall["axis"])
            ends = [(min(places[axis]) - margin, max(places[axis]) + margin) for axis in (one, two)]
            around = [(0, 0), (1, 0), (1, 1), (0, 1)]
            corners = [{wall["axis"]: wall["place"], one: ends[0][i], two: ends[1][k]} for i, k in around]
            self.face([self.point(**corner) for corner in corners])

    def block(self):
        """The punch: four faces, whose corners are moved."""
        (x, z), (across, up) = self.job.asked["punch"]["centre"], self.job.asked["punch"]["half_extents"]
        deep = BEYOND * max(grain["radius"] for grain in self.job.grains)
        sides = [grain.get("y", 0.0) for grain in self.job.grains]
        around = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        rings = [[self.point(x + i * across, of, z + k * up) for i, k in around] for of in (min(sides) - deep, max(sides) + deep)]
        for one in range(4):
            two = (one + 1) % 4
            self.face([rings[0][one], rings[0][two], rings[1][two], rings[1][one]])
        return {"z": z, "velocity": self.job.asked["punch"]["velocity"], "corners": rings[0] + rings[1]}

    def go(self):
        """A step."""
        self.time = self.solver.AdvanceInTime(self.time)
        self.solver.InitializeSolutionStep()
        self.solver.SolveSolutionStep()
        self.step += 1
        if self.punch is not None:
            self.punch["z"] += self.punch["velocity"] * self.job.model["dt"]
            (_, up), corners = self.job.asked["punch"]["half_extents"], self.punch["corners"]
            for index, corner in enumerate(corners):
                setattr(corner, "Y" if self.job.axes == "xz" else "Z", self.punch["z"] + (up if index % 4 > 1 else -up))

    def to(self, step):
        while self.step < step:
            self.go()

    def to_rule(self, step):
        """Go on to this step, or to an earlier one where the punch has its force or is too deep: whether it has the force,
        whether it is too deep, and the force."""
        loading, given = self.job.asked["loading"], self.job.asked["punch"]
        while True:
            self.go()
            force = self.force(self.pushed(self.places(self.motion)))
            reached = force >= loading["target_force"]
            deep = given["start"] - (self.punch["z"] - given["half_extents"][1]) >= loading["give_up_depth"]
            if reached or deep or self.step >= step:
                return reached, deep, force

    def stop_punch(self):
        self.punch["velocity"] = 0.0

    def ends(self):
        self.model.Reset()

    @property
    def motion(self):
        speed = self.program.core.VELOCITY
        both = ((node, node.GetSolutionStepValue(speed)) for node in self.nodes)
        if self.job.axes == "xyz":
            return [(node.X, node.Z, velocity[0], velocity[2], node.Y, velocity[1]) for node, velocity in both]
        return [(node.X, node.Y, velocity[0], velocity[1]) for node, velocity in both]

    def places(self, motion):
        return [of[:2] if self.job.axes == "xz" else (of[0], of[4], of[1]) for of in motion]

    def pushed(self, places):
        return punch_contacts(self.job, (self.job.asked["punch"]["centre"][0], self.punch["z"]), places, elastic(self.job))

    def force(self, pushed):
        return -sum(row[3] * row[4 + len(self.job.axes)] for row in pushed)

    def show(self):
        """Write the moment, with the forces of the law: the program keeps their sums alone."""
        job, motion, punch = self.job, self.motion, None
        places, push = self.places(motion), elastic(job)
        rows = pair_contacts(job, push, places) + wall_contacts(job, None, places, push)
        if self.punch is not None:
            given, pushed = job.asked["punch"], self.pushed(places)
            centre, force = [given["centre"][0], self.punch["z"]], self.force(pushed)
            punch = {"centre": centre, "start": given["start"], "velocity": self.punch["velocity"], "force": force}
            rows += pushed
        job.moment(job.asked.get("stage", "settle"), self.step, motion, rows, punch)


def refuse_hidden_walls(job):
    """Its search keeps one face of those that push a grain the same way."""
    largest, places = max(grain["radius"] for grain in job.grains), [(wall["axis"], wall["place"]) for wall in job.model["walls"]]
    for one, (axis, place) in enumerate(places):
        if any(axis == other and abs(place - at) < largest for other, at in places[:one]):
            raise Refused("two walls that push a grain the same way")


def in_program(runs):
    def run(job):
        refuse(job)
        refuse_hidden_walls(job)
        refuse_inside(job)
        return runs(job, lambda of: Bed(of, program()))

    return run


def description():
    from importlib.metadata import version

    program()
    return {"protocol": 2, "name": "Kratos DEM", "version": version("KratosDEMApplication"), "parts": PARTS, "approximations": APPROXIMATIONS, "rules": RULES}


if __name__ == "__main__":
    in_its_python()
    serve(description, in_program(run_scene), in_program(run_case))
