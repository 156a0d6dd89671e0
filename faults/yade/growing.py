"""Spheres that touch grow by a fifth. Their contact should then be as stiff as one of spheres that were made so large, and so should their
moments of inertia be, alone and in a clump."""
from yadeimport import *

LINEAR = Ip2_FrictMat_FrictMat_FrictPhys(), Law2_ScGeom_FrictPhys_CundallStrack()
HERTZ = Ip2_FrictMat_FrictMat_MindlinPhys(), Law2_ScGeom_MindlinPhys_Mindlin()


def pair(first, second, ip, law):
    O.reset()
    O.materials.append(FrictMat(young=2e7, poisson=0.3, density=2600, frictionAngle=0.5))
    for height, radius in ((0, first), (0.0199, second)):
        O.bodies.append(sphere((0, 0, height), radius, color=(1, 1, 1)))
        O.bodies[-1].state.blockedDOFs = "xyzXYZ"
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb()]),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [ip], [law]),
        NewtonIntegrator(damping=0),
    ]
    O.dt = 1e-7
    O.run(2, True)


def stiffness():
    """Of the linear law kn, of Hertz's law the constant that the power of the overlap is multiplied by."""
    O.run(1, True)
    physics = O.interactions[0, 1].phys
    return getattr(physics, "kno", physics.kn)


def after_growing(grow, radii, law):
    pair(0.01, 0.01, *law)
    grow()
    grown = stiffness()
    pair(*radii, *law)
    return grown / stiffness()


def inertia(size, grow=1):
    O.reset()
    O.bodies.append(sphere((0, 1, 0), 0.01 * size, color=(1, 1, 1)))
    O.bodies.appendClumped([sphere((x * size, 0, 0), 0.01 * size, color=(1, 1, 1)) for x in (0, 0.03)])
    growParticles(grow)
    return O.bodies[0].state.inertia[0], O.bodies[3].state.inertia.norm()


all_grow, one_grows = lambda: growParticles(1.2), lambda: growParticle(1, 1.2)
(sphere_grown, clump_grown), (sphere_made, clump_made) = inertia(1, 1.2), inertia(1.2)
print('{"one_linear": %.6g, "all_linear": %.6g, "all_hertz": %.6g, "inertia": %.6g, "inertia_of_clump": %.6g}' % (
    after_growing(one_grows, (0.01, 0.012), LINEAR), after_growing(all_grow, (0.012, 0.012), LINEAR),
    after_growing(all_grow, (0.012, 0.012), HERTZ), sphere_grown / sphere_made, clump_grown / clump_made))
