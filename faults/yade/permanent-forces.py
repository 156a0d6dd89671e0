"""A permanent force of 1 N on 1 kg and a permanent torque of 1 N m on 1 kg m^2 for a second, the scene saved and loaded, and another second: the
sphere should have 2 m/s and 2 rad/s."""
from yadeimport import *

O.bodies.append(sphere((0, 0, 0), 1, color=(1, 1, 1)))
O.bodies[0].state.mass = 1
O.bodies[0].state.inertia = (1, 1, 1)
O.engines = [ForceResetter(), NewtonIntegrator(damping=0)]
O.dt = 1e-3
O.forces.setPermF(0, (1, 0, 0))
O.forces.setPermT(0, (1, 0, 0))
O.run(1000, True)
O.save("scene.xml")
O.load("scene.xml")
O.run(1000, True)
print('{"speed": %.6g, "spin": %.6g}' % (O.bodies[0].state.vel[0], O.bodies[0].state.angVel[0]))
