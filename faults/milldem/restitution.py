"""Two balls of a mill meet head on, away from its shell, without the background damping: a restitution of 0.5 is asked for at 0.1 and at
1 m/s. The package says that its damping is exact for Hooke's spring and by Tsuji's form, which does not depend on the velocity, for Hertz's."""
import json

import numpy
from milldem import ContactModel, MillConfig, MillDEM


def restitution(model, speed):
    mill = MillDEM(MillConfig(bg_damping=0.0, contact=ContactModel(model=model, e=0.5)))
    radius, mass = mill.r[0], mill.m[0]
    mill.n, mill.r, mill.m, mill.wall_shear = 2, numpy.full(2, radius), numpy.full(2, mass), numpy.zeros(2)
    mill.px, mill.py = numpy.array([-1.0001, 1.0001]) * radius, numpy.zeros(2)
    mill.vx, mill.vy = numpy.array([0.5, -0.5]) * speed, numpy.zeros(2)
    while mill.px[1] - mill.px[0] > 2 * radius:
        mill.step()
    while mill.px[1] - mill.px[0] <= 2 * radius:
        mill.step()
    return float(mill.vx[1] - mill.vx[0]) / speed


print(json.dumps({"%s_at_%s" % (model, name): restitution(model, speed) for model in ("hooke", "hertz") for name, speed in (("0.1", 0.1), ("1", 1.0))}))
