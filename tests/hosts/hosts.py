"""Runs a filter on a cloud in each host, behind one interface."""
import os
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import meshlab_2020

BUILD = Path(os.environ.get("POINT_SURFACES_BUILD", Path(__file__).parents[2] / "build"))


@dataclass
class Cloud:
    points: np.ndarray
    colours: np.ndarray = None  # n x 4, 0..255
    quality: np.ndarray = None
    selected: np.ndarray = None
    transform: np.ndarray = field(default_factory=lambda: np.eye(4))


@dataclass
class Surface:
    points: np.ndarray
    triangles: np.ndarray
    colours: np.ndarray = None
    quality: np.ndarray = None
    transform: np.ndarray = None
    faux_edges: np.ndarray = None


@dataclass
class Outcome:
    error: str = None       # the message in the host's own error channel
    unchanged: bool = None  # the document after an error
    surface: Surface = None
    values: dict = field(default_factory=dict)
    layers: int = None
    log: str = ""


@dataclass
class Length:
    """A value of a length parameter."""
    value: float
    per_cent: bool = False


def selecting_condition(selected):
    """For MeshLab's conditional selection."""
    ids = np.flatnonzero(selected)
    assert len(ids) == ids[-1] - ids[0] + 1, "only a run of vertices can be selected"
    return f"(vi >= {ids[0]}) && (vi <= {ids[-1]})"


def colours_of(cloud):
    return np.full((len(cloud.points), 4), 255) if cloud.colours is None else cloud.colours


# --- pymeshlab ------------------------------------------------------------------------------------------------------------

class PyMeshLab:
    name = "pymeshlab-2025.7"
    double = True

    def __init__(self, plugin):
        import pymeshlab
        self.pymeshlab = pymeshlab
        try:
            pymeshlab.load_plugin(str(BUILD / "plugins" / self.name / plugin))
        except pymeshlab.PyMeshLabException as problem:
            if "already" not in str(problem):
                raise

    def mesh_set(self, cloud, verbose=False):
        meshes = self.pymeshlab.MeshSet(verbose=verbose)
        if cloud is not None:
            attributes = {}
            if cloud.colours is not None:
                attributes["v_color_matrix"] = np.asarray(cloud.colours, float) / 255
            if cloud.quality is not None:
                attributes["v_scalar_array"] = np.asarray(cloud.quality, float)
            meshes.add_mesh(self.pymeshlab.Mesh(np.asarray(cloud.points, float).reshape(-1, 3), **attributes), "cloud")
            if not np.array_equal(cloud.transform, np.eye(4)):
                meshes.set_matrix(transformmatrix=cloud.transform, freeze=False)
            if cloud.selected is not None and np.any(cloud.selected):
                meshes.compute_selection_by_condition_per_vertex(condselect=selecting_condition(cloud.selected))
        return meshes

    def arguments(self, parameters):
        arguments = {}
        for name, value in parameters.items():
            if isinstance(value, Length):
                wrap = self.pymeshlab.PercentageValue if value.per_cent else self.pymeshlab.PureValue
                value = wrap(value.value)
            arguments[name] = value
        return arguments

    def run(self, filter_spec, cloud, parameters, folder):
        meshes = self.mesh_set(cloud)
        before = self.state(meshes)
        outcome = Outcome()
        try:
            outcome.values = meshes.apply_filter(filter_spec.python_name, **self.arguments(parameters))
        except self.pymeshlab.PyMeshLabException as problem:
            outcome.error = str(problem)
            outcome.unchanged = self.state(meshes) == before
            outcome.layers = meshes.mesh_number()
            return outcome
        mesh = meshes.current_mesh()
        outcome.layers = meshes.mesh_number()
        outcome.surface = Surface(
            mesh.vertex_matrix(), mesh.face_matrix(),
            np.rint(mesh.vertex_color_matrix() * 255) if mesh.has_vertex_color() else None,
            mesh.vertex_scalar_array() if mesh.has_vertex_scalar() else None, mesh.transform_matrix())
        return outcome

    @staticmethod
    def state(meshes):
        """All that a filter could have changed."""
        state = [meshes.mesh_number()]
        for i in range(meshes.mesh_number()):
            mesh = meshes.mesh(i)
            state.append((meshes.current_mesh_id(), mesh.vertex_matrix().tobytes(), mesh.vertex_normal_matrix().tobytes(),
                          mesh.face_matrix().tobytes(), mesh.vertex_selection_array().tobytes(),
                          mesh.transform_matrix().tobytes(), mesh.has_vertex_color(), mesh.has_vertex_scalar()))
        return state


@dataclass
class Parameter:
    name: str
    kind: str  # MeshLab's type in .mlx
    default: str
    label: str
    tooltip: str
    choices: list


@dataclass
class Filter:
    name: str
    python_name: str
    parameters: list


def filters_of(plugin):
    """The filters of a plugin for MeshLab 2025.07, as its plugin manager sees them."""
    shown = subprocess.run([str(BUILD / "tests" / "hosts" / "plugin_manager_run"), str(plugin)], check=True, text=True,
                           env={**os.environ, "QT_QPA_PLATFORM": "offscreen"}, stdout=subprocess.PIPE).stdout
    filters = []
    for line in shown.splitlines():
        key, _, rest = line.partition(" ")
        words = rest.split("\t")
        if key == "filter":
            filters.append(Filter(*words, []))
        elif key == "parameter":
            filters[-1].parameters.append(Parameter(*words[:5], words[5:]))
    return filters


def all_filters():
    """Of all plugins."""
    return [f for plugin in sorted((BUILD / "plugins" / MeshLab2025.name).glob("*.so")) for f in filters_of(plugin)]


# --- MeshLab 2025.07, its own plugin manager ------------------------------------------------------------------------------

class MeshLab2025:
    name = "meshlab-2025.07"
    double = False

    def __init__(self, plugin):
        self.plugin = BUILD / "plugins" / self.name / plugin
        self.program = BUILD / "tests" / "hosts" / "plugin_manager_run"

    def run(self, filter_spec, cloud, parameters, folder, cancel=False):
        cloud_file = "-"
        if cloud is not None:
            n = len(cloud.points)
            vertices = np.zeros((n, 9))
            vertices[:, :3] = np.asarray(cloud.points, float).reshape(-1, 3)
            vertices[:, 3:7] = colours_of(cloud)
            if cloud.quality is not None:
                vertices[:, 7] = cloud.quality
            if cloud.selected is not None:
                vertices[:, 8] = cloud.selected
            header = [n, cloud.colours is not None, cloud.quality is not None, *np.asarray(cloud.transform).ravel()]
            cloud_file = Path(folder) / "cloud.raw"
            np.concatenate([np.array(header, float), vertices.ravel()]).tofile(cloud_file)
        surface_file = Path(folder) / "surface.raw"
        surface_file.unlink(missing_ok=True)
        arguments = ["cancel"] if cancel else []
        for name, value in parameters.items():
            if isinstance(value, Length):
                text = f"{float(value.value)!r}{'%' if value.per_cent else ''}"
            else:
                text = str(value).lower() if isinstance(value, bool) else str(value)
            arguments.append(f"{name}={text}")
        process = subprocess.run(
            [str(self.program), str(self.plugin), filter_spec.name, str(cloud_file), str(surface_file), *arguments],
            env={**os.environ, "QT_QPA_PLATFORM": "offscreen"}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            errors="replace", timeout=600)
        assert process.returncode == 0, f"exit code {process.returncode}: {process.stdout} {process.stderr}"
        outcome = Outcome(log=process.stdout)
        for line in process.stdout.splitlines():
            key, _, rest = line.partition(" ")
            if key == "value":
                name, kind, text = rest.split(" ", 2)
                outcome.values[name] = {"int": int, "double": float, "bool": lambda t: t == "true"}[kind](text)
            elif key == "error":
                outcome.error = rest
            elif key == "layers":
                outcome.layers = int(rest)
            elif key == "unchanged":
                outcome.unchanged = rest == "1"
        if outcome.error is None:
            outcome.surface = self.read(surface_file)
        return outcome

    @staticmethod
    def read(path):
        raw = np.fromfile(path)
        n, m, has_colours, has_quality = raw[:4].astype(int)
        vertices = raw[20:20 + 8 * n].reshape(n, 8)
        faces = raw[20 + 8 * n:].reshape(m, 4).astype(int)
        return Surface(vertices[:, :3], faces[:, :3], vertices[:, 3:7] if has_colours else None,
                       vertices[:, 7] if has_quality else None, raw[4:20].reshape(4, 4), faces[:, 3])


# --- meshlabserver 2020.09 ------------------------------------------------------------------------------------------------

def write_ply(path, cloud):
    """Binary PLY; coordinates as double, which MeshLab 2020 rounds to float itself."""
    columns = [("x", "f8"), ("y", "f8"), ("z", "f8")]
    if cloud.colours is not None:
        columns += [("red", "u1"), ("green", "u1"), ("blue", "u1"), ("alpha", "u1")]
    if cloud.quality is not None:
        columns += [("quality", "f4")]
    table = np.zeros(len(cloud.points), dtype=columns)
    points = np.asarray(cloud.points, float).reshape(-1, 3)
    for i, axis in enumerate("xyz"):
        table[axis] = points[:, i]
    if cloud.colours is not None:
        for i, channel in enumerate(("red", "green", "blue", "alpha")):
            table[channel] = np.asarray(cloud.colours)[:, i]
    if cloud.quality is not None:
        table["quality"] = cloud.quality
    names = {"f8": "double", "f4": "float", "u1": "uchar"}
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(table)}"]
    header += [f"property {names[kind]} {name}" for name, kind in columns]
    header += ["element face 0", "property list uchar int vertex_indices", "end_header"]
    Path(path).write_bytes(("\n".join(header) + "\n").encode() + table.tobytes())


def read_ply(path):
    """The binary PLY files that MeshLab writes."""
    data = Path(path).read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    kinds = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4", "uint": "<u4"}
    counts, columns, element = {}, {}, None
    for line in data[:end].decode().splitlines():
        words = line.split()
        if words[0] == "element":
            element = words[1]
            counts[element], columns[element] = int(words[2]), []
        elif words[0] == "property" and words[1] != "list":
            columns[element].append((words[2], kinds[words[1]]))
    table = np.frombuffer(data, dtype=columns["vertex"], count=counts["vertex"], offset=end)
    faces = np.frombuffer(data, dtype=[("n", "u1"), ("v", "<i4", 3)], count=counts.get("face", 0), offset=end + table.nbytes)
    assert np.all(faces["n"] == 3)
    points = np.column_stack([table[axis].astype(float) for axis in "xyz"])
    colours = np.column_stack([table[c].astype(float) for c in ("red", "green", "blue", "alpha")]) if "red" in table.dtype.names else None
    quality = table["quality"].astype(float) if "quality" in table.dtype.names else None
    return Surface(points, faces["v"].astype(int), colours, quality)


class MeshLabServer2020:
    name = "meshlab-2020.09"
    double = False

    def __init__(self, plugin, display):
        self.display = display
        self.programs = meshlab_2020.private_install(BUILD / "meshlab-2020", BUILD / "plugins" / self.name)

    def run(self, filter_spec, cloud, parameters, folder):
        folder = Path(folder)
        project = folder / "in.mlp"
        result = folder / "out.mlp"
        for old in folder.glob("out*"):
            old.unlink()
        filters = []
        arguments = []
        if cloud is not None:
            write_ply(folder / "cloud.ply", cloud)
            rows = "\n".join(" ".join(f"{x:.17g}" for x in row) + " " for row in np.asarray(cloud.transform))
            project.write_text('<!DOCTYPE MeshLabDocument>\n<MeshLabProject>\n <MeshGroup>\n  <MLMesh label="cloud" filename="cloud.ply" visible="1">\n'
                               f"   <MLMatrix44>\n{rows}\n</MLMatrix44>\n  </MLMesh>\n </MeshGroup>\n <RasterGroup/>\n</MeshLabProject>\n")
            arguments += ["-p", project.name]
            if cloud.selected is not None and np.any(cloud.selected):
                filters.append(("Conditional Vertex Selection",
                                [("condSelect", "RichString", selecting_condition(cloud.selected), {})]))
        filters.append((filter_spec.name, self.parameters(filter_spec, parameters, cloud)))
        (folder / "script.mlx").write_text(meshlab_2020.script(*filters))
        masks = ["-m", "vc", "vq"]
        arguments += ["-s", "script.mlx"]
        arguments += ["-w", result.name, "-o", "out.ply"]
        if cloud is not None and (cloud.colours is not None or cloud.quality is not None):
            arguments += masks
        code, text = meshlab_2020.run_server(self.programs, self.display, arguments, folder)
        outcome = Outcome(log=text, values=meshlab_2020.values_in_log(text))
        assert code >= 0, f"meshlabserver was ended by signal {-code}: {text}"
        if code != 0:
            # meshlabserver saves nothing after a filter has failed, so the document is what it was: the input files.
            outcome.error = text
            outcome.unchanged = not result.exists() and not (folder / "out.ply").exists()
            return outcome
        outcome.surface = read_ply(folder / "out.ply")
        document = result.read_text()
        outcome.layers = document.count("<MLMesh ")
        matrix = document.rsplit("<MLMatrix44>", 1)[1].split("</MLMatrix44>")[0]
        outcome.surface.transform = np.array(matrix.split(), float).reshape(4, 4)
        return outcome

    @staticmethod
    def parameters(filter_spec, parameters, cloud):
        """All parameters: meshlabserver ends on a script that leaves some out."""
        points = np.asarray(cloud.points, float).reshape(-1, 3) if cloud is not None else np.zeros((0, 3))
        finite = points[np.isfinite(points).all(axis=1)]
        diagonal = float(np.linalg.norm(np.ptp(finite, axis=0))) if len(finite) else 1.0
        lines = []
        for name, kind, default, choices in filter_spec.parameters:
            value = parameters.get(name, default)
            attributes = {}
            if kind == "RichAbsPerc":
                value = value if isinstance(value, Length) else Length(value)
                value = value.value / 100 * diagonal if value.per_cent else value.value
                attributes = {"min": 0, "max": f"{diagonal:.9g}"}
                value = f"{value:.9g}"
            elif kind == "RichEnum":
                attributes = {"enum_cardinality": len(choices), **{f"enum_val{i}": text for i, text in enumerate(choices)}}
                value = choices.index(value)
            elif kind == "RichBool":
                value = str(value).lower()
            lines.append((name, kind, value, attributes))
        return lines
