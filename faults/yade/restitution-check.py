"""YADE's own check of restitution (checkViscElEng) looks at a falling sphere at every hundredth step and takes the ratio of the first velocity
upwards to the one before, which is the 0.736357 that it has written down. Both are from inside the contact. Here is the same fall with the
velocities before and after the contact too, and with the ratio that comes out if the hundredth steps are others."""
from yadeimport import *

large, small, contact_time = 0.003, 0.002, 1e-3
O.materials.append(ViscElMat(frictionAngle=0.5, density=2000, tc=contact_time, en=0.7, et=0.7))
O.bodies.append(sphere((0, 0, 0), large, fixed=True, color=(1, 1, 1)))
O.bodies.append(sphere((0, 0, large + 2 * small), small, color=(1, 1, 1)))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()], [Law2_ScGeom_ViscElPhys_Basic()]),
    NewtonIntegrator(damping=0, gravity=(0, 0, -9.81)),
]
O.dt = 2e-4 * contact_time
falling = O.bodies[1].state
velocities, touching = [], []
while not velocities or velocities[-1] <= 0 or touching[-1]:
    O.step()
    velocities.append(falling.vel[2])
    touching.append(falling.pos[2] < large + small)
turn = next(index for index, velocity in enumerate(velocities) if velocity > 0)
before = velocities[touching.index(True) - 1]
seen = velocities[100::100]
rising = next(index for index, velocity in enumerate(seen) if velocity > 0)
ratios = [-velocities[turn + later] / velocities[turn + later - 100] for later in range(100)]
print('{"check": %.8g, "restitution": %.8g, "least": %.6g, "largest": %.6g}' % (
    -seen[rising] / seen[rising - 1], -velocities[-1] / before, min(ratios), max(ratios)))
