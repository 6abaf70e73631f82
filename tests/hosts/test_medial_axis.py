"""The filter 'Medial Axis: Power Shape' in every host."""
import numpy as np
import pytest

from conftest import HOSTS
from hosts import Cloud
from mesh_checks import torus
from released_filters import MEDIAL_AXIS as FILTER

MAJOR, MINOR = 1.0, 0.4  # of mesh_checks.torus()


@pytest.mark.parametrize("host", HOSTS)
def test_axis_of_a_torus_is_its_circle(make_host, tmp_path, host):
    outcome = make_host(host, FILTER.plugin).run(FILTER, Cloud(torus(4000, 0.01, seed=1)), {}, tmp_path)
    assert outcome.error is None, outcome.error
    poles = outcome.surface.points
    assert len(poles) > 100
    off_circle = np.hypot(np.hypot(poles[:, 0], poles[:, 1]) - MAJOR, poles[:, 2])
    assert off_circle.max() < 0.15
    angles = np.sort(np.arctan2(poles[:, 1], poles[:, 0]))
    assert np.diff(angles).max() < 0.3
    values = outcome.values
    assert values["poles"] == len(poles)
    assert values["union_volume"] == pytest.approx(2 * np.pi**2 * MINOR**2 * MAJOR, rel=0.05)
    assert values["largest_radius"] == pytest.approx(MINOR, rel=0.1)


def test_sheets_reach_the_edges_of_a_box(make_host):
    half = np.array([1.0, 0.75, 0.5])
    random = np.random.default_rng(3)
    points = random.uniform(-half, half, (6000, 3))
    areas = np.array([half[1] * half[2], half[2] * half[0], half[0] * half[1]])
    face = random.choice(3, len(points), p=areas / areas.sum())
    points[np.arange(len(points)), face] = half[face] * random.choice([-1.0, 1.0], len(points))
    meshes = make_host("pymeshlab", FILTER.plugin).mesh_set(Cloud(points))
    values = meshes.apply_filter(FILTER.python_name)
    axis = meshes.current_mesh()
    radii = axis.vertex_custom_scalar_attribute_array("radius")
    assert values["edge_places"] == (radii == 0).sum() > 100
    assert values["poles"] == (radii > 0).sum()
    off = np.sort(np.abs(np.abs(axis.vertex_matrix()[radii == 0]) - half), axis=1)
    assert off[:, 1].max() < 0.03  # an edge lies on two faces


def test_radii_and_edges_reach_pymeshlab(make_host):
    points = torus(3000, 0.0, seed=2)
    meshes = make_host("pymeshlab", FILTER.plugin).mesh_set(Cloud(points))
    values = meshes.apply_filter(FILTER.python_name, side="both")
    axis = meshes.current_mesh()
    assert meshes.mesh_number() == 2
    radii = axis.vertex_custom_scalar_attribute_array("radius")
    assert np.array_equal(radii, axis.vertex_scalar_array())
    assert radii.min() > 0
    assert axis.face_number() == values["triangles"] > 0
    assert axis.edge_number() == values["edges"]
    # A polar ball reaches the nearest point and holds none.
    distances = np.linalg.norm(axis.vertex_matrix()[:, None] - points[None], axis=2).min(axis=1)
    assert np.abs(distances - radii).max() < 1e-6 * radii.max()
