"""Run small verification cases in YADE, one after the other in one process, and write tables.

Fixed text. Reads cases.json and job.json from the folder named by CROSSGRAIN_JOB and writes, case by
case, the state at each of its moments (frames.bin, frames.jsonl as in run_scene.py) after a line with
the parameters that YADE uses for it; where a case asks for them, also forces and torques summed on each grain. Last of all done.json.
"""
import time

import model_in_yade
from model_in_yade import ModelInYade, Tables, read_json, write_json
from yadeimport import *  # noqa: F403

model_in_yade.say_hello()

job = read_json("job.json")
cases = read_json("cases.json")
tables = Tables()
KEYS = ("x", "z", "vx", "vz", "radius", "mass", "spin", "inertia")


def effective(model):
    """What YADE itself says of the case."""
    contacts = []
    for contact in model.real_contacts():
        physics = contact.phys
        contacts.append(
            {
                "id1": contact.id1,
                "id2": contact.id2,
                "k_n": float(physics.kn),
                "k_s": float(physics.ks) if model.law["friction_angle"] > 0.0 else None,
                "tan_phi": float(physics.tangensOfFrictionAngle),
                "c_n": float(getattr(physics, "cn", 0.0)),
            }
        )
    gravity = model.newton.gravity
    return {
        "contacts": contacts,
        "mass": [float(state.mass) for state in model.states],
        "inertia": [float(state.inertia[1]) for state in model.states] if model.rotates else [],
        "gravity": [float(gravity[0]), float(gravity[2])],
        "alpha": float(model.newton.damping),
        "dt": float(O.dt),
    }


def loads(model):
    """Force and torque summed on each grain: x, z, and about y."""
    rows = []
    for body in range(model.grains):
        force, torque = O.forces.f(body), O.forces.t(body)
        rows.append([float(force[0]), float(force[2]), float(torque[1])])
    return rows


steps_done = 0
last_beat = time.monotonic()
for index, case in enumerate(cases):
    O.reset()
    grains = [dict(zip(KEYS, row)) for row in case["bodies"]]
    model = ModelInYade(case["model"], grains, True, case["verlet_distance"])
    if case["punch"] is not None:
        punch = case["punch"]
        model.add_punch(
            punch["centre"], punch["half_extents"], job["punch_half_depth"], punch["velocity"], punch["start"]
        )
    model.evaluate_at_start()
    tables.line({"effective": index, "parameters": effective(model)})
    step = 0
    for moment in case["moments"]:
        while step < moment:
            O.step()
            step += 1
            if time.monotonic() - last_beat > 0.2:
                last_beat = time.monotonic()
                tables.beat("settle", steps_done + step, index / len(cases))
        head = {"case": index, "step": step}
        if case["loads"]:
            head["loads"] = loads(model)
        tables.frame(model, head)
    # By YADE's own count; one evaluation at the start moves nothing.
    steps_done += O.iter - 1

tables.close()
write_json("done.json", {"steps_by_yade": steps_done})
O.exitNoBacktrace()
