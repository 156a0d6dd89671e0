"""Version 1 of crossgrain's engine protocol, as an engine in Python sees it (docs/engine-protocol.md)."""
import csv
import json
import math
import os
import sys
import time
from array import array

PROTOCOL = 1
MOTION = ("x", "z", "vx", "vz")
CONTACTS = "id1,id2,overlap,fn,ft,nx,nz,x,z"
IN_SPACE = (*MOTION, "spin", "y", "vy", "spin_x", "spin_z")


class Refused(Exception):
    """The job asks for something that the engine does not have."""


class Job:
    """One folder: a scene or a case, what it asks for and what is written of it."""

    def __init__(self, folder):
        self.folder = folder
        with open(self.place("job.json"), encoding="utf-8") as file:
            self.asked = json.load(file)
        if self.asked["protocol"] != PROTOCOL:
            sys.exit("this engine speaks protocol %d, the job is of %s" % (PROTOCOL, self.asked["protocol"]))
        self.kind = self.asked["kind"]
        if self.kind == "cases":
            return
        with open(self.place("initial.csv"), encoding="utf-8", newline="") as file:
            self.rows = list(csv.DictReader(file))
        self.grains = [{key: float(value) for key, value in row.items()} for row in self.rows]
        self.model = self.asked["model"]
        # The coordinates that grains have, and in space the columns of their motion.
        self.axes = "xyz" if self.rows and "y" in self.rows[0] else "xz"
        self.names = [name for name in IN_SPACE if name in self.rows[0]] if self.axes == "xyz" else MOTION
        self.first = self.asked["step"] if self.kind == "scene" else 0
        self.index = None

    def place(self, name):
        return os.path.join(self.folder, name)

    def inner(self):
        """The jobs of a list of cases."""
        return [Job(self.place(name)) for name in self.asked["folders"]]

    def line(self, value):
        if self.index is None:
            self.index = open(self.place("moments.jsonl"), "w", encoding="utf-8")
        self.index.write(json.dumps(value) + "\n")
        self.index.flush()

    def moment(self, stage, step, motion, contacts, punch=None):
        """Write a moment: (x, z, vx, vz), and the spin of one that turns, of each grain, and rows of contacts in any order. In space the
        motion is that of `names`, and rows have the tangential force, the normal and the point as vectors of three."""
        if self.axes == "xyz":
            return self.tables(stage, step, motion, contacts, punch)
        turns = "spin" in self.rows[0]
        with open(self.place("%s-%d-bodies.csv" % (stage, step)), "w", encoding="utf-8") as file:
            file.write("id,x,z,vx,vz,radius,mass%s\n" % (",spin,inertia" if turns else ""))
            for row, (x, z, vx, vz, *spin) in zip(self.rows, motion):
                turning = ",%r,%s" % (*spin, row["inertia"]) if turns else ""
                file.write("%s,%r,%r,%r,%r,%s,%s%s\n" % (row["id"], x, z, vx, vz, row["radius"], row["mass"], turning))
        with open(self.place("%s-%d-contacts.csv" % (stage, step)), "w", encoding="utf-8") as file:
            file.write(CONTACTS + "\n")
            for row in sorted(contacts):
                file.write("%d,%d,%r,%r,%r,%r,%r,%r,%r\n" % tuple(row))
        self.line({"stage": stage, "step": step, "punch": punch})

    def tables(self, stage, step, motion, contacts, punch):
        """The same in space, as numbers."""
        table = array("d", (of[at] for at in range(len(self.names)) for of in motion))
        for one, two, overlap, fn, ft, nx, ny, nz, x, y, z in sorted(contacts):
            table.extend((one, two, overlap, fn, math.hypot(*ft), nx, nz, x, z, ny, y, ft[0], ft[1], ft[2]))
        with open(self.place("tables.bin"), "ab") as file:
            table.tofile(file)
        self.line({"stage": stage, "step": step, "punch": punch, "contacts": len(contacts)})

    def settle_rule(self, step, motion, memory):
        """Why settling ends in this step, if it does; `memory` keeps the peak of the kinetic energy."""
        settle = self.asked["settle"]
        if step % settle["check_every"] == 0:
            energy = 0.0
            for grain, (_, _, vx, vz, *spin) in zip(self.grains, motion):
                further = 0.0
                if self.axes == "xyz":
                    of = dict(zip(self.names[4:], spin))
                    further, spin = of["vy"] ** 2, [of[name] for name in of if name.startswith("spin")]
                energy += 0.5 * grain["mass"] * (vx * vx + vz * vz + further) + sum(0.5 * grain["inertia"] * of * of for of in spin)
            memory["peak"] = max(memory.get("peak", self.asked["energy_seen"]), energy)
            fraction = settle["kinetic_energy_fraction"]
            if energy <= fraction * memory["peak"]:
                return "settled"
            # The energy falls about exponentially, so its logarithm tells how far settling is.
            memory["share"] = math.log(energy / memory["peak"]) / math.log(fraction)
        return "max_steps" if step >= settle["max_steps"] else None


def progress(stage, step, share):
    print("%s %d %.4f" % (stage, step, share), flush=True)


def serve(description, run_scene, run_case, time_steps=None):
    """Answer `describe` and `run FOLDER`; the first two functions take a job and return the steps that they did, the third
    one takes a job of kind `timing` and returns what belongs into done.json."""
    if sys.argv[1:] == ["describe"]:
        print(json.dumps({"protocol": PROTOCOL, **description()}))
        return
    if len(sys.argv) != 3 or sys.argv[1] != "run":
        sys.exit("usage: %s describe | run FOLDER" % sys.argv[0])
    job = Job(sys.argv[2])
    steps, times = 0, {}
    for one in job.inner() if job.kind == "cases" else [job]:
        try:
            if one.kind == "timing":
                times = time_steps(one)
                steps += times["steps"]
            else:
                steps += run_case(one) if one.kind == "case" else run_scene(one)
        except Refused as reason:
            # Alone, whatever was told before.
            one.index = None
            one.line({"refused": str(reason)})
    with open(job.place("done.json"), "w", encoding="utf-8") as file:
        json.dump(dict(times, steps=steps), file)


class Clock:
    """Time on the clock and of the processor since its start; another program's counts when it has ended."""

    def __init__(self):
        self.wall = time.monotonic()
        self.cpu = self.spent()

    @staticmethod
    def spent():
        of = os.times()
        return of.user + of.system + of.children_user + of.children_system

    def end(self, stage, steps, stop):
        return {
            "end": stage,
            "steps": steps,
            "stop": stop,
            "wall_seconds": time.monotonic() - self.wall,
            "cpu_seconds": self.spent() - self.cpu,
        }
