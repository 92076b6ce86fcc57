"""Writes the corpus: python make_corpus.py (needs PyPI meshio 5.3, gmsh 4.15 and numpy).

One small mesh in every variant of the formats, most of them written by meshio, which knows nothing of our readers: two
tetrahedra over five points, their six outer triangles. The rest are written by hand for what meshio does not write.
Files named regression_* were found by fuzzing and are not made here.
"""
import struct

import meshio
import numpy as np

P = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.75, 1.25]])
TETS = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
TRIS = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4], [2, 3, 4], [3, 1, 4]])


def msh():
    tags = {"gmsh:physical": [np.array([7, 8]), np.full(6, 3)], "gmsh:geometrical": [np.array([1, 1]), np.full(6, 1)]}
    mesh = meshio.Mesh(P, [("tetra", TETS), ("triangle", TRIS)], cell_data=tags)
    for binary, name in ((False, "ascii"), (True, "binary")):
        meshio.write(f"msh/meshio_22_{name}.msh", mesh, file_format="gmsh22", binary=binary)
    mesh = meshio.Mesh(P, [("tetra", TETS)])
    for binary, name in ((False, "ascii"), (True, "binary")):
        meshio.write(f"msh/meshio_41_{name}.msh", mesh, file_format="gmsh", binary=binary)
    hexahedron = meshio.Mesh(np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float),
                             [("hexahedron", np.arange(8)[None]), ("triangle", np.array([[0, 2, 1]]))])
    meshio.write("msh/meshio_22_hexahedron.msh", hexahedron, file_format="gmsh22", binary=False)
    with open("msh/hand_41_big_endian.msh", "wb") as f:
        f.write(b"$MeshFormat\n4.1 1 8\n" + struct.pack(">i", 1) + b"\n$EndMeshFormat\n$Entities\n")
        f.write(struct.pack(">4Q", 0, 0, 0, 1) + struct.pack(">i6dQiQ", 5, 0, 0, 0, 1, 1, 1.25, 1, -9, 0))
        f.write(b"\n$EndEntities\n$Nodes\n" + struct.pack(">4Q", 1, 5, 10, 50) + struct.pack(">3iQ", 3, 5, 0, 5))
        f.write(struct.pack(">5Q", 10, 50, 20, 40, 30) + P.astype(">f8").tobytes() + b"\n$EndNodes\n$Elements\n")
        tag = [10, 50, 20, 40, 30]
        f.write(struct.pack(">4Q", 1, 2, 1, 2) + struct.pack(">3iQ", 3, 5, 4, 2))
        for k, tet in enumerate(TETS):
            f.write(struct.pack(">5Q", k + 1, *(tag[i] for i in tet)))
        f.write(b"\n$EndElements\n")
    with open("msh/hand_41_gmsh_style.msh", "w") as f:
        f.write("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 3 \"outer skin\"\n3 7 \"body\"\n"
                "$EndPhysicalNames\n$Comments\nfree text\n$EndComments\n"
                "$Entities\n1 1 1 1\n1 0 0 0 0\n1 0 0 0 1 0 0 0 2 1 1\n1 0 0 0 1 1 1 1 3 0\n"
                "1 0 0 0 1 1 1 1 7 1 1\n$EndEntities\n$Nodes\n3 5 1 5\n0 1 0 1\n1\n0 0 0\n"
                "1 1 1 1\n2\n1 0 0 0.5\n2 1 1 3\n3\n4\n5\n0 1 0 0.1 0.2\n0 0 1 0.3 0.4\n0.5 0.75 1.25 0.5 0.6\n$EndNodes\n"
                "$Elements\n4 10 1 10\n0 1 15 1\n1 1\n1 1 1 1\n2 1 2\n2 1 2 6\n")
        f.writelines(f"{k + 3} {a + 1} {b + 1} {c + 1}\n" for k, (a, b, c) in enumerate(TRIS))
        f.write("3 1 4 2\n")
        f.writelines(f"{k + 9} {a + 1} {b + 1} {c + 1} {d + 1}\n" for k, (a, b, c, d) in enumerate(TETS))
        f.write("$EndElements\n")


def stl():
    mesh = meshio.Mesh(P, [("triangle", TRIS)])
    meshio.write("stl/meshio_ascii.stl", mesh, binary=False)
    meshio.write("stl/meshio_binary.stl", mesh, binary=True)
    data = bytearray(open("stl/meshio_binary.stl", "rb").read())
    data[:80] = b"solid but binary".ljust(80)
    open("stl/hand_solid_binary.stl", "wb").write(data)


def ply():
    mesh = meshio.Mesh(P, [("triangle", TRIS)])
    meshio.write("ply/meshio_ascii.ply", mesh, binary=False)
    meshio.write("ply/meshio_binary.ply", mesh, binary=True)
    quads = meshio.Mesh(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], float),
                        [("quad", np.array([[0, 1, 2, 3], [1, 4, 5, 2]]))])
    meshio.write("ply/meshio_quads.ply", quads, binary=True)
    with open("ply/hand_big_endian.ply", "wb") as f:
        f.write(b"ply\nformat binary_big_endian 1.0\ncomment properties in another order\nelement material 2\n"
                b"property list ushort short weights\nelement vertex 5\nproperty uchar red\nproperty float z\n"
                b"property double y\nproperty float x\nelement face 6\nproperty char flag\n"
                b"property list uchar ushort vertex_index\nelement edge 1\nproperty int vertex1\nproperty int vertex2\n"
                b"end_header\n")
        f.write(struct.pack(">HhhH", 2, -1, 5, 0))
        for x, y, z in P:
            f.write(struct.pack(">Bfdf", 200, z, y, x))
        for t in TRIS:
            f.write(struct.pack(">bB3H", -1, 3, *t))
        f.write(struct.pack(">2i", 0, 4))


def obj():
    meshio.write("obj/meshio.obj", meshio.Mesh(P, [("triangle", TRIS)]))
    with open("obj/hand.obj", "w", newline="") as f:
        f.write("# every form of index\r\nmtllib none.mtl\r\no thing\r\nv 0 0 0 1.0\r\nv 1 0 0 0.5 0.5 0.5\r\nv 1 1 0\r\n"
                "v 0 1 0\r\nvt 0 0\r\nvn 0 0 1\r\nusemtl none\r\nf 1/1/1 2//1 3/1 \\\r\n4\r\n"
                "v 0 0 2e0\r\nf -1 -5 -4 # relative\r\nl 1 5 6\r\nv 0 0 3\r\np 6\r\n")


for write in (msh, stl, ply, obj):
    write()


def gmsh():
    """Files of Gmsh itself (PyPI gmsh 4.15): a unit cube as coarse as can be, with named groups and parametric nodes."""
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMin", 2)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 2)
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [1], 11, "cube")
    gmsh.model.addPhysicalGroup(2, [1, 2], 12, "two sides")
    gmsh.model.mesh.generate(3)
    for version in (2.2, 4.1):
        # In version 2.2 saving all means saving without groups.
        gmsh.option.setNumber("Mesh.SaveAll", int(version == 4.1))
        for binary in (0, 1):
            gmsh.option.setNumber("Mesh.MshFileVersion", version)
            gmsh.option.setNumber("Mesh.Binary", binary)
            gmsh.option.setNumber("Mesh.SaveParametric", binary * int(version == 4.1))
            gmsh.write(f"msh/gmsh_{str(version).replace('.', '')}_{('ascii', 'binary')[binary]}.msh")
    gmsh.finalize()


gmsh()
