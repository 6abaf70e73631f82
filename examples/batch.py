"""Reconstructs every cloud of a folder:  batch.py <folder> <output folder> [<plugin.so>]

Prints one line per file; a file that cannot be reconstructed is reported and does not end the job. The surface of scan.ply
becomes scan.ply, that of scan.xyz scan.xyz.ply, in a folder that must be another than that of the clouds.
"""
import sys
from pathlib import Path

import pymeshlab

FILTER = "generate_surface_reconstruction_noisy_power_crust"


def main(folder, output, plugin):
    pymeshlab.load_plugin(str(Path(plugin).resolve()))
    output.mkdir(parents=True, exist_ok=True)
    if output.samefile(folder):
        sys.exit("The output folder must be another one: surfaces there would be taken for clouds by the next run.")
    failed = 0
    # One MeshSet for the whole job: after a filter has failed, pymeshlab 2025.7 goes on writing to the log of the MeshSet in
    # which it failed, and crashes if that is gone (PyMeshLab issue 399).
    meshes = pymeshlab.MeshSet(verbose=False)
    for cloud in sorted(p for p in folder.iterdir() if p.suffix.lower() in (".ply", ".obj", ".xyz", ".pts")):
        name = cloud.name if cloud.suffix == ".ply" else f"{cloud.name}.ply"
        meshes.clear()
        try:
            meshes.load_new_mesh(str(cloud))
            found = meshes.apply_filter(FILTER, threads=1)  # one thread: run several jobs side by side instead
            meshes.save_current_mesh(str(output / name))
        except pymeshlab.PyMeshLabException as problem:
            failed += 1
            print(f"{cloud.name}: {str(problem).splitlines()[-1]}")
            continue
        print(f"{cloud.name}: {found['points_used']} points, noise {found['noise']:.3g}, genus {found['genus']}")
    return 1 if failed else 0


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    default = Path(__file__).parents[1] / "build/plugins/pymeshlab-2025.7/libfilter_noisy_powercrust.so"
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3] if len(sys.argv) == 4 else default))
