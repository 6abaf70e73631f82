#pragma once

#include "parameters.h"

#include <recon/geometry.h>
#include <recon/progress.h>

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace plugin
{

using Colour = std::array<std::uint8_t, 4>; ///< Red, green, blue, alpha.

/// The current layer as a filter sees it: all its vertices, in the layer's own coordinates. The layer's transform is
/// not applied; new layers get the same transform.
struct InputLayer
{
    std::string name;
    recon::Points points;
    recon::Vectors normals; ///< One per vertex, zero where the layer has none; any length.
    std::vector<char> selected;
    std::vector<Colour> colours; ///< Empty: the layer has none.
    std::vector<double> quality; ///< Empty: the layer has none.
    std::vector<double> radii; ///< Custom attribute "radius", else the radius component. Empty: the layer has neither.

    /// Another layer by its name, in this layer's coordinates.
    /// \throws InvalidInput if no layer, or more than one, has that name; the message lists the names.
    std::function<InputLayer(const std::string& name)> find_layer;
};

/// The layer's name for naming new layers after it. MeshLab's labels are often file names, whose ending (up to four
/// letters and digits) says nothing; "version 1.5" stays whole.
std::string name_without_ending(const InputLayer& layer);

/// Vertices that a filter works on: all, or the selected ones.
/// \throws InvalidInput if the layer has no vertices, none is selected, or one of them is not finite.
std::vector<int> vertices_to_use(const InputLayer& layer, bool selected_only);

template <class T>
std::vector<T> pick(const std::vector<T>& values, const std::vector<int>& indices)
{
    std::vector<T> picked;
    picked.reserve(indices.size());
    for (int i : indices)
        picked.push_back(values[i]);
    return picked;
}

/// Points and unit normals of the given vertices.
/// \throws InvalidInput if one has no normal, or one that is not finite, naming a filter that computes them.
recon::OrientedSamples oriented_samples(const InputLayer& layer, const std::vector<int>& vertices);

/// A layer that the filter makes. What is empty is not written: vertex normals then come from the faces.
struct NewLayer
{
    std::string name;
    recon::TriangleMesh mesh;              ///< Without triangles: a point cloud.
    std::vector<std::array<int, 2>> edges; ///< That belong to no triangle, such as those of a medial axis.
    std::vector<int>
        source; ///< Per vertex of `mesh`: the input's vertex whose colour and quality it takes, -1 for none.
    recon::Vectors normals;
    std::vector<Colour> colours; ///< Instead of the sources'.
    std::vector<double> quality; ///< Instead of the sources'.
    std::vector<double> radii;
};

/// Changes of the current layer's vertices, in place. What is empty stays as it is; the rest has one entry per vertex
/// in `vertices`.
struct ChangedVertices
{
    std::vector<int> vertices;
    recon::Points points;
    recon::Vectors normals;
    std::vector<Colour> colours;
    std::vector<double> quality;
    std::vector<double> radii;
    std::vector<char> selected;
};

/// Vertices appended to the current layer.
struct AppendedVertices
{
    recon::Points points;
    recon::Vectors normals;
    std::vector<int> source; ///< As in NewLayer.
    std::vector<Colour> colours;
    std::vector<double> quality;
    std::vector<double> radii;
    bool selected = false;
};

using ResultValue = std::variant<int, double, bool>;

/// All that a filter does. It is written to the document after the filter has returned: whatever it throws, the
/// document is as it was.
struct FilterResult
{
    std::vector<NewLayer> new_layers;
    ChangedVertices changed;
    AppendedVertices appended;
    std::vector<int> removed; ///< Vertices of the current layer that are deleted, with their faces, after all changes.
    std::vector<std::pair<std::string, ResultValue>> values; ///< pymeshlab's dictionary; other hosts log them.
    std::vector<std::string> log;
    std::vector<std::string> warnings;
};

/// What a filter does to the document, or-ed together: `Effect::makes_layer | ...`.
struct Effect
{
    enum : unsigned
    {
        makes_layer = 1,
        moves_vertices = 2,
        changes_normals = 4,
        changes_colours = 8,
        changes_quality = 16,
        changes_selection = 32,
        changes_radii = 64,
        appends_vertices = 128,
        removes_vertices = 256
    };
};

/// MeshLab's classes of filters (sub-menus), or-ed together; the values are MeshLab's.
struct Category
{
    enum : unsigned
    {
        selection = 0x00001,
        cleaning = 0x00002,
        remeshing = 0x00004,
        smoothing = 0x00080,
        quality = 0x00100,
        normal = 0x00800,
        sampling = 0x01000,
        point_set = 0x08000
    };
};

/// A filter is data.
struct FilterSpec
{
    std::string name;        ///< In menus and .mlx scripts. Never renamed once released, as python_name.
    std::string python_name; ///< In pymeshlab.
    std::string info;        ///< HTML: what it does, when to use it, and what it was made from.
    unsigned category = 0;   ///< Of Category; not 0.
    unsigned effects = 0;    ///< Of Effect; not 0.
    std::function<std::vector<ParameterDeclaration>()> parameters;
    std::function<FilterResult(const InputLayer&, const ParameterValues&, const recon::Progress&)> run;

    /// Sets `parameters` and `run`. `filter` computes from the layer's data and the options; it may throw.
    template <class Options>
    void compute_with(ParameterTable<Options> table,
                      FilterResult (*filter)(const InputLayer&, const Options&, const recon::Progress&))
    {
        parameters = [table] { return table.declare(); };
        run = [table, filter](const InputLayer& layer, const ParameterValues& values, const recon::Progress& progress)
        { return filter(layer, table.read(values), progress); };
    }
};

struct PluginSpec
{
    std::string name; ///< MeshLab lists the plugin under it.
    std::vector<FilterSpec> filters;
};

/// Defined once in each plugin, in its plugin.cpp.
PluginSpec describe_plugin();

/// The message for the user of the exception that is being handled.
std::string message_of_current_exception();

/// Key of a phase's seconds among the result values: "polar balls" becomes "seconds_polar_balls".
std::string key_of_seconds(const std::string& phase);

/// Adds the seconds of each phase to the result values, under those keys.
void append_seconds(FilterResult& result, const std::vector<std::pair<std::string, double>>& seconds_of_phases);

/// "points_used: 1234" and so on, for hosts that cannot return values.
std::string describe_value(const std::pair<std::string, ResultValue>& value);

} // namespace plugin
