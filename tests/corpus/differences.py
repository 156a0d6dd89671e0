#!/usr/bin/env python3
"""Whether the corpus is one: every right engine is the plain one up to rounding, every wrong one is not.

    differences.py [--reference PROGRAM] FOLDER

Builds the engines of corpus.json in FOLDER, lets the plain one make starts (loose, falling, at rest, under the punch; springs, friction,
dashpots), runs every variant from them for 1, 10 and 100 steps, and prints how far each is from the plain one (or from
another program that speaks the protocol). Exit code 1 if a right one is far or a wrong one is not.
"""
import array
import argparse
import json
import math
import os
import random
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
RADIUS, WIDTH, COUNT, MODULUS, DENSITY = 0.005, 0.12, 250, 1e10, 2600.0
MOMENTS = [0, 1, 10, 100]
# Farther than a right engine may be, over the radius, after so many steps: several times what rounding was seen to make.
ROUNDING = {"double": {0: 0.0, 1: 1e-13, 10: 3e-13, 100: 3e-10}, "single": {0: 0.0, 1: 3e-5, 10: 5e-4, 100: 5e-2}}
DEFAULT = {"rotation": "free", "viscosity": {"kind": "none"}, "slip_velocity": "ratcheting_corrected",
           "torque_arms": "half_overlap", "new_contact_slip": "whole_step"}
BY_POINT = {"slip_velocity": "contact_point", "torque_arms": "contact_point", "new_contact_slip": "since_touch"}
# What a law has beside springs, its friction angle and its choices.
LAWS = {
    "springs": ([], 0.0, {}),
    "friction": (["friction"], 0.5, {}),
    "friction-by-point": (["friction"], 0.5, BY_POINT),
    "restitution": (["dashpots"], 0.0, {"viscosity": {"kind": "restitution", "e_n": 0.6, "tension": "clipped"}}),
    "both": (["friction", "dashpots"], 0.3, dict(BY_POINT, viscosity={"kind": "dashpot", "c_n": 900.0, "tension": "unclipped"})),
}


def model(law):
    _, angle, contact = LAWS[law]
    walls = [{"axis": "x", "place": 0.0}, {"axis": "x", "place": WIDTH}, {"axis": "z", "place": 0.0}]
    law = {"modulus": MODULUS, "stiffness_ratio": 0.8, "friction_angle": angle, "contact": dict(DEFAULT, **contact)}
    return {"gravity": [0.0, -9.81], "alpha": 0.2, "dt": 2.9e-5, "walls": walls, "law": law}


def cloud():
    """A loose lattice whose grains come down and across: columns x, z, vx, vz, radius."""
    chance, columns, rows = random.Random(1), 10, []
    for index in range(COUNT):
        place = [WIDTH / columns * (index % columns + 0.5), 0.0115 * (index // columns + 0.5)]
        rows.append([at + chance.uniform(-4e-4, 4e-4) for at in place] + [chance.uniform(-0.4, 0.4), chance.uniform(-0.5, 0.1)]
                    + [RADIUS * chance.uniform(0.95, 1.05)])
    return rows


class Case:
    def __init__(self, name, law, rows, punch=None):
        self.name, self.law, self.rows, self.punch = name, law, rows, punch
        self.turns = "friction" in LAWS[law][0]

    def write(self, folder, moments):
        os.makedirs(folder)
        job = {"kind": "case", "protocol": 1, "name": self.name, "model": model(self.law), "moments": moments, "punch": self.punch}
        with open(os.path.join(folder, "job.json"), "w", encoding="utf-8") as file:
            json.dump(job, file)
        with open(os.path.join(folder, "initial.csv"), "w", encoding="utf-8") as file:
            file.write("id,x,z,vx,vz,radius,mass" + (",spin,inertia" if self.turns else "") + "\n")
            for index, (x, z, vx, vz, radius, *spin) in enumerate(self.rows):
                mass = DENSITY * math.pi * radius * radius
                more = [spin[0] if spin else 0.0, 0.5 * mass * radius * radius] if self.turns else []
                file.write(",".join([str(index)] + [repr(value) for value in [x, z, vx, vz, radius, mass] + more]) + "\n")


class Moment:
    """One of tables.bin."""

    def __init__(self, numbers, at, line, turns):
        columns = 5 if turns else 4
        self.columns = [numbers[at + c * COUNT:at + (c + 1) * COUNT] for c in range(columns)]
        at += columns * COUNT
        self.contacts = {}
        for _ in range(line["contacts"]):
            row = numbers[at:at + 9]
            self.contacts[int(row[0]), int(row[1])] = row[2:]
            at += 9
        self.end, self.punch = at, line["punch"]

    def places(self):
        return list(zip(self.columns[0], self.columns[1]))


def run(program, cases, folder, moments, fault=""):
    """The moments of each case."""
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    names = ["case-%d" % index for index in range(len(cases))]
    with open(os.path.join(folder, "job.json"), "w", encoding="utf-8") as file:
        json.dump({"protocol": 1, "kind": "cases", "folders": names}, file)
    for name, case in zip(names, cases):
        case.write(os.path.join(folder, name), moments)
    subprocess.run([program, "run", folder], check=True, env=dict(os.environ, FAULT=fault))
    tracks = []
    for name, case in zip(names, cases):
        numbers, track, at = array.array("d"), [], 0
        with open(os.path.join(folder, name, "tables.bin"), "rb") as file:
            numbers.frombytes(file.read())
        with open(os.path.join(folder, name, "moments.jsonl"), encoding="utf-8") as file:
            for line in file:
                track.append(Moment(numbers, at, json.loads(line), case.turns))
                at = track[-1].end
        assert at == len(numbers), name
        tracks.append(track)
    shutil.rmtree(folder)
    return tracks


def build(variant, folder):
    program = os.path.join(folder, variant["name"])
    subprocess.run(["cc", "-std=c11", *variant["compile"], os.path.join(HERE, "engine.c"), "-lm", "-o", program], check=True)
    return program


def starts(program, folder):
    """Cases of each law."""
    made = []
    for law in LAWS:
        rows = cloud()

        def after(moment, rows=rows):
            return [[*(column[index] for column in moment.columns[:4]), rows[index][4], *(c[index] for c in moment.columns[4:])]
                    for index in range(COUNT)]

        (track,) = run(program, [Case("pour", law, rows)], folder, [2500, 12000])
        falling, resting = (after(moment) for moment in track)
        top = max(z + radius for x, z, _, _, radius, *_ in resting if abs(x - WIDTH / 2) < 0.02 + radius)
        punch = {"centre": [WIDTH / 2 + 0.002, top + 0.05], "half_extents": [0.02, 0.05], "start": top, "velocity": -0.2}
        (track,) = run(program, [Case("push", law, resting, punch)], folder, [2500])
        pushed = dict(punch, centre=track[0].punch["centre"])
        made += [Case(law + "/loose", law, rows), Case(law + "/falling", law, falling), Case(law + "/resting", law, resting),
                 Case(law + "/pushed", law, after(track[0]), pushed)]
    return made


def largest(pairs):
    return max((abs(a - b) for a, b in pairs), default=0.0)


def apart(one, other):
    """The largest differences of places, over the radius, and of velocities, spins and contact forces, which have no such scale."""
    places, *motions = ([*zip(a, b)] for a, b in zip([one.columns[0] + one.columns[1], *one.columns[2:]],
                                                    [other.columns[0] + other.columns[1], *other.columns[2:]]))
    none = [0.0] * 7
    forces = [(one.contacts.get(ids, none), other.contacts.get(ids, none)) for ids in one.contacts.keys() | other.contacts.keys()]
    return [largest(places) / RADIUS, max(map(largest, motions)), *(largest((a[c], b[c]) for a, b in forces) for c in (1, 2))]


QUANTITIES = ["places", "velocities", "normal forces", "shear forces"]


def differences(tracks, others):
    return {(case, step, what): value
            for case, (one, other) in enumerate(zip(tracks, others))
            for step, a, b in zip(MOMENTS, one, other)
            for what, value in zip(QUANTITIES, apart(a, b))}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--reference", metavar="PROGRAM", help="another engine than the plain one")
    parser.add_argument("folder", metavar="FOLDER")
    asked = parser.parse_args()
    with open(os.path.join(HERE, "corpus.json"), encoding="utf-8") as file:
        corpus = json.load(file)
    work = lambda name: os.path.join(asked.folder, "work-" + name)
    os.makedirs(asked.folder, exist_ok=True)
    programs = {variant["name"]: build(variant, asked.folder) for variant in corpus["right"]}
    cases = starts(programs["plain"], work("starts"))
    reference = run(asked.reference or programs["plain"], cases, work("reference"), MOMENTS)
    envelope, bad = {}, 0
    print("right: largest distance from the reference over the radius, by steps")
    for variant in corpus["right"]:
        found = differences(reference, run(programs[variant["name"]], cases, work("right"), MOMENTS))
        far = {step: max(found[case, step, "places"] for case in range(len(cases))) for step in MOMENTS}
        wrong = any(far[step] > ROUNDING[variant["precision"]][step] for step in MOMENTS)
        bad += wrong
        print("%-24s" % variant["name"], *("%9.1e" % far[step] for step in MOMENTS), "FAR" if wrong else "")
        if variant["precision"] == "double":
            envelope = {key: max(value, envelope.get(key, 0.0)) for key, value in found.items()}
    print("\nwrong: where it leaves the envelope of the right ones in double precision farthest, and how many times over")
    for variant in corpus["wrong"]:
        found = differences(reference, run(programs["plain"], cases, work("wrong"), MOMENTS, variant["fault"]))
        times = {key: value / envelope[key] if envelope[key] else math.inf if value else 0.0 for key, value in found.items()}
        # In the simplest laws that have what it needs.
        needs = set(variant["needs"]) & {"friction", "dashpots"}
        apt = [law for law, (parts, _, _) in LAWS.items() if needs == set(parts)]
        case, step, what = key = max((key for key in times if cases[key[0]].law in apt), key=times.get)
        bad += times[key] < 10.0
        print("%-24s %9.1e times: %s of %s after %d steps" % (variant["name"], times[key], what, cases[case].name, step),
              "NO FAULT" if times[key] < 10.0 else "")
    sys.exit(bad > 0)


main()
