"""Real scans through the noisy power crust in all three hosts, default parameters: prints the table of crust.md.

  python benchmarks/real_scans.py <folder with the scans> [--pictures <folder>] [name...]
Needs ./test or ./demo to have built the plugins, and the Python that `cmake/setup --python` prints.
"""
import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests" / "hosts"), str(ROOT / "examples")]
import hosts
import released_filters
import meshlab_2020
import render
from mesh_checks import examine

SCANS = ["dragon_scans_raw", "bunny_scans_raw", "uwa_rs1_scan", "rabbit_real_scan"]


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("names", nargs="*", default=SCANS)
    arguments.add_argument("--pictures", type=Path)
    arguments = arguments.parse_args()
    crust = released_filters.NOISY_POWER_CRUST
    print("| scan | points | host | closed, manifold, outward | components | Euler characteristic | triangles | seconds |")
    print("|---|---|---|---|---|---|---|---|")
    with meshlab_2020.Display() as display, tempfile.TemporaryDirectory() as work:
        python = hosts.PyMeshLab(crust.plugin)
        everywhere = [python, hosts.MeshLab2025(crust.plugin), hosts.MeshLabServer2020(crust.plugin, display)]
        for name in arguments.names:
            meshes = python.pymeshlab.MeshSet()
            meshes.load_new_mesh(str(arguments.folder / f"{name}.ply"))
            points = meshes.current_mesh().vertex_matrix()
            for host in everywhere:
                start = time.perf_counter()
                outcome = host.run(crust, hosts.Cloud(points), {}, work)
                seconds = time.perf_counter() - start
                if outcome.error:
                    print(f"| {name} | {len(points)} | {host.name} | {outcome.error} |", flush=True)
                    continue
                report = examine(outcome.surface)
                good = report["closed"] and report["oriented"] and report["vertex_manifold"] and report["volume"] > 0
                print(f"| {name} | {len(points)} | {host.name} | {'yes' if good else 'NO'} | {report['components']} | "
                      f"{report['euler_characteristic']} | {len(outcome.surface.triangles)} | {seconds:.1f} |", flush=True)
            if arguments.pictures:
                arguments.pictures.mkdir(parents=True, exist_ok=True)
                surface, row = outcome.surface, []
                for view in [(0, 0), (60, 20), (180, 0)]:
                    frame = render.Frame(surface.points, render.look_from(*view), 1000)
                    row.append(render.half_size(render.surface_picture(surface.points, surface.triangles, frame)))
                import matplotlib.image
                matplotlib.image.imsave(arguments.pictures / f"{name}.png", np.clip(np.hstack(row), 0, 1))


if __name__ == "__main__":
    main()
