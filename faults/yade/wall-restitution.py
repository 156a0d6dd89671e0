"""A restitution of 0.5 is asked for; a sphere meets a wall, and a sphere meets another, under each of three laws."""
from yadeimport import *


def rebound(material, ip, law, wall):
    O.reset()
    O.materials.append(material)
    O.bodies.append(sphere((0, 0, 0.0100001), 0.01, color=(1, 1, 1)))
    O.bodies[0].state.vel = (0, 0, -0.1)
    if wall:
        O.bodies.append(utils.wall(0, axis=2, color=(1, 1, 1)))
    else:
        O.bodies.append(sphere((0, 0, -0.01), 0.01, color=(1, 1, 1)))
        O.bodies[1].state.vel = (0, 0, 0.1)
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [ip], [law]),
        NewtonIntegrator(damping=0),
    ]
    O.dt = 1e-7
    O.run(60000, True)
    return O.bodies[0].state.vel[2] / 0.1


time = ViscElMat(tc=1e-3, en=0.5, et=0.5, density=2600, frictionAngle=0), Ip2_ViscElMat_ViscElMat_ViscElPhys(), Law2_ScGeom_ViscElPhys_Basic()
modulus = ViscElMat(young=1e6, poisson=0.3, en=0.5, et=1, density=2600, frictionAngle=0), *time[1:]
hertz = FrictMat(young=2e7, poisson=0.3, density=2600, frictionAngle=0), Ip2_FrictMat_FrictMat_MindlinPhys(en=0.5, es=0.5), Law2_ScGeom_MindlinPhys_Mindlin()
print('{"by_time_wall": %.6g, "by_time_pair": %.6g, "by_modulus_wall": %.6g, "by_modulus_pair": %.6g, "hertz_wall": %.6g, "hertz_pair": %.6g}'
      % tuple(rebound(*law, wall) for law in (time, modulus, hertz) for wall in (True, False)))
