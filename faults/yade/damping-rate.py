"""NormalRestitution2DampingRate(0.2) beside the formula that its text has, -ln e / sqrt(e^2 + pi^2), and beside the damping ratio of a linear
spring and dashpot with that restitution, -ln e / sqrt(ln^2 e + pi^2)."""
from math import log, pi

from yadeimport import *

print('{"over_text": %.8g, "over_law": %.8g}' % tuple(
    NormalRestitution2DampingRate(0.2) / (-log(0.2) / (square + pi**2)**0.5) for square in (0.2**2, log(0.2)**2)))
print(NormalRestitution2DampingRate.__doc__)
