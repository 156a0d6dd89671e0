"""The user gives a seed to Python's generator, adds a sphere, and draws a number; twice. Both should be the same number."""
import random

from yadeimport import *


def drawn(**more):
    random.seed(1)
    sphere((0, 0, 0), 1, **more)
    return random.random()


print('{"drawn_again": %d, "drawn_again_with_color": %d}' % (drawn() == drawn(), drawn(color=(1, 1, 1)) == drawn(color=(1, 1, 1))))
