"""The filter 'Surface Reconstruction: Noisy Power Crust' in pymeshlab, MeshLab 2025.07's plugin manager and meshlabserver."""
import re
import subprocess
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pytest

from conftest import HOSTS
from hosts import Cloud, Length
from mesh_checks import assert_closed_manifold, examine, sphere, torus
from released_filters import NOISY_POWER_CRUST as FILTER

TORUS = torus(4000, 0.01, seed=1)


def run(host, folder, cloud, **parameters):
    outcome = host.run(FILTER, cloud, parameters, folder)
    assert outcome.error is None, outcome.error
    return outcome


# --- good input -----------------------------------------------------------------------------------------------------------

def test_noisy_torus_becomes_a_torus(any_host, tmp_path):
    outcome = run(any_host, tmp_path, Cloud(TORUS))
    report = assert_closed_manifold(outcome.surface)
    assert (report["components"], report["euler_characteristic"]) == (1, 0)
    assert outcome.layers == 2
    assert report["volume"] == pytest.approx(2 * np.pi**2 * 0.4**2, rel=0.03)


def test_a_hole_stays_open_when_asked(any_host, tmp_path):
    scan = sphere(4000, 0.005, seed=2)
    outcome = run(any_host, tmp_path, Cloud(scan[scan[:, 2] < 0.7]), open_holes=True)
    report = examine(outcome.surface)
    assert report["oriented"] and not report["closed"] and report["unused_vertices"] == 0, report
    assert (outcome.values["boundary_loops"], outcome.values["components"], outcome.values["genus"]) == (1, 1, 0)
    assert outcome.surface.points[:, 2].max() < 0.85


def test_result_values_agree_with_the_surface(any_host, tmp_path):
    outcome = run(any_host, tmp_path, Cloud(TORUS))
    report = examine(outcome.surface)
    values = outcome.values
    assert values["points_used"] == len(TORUS)
    for name in ("components", "euler_characteristic"):
        assert values[name] == report[name]
    assert values["genus"] == 1
    assert values["noise"] == pytest.approx(0.01, rel=0.5)
    assert values["balls_kept"] > 0
    assert values["smallest_ball"] > 0
    assert 0.01 < values["spacing"] < 0.2
    assert 0 <= values["violated_votes"] <= 1
    phases = [name for name in values if name.startswith("seconds_")]
    assert len(phases) > 2 and all(values[name] >= 0 for name in phases)


def test_all_hosts_find_the_same_topology(make_host, tmp_path):
    found = {name: examine(run(make_host(name, FILTER.plugin), tmp_path, Cloud(TORUS)).surface) for name in HOSTS}
    for key in ("components", "euler_characteristic"):
        assert len({report[key] for report in found.values()}) == 1, found


def test_colour_and_quality_come_from_the_nearest_sample(any_host, tmp_path):
    points = sphere(3000, 0.005, seed=2)
    above = points[:, 2] > 0
    colours = np.where(above[:, None], [250, 10, 20, 255], [10, 20, 250, 255])
    quality = np.where(above, 5.0, -5.0)
    surface = run(any_host, tmp_path, Cloud(points, colours=colours, quality=quality)).surface
    clear = np.abs(surface.points[:, 2]) > 0.2
    upper = surface.points[clear, 2] > 0
    assert np.array_equal(surface.colours[clear][:, :3], np.where(upper[:, None], [250, 10, 20], [10, 20, 250]))
    assert np.array_equal(surface.quality[clear], np.where(upper, 5.0, -5.0))


def test_no_colour_and_quality_without_the_inputs(make_host, tmp_path):
    """(Of pymeshlab's own layers made from arrays, every one claims to have colours.)"""
    surface = run(make_host("meshlab-2025.07", FILTER.plugin), tmp_path, Cloud(TORUS)).surface
    assert surface.colours is None and surface.quality is None


def test_polygon_diagonals_are_faux(make_host, tmp_path):
    surface = run(make_host("meshlab-2025.07", FILTER.plugin), tmp_path, Cloud(TORUS),
                  denoise="off", simplify=False, smooth=False).surface  # later steps make triangles of the polygons
    t = surface.triangles
    faux = set()
    real = set()
    for edge in range(3):
        for bits, a, b in zip(surface.faux_edges, t[:, edge], t[:, (edge + 1) % 3]):
            (faux if bits >> edge & 1 else real).add((min(a, b), max(a, b)))
    assert faux and not faux & real  # both triangles of a diagonal say so


def test_selected_only(any_host, tmp_path):
    left, right = sphere(1500, 0.005, seed=3), sphere(1500, 0.005, seed=4) + [5, 0, 0]
    selected = np.arange(3000) >= 1500
    surface = run(any_host, tmp_path, Cloud(np.vstack([left, right]), selected=selected), selected_only=True).surface
    assert surface.points[:, 0].min() > 3


def test_keep_components(any_host, tmp_path):
    points = np.vstack([sphere(1500, 0.005, seed=3), 0.5 * sphere(1500, 0.005, seed=4) + [5, 0, 0]])
    both = run(any_host, tmp_path, Cloud(points))
    assert assert_closed_manifold(both.surface)["components"] == 2
    largest = run(any_host, tmp_path, Cloud(points), keep_components="largest")
    assert assert_closed_manifold(largest.surface)["components"] == 1
    assert largest.surface.points[:, 0].max() < 3


def test_transform_of_the_layer_is_carried_over(any_host, tmp_path):
    angle = 0.7
    transform = np.array([[np.cos(angle), -np.sin(angle), 0, 10], [np.sin(angle), np.cos(angle), 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]])
    plain = run(any_host, tmp_path, Cloud(TORUS)).surface
    moved = run(any_host, tmp_path, Cloud(TORUS, transform=transform)).surface
    assert moved.transform == pytest.approx(transform, abs=1e-5)
    assert np.array_equal(moved.points, plain.points)  # coordinates are the layer's own


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale_does_not_matter(any_host, tmp_path, scale):
    outcome = run(any_host, tmp_path, Cloud(TORUS * scale))
    report = assert_closed_manifold(outcome.surface)
    assert (report["components"], report["euler_characteristic"]) == (1, 0)
    assert report["volume"] == pytest.approx(2 * np.pi**2 * 0.4**2 * scale**3, rel=0.03)


@pytest.mark.parametrize("denoise", ["off", "on"])
def test_utm_coordinates_give_the_same_surface(make_host, tmp_path, denoise):
    """In pymeshlab, which keeps double precision; float hosts round such coordinates on loading."""
    host = make_host("pymeshlab", FILTER.plugin)
    offset = np.array([5e5, 5e6, 100])
    cloud = np.round(TORUS * 2**20) / 2**20  # exact with and without the offset
    plain, moved = (run(host, tmp_path, Cloud(points), denoise=denoise).surface for points in (cloud, cloud + offset))
    assert plain.triangles.shape == moved.triangles.shape
    # Projected points are rounded to the coordinates' last digit, which can change the order of vertices.
    for vertex in (moved.points - offset)[::10]:
        assert np.linalg.norm(plain.points - vertex, axis=1).min() < 1e-8


def test_lengths_absolute_and_per_cent(any_host, tmp_path):
    diagonal = np.linalg.norm(np.ptp(TORUS, axis=0))
    absolute = run(any_host, tmp_path, Cloud(TORUS), noise=Length(0.004 * diagonal))
    relative = run(any_host, tmp_path, Cloud(TORUS), noise=Length(0.4, per_cent=True))
    assert absolute.values["noise"] == pytest.approx(0.004 * diagonal, rel=1e-4)
    assert relative.values["noise"] == pytest.approx(0.004 * diagonal, rel=1e-4)


# --- bad input: the cause and the remedy in the host's own words, the document as it was --------------------------------------

random = np.random.default_rng(0)
LINE = np.outer(random.uniform(size=50), [1, 2, 3])
PLANE = np.column_stack([random.uniform(size=(50, 2)), np.full(50, 2.0)])
BAD_CLOUDS = {
    "three points": (random.uniform(size=(3, 3)), "4"),
    "all equal": (np.ones((50, 3)), "equal|same|identical"),
    "collinear": (LINE, "line"),
    "coplanar": (PLANE, "plane"),
}


def assert_refused(outcome, pattern):
    assert outcome.error is not None
    assert re.search(pattern, outcome.error), outcome.error
    assert "internal error" not in outcome.error
    assert outcome.unchanged


@pytest.mark.parametrize("kind", BAD_CLOUDS)
def test_bad_cloud(any_host, tmp_path, kind):
    points, pattern = BAD_CLOUDS[kind]
    assert_refused(any_host.run(FILTER, Cloud(points), {}, tmp_path), pattern)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["pymeshlab", "meshlab-2025.07"])
def test_point_that_is_not_finite(make_host, tmp_path, name, value):
    points = TORUS.copy()
    points[7, 1] = value
    assert_refused(make_host(name, FILTER.plugin).run(FILTER, Cloud(points), {}, tmp_path), "finite")


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_meshlabserver_drops_points_that_are_not_finite(make_host, tmp_path, value):
    """It does so itself on loading; the filter then sees a good cloud."""
    points = TORUS.copy()
    points[7, 1] = value
    outcome = run(make_host("meshlabserver", FILTER.plugin), tmp_path, Cloud(points))
    assert outcome.values["points_used"] == len(TORUS) - 1


def test_threshold_that_deletes_every_inner_ball(any_host, tmp_path):
    outcome = any_host.run(FILTER, Cloud(TORUS), {"ball_threshold": Length(1.5)}, tmp_path)
    assert_refused(outcome, "ball_threshold|threshold|smaller")


def test_empty_selection(any_host, tmp_path):
    assert_refused(any_host.run(FILTER, Cloud(TORUS), {"selected_only": True}, tmp_path), "selected")


def test_no_layer(any_host, tmp_path):
    outcome = any_host.run(FILTER, None, {}, tmp_path)
    assert outcome.error is not None
    assert any(word in outcome.error for word in ("no layer", "at least one mesh")), outcome.error


@pytest.mark.parametrize("parameters", [{"noise": Length(-1.0)}, {"deep_intersection": 1.5}, {"threads": -2}])
def test_option_out_of_range_is_named(any_host, tmp_path, parameters):
    outcome = any_host.run(FILTER, Cloud(TORUS), parameters, tmp_path)
    assert_refused(outcome, next(iter(parameters)))


# --- one host only --------------------------------------------------------------------------------------------------------

def test_threads_do_not_change_the_result(make_host, tmp_path):
    host = make_host("pymeshlab", FILTER.plugin)
    one, two, again = (run(host, tmp_path, Cloud(TORUS), threads=n).surface for n in (1, 2, 2))
    for other in (two, again):
        assert np.array_equal(one.points, other.points) and np.array_equal(one.triangles, other.triangles)


def test_next_filter_works_after_an_error(make_host, tmp_path):
    host = make_host("pymeshlab", FILTER.plugin)
    meshes = host.mesh_set(Cloud(PLANE))
    with pytest.raises(host.pymeshlab.PyMeshLabException):
        meshes.apply_filter(FILTER.python_name)
    meshes.add_mesh(host.pymeshlab.Mesh(TORUS))
    assert meshes.apply_filter(FILTER.python_name)["genus"] == 1


def test_parameters_are_those_that_scripts_rely_on(make_host, tmp_path):
    host = make_host("pymeshlab", FILTER.plugin)
    meshes = host.mesh_set(Cloud(TORUS))
    meshes.apply_filter(FILTER.python_name)
    script = tmp_path / "script.mlx"
    meshes.save_filter_script(str(script))
    written = [(p.get("name"), p.get("type")) for p in xml.parse(script).getroot().iter("Param")]
    assert written == [(name, kind) for name, kind, _, _ in FILTER.parameters]


def test_plugin_manager_lists_the_filter_under_both_names(make_host, tmp_path):
    log = run(make_host("meshlab-2025.07", FILTER.plugin), tmp_path, Cloud(TORUS)).log.splitlines()
    assert f"python_name {FILTER.python_name}" in log
    assert [f"parameter {name}" for name, *_ in FILTER.parameters] == [line for line in log if line.startswith("parameter ")]


def test_cancelling_leaves_the_document_as_it_was(make_host, tmp_path):
    outcome = make_host("meshlab-2025.07", FILTER.plugin).run(FILTER, Cloud(TORUS), {}, tmp_path, cancel=True)
    assert_refused(outcome, "cancelled")


def test_progress_is_reported(tmp_path):
    """pymeshlab prints it; in a process of its own, since it writes past Python's standard output."""
    text = ("import hosts, mesh_checks; from released_filters import NOISY_POWER_CRUST as f; "
            "h = hosts.PyMeshLab(f.plugin); "
            "h.mesh_set(hosts.Cloud(mesh_checks.torus(4000, 0.01, 1)), verbose=True).apply_filter(f.python_name)")
    shown = subprocess.run([sys.executable, "-c", text], cwd=Path(__file__).parent, stdout=subprocess.PIPE,
                           stderr=subprocess.STDOUT, text=True, check=True)
    per_cent = [int(n) for n in re.findall(r"\[ (\d+)% \]", shown.stdout)]
    assert len(per_cent) > 5 and per_cent == sorted(per_cent), shown.stdout
    assert "Delaunay" in shown.stdout
