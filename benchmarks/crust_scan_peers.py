"""The noisy power crust beside Screened Poisson (pymeshlab) on virtual scans, clouds written by `crust_scans ... -o <clouds>`.

crust_scan_peers.py <crust_peers program> <folder of models> <folder of clouds> [model...]

No method gets normals. Poisson gets MeshLab's own (30 neighbours) at pymeshlab's default depth (8), and CGAL's (principal
components of 30 neighbours, oriented along a spanning tree) at depths 7 and 8. One thread. Each entry: right, or what is wrong; RMS
of the vertices to the true mesh in 1e-6 of the diagonal; CPU seconds over those of CGAL's Delaunay of the cloud. Right is as in
crust_peers.py. Scanners are counted as crust_scans lists them.
"""
import argparse
import re
import subprocess
import tempfile
import time
from pathlib import Path

import pymeshlab
from crust_peers import call, describe, poisson

TITLES = {"crust": "crust", "meshlab8": "Poisson 8, MeshLab's normals", "tree7": "Poisson 7, pca30 + tree",
          "tree8": "Poisson 8, pca30 + tree"}


def write_meshlab_normals(cloud, oriented):
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.load_new_mesh(str(cloud))
    begin = time.process_time()
    meshes.apply_filter("compute_normal_for_point_clouds", k=30)
    seconds = time.process_time() - begin
    meshes.save_current_mesh(str(oriented), save_vertex_normal=True)
    return seconds


def run_cell(program, model, cloud, work):
    oriented, mesh = work / "oriented.ply", work / "mesh.ply"
    crust = call(program, "crust", cloud, mesh)
    found = {"crust": call(program, "judge", model, mesh) | {"ratio": crust["seconds"] / crust["delaunay"]}}
    for method in list(TITLES)[1:]:
        try:
            if method == "meshlab8":
                normals = write_meshlab_normals(cloud, oriented)
            elif method == "tree7":
                normals = call(program, "normals", cloud, oriented)["seconds"]
            seconds = normals + poisson(oriented, mesh, int(method[-1]))
            found[method] = call(program, "judge", model, mesh) | {"ratio": seconds / crust["delaunay"]}
        except (subprocess.CalledProcessError, pymeshlab.PyMeshLabException) as failure:
            print(f"<!-- {cloud.name} {method}: {failure} -->")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("models", type=Path)
    parser.add_argument("clouds", type=Path)
    parser.add_argument("names", nargs="*")
    arguments = parser.parse_args()
    print("| model | scanner | " + " | ".join(TITLES.values()) + " |\n|---|---|" + "---|" * len(TITLES), flush=True)
    cells = []
    with tempfile.TemporaryDirectory() as work:
        for cloud in sorted(arguments.clouds.glob("*_cloud.ply")):
            name, scanner = re.fullmatch(r"(.+)_(\d+)_cloud", cloud.stem).groups()
            if arguments.names and name not in arguments.names:
                continue
            cells.append(run_cell(arguments.program, arguments.models / f"{name}.ply", cloud, Path(work)))
            entries = (describe(cells[-1][m]) if m in cells[-1] else "failed" for m in TITLES)
            print(f"| {name} | {int(scanner) + 1} | " + " | ".join(entries) + " |", flush=True)
    print()
    lowest = [min(cell, key=lambda m: cell[m]["rms"]) for cell in cells]
    for method, title in TITLES.items():
        column = [cell[method] for cell in cells if method in cell]
        print(f"- {title}: right {sum(c['right'] for c in column):.0f}, outward {sum(c['volume'] > 0 for c in column)}, "
              f"lowest RMS {lowest.count(method)} of {len(cells)}")


if __name__ == "__main__":
    main()
