"""Two spheres meet at 45 degrees without dashpots. What is missing of their energy afterwards was taken by friction, and
friction can only take: the account of it should not be below zero. No spring holds energy after the contact."""
from math import atan

from yadeimport import *

O.materials.append(FrictMat(young=2e7, poisson=0.3, density=2600, frictionAngle=atan(2.0)))
O.bodies.append(sphere((0, 0, 0), 0.01, fixed=True, color=(1, 1, 1)))
O.bodies.append(sphere((0, 0, 0.02000001), 0.01, color=(1, 1, 1)))
O.bodies[1].state.vel = (0.1, 0, -0.1)
law = Law2_ScGeom_MindlinPhys_Mindlin(calcEnergy=True)
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False)], [Ip2_FrictMat_FrictMat_MindlinPhys()], [law]),
    NewtonIntegrator(damping=0),
]
O.dt = 2e-7
before = kineticEnergy()
O.run(40000, True)
lost = before - kineticEnergy()
print('{"at_least_zero": %d, "account_over_energy": %.6g, "loss_over_energy": %.6g, "shear_energy_over_energy": %.6g}'
      % (law.frictionDissipation >= 0, law.frictionDissipation / before, lost / before, law.shearEnergy / before))
