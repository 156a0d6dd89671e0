"""A sphere that does not turn slides over a face: what it loses along the face over what the face gives it upwards is the coefficient of
friction, which is asked to be 0.5 and 1. A sphere falls on a face: its speed after that over the one before is the restitution, which is
asked to be 0.5. Each under a law that shows a fault and under one that does not. Two spheres that turn alike meet head on: they do not roll on
each other, so that no rolling friction, whatever its model, should change their spins, and any should leave their sum."""
import json
import os
import sys

answers = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

import KratosMultiphysics as core
from KratosMultiphysics import DEMApplication as dem
from KratosMultiphysics.DEMApplication import DEM_procedures
from KratosMultiphysics.DEMApplication.dem_default_input_parameters import GetDefaultInputParameters
from KratosMultiphysics.DEMApplication.sphere_strategy import ExplicitStrategy


def put(into, **values):
    for name, value in values.items():
        into[getattr(core if hasattr(core, name) else dem, name)] = value


def velocities(law, start, gravity, friction, restitution, element="SphericParticle3D", step=1e-6, steps=4000, rolling=None, spin=0.0):
    """The velocity at the start, at half of the steps and at their end, over a face. With a model of rolling friction it is that of the first
    of two spheres that meet and turn alike, and the sum of their spins comes last."""
    radius, settings = 0.01, GetDefaultInputParameters()
    settings["solver_settings"].AddString("strategy", "sphere_strategy")
    for name, value in {"MaxTimeStep": step, "GravityX": 0.0, "GravityY": -gravity, "GravityZ": 0.0}.items():
        settings[name].SetDouble(value)
    settings["RotationOption"].SetBool(rolling is not None)
    settings["RollingFrictionOption"].SetBool(rolling is not None)
    model = core.Model()
    names = ["SpheresPart", "RigidFacePart", "ClusterPart", "DEMInletPart", "MappingPart", "ContactPart"]
    parts = DEM_procedures.SetOfModelParts([model.CreateModelPart(name) for name in names])
    spheres, faces = parts.Get("SpheresPart"), parts.Get("RigidFacePart")
    creator, procedures, scheme = dem.ParticleCreatorDestructor(), DEM_procedures.Procedures(settings), dem.SymplecticEulerScheme()
    solver = ExplicitStrategy(parts, creator, dem.DEM_FEM_Search(), settings, procedures)
    procedures.AddAllVariablesInAllModelParts(solver, scheme, scheme, parts, settings)
    made = [part.CreateNewProperties(index + 1) for index, part in enumerate((spheres, faces))]
    for index, of in enumerate(made):
        put(of, YOUNG_MODULUS=1e6, POISSON_RATIO=0.3, COMPUTE_WEAR=False)
        touching = core.Properties(index + 1)
        put(touching, DEM_DISCONTINUUM_CONSTITUTIVE_LAW_NAME=law, DEM_ROLLING_FRICTION_MODEL_NAME=rolling or "DEMRollingFrictionModelBounded")
        put(touching, STATIC_FRICTION=friction, DYNAMIC_FRICTION=friction, FRICTION_DECAY=500.0, ROLLING_FRICTION=0.1 if rolling else 0.0, COEFFICIENT_OF_RESTITUTION=restitution)
        made[0].AddSubProperties(touching)
    put(made[0], PARTICLE_DENSITY=2600.0, PARTICLE_MATERIAL=1)
    places = [(-1.0001 * radius, 0.0), (1.0001 * radius, 0.0)] if rolling else [(0.0, radius)]
    nodes = [spheres.CreateNewNode(index + 1, x, y, 0.0) for index, (x, y) in enumerate(places)]
    for node, sign in zip(nodes, (1, -1)):
        node.SetSolutionStepValue(core.RADIUS, radius)
        node.SetSolutionStepValue(core.VELOCITY, core.Array3([sign * component for component in start]))
        node.SetSolutionStepValue(core.ANGULAR_VELOCITY, core.Array3([0.0, 0.0, spin]))
        spheres.CreateNewElement(element, node.Id, [node.Id], made[0])
    if not rolling:
        for index, (x, z) in enumerate([(-9, -9), (9, -9), (9, 9), (-9, 9)]):
            faces.CreateNewNode(index + 2, x, 0.0, z)
        faces.CreateNewCondition("RigidFace3D4N", 1, [2, 3, 4, 5], made[1])
    for name in names:
        parts.Get(name).SetBufferSize(1)
    solver.AddDofs()
    parts.ComputeMaxIds()
    creator.SetMaxNodeId(parts.MaxNodeId)
    solver.BeforeInitialize()
    solver.Initialize()
    seen, time = [start], 0.0
    for index in range(steps):
        time = solver.AdvanceInTime(time)
        solver.InitializeSolutionStep()
        solver.SolveSolutionStep()
        if index + 1 in (steps // 2, steps):
            seen.append(list(nodes[0].GetSolutionStepValue(core.VELOCITY)))
    return seen + [sum(node.GetSolutionStepValue(core.ANGULAR_VELOCITY)[2] for node in nodes)]


def shown_friction(law, asked):
    (_, (before, down, _), (after, up, _), _), gravity = velocities(law, [1.0, 0.0, 0.0], 10.0, asked, 0.2), 10.0
    return (before - after) / (gravity * 2000 * 1e-6 + up - down)


def shown_restitution(law, asked, element="SphericParticle3D"):
    return velocities(law, [0.0, -0.1, 0.0], 0.0, 0.0, asked, element, 2e-7, 60000)[2][1] / 0.1


def shown_spins(rolling):
    """The spins after the contact over those before it, if the spheres part."""
    _, _, (after, _, _), spins = velocities("DEM_D_Hertz_viscous_Coulomb", [0.1, 0.0, 0.0], 0.0, 0.0, 0.5, steps=20000, rolling=rolling, spin=10.0)
    return spins / 20 if after < 0 else None


core.Logger.GetDefaultOutput().SetSeverity(core.Logger.Severity.WARNING)
json.dump({
    "friction_simple_0.5": shown_friction("DEM_D_Linear_Simple_Coulomb", 0.5),
    "friction_simple_1": shown_friction("DEM_D_Linear_Simple_Coulomb", 1.0),
    "friction_viscous_0.5": shown_friction("DEM_D_Linear_viscous_Coulomb", 0.5),
    "restitution_hertz_2d": shown_restitution("DEM_D_Hertz_viscous_Coulomb2D", 0.5, "CylinderParticle2D"),
    "restitution_hertz": shown_restitution("DEM_D_Hertz_viscous_Coulomb", 0.5),
    "restitution_linear": shown_restitution("DEM_D_Linear_viscous_Coulomb", 0.5),
    "spins_bounded": shown_spins("DEMRollingFrictionModelBounded"),
    "spins_constant_torque": shown_spins("DEMRollingFrictionModelConstantTorque"),
    "spins_viscous_torque": shown_spins("DEMRollingFrictionModelViscousTorque"),
}, answers)
