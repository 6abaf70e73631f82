#include "crease_detection.h"

#include "sparse_set.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace recon::pn
{

AddedSamples detect_creases(const UsableSamples& usable, const NeighbourSearch& search, double crease_angle)
{
    struct Pair
    {
        int i, j;
        double length;
    };
    constexpr int k = 9;
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
            if (const int j = nearest[m];
                squared[m] > 0 && i < j && normals[std::size_t(i)].dot(normals[std::size_t(j)]) < same)
                pairs.push_back({i, j, std::sqrt(squared[m])});
    }
    spacing /= double(std::max<std::size_t>(points.size(), 1));
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.length < b.length; });

    AddedSamples creases;
    SparseSet taken(0.7 * spacing);
    for (std::size_t i = 0; i < points.size(); ++i)
        if (usable.is_crease[i])
            taken.add(points[i]);
    for (const Pair& pair : pairs)
    {
        const auto i = std::size_t(pair.i), j = std::size_t(pair.j);
        const Vector &a = normals[i], &b = normals[j];
        // The point of the planes' intersection that is nearest to the middle.
        const Point middle = 0.5 * (points[i] + points[j]);
        const double da = a.dot(points[i] - middle), db = b.dot(points[j] - middle), c = a.dot(b), d = 1 - c * c;
        if (d < 1e-6 || usable.is_crease[i] || usable.is_crease[j])
            continue;
        const Point x = middle + ((da - c * db) / d) * a + ((db - c * da) / d) * b;
        // Farther away the two belong to different sheets, not to two sides of one crease.
        if ((x - middle).norm() > pair.length || taken.has_near(x))
            continue;
        taken.add(x);
        creases.samples.points.insert(creases.samples.points.end(), {x, x});
        creases.samples.normals.insert(creases.samples.normals.end(), {a, b});
        creases.parents.push_back({pair.i, pair.i, pair.j});
        creases.parents.push_back({pair.j, pair.j, pair.i});
    }
    return creases;
}

} // namespace recon::pn
