"""FILTERS.md, the scripts in examples/ and the released names against the plugins."""
import re

import filters_page
import hosts
import meshlab_2020
import pytest
import released_filters
from mesh_checks import torus

TORUS = torus(4000, 0.01, seed=1)


def test_committed_files_are_what_the_plugins_declare():
    for path, text in filters_page.files().items():
        assert path.read_text() == text, f"{path.name} is stale: run tests/hosts/filters_page.py"


@pytest.mark.parametrize("released", released_filters.ALL, ids=lambda f: f.python_name)
def test_names_parameters_and_defaults_are_those_released(released):
    declared, = [f for f in hosts.filters_of(hosts.BUILD / "plugins" / hosts.MeshLab2025.name / released.plugin)
                 if f.python_name == released.python_name]
    assert declared.name == released.name
    shown = {bool: lambda flag: "on" if flag else "off", float: lambda number: f"{number:g}"}
    assert [(p.name, p.kind, p.default, p.choices) for p in declared.parameters] == [
        (name, kind, shown.get(type(default), str)(default), choices or []) for name, kind, default, choices in released.parameters]


MAKES_RADII = {"generate_medial_axis_power_shape", "meshing_point_cloud_refinement_pn"}
OTHER_WAYS = {"compute_normal_from_delaunay_balls": {"method": "paper"}}


@pytest.mark.parametrize("released", released_filters.ALL, ids=lambda f: f.python_name)
def test_result_values_are_described(make_host, released):
    host = make_host("pymeshlab", released.plugin)
    returned = set()
    for parameters in ({}, OTHER_WAYS.get(released.python_name, {})):
        values = host.mesh_set(hosts.Cloud(TORUS)).apply_filter(released.python_name, **parameters)
        returned |= {"points_step_..." if name.startswith("points_step_") else name
                     for name in values if not name.startswith("seconds_")}
    assert returned == set(filters_page.VALUES[released.python_name])


@pytest.mark.parametrize("released", released_filters.ALL, ids=lambda f: f.python_name)
def test_script_runs_in_meshlabserver(make_host, tmp_path, released):
    host = make_host("meshlabserver", released.plugin)
    hosts.write_ply(tmp_path / "scan.ply", hosts.Cloud(TORUS))
    script = filters_page.ROOT / "examples" / f"{filters_page.SCRIPTS[released.python_name]}.mlx"
    masks = re.search(r"`meshlabserver .*?-m ([a-z ]+) -s <script>`", filters_page.HEAD).group(1).split()
    code, log = meshlab_2020.run_server(host.programs, host.display, ["-i", "scan.ply", "-o", "out.ply", "-m", *masks, "-s", script], tmp_path)
    assert code == 0, log
    assert released.name in log
    header = (tmp_path / "out.ply").read_bytes().split(b"end_header")[0].decode().split()
    assert {"nx", "red", "quality"} <= set(header)
    assert ("radius" in header) == (released.python_name in MAKES_RADII)
