"""A cubic lattice of 6 layers of spheres is compressed by PeriIsoCompressor until it says that 1e4 Pa are reached. The stress is then read
by getStress, which is the sum of forces times branches over the volume."""
from yadeimport import *

O.materials.append(FrictMat(young=1e7, poisson=0.3, density=2600, frictionAngle=0))
O.periodic = True
layers, radius = 6, 0.01
O.cell.setBox(*[2 * radius * layers] * 3)
places = [(x, y, z) for x in range(layers) for y in range(layers) for z in range(layers)]
O.bodies.append([sphere([(2 * of + 1) * radius for of in place], radius, color=(1, 1, 1)) for place in places])
done = []
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
    PeriIsoCompressor(charLen=2 * radius, stresses=[-1e4], maxUnbalanced=1e-2, globalUpdateInt=5, doneHook="done.append(-getStress().trace() / 3)"),
    NewtonIntegrator(damping=0.6),
]
O.dt = 0.5 * PWaveTimeStep()
import yade, __main__
__main__.done = done
while not done and O.iter < 100000:
    O.run(100, True)
print('{"stress_over_goal": %.6g}' % (done[0] / 1e4))
