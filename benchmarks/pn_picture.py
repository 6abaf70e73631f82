"""The picture in filter_pn_refine/README.md: pn_picture.py <folder that pn_picture filled> <out.png>"""
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

# Title, axis up, axis towards the viewer, turn about the axis up and tilt [degrees].
CLOUDS = {"igea": ("600 samples of igea", "+y", "+x", 130, 0),
          "rocker_arm": ("3,500 of a rocker arm", "+z", "-y", 100, 15),
          "bunny_closed": ("3,500 of a bunny", "+y", "+z", 0, 0),
          "cube": ("384 of a cube with creases", "+z", "-y", -30, 25),
          "sphere": ("sphere with a hole", "+z", "-y", -30, 25)}
LIGHT = np.array([0.4, 0.5, 0.77])


def axis(name):
    return np.eye(3)["xyz".index(name[1])] * (1 if name[0] == "+" else -1)


def view(up, towards, turn, tilt):
    a, e = np.radians([turn, tilt])
    base = np.array([np.cross(axis(up), axis(towards)), axis(up), axis(towards)])
    about_up = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    tilted = np.array([[1, 0, 0], [0, np.cos(e), -np.sin(e)], [0, np.sin(e), np.cos(e)]])
    return tilted @ about_up @ base


def draw(plot, cloud, matrix, title):
    points, normals = cloud[:, :3] @ matrix.T, cloud[:, 3:] @ matrix.T
    order = np.argsort(points[:, 2])
    order = order[normals[order, 2] > 0]
    shade = np.clip(normals[order] @ LIGHT, 0, 1) * 0.75 + 0.12
    size = 5 if len(cloud) < 4000 else np.clip(60000 / len(cloud), 0.25, 3)
    plot.scatter(points[order, 0], points[order, 1], c=shade, cmap="gray", vmin=0, vmax=1, s=size, linewidths=0)
    plot.set_aspect("equal")
    plot.axis("off")
    plot.set_title(title, fontsize=11)


def main(folder, out):
    _, plots = plt.subplots(2, len(CLOUDS), figsize=(3.5 * len(CLOUDS), 7.4), sharex="col", sharey="col")
    for column, (name, (title, *angles)) in enumerate(CLOUDS.items()):
        before, after = (np.fromfile(Path(folder) / f"{name}.{when}").reshape(-1, 6) for when in ("before", "after"))
        draw(plots[0, column], before, view(*angles), title)
        draw(plots[1, column], after, view(*angles), f"{len(after):,} points")
    plt.tight_layout(pad=0.4)
    plt.savefig(out, dpi=64)


main(*sys.argv[1:])
