"""Time steps of a crossgrain bed in YADE.

Fixed text: nothing is ever spliced into this file. It reads, from the folder named by the
environment variable CROSSGRAIN_JOB (or the current folder),

    initial.csv   id,x,z,vx,vz,radius,mass of every grain at the start
    job.json      the model, the loop's order, verletDist, and how many steps

and writes there hello.json, heartbeat, the moment after the timed steps (frames.bin, frames.jsonl)
and, last of all, done.json with the times. Nothing but steps is inside the timed part: no history,
no stop rule, no start-up.
"""
import csv
import resource
import time

import model_in_yade
from model_in_yade import ModelInYade, Tables, place, read_json, write_json
from yadeimport import *  # noqa: F403

model_in_yade.say_hello()

job = read_json("job.json")
with open(place("initial.csv"), encoding="utf-8", newline="") as file:
    rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]

model = ModelInYade(job["model"], rows, job["sorted"], job["verlet_distance"])
del rows
tables = Tables()
model.evaluate_at_start()


def steps(count):
    """Do so many steps; a sign of life between blocks of about half a second."""
    block = job["block"]
    done = 0
    while done < count:
        part = min(block, count - done)
        for _ in range(part):
            O.step()
        done += part
        tables.beat("settle", done, done / count)


steps(job["warm_up"])
wall, cpu = time.monotonic(), time.process_time()
steps(job["steps"])
wall, cpu = time.monotonic() - wall, time.process_time() - cpu
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
tables.frame(model, {"frame": "settle", "step": job["warm_up"] + job["steps"]})

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
        "steps_by_yade": O.iter - 1,
        "wall_seconds": wall,
        "cpu_seconds": cpu,
        "peak_memory": memory,
        "shares": shares,
    },
)
O.exitNoBacktrace()
