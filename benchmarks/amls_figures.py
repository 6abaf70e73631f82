"""The two figures of AMLS: domain of convergence (figure 11 of the paper), and scans before and after projection.

amls_figures.py convergence <what `amls_paper <models> convergence` printed> <out.png>
amls_figures.py projection <plugin.so> <out.png> <cloud.ply>...

The clouds are drawn as small discs shaded by the plane of their 10 nearest points, before and after alike, so that the light
shows the noise and not the filter's opinion of it.
"""
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

VIEWS = {"rabbit_real_scan": (0, 0, 0), "uwa_rs1_scan": (0, 0, 0), "hand_points": (0, 0, 0)}  # degrees about x, y, z


def draw_convergence(table, out):
    rows = [[cell.strip() for cell in line.strip("| \n").split("|")] for line in Path(table).read_text().splitlines()
            if line.startswith("|")]
    figure, axes = plt.subplots(figsize=(5, 2.8))
    for shape, style in (("torus 1, 0.4", "-"), ("sphere", "--")):
        found = np.array([[float(cell) for cell in row[1:4]] for row in rows if row[0] == shape and len(row) == 4])
        axes.plot(found[:, 0], found[:, 1], "o" + style, color="tab:blue", label=f"I, {shape}", markersize=4)
        axes.plot(found[:, 0], found[:, 2], "s" + style, color="tab:red", label=f"N, {shape}", markersize=4)
    axes.set(xlabel="pushed off the surface by [local feature size]", ylabel="share that returns", ylim=(-0.03, 1.05))
    axes.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    figure.savefig(out, dpi=90)


def rotation(angles):
    result = np.eye(3)
    for axis, angle in enumerate(np.radians(angles)):
        turn = np.eye(3)
        i, j = [k for k in range(3) if k != axis]
        turn[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
        result = turn @ result
    return result


def local_normals(points):
    from scipy.spatial import cKDTree
    _, near = cKDTree(points).query(points, 10)
    local = points[near] - points[near].mean(1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
    return vectors[:, :, 0]


def render(points, low, scale, size):
    """A picture of the points seen along -z, nearest on top."""
    shade = np.abs(local_normals(points) @ (np.array([0.4, 0.5, 0.77]) / np.linalg.norm([0.4, 0.5, 0.77])))
    picture, depth = np.full((size, size), 1.0), np.full((size, size), -np.inf)
    at = ((points[:, :2] - low) * scale).astype(int)
    for dx in range(-2, 3):
        for dy in range(-2, 3):
            x, y = np.clip(at[:, 0] + dx, 0, size - 1), np.clip(size - 1 - at[:, 1] - dy, 0, size - 1)
            order = np.argsort(points[:, 2])
            order = order[points[order, 2] > depth[y[order], x[order]]]
            picture[y[order], x[order]] = 0.1 + 0.8 * shade[order]
            np.maximum.at(depth, (y[order], x[order]), points[order, 2])
    return picture


def draw_projection(plugin, out, clouds):
    import pymeshlab
    pymeshlab.load_plugin(plugin)
    size = 300
    figure, axes = plt.subplots(2, len(clouds), figsize=(3.3 * len(clouds), 6.8), squeeze=False)
    for column, cloud in enumerate(clouds):
        name = Path(cloud).stem
        meshes = pymeshlab.MeshSet(verbose=False)
        meshes.load_new_mesh(cloud)
        turn = rotation(VIEWS.get(name, (0, 0, 0)))
        before = meshes.current_mesh().vertex_matrix() @ turn.T
        meshes.apply_filter("compute_mls_projection_amls")
        after = meshes.current_mesh().vertex_matrix() @ turn.T
        low, high = before[:, :2].min(0), before[:, :2].max(0)
        low, extent = 0.5 * (low + high) - 0.3 * (high - low).max(), 0.6 * (high - low).max()
        for row, (points, what) in enumerate(((before, name), (after, "projected"))):
            axes[row, column].imshow(render(points, low, size / extent, size), cmap="gray", vmin=0, vmax=1)
            axes[row, column].set_title(what, fontsize=9)
            axes[row, column].axis("off")
    figure.tight_layout()
    figure.savefig(out, dpi=62)
    from PIL import Image
    Image.open(out).convert("L").quantize(24).save(out, optimize=True)


if __name__ == "__main__":
    if len(sys.argv) >= 4 and sys.argv[1] == "convergence":
        draw_convergence(sys.argv[2], sys.argv[3])
    elif len(sys.argv) >= 5 and sys.argv[1] == "projection":
        draw_projection(sys.argv[2], sys.argv[3], sys.argv[4:])
    else:
        sys.exit(__doc__)
