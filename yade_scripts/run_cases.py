"""Run a job of kind `cases` of the engine protocol in YADE, one case after the other in one process.

Fixed text. Case by case it writes the state at each moment, effective.json with the parameters that YADE uses, and in
small cases, up to the setting `loads_up_to`, forces and torques summed on each grain.
"""
import os
import time

import model_in_yade
from model_in_yade import Tables, beat, case_in_yade, friction_angles, read_json, write_json
from yadeimport import *  # noqa: F403

model_in_yade.say_hello()

job = read_json("job.json")


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
                "k_s": float(physics.ks) if max(friction_angles(model.law)) > 0.0 else None,
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
for index, name in enumerate(job["folders"]):
    case, grains, model = case_in_yade(name, job["settings"])
    model.evaluate_at_start()
    write_json(os.path.join(name, "effective.json"), effective(model))
    tables = Tables(name)
    step = 0
    for moment in case["moments"]:
        while step < moment:
            O.step()
            step += 1
            if time.monotonic() - last_beat > 0.2:
                last_beat = time.monotonic()
                beat("settle", steps_done + step, index / len(job["folders"]))
        small = len(grains) <= job["settings"]["loads_up_to"]
        tables.moment(model, "settle", step, **({"loads": loads(model)} if small else {}))
    tables.close()
    # By YADE's own count; one evaluation at the start moves nothing.
    steps_done += O.iter - 1

write_json("done.json", {"steps": steps_done})
O.exitNoBacktrace()
