"""The filter 'Surface Reconstruction: AMLS' in every host."""
import numpy as np
import pytest

from conftest import HOSTS
from hosts import Cloud
from mesh_checks import assert_closed_manifold, examine, sphere, torus
from released_filters import AMLS_RECONSTRUCTION as FILTER


@pytest.mark.parametrize("host", HOSTS)
def test_noisy_torus_becomes_a_smooth_torus(make_host, tmp_path, host):
    outcome = make_host(host, FILTER.plugin).run(FILTER, Cloud(torus(8000, 0.02, seed=1)), {}, tmp_path)
    assert outcome.error is None, outcome.error
    report = assert_closed_manifold(outcome.surface)
    assert (report["components"], report["euler_characteristic"]) == (1, 0)
    assert report["volume"] == pytest.approx(2 * np.pi**2 * 0.4**2, rel=0.02)
    points = outcome.surface.points
    off = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1, points[:, 2]) - 0.4
    assert np.sqrt(np.mean(off**2)) < 0.006  # the points: 0.02
    assert outcome.values["noise"] == pytest.approx(0.02, rel=0.15)


@pytest.mark.parametrize("host", HOSTS)
def test_a_hole_stays_open_when_asked(make_host, tmp_path, host):
    scan = sphere(8000, 0.02, seed=2)
    outcome = make_host(host, FILTER.plugin).run(FILTER, Cloud(scan[scan[:, 2] < 0.7]), {"open_holes": True}, tmp_path)
    assert outcome.error is None, outcome.error
    assert not examine(outcome.surface)["closed"]
    assert (outcome.values["boundary_loops"], outcome.values["components"], outcome.values["genus"]) == (1, 1, 0)


def test_too_few_points_say_so(make_host, tmp_path):
    outcome = make_host("pymeshlab", FILTER.plugin).run(FILTER, Cloud(np.eye(3)), {}, tmp_path)
    assert "at least 4" in outcome.error
    assert outcome.layers == 1
