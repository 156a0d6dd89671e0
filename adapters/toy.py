#!/usr/bin/env python3
"""A frictionless engine in 60 lines; docs/bring-your-own-engine.md builds it up. For small beds: it looks at all pairs."""
import csv, json, math, os, sys, time

PARTS = ["normal_spring", "local_damping", "gravity", "walls", "cases"]

def forces(x, radius, stiffness, walls):
    """Force on each grain, and the rows of the contacts: grain by grain, then wall by wall."""
    count = len(x)
    force, rows = [[0.0, 0.0] for _ in x], []
    for i in range(count):
        for j in range(i + 1, count):
            dx, dz = x[j][0] - x[i][0], x[j][1] - x[i][1]
            distance = math.sqrt(dx * dx + dz * dz)
            overlap = radius[i] + radius[j] - distance
            if overlap < 0.0: continue
            a, b, n = stiffness * radius[i], stiffness * radius[j], (dx / distance, dz / distance)
            push, arm = 2.0 * a * b / (a + b) * overlap, radius[i] - 0.5 * overlap
            f = (push * n[0], push * n[1])
            for axis in (0, 1):
                force[i][axis] -= f[axis]
                force[j][axis] += f[axis]
            fn, ft = f[0] * n[0] + f[1] * n[1], f[1] * n[0] - f[0] * n[1]
            rows.append((i, j, overlap, fn, ft, *n, x[i][0] + arm * n[0], x[i][1] + arm * n[1]))
    for index, wall in enumerate(walls):
        axis = "xz".index(wall["axis"])
        for j in range(count):
            distance = x[j][axis] - wall["place"]
            overlap, k = -(abs(distance) - radius[j]), stiffness * radius[j]
            if overlap < 0.0: continue
            f, n, point = 2.0 * k * k / (k + k) * overlap, [0.0, 0.0], list(x[j])
            n[axis], point[axis] = math.copysign(1.0, distance), wall["place"]
            force[j][axis] += f * n[axis]
            rows.append((count + index, j, overlap, f, 0.0, *n, *point))
    return force, sorted(rows)

def run(folder):
    job = json.load(open(os.path.join(folder, "job.json"), encoding="utf-8"))
    if job["kind"] == "cases":
        return sum(run(os.path.join(folder, case)) for case in job["folders"])
    model, step, began = job["model"], job.get("step", 0), (time.monotonic(), time.process_time())
    if job["kind"] == "scene" and job["until_step"] is None: sys.exit("toy.py has no stop rules: give --steps")
    last = job["until_step"] if job["kind"] == "scene" else job["moments"][-1]
    grains = list(csv.reader(open(os.path.join(folder, "initial.csv"), encoding="utf-8")))[1:]
    x, v = ([[float(row[c]) for c in columns] for row in grains] for columns in ((1, 2), (3, 4)))
    radius, mass = ([float(row[c]) for row in grains] for c in (5, 6))
    dt, gravity, alpha = model["dt"], model["gravity"], model["alpha"]
    index = open(os.path.join(folder, "moments.jsonl"), "w", encoding="utf-8")
    while True:
        force, contacts = forces(x, radius, model["law"]["modulus"], model["walls"])
        if step in job.get("moments", ()) or (job["kind"] == "scene" and (step in (job["step"], last) or step % job["moments_every"] == 0)):
            bodies = [(i, *x[i], *v[i], radius[i], mass[i]) for i in range(len(x))]
            for name, head, rows in (("bodies", "id,x,z,vx,vz,radius,mass", bodies), ("contacts", "id1,id2,overlap,fn,ft,nx,nz,x,z", contacts)):
                with open(os.path.join(folder, f"settle-{step}-{name}.csv"), "w", encoding="utf-8") as table:
                    table.write(head + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
            print(json.dumps({"stage": "settle", "step": step, "punch": None}), file=index, flush=True)
            print("settle", step, step / max(last, 1), flush=True)
        if step == last: break
        for i in range(len(x)):
            for axis in (0, 1):
                a = force[i][axis] / mass[i] + gravity[axis]
                power = a * (v[i][axis] + 0.5 * dt * a)
                a *= 1.0 - alpha * ((power > 0.0) - (power < 0.0))
                v[i][axis] += dt * a
                x[i][axis] += dt * v[i][axis]
        step += 1
    if job["kind"] == "scene":
        print(json.dumps({"end": "settle", "steps": step, "stop": "steps_done", "wall_seconds": time.monotonic() - began[0],
                          "cpu_seconds": time.process_time() - began[1]}), file=index, flush=True)
    return step - job.get("step", 0)

if sys.argv[1] == "describe":
    print(json.dumps({"protocol": 1, "name": "toy", "version": "1", "parts": PARTS, "approximations": []}))
else:
    steps = run(sys.argv[2])
    json.dump({"steps": steps}, open(os.path.join(sys.argv[2], "done.json"), "w", encoding="utf-8"))
