"""The filters as released: names, parameters, defaults and choices, on which scripts rely. They never change (test_filters_page.py).

A list is not made from the plugin, since tests must notice when the plugin changes.
"""
from dataclasses import dataclass


@dataclass
class FilterSpec:
    plugin: str
    name: str
    python_name: str
    parameters: list  # (name, MeshLab's type in .mlx, default, texts of a choice)


NOISY_POWER_CRUST = FilterSpec(
    "libfilter_noisy_powercrust.so",
    "Surface Reconstruction: Noisy Power Crust",
    "generate_surface_reconstruction_noisy_power_crust",
    [("open_holes", "RichBool", False, None),
     ("ball_threshold", "RichAbsPerc", 0.0, None),
     ("noise", "RichAbsPerc", 0.0, None),
     ("deep_intersection", "RichFloat", 0.0, None),
     ("keep_components", "RichEnum", "automatic", ["largest", "all", "automatic"]),
     ("denoise", "RichEnum", "automatic", ["automatic", "on", "off"]),
     ("smooth", "RichBool", True, None),
     ("simplify", "RichBool", True, None),
     ("trim_length", "RichAbsPerc", 0.0, None),
     ("selected_only", "RichBool", False, None),
     ("threads", "RichInt", 0, None)])

MEDIAL_AXIS = FilterSpec(
    "libfilter_noisy_powercrust.so",
    "Medial Axis: Power Shape",
    "generate_medial_axis_power_shape",
    [("side", "RichEnum", "inner", ["inner", "outer", "both"]),
     ("ball_threshold", "RichAbsPerc", 0.0, None),
     ("object_angle", "RichFloat", 75.0, None),
     ("redundancy", "RichFloat", 0.0, None),
     ("denoise", "RichEnum", "automatic", ["automatic", "on", "off"]),
     ("noise", "RichAbsPerc", 0.0, None),
     ("selected_only", "RichBool", False, None),
     ("threads", "RichInt", 0, None)])

BALLS = [("method", "RichEnum", "automatic", ["automatic", "paper"]),
         ("big_ball_ratio", "RichFloat", 0.0, None),
         ("neighbours", "RichInt", 0, None),
         ("selected_only", "RichBool", False, None),
         ("threads", "RichInt", 0, None)]
NORMALS = FilterSpec("libfilter_amls.so", "Compute normals from Delaunay balls", "compute_normal_from_delaunay_balls", BALLS)
FEATURE_SIZE = FilterSpec("libfilter_amls.so", "Compute local feature size", "compute_scalar_by_local_feature_size",
                          BALLS + [("smoothing", "RichInt", 0, None), ("colorize", "RichBool", False, None)])
PROJECTION = FilterSpec(
    "libfilter_amls.so", "MLS projection (AMLS)", "compute_mls_projection_amls",
    [("rho_e", "RichFloat", 0.0, None),
     ("noise", "RichAbsPerc", 0.0, None),
     ("normals", "RichEnum", "estimate", ["estimate", "use the layer's"]),
     ("weights", "RichEnum", "anchors with curvature",
      ["anchors with curvature", "paper's normalised I", "paper's plain N"]),
     ("max_iterations", "RichInt", 0, None),
     ("tolerance", "RichFloat", 0.1, None),
     ("cut_off", "RichFloat", 0.0, None),
     ("remove_outliers", "RichBool", False, None),
     ("select_not_converged", "RichBool", False, None),
     ("surface_layer", "RichString", "", None),
     ("selected_only", "RichBool", False, None),
     ("threads", "RichInt", 0, None)])

AMLS_RECONSTRUCTION = FilterSpec(
    "libfilter_amls.so",
    "Surface Reconstruction: AMLS",
    "generate_surface_reconstruction_amls",
    [("open_holes", "RichBool", False, None),
     ("rho_e", "RichFloat", 0.0, None),
     ("noise", "RichAbsPerc", 0.0, None),
     ("keep_components", "RichEnum", "automatic", ["largest", "all", "automatic"]),
     ("simplify", "RichBool", True, None),
     ("selected_only", "RichBool", False, None),
     ("threads", "RichInt", 0, None)])

PN_REFINEMENT = FilterSpec(
    "libfilter_pn_refine.so", "Point Cloud Refinement: PN Triangles", "meshing_point_cloud_refinement_pn",
    [("steps", "RichInt", 3, None),
     ("target_radius", "RichAbsPerc", 0.0, None),
     ("neighbourhood", "RichEnum", "automatic", ["automatic", "fast fuzzy BSP", "accurate geodesic"]),
     ("fast", "RichBool", False, None),
     ("initial_radius", "RichAbsPerc", 0.0, None),
     ("hole_radius", "RichAbsPerc", 0.0, None),
     ("boundary_angle", "RichFloat", 150.0, None),
     ("crease_angle", "RichFloat", 45.0, None),
     ("detect_creases", "RichBool", True, None),
     ("preserve_boundaries", "RichBool", True, None),
     ("preserve_creases", "RichBool", True, None),
     ("repair_normals", "RichBool", True, None),
     ("max_points", "RichInt", 50000000, None),
     ("selected_only", "RichBool", False, None),
     ("into_new_layer", "RichBool", True, None),
     ("threads", "RichInt", 0, None)])

ALL = [NORMALS, FEATURE_SIZE, PROJECTION, AMLS_RECONSTRUCTION, NOISY_POWER_CRUST, MEDIAL_AXIS, PN_REFINEMENT]
