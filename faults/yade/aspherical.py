"""A body whose moments of inertia are 1, 3.5 and 3.5 kg m^2 lies turned by a quarter about z, so that they are 3.5, 1 and 3.5 along x, y
and z. A torque of 1 N m along x, and then one along y, acts for 0.1 s: the spin that each gives, over the law's."""
from math import pi

from yadeimport import *


def spin_over_law(axis, moment, exact):
    O.reset()
    O.bodies.append(sphere((0, 0, 0), 0.01, color=(1, 1, 1)))
    O.bodies[0].aspherical = True
    state = O.bodies[0].state
    state.mass, state.inertia, state.ori = 1, (1, 3.5, 3.5), Quaternion((0, 0, 1), pi / 2)
    O.forces.setPermT(0, axis)
    O.engines = [ForceResetter(), NewtonIntegrator(damping=0, exactAsphericalRot=exact)]
    O.dt = 1e-3
    O.run(100, True)
    return state.angVel.dot(Vector3(axis)) * moment / 0.1


print('{"along_x": %.6g, "along_y": %.6g, "along_x_exact": %.6g, "along_y_exact": %.6g}' % tuple(
    spin_over_law(axis, moment, exact) for exact in (False, True) for axis, moment in (((1, 0, 0), 3.5), ((0, 1, 0), 1))))
