"""300 grains of 0.1 m fill 0.157 of a cube of 1 m, less than the 0.35 that makeCloud tries first (porosity=0.65): they need not be made
smaller. All the same size may also be said by a table of one step. Of a table of masses a half lies below 0.2 m."""
from math import isfinite

from yadeimport import *
from yade import pack


def cloud(side, number, sizes, shares, by_mass):
    packing = pack.SpherePack()
    packing.makeCloud((0, 0, 0), (side, side, side), psdSizes=sizes, psdCumm=shares, num=number, distributeMass=by_mass, seed=1)
    return packing.appliedPsdScaling, [2 * radius for _, radius in packing]


def scaling(by_mass):
    return cloud(1, 300, [0.1, 0.1 + 1e-6], [0, 1], by_mass)[0]


def is_a_number(by_mass):
    return all(isfinite(size) for size in cloud(4, 300, [0.1, 0.1], [0, 1], by_mass)[1])


sizes = cloud(8, 1000, [0.1, 0.2, 0.4], [0, 0.5, 1], True)[1]
below = sum(size**3 for size in sizes if size <= 0.2) / sum(size**3 for size in sizes)
print('{"size_by_number": %.6g, "size_by_mass": %.6g, "one_size_by_number": %d, "one_size_by_mass": %d, "mass_below": %.6g}' % (
    scaling(False), scaling(True), is_a_number(False), is_a_number(True), below))
