"""A box turns about its own centre by 1 rad/s towards a sphere at rest, which it meets after 0.2885 s: the centre of the sphere, 0.8544 m away
and 0.3588 rad ahead, is then 0.06 m from the middle plane of the box. Has it moved after 0.35 s? So does a facet, about its point (√2 - 1, 0,
1 - √2); the sphere is 0.4887 m from that axis and 0.6610 rad ahead, and at 0.05 m from its plane after 0.5585 s. Has it moved after 0.65 s?"""
from yadeimport import *


def met(body, until, **collider):
    O.reset()
    O.materials.append(FrictMat(young=1e6, poisson=0.3, density=1000, frictionAngle=0))
    O.bodies.append(body())
    O.bodies[0].state.angVel = (0, 0, 1)
    O.bodies.append(sphere((0.8, 0.3, 0), 0.05, color=(1, 1, 1)))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb(), Bo1_Facet_Aabb()], **collider),
        InteractionLoop([Ig2_Box_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
        NewtonIntegrator(damping=0),
    ]
    O.dt = 1e-4
    O.run(until, True)
    return O.bodies[1].state.vel.norm() > 0


def flat_box():
    return box((0, 0, 0), (1, 0.01, 0.5), fixed=True, color=(1, 1, 1))


def triangle():
    return facet([(-1, 0, -1), (1, 0, -1), (1, 0, 1)], fixed=True, color=(1, 1, 1))


print('{"met": %d, "met_with_bounds_made_at_every_step": %d, "facet_met": %d, "facet_met_with_bounds_made_at_every_step": %d}' % tuple(
    met(body, until, **collider) for body, until in ((flat_box, 3500), (triangle, 6500)) for collider in ({}, {"verletDist": 0})))
