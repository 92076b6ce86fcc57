#!/usr/bin/env python3
"""Writes the corpus of splat files and what they should be read as, with the standard library and the program zstd.

Written from the descriptions of the formats, apart from the crate: the tests compare what the crate reads with the numbers before encoding.
"""

import gzip
import json
import math
import random
import struct
import subprocess
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
SH_C0 = 0.28209479177387814


def gaussian(rng, degree):
    n = (degree + 1) ** 2
    return {
        "mean": [rng.uniform(-2, 2) for _ in range(3)],
        "log_scale": [rng.uniform(-6, -1) for _ in range(3)],
        "rotation": [rng.gauss(0, 1) for _ in range(4)],
        "opacity": rng.uniform(0.05, 0.95),
        # by coefficient and channel
        "harmonics": [[rng.uniform(-0.9, 0.9) for _ in range(3)] for _ in range(n)],
    }


def scene(seed, degree, count=6):
    rng = random.Random(seed)
    return [gaussian(rng, degree) for _ in range(count)]


def lattice():
    """Many Gaussians that are nearly the same, so that compression has something to do."""
    first, second = scene(5, 1, count=2)
    places = [[0.1 * (i % 6), 0.1 * (i // 6 % 6), 0.1 * (i // 36)] for i in range(216)]
    return [dict(second if i % 5 == 0 else first, mean=x) for i, x in enumerate(places)]


def rotation_matrix(q):
    norm = math.sqrt(sum(x * x for x in q))
    w, x, y, z = (c / norm for c in q)
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def expected(g):
    r = rotation_matrix(g["rotation"])
    s2 = [math.exp(2 * s) for s in g["log_scale"]]
    a = [[sum(r[i][k] * s2[k] * r[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    return {
        "mean": g["mean"],
        "covariance": [a[0][0], a[0][1], a[0][2], a[1][1], a[1][2], a[2][2]],
        "opacity": g["opacity"],
        "harmonics": [c[channel] for channel in range(3) for c in g["harmonics"]],
    }


def columns(g):
    """Property name -> value of a PLY file."""
    rest = [c[channel] for channel in range(3) for c in g["harmonics"][1:]]
    values = dict(zip("xyz", g["mean"]))
    values |= {f"f_dc_{k}": c for k, c in enumerate(g["harmonics"][0])}
    values |= {f"f_rest_{k}": c for k, c in enumerate(rest)}
    values["opacity"] = math.log(g["opacity"] / (1 - g["opacity"]))
    values |= {f"scale_{k}": s for k, s in enumerate(g["log_scale"])}
    values |= {f"rot_{k}": q for k, q in enumerate(g["rotation"])}
    return values


def ply(gaussians, encoding, order, types=None, header_extra=(), before=None, newline="\n"):
    """`order` lists names; names that no Gaussian has are filled with 7."""
    types = types or {}
    lines = ["ply", f"format {encoding} 1.0", *header_extra]
    prefix = b""
    if before:
        name, count, properties = before
        lines.append(f"element {name} {count}")
        lines += [f"property {kind} {p}" for kind, p in properties]
    lines.append(f"element vertex {len(gaussians)}")
    lines += [f"property {types.get(name, 'float')} {name}" for name in order]
    lines.append("element face 0")
    lines.append("property list uchar int vertex_indices")
    lines.append("end_header")
    codes = {"float": "f", "double": "d", "uchar": "B", "short": "h", "int": "i"}
    end = ">" if encoding == "binary_big_endian" else "<"
    rows = []
    if before:
        name, count, properties = before
        for k in range(count):
            numbers = [k for _ in properties]
            if encoding == "ascii":
                rows.append((" ".join(map(str, numbers)) + newline).encode())
            else:
                rows.append(struct.pack(end + "".join(codes[kind] for kind, _ in properties), *numbers))
    for g in gaussians:
        values = columns(g)
        numbers = [values.get(name, 7) for name in order]
        if encoding == "ascii":
            rows.append((" ".join(f"{x:.9g}" for x in numbers) + newline).encode())
        else:
            rows.append(struct.pack(end + "".join(codes[types.get(n, "float")] for n in order), *numbers))
    return (newline.join(lines) + newline).encode() + prefix + b"".join(rows)


def standard_order(gaussians):
    names = list(columns(gaussians[0]))
    return names[:3] + ["nx", "ny", "nz"] + names[3:]


def clamp_byte(x):
    return max(0, min(255, round(x)))


def splat(gaussians):
    out = b""
    for g in gaussians:
        norm = math.sqrt(sum(q * q for q in g["rotation"]))
        out += struct.pack("<3f", *g["mean"])
        out += struct.pack("<3f", *(math.exp(s) for s in g["log_scale"]))
        out += bytes(clamp_byte((0.5 + SH_C0 * c) * 255) for c in g["harmonics"][0])
        out += bytes([clamp_byte(g["opacity"] * 255)])
        out += bytes(clamp_byte(q / norm * 128 + 128) for q in g["rotation"])
    return out


def first_three(q):
    norm = math.sqrt(sum(c * c for c in q))
    sign = -1 if q[0] < 0 else 1
    return bytes(clamp_byte(sign * c / norm * 127.5 + 127.5) for c in q[1:])


def smallest_three(q):
    norm = math.sqrt(sum(c * c for c in q))
    w, x, y, z = (c / norm for c in q)
    xyzw = [x, y, z, w]
    largest = max(range(4), key=lambda k: abs(xyzw[k]))
    negate = xyzw[largest] < 0
    bits = largest
    for k in range(4):
        if k != largest:
            sign = int((xyzw[k] < 0) != negate)
            size = int(511 * abs(xyzw[k]) * math.sqrt(2) + 0.5)
            bits = (bits << 10) | (sign << 9) | size
    return struct.pack("<I", bits)


def spz_header(gaussians, degree, version, flags, last=0, fractional_bits=12):
    return struct.pack("<4sIIBBBB", b"NGSP", version, len(gaussians), degree, fractional_bits, flags, last)


def spz_columns(gaussians, version, fractional_bits=12):
    means = b""
    for g in gaussians:
        for x in g["mean"]:
            if version == 1:
                means += struct.pack("<e", x)
            else:
                means += struct.pack("<i", round(x * (1 << fractional_bits)))[:3]
    alphas = bytes(clamp_byte(g["opacity"] * 255) for g in gaussians)
    colours = bytes(clamp_byte((0.15 * c + 0.5) * 255) for g in gaussians for c in g["harmonics"][0])
    scales = bytes(clamp_byte((s + 10) * 16) for g in gaussians for s in g["log_scale"])
    pack = smallest_three if version >= 3 else first_three
    rotations = b"".join(pack(g["rotation"]) for g in gaussians)
    rest = bytes(clamp_byte(c * 128 + 128) for g in gaussians for rgb in g["harmonics"][1:] for c in rgb)
    return [means, alphas, colours, scales, rotations, rest]


def extension(kind, payload):
    return struct.pack("<II", kind, len(payload)) + payload


# Limits of an orbit, and a record of a type that nobody knows.
EXTENSIONS = extension(0xADBE0002, struct.pack("<3f", -0.5, 0.5, 1.0)) + extension(7, b"anything")


def spz(gaussians, degree, version, extensions=b""):
    head = spz_header(gaussians, degree, version, 2 if extensions else 0)
    return gzip.compress(head + b"".join(spz_columns(gaussians, version)) + extensions, mtime=0)


def zstd(data, length_in_header):
    """One frame, as the library of reference compresses; without a length in its header, as from a pipe."""
    command = ["zstd", "-q", "-12", "--no-check", "-c"]
    if not length_in_header:
        return subprocess.run(command, input=data, capture_output=True, check=True).stdout
    with tempfile.NamedTemporaryFile() as file:
        file.write(data)
        file.flush()
        return subprocess.run([*command, file.name], capture_output=True, check=True).stdout


def spz4(gaussians, degree, extensions=b"", length_in_header=True):
    columns = [c for c in spz_columns(gaussians, 4) if c]
    streams = [zstd(c, length_in_header) for c in columns]
    head = spz_header(gaussians, degree, 4, 2 if extensions else 0, len(streams))
    head += struct.pack("<I12x", 32 + len(extensions))
    table = b"".join(struct.pack("<QQ", len(s), len(c)) for s, c in zip(streams, columns))
    return head + extensions + table + b"".join(streams)


def write(name, data):
    path = HERE / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(data)


def main():
    truth = {}
    for degree in range(4):
        scenes = scene(degree, degree)
        truth[str(degree)] = [expected(g) for g in scenes]
        write(f"ply/little_{degree}.ply", ply(scenes, "binary_little_endian", standard_order(scenes)))
        write(f"ply/big_{degree}.ply", ply(scenes, "binary_big_endian", standard_order(scenes)))
        shuffled = standard_order(scenes)[:3] + standard_order(scenes)[6:] + ["red", "segment"]
        random.Random(99).shuffle(shuffled)
        odd = {
            "types": {"x": "double", "opacity": "double", "red": "uchar", "segment": "short"},
            "header_extra": ("comment element vertex 3", "obj_info made by hand"),
            "before": ("camera", 2, [("int", "id"), ("float", "x")]),
        }
        write(f"ply/shuffled_{degree}.ply", ply(scenes, "binary_little_endian", shuffled, **odd))
        write(f"ply/ascii_{degree}.ply", ply(scenes, "ascii", shuffled, newline="\r\n", **odd))
        for version in (1, 2, 3):
            write(f"spz/version{version}_{degree}.spz", spz(scenes, degree, version))
        write(f"spz/version4_{degree}.spz", spz4(scenes, degree))
    extended = scene(1, 1)
    write("spz/version3_extended_1.spz", spz(extended, 1, 3, EXTENSIONS))
    write("spz/version4_extended_1.spz", spz4(extended, 1, EXTENSIONS, length_in_header=False))
    for version, data in (3, spz(lattice(), 1, 3)), (4, spz4(lattice(), 1)):
        write(f"spz/version{version}_lattice_1.spz", data)
    write("splat/hand.splat", splat(scene(0, 0)))
    (HERE / "truth.json").write_text(json.dumps(truth))


main()
