"""Run a job of kind `scene` of the engine protocol (docs/engine-protocol.md) in YADE.

Fixed text: nothing is ever spliced into this file. The job is in the folder named by the environment variable
CROSSGRAIN_JOB, or in the current folder; its `settings` are `sorted` and `verlet_distance`. hello.json says who is
running; tables are written as numbers.

Bodies are made in this order: grains, left wall, right wall, floor, and the punch when loading starts.
"""
import math
import time

import model_in_yade
from model_in_yade import ModelInYade, Tables, beat, read_grains, read_json, write_json
from yadeimport import *  # noqa: F403

model_in_yade.say_hello()

job = read_json("job.json")
rows = read_grains()
model = ModelInYade(job["model"], rows, **job["settings"])
tables = Tables()

# --- the punch ------------------------------------------------------------------------------
loading = job["loading"]
half_extents = loading["half_extents"]


def lower_punch():
    """Set the punch on the highest grain below it."""
    axis = loading["axis"]
    top = 0.0
    for state, row in zip(model.states, rows):
        if abs(state.pos[0] - axis) < half_extents[0] + row["radius"]:
            top = max(top, state.pos[2] + row["radius"])
    model.add_punch((axis, top + half_extents[1]), half_extents, -loading["speed"], top)


# --- the stages -----------------------------------------------------------------------------
settle = job["settle"]
moments_every = job["moments_every"]
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
        long_enough = step >= memory["standing_since"] + loading["steps_standing_still"]
        return "reached" if long_enough else None
    if force >= loading["target_force"]:
        if loading["steps_standing_still"] is None:
            return "reached"
        memory["standing_since"] = step
        model.punch["state"].vel = (0.0, 0.0, 0.0)
        return None
    depth = model.punch["start"] - (model.punch["state"].pos[2] - half_extents[1])
    memory["share"] = max(force / loading["target_force"], depth / loading["give_up_depth"])
    return "target_load_not_reached" if depth >= loading["give_up_depth"] else None


def run_stage(stage, step, rule):
    wall, cpu = time.monotonic(), time.process_time()
    memory = {"peak": job["energy_seen"], "share": 0.0}
    last_beat = wall
    if stage == "load" and model.punch["state"].vel[2] == 0.0:
        memory["standing_since"] = step

    tables.moment(model, stage, step)
    shown = step
    while True:
        if until_step is not None and step >= until_step:
            stop = "steps_done"
            break
        if stage == "load" and step == 0 and "loading_model" in job:
            model.change(job["loading_model"])
        O.step()
        step += 1
        stop = rule(step, memory)
        if stop is not None and (until_step is None or stop == "not_finite"):
            break
        if step % moments_every == 0:
            tables.moment(model, stage, step)
            shown = step
        if time.monotonic() - last_beat > 0.2:
            last_beat = time.monotonic()
            beat(stage, step, memory["share"])
    if shown != step:
        tables.moment(model, stage, step)
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


punch = job["punch"]
if punch is not None:
    model.add_punch(punch["centre"], half_extents, punch["velocity"], punch["start"])
model.evaluate_at_start()

go_on = True
if job["stage"] == "settle":
    settled = run_stage("settle", job["step"], settle_rule) == "settled"
    go_on = settled and not job["ends_settled"]
if go_on:
    if model.punch is None:
        lower_punch()
    run_stage("load", job["step"] if job["stage"] == "load" else 0, load_rule)

tables.close()
# By YADE's own count; one evaluation at the start moves nothing.
write_json("done.json", {"steps": O.iter - 1})
O.exitNoBacktrace()
