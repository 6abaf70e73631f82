"""Pictures of clouds and surfaces in numpy alone: every triangle is sampled, the nearest sample of a pixel is shaded."""
import numpy as np

CLAY = np.array([0.86, 0.73, 0.58])
INK = np.array([0.13, 0.25, 0.45])


def look_from(azimuth, elevation):
    """Rotation for a viewer at the given angles in degrees; rows: right, up, towards the viewer."""
    a, e = np.radians([azimuth, elevation])
    towards = np.array([np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)])
    right = np.array([np.cos(a), 0, -np.sin(a)])
    return np.array([right, np.cross(towards, right), towards])


class Frame:
    """Maps points to pixels so that a cloud fills the picture."""

    def __init__(self, points, view, size):
        self.view, self.size = view, size
        turned = points @ view.T
        low, high = turned.min(axis=0), turned.max(axis=0)
        self.scale = 0.92 * size / max((high - low)[:2])
        self.centre = (low + high) / 2
        self.depth_range = high[2] - low[2]

    def __call__(self, points):
        """Pixels, and depth (larger: nearer)."""
        turned = points @ self.view.T - self.centre
        x = turned[:, 0] * self.scale + self.size / 2
        y = self.size / 2 - turned[:, 1] * self.scale
        return x, y, turned[:, 2]


def nearest_per_pixel(frame, x, y, depth):
    """Index of the nearest sample of each pixel, -1 where there is none."""
    size = frame.size
    column, row = x.astype(np.int32), y.astype(np.int32)
    inside = np.flatnonzero((x >= 0) & (y >= 0) & (column < size) & (row < size))
    key = (((depth.max() - depth[inside]) / max(np.ptp(depth), 1e-300) * (2**31 - 1)).astype(np.uint64) << np.uint64(32)) \
        | inside.astype(np.uint64)
    buffer = np.full(size * size, np.iinfo(np.uint64).max, dtype=np.uint64)
    np.minimum.at(buffer, row[inside] * size + column[inside], key)
    index = (buffer & np.uint64(0xFFFFFFFF)).astype(np.int64)
    index[buffer == np.iinfo(np.uint64).max] = -1
    return index.reshape(size, size)


def fill_pinholes(picture, depth):
    """Pixels that no sample of the front surface happened to hit get the mean of their nearer neighbours, if most are nearer.

    `depth` is -inf where nothing was hit."""
    size = len(depth)
    finite = depth[np.isfinite(depth)]
    step = 0.02 * np.ptp(finite) if len(finite) else 0
    wide, wide_depth = np.pad(picture, ((1, 1), (1, 1), (0, 0))), np.pad(depth, 1, constant_values=-np.inf)
    total, count = np.zeros_like(picture), np.zeros_like(depth)
    for i, j in [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]:
        nearer = wide_depth[i:i + size, j:j + size] > depth + step
        total += nearer[..., None] * wide[i:i + size, j:j + size]
        count += nearer
    holes = count >= 5
    picture[holes] = total[holes] / count[holes][:, None]
    return picture


def surface_picture(points, triangles, frame, samples_per_pixel=3):
    """Shaded, in supersampled pixels of `frame`."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    vertex_normals = np.zeros_like(points)
    for corner in range(3):
        for axis in range(3):
            vertex_normals[:, axis] += np.bincount(triangles[:, corner], normals[:, axis], len(points))
    vertex_normals /= np.maximum(np.linalg.norm(vertex_normals, axis=1), 1e-300)[:, None]

    area = np.linalg.norm(normals, axis=1) / 2 * frame.scale**2
    faces_viewer = normals @ frame.view[2] > 0
    count = np.where(faces_viewer, np.ceil(area * samples_per_pixel), 0).astype(int)
    face = np.repeat(np.arange(len(triangles)), count)
    random = np.random.default_rng(0)
    u, v = random.random((2, len(face)), dtype=np.float32)
    flip = u + v > 1
    u[flip], v[flip] = 1 - u[flip], 1 - v[flip]
    x, y, depth = frame(points)
    t = triangles[face]
    mix = [1 - u - v, u, v]
    x, y, depth = (sum(m * values[t[:, i]] for i, m in enumerate(mix)) for values in (x, y, depth))
    nearest = nearest_per_pixel(frame, x, y, depth)
    seen = nearest >= 0
    chosen = nearest[seen]
    normal = sum(mix[i][chosen, None] * vertex_normals[t[chosen, i]] for i in range(3))
    normal = normal @ frame.view.T
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]

    def lamp(direction, strength):
        direction = np.array(direction) / np.linalg.norm(direction)
        return strength * np.clip(normal @ direction, 0, 1)

    light = 0.15 + lamp([-0.5, 0.6, 0.7], 0.75) + lamp([0.8, -0.1, 0.4], 0.22)
    shine = lamp([-0.3, 0.45, 1.0], 1.0) ** 40 * 0.25
    picture = np.ones((frame.size, frame.size, 3))
    picture[seen] = np.clip(light[:, None] * CLAY + shine[:, None], 0, 1)
    depths = np.full(seen.shape, -np.inf)
    depths[seen] = depth[chosen]
    return fill_pinholes(picture, depths)


def cloud_picture(points, frame, radius):
    """Discs, the nearer the darker."""
    x, y, depth = frame(points)
    steps = np.arange(-radius, radius + 1)
    dx, dy = (offset.ravel() for offset in np.meshgrid(steps, steps))
    round_ = dx**2 + dy**2 <= radius**2 + 0.5
    dx, dy = dx[round_], dy[round_]
    samples = [values[:, None].repeat(len(dx), axis=1) for values in (x, y, depth)]
    nearest = nearest_per_pixel(frame, (samples[0] + dx).ravel(), (samples[1] + dy).ravel(), samples[2].ravel())
    picture = np.ones((frame.size, frame.size, 3))
    seen = nearest >= 0
    near = (samples[2].ravel()[nearest[seen]] / max(frame.depth_range, 1e-300) + 0.5).clip(0, 1)[:, None]
    picture[seen] = near * INK + (1 - near) * (0.8 + 0.2 * INK)
    return picture


def half_size(picture):
    """Averages 2 x 2 pixels."""
    h, w = picture.shape[0] // 2, picture.shape[1] // 2
    return picture[:2 * h, :2 * w].reshape(h, 2, w, 2, 3).mean(axis=(1, 3))
