"""The filter 'Point Cloud Refinement: PN Triangles' in every host, and what only pymeshlab shows of it."""
import numpy as np
import pytest

from conftest import HOSTS
from hosts import Cloud, Length
from released_filters import PN_REFINEMENT as FILTER

pymeshlab = pytest.importorskip("pymeshlab")


def sphere_points(n, seed):
    points = np.random.default_rng(seed).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1)[:, None]


@pytest.fixture(autouse=True)
def loaded(make_host):
    make_host("pymeshlab", FILTER.plugin)


@pytest.fixture(params=HOSTS)
def host(request, make_host):
    return make_host(request.param, FILTER.plugin)


def test_sphere_becomes_dense_in_every_host(host, tmp_path):
    # Without normals: the filter computes them. Quality: the height, so that what is interpolated is known.
    points = sphere_points(2000, 7)
    outcome = host.run(FILTER, Cloud(points, quality=points[:, 2]), {"steps": 2}, tmp_path)
    assert outcome.error is None, outcome.error
    assert outcome.layers == 2
    refined = outcome.surface.points
    expected = points if host.double else points.astype(np.float32).astype(float)
    assert np.array_equal(refined[:2000], expected)
    assert len(refined) == 2000 + outcome.values["new_points"]
    assert len(refined) > 2.5 * 2000
    assert np.abs(np.linalg.norm(refined, axis=1) - 1).max() < 0.02
    assert np.abs(outcome.surface.quality - refined[:, 2]).max() < 0.1
    assert len(outcome.surface.triangles) == 0


def test_parameters_reach_the_filter_in_every_host(host, tmp_path):
    points = sphere_points(1500, 8)
    cloud = Cloud(points, selected=np.arange(1500) < 200)
    outcome = host.run(FILTER, cloud, {"steps": 2, "fast": True, "selected_only": True, "into_new_layer": False}, tmp_path)
    assert outcome.error is None, outcome.error
    assert outcome.layers == 1
    assert 100 < outcome.values["new_points"] < 2500  # of all 1,500 points it would be five times that
    outcome = host.run(FILTER, Cloud(points), {"steps": 6, "max_points": 4000}, tmp_path)
    assert outcome.error is None, outcome.error
    assert 1500 < len(outcome.surface.points) <= 4000


def test_errors_leave_the_document_in_every_host(host, tmp_path):
    points = sphere_points(500, 9)
    for parameters, words in (({"boundary_angle": 10.0}, "boundary angle"), ({"steps": 31}, "steps"),
                              ({"crease_angle": -1.0}, "crease angle")):
        outcome = host.run(FILTER, Cloud(points), parameters, tmp_path)
        assert outcome.error and words in outcome.error
        assert outcome.unchanged


def mesh_set(points, **attributes):
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(points, **attributes), "cloud")
    return meshes


def test_sphere_becomes_dense_in_a_new_layer():
    points = sphere_points(1500, 1)
    meshes = mesh_set(points, v_normals_matrix=points)
    values = meshes.apply_filter(FILTER.python_name, steps=3)
    assert meshes.mesh_number() == 2
    refined = meshes.current_mesh()
    vertices = refined.vertex_matrix()
    assert np.array_equal(vertices[:1500], points)
    assert len(vertices) == values["points_step_3"] == 1500 + values["new_points"]
    assert len(vertices) > 4 * 1500
    assert np.abs(np.linalg.norm(vertices, axis=1) - 1).max() < 1e-3
    cosines = np.einsum("ij,ij->i", refined.vertex_normal_matrix(), vertices)
    assert np.degrees(np.arccos(np.clip(cosines, -1, 1))).max() < 1
    assert np.array_equal(meshes.mesh(0).vertex_matrix(), points)


def test_colour_and_quality_lie_between_those_of_the_neighbours():
    points = sphere_points(2000, 2)
    colours = np.column_stack([(points + 1) / 2, np.ones(len(points))])
    quality = points[:, 2].copy()
    meshes = mesh_set(points, v_normals_matrix=points, v_color_matrix=colours, v_scalar_array=quality)
    meshes.apply_filter(FILTER.python_name, steps=2)
    refined = meshes.current_mesh()
    vertices = refined.vertex_matrix()
    assert np.abs(refined.vertex_scalar_array() - vertices[:, 2]).max() < 0.05
    assert np.abs(refined.vertex_color_matrix()[:, :3] - (vertices + 1) / 2).max() < 0.05
    assert np.array_equal(refined.vertex_scalar_array()[:2000], quality)
    radii = refined.vertex_custom_scalar_attribute_array("radius")
    assert np.all((radii >= 0) & (radii < 0.5))


def test_without_normals_they_are_computed():
    points = sphere_points(2000, 3)
    meshes = mesh_set(points)
    meshes.apply_filter(FILTER.python_name, steps=1)
    refined = meshes.current_mesh()
    cosines = np.einsum("ij,ij->i", refined.vertex_normal_matrix(), refined.vertex_matrix())
    assert np.mean(cosines > 0.9) > 0.99


def test_without_normals_noise_turns_none_over():
    exact = sphere_points(4000, 5)
    points = exact + np.random.default_rng(7).normal(scale=0.005, size=exact.shape)
    meshes = mesh_set(points)
    assert meshes.apply_filter(FILTER.python_name, steps=0)["turned_normals"] == 0
    cosines = np.einsum("ij,ij->i", meshes.current_mesh().vertex_normal_matrix()[:4000], exact)
    assert np.mean(cosines > 0) > 0.999


def test_in_place_keeps_the_layer_and_its_faces():
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.create_sphere(subdiv=4)
    before = meshes.current_mesh()
    points, faces = before.vertex_matrix(), before.face_matrix()
    meshes.apply_filter(FILTER.python_name, steps=1, into_new_layer=False)
    assert meshes.mesh_number() == 1
    after = meshes.current_mesh()
    assert np.array_equal(after.vertex_matrix()[:len(points)], points)
    assert after.vertex_number() > 1.5 * len(points)
    assert np.array_equal(after.face_matrix(), faces)


def test_selected_vertices_only():
    points = sphere_points(2000, 4)
    meshes = mesh_set(points, v_normals_matrix=points)
    meshes.compute_selection_by_condition_per_vertex(condselect="z > 0")
    meshes.apply_filter(FILTER.python_name, steps=2, selected_only=True)
    added = meshes.current_mesh().vertex_matrix()[2000:]
    assert len(added) > 2000
    assert added[:, 2].min() > -0.3


def test_a_wrong_option_is_named_and_changes_nothing():
    points = sphere_points(500, 5)
    meshes = mesh_set(points, v_normals_matrix=points)
    with pytest.raises(pymeshlab.PyMeshLabException, match="boundary angle"):
        meshes.apply_filter(FILTER.python_name, boundary_angle=10.0)
    assert meshes.mesh_number() == 1
    assert np.array_equal(meshes.current_mesh().vertex_matrix(), points)


def test_a_step_beyond_the_largest_number_is_not_done():
    points = sphere_points(1000, 6)
    meshes = mesh_set(points, v_normals_matrix=points)
    values = meshes.apply_filter(FILTER.python_name, steps=8, max_points=5000)
    assert 1000 < meshes.current_mesh().vertex_number() <= 5000
    assert "points_step_8" not in values


def flat_points(n):
    return np.column_stack([np.random.default_rng(10).uniform(size=(n, 2)), np.zeros(n)])


def test_a_flat_cloud_is_refined_with_normals_and_refused_without():
    points = flat_points(500)
    meshes = mesh_set(points, v_normals_matrix=np.tile([0.0, 0, 1], (500, 1)))
    assert meshes.apply_filter(FILTER.python_name, steps=1)["new_points"] > 250
    assert np.all(meshes.current_mesh().vertex_matrix()[:, 2] == 0)
    with pytest.raises(pymeshlab.PyMeshLabException, match="Compute normals for point sets"):
        mesh_set(points).apply_filter(FILTER.python_name)


def test_a_run_that_adds_nothing_says_so(make_host, tmp_path):
    host = make_host("meshlab-2025.07", FILTER.plugin)
    cloud = Cloud(sphere_points(500, 11))
    assert "No point was added" not in host.run(FILTER, cloud, {"steps": 1}, tmp_path).log
    for parameters in ({"initial_radius": Length(100, per_cent=True)}, {"max_points": 500}):
        outcome = host.run(FILTER, cloud, parameters, tmp_path)
        assert outcome.values["new_points"] == 0
        assert "No point was added" in outcome.log
