#include "turn_patches.h"

#include "label_balls.h"

#include <recon/disjoint_sets.h>
#include <recon/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <tuple>
#include <utility>

namespace recon
{
namespace
{

/// Neighbours are nearer than this [spacings], and lie in one plane where their normals' cosine and the sines of the
/// edge with both planes say so.
constexpr double near_by = 3, parallel = 0.8, in_plane = 0.3;
/// Fewer points are settled by their neighbours' votes [count].
constexpr int least_patch = 20;
/// Share of the neighbours across a patch's bounds that are across seams: 0.65 and more of sheets that bend back, 0.87
/// and more of a wavy sheet that passes for a ground, up to 0.85 of what does stand on one.
constexpr double seam_share = 0.5, seam_share_on_ground = 0.87;
/// Most of a patch's points that a seam may touch, as a share of them and in multiples of their root: up to 4.3 roots
/// all around a compact patch; of the two sides of a thin wall all points touch.
constexpr double most_at_seam = 0.75, longest_seam = 7;

using Edge = std::array<int, 2>;

void sort_out_twins(std::vector<Edge>& edges)
{
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
}

/// Edges of a cell between points that are near each other.
template <class Visit>
void visit_near_edges(const Triangulation& t, std::size_t cell, const Points& points,
                      const std::vector<double>& spacing, const Visit& visit)
{
    const auto& v = t.cells[cell].vertices;
    for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j)
        {
            const int a = std::min(v[i], v[j]), b = std::max(v[i], v[j]);
            const double reach = near_by / 2;
            if (b < int(points.size()) && (points[b] - points[a]).norm() < reach * (spacing[a] + spacing[b]))
                visit(Edge{a, b});
        }
}

bool lie_in_one_plane(const Edge& edge, const Points& points, const Vectors& normals)
{
    const auto& [a, b] = edge;
    const Vector along = points[b] - points[a];
    return std::abs(normals[a].dot(normals[b])) > parallel &&
           std::max(std::abs(normals[a].dot(along)), std::abs(normals[b].dot(along))) < in_plane * along.norm();
}

/// Patches, those of least_patch points and more numbered in the order of their first points.
struct Patches
{
    std::vector<int> of_point; ///< -1 where a patch is too small.
    std::vector<int> size;     ///< Per patch [count].
    std::vector<int> leaving;  ///< Per patch: edges to points that are not of it [count].
    std::vector<Edge> across;  ///< Between points that lie in one plane and disagree.
};

/// Bounds are looked at only if there are two patches or more.
Patches find_patches(const Triangulation& t, const Points& points, const std::vector<double>& spacing,
                     const Vectors& normals, int threads)
{
    const std::size_t cells = std::size_t(t.finite_cells);
    constexpr std::size_t grain = 8192;
    DisjointSets sets(points.size());
    const auto agree = [&](const Edge& edge) { return normals[edge[0]].dot(normals[edge[1]]) > 0; };
    const auto join = [&](const Edge& edge)
    {
        if (agree(edge) && lie_in_one_plane(edge, points, normals))
            sets.join(edge[0], edge[1]);
    };
    parallel_for(
        cells, threads, {}, [&](std::size_t c) { visit_near_edges(t, c, points, spacing, join); }, grain);
    std::vector<int> size(points.size(), 0), number(points.size(), -1);
    for (int v = 0; v < int(points.size()); ++v)
        ++size[sets.find(v)];
    Patches patches;
    patches.of_point.resize(points.size());
    for (int v = 0; v < int(points.size()); ++v)
    {
        const int set = sets.find(v);
        if (number[set] < 0 && size[set] >= least_patch)
        {
            number[set] = int(patches.size.size());
            patches.size.push_back(size[set]);
        }
        patches.of_point[v] = number[set];
    }
    if (patches.size.size() < 2)
        return patches;
    std::vector<Edge> bounds = parallel_collect<Edge>(
        cells, threads, {},
        [&](std::size_t c, std::vector<Edge>& found)
        {
            visit_near_edges(t, c, points, spacing,
                             [&](const Edge& edge)
                             {
                                 if (sets.find(edge[0]) != sets.find(edge[1]))
                                     found.push_back(edge);
                             });
        },
        grain);
    sort_out_twins(bounds);
    patches.leaving.assign(patches.size.size(), 0);
    for (const Edge& edge : bounds)
    {
        for (const int v : edge)
            if (patches.of_point[v] >= 0)
                ++patches.leaving[patches.of_point[v]];
        if (!agree(edge) && lie_in_one_plane(edge, points, normals))
            patches.across.push_back(edge);
    }
    return patches;
}

/// Between patches that a seam joins, as heavy as it is long.
std::vector<Tie> list_seams(const Patches& patches, double least_share)
{
    struct Crossing
    {
        int smaller, larger; ///< Patches.
        int end;             ///< In the smaller one.
    };
    std::vector<Crossing> crossings;
    std::vector<int> across_seams(patches.size.size(), 0);
    for (const auto& [a, b] : patches.across)
    {
        const int p = patches.of_point[a], q = patches.of_point[b];
        if (p < 0 || q < 0 || p == q)
            continue;
        ++across_seams[p];
        ++across_seams[q];
        const bool is_first_smaller = std::pair(patches.size[p], p) < std::pair(patches.size[q], q);
        crossings.push_back(is_first_smaller ? Crossing{p, q, a} : Crossing{q, p, b});
    }
    std::sort(crossings.begin(), crossings.end(),
              [](const Crossing& x, const Crossing& y)
              { return std::tuple(x.smaller, x.larger, x.end) < std::tuple(y.smaller, y.larger, y.end); });
    std::vector<Tie> seams;
    for (std::size_t begin = 0, end; begin < crossings.size(); begin = end)
    {
        const Crossing& first = crossings[begin];
        int at_seam = 0;
        for (end = begin;
             end < crossings.size() && crossings[end].smaller == first.smaller && crossings[end].larger == first.larger;
             ++end)
            at_seam += end == begin || crossings[end].end != crossings[end - 1].end;
        const double size = patches.size[first.smaller];
        if (across_seams[first.smaller] >= least_share * patches.leaving[first.smaller] &&
            at_seam <= std::min(most_at_seam * size, longest_seam * std::sqrt(size)))
            seams.push_back({first.smaller, first.larger, float(end - begin), true});
    }
    return seams;
}

/// Of the patches that seams join the largest, one of each lot.
std::vector<int> choose_fixed(const Patches& patches, const std::vector<Tie>& seams)
{
    DisjointSets lots(patches.size.size());
    for (const Tie& seam : seams)
        lots.join(seam.a, seam.b);
    std::vector<int> largest(patches.size.size(), -1), fixed;
    for (int p = 0; p < int(patches.size.size()); ++p)
        if (int& best = largest[lots.find(p)]; best < 0 || patches.size[p] > patches.size[best])
            best = p;
    std::copy_if(largest.begin(), largest.end(), std::back_inserter(fixed), [](int p) { return p >= 0; });
    return fixed;
}

} // namespace

double turn_patches(const Triangulation& delaunay, const Points& points, const std::vector<double>& spacing,
                    bool has_ground, Vectors& normals, int threads)
{
    const Patches patches = find_patches(delaunay, points, spacing, normals, threads);
    std::vector<Tie> ties = list_seams(patches, has_ground ? seam_share_on_ground : seam_share);
    if (ties.empty())
        return 0;
    const int outside = int(patches.size.size());
    for (const int p : choose_fixed(patches, ties))
        ties.push_back({p, outside, float(patches.across.size()), false});
    const BallLabels labels = label_balls(outside, ties, threads);
    int turned = 0;
    for (std::size_t v = 0; v < points.size(); ++v)
        if (const int p = patches.of_point[v]; p >= 0 && labels.side[p] < 0)
        {
            normals[v] = -normals[v];
            ++turned;
        }
    return double(turned) / double(points.size());
}

} // namespace recon
