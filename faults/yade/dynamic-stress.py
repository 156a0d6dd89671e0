"""A sphere of 1 kg moves at 2 m/s along x in a cell of 8 m^3: the stress of its motion is -m v v/V by the manual, -0.5 Pa."""
from yadeimport import *

O.periodic = True
O.cell.setBox(2, 2, 2)
O.bodies.append(sphere((1, 1, 1), 0.1, color=(1, 1, 1)))
O.bodies[0].state.mass = 1
O.bodies[0].state.vel = (2, 0, 0)
O.dt = 1e-6
O.engines = [ForceResetter(), NewtonIntegrator(damping=0)]
O.step()
try:
    getDynamicStress()
    answers = 1
except TypeError:
    answers = 0
print('{"total": %.6g, "per_body_answers": %d}' % (getTotalDynamicStress()[0][0], answers))
print(getStress.__doc__, getTotalDynamicStress.__doc__, getDynamicStress.__doc__)
