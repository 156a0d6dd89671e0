"""A sphere that turns on a fixed one is braked by the moment mR N of ViscElMat, which does not depend on how fast it turns; with mRtype = 2 by
one that is multiplied by the velocity of rolling. The moments at 1 and at 10 rad/s are read."""
from yadeimport import *


def moment(spin, kind):
    O.reset()
    O.materials.append(ViscElMat(kn=1e5, cn=0, ks=0, cs=0, density=2600, frictionAngle=0, mR=1e-3, mRtype=kind))
    O.bodies.append(sphere((0, 0, 0), 0.01, fixed=True, color=(1, 1, 1)))
    O.bodies.append(sphere((0, 0, 0.0199), 0.01, color=(1, 1, 1)))
    O.bodies[1].state.blockedDOFs = "xyz"
    O.bodies[1].state.angVel = (0, spin, 0)
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb()]),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()], [Law2_ScGeom_ViscElPhys_Basic()]),
        NewtonIntegrator(damping=0),
    ]
    O.dt = 1e-6
    O.run(2, True)
    return -O.forces.t(1)[1]


print('{"moment_at_10_over_moment_at_1": %.6g, "viscous_at_10_over_viscous_at_1": %.6g}' % (moment(10, 1) / moment(1, 1), moment(10, 2) / moment(1, 2)))
