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
void add_corners(const UsableSamples& usable, const std::vector<Pair>& pairs, SparseSet& taken, AddedSamples& creases)
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
            taken.add(x);
            add(usable, x, {pair.i, pair.j, k}, creases);
        }
    }
}

} // namespace

AddedSamples detect_creases(const UsableSamples& usable, const NeighbourSearch& search, double crease_angle)
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
        const int found = search.nearest(points[std::size_t(i)], k, nearest, squared);
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
    add_corners(usable, pairs, taken, creases);
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
        if ((x - middle).norm() > pair.length || taken.has_near(x))
            continue;
        taken.add(x);
        add(usable, x, {pair.i, pair.j}, creases);
    }
    return creases;
}

} // namespace recon::pn
