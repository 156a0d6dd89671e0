"""Run one crossgrain scene in YADE and write tables.

Fixed text: nothing is ever spliced into this file. It reads, from the folder named by the
environment variable CROSSGRAIN_JOB (or the current folder),

    scene.json    the scene, as `crossgrain scene paper` prints it
    initial.csv   id,x,z,vx,vz,radius,mass of every grain at the start
    job.json      what to run: time step, loop order, where to start and stop

and writes there hello.json (who is running), heartbeat (a line now and then), frames.bin and
frames.jsonl (moments of the run, see README.md) and, last of all, done.json.

The plane is YADE's x-z plane. Bodies are made in this order: grains, left wall, right wall,
floor, and the punch when loading starts.
"""
import csv
import json
import math
import os
import sys
import time
from array import array

folder = os.environ.get("CROSSGRAIN_JOB", os.getcwd())
parent = os.getppid()

from yadeimport import *  # noqa: E402,F403  starts YADE without any listening socket
from yade import config, utils  # noqa: E402


def place(name):
    return os.path.join(folder, name)


def read_json(name):
    with open(place(name), encoding="utf-8") as file:
        return json.load(file)


def write_json(name, value):
    aside = place(name + ".part")
    with open(aside, "w", encoding="utf-8") as file:
        json.dump(value, file)
    os.replace(aside, place(name))


write_json("hello.json", {"version": str(config.version), "python": sys.version.split()[0]})

scene = read_json("scene.json")
job = read_json("job.json")
with open(place("initial.csv"), encoding="utf-8", newline="") as file:
    rows = list(csv.DictReader(file))

# --- the bodies -----------------------------------------------------------------------------
material = FrictMat(
    young=scene["material"]["youngs_modulus"],
    poisson=scene["material"]["stiffness_ratio"],
    frictionAngle=scene["material"]["friction_angle"],
    density=scene["material"]["density"],
)
O.materials.append(material)
grey = (0.7, 0.7, 0.7)  # without a colour, YADE reseeds Python's random numbers

states = []
masses = []
radii = []
for row in rows:
    radius = float(row["radius"])
    body = utils.sphere((float(row["x"]), 0.0, float(row["z"])), radius, material=material, color=grey)
    body.state.mass = float(row["mass"])
    body.state.blockedDOFs = "yXYZ"
    body.state.vel = (float(row["vx"]), 0.0, float(row["vz"]))
    O.bodies.append(body)
    states.append(body.state)
    masses.append(body.state.mass)
    radii.append(radius)
width = scene["box"]["width"]
for position, axis in ((0.0, 0), (width, 0), (0.0, 2)):
    O.bodies.append(utils.wall(position, axis=axis, sense=0, material=material, color=grey))

loading = scene["loading"]
half_width = loading["half_width"]
half_height = 0.5 * loading["punch_height"]
target_force = 2.0 * half_width * loading["pressure"]
punch = None


def add_punch(centre_x, centre_z, start):
    global punch
    body = utils.box(
        (centre_x, 0.0, centre_z),
        (half_width, job["punch_half_depth"], half_height),
        fixed=True,
        material=material,
        color=grey,
    )
    body.state.blockedDOFs = "xyzXYZ"
    body.state.vel = (0.0, 0.0, -loading["speed"])
    punch = {"id": O.bodies.append(body), "state": body.state, "start": start}


def lower_punch():
    """Set the punch on the highest grain below it."""
    axis = 0.5 * width
    top = 0.0
    for state, radius in zip(states, radii):
        if abs(state.pos[0] - axis) < half_width + radius:
            top = max(top, state.pos[2] + radius)
    add_punch(axis, top + half_height, top)


# --- the engines ----------------------------------------------------------------------------
# Integration stands first, so that after each step forces and contacts belong to the positions.
newton = NewtonIntegrator(
    gravity=(0.0, 0.0, -scene["gravity"]),
    damping=scene["damping"]["alpha"],
    dampGravity=True,
    warnNoForceReset=False,
)
O.engines = [
    newton,
    ForceResetter(),
    InsertionSortCollider(
        [Bo1_Sphere_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb()],
        verletDist=job["verlet_distance"],
    ),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_FrictPhys()],
        [Law2_ScGeom_FrictPhys_CundallStrack()],
        loopOnSortedInteractions=job["sorted"],
    ),
]
O.dt = job["dt"]

# --- tables ---------------------------------------------------------------------------------
frames_binary = open(place("frames.bin"), "wb")
frames_index = open(place("frames.jsonl"), "w", encoding="utf-8")
heartbeat = open(place("heartbeat"), "w", encoding="utf-8")


def line(value):
    frames_index.write(json.dumps(value) + "\n")
    frames_index.flush()


def frame(stage, step):
    positions = [state.pos for state in states]
    velocities = [state.vel for state in states]
    table = array("d")
    for column, axis in ((positions, 0), (positions, 2), (velocities, 0), (velocities, 2)):
        table.extend([vector[axis] for vector in column])
    count = 0
    for contact in O.interactions:
        if not contact.isReal:
            continue
        geometry, physics = contact.geom, contact.phys
        normal, point = geometry.normal, geometry.contactPoint
        force = physics.normalForce + physics.shearForce
        table.extend(
            (
                contact.id1,
                contact.id2,
                geometry.penetrationDepth,
                normal[0],
                normal[2],
                force[0],
                force[2],
                point[0],
                point[2],
            )
        )
        count += 1
    table.tofile(frames_binary)
    frames_binary.flush()
    out_of_plane = max(abs(p[1]) + abs(v[1]) for p, v in zip(positions, velocities))
    at = None
    if punch is not None:
        where = punch["state"].pos
        at = {
            "centre": [where[0], where[2]],
            "start": punch["start"],
            "velocity": punch["state"].vel[2],
            "force": O.forces.f(punch["id"])[2],
        }
    line(
        {
            "frame": stage,
            "step": step,
            "bodies": len(states),
            "contacts": count,
            "out_of_plane": out_of_plane,
            "punch": at,
        }
    )


def beat(stage, step, share):
    if os.getppid() != parent:
        os._exit(1)  # whoever asked for this run is gone
    heartbeat.write("%s %d %.4f\n" % (stage, step, share))
    heartbeat.flush()


def kinetic_energy():
    energy = 0.0
    for mass, state in zip(masses, states):
        v = state.vel
        energy += 0.5 * mass * (v[0] * v[0] + v[2] * v[2])
    return energy


# --- the stages -----------------------------------------------------------------------------
settle = scene["settle"]
history_every = scene["measurement"]["history_every"]
until_step = job["until_step"]


def settle_rule(step, memory):
    if step % settle["check_every"] == 0:
        energy = kinetic_energy()
        if not math.isfinite(energy):
            return "not_finite"
        memory["peak"] = max(memory["peak"], energy)
        if energy <= settle["kinetic_energy_fraction"] * memory["peak"]:
            return "settled"
        memory["share"] = math.log(energy / memory["peak"]) / math.log(settle["kinetic_energy_fraction"])
    return "max_steps" if step >= settle["max_steps"] else None


def load_rule(step, memory):
    force = O.forces.f(punch["id"])[2]
    if not math.isfinite(force):
        return "not_finite"
    if force >= target_force:
        return "reached"
    depth = punch["start"] - (punch["state"].pos[2] - half_height)
    memory["share"] = max(force / target_force, depth / loading["give_up_depth"])
    return "sank_to_give_up_depth" if depth >= loading["give_up_depth"] else None


def run_stage(stage, step, rule):
    wall, cpu = time.monotonic(), time.process_time()
    memory = {"peak": 0.0, "share": 0.0}
    last_beat = wall
    frame(stage, step)
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
            frame(stage, step)
            framed = step
        if time.monotonic() - last_beat > 0.2:
            last_beat = time.monotonic()
            beat(stage, step, memory["share"])
    if framed != step:
        frame(stage, step)
    line(
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
    at = start["punch"]
    add_punch(at["centre"][0], at["centre"][1], at["start"])

newton.dead = True  # evaluate the forces at the start without moving anything
O.step()
newton.dead = False

go_on = True
if start["stage"] == "settle":
    go_on = run_stage("settle", start["step"], settle_rule) == "settled"
if go_on:
    if punch is None:
        lower_punch()
    run_stage("load", start["step"] if start["stage"] == "load" else 0, load_rule)

frames_binary.close()
frames_index.close()
write_json("done.json", {"steps_by_yade": O.iter - 1})
O.exitNoBacktrace()
