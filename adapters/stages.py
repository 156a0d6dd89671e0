"""The stages of a scene and their rules, for programs that stop at any step and say where the grains are.

A run has `step`, `motion` (x, z, vx, vz of each grain first), `to(step)`, `to_rule(step)`, `stop_punch()`, `show()` and `ends()`.
"""
import copy

from exchange import Clock, Refused, progress
from law import has_friction

# The most steps between two signs of life.
MOST_STEPS = 1000


class Settling:
    """The rule that ends settling."""

    def __init__(self, job):
        self.job, self.memory = job, {}

    def go(self, run, to):
        """Go on, at most to this step; why the stage ends there, if it does."""
        settle = self.job.asked["settle"]
        check = (run.step // settle["check_every"] + 1) * settle["check_every"]
        run.to(min(to, check, max(settle["max_steps"], run.step + 1)))
        return self.job.settle_rule(run.step, run.motion[: len(self.job.grains)], self.memory)

    def share(self):
        return self.memory.get("share", 0.0)


class Loading:
    """The rule that ends loading, and stops the punch when it has its force if it is to stand a while."""

    def __init__(self, job):
        self.asked, self.force = job.asked, 0.0
        # The step since which the punch stands.
        self.since = job.first if job.asked["punch"]["velocity"] == 0.0 else None

    def go(self, run, to):
        """As that of settling."""
        wait = self.asked["loading"]["steps_standing_still"]
        if self.since is not None:
            last = max(self.since + (wait or 0), run.step + 1)
            run.to(min(to, last))
            return "reached" if run.step == last else None
        if wait is None and self.asked["until_step"] is not None:
            return run.to(to)  # The rule would end nothing and stop nothing.
        reached, deep, self.force = run.to_rule(to)
        if reached and wait is not None:
            self.since = run.step
            run.stop_punch()
            return None
        return "reached" if reached else "target_load_not_reached" if deep else None

    def share(self):
        return self.force / self.asked["loading"]["target_force"]


def follow(job, rule, start):
    """Show a scene's moments until its stage ends; the run, and why it ended."""
    clock, asked = Clock(), job.asked
    stage, every, until = asked["stage"], asked["moments_every"], asked["until_step"]
    run, stop = start(job), None
    run.show()
    while stop is None and run.step != until:
        to = min((run.step // every + 1) * every, run.step + MOST_STEPS)
        stop = rule.go(run, to if until is None else min(to, until))
        if until is not None:
            stop = None
        if stop is not None or run.step % every == 0 or run.step == until:
            run.show()
        progress(stage, run.step, run.step / until if until else rule.share())
    run.ends()
    job.line(clock.end(stage, run.step, stop or "steps_done"))
    return run, stop


def settled(job, motion):
    """The job of loading after that of settling, which left the grains so."""
    after = copy.copy(job)
    after.first, after.asked = 0, dict(job.asked, stage="load")
    after.grains = [dict(grain, **dict(zip(job.names, of))) for grain, of in zip(job.grains, motion)]
    return after


def lower_punch(job):
    """Set the punch on the highest grain below it."""
    loading = job.asked["loading"]
    axis, half_extents = loading["axis"], loading["half_extents"]
    below = [of for of in job.grains if abs(of["x"] - axis) < half_extents[0] + of["radius"]]
    top = max([of["z"] + of["radius"] for of in below], default=0.0)
    centre, velocity = [axis, top + half_extents[1]], -loading["speed"]
    job.asked["punch"] = {"centre": centre, "half_extents": half_extents, "start": top, "velocity": velocity}


def run_scene(job, start):
    """Settle and load; the steps that were done. `start` starts the program with a job."""
    asked, steps = job.asked, 0
    goes_on = has_friction(job) and asked["until_step"] is None and not asked["ends_settled"]
    anew = "settling that goes on into loading with friction: the program is started anew, without springs of contacts"
    if goes_on and job.axes == "xz" and asked["stage"] == "settle":
        raise Refused(anew)
    if asked["stage"] == "settle":
        run, stop = follow(job, Settling(job), start)
        steps = run.step - job.first
        if asked["ends_settled"] or stop != "settled":
            return steps
        if goes_on:
            raise Refused(anew)
        job = settled(job, run.motion)
    if job.asked["punch"] is None:
        lower_punch(job)
    run, _ = follow(job, Loading(job), start)
    return steps + run.step - job.first


def run_case(job, start):
    """Go to each moment of a case; the steps that were done."""
    run = start(job)
    for step in job.asked["moments"]:
        run.to(step)
        run.show()
    run.ends()
    return run.step
