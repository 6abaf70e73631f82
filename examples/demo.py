"""What ./demo runs: a real scan and a noisy closed model through the filter, in pymeshlab and in meshlabserver."""
import argparse
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests" / "hosts"), str(Path(__file__).parent)]
import hosts
import meshlab_2020
import render
from released_filters import NOISY_POWER_CRUST as FILTER


def trefoil_knot(n, tube, noise, seed):
    """Points on a tube around a trefoil knot (genus 1), evenly spread, each coordinate with Gaussian noise."""
    random = np.random.default_rng(seed)
    s = np.linspace(0, 2 * np.pi, 2000, endpoint=False)

    def curve(t):
        return np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])

    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(curve(np.append(s, 2 * np.pi)), axis=0), axis=1))])
    t = np.interp(random.uniform(0, length[-1], n), length, np.append(s, 2 * np.pi))
    centre, tangent = curve(t), curve(t + 1e-4) - curve(t - 1e-4)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    normal = np.cross(tangent, [0, 0, 1.0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    angle = random.uniform(0, 2 * np.pi, n)[:, None]
    return centre + tube * (np.cos(angle) * normal + np.sin(angle) * np.cross(tangent, normal)) + random.normal(0, noise, (n, 3))


def face_scan():
    """One range map of a laser scanner, as it comes with pymeshlab: 85,849 points, open."""
    import pymeshlab
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "rangemaps" / "face000.ply"))
    return meshes.current_mesh().vertex_matrix()


MODELS = [
    ("face", "real laser scan of a face", face_scan, [(0, 0), (60, 0)]),
    ("knot", "trefoil knot with noise", lambda: trefoil_knot(60000, 0.45, 0.03, seed=1), [(0, 0), (30, 50)]),
]


def is_closed(surface):
    """Every edge has two triangles that run through it in opposite directions, and they face outward."""
    n, triangles = len(surface.points), surface.triangles.astype(np.int64)
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    there, back = np.sort(start * n + end), np.sort(end * n + start)
    a, b, c = (surface.points[triangles[:, i]] - surface.points.mean(axis=0) for i in range(3))
    return (np.array_equal(there, back) and np.all(np.diff(there) > 0)
            and np.einsum("ij,ij->", a, np.cross(b, c)) > 0)


def show(title, points, surface, views, size):
    """One row: the points, and the surface from two sides."""
    row = []
    for i, view in enumerate(views):
        frame = render.Frame(points, render.look_from(*view), 2 * size)
        if i == 0:
            row.append((f"{title}: {len(points):,} points", render.half_size(render.cloud_picture(points, frame, 2))))
        row.append((["closed surface", "from another side"][i],
                    render.half_size(render.surface_picture(surface.points, surface.triangles, frame))))
    return row


def write_picture(rows, path):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(len(rows), len(rows[0]), figsize=(4.2 * len(rows[0]), 4.4 * len(rows)), dpi=100)
    for line, row in zip(axes, rows):
        for axis, (title, picture) in zip(line, row):
            axis.imshow(picture, interpolation="none")
            axis.set_title(title, fontsize=11)
            axis.axis("off")
    figure.tight_layout(pad=0.4)
    figure.savefig(path, pil_kwargs={"optimize": True})


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--out", type=Path, default=ROOT / "out")
    arguments = arguments.parse_args()
    out = arguments.out
    out.mkdir(parents=True, exist_ok=True)

    rows, table, phases, bad = [], [], [], 0
    python = hosts.PyMeshLab(FILTER.plugin)
    with meshlab_2020.Display() as display:
        server = hosts.MeshLabServer2020(FILTER.plugin, display) if meshlab_2020.is_installed() else None
        for model, title, make, views in MODELS:
            points = make()
            cloud_file = out / f"{model}_points.ply"
            hosts.write_ply(cloud_file, hosts.Cloud(points))
            results = []

            start = time.perf_counter()
            meshes = python.pymeshlab.MeshSet()
            meshes.load_new_mesh(str(cloud_file))
            values = meshes.apply_filter(FILTER.python_name)
            made = out / f"{model}_surface.ply"
            meshes.save_current_mesh(str(made))
            results.append(("pymeshlab", values, made, time.perf_counter() - start))
            print(f"{model}: pymeshlab, {results[-1][3]:.1f} s", flush=True)

            if server:
                start = time.perf_counter()
                served = out / f"{model}_surface_meshlabserver.ply"
                code, log = meshlab_2020.run_server(server.programs, display, [
                    "-i", cloud_file.name, "-o", served.name, "-s", ROOT / "examples" / "noisy_power_crust.mlx"], out)
                if code != 0 or not served.exists():
                    sys.exit(f"meshlabserver failed ({code}):\n{log}")
                results.append(("meshlabserver", meshlab_2020.values_in_log(log), served, time.perf_counter() - start))
                print(f"{model}: meshlabserver, {results[-1][3]:.1f} s", flush=True)

            for host, values, surface_file, seconds in results:
                surface = hosts.read_ply(surface_file)
                closed = is_closed(surface)
                bad += not closed
                table.append((model, host, f"{len(points):,}", f"{values['noise']:.3g}", f"{values['spacing']:.3g}",
                              int(values["components"]), int(values["genus"]),
                              "yes" if closed else "NO", f"{len(surface.triangles):,}", f"{seconds:.1f}"))
                phases.append((model, host, {k[len("seconds_"):].replace("_", " "): v for k, v in values.items()
                                             if k.startswith("seconds_")}))
            rows.append(show(title, points, surface, views, 420))

    write_picture(rows, out / "before_after.png")
    head = ("model", "host", "points", "noise", "spacing", "components", "genus", "closed", "triangles", "seconds")
    widths = [max(len(str(line[i])) for line in [head, *table]) for i in range(len(head))]
    print()
    for line in [head, *table]:
        print("  ".join(str(cell).rjust(width) for cell, width in zip(line, widths)))
    print("\nSeconds per phase (the column above includes starting the host, reading and writing):")
    for model, host, seconds in phases:
        print(f"  {model} {host}: " + ", ".join(f"{name} {s:.2f}" for name, s in seconds.items()))
    print(f"\nSurfaces and the picture before_after.png are in {out.name}/")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
