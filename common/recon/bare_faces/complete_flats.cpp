#include <recon/bare_faces/complete_flats.h>

#include <recon/bare_faces/rim_walls.h>
#include <recon/bare_faces/wall_samples.h>
#include <recon/parallel.h>
#include <recon/scramble.h>
#include <recon/search/keep_apart.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <deque>
#include <utility>

namespace recon
{
namespace
{

/// Distance of the new samples from each other: this share of the rim spacing next to a rim, and so much more per unit
/// of distance.
constexpr double share_of_rim_spacing = 0.7, growth = 0.15;
/// Pieces that a face is cut into to choose among, at most [per triangle; count]: else, as where triangles run along
/// rows of samples, it gets none. Up to 770 candidates per triangle of a helix were seen, and 220 of other faces.
constexpr std::size_t most_pieces_per_triangle = 4000, most_pieces = 8'000'000;

/// A face, and where its rim runs. Stays where it was made: `search` refers to `rim`.
struct RimmedFace
{
    RimmedFace(FlatFace found, const Points& samples)
        : face(std::move(found)), rim(points_at(face.rim, samples)), search(rim)
    {
        for (const Point& p : rim)
        {
            int indices[3];
            double squared[3];
            const int count = search.nearest(p, 3, indices, squared);
            spacing.push_back(std::sqrt(squared[count - 1]));
        }
    }
    RimmedFace(const RimmedFace&) = delete;

    FlatFace face;
    Points rim;
    NeighbourSearch search;
    std::vector<double> spacing; ///< Per rim sample: distance to the second nearest of the rim.
};

/// Where a new sample may go, and how far it keeps from others.
struct Candidate
{
    Point position;
    double radius;
};

class FaceFiller
{
public:
    FaceFiller(const Points& present, const Points& rims, const NeighbourSearch& search, const RimmedFace& face)
        : present_(present), rims_(rims), search_(search), face_(face)
    {
    }

    Points fill(int threads, const Progress& progress) const
    {
        const std::vector<std::array<int, 3>>& triangles = face_.face.triangles;
        const std::size_t most = std::min(most_pieces, most_pieces_per_triangle * triangles.size());
        std::atomic<std::size_t> all = 0; // beyond `most` in any order, or in none
        const std::vector<Candidate> candidates = parallel_collect<Candidate>(
            triangles.size(), threads, progress,
            [&](std::size_t k, std::vector<Candidate>& found)
            {
                if (all > most)
                    return;
                std::size_t left = most + 1;
                divide(rims_[triangles[k][0]], rims_[triangles[k][1]], rims_[triangles[k][2]], 0, left, found);
                all += most + 1 - left;
            },
            16);
        return all > most ? Points{} : thin(candidates);
    }

private:
    /// Lists the centres of pieces as small as half the radius wanted there. \param left pieces that there may be
    /// [count].
    void divide(const Point& a, const Point& b, const Point& c, int depth, std::size_t& left,
                std::vector<Candidate>& found) const
    {
        if (left == 0)
            return;
        const double sides[3] = {(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()};
        const int longest = int(std::max_element(sides, sides + 3) - sides);
        const Point centre = (a + b + c) / 3;
        int nearest;
        double squared;
        face_.search.nearest(centre, 1, &nearest, &squared);
        const double distance = std::sqrt(squared);
        const double radius = share_of_rim_spacing * face_.spacing[nearest] + growth * distance;
        if (sides[longest] <= 0.25 * radius * radius || depth > 24)
        {
            --left;
            if (distance > 0.8 * radius)
                found.push_back(
                    {centre - face_.face.normal.dot(centre - face_.face.origin) * face_.face.normal, radius});
            return;
        }
        if (longest == 0)
            divide_at((a + b) / 2, a, b, c, depth, left, found);
        else if (longest == 1)
            divide_at((b + c) / 2, b, c, a, depth, left, found);
        else
            divide_at((c + a) / 2, c, a, b, depth, left, found);
    }
    void divide_at(const Point& middle, const Point& from, const Point& to, const Point& opposite, int depth,
                   std::size_t& left, std::vector<Candidate>& found) const
    {
        divide(from, middle, opposite, depth + 1, left, found);
        divide(middle, to, opposite, depth + 1, left, found);
    }

    /// In a scrambled order; what an older sample is too near to is left out.
    Points thin(const std::vector<Candidate>& candidates) const
    {
        std::vector<std::pair<std::uint64_t, int>> order;
        for (int i = 0; i < int(candidates.size()); ++i)
            order.emplace_back(scramble(std::uint64_t(i)), i);
        std::sort(order.begin(), order.end());
        Points positions;
        std::vector<double> radii;
        for (const auto& entry : order)
        {
            positions.push_back(candidates[entry.second].position);
            radii.push_back(candidates[entry.second].radius);
        }
        const auto has_room = [&](int i)
        { return (present_[search_.nearest(positions[i])] - positions[i]).norm() >= 0.5 * radii[i]; };
        return points_at(keep_apart(positions, radii, has_room), positions);
    }

    const Points& present_;
    const Points& rims_;
    const NeighbourSearch& search_; ///< Of present_.
    const RimmedFace& face_;
};

/// A wall joins parallel faces (cosine of their normals), straight but for this share of the rim's spacing.
constexpr double parallel = 0.97, aside = 0.6;

/// Samples on walls that rise straight from the rim of one face to the rim of another: extruded shapes and bores carry
/// samples at both ends only.
class WallFiller
{
public:
    /// \param samples that the faces refer to [count]. \param walls without any yet.
    WallFiller(const std::deque<RimmedFace>& faces, int samples, WallSamples walls)
        : faces_(faces), uses_(std::size_t(samples), 0), walls_(std::move(walls))
    {
        for (const RimmedFace& face : faces)
            for (const int v : face.face.rim)
                ++uses_[v];
    }

    void fill(FlatCompletion& result)
    {
        for (int f = 0; f < int(faces_.size()); ++f)
            for (int v = 0; v < int(faces_[f].rim.size()); ++v)
            {
                if (meets_face(f, v))
                    continue;
                const Foot foot = {f, v}, top = find_top(foot);
                // Once from the side of the sparser rim, or for each of two that are not above each other.
                if (top.face < 0 || (is_same(find_top(top), foot) && top.face < f))
                    continue;
                raise(foot, top);
            }
        const Points walls = walls_.thin();
        result.points.insert(result.points.end(), walls.begin(), walls.end());
    }

private:
    struct Foot
    {
        int face = -1, rim = -1;
    };
    static bool is_same(const Foot& a, const Foot& b) { return a.face == b.face && a.rim == b.rim; }
    const Point& position(const Foot& foot) const { return faces_[foot.face].rim[foot.rim]; }

    /// Whether the surface goes on as another flat face.
    bool meets_face(int face, int rim) const { return uses_[faces_[face].face.rim[rim]] > 1; }

    /// Nearest rim sample of another face straight above or below.
    Foot find_top(const Foot& foot) const
    {
        const Point& p = position(foot);
        const RimmedFace& own = faces_[foot.face];
        Foot result;
        double least = 1e300;
        for (int f = 0; f < int(faces_.size()); ++f)
        {
            const RimmedFace& other = faces_[f];
            if (f == foot.face || std::abs(own.face.normal.dot(other.face.normal)) < parallel)
                continue;
            const double height = (other.rim.front() - p).dot(own.face.normal);
            const int nearest = other.search.nearest(p + height * own.face.normal);
            const Vector offset = other.rim[nearest] - p;
            const double squared = offset.squaredNorm(), up = std::abs(offset.dot(own.face.normal));
            const double lateral = std::sqrt(std::max(squared - up * up, 0.0));
            if (squared < least && lateral < up && lateral < aside * other.spacing[nearest] && !meets_face(f, nearest))
            {
                least = squared;
                result = {f, nearest};
            }
        }
        return result;
    }

    void raise(const Foot& foot, const Foot& top)
    {
        const double spacing = std::min(faces_[foot.face].spacing[foot.rim], faces_[top.face].spacing[top.rim]);
        walls_.raise(position(foot), position(top), spacing);
    }

    const std::deque<RimmedFace>& faces_;
    std::vector<int> uses_; ///< Per sample: faces that it bounds.
    WallSamples walls_;
};

} // namespace

Points fill_face(const FlatFace& face, const Points& rims, const Points& present, int threads)
{
    const NeighbourSearch search(present);
    const RimmedFace rimmed(face, rims);
    return FaceFiller(present, rims, search, rimmed).fill(threads, {});
}

FlatCompletion complete_flats(const Points& samples, const FlatFaceOptions& options, const Progress& progress)
{
    FlatCompletion result;
    const FlatFaces found = find_flat_faces(samples, options, progress.part(0, 0.6));
    if (found.bare.empty())
        return result;
    std::deque<RimmedFace> faces;
    for (const FlatFace& face : found.bare)
        faces.emplace_back(face, samples);
    result.faces = int(faces.size());
    const NeighbourSearch search(samples);
    const Progress filling = progress.part(0.6, 0.8, "flat faces");
    const double share = 1 / double(faces.size());
    for (std::size_t k = 0; k < faces.size(); ++k)
    {
        const Points added = FaceFiller(samples, samples, search, faces[k])
                                 .fill(options.threads, filling.part(share * double(k), share * double(k + 1)));
        result.points.insert(result.points.end(), added.begin(), added.end());
    }
    Points present = samples;
    present.insert(present.end(), result.points.begin(), result.points.end());
    const NeighbourSearch search_present(present);
    const WallSamples no_walls(search_present, present);
    if (!found.mere_rims.empty())
    {
        const Points walls =
            fill_rim_walls(found, samples, search, no_walls, options.threads, progress.part(0.8, 1, "flat faces"));
        result.with_all_walls = result.points;
        result.with_all_walls.insert(result.with_all_walls.end(), walls.begin(), walls.end());
    }
    WallFiller(faces, int(samples.size()), no_walls).fill(result);
    return result;
}

} // namespace recon
