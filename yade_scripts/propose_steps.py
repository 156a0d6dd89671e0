"""Ask YADE which time step it would choose for each of some cases, without moving anything.

Fixed text. Reads a job of kind `cases` and writes proposals.json: a line a case with
PWaveTimeStep and the step that a GlobalStiffnessTimeStepper sets, without and with dashpots. Last of all done.json.
"""
import model_in_yade
from model_in_yade import case_in_yade, dashpot, read_json, write_json
from yadeimport import *  # noqa: F403
from yade import utils

model_in_yade.say_hello()

job = read_json("job.json")


def stepper(viscous):
    """The step that YADE's stepper sets at its first look; from a huge step its limit on growth does not bind."""
    engine = GlobalStiffnessTimeStepper(active=True, timeStepUpdateInterval=1, viscEl=viscous)
    O.engines = O.engines + [engine]
    O.dt = 1.0e3
    O.step()
    chosen = float(O.dt)
    O.engines = O.engines[:-1]
    return chosen


proposals = []
for name in job["folders"]:
    _, grains, model = case_in_yade(name)
    if not model.rotates:
        # The stepper looks at rotations even where they are blocked: a ball of this mass.
        for state, grain in zip(model.states, grains):
            inertia = 0.4 * grain["mass"] * grain["radius"] ** 2
            state.inertia = (inertia, inertia, inertia)
    model.evaluate_at_start()
    p_wave = float(utils.PWaveTimeStep())
    model.newton.dead = True
    chosen = stepper(False)
    # Of contacts without dashpots viscEl=True reads what is not there: steps of 1e-41 s were seen.
    viscous = stepper(True) if dashpot(model.law) is not None else chosen
    proposals.append({"p_wave": p_wave, "global_stiffness": chosen, "with_dashpots": viscous})

write_json("proposals.json", proposals)
write_json("done.json", {"steps": 0})
O.exitNoBacktrace()
