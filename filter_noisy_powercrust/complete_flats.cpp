#include "complete_flats.h"

#include <recon/neighbours.h>
#include <recon/scramble.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace recon
{
namespace
{

/// Distance of the new samples from each other: this share of the rim spacing next to a rim, and so much more per unit
/// of distance.
constexpr double share_of_rim_spacing = 0.7, growth = 0.15;

/// Where a new sample may go, and how far it keeps from others.
struct Candidate
{
    Point position;
    double radius;
};

class FaceFiller
{
public:
    FaceFiller(const Points& samples, const NeighbourSearch& search) : samples_(samples), search_(search) {}

    Points fill(const FlatFace& face)
    {
        rim_.clear();
        spacing_.clear();
        for (const int v : face.rim)
        {
            int indices[3];
            double squared[3];
            const int found = search_.nearest(samples_[v], 3, indices, squared);
            rim_.push_back(samples_[v]);
            spacing_.push_back(std::sqrt(squared[found - 1]));
        }
        const NeighbourSearch rim_search(rim_);
        rim_search_ = &rim_search;
        candidates_.clear();
        for (const auto& t : face.triangles)
            divide(samples_[t[0]], samples_[t[1]], samples_[t[2]], 0);
        return thin();
    }

private:
    /// Lists the centres of pieces as small as half the radius wanted there.
    void divide(const Point& a, const Point& b, const Point& c, int depth)
    {
        const double sides[3] = {(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()};
        const int longest = int(std::max_element(sides, sides + 3) - sides);
        const Point centre = (a + b + c) / 3;
        int nearest;
        double squared;
        rim_search_->nearest(centre, 1, &nearest, &squared);
        const double distance = std::sqrt(squared);
        const double radius = share_of_rim_spacing * spacing_[nearest] + growth * distance;
        if (sides[longest] <= 0.25 * radius * radius || depth > 24)
        {
            if (distance > 0.8 * radius)
                candidates_.push_back({centre, radius});
            return;
        }
        if (longest == 0)
            divide_at((a + b) / 2, a, b, c, depth);
        else if (longest == 1)
            divide_at((b + c) / 2, b, c, a, depth);
        else
            divide_at((c + a) / 2, c, a, b, depth);
    }
    void divide_at(const Point& middle, const Point& from, const Point& to, const Point& opposite, int depth)
    {
        divide(from, middle, opposite, depth + 1);
        divide(middle, to, opposite, depth + 1);
    }

    /// Greedy Poisson disks in a scrambled order; what an older sample is too near to is left out.
    Points thin() const
    {
        Points positions;
        std::vector<std::pair<std::uint64_t, int>> order;
        for (int i = 0; i < int(candidates_.size()); ++i)
        {
            positions.push_back(candidates_[i].position);
            order.emplace_back(scramble(std::uint64_t(i)), i);
        }
        std::sort(order.begin(), order.end());
        const NeighbourSearch among(positions);
        std::vector<char> is_taken(positions.size(), 0);
        std::vector<int> near;
        Points result;
        for (const auto& entry : order)
        {
            const Candidate& c = candidates_[entry.second];
            if (is_taken[entry.second] || (samples_[search_.nearest(c.position)] - c.position).norm() < 0.5 * c.radius)
                continue;
            among.within(c.position, c.radius, near);
            for (const int i : near)
                is_taken[i] = 1;
            result.push_back(c.position);
        }
        return result;
    }

    const Points& samples_;
    const NeighbourSearch& search_;
    Points rim_;
    std::vector<double> spacing_; ///< Per rim sample.
    const NeighbourSearch* rim_search_ = nullptr;
    std::vector<Candidate> candidates_;
};

/// Cosine of the steepest slant of a wall against the normals of the faces that it joins.
const double straight = std::cos(15 * 3.14159265358979323846 / 180);

/// Where a wall may start: a rim sample of a flat face.
struct WallFoot
{
    int sample, face;
    int top = -1; ///< Position of the nearest foot of another face straight above or below.
};

/// Samples on walls that rise straight from the rim of one face to the rim of another: extruded shapes and bores carry
/// samples at both ends only.
Points fill_walls(const Points& samples, const NeighbourSearch& search, const std::vector<FlatFace>& faces,
                  std::vector<std::array<int, 2>>& ends)
{
    std::vector<WallFoot> feet;
    for (int f = 0; f < int(faces.size()); ++f)
        for (const int v : faces[f].rim)
            feet.push_back({v, f});
    for (WallFoot& foot : feet)
    {
        double least = 1e300;
        for (int j = 0; j < int(feet.size()); ++j)
        {
            if (feet[j].face == foot.face)
                continue;
            const Vector offset = samples[feet[j].sample] - samples[foot.sample];
            const double squared = offset.squaredNorm();
            if (squared < least && squared > 0 &&
                std::abs(offset.dot(faces[foot.face].normal)) > straight * std::sqrt(squared) &&
                std::abs(offset.dot(faces[feet[j].face].normal)) > straight * std::sqrt(squared))
            {
                least = squared;
                foot.top = j;
            }
        }
    }
    Points result;
    for (int i = 0; i < int(feet.size()); ++i)
    {
        const int j = feet[i].top;
        if (j < i || feet[j].top != i)
            continue;
        const Point &a = samples[feet[i].sample], &b = samples[feet[j].sample];
        double spacing = 1e300;
        for (const Point& p : {a, b})
        {
            int indices[3];
            double squared[3];
            const int found = search.nearest(p, 3, indices, squared);
            spacing = std::min(spacing, std::sqrt(squared[found - 1]));
        }
        const int pieces = int(std::ceil((b - a).norm() / spacing));
        for (int k = 1; k < pieces; ++k)
        {
            const Point p = a + (b - a) * (double(k) / pieces);
            if ((samples[search.nearest(p)] - p).norm() < 0.5 * spacing)
                continue;
            result.push_back(p);
            ends.push_back({feet[i].sample, feet[j].sample});
        }
    }
    return result;
}

} // namespace

FlatCompletion complete_flats(const Points& samples, const Vectors& normals, const FlatFaceOptions& options,
                              const Progress& progress)
{
    FlatCompletion result;
    const std::vector<FlatFace> faces = find_flat_faces(samples, options, progress.part(0, 0.8, "flat faces"));
    if (faces.empty())
        return result;
    const NeighbourSearch search(samples);
    FaceFiller filler(samples, search);
    for (const FlatFace& face : faces)
    {
        Vector normal = face.normal;
        if (!normals.empty())
        {
            double along = 0;
            for (const int v : face.rim)
                along += normals[v].dot(face.normal);
            if (along < 0)
                normal = -normal;
        }
        const Points added = filler.fill(face);
        result.points.insert(result.points.end(), added.begin(), added.end());
        if (!normals.empty())
            result.normals.insert(result.normals.end(), added.size(), normal);
        ++result.faces;
    }
    if (faces.size() > 1)
    {
        std::vector<std::array<int, 2>> ends;
        const Points added = fill_walls(samples, search, faces, ends);
        result.points.insert(result.points.end(), added.begin(), added.end());
        if (!normals.empty())
            for (std::size_t k = 0; k < added.size(); ++k)
            {
                const Vector along = (samples[ends[k][1]] - samples[ends[k][0]]).normalized();
                const Vector sum = normals[ends[k][0]] + normals[ends[k][1]];
                result.normals.push_back((sum - sum.dot(along) * along).normalized());
            }
    }
    return result;
}

} // namespace recon
