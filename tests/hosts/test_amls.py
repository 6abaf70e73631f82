"""The filters of libfilter_amls.so in pymeshlab, and the projection in the other hosts."""
import numpy as np
import pytest

from conftest import HOSTS
from hosts import Cloud
from mesh_checks import sphere, torus
from released_filters import FEATURE_SIZE, NORMALS, PROJECTION

PLUGIN = PROJECTION.plugin
SIGMA = 0.02
NOISY = sphere(4000, SIGMA, seed=5)
OUTLIERS = np.array([[3.0, 3, 3], [-3, 2, 1], [2, -3, -3]])


def radial_rms(points):
    return float(np.sqrt(np.mean((np.linalg.norm(points, axis=1) - 1) ** 2)))


@pytest.fixture(params=HOSTS)
def host(request, make_host):
    return make_host(request.param, PLUGIN)


@pytest.fixture
def meshes(make_host):
    return make_host("pymeshlab", PLUGIN).mesh_set(Cloud(NOISY))


def apply(meshes, spec, **parameters):
    return meshes.apply_filter(spec.python_name, **parameters)


# --- projection -----------------------------------------------------------------------------------------------------------

def test_projection_removes_noise_in_every_host(host, tmp_path):
    outcome = host.run(PROJECTION, Cloud(NOISY), {}, tmp_path)
    assert outcome.error is None, outcome.error
    assert outcome.layers == 1
    assert radial_rms(outcome.surface.points) < 0.25 * radial_rms(NOISY)
    assert outcome.values["noise"] == pytest.approx(SIGMA, rel=0.2)
    assert outcome.values["points_projected"] == len(NOISY)
    assert outcome.values["rho_e"] > 0


def test_errors_leave_the_document_in_every_host(host, tmp_path):
    for parameters, words in (({"tolerance": 0.0}, "tolerance"), ({"surface_layer": "nowhere"}, "nowhere"),
                              ({"cut_off": 9.0}, "cut-off")):
        outcome = host.run(PROJECTION, Cloud(NOISY), parameters, tmp_path)
        assert outcome.error and words in outcome.error
        assert outcome.unchanged


def test_normals_are_those_of_the_surface(meshes):
    apply(meshes, PROJECTION)
    mesh = meshes.current_mesh()
    unit = mesh.vertex_matrix() / np.linalg.norm(mesh.vertex_matrix(), axis=1)[:, None]
    angles = np.degrees(np.arccos(np.clip(np.sum(unit * mesh.vertex_normal_matrix(), axis=1), -1, 1)))
    assert np.sqrt(np.mean(angles ** 2)) < 2
    assert np.max(angles) < 18


def test_outliers_are_selected_and_stay(make_host):
    meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(np.vstack([NOISY, OUTLIERS])))
    values = apply(meshes, PROJECTION)
    mesh = meshes.current_mesh()
    assert values["outliers"] == len(OUTLIERS)
    assert np.flatnonzero(mesh.vertex_selection_array()).tolist() == list(range(len(NOISY), len(NOISY) + len(OUTLIERS)))
    assert np.array_equal(mesh.vertex_matrix()[len(NOISY):], OUTLIERS)


def test_outliers_are_removed_on_request(make_host):
    meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(np.vstack([OUTLIERS, NOISY])))
    apply(meshes, PROJECTION, remove_outliers=True)
    mesh = meshes.current_mesh()
    assert mesh.vertex_number() == len(NOISY)
    assert radial_rms(mesh.vertex_matrix()) < 0.25 * radial_rms(NOISY)


def test_selected_only_moves_only_the_selected(make_host):
    selected = np.arange(len(NOISY)) < 1000
    meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(NOISY, selected=selected))
    apply(meshes, PROJECTION, selected_only=True)
    after = meshes.current_mesh().vertex_matrix()
    assert np.array_equal(after[1000:], NOISY[1000:])
    assert radial_rms(after[:1000]) < 0.25 * radial_rms(NOISY[:1000])


def test_surface_of_another_layer_in_world_coordinates(make_host):
    import pymeshlab
    meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(NOISY))
    shift = np.array([0.05, 0, 0])
    queries = sphere(500, 0, seed=6) * 1.03 - shift
    meshes.add_mesh(pymeshlab.Mesh(queries), "queries")
    transform = np.eye(4)
    transform[:3, 3] = shift
    meshes.set_matrix(transformmatrix=transform, freeze=False)
    apply(meshes, PROJECTION, surface_layer="cloud")
    assert radial_rms(meshes.current_mesh().vertex_matrix() + shift) < 0.01
    assert np.array_equal(meshes.mesh(0).vertex_matrix(), NOISY)


def far_and_near():
    """Queries for the surface of NOISY: the last is beyond its reach."""
    return np.vstack([sphere(50, 0, seed=6) * 1.02, [[40.0, 0, 0]]])


@pytest.mark.parametrize("parameters", [{"remove_outliers": True}, {"weights": "paper's normalised I"}], ids=["remove", "paper"])
def test_points_too_far_from_another_layer_stay_and_are_selected(make_host, parameters):
    import pymeshlab
    meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(NOISY))
    meshes.add_mesh(pymeshlab.Mesh(far_and_near()), "queries")
    values = apply(meshes, PROJECTION, surface_layer="cloud", **parameters)
    mesh = meshes.current_mesh()
    assert values["points_too_far"] == 1 and values["points_projected"] == 50
    assert np.flatnonzero(mesh.vertex_selection_array()).tolist() == [50]
    assert np.array_equal(mesh.vertex_matrix()[50], far_and_near()[50])
    assert mesh.vertex_normal_matrix()[50] @ [1, 0, 0] > 0.9


def test_the_layers_own_name_is_as_good_as_none(make_host):
    results = []
    for name in ("", "cloud"):
        meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(np.vstack([NOISY, OUTLIERS])))
        values = apply(meshes, PROJECTION, surface_layer=name)
        assert values["outliers"] == len(OUTLIERS)
        results.append(meshes.current_mesh().vertex_matrix())
    assert np.array_equal(*results)


def test_removed_points_take_their_edges_along(make_host):
    import pymeshlab
    points = np.vstack([NOISY, OUTLIERS])
    edges = np.array([[0, 1], [1, len(NOISY)], [len(NOISY), len(NOISY) + 1]])
    meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(NOISY))
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=points, edge_matrix=edges), "polyline")
    apply(meshes, PROJECTION, remove_outliers=True)
    assert meshes.current_mesh().edge_matrix().tolist() == [[0, 1]]


@pytest.mark.parametrize("parameter, value", [("rho_e", -1.0), ("max_iterations", -1), ("cut_off", -1.0)])
@pytest.mark.parametrize("weights", ["anchors with curvature", "paper's plain N"])
def test_parameters_out_of_range_are_refused(meshes, weights, parameter, value):
    with pytest.raises(Exception, match={"rho_e": "rho_e", "max_iterations": "iterations", "cut_off": "[Cc]ut-off"}[parameter]):
        apply(meshes, PROJECTION, weights=weights, **{parameter: value})
    assert np.array_equal(meshes.current_mesh().vertex_matrix(), NOISY)


def test_the_number_of_a_bad_vertex_is_that_of_the_layer(make_host):
    points = NOISY.copy()
    points[600] = np.nan
    meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(points, selected=np.arange(len(points)) >= 500))
    with pytest.raises(Exception, match="Vertex 600 "):
        apply(meshes, NORMALS, selected_only=True)


def test_given_normals_decide_the_sides(make_host):
    meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(NOISY))
    apply(meshes, NORMALS)
    meshes.apply_filter("compute_normal_for_point_clouds", k=10, flipflag=True, viewpos=np.zeros(3))
    inward = np.mean(np.sum(meshes.current_mesh().vertex_normal_matrix() * NOISY, axis=1) < 0)
    assert inward > 0.99
    apply(meshes, PROJECTION, normals="use the layer's")
    mesh = meshes.current_mesh()
    assert np.mean(np.sum(mesh.vertex_normal_matrix() * mesh.vertex_matrix(), axis=1) < 0) > 0.99


@pytest.mark.parametrize("weights", ["paper's normalised I", "paper's plain N"])
def test_the_papers_own_weights(meshes, weights):
    values = apply(meshes, PROJECTION, weights=weights, rho_e=0.3)
    assert values["rho_e"] == pytest.approx(0.3)
    assert radial_rms(meshes.current_mesh().vertex_matrix()) < 0.05  # planes shrink a sphere


def test_two_runs_and_thread_counts_agree_bit_for_bit(make_host):
    results = []
    for threads in (1, 2, 2):
        meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(NOISY))
        apply(meshes, PROJECTION, threads=threads)
        results.append(meshes.current_mesh().vertex_matrix())
    assert np.array_equal(results[0], results[1]) and np.array_equal(results[1], results[2])


# --- normals and feature size ---------------------------------------------------------------------------------------------

@pytest.mark.parametrize("method", ["automatic", "paper"])
def test_normals_point_outward(meshes, method):
    apply(meshes, NORMALS, method=method)
    mesh = meshes.current_mesh()
    assert np.array_equal(mesh.vertex_matrix(), NOISY)
    assert np.mean(np.sum(mesh.vertex_normal_matrix() * NOISY, axis=1) > 0) > 0.999


def test_feature_size_of_a_torus(make_host):
    points = torus(8000, 0, seed=7)  # radii 1 and 0.4
    meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(points))
    values = apply(meshes, FEATURE_SIZE, colorize=True)
    mesh = meshes.current_mesh()
    assert np.median(mesh.vertex_scalar_array()) == pytest.approx(0.4, rel=0.1)
    assert values["median_feature_size"] == pytest.approx(np.median(mesh.vertex_scalar_array()), rel=1e-6)
    assert values["min_feature_size"] <= values["median_feature_size"] <= values["max_feature_size"]
    assert len(np.unique(mesh.vertex_color_matrix(), axis=0)) > 10


def test_feature_size_keeps_colours_unless_asked(make_host):
    colours = np.tile([10, 20, 30, 255], (len(NOISY), 1))
    meshes = make_host("pymeshlab", PLUGIN).mesh_set(Cloud(NOISY, colours=colours))
    apply(meshes, FEATURE_SIZE, smoothing=10)
    assert np.array_equal(np.rint(meshes.current_mesh().vertex_color_matrix() * 255), colours)
