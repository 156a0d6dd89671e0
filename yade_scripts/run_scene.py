"""Run one crossgrain scene in YADE and write tables.

Fixed text: nothing is ever spliced into this file. It reads, from the folder named by the
environment variable CROSSGRAIN_JOB (or the current folder),

    scene.json    the scene, as `crossgrain scene paper` prints it
    initial.csv   id,x,z,vx,vz,radius,mass (and spin,inertia) of every grain at the start
    job.json      the model, and what to run: loop order, where to start and stop

and writes there hello.json (who is running), heartbeat (a line now and then), frames.bin and
frames.jsonl (moments of the run, see README.md) and, last of all, done.json.

Bodies are made in this order: grains, left wall, right wall, floor, and the punch when loading
starts.
"""
import csv
import math
import time

import model_in_yade
from model_in_yade import ModelInYade, Tables, place, read_json, write_json
from yadeimport import *  # noqa: F403

model_in_yade.say_hello()

scene = read_json("scene.json")
job = read_json("job.json")
with open(place("initial.csv"), encoding="utf-8", newline="") as file:
    rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]

model = ModelInYade(job["model"], rows, job["sorted"], job["verlet_distance"])
tables = Tables()

# --- the punch ------------------------------------------------------------------------------
loading = scene["loading"]
half_extents = (loading["half_width"], 0.5 * loading["punch_height"])
target_force = 2.0 * loading["half_width"] * loading["pressure"]


def add_punch(centre, start, velocity):
    model.add_punch(centre, half_extents, job["punch_half_depth"], velocity, start)


def lower_punch():
    """Set the punch on the highest grain below it."""
    axis = 0.5 * scene["box"]["width"]
    top = 0.0
    for state, row in zip(model.states, rows):
        if abs(state.pos[0] - axis) < half_extents[0] + row["radius"]:
            top = max(top, state.pos[2] + row["radius"])
    add_punch((axis, top + half_extents[1]), top, -loading["speed"])


# --- the stages -----------------------------------------------------------------------------
settle = scene["settle"]
history_every = scene["measurement"]["history_every"]
until_step = job["until_step"]


def settle_rule(step, memory):
    if step % settle["check_every"] == 0:
        energy = model.kinetic_energy()
        if not math.isfinite(energy):
            return "not_finite"
        memory["peak"] = max(memory["peak"], energy)
        if energy <= settle["kinetic_energy_fraction"] * memory["peak"]:
            return "settled"
        memory["share"] = math.log(energy / memory["peak"]) / math.log(settle["kinetic_energy_fraction"])
    return "max_steps" if step >= settle["max_steps"] else None


def load_rule(step, memory):
    force = O.forces.f(model.punch["id"])[2]
    if not math.isfinite(force):
        return "not_finite"
    if "standing_since" in memory:
        long_enough = step >= memory["standing_since"] + job["steps_standing_still"]
        return "reached" if long_enough else None
    if force >= target_force:
        if job["steps_standing_still"] is None:
            return "reached"
        memory["standing_since"] = step
        model.punch["state"].vel = (0.0, 0.0, 0.0)
        return None
    depth = model.punch["start"] - (model.punch["state"].pos[2] - half_extents[1])
    memory["share"] = max(force / target_force, depth / loading["give_up_depth"])
    return "sank_to_give_up_depth" if depth >= loading["give_up_depth"] else None


def run_stage(stage, step, rule):
    wall, cpu = time.monotonic(), time.process_time()
    memory = {"peak": 0.0, "share": 0.0}
    last_beat = wall
    if stage == "load" and model.punch["state"].vel[2] == 0.0:
        memory["standing_since"] = step

    def frame():
        tables.frame(model, {"frame": stage, "step": step})

    frame()
    framed = step
    while True:
        if until_step is not None and step >= until_step:
            stop = "steps_done"
            break
        O.step()
        step += 1
        stop = rule(step, memory)
        if stop is not None and (until_step is None or stop == "not_finite"):
            break
        if step % history_every == 0:
            frame()
            framed = step
        if time.monotonic() - last_beat > 0.2:
            last_beat = time.monotonic()
            tables.beat(stage, step, memory["share"])
    if framed != step:
        frame()
    tables.line(
        {
            "end": stage,
            "steps": step,
            "stop": stop,
            "wall_seconds": time.monotonic() - wall,
            "cpu_seconds": time.process_time() - cpu,
        }
    )
    return stop


start = job["start"]
if start["punch"] is not None:
    # A punch that stands still goes on doing so; any other has the scene's speed.
    standing = start["punch"]["velocity"] == 0.0
    add_punch(start["punch"]["centre"], start["punch"]["start"], 0.0 if standing else -loading["speed"])
model.evaluate_at_start()

go_on = True
if start["stage"] == "settle":
    settled = run_stage("settle", start["step"], settle_rule) == "settled"
    go_on = settled and not job["ends_settled"]
if go_on:
    if model.punch is None:
        lower_punch()
    run_stage("load", start["step"] if start["stage"] == "load" else 0, load_rule)

tables.close()
write_json("done.json", {"steps_by_yade": O.iter - 1})
O.exitNoBacktrace()
