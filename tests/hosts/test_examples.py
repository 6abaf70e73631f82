"""The examples of the README run as they stand."""
import re
import subprocess
import sys
from pathlib import Path

import pytest

import hosts
import meshlab_2020
from hosts import BUILD, Cloud
from mesh_checks import assert_closed_manifold, torus
from released_filters import NOISY_POWER_CRUST

ROOT = Path(__file__).parents[2]
TORUS = torus(4000, 0.01, seed=1)


def test_meshlabserver_as_in_the_readme(make_host, tmp_path):
    host = make_host("meshlabserver", NOISY_POWER_CRUST.plugin)
    hosts.write_ply(tmp_path / "scan.ply", Cloud(TORUS))
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    line = re.search(r"^xvfb-run -a meshlabserver (.*)$", (ROOT / "README.md").read_text(), re.M).group(1)
    code, log = meshlab_2020.run_server(host.programs, host.display, line.split(), tmp_path)
    assert code == 0, log
    assert assert_closed_manifold(hosts.read_ply(tmp_path / "surface.ply"))["euler_characteristic"] == 0


@pytest.mark.parametrize("host", ["meshlabserver", "pymeshlab"])
def test_script_older_than_a_parameter(make_host, tmp_path, host):
    text, found = re.subn(r'.*name="open_holes".*\n', "", (ROOT / "examples" / "noisy_power_crust.mlx").read_text())
    assert found == 1
    (tmp_path / "old.mlx").write_text(text)
    hosts.write_ply(tmp_path / "scan.ply", Cloud(TORUS))
    made = make_host(host, NOISY_POWER_CRUST.plugin)
    if host == "meshlabserver":
        code, log = meshlab_2020.run_server(made.programs, made.display, [
            "-i", "scan.ply", "-o", "surface.ply", "-s", tmp_path / "old.mlx"], tmp_path)
        assert code == 0, log
        surface = hosts.read_ply(tmp_path / "surface.ply")
    else:
        meshes = made.mesh_set(Cloud(TORUS))
        meshes.load_filter_script(str(tmp_path / "old.mlx"))
        meshes.apply_filter_script()
        mesh = meshes.current_mesh()
        surface = hosts.Surface(mesh.vertex_matrix(), mesh.face_matrix())
    assert assert_closed_manifold(surface)["euler_characteristic"] == 0


def test_script_in_pymeshlab(make_host, tmp_path):
    host = make_host("pymeshlab", NOISY_POWER_CRUST.plugin)
    meshes = host.mesh_set(Cloud(TORUS))
    meshes.load_filter_script(str(ROOT / "examples" / "noisy_power_crust.mlx"))
    meshes.apply_filter_script()
    mesh = meshes.current_mesh()
    assert assert_closed_manifold(hosts.Surface(mesh.vertex_matrix(), mesh.face_matrix()))["euler_characteristic"] == 0


def test_python_of_the_readme(tmp_path):
    code = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S).group(1)
    hosts.write_ply(tmp_path / "scan.ply", Cloud(TORUS))
    (tmp_path / "build").symlink_to(BUILD)
    shown = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert shown.returncode == 0, shown.stderr
    assert shown.stdout.split()[1:] == ["1", "1"]  # components, genus
    assert (tmp_path / "surface.ply").exists()


def test_batch_goes_on_after_a_bad_file(tmp_path):
    (tmp_path / "in").mkdir()
    hosts.write_ply(tmp_path / "in" / "a_flat.ply", Cloud(TORUS * [1, 1, 0]))
    hosts.write_ply(tmp_path / "in" / "b_torus.ply", Cloud(TORUS))
    plugin = BUILD / "plugins" / "pymeshlab-2025.7" / NOISY_POWER_CRUST.plugin
    shown = subprocess.run([sys.executable, ROOT / "examples" / "batch.py", tmp_path / "in", tmp_path / "out", plugin],
                           capture_output=True, text=True)
    lines = shown.stdout.splitlines()
    assert shown.returncode == 1
    assert "plane" in lines[0] and "genus 1" in lines[1], shown
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["b_torus.ply"]


def test_batch_refuses_to_write_among_its_input(tmp_path):
    hosts.write_ply(tmp_path / "torus.ply", Cloud(TORUS))
    plugin = BUILD / "plugins" / "pymeshlab-2025.7" / NOISY_POWER_CRUST.plugin
    shown = subprocess.run([sys.executable, ROOT / "examples" / "batch.py", tmp_path, tmp_path, plugin], capture_output=True, text=True)
    assert shown.returncode == 1 and "another" in shown.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["torus.ply"]
