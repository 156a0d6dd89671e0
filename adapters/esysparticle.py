#!/usr/bin/env python3
"""ESyS-Particle as an engine of crossgrain: spheres that do not turn, in one plane or in space.

Its step is the leapfrog, with velocities of the half step before the positions, as crossgrain has it. It is an MPI job
of two processes, and `mpirun` listens on all addresses, so both have a network of their own, which nobody else sees.
The master of the two runs this file anew.

There is no friction: `RotFrictionPrms` has it between grains, but of its groups for walls and meshes none takes a friction coefficient.
"""
import json
import math
import os
import shutil
import subprocess
import sys

from apart import alone, mpirun, surroundings
from exchange import Clock, Job, Refused, progress, serve
from law import pair_contacts, refuse, wall_contacts

HERE = os.path.abspath(sys.argv[0])
# Tells the master the folder of its job.
INSIDE = "CROSSGRAIN_ESYSPARTICLE_JOB"
# What the master answers, in that folder.
ANSWER = "answer.json"
NEEDED = {"esysparticle": "esys-particle", "mpirun": "openmpi-bin", "unshare": "util-linux"}
PARTS = ["normal_spring", "local_damping", "gravity", "walls", "stop_rules", "cases", "space"]
APPROXIMATIONS = [
    "the spring of two grains has the mean of both stiffnesses, E·(R1 + R2)/2, not both in series",
    "local damping goes by the sign of the velocity before the kick, not of that halfway through it, and spares what is at rest",
]
RULES = {"damping_velocity": "before", "stiffness_mean": "arithmetic"}
# As the program has it, which multiplies the stiffness of a wall by it and the radius.
PI = 3.141592654
# Distance within which neighbours are listed, beyond touching, over the largest radius.
SKIN = 0.2
# The most cells of its grid along an axis.
MOST_CELLS = 1000
# The most steps between two signs of life.
MOST_STEPS = 1000


def in_program(folder):
    """Have the program do the job in this folder, apart from the line that ends it; what it answers."""
    environment = dict(surroundings(folder), PYTHONPATH=os.path.dirname(HERE), **{INSIDE: folder})
    command = alone([*mpirun(2), "esysparticle", HERE])
    subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, stdout=sys.stderr, check=True)
    with open(os.path.join(folder, ANSWER), encoding="utf-8") as file:
        return json.load(file)


def refuse_two_sides(job):
    for wall in job.model["walls"]:
        if len({grain[wall["axis"]] > wall["place"] for grain in job.grains}) > 1:
            raise Refused("grains on both sides of a wall")


class Bed:
    """The grains in the program."""

    def __init__(self, job, program):
        from esys.lsm import GravityPrms, LocalDampingPrms, NRotElasticPrms, NRotElasticWallPrms, NRotSphere
        from esys.lsm.util import BoundingBox, Vec3

        self.job, self.program, self.step, model = job, program, job.first, job.model
        largest = max(grain["radius"] for grain in job.grains)
        low, high = domain(job, 4.0 * largest)
        cell = max(2.0 * (1.0 + SKIN) * largest, *((above - below) / MOST_CELLS for below, above in zip(low, high)))
        program.initNeighbourSearch("NRotSphere", cell, SKIN * largest)
        program.setNumTimeSteps(2**31 - 1)
        program.setTimeStepSize(model["dt"])
        # The plane has x and y in the program, which is in space.
        plane = job.axes == "xz"
        whole = lambda vector, across=0.0: Vec3(*vector, *[across] * plane)
        program.setSpatialDomain(BoundingBox(whole(low, -2.0 * cell), whole(high, 2.0 * cell)))
        spheres = []
        for index, grain in enumerate(job.grains):
            spheres.append(NRotSphere(index, whole([grain[axis] for axis in job.axes]), grain["radius"], grain["mass"]))
            spheres[-1].setLinearVelocity(whole([grain["v" + axis] for axis in job.axes]))
        program.createParticles(spheres)
        # Scaled by a quarter of the sum of both radii.
        groups = [NRotElasticPrms("springs", 2.0 * model["law"]["modulus"], True)]
        across, up = model["gravity"]
        groups.append(GravityPrms("gravity", whole((across, up) if plane else (across, 0.0, up))))
        for index, wall in enumerate(model["walls"]):
            name, axis = "wall %d" % index, job.axes.index(wall["axis"])
            side = 1.0 if job.grains[0][wall["axis"]] > wall["place"] else -1.0
            place, normal = [0.0] * 3, [0.0] * 3
            place[axis], normal[axis] = wall["place"], side
            program.createWall(name, Vec3(*place), Vec3(*normal))
            groups.append(NRotElasticWallPrms("springs of " + name, name, model["law"]["modulus"] / PI))
        if model["alpha"] != 0.0:
            groups.append(LocalDampingPrms("damping", model["alpha"]))
        for group in groups:
            program.createInteractionGroup(group)

    def to(self, step):
        while self.step < step:
            self.program.runTimeStep()
            self.step += 1

    def motion(self):
        grains = sorted(self.program.getParticleList(), key=lambda grain: grain.getId())
        if len(grains) != len(self.job.grains):
            raise RuntimeError("grains were lost: %d of %d are left" % (len(grains), len(self.job.grains)))
        both = ((grain.getPosn(), grain.getVelocity()) for grain in grains)
        if self.job.axes == "xyz":
            return [(place[0], place[2], velocity[0], velocity[2], place[1], velocity[1]) for place, velocity in both]
        return [(place[0], place[1], velocity[0], velocity[1]) for place, velocity in both]

    def show(self, motion):
        radius, modulus = lambda grain: self.job.grains[grain]["radius"], self.job.model["law"]["modulus"]
        places = [of[:2] if self.job.axes == "xz" else (of[0], of[4], of[1]) for of in motion]
        push = lambda one, two, overlap: 0.5 * modulus * (radius(one) + radius(two)) * overlap
        rows = pair_contacts(self.job, push, places)
        self.job.moment("settle", self.step, motion, rows + wall_contacts(self.job, radius, places))


def domain(job, margin):
    """Where grains may go: lower and upper corner."""
    speeds = (math.hypot(*(grain["v" + axis] for axis in job.axes)) for grain in job.grains)
    (across, up), fastest = job.model["gravity"], max(speeds)
    if job.kind == "case":
        time = job.asked["moments"][-1] * job.model["dt"]
        margin += fastest * time + 0.5 * math.hypot(across, up) * time * time
    else:
        margin += 0.5 * fastest * fastest / max(-up, 1.0e-3)
    places = {axis: [grain[axis] for grain in job.grains] for axis in job.axes}
    for wall in job.model["walls"]:
        places[wall["axis"]].append(wall["place"])
    return [min(places[axis]) - margin for axis in job.axes], [max(places[axis]) + margin for axis in job.axes]


def settle(job, bed):
    """Show a scene's moments until settling ends; why it ended."""
    asked, memory = job.asked, {}
    every, until, check = asked["moments_every"], asked["until_step"], asked["settle"]["check_every"]
    stop, motion = None, bed.motion()
    bed.show(motion)
    while stop is None and bed.step != until:
        last = max(asked["settle"]["max_steps"], bed.step + 1) if until is None else until
        bed.to(min((bed.step // every + 1) * every, (bed.step // check + 1) * check, bed.step + MOST_STEPS, last))
        motion = bed.motion()
        stop = job.settle_rule(bed.step, motion, memory) if until is None else None
        if stop is not None or bed.step % every == 0 or bed.step == until:
            bed.show(motion)
        progress("settle", bed.step, bed.step / until if until else memory.get("share", 0.0))
    return stop or "steps_done"


def master(folder):
    """The job, in the master."""
    from esys.lsm import LsmMpi

    program = LsmMpi(1, [1, 1, 1])
    job = Job(folder)
    bed, stop = Bed(job, program), None
    if job.kind == "scene":
        stop = settle(job, bed)
    else:
        for step in job.asked["moments"]:
            bed.to(step)
            bed.show(bed.motion())
    answer = [bed.step, stop]
    program.exit()
    with open(os.path.join(folder, ANSWER), "w", encoding="utf-8") as file:
        json.dump(answer, file)


def description():
    for name, package in NEEDED.items():
        if shutil.which(name) is None:
            raise SystemExit(
                "there is no program `%s` on the path; on Debian: apt-get install --no-install-recommends %s" % (name, package)
            )
    if subprocess.run(alone(["true"]), stdin=subprocess.DEVNULL).returncode != 0:
        raise SystemExit("a program may have no network of its own here, and its MPI would listen on all addresses")
    # Its two processes wait for each other busily, which takes long on a machine that is busy itself; Debian's Python needs none.
    ask = "from esys.lsm.util import InstallInfo; print(InstallInfo.version)"
    said = subprocess.run(["/usr/bin/python3", "-c", ask], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, check=True, text=True)
    version = said.stdout.strip()
    return {"protocol": 2, "name": "ESyS-Particle", "version": version, "parts": PARTS, "approximations": APPROXIMATIONS, "rules": RULES}


def run_scene(job):
    refuse(job)
    refuse_two_sides(job)
    clock = Clock()
    step, stop = in_program(job.folder)
    job.index = open(job.place("moments.jsonl"), "a", encoding="utf-8")
    job.line(clock.end("settle", step, stop))
    return step - job.first


def run_case(job):
    refuse(job)
    refuse_two_sides(job)
    return in_program(job.folder)[0]


if __name__ == "__main__":
    if INSIDE in os.environ:
        master(os.environ[INSIDE])
    else:
        serve(description, run_scene, run_case)
