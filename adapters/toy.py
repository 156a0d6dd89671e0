#!/usr/bin/env python3
"""A frictionless engine for small beds: it looks at all pairs. docs/bring-your-own-engine.md builds it up."""
import csv, json, math, os, sys, time

def push(force, rows, one, two, n, overlap, k, point):
    """A spring between body `one` (a grain, or a wall, which bears nothing) and grain `two`, and its row."""
    f = (k * overlap * n[0], k * overlap * n[1])
    for axis in (0, 1):
        force[two][axis] += f[axis]
        if one < len(force): force[one][axis] -= f[axis]
    rows.append((one, two, overlap, f[0] * n[0] + f[1] * n[1], f[1] * n[0] - f[0] * n[1], *n, *point))

def forces(x, radius, modulus, walls):
    """Force on each grain, and the rows of all contacts: pairs of grains by their ids, then wall by wall."""
    force, rows, count = [[0.0, 0.0] for _ in x], [], len(x)
    for i in range(count):
        for j in range(i + 1, count):
            dx, dz = x[j][0] - x[i][0], x[j][1] - x[i][1]
            distance = math.sqrt(dx * dx + dz * dz)
            overlap = radius[i] + radius[j] - distance
            if overlap >= 0.0:
                a, b, n = modulus * radius[i], modulus * radius[j], (dx / distance, dz / distance)
                arm = radius[i] - 0.5 * overlap
                push(force, rows, i, j, n, overlap, 2.0 * a * b / (a + b), (x[i][0] + arm * n[0], x[i][1] + arm * n[1]))
    for index, wall in enumerate(walls):
        axis, place = "xz".index(wall["axis"]), wall["place"]
        for j in range(count):
            distance, n, point, a = x[j][axis] - place, [0.0, 0.0], list(x[j]), modulus * radius[j]
            n[axis], point[axis] = math.copysign(1.0, distance), place
            if abs(distance) <= radius[j]:
                push(force, rows, count + index, j, n, radius[j] - abs(distance), 2.0 * a * a / (a + a), point)
    return force, sorted(rows)

def run(folder):
    """Do the job in a folder; the steps that were done."""
    def put(name, text, mode="w"):
        with open(os.path.join(folder, name), mode, encoding="utf-8") as file: file.write(text)
    def table(name, head, rows):
        put(name, head + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
    job = json.load(open(os.path.join(folder, "job.json"), encoding="utf-8"))
    if job["kind"] == "cases": return sum(run(os.path.join(folder, case)) for case in job["folders"])
    first, last = (job["step"], job["until_step"]) if job["kind"] == "scene" else (0, job["moments"][-1])
    moments = job.get("moments") or {first, last, *range(0, last + 1, job["moments_every"])}
    grains = list(csv.reader(open(os.path.join(folder, "initial.csv"), encoding="utf-8")))[1:]
    if len(grains) > 200:
        put("moments.jsonl", json.dumps({"refused": "more than 200 grains"}) + "\n")
        return 0
    x, v = ([[float(row[c]) for c in columns] for row in grains] for columns in ((1, 2), (3, 4)))
    radius, mass = ([float(row[c]) for row in grains] for c in (5, 6))
    model, wall, cpu = job["model"], time.monotonic(), time.process_time()
    dt, gravity, alpha = model["dt"], model["gravity"], model["alpha"]
    for step in range(first, last + 1):
        if step > first:
            for i in range(len(x)):
                for axis in (0, 1):
                    a = force[i][axis] / mass[i] + gravity[axis]
                    power = a * (v[i][axis] + 0.5 * dt * a)
                    a *= 1.0 - alpha * ((power > 0.0) - (power < 0.0))
                    v[i][axis] += dt * a
                    x[i][axis] += dt * v[i][axis]
        force, contacts = forces(x, radius, model["law"]["modulus"], model["walls"])
        if step in moments:
            table(f"settle-{step}-bodies.csv", "id,x,z,vx,vz,radius,mass", [(i, *x[i], *v[i], radius[i], mass[i]) for i in range(len(x))])
            table(f"settle-{step}-contacts.csv", "id1,id2,overlap,fn,ft,nx,nz,x,z", contacts)
            put("moments.jsonl", json.dumps({"stage": "settle", "step": step}) + "\n", "a")
        if step % 100 == 0: print("settle", step, step / max(last, 1), flush=True)
    if job["kind"] == "scene":
        times = {"wall_seconds": time.monotonic() - wall, "cpu_seconds": time.process_time() - cpu}
        put("moments.jsonl", json.dumps({"end": "settle", "steps": last, "stop": "steps_done", **times}) + "\n", "a")
    return last - first

if sys.argv[1] == "describe":
    parts = ["normal_spring", "local_damping", "gravity", "walls", "cases"]
    print(json.dumps({"protocol": 1, "name": "toy", "version": "1", "parts": parts}))
else:
    steps = run(sys.argv[2])
    json.dump({"steps": steps}, open(os.path.join(sys.argv[2], "done.json"), "w", encoding="utf-8"))
