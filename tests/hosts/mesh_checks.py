"""Independent checks of triangle meshes, and clouds with known topology."""
import numpy as np


def components(n, triangles):
    """Label per vertex; vertices of one component have the same one."""
    label = np.arange(n)
    while True:
        before = label.copy()
        lowest = label[triangles].min(axis=1)
        for corner in range(3):
            np.minimum.at(label, triangles[:, corner], lowest)
        label = label[label]
        if np.array_equal(label, before):
            return label


def examine(surface):
    """What a closed surface must be, and its topology."""
    points, triangles = surface.points, surface.triangles
    n = len(points)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    directed, uses = np.unique(edges[:, 0] * n + edges[:, 1], return_counts=True)
    reverse = np.unique(edges[:, 1] * n + edges[:, 0])
    used = np.unique(triangles)
    # The triangles around a vertex form one fan if walking over shared edges reaches all of them.
    corner_vertex = triangles.ravel()
    after = triangles[:, [1, 2, 0]].ravel().astype(np.int64)
    before = triangles[:, [2, 0, 1]].ravel().astype(np.int64)
    start = corner_vertex.astype(np.int64) * n + after
    order = np.argsort(start)
    following = order[np.clip(np.searchsorted(start[order], corner_vertex.astype(np.int64) * n + before), 0, len(start) - 1)]
    label = np.arange(len(start))
    while True:  # pointer doubling along the cycles of corners
        lowest = np.minimum(label, label[following])
        following = following[following]
        if np.array_equal(lowest, label):
            break
        label = lowest
    fans = len(np.unique(label))
    a, b, c = (points[triangles[:, i]] - points.mean(axis=0) for i in range(3))
    labels = components(n, triangles)
    return {
        "closed": bool(np.array_equal(directed, reverse)),
        "oriented": bool(np.all(uses == 1)),
        "vertex_manifold": fans == len(used),
        "unused_vertices": n - len(used),
        "components": len(np.unique(labels[used])),
        "euler_characteristic": len(used) - len(edges) // 2 + len(triangles),
        "volume": float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6),
    }


def assert_closed_manifold(surface):
    report = examine(surface)
    assert np.isfinite(surface.points).all()
    assert report["closed"] and report["oriented"] and report["vertex_manifold"] and report["unused_vertices"] == 0, report
    assert report["volume"] > 0, report
    return report


def torus(n, noise, seed):
    """Noisy points of a torus (radii 1 and 0.4), equally dense by rejection."""
    random = np.random.default_rng(seed)
    u, v, w = random.uniform(0, 2 * np.pi, 4 * n), random.uniform(0, 2 * np.pi, 4 * n), random.uniform(0, 1.4, 4 * n)
    keep = np.flatnonzero(w < 1 + 0.4 * np.cos(v))[:n]
    u, v = u[keep], v[keep]
    ring = 1 + 0.4 * np.cos(v)
    return np.column_stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)]) + random.normal(0, noise, (len(u), 3))


def sphere(n, noise, seed):
    """Noisy points of the unit sphere."""
    random = np.random.default_rng(seed)
    points = random.normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1)[:, None] + random.normal(0, noise, (n, 3))
