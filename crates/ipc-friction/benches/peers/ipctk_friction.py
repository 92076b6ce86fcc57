"""Times ipctk's friction on a scene of scenes.py, on one thread: ipctk_friction.py SCENE REPEATS. Prints JSON."""
import json
import sys
import time

import ipctk
import numpy as np
from scenes import SC

start, faces, end, activation_distance = (np.asfortranarray(a) if np.ndim(a) else a for a in SC[sys.argv[1]]())
ipctk.set_num_threads(1)
mesh = ipctk.CollisionMesh(start, ipctk.edges(faces), faces)
contacts = ipctk.NormalCollisions()
contacts.build(mesh, start, activation_distance)
barrier = ipctk.BarrierPotential(activation_distance, 1.0)
velocity = np.asfortranarray(end - start)
friction = ipctk.FrictionPotential(1e-3)
projection = ipctk.PSDProjectionMethod


def build():
    pairs = ipctk.TangentialCollisions()
    pairs.build(mesh, start, contacts, barrier, 0.5)
    return pairs


pairs = build()
stages = {
    "build": build,
    "value": lambda: friction(pairs, mesh, velocity),
    "gradient": lambda: friction.gradient(pairs, mesh, velocity),
    "hessian": lambda: friction.hessian(pairs, mesh, velocity, projection.NONE),
    "clamped": lambda: friction.hessian(pairs, mesh, velocity, projection.CLAMP),
}
result = {"pairs": len(pairs)}
for name, stage in stages.items():
    times = []
    for _ in range(int(sys.argv[2])):
        begin = time.perf_counter()
        out = stage()
        times.append(1e3 * (time.perf_counter() - begin))
        if sum(times) > 3000.0:
            break
    result[name + "_ms"] = [min(times), float(np.median(times))]
    if name != "build":
        norm = np.linalg.norm(out.data if hasattr(out, "data") and hasattr(out, "nnz") else out)
        result[name] = float(out) if name == "value" else float(norm)
print(json.dumps(result))
