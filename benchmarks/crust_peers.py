"""The noisy power crust beside Screened Poisson (pymeshlab) on the same clouds.

crust_peers.py <crust_peers program> <folder of models> <seed> [--sigmas 0,0.1,0.2,0.4,0.6] [--work folder] [model...]

Each cloud is written once with the true normals; every method reads that file. Crusts get the bare points; Poisson gets the
true normals at pymeshlab's default depth (8), and at depths 7 and 8 CGAL's normals (principal components of 30 neighbours,
oriented along a spanning tree). One thread; CPU seconds, normals included, over the CPU seconds of CGAL's Delaunay of the cloud.
RMS: of the vertices to the true mesh, in 1e-6 of the diagonal. Right: one component, true genus, closed, manifold, outward,
volume within 3 %. Writes one Markdown row a cell, then the sums, also when interrupted.
"""
import argparse
import itertools
import math
import subprocess
import tempfile
import time
from pathlib import Path

import pymeshlab

GRID_A = ("bunny_closed armadillo_43k igea horse rocker_arm trim_star block elephant_refined fertility anchor_dense "
          "maxplanck_closed_10k fandisk_large").split()
METHODS = ["crust", "raw", "true8", "tree7", "tree8"]
TITLES = {"crust": "crust", "raw": "raw crust", "true8": "Poisson 8, true normals", "tree7": "Poisson 7, pca30 + tree",
          "tree8": "Poisson 8, pca30 + tree"}


def call(program, *arguments):
    text = subprocess.run([program, *map(str, arguments)], check=True, capture_output=True, text=True).stdout
    return {name: float(value) for name, value in (line.split() for line in text.splitlines())}


def poisson(cloud, mesh, depth):
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.load_new_mesh(str(cloud))
    begin = time.process_time()
    meshes.apply_filter("generate_surface_reconstruction_screened_poisson", depth=depth, threads=1)
    seconds = time.process_time() - begin
    meshes.save_current_mesh(str(mesh), save_vertex_normal=False, save_vertex_color=False, save_vertex_quality=False,
                             save_face_color=False, save_face_quality=False)
    return seconds


def run_cell(program, folder, model, sigma, work):
    cloud, tree, mesh = work / f"{model}_{sigma}.ply", work / "tree.ply", work / "mesh.ply"
    found, seconds, unit = {}, {}, 0
    for method in METHODS:
        try:
            if method in ("crust", "raw"):
                run = call(program, "crust", cloud, mesh, *(["raw"] if method == "raw" else []))
                unit, seconds[method] = run["delaunay"], run["seconds"]
            elif method == "true8":
                seconds[method] = poisson(cloud, mesh, 8)
            else:
                if method == "tree7":
                    normals = call(program, "normals", cloud, tree)["seconds"]
                seconds[method] = normals + poisson(tree, mesh, int(method[-1]))
            found[method] = call(program, "judge", folder / f"{model}.ply", mesh)
        except (subprocess.CalledProcessError, pymeshlab.PyMeshLabException) as failure:
            print(f"<!-- {model} {sigma} {method}: {failure} -->")
            found[method] = dict(right=0, rms=math.inf, volume=math.nan, genus=-1, components=0)
            seconds.setdefault(method, math.nan)
        found[method]["ratio"] = seconds[method] / unit
    return found


def describe(cell):
    shape = "right" if cell["right"] else f"{cell['components']:.0f} c, genus {cell['genus']:.0f}, vol {cell['volume']:.3f}"
    return f"{shape}; {cell['rms']:.0f}; {cell['ratio']:.1f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", type=Path)
    parser.add_argument("seed")
    parser.add_argument("models", nargs="*")
    parser.add_argument("--sigmas", default="0,0.1,0.2,0.4,0.6")
    parser.add_argument("--work", type=Path)
    arguments = parser.parse_intermixed_args()
    work = arguments.work or Path(tempfile.mkdtemp())
    cells = {}
    print("| model | sigma | " + " | ".join(TITLES[m] for m in METHODS) + " |\n|---|---|" + "---|" * len(METHODS), flush=True)
    try:
        for sigma, model in itertools.product(arguments.sigmas.split(","), arguments.models or GRID_A):
            call(arguments.program, "clouds", arguments.folder, arguments.seed, work, sigma, model)
            cells[model, sigma] = cell = run_cell(arguments.program, arguments.folder, model, sigma, work)
            print(f"| {model} | {sigma} | " + " | ".join(describe(cell[m]) for m in METHODS) + " |", flush=True)
            (work / f"{model}_{sigma}.ply").unlink()
    except KeyboardInterrupt:
        pass  # the sums of what there is
    print()
    for m in METHODS:
        column = [cell[m] for cell in cells.values()]
        ratios = [c["ratio"] for c in column if math.isfinite(c["ratio"])]
        print(f"- {TITLES[m]}: right {sum(c['right'] for c in column):.0f} of {len(column)}, outward "
              f"{sum(c['volume'] > 0 for c in column)}, {math.exp(sum(map(math.log, ratios)) / len(ratios)):.1f} x Delaunay")
    noisy = [cell for (_, sigma), cell in cells.items() if sigma in ("0.2", "0.4")]
    print(f"- RMS at 0.2 and 0.4 %: crust at or below half the raw crust's in {sum(c['crust']['rms'] <= 0.5 * c['raw']['rms'] for c in noisy)}"
          f" of {len(noisy)} cells, at or below Poisson with true normals in {sum(c['crust']['rms'] <= c['true8']['rms'] for c in noisy)}"
          f"; geometric mean of crust / raw {mean_ratio(noisy, 'raw'):.3f}, of crust / Poisson {mean_ratio(noisy, 'true8'):.3f}")


def mean_ratio(cells, other):
    return math.exp(sum(math.log(c["crust"]["rms"] / c[other]["rms"]) for c in cells) / max(len(cells), 1))


if __name__ == "__main__":
    main()
