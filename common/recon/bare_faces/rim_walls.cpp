#include <recon/bare_faces/rim_walls.h>

#include <recon/bare_faces/rim_curves.h>
#include <recon/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

/// Cosine of the normals of parallel planes, and what a sample is off the plane of a rim [rim spacings].
constexpr double parallel = 0.97, off_plane = 0.03;
/// A wall is straight but for this share of the rim's spacing: chords of a circle of 18 samples are off by 0.05.
constexpr double straight = 0.15;
/// No wall begins where there are samples straight before it within this share of its height, and so many rim spacings.
constexpr double empty_share = 0.6, empty_spacings = 3;
/// The surface is sampled by loops where this share of one lies between the same two others, seen in directions whose
/// cosine is at most this.
constexpr double nearly_all = 0.7, opposite = -0.8;

/// Up to two of what a rim sample bounds, by number.
class Bounded
{
public:
    bool has(int surface) const { return ids_[0] == surface || ids_[1] == surface; }
    bool may_have(int surface) const { return has(surface) || ids_[1] == none; }
    void add(int surface)
    {
        if (!has(surface) && ids_[1] == none)
            ids_[ids_[0] != none] = surface;
    }

private:
    static constexpr int none = -1;
    int ids_[2] = {none, none};
};

/// A closed curve of a rim. Stays where it was made: `search` refers to `points`.
struct Loop
{
    Loop(const FlatFace& face, const RimCurve& curve, bool bounds_face, const Points& positions)
        : normal(face.normal), is_of_face(bounds_face), samples(list_samples(face, curve)),
          points(points_at(samples, positions)), search(points), along(samples.size()), spacing(samples.size(), 0)
    {
        for (const auto& [a, b] : curve.edges)
        {
            along[a].push_back(b);
            along[b].push_back(a);
        }
        for (std::size_t k = 0; k < points.size(); ++k)
            for (const int j : along[k])
            {
                const double length = (points[j] - points[k]).norm();
                spacing[k] += length / double(along[k].size());
                longest_edge = std::max(longest_edge, length);
            }
    }
    Loop(const Loop&) = delete;

    Vector normal; ///< Of its plane.
    bool is_of_face;
    std::vector<int> samples;
    Points points; ///< Their positions.
    NeighbourSearch search;
    std::vector<std::vector<int>> along; ///< Per sample: the places of those beside it.
    std::vector<double> spacing;         ///< Per sample: mean distance from these.
    double longest_edge = 0;

private:
    static std::vector<int> list_samples(const FlatFace& face, const RimCurve& curve)
    {
        std::vector<int> result;
        for (const int k : curve.places)
            result.push_back(face.rim[k]);
        return result;
    }
};

class RimWallFiller
{
public:
    RimWallFiller(const FlatFaces& faces, const Points& samples, const NeighbourSearch& search, WallSamples walls)
        : samples_(samples), search_(search), bounded_(samples.size()), places_(samples.size()),
          walls_(std::move(walls))
    {
        for (const auto* list : {&faces.bare, &faces.narrow, &faces.mere_rims})
            for (const FlatFace& face : *list)
                append_loops(face, list != &faces.mere_rims);
    }

    Points fill(int threads, const Progress& progress)
    {
        add_strips();
        raise_walls(threads, progress);
        return walls_.thin();
    }

private:
    struct Wall
    {
        int foot = -1, place = -1; ///< Loop, and which of its samples.
        int top = -1, sample = -1; ///< Loop, and the sample next to the wall's end.
        double height = 0;
        Point end = Point::Zero();
    };
    using Beside = std::array<int, 2>; ///< Samples below and above, -1 if there are none.

    /// A surface from a loop to another has the other's number, a face in the loop's plane this.
    static int face_of(int loop) { return -2 - loop; }

    void append_loops(const FlatFace& face, bool is_face)
    {
        for (const RimCurve& curve : list_rim_curves(face))
        {
            const int loop = int(loops_.size());
            loops_.emplace_back(face, curve, is_face, samples_);
            const std::vector<int>& samples = loops_.back().samples;
            for (int k = 0; k < int(samples.size()); ++k)
            {
                places_[samples[k]].emplace_back(loop, k);
                if (is_face)
                    bounded_[samples[k]].add(face_of(loop));
            }
        }
    }

    /// Nearest samples off the plane of a loop, if they are among the nearest at all.
    Beside find_beside(const Loop& loop, int place) const
    {
        constexpr int around = 64;
        int near[around];
        double squared[around];
        const int count = search_.nearest(loop.points[place], around, near, squared);
        Beside result = {-1, -1};
        for (int j = count - 1; j > 0; --j)
        {
            const double height = (samples_[near[j]] - loop.points[place]).dot(loop.normal);
            if (std::abs(height) > off_plane * loop.spacing[place])
                result[height > 0] = near[j];
        }
        return result;
    }

    /// Where the surface is sampled by loops, however far apart.
    void add_strips()
    {
        for (const Loop& loop : loops_)
        {
            beside_.emplace_back();
            for (int k = 0; k < int(loop.points.size()); ++k)
                beside_.back().push_back(find_beside(loop, k));
        }
        for (int l = 0; l < int(loops_.size()); ++l)
            if (!loops_[l].is_of_face)
                add_strips_beside(l);
    }

    /// To both sides of a loop, if nearly all of it lies between the same two others, and is what they see next.
    void add_strips_beside(int l)
    {
        const Loop& loop = loops_[l];
        std::map<std::pair<int, int>, int> counts;
        for (int k = 0; k < int(loop.points.size()); ++k)
            if (goes_on(l, k))
                for (const auto& below : places_[beside_[l][k][0]])
                    for (const auto& above : places_[beside_[l][k][1]])
                        if (leads_back(below, l) && leads_back(above, l))
                            ++counts[{below.first, above.first}];
        for (const auto& [others, count] : counts)
            if (count >= nearly_all * double(loop.points.size()))
                for (int k = 0; k < int(loop.points.size()); ++k)
                    for (const int side : {0, 1})
                    {
                        bounded_[loop.samples[k]].add(side == 0 ? others.first : others.second);
                        if (beside_[l][k][side] >= 0)
                            bounded_[beside_[l][k][side]].add(l);
                    }
    }

    /// Whether the nearest samples lie on opposite sides.
    bool goes_on(int l, int place) const
    {
        const auto [below, above] = beside_[l][place];
        if (below < 0 || above < 0)
            return false;
        const Point& p = loops_[l].points[place];
        return (samples_[below] - p).normalized().dot((samples_[above] - p).normalized()) < opposite;
    }

    bool leads_back(const std::pair<int, int>& from, int to) const
    {
        const Beside& back = beside_[from.first][from.second];
        return std::any_of(back.begin(), back.end(),
                           [&](int sample)
                           {
                               return sample >= 0 && std::any_of(places_[sample].begin(), places_[sample].end(),
                                                                 [&](const auto& entry) { return entry.first == to; });
                           });
    }

    void raise_walls(int threads, const Progress& progress)
    {
        std::vector<std::pair<int, int>> feet; // loops and which of their samples
        for (int l = 0; l < int(loops_.size()); ++l)
            for (int k = 0; k < int(loops_[l].points.size()); ++k)
                feet.emplace_back(l, k);
        std::vector<Wall> walls =
            parallel_collect<Wall>(feet.size(), threads, progress,
                                   [&](std::size_t i, std::vector<Wall>& found)
                                   {
                                       const auto [l, k] = feet[i];
                                       for (const int side : {1, -1})
                                       {
                                           const Wall wall = find_wall(l, k, side);
                                           if (wall.top >= 0 && is_empty(wall, side * loops_[l].normal))
                                               found.push_back(wall);
                                       }
                                   });
        std::stable_sort(walls.begin(), walls.end(), [](const Wall& a, const Wall& b) { return a.height < b.height; });
        for (const Wall& wall : walls)
        {
            const Loop& foot = loops_[wall.foot];
            Bounded &at_foot = bounded_[foot.samples[wall.place]], &at_top = bounded_[wall.sample];
            if (!at_foot.may_have(wall.top) || !at_top.may_have(wall.foot))
                continue;
            at_foot.add(wall.top);
            at_top.add(wall.foot);
            walls_.raise(foot.points[wall.place], wall.end, foot.spacing[wall.place]);
        }
    }

    /// Nearest sample of a loop, by place; -1 if none is so near that the loop may pass straight below or above.
    static int find_nearest(const Loop& loop, const Point& p, std::vector<int>& near)
    {
        // A query of the nearest from the middle of a circle would visit all of it.
        loop.search.within(p, (1 + straight) * loop.longest_edge, near);
        const auto distance = [&](int k) { return (loop.points[k] - p).squaredNorm(); };
        const auto nearest =
            std::min_element(near.begin(), near.end(),
                             [&](int a, int b) { return std::pair(distance(a), a) < std::pair(distance(b), b); });
        return nearest == near.end() ? -1 : *nearest;
    }

    /// To the nearest place on another loop straight above or below.
    Wall find_wall(int l, int place, int side) const
    {
        const Loop& own = loops_[l];
        const Vector up = side * own.normal;
        const Point& p = own.points[place];
        Wall result;
        std::vector<int> near;
        double least = 1e300;
        for (int g = 0; g < int(loops_.size()); ++g)
        {
            const Loop& other = loops_[g];
            const double height = (other.points.front() - p).dot(up);
            if (g == l || height >= least || height <= off_plane * own.spacing[place] ||
                std::abs(up.dot(other.normal)) < parallel)
                continue;
            const Point above = p + height * up;
            const int nearest = find_nearest(other, above, near);
            if (nearest < 0)
                continue;
            const Point& q = other.points[nearest];
            for (const int w : other.along[nearest])
            {
                const Vector edge = other.points[w] - q;
                const Point end = q + std::clamp((above - q).dot(edge) / edge.squaredNorm(), 0.0, 1.0) * edge;
                if ((end - above).norm() >= std::min(straight * other.spacing[nearest], height))
                    continue;
                least = height;
                result = {l, place, g, other.samples[nearest], height, end};
            }
        }
        return result;
    }

    bool is_empty(const Wall& wall, const Vector& up) const
    {
        const Loop& own = loops_[wall.foot];
        const Point& p = own.points[wall.place];
        const double spacing = own.spacing[wall.place];
        std::vector<int> near;
        search_.within(p, std::min(empty_share * wall.height, empty_spacings * spacing), near);
        return std::none_of(near.begin(), near.end(),
                            [&](int i)
                            {
                                const Vector offset = samples_[i] - p;
                                const double height = offset.dot(up);
                                return height > off_plane * spacing && height > 0.5 * offset.norm();
                            });
    }

    const Points& samples_;
    const NeighbourSearch& search_;
    std::deque<Loop> loops_;
    std::vector<Bounded> bounded_;                         ///< Per sample.
    std::vector<std::vector<std::pair<int, int>>> places_; ///< Per sample: loops that it lies on, and where.
    std::vector<std::vector<Beside>> beside_;              ///< Per loop and its samples.
    WallSamples walls_;
};

} // namespace

Points fill_rim_walls(const FlatFaces& faces, const Points& samples, const NeighbourSearch& search, WallSamples walls,
                      int threads, const Progress& progress)
{
    return RimWallFiller(faces, samples, search, std::move(walls)).fill(threads, progress);
}

} // namespace recon
