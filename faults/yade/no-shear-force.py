"""A sphere slides over another one at a constant overlap under two laws of Mindlin's family: the force along the surface before it slips."""
from yadeimport import *


def along(ip, law):
    O.reset()
    O.materials.append(FrictMat(young=2e7, poisson=0.3, density=2600, frictionAngle=0.5))
    O.bodies.append(sphere((0, 0, 0), 0.01, fixed=True, color=(1, 1, 1)))
    O.bodies.append(sphere((0, 0, 0.0199), 0.01, fixed=True, color=(1, 1, 1)))
    O.bodies[1].state.vel = (0.01, 0, 0)
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb()]),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [ip], [law]),
        NewtonIntegrator(damping=0),
    ]
    O.dt = 1e-6
    O.run(100, True)
    return O.interactions[0, 1].phys.shearForce.norm()


mindlin = along(Ip2_FrictMat_FrictMat_MindlinPhys(), Law2_ScGeom_MindlinPhys_Mindlin())
other = along(Ip2_FrictMat_FrictMat_MindlinPhys(), Law2_ScGeom_MindlinPhys_MindlinDeresiewitz())
print('{"deresiewicz": %.6g, "mindlin": %.6g}' % (other, mindlin))
