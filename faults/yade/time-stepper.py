"""A sphere sinks into another one, and GlobalStiffnessTimeStepper finds a time step at every 40th step. The scene is saved after 65 steps; the
time step of the next one should be the same in the run that goes on and in the one that is loaded."""
from yadeimport import *

O.materials.append(FrictMat(young=2e7, poisson=0.3, density=2600, frictionAngle=0.5))
O.bodies.append(sphere((0, 0, 0), 0.01, fixed=True, color=(1, 1, 1)))
O.bodies.append(sphere((0, 0, 0.0199), 0.01, color=(1, 1, 1)))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys()], [Law2_ScGeom_MindlinPhys_Mindlin()]),
    GlobalStiffnessTimeStepper(timeStepUpdateInterval=40, timestepSafetyCoefficient=0.03),
    NewtonIntegrator(damping=0, gravity=(0, 0, -300)),
]
O.run(65, True)
O.save("scene.xml")
O.step()
went_on = O.dt
O.load("scene.xml")
at_load = O.dt
O.step()
print('{"step_over_step": %.8g, "at_load": %.8g}' % (O.dt / went_on, at_load / went_on))
