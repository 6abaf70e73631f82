"""FILTERS.md and the scripts in examples/: every filter with its parameters, as the plugins themselves declare them.

    POINT_SURFACES_BUILD=build python tests/hosts/filters_page.py      writes them

test_filters_page.py holds what is committed against the plugins, and the result values against what a run returns.
"""
import html
import re
from pathlib import Path

import hosts
import meshlab_2020

ROOT = Path(__file__).parents[2]

SCRIPTS = {
    "compute_normal_from_delaunay_balls": "delaunay_ball_normals",
    "compute_scalar_by_local_feature_size": "local_feature_size",
    "compute_mls_projection_amls": "amls_projection",
    "generate_surface_reconstruction_amls": "amls_reconstruction",
    "generate_surface_reconstruction_noisy_power_crust": "noisy_power_crust",
    "generate_medial_axis_power_shape": "medial_axis",
    "meshing_point_cloud_refinement_pn": "pn_refinement",
}

KINDS = {"RichAbsPerc": "length", "RichFloat": "number", "RichInt": "count", "RichBool": "flag", "RichEnum": "choice",
         "RichString": "text"}

NOISE = {"noise": "standard deviation of the noise, given or estimated; of surfaces less if that shows thin walls, more if scans are out of register (length)"}
SPACING = {"spacing": "median distance of neighbouring points (length)"}
COMPLETED = "of these, put on faces that had none: flat ones but for their rims, walls between rims, what lies between rounded edges"
SURFACE = {
    **NOISE, **SPACING,
    "width": "median width of the weights (length)",
    "rho_e": "the paper's parameter that this width amounts to",
    "cells": "cells into which the points were averaged",
    "anchors": "quadrics that make the surface",
    "open": "the cloud is an open sheet: normals are consistent across it, but \"outside\" has no meaning; of a level one it is above",
}
TOPOLOGY = {
    "components": "connected parts",
    "euler_characteristic": "vertices - edges + triangles",
    "genus": "handles, summed over the components",
    "violated_votes": "share of the samples' votes (this is inside, that is outside) that the surface contradicts; above 0.05 look at the result",
}
BIG_BALLS = {"points_with_big_ball": "method 'paper': points that have a big ball of their own"}
OUTLIERS = {"outliers": "points far from any surface"}
VALUES = {
    "compute_normal_from_delaunay_balls": {
        **SURFACE, **BIG_BALLS,
        "exact": "the points are free of noise, so that the crust goes through them",
        "normals_of_crust": "points whose normal is the crust's, as of thin walls and edges",
    },
    "compute_scalar_by_local_feature_size": {
        **SURFACE,
        "min_feature_size": "smallest value", "median_feature_size": "median value", "max_feature_size": "largest value",
        "poles": "centres of big Delaunay balls, which approximate the medial axis",
    },
    "compute_mls_projection_amls": {
        **SURFACE, **OUTLIERS,
        "points_projected": "points moved",
        "points_kept": "points not moved since the surface rounds off a detail, such as a sharp edge, in which samples agree",
        "points_too_far": "points not moved since the surface of the other layer is too far",
        "points_not_converged": "points whose last step was longer than the tolerance",
        "points_on_local_plane": "points for which Newton's method left the neighbourhood; they were put onto the local plane",
        "mean_iterations": "steps per point", "mean_neighbours": "neighbours per point and step",
    },
    "generate_surface_reconstruction_amls": {
        **NOISE, **SPACING, **OUTLIERS, **TOPOLOGY,
        "rho_e": SURFACE["rho_e"], "open": SURFACE["open"],
        "samples": "points that the mesh was made of: projected and thinned, or those of a clean cloud",
        "completed": COMPLETED,
        "vertices_on_surface": "vertices on the AMLS surface; the others close holes, or are points of a clean cloud",
        "boundary_loops": "rims, 0 unless opened",
    },
    "generate_surface_reconstruction_noisy_power_crust": {
        **NOISE, **TOPOLOGY, **OUTLIERS,
        "spacing": "median local spacing of the samples (length)",
        "points_used": "distinct input points", "denoised": "whether the points were projected and thinned first",
        "samples": "points that the crust was made of", "completed": COMPLETED,
        "edge_vertices": "vertices of the crust moved onto the two faces of a sharp edge",
        "smallest_ball": "radius of the smallest polar ball kept (length)", "balls_kept": "polar balls kept",
        "cleanness": "share of samples that look free of noise; below 0.7 the noise is looked at more closely",
        "boundary_loops": "rims, 0 unless opened or trimmed",
    },
    "generate_medial_axis_power_shape": {
        **NOISE,
        "spacing": "median local spacing of the samples (length)",
        "points_used": "distinct input points", "denoised": "whether the points were projected and thinned first",
        "poles": "vertices that are centres of polar balls",
        "edge_places": "vertices on sharp edges and at their corners, after the poles; radius 0",
        "triangles": "faces", "edges": "edges that belong to no triangle",
        "union_volume": "volume of the union of the inner balls; 0 for the outer side",
        "union_area": "its surface area", "largest_radius": "of the balls (length)",
        "violated_votes": TOPOLOGY["violated_votes"],
    },
    "meshing_point_cloud_refinement_pn": {
        "points_step_...": "points in all after step 1, 2 and so on", "new_points": "points added",
        "smallest_radius": "after the last step, at the start if there was none (length)",
        "median_radius": "likewise", "largest_radius": "likewise",
        "open_gaps": "points around which gaps stayed open: rims, holes",
        "boundary_segments": "segments of rims at the start", "crease_segments": "segments of creases at the start",
        "crease_points": "points put onto detected creases before the first step",
        "hole_points": "points put into holes before the first step",
        "void_points": "points put into voids between samples",
        "fold_points": "points put into folds that the samples show too sparsely",
        "turned_normals": "input points whose normal was turned",
        "left_out": "input points that took no part: duplicates, without normal, isolated",
        "new_points_per_second": "speed, with the time for normals and isolated points",
    },
}

HEAD = """# The filters, their parameters and result values

Written by `tests/hosts/filters_page.py` from what the plugins declare; a test keeps it so.

Lengths are in the layer's units, or per cent of the diagonal of its bounding box; 0 means what the parameter says. Coordinates and lengths are
those of the layer before its transform; new layers get the same transform. pymeshlab returns the result values as a dictionary, the other hosts
log them; `seconds_...` are wall-clock seconds per phase. If a filter fails or is cancelled, the document is as it was.

For `meshlabserver` a script must list every parameter but the first: there is one for each filter in [examples](examples), to be copied and changed.
`meshlabserver -i scan.ply -o result.ply -m vn vc vq vr -s <script>` also saves normals, colours, quality and radii; without `-m` it saves positions and faces alone.
The scripts run in MeshLab 2025.07 and in pymeshlab (`ms.load_filter_script(path)`, then `ms.apply_filter_script()`) as well.
"""


def text_of(tooltip):
    return html.unescape(re.sub(r"</?p>", "", tooltip))


def table(head, rows):
    lines = ["| " + " | ".join(row) + " |" for row in [head, *rows]]
    return "\n".join([lines[0], "|---" * len(head) + "|", *lines[1:]])


def section(f):
    rows = []
    for p in f.parameters:
        kind = ", ".join(f"`{text}`" for text in p.choices) or KINDS[p.kind]
        default = p.default if p.kind in ("RichAbsPerc", "RichFloat", "RichInt", "RichBool") else f"`{p.default}`" if p.default else "empty"
        rows.append([f"`{p.name}`", kind, default, text_of(p.tooltip)])
    values = [[f"`{name}`", meaning] for name, meaning in VALUES[f.python_name].items()]
    return (f"\n## {f.name}\n\n`{f.python_name}`, [examples/{SCRIPTS[f.python_name]}.mlx](examples/{SCRIPTS[f.python_name]}.mlx)\n\n"
            + table(["parameter", "kind", "default", "meaning"], rows) + "\n\n" + table(["result value", "meaning"], values) + "\n")


def page(filters):
    return HEAD + "".join(section(f) for f in filters)


def script(f):
    """A filter with the default of every parameter, for meshlabserver."""
    lines = []
    for p in f.parameters:
        value, attributes = p.default, {}
        if p.kind == "RichBool":
            value = "true" if p.default == "on" else "false"
        elif p.kind == "RichEnum":
            value = p.choices.index(p.default)
            attributes = {"enum_cardinality": len(p.choices), **{f"enum_val{i}": text for i, text in enumerate(p.choices)}}
        elif p.kind == "RichAbsPerc":
            attributes = {"min": 0, "max": 1}
        lines.append((p.name, p.kind, value, attributes))
    return meshlab_2020.script((f.name, lines))


def files():
    """Path and text of all that is written."""
    filters = hosts.all_filters()
    return {ROOT / "FILTERS.md": page(filters),
            **{ROOT / "examples" / f"{SCRIPTS[f.python_name]}.mlx": script(f) for f in filters}}


if __name__ == "__main__":
    for path, text in files().items():
        path.write_text(text)
