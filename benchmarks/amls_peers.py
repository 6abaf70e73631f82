"""MLS projection: AMLS beside MeshLab's APSS and RIMLS, on the clouds that amls_clouds wrote.

amls_peers.py <plugin.so> <folder with clouds and truth>... [--models name,...] [--only-peers] [--peers apss,rimls]
              [--scales 2,4,8] [--save <folder>]

Each cloud <name>.ply has its true surface in <name>.truth (the path of a mesh). The peers get MeshLab's own normals
(K = 30) and run at FilterScale 2, 4, 8 between two layers: projected onto the cloud (controlmesh) is a copy of it
(proxymesh), since their default, one layer for both, crashes. AMLS gets the bare points and no parameter. Errors are RMS
distances to the true mesh in 1e-6 of its diagonal, outliers left out; times are CPU seconds of the process. What the peers reached is kept
in <folder>/peers.jsonl, one run a line, and is not run again. --save keeps the points of new runs of the peers as
<cloud>_<peer>_<scale>.ply; amls_grid --peers <folder> counts which of them lie farther off than they were.
"""
import argparse
import json
import os
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"  # CPU time would count threads that spin while they wait

import numpy as np
import pymeshlab


def read_points(path):
    data = Path(path).read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    n = next(int(line.split()[2]) for line in data[:end].decode().splitlines() if line.startswith("element vertex"))
    return np.frombuffer(data, "<f4", 3 * n, end).reshape(n, 3).astype(float)


def write_points(path, points):
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    path.write_bytes(header.encode() + points.astype("<f4").tobytes())


class Truth:
    """Distance to a mesh, by MeshLab's own attribute of sampled points: exact closest points on the surface."""

    def __init__(self, path):
        self.path = str(path)
        meshes = pymeshlab.MeshSet(verbose=False)
        meshes.load_new_mesh(self.path)
        v = meshes.current_mesh().vertex_matrix()
        self.diagonal = float(np.linalg.norm(v.max(0) - v.min(0)))

    def distances(self, points):
        meshes = pymeshlab.MeshSet(verbose=False)
        meshes.load_new_mesh(self.path)
        meshes.add_mesh(pymeshlab.Mesh(points), "points")
        meshes.apply_filter("compute_scalar_by_distance_from_another_mesh_per_vertex", measuremesh=1, refmesh=0,
                            signeddist=False, maxdist=pymeshlab.PureValue(self.diagonal))
        return np.abs(meshes.current_mesh().vertex_scalar_array()) / self.diagonal


def cpu(function):
    start = time.process_time()
    result = function()
    return result, time.process_time() - start


def run_amls(points):
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(points), "cloud")
    _, seconds = cpu(lambda: meshes.apply_filter("compute_mls_projection_amls", threads=1))
    return meshes.current_mesh().vertex_matrix(), seconds


def run_peer(name, points, scale):
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(points), "control")
    meshes.apply_filter("compute_normal_for_point_clouds", k=30)
    normals = meshes.current_mesh().vertex_normal_matrix()
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(points, v_normals_matrix=normals), "control")
    meshes.add_mesh(pymeshlab.Mesh(points, v_normals_matrix=normals), "proxy")
    meshes.set_current_mesh(0)  # with the other one current these filters crash as well
    _, seconds = cpu(lambda: meshes.apply_filter(f"compute_mls_projection_{name}", controlmesh=0, proxymesh=1,
                                                 filterscale=scale))
    return meshes.mesh(1).vertex_matrix(), seconds


def genuine(name, points):
    """How many points of a cloud are no outliers: in <model>_outliers_<percent> they come first."""
    model, _, percent = name.rpartition("_outliers_")
    return round(len(points) / (1 + float(percent) / 100)) if model else len(points)


def rms(distances):
    good = distances[np.isfinite(distances)]
    return 1e6 * float(np.sqrt(np.mean(good ** 2)))


class PeerRuns:
    """Errors and seconds of the peers' runs in a folder, kept beside its clouds."""

    def __init__(self, folder, save=None):
        self.save = save
        self.path = folder / "peers.jsonl"
        self.found = {}
        if self.path.exists():
            for line in self.path.read_text().splitlines():
                run = json.loads(line)
                self.found[run["cloud"], run["peer"], run["scale"]] = run

    def get(self, cloud, peer, scale, points, truth):
        key = cloud, peer, scale
        if key not in self.found:
            moved, seconds = run_peer(peer, points, scale)
            if self.save:
                write_points(self.save / f"{cloud}_{peer}_{scale}.ply", moved)
            run = {"cloud": cloud, "peer": peer, "scale": scale, "rms": rms(truth.distances(moved[:genuine(cloud, points)])), "seconds": seconds}
            self.found[key] = run
            with self.path.open("a") as out:
                out.write(json.dumps(run) + "\n")
        return self.found[key]["rms"], self.found[key]["seconds"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plugin")
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--models", default="", help="beginnings of the clouds' names, in the order to run")
    parser.add_argument("--only-peers", action="store_true")
    parser.add_argument("--save", type=Path)
    parser.add_argument("--peers", default="apss,rimls")
    parser.add_argument("--scales", default="2,4,8")
    arguments = parser.parse_args()
    if not arguments.only_peers:
        pymeshlab.load_plugin(arguments.plugin)
    print("| folder | cloud | points | input | AMLS | APSS 2 / 4 / 8 | RIMLS 2 / 4 / 8 | AMLS / best APSS | "
          "AMLS / best RIMLS | s AMLS | s best APSS | s best RIMLS |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|", flush=True)
    ratios = {"apss": [], "rimls": []}
    for start in arguments.models.split(","):
        for folder in arguments.folders:
            runs = PeerRuns(folder, arguments.save)
            for path in sorted(folder.glob(f"{start}*.ply")):
                name = path.stem
                truth = Truth((folder / f"{name}.truth").read_text().strip())
                points = read_points(path)
                peers = {peer: [runs.get(name, peer, int(scale), points, truth) for scale in arguments.scales.split(",")]
                         for peer in arguments.peers.split(",")}
                if arguments.only_peers:
                    continue
                moved, seconds = run_amls(points)
                count = genuine(name, points)
                ours = rms(truth.distances(moved[:count]))
                before = rms(truth.distances(points[:count]))
                row = [folder.name, name, str(len(points)), f"{before:.0f}", f"{ours:.0f}"]
                times = [f"{seconds:.2f}"]
                beside = []
                for peer in ratios:
                    if peer not in peers:
                        for column in (row, beside, times):
                            column.append("-")
                        continue
                    best = min(peers[peer])
                    ratios[peer].append(ours / best[0])
                    row.append(" / ".join(f"{error:.0f}" for error, _ in peers[peer]))
                    beside.append(f"{ratios[peer][-1]:.2f}")
                    times.append(f"{best[1]:.1f}")
                row += beside + times
                print("| " + " | ".join(row) + " |", flush=True)
    for peer, values in ratios.items():
        if values:
            print(f"\n{peer.upper()}: at or below in {sum(v <= 1 for v in values)} of {len(values)}, geometric mean "
                  f"{np.exp(np.mean(np.log(values))):.3f}, worst {max(values):.2f}")


if __name__ == "__main__":
    main()
