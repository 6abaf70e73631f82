#include "crease_detection.h"

#include "sparse_set.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace recon::pn
{

namespace
{

struct Pair
{
    int i, j;
    double length;
};

/// Whether the planes of samples i and j, which meet at x, are two faces of an edge: both samples lie on the same side
/// of the other's plane, and no sample around x has a normal between the two, as where a surface just bends.
bool is_edge(const UsableSamples& usable, const BlockSearch& search, std::size_t i, std::size_t j, const Point& x)
{
    const Points& points = usable.samples.points;
    const Vectors& normals = usable.samples.normals;
    const Vector &a = normals[i], &b = normals[j];
    if ((points[i] - x).dot(b) * (points[j] - x).dot(a) <= 0)
        return false;
    constexpr int k = 12;
    constexpr double between = 0.75; // of the angle from one face to the other, seen from either
    const double least = std::cos(between * std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
    const double reach = 1.5 * std::max((points[i] - x).norm(), (points[j] - x).norm());
    int near[k];
    double squared[k];
    double first_reach = reach;
    const int found = search.nearest(x, k, near, squared, first_reach);
    return std::none_of(near, near + found,
                        [&](int m)
                        {
                            const Vector& n = normals[std::size_t(m)];
                            return (points[std::size_t(m)] - x).norm() < reach && n.dot(a) > least && n.dot(b) > least;
                        });
}

/// Adds one position with the normals of the samples around it.
void add(const UsableSamples& usable, const Point& x, std::initializer_list<int> around, AddedSamples& creases)
{
    for (int i : around)
    {
        creases.samples.points.push_back(x);
        creases.samples.normals.push_back(usable.samples.normals[std::size_t(i)]);
        // One's own side counts double.
        const auto other = std::find_if(around.begin(), around.end(), [i](int j) { return j != i; });
        creases.parents.push_back({i, i, *other});
    }
}

/// Adds corners, where the planes of three near samples meet. `pairs`: near samples on different faces, shortest first.
void add_corners(const UsableSamples& usable, const BlockSearch& search, const std::vector<Pair>& pairs,
                 SparseSet& taken, AddedSamples& creases)
{
    const Points& points = usable.samples.points;
    const Vectors& normals = usable.samples.normals;
    std::vector<std::vector<int>> across(points.size());
    for (const Pair& pair : pairs)
        across[std::size_t(pair.i)].push_back(pair.j);
    for (const Pair& pair : pairs)
    {
        const std::vector<int>& of_i = across[std::size_t(pair.i)];
        for (int k : across[std::size_t(pair.j)])
        {
            if (std::find(of_i.begin(), of_i.end(), k) == of_i.end())
                continue;
            const auto a = std::size_t(pair.i), b = std::size_t(pair.j), c = std::size_t(k);
            Eigen::Matrix3d planes;
            planes << normals[a].transpose(), normals[b].transpose(), normals[c].transpose();
            constexpr double least_volume = 0.3; // of the normals: else the three planes nearly share a line
            if (std::abs(planes.determinant()) < least_volume)
                continue;
            const Vector heights(0, normals[b].dot(points[b] - points[a]), normals[c].dot(points[c] - points[a]));
            const Point x = points[a] + planes.inverse() * heights;
            const double size = std::max((points[a] - points[c]).norm(), (points[b] - points[c]).norm());
            if ((x - (points[a] + points[b] + points[c]) / 3).norm() > size || taken.has_near(x))
                continue;
            if (!is_edge(usable, search, a, b, x) || !is_edge(usable, search, b, c, x) ||
                !is_edge(usable, search, a, c, x))
                continue;
            taken.add(x);
            add(usable, x, {pair.i, pair.j, k}, creases);
        }
    }
}

} // namespace

AddedSamples detect_creases(const UsableSamples& usable, const BlockSearch& search, double crease_angle)
{
    constexpr int k = 16;
    const double same = std::cos(crease_angle);
    const Points& points = usable.samples.points;
    const Vectors& normals = usable.samples.normals;
    std::vector<Pair> pairs;
    double spacing = 0;
    for (int i = 0; i < int(points.size()); ++i)
    {
        int nearest[k];
        double squared[k];
        const Point& farthest = points[std::size_t(usable.nearest.of(std::size_t(i))[usable.nearest.count - 1])];
        double reach = (farthest - points[std::size_t(i)]).norm();
        const int found = search.nearest(points[std::size_t(i)], k, nearest, squared, reach);
        spacing += found > 4 ? std::sqrt(squared[4]) : 0;
        for (int m = 0; m < found; ++m)
            if (const int j = nearest[m]; squared[m] > 0 && i < j && !usable.is_crease[std::size_t(i)] &&
                                          !usable.is_crease[std::size_t(j)] &&
                                          normals[std::size_t(i)].dot(normals[std::size_t(j)]) < same)
                pairs.push_back({i, j, std::sqrt(squared[m])});
    }
    spacing /= double(std::max<std::size_t>(points.size(), 1));
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.length < b.length; });

    AddedSamples creases;
    SparseSet taken(0.7 * spacing);
    for (std::size_t i = 0; i < points.size(); ++i)
        if (usable.is_crease[i])
            taken.add(points[i]);
    add_corners(usable, search, pairs, taken, creases);
    for (const Pair& pair : pairs)
    {
        const auto i = std::size_t(pair.i), j = std::size_t(pair.j);
        const Vector &a = normals[i], &b = normals[j];
        // The point of the planes' intersection that is nearest to the middle.
        const Point middle = 0.5 * (points[i] + points[j]);
        const double da = a.dot(points[i] - middle), db = b.dot(points[j] - middle), c = a.dot(b), d = 1 - c * c;
        if (d < 1e-6)
            continue;
        const Point x = middle + ((da - c * db) / d) * a + ((db - c * da) / d) * b;
        // Farther away the two belong to different sheets, not to two sides of one crease.
        if ((x - middle).norm() > pair.length || taken.has_near(x) || !is_edge(usable, search, i, j, x))
            continue;
        taken.add(x);
        add(usable, x, {pair.i, pair.j}, creases);
    }
    return creases;
}

} // namespace recon::pn
