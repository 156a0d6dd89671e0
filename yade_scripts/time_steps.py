"""Do a job of kind `timing` of the engine protocol in YADE.

Fixed text: nothing is ever spliced into this file. Nothing but steps is inside the timed part: no history, no stop rule, no
start-up.
"""
import resource
import time

import model_in_yade
from model_in_yade import ModelInYade, Tables, beat, read_grains, read_json, write_json
from yadeimport import *  # noqa: F403

model_in_yade.say_hello()

# Grains times steps between two signs of life: about half a second's.
GRAIN_STEPS_A_BLOCK = 2_000_000

job = read_json("job.json")
model = ModelInYade(job["model"], read_grains(), **job["settings"])
block = -(-GRAIN_STEPS_A_BLOCK // model.grains)
tables = Tables()
model.evaluate_at_start()


def steps(count):
    """Do so many steps; a sign of life between blocks of about half a second."""
    done = 0
    while done < count:
        part = min(block, count - done)
        for _ in range(part):
            O.step()
        done += part
        beat("settle", done, done / count)


steps(job["warm_up"])
wall, cpu = time.monotonic(), time.process_time()
steps(job["steps"])
wall, cpu = time.monotonic() - wall, time.process_time() - cpu
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
tables.moment(model, "settle", job["warm_up"] + job["steps"])

# YADE's own account of its engines, in steps of their own, because keeping it costs time.
O.timingEnabled = True
for engine in O.engines:
    engine.execTime = 0
steps(job["shares"])
shares = [{"name": type(engine).__name__, "nanoseconds": engine.execTime} for engine in O.engines]

tables.close()
write_json(
    "done.json",
    {
        "steps": O.iter - 1,
        "wall_seconds": wall,
        "cpu_seconds": cpu,
        "peak_memory": memory,
        "shares": shares,
    },
)
O.exitNoBacktrace()
