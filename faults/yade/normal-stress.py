"""A periodic column of five spheres is compressed. The manual says that getStress is negative under compression. The first tensor of
normalShearStressTensors should have that sign too, and with compressionPositive the other; its size should be the same, for there are normal
forces alone and the manual takes the distance of the centres for R N n n."""
from yadeimport import *

O.materials.append(FrictMat(young=2e7, poisson=0.3, density=2600, frictionAngle=0.5))
O.periodic = True
distance = 0.019
O.cell.setBox(0.1, 0.1, 5 * distance)
O.bodies.append([sphere((0.05, 0.05, (index + 0.5) * distance), 0.01, color=(1, 1, 1)) for index in range(5)])
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
    NewtonIntegrator(damping=0),
]
O.dt = 1e-8
O.step()
love, normal, positive = getStress()[2][2], normalShearStressTensors()[0][2][2], normalShearStressTensors(True)[0][2][2]
print('{"compression_is_positive": %d, "size": %.8g}' % (love < 0 < positive, abs(normal / love)))
print(getStress.__doc__, normalShearStressTensors.__doc__)
