"""Open the bed of a run folder in YADE, to look at it or to go on with it there:

    /usr/bin/python3 -i yade_scripts/open_run.py RUN             # the bed at the end
    /usr/bin/python3 -i yade_scripts/open_run.py RUN --settled   # before the punch

Needs Debian's yade, the Python that it was built for, and `crossgrain` on the path (or named by the variable CROSSGRAIN).
Then `O` is the scene, as in YADE's own shell: `O.run(1000, wait=True)`, `O.save("bed.yade.gz")`. YADE is imported and not
started, so that it opens no socket.
"""
import atexit
import csv
import gzip
import hashlib
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile


def import_yade():
    """The module that the scripts share, with YADE's program under a name that Python can import."""
    program = os.environ.get("CROSSGRAIN_YADE") or shutil.which("yade")
    if program is None:
        sys.exit("there is no program `yade` on the path; install Debian's package yade")
    place = tempfile.mkdtemp(prefix="crossgrain-")
    atexit.register(shutil.rmtree, place, ignore_errors=True)
    os.symlink(program, os.path.join(place, "yadeimport.py"))
    sys.path[:0] = [place, os.path.dirname(os.path.abspath(__file__))]
    # YADE reads the command line even where it is imported.
    words, sys.argv = sys.argv, sys.argv[:1]
    import model_in_yade

    sys.argv = words
    return model_in_yade


def read_files(folder):
    """The text of each file of a run folder, unpacked, if each is as it was written."""
    texts = {}
    try:
        with open(os.path.join(folder, "SHA256SUMS"), encoding="utf-8") as file:
            sums = [line.split("  ") for line in file.read().splitlines()]
        for digest, name in sums:
            with open(os.path.join(folder, name), "rb") as file:
                stored = file.read()
            if hashlib.sha256(stored).hexdigest() != digest:
                sys.exit("%s/%s was changed after it was written; put back what was there, or run it again" % (folder, name))
            text = gzip.decompress(stored) if name.endswith(".gz") else stored
            texts[name[:-3] if name.endswith(".gz") else name] = text.decode("utf-8")
    except (OSError, ValueError) as error:
        sys.exit("%s is no run folder: %s; give one that `crossgrain run` wrote" % (folder, error))
    return texts


def rows(text):
    """A table as dictionaries; an empty cell is none."""
    number = lambda key, of: of if key in ("stage", "state") else float(of) if of else None
    return [{key: number(key, of) for key, of in row.items()} for row in csv.DictReader(io.StringIO(text))]


def model_of(folder, loading):
    """What crossgrain gives engines for this scene: gravity, walls, contact law."""
    program = os.environ.get("CROSSGRAIN", "crossgrain")
    command = [program, "scene", "model", os.path.join(folder, "scene.json")]
    try:
        told = subprocess.run(command + ["--loading"] * loading, stdout=subprocess.PIPE, check=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit("crossgrain does not tell the model: %s; put it on the path, or name it by CROSSGRAIN" % error)
    model = json.loads(told)
    law = model["law"]
    contact, angles = law["contact"], import_yade().friction_angles(law)
    kind = contact["viscosity"]["kind"]
    arms = contact["slip_velocity"] == contact["torque_arms"] == "contact_point"
    lacks = kind == "restitution" or kind == "dashpot" and contact["viscosity"]["tension"] == "unclipped"
    lacks |= kind == "dashpot" and (max(angles) > 0.0 and not arms or min(angles) < max(angles))
    if lacks or max(angles) > 0.0 and contact["new_contact_slip"] == "since_touch":
        sys.exit("YADE does not have the contacts of %s; `crossgrain run --engine yade` says what it lacks" % folder)
    return model


def punch_of(record, scene, files):
    """Centre, half extents, velocity and start of the punch at the end."""
    punch = record.get("restart", {}).get("punch")
    if punch is not None:
        return punch
    # A run of another engine says only how deep it is, so that its place is good to rounding.
    loading = scene["loading"]
    half = [loading["half_width"], 0.5 * loading["punch_height"]]
    axis = 0.5 * scene["box"]["width"]
    below = [row for row in rows(files["settled-bodies.csv"]) if abs(row["x"] - axis) < half[0] + row["radius"]]
    start = max([0.0] + [row["z"] + row["radius"] for row in below])
    depth = rows(files["history.csv"])[-1]["punch_depth"]
    standing = record["stages"][-1]["stop"] == "reached" and loading["after_force"] != "measure_at_once"
    velocity = 0.0 if standing else -loading["speed"]
    return {"centre": [axis, start - depth + half[1]], "half_extents": half, "velocity": velocity, "start": start}


def load(folder, settled=False):
    """An empty YADE scene gets the bed: grains with velocities and spins, walls, the punch, and contacts with the tangential
    forces that they remember. Returns the ModelInYade; its `states` are the grains'."""
    files = read_files(folder)
    record, scene = json.loads(files["run.json"]), json.loads(files["scene.json"])
    loaded = record["stages"][-1]["stage"] == "load" and not settled
    before = "settled-" if settled and "settled-bodies.csv" in files else ""
    model = model_of(folder, loaded)
    shared = import_yade()
    O, Vector3 = shared.O, shared.Vector3
    grains = rows(files[before + "bodies.csv"])
    distance = shared.VERLET_OVER_RADIUS * min(grain["radius"] for grain in grains)
    bed = shared.ModelInYade(model, grains, True, distance)
    if loaded:
        punch = punch_of(record, scene, files)
        bed.add_punch(punch["centre"], punch["half_extents"], punch["velocity"], punch["start"])
    # In no time nothing slips: contacts come to be, get what they remember, and give their forces.
    O.dt = 0.0
    bed.evaluate_at_start()
    for row in rows(files.get(before + "memory.csv") or files[before + "contacts.csv"]):
        if "ft" in row:  # of other engines: (−nz, nx) times the tangential force
            row["sx"], row["sz"] = -row["nz"] * row["ft"], row["nx"] * row["ft"]
        contact = O.interactions[int(row["id1"]), int(row["id2"])]
        contact.phys.shearForce = Vector3(row["sx"], 0.0, row["sz"])
    # YADE sets back only forces that someone has summed, as integration does otherwise.
    O.forces.f(0, True)
    bed.evaluate_at_start()
    O.dt = record["time_step"]
    return bed


if __name__ == "__main__":
    arguments = [of for of in sys.argv[1:] if of != "--settled"]
    if len(arguments) != 1:
        sys.exit(__doc__)
    bed = load(arguments[0], settled="--settled" in sys.argv)
    from yadeimport import *  # noqa: F403
    print("%d bodies, %d contacts; O is the scene" % (len(O.bodies), len(bed.real_contacts())))  # noqa: F405
