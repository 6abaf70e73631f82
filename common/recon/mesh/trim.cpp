#include <recon/mesh/trim.h>

#include <recon/disjoint_sets.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/level_sheet.h>
#include <recon/mesh/mismatch.h>
#include <recon/parallel.h>
#include <recon/scan/line_spacing.h>
#include <recon/search/block_search.h>
#include <recon/search/nearest_samples.h>
#include <recon/search/neighbours.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

using Corners = std::array<int, 3>;

/// A bare part is a hole if it reaches as far as this from all samples [spacings].
constexpr double hole_beyond = 3;
/// Samples around a place [count], and the share of them that have its spacing or less.
constexpr int samples_around = 80;
constexpr double common_share = 0.9;
/// Islands of fewer triangles than a sample and those around it have are dropped [count].
constexpr int smallest_island = 24;

/// Triangles at each vertex.
struct Stars
{
    std::vector<int> first, triangle; ///< Of vertex v: triangle[first[v]..first[v + 1]).

    explicit Stars(const TriangleMesh& mesh) : first(mesh.vertices.size() + 1, 0), triangle(3 * mesh.triangles.size())
    {
        for (const Corners& t : mesh.triangles)
            for (const int v : t)
                ++first[v + 1];
        for (std::size_t v = 1; v < first.size(); ++v)
            first[v] += first[v - 1];
        std::vector<int> next(first.begin(), first.end() - 1);
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            for (const int v : mesh.triangles[i])
                triangle[next[v]++] = int(i);
    }
};

/// Triangles at the vertex in fans by shared sides, the largest first; of equal ones that with the lowest triangle.
std::vector<std::vector<int>> list_fans(int vertex, const TriangleMesh& mesh, const Stars& stars,
                                        const std::vector<char>& keep)
{
    std::vector<int> members;
    for (int k = stars.first[vertex]; k < stars.first[vertex + 1]; ++k)
        if (keep[stars.triangle[k]])
            members.push_back(stars.triangle[k]);
    DisjointSets sets(members.size());
    std::map<int, int> across; // other end of a side -> the member seen with it
    for (std::size_t i = 0; i < members.size(); ++i)
        for (const int other : mesh.triangles[members[i]])
            if (other != vertex)
                if (const auto [seen, is_new] = across.emplace(other, int(i)); !is_new)
                    sets.join(seen->second, int(i));
    std::map<int, std::vector<int>> by_root;
    for (std::size_t i = 0; i < members.size(); ++i)
        by_root[sets.find(int(i))].push_back(members[i]);
    std::vector<std::vector<int>> fans;
    for (auto& [root, fan] : by_root)
        fans.push_back(std::move(fan));
    std::sort(fans.begin(), fans.end(),
              [](const auto& a, const auto& b)
              { return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front(); });
    return fans;
}

/// Drops all but the largest fan at each vertex, until each has one.
void leave_single_fans(const TriangleMesh& mesh, std::vector<char>& keep)
{
    const Stars stars(mesh);
    std::vector<int> dropped;
    for (std::size_t i = 0; i < keep.size(); ++i)
        if (!keep[i])
            dropped.push_back(int(i));
    while (!dropped.empty())
    {
        std::vector<int> rim;
        for (const int i : dropped)
            rim.insert(rim.end(), mesh.triangles[i].begin(), mesh.triangles[i].end());
        std::sort(rim.begin(), rim.end());
        rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
        dropped.clear();
        for (const int v : rim)
        {
            const std::vector<std::vector<int>> fans = list_fans(v, mesh, stars, keep);
            for (std::size_t f = 1; f < fans.size(); ++f)
                for (const int i : fans[f])
                {
                    keep[i] = 0;
                    dropped.push_back(i);
                }
        }
    }
}

Point centre_of(const TriangleMesh& mesh, const Corners& t)
{
    return (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
}

void turn(TriangleMesh& mesh, int triangle)
{
    std::swap(mesh.triangles[triangle][1], mesh.triangles[triangle][2]);
    if (!mesh.faux_edges.empty())
    {
        std::uint8_t& faux = mesh.faux_edges[triangle]; // the first and the third side change places
        faux = std::uint8_t((faux & 2) | ((faux & 1) << 2) | ((faux & 4) >> 2));
    }
}

/// Whether most of a part turns its back to who saw it. \param normals times areas.
bool faces_away(const Viewpoints& viewpoints, const Points& centres, const Vectors& normals)
{
    double facing = 0;
    for (std::size_t i = 0; i < centres.size(); ++i)
        facing += normals[i].dot((viewpoints.of(centres[i]) - centres[i]).normalized());
    return facing < 0;
}

/// Turns parts so that they face who saw them, or up, if they are open level sheets.
void turn_parts(TriangleMesh& mesh, const Viewpoints& viewpoints)
{
    const MeshComponents components = find_components(mesh);
    std::vector<std::vector<int>> members(std::size_t(components.count));
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        members[components.of_triangle[i]].push_back(int(i));
    for (const std::vector<int>& part : members)
    {
        Points centres;
        Vectors normals;
        for (const int i : part)
        {
            const Corners& t = mesh.triangles[i];
            const Point& a = mesh.vertices[t[0]];
            centres.push_back(centre_of(mesh, t));
            normals.push_back((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a));
        }
        if (viewpoints.empty() ? is_upside_down(centres, normals) : faces_away(viewpoints, centres, normals))
            for (const int i : part)
                turn(mesh, i);
    }
}

/// Drops triangles, and islands that are left. \returns for each vertex that is left its former index.
std::vector<int> drop(TriangleMesh& mesh, std::vector<char> keep, const Viewpoints& viewpoints)
{
    leave_single_fans(mesh, keep);
    const std::vector<int> former = keep_triangles(mesh, keep);
    const MeshComponents components = find_components(mesh);
    std::vector<int> count(std::size_t(components.count), 0);
    for (const int c : components.of_triangle)
        ++count[c];
    const int least = count.empty() ? 0 : std::min(smallest_island, *std::max_element(count.begin(), count.end()));
    keep.clear();
    for (const int c : components.of_triangle)
        keep.push_back(count[c] >= least);
    std::vector<int> result = keep_triangles(mesh, keep);
    turn_parts(mesh, viewpoints);
    for (int& v : result)
        v = former[v];
    return result;
}

/// Closes rims of few sides, but the longest of each part, by fans from one of their vertices: the front of a slab can
/// dip to its back, or through it, in a gap between samples.
void close_short_rims(TriangleMesh& mesh)
{
    constexpr std::size_t most_sides = 6;
    std::vector<std::vector<int>> rims = list_rims(mesh);
    const MeshComponents components = find_components(mesh);
    const std::vector<int>& part = components.of_vertex;
    std::vector<std::size_t> longest(std::size_t(components.count), 0);
    for (const std::vector<int>& rim : rims)
        longest[part[rim[0]]] = std::max(longest[part[rim[0]]], rim.size());
    const auto is_long = [&](const std::vector<int>& rim)
    { return rim.size() < 3 || rim.size() > most_sides || rim.size() == longest[part[rim[0]]]; };
    rims.erase(std::remove_if(rims.begin(), rims.end(), is_long), rims.end());
    std::vector<std::pair<int, int>> diagonals, taken;
    for (const std::vector<int>& rim : rims)
        for (std::size_t i = 2; i + 1 < rim.size(); ++i)
            diagonals.push_back(std::minmax(rim[0], rim[i]));
    std::sort(diagonals.begin(), diagonals.end());
    for (const Corners& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
            if (const std::pair<int, int> side = std::minmax(t[k], t[(k + 1) % 3]);
                std::binary_search(diagonals.begin(), diagonals.end(), side))
                taken.push_back(side);
    for (const std::vector<int>& rim : rims)
    {
        bool is_free = true;
        for (std::size_t i = 2; i + 1 < rim.size(); ++i)
            is_free = is_free && std::find(taken.begin(), taken.end(),
                                           std::pair<int, int>(std::minmax(rim[0], rim[i]))) == taken.end();
        for (std::size_t i = 1; is_free && i + 1 < rim.size(); ++i)
        {
            mesh.triangles.push_back({rim[0], rim[i + 1], rim[i]});
            if (!mesh.faux_edges.empty())
                mesh.faux_edges.push_back(0);
        }
    }
}

/// Distances from the samples, in spacings.
class Depths
{
public:
    Depths(const Points& samples, int backs, const Viewpoints& viewpoints, int threads, const Progress& progress)
        : samples_(samples), sample_search_(samples, threads), scanned_(samples.begin(), samples.end() - backs),
          search_(scanned_), spacing_(measure_line_spacing(scanned_, viewpoints, threads, progress)), threads_(threads)
    {
        parallel_for(scanned_.size(), threads, {},
                     [&](std::size_t i)
                     { spacing_[i] = std::max(spacing_[i], measure_spacing_at(scanned_[i], search_)); });
    }
    std::vector<double> at(const Points& places) const
    {
        const NearestSamples nearest = find_nearest_samples(places, samples_, sample_search_, threads_);
        std::vector<double> depths(places.size(), 0);
        parallel_for(places.size(), threads_, {},
                     [&](std::size_t i)
                     {
                         const double distance = std::sqrt(nearest.squared[i]);
                         if (std::size_t(nearest.sample[i]) >= spacing_.size())
                             depths[i] = std::numeric_limits<double>::infinity();
                         else if (distance > bare_beyond * spacing_[nearest.sample[i]])
                             depths[i] = distance / std::max(spacing_[nearest.sample[i]], measure_spacing(places[i]));
                     });
        return depths;
    }

private:
    /// That most samples around the place have or fall below.
    double measure_spacing(const Point& place) const
    {
        std::array<int, samples_around> around;
        std::array<double, samples_around> squared, spacings;
        const int found = search_.nearest(place, samples_around, around.data(), squared.data());
        for (int i = 0; i < found; ++i)
            spacings[i] = spacing_[around[i]];
        const auto at = spacings.begin() + int(common_share * (found - 1));
        std::nth_element(spacings.begin(), at, spacings.begin() + found);
        return *at;
    }

    const Points& samples_;
    BlockSearch sample_search_;
    Points scanned_;
    NeighbourSearch search_;
    std::vector<double> spacing_; ///< Per sample that was scanned.
    int threads_;
};

/// Per triangle the largest of what `measure` makes of its corners, the middles of its sides and its centre.
/// \param measure from points to as many numbers.
template <class Measure>
std::vector<double> find_largest(const TriangleMesh& mesh, const Progress& progress, const Measure& measure)
{
    constexpr std::size_t places_per_triangle = 7, chunk = 50'000; // places take more memory than the mesh
    const std::size_t triangles = mesh.triangles.size();
    std::vector<double> result(triangles, 0);
    for (std::size_t begin = 0; begin < triangles; begin += chunk)
    {
        progress.report(double(begin) / double(triangles));
        Points places;
        for (std::size_t i = begin; i < std::min(begin + chunk, triangles); ++i)
        {
            const Corners& t = mesh.triangles[i];
            const Point &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
            for (const Point& p :
                 {a, b, c, Point((a + b) / 2), Point((b + c) / 2), Point((c + a) / 2), centre_of(mesh, t)})
                places.push_back(p);
        }
        const std::vector<double> values = measure(places);
        for (std::size_t k = 0; k < values.size(); ++k)
        {
            double& largest = result[begin + k / places_per_triangle];
            largest = std::max(largest, values[k]);
        }
    }
    return result;
}

} // namespace

std::vector<int> trim_by_length(TriangleMesh& mesh, const Points& points, double length, int threads,
                                const Progress& progress, const Viewpoints& viewpoints)
{
    const BlockSearch search(points, threads);
    const std::vector<double> squared = find_largest(
        mesh, progress,
        [&](const Points& places) { return find_nearest_samples(places, points, search, threads).squared; });
    std::vector<char> keep;
    for (const double s : squared)
        keep.push_back(s <= length * length);
    return drop(mesh, std::move(keep), viewpoints);
}

std::vector<int> open_holes(TriangleMesh& mesh, const Points& samples, int backs, int threads, const Progress& progress,
                            const Viewpoints& viewpoints)
{
    const Depths depths(samples, backs, viewpoints, threads, progress.part(0, 0.2));
    const std::vector<double> deepest =
        find_largest(mesh, progress.part(0.2, 1), [&](const Points& places) { return depths.at(places); });
    // Bare triangles that share a corner are one part.
    DisjointSets parts(mesh.vertices.size());
    for (std::size_t i = 0; i < deepest.size(); ++i)
        if (deepest[i] > bare_beyond)
            for (const int v : mesh.triangles[i])
                parts.join(mesh.triangles[i][0], v);
    std::vector<char> is_hole(mesh.vertices.size(), 0), keep(mesh.triangles.size(), 1);
    for (std::size_t i = 0; i < deepest.size(); ++i)
        if (deepest[i] > hole_beyond)
            is_hole[parts.find(mesh.triangles[i][0])] = 1;
    for (std::size_t i = 0; i < deepest.size(); ++i)
        keep[i] = deepest[i] <= bare_beyond || !is_hole[parts.find(mesh.triangles[i][0])];
    if (std::count(keep.begin(), keep.end(), 1) == 0)
        keep.assign(keep.size(), 1);
    std::vector<int> former = drop(mesh, std::move(keep), viewpoints);
    if (backs > 0)
        close_short_rims(mesh);
    return former;
}

} // namespace recon
