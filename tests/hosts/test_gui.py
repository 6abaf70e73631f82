"""The filters in MeshLab 2020's window: in the menus; the dialog and the result of one. Pictures are left in build/gui/."""
import subprocess

import pytest

import hosts
import meshlab_2020
from hosts import BUILD, Cloud
from mesh_checks import torus
from released_filters import NOISY_POWER_CRUST


@pytest.mark.skipif(not meshlab_2020.is_installed(), reason="MeshLab 2020.09 is not installed")
def test_filter_runs_from_the_menu(display, tmp_path):
    pictures = BUILD / "gui"
    pictures.mkdir(exist_ok=True)
    for old in pictures.glob("*"):
        old.unlink()
    programs = meshlab_2020.private_install(BUILD / "meshlab-2020-gui", BUILD / "plugins" / "meshlab-2020.09",
                                            more=[BUILD / "tests" / "hosts" / "libgui_probe.so"])
    hosts.write_ply(tmp_path / "torus.ply", Cloud(torus(4000, 0.01, seed=1)))
    names = [f.name for f in hosts.all_filters()]
    process = subprocess.run(
        [str(programs / "meshlab"), str(tmp_path / "torus.ply")], cwd=tmp_path, stdin=subprocess.DEVNULL,
        env={**meshlab_2020.environment(display, tmp_path / "home"), "PROBE_FILTER": NOISY_POWER_CRUST.name,
             "PROBE_FOLDER": str(pictures), "PROBE_MENUS": "|".join(names)},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", timeout=180)
    report = (pictures / "report.txt").read_text() if (pictures / "report.txt").exists() else process.stdout
    lines = report.splitlines()
    assert NOISY_POWER_CRUST.name in names
    for name in names:
        assert any(line.startswith("menu /Filters/") and line.endswith("/" + name) for line in lines), (name, report)
    assert any(line.startswith("menu /Filters/Remeshing") for line in lines), report
    assert any(line.startswith("menu /Filters/Point Set") for line in lines), report
    assert not any("disabled" in line for line in lines), report
    assert lines[-2:] == ["apply", "done"], report  # no message box came up
