"""Writes vertices and triangles of CAD parts as PLY, for crust_grid: cad_parts.py <folder>

Wants CadQuery 2 (pip install cadquery). Each part is tessellated twice, coarsely (_c) and finely (_f): vertices lie on
rims, fillets and curved faces, none on flat ones.
"""
import math
import sys

import cadquery
import numpy

Plane = cadquery.Workplane


def gear():
    corners = []
    for tooth in range(18):
        for share, radius in ((-0.28, 2), (-0.15, 2.5), (0.15, 2.5), (0.28, 2)):
            angle = 2 * math.pi * (tooth + share) / 18
            corners.append((radius * math.cos(angle), radius * math.sin(angle)))
    return Plane().polyline(corners).close().extrude(0.8).faces(">Z").workplane().hole(1)


def bracket():
    plate = Plane().box(4, 3, 0.4).faces(">Z").workplane().center(-1.8, 0).rect(0.4, 3).extrude(2.5)
    corners = plate.edges("|Y").fillet(0.12).faces("<Z").workplane().rect(2.4, 2, forConstruction=True).vertices()
    return corners.hole(0.4)


def elbow():
    path = Plane("XZ").moveTo(0, 0).lineTo(0, 3).radiusArc((2, 5), 2).lineTo(5, 5)
    return Plane("XY").circle(0.8).circle(0.6).sweep(path)


def tee():
    def tubes(radius, length):
        run = Plane("XZ").circle(radius + 0.2).extrude(length, both=True)
        return run.union(Plane("XY").circle(radius).extrude(length))

    return tubes(0.8, 3).cut(tubes(0.6, 3.1))


def wheel():
    result = Plane().circle(3).circle(2.5).extrude(0.8).union(Plane().circle(0.7).circle(0.3).extrude(0.8))
    for spoke in range(5):
        bar = Plane().rect(2.2, 0.3).extrude(0.4).translate((1.6, 0, 0.2))
        result = result.union(bar.rotate((0, 0, 0), (0, 0, 1), 72 * spoke))
    return result


def knob():
    body = Plane().circle(1.5).extrude(0.8).edges(">Z").fillet(0.3)
    flutes = Plane().polarArray(1.7, 0, 360, 12).circle(0.25).extrude(1)
    return body.cut(flutes).faces("<Z").workplane().hole(0.5, 0.5)


PARTS = {
    "fillet_box": lambda: Plane().box(4, 3, 2).edges().fillet(0.3),
    "key_cap": lambda: Plane().rect(2, 2).workplane(offset=1).rect(1.4, 1.5).loft().edges().fillet(0.12)
    .faces("<Z").shell(-0.12),
    "knob": knob,
    "loft": lambda: Plane().rect(3, 3).workplane(offset=3).circle(0.8).loft(),
    "chamfer_block": lambda: Plane().box(3, 3, 3).edges().chamfer(0.4),
    "box_hole": lambda: Plane().box(4, 3, 1).faces(">Z").workplane().hole(1),
    "bracket": bracket,
    "flange": lambda: Plane().circle(3).circle(1.2).extrude(0.5).faces(">Z").workplane().circle(1.6).circle(1.2)
    .extrude(1.2).faces("<Z").workplane().polarArray(2.3, 0, 360, 6).hole(0.5),
    "gear": gear,
    "elbow": elbow,
    "tee": tee,
    "wheel": wheel,
    "bolt": lambda: Plane().polygon(6, 2).extrude(0.7).faces(">Z").workplane().circle(0.5).extrude(3).faces(">Z")
    .chamfer(0.1),
    "ring": lambda: Plane("XZ").polyline([(2, 0), (2.6, 0), (2.6, 0.3), (2.4, 0.5), (2.4, 0.9), (2, 0.9)]).close()
    .revolve(360, (0, 0, 0), (0, 1, 0)),
    "pockets": lambda: Plane().box(6, 4, 0.8).faces(">Z").workplane().rarray(1.8, 1.8, 3, 2).rect(1.3, 1.3)
    .cutBlind(-0.5),
    "shell_box": lambda: Plane().box(4, 3, 2).edges("|Z").fillet(0.4).faces(">Z").shell(-0.2),
}


def tessellate(solid, tolerance, angle):
    """Vertices, each once, and triangles of a closed mesh."""
    vertices, triangles = solid.tessellate(tolerance, angle)
    vertices = numpy.array([v.toTuple() for v in vertices])
    size = numpy.ptp(vertices, axis=0).max()
    _, first, again = numpy.unique(numpy.round(vertices / size * 1e7), axis=0, return_index=True, return_inverse=True)
    triangles = again.ravel()[numpy.array(triangles)]
    ends = numpy.sort(triangles, axis=1)
    return vertices[first], triangles[(ends[:, 0] != ends[:, 1]) & (ends[:, 1] != ends[:, 2])]


def write(path, vertices, triangles):
    with open(path, "w") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty double x\nproperty double y\n"
                   f"property double z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\n"
                   "end_header\n")
        file.writelines("%.17g %.17g %.17g\n" % tuple(v) for v in vertices)
        file.writelines("3 %d %d %d\n" % tuple(t) for t in triangles)


for name, make in PARTS.items():
    solid = make().val()
    diagonal = solid.BoundingBox().DiagonalLength
    for suffix, tolerance, angle in (("c", 0.004, 0.5), ("f", 0.0007, 0.2)):
        write(f"{sys.argv[1]}/{name}_{suffix}.ply", *tessellate(solid, tolerance * diagonal, angle))
