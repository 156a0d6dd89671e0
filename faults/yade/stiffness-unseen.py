"""Three laws have the same normal force at the same overlap: Mindlin's, HertzWithLinearShear and MindlinDeresiewitz. The last two leave phys.kn at
zero, where GlobalStiffnessTimeStepper looks for the stiffness."""
from yadeimport import *


def normal(law):
    O.reset()
    O.materials.append(FrictMat(young=2e7, poisson=0.3, density=2600, frictionAngle=0.5))
    O.bodies.append(sphere((0, 0, 0), 0.01, fixed=True, color=(1, 1, 1)))
    O.bodies.append(sphere((0, 0, 0.0199), 0.01, fixed=True, color=(1, 1, 1)))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb()]),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys()], [law]),
        NewtonIntegrator(damping=0),
    ]
    O.dt = 1e-6
    O.run(2, True)
    physics = O.interactions[0, 1].phys
    return physics.kn, physics.normalForce.norm()


stiffness, force = normal(Law2_ScGeom_MindlinPhys_Mindlin())
other_stiffness, other_force = normal(Law2_ScGeom_MindlinPhys_HertzWithLinearShear())
partial_stiffness, partial_force = normal(Law2_ScGeom_MindlinPhys_MindlinDeresiewitz())
print('{"stiffness_over_stiffness": %.6g, "force_over_force": %.6g, "deresiewicz_stiffness": %.6g, "deresiewicz_force": %.6g}' % (
    other_stiffness / stiffness, other_force / force, partial_stiffness / stiffness, partial_force / force))
