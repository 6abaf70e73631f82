#include "complete_noisy_flats.h"

#include "complete_flats.h"
#include "keep_apart.h"
#include "noisy_faces.h"
#include "noisy_planes.h"
#include "planar_faces.h"

#include <recon/block_search.h>
#include <recon/disjoint_sets.h>
#include <recon/median.h>
#include <recon/neighbours.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

namespace recon
{
namespace
{

/// Share of a rim's samples at which a wall must end, within so much of its height [noise].
constexpr double share_of_tops = 0.75, level_top = 3.5;
/// Farthest from the straight line that rises from a rim sample that the wall's other end lies [noise].
constexpr double aside = 3;
/// Distance of samples on walls [rim spacings].
constexpr double wall_density = 0.4;
/// Denoised samples so near to the new ones give way: no surface could be fitted there [noise].
constexpr double replaced_within = 3.5;
/// Share of a face's rim that has walls, at least.
constexpr double least_walled = 0.5;
/// Of walls on both sides of a plane the lower one counts if the other is so many times as high.
constexpr double one_sided = 1.5;
/// Mean cosine of normals around a rim with that of the face above which they tell its outer side.
constexpr double agreeing = 0.1;
/// Share of a rim above which larger faces account for it.
constexpr double explained = 0.7;
/// Highest wall looked for [diagonals of the rim's box].
constexpr double highest_wall = 3;

class NoisyFlatCompleter
{
public:
    NoisyFlatCompleter(const Points& points, double noise, const Points& samples, const Vectors& normals)
        : points_(points), noise_(noise), samples_(samples), normals_(normals), search_(points), sample_search_(samples)
    {
        result_.is_replaced.assign(samples.size(), 0);
    }

    NoisyFlatCompletion complete(const NoisyFaces& found)
    {
        rim_normals_.assign(found.rims.size(), Vector::Zero());
        std::vector<FlatFace> faces;
        for (FlatFace face : sort_by_area(found))
        {
            if (is_explained(face, found.rims))
                continue;
            const bool is_sure = turn_outward(face, found.rims);
            bool is_face = raise_walls(face, found.rims);
            // Else solid is where walls are.
            if (!is_face && !is_sure)
            {
                turn(face);
                is_face = raise_walls(face, found.rims);
            }
            if (!is_face)
                continue;
            for (const int v : face.rim)
                placed_.push_back(found.rims[v]);
            faces.push_back(std::move(face));
        }
        for (std::size_t v = 0; v < found.rims.size(); ++v)
            if (rim_normals_[v].norm() > 0.1)
                append(found.rims[v], rim_normals_[v].normalized());
        for (const int k : keep_apart(wall_points_, wall_radii_))
            append(wall_points_[k], wall_normals_[k].normalized());
        Points present = result_.points;
        for (std::size_t i = 0; i < samples_.size(); ++i)
            if (!result_.is_replaced[i])
                present.push_back(samples_[i]);
        for (const FlatFace& face : faces)
            for (const Point& p : fill_face(face, found.rims, present))
                append(p, face.normal);
        for (const Base& base : bases_)
            for (const Point& p : fill_face(base.face, base.rims, present))
                append(p, base.face.normal);
        return std::move(result_);
    }

private:
    struct Loop
    {
        std::vector<int> rim;                  ///< Indices of rim samples.
        std::vector<Vector> away;              ///< Per rim sample.
        std::vector<std::array<int, 2>> edges; ///< Of places in `rim`.
    };

    void append(const Point& p, const Vector& normal)
    {
        result_.points.push_back(p);
        result_.normals.push_back(normal);
        sample_search_.within(p, replaced_within * noise_, near_);
        for (const int i : near_)
            result_.is_replaced[i] = 1;
    }

    static std::vector<FlatFace> sort_by_area(const NoisyFaces& found)
    {
        std::vector<std::pair<double, std::size_t>> order;
        for (std::size_t k = 0; k < found.faces.size(); ++k)
        {
            double twice = 0;
            for (const auto& t : found.faces[k].triangles)
                twice += (found.rims[t[1]] - found.rims[t[0]]).cross(found.rims[t[2]] - found.rims[t[0]]).norm();
            order.emplace_back(-twice, k);
        }
        std::sort(order.begin(), order.end());
        std::vector<FlatFace> result;
        for (const auto& entry : order)
            result.push_back(found.faces[entry.second]);
        return result;
    }

    /// Whether the rim lies on rims and walls of larger faces: then these have its ground already.
    bool is_explained(const FlatFace& face, const Points& rims) const
    {
        if (placed_.empty())
            return false;
        const NeighbourSearch search(placed_);
        const auto near = std::count_if(
            face.rim.begin(), face.rim.end(),
            [&](int v) { return (placed_[search.nearest(rims[v])] - rims[v]).norm() < replaced_within * noise_; });
        return double(near) > explained * double(face.rim.size());
    }

    /// By what the denoised samples around the rims say together; each alone knows little. \returns whether they agree.
    bool turn_outward(FlatFace& face, const Points& rims) const
    {
        double along = 0;
        for (const int v : face.rim)
            along += normals_[sample_search_.nearest(rims[v])].dot(face.normal);
        if (along < 0)
            turn(face);
        return std::abs(along) > agreeing * double(face.rim.size());
    }

    static void turn(FlatFace& face)
    {
        face.normal = -face.normal;
        for (auto& t : face.triangles)
            std::swap(t[0], t[1]);
    }

    std::vector<Loop> list_loops(const FlatFace& face) const
    {
        std::map<int, int> place;
        for (const int v : face.rim)
            place.insert({v, int(place.size())});
        const std::vector<std::array<int, 2>> border = list_border_edges(face.triangles);
        DisjointSets sets(face.rim.size());
        for (const auto& [a, b] : border)
            sets.join(place[a], place[b]);
        std::map<int, Loop> loops;
        std::vector<int> place_in_loop;
        for (std::size_t k = 0; k < face.rim.size(); ++k)
        {
            Loop& loop = loops[int(sets.find(int(k)))];
            place_in_loop.push_back(int(loop.rim.size()));
            loop.rim.push_back(face.rim[k]);
            loop.away.push_back(face.away[k]);
        }
        for (const auto& [v, w] : border)
        {
            const int a = place[v], b = place[w];
            loops[int(sets.find(a))].edges.push_back({place_in_loop[a], place_in_loop[b]});
        }
        std::vector<Loop> result;
        for (auto& entry : loops)
            if (!entry.second.edges.empty())
                result.push_back(std::move(entry.second));
        return result;
    }

    /// Heights of the first points straight along `up`, per rim sample; 0 where there are none.
    std::vector<double> find_tops(const Loop& loop, const Points& rims, const Vector& up, double highest)
    {
        std::vector<double> tops;
        for (const int v : loop.rim)
        {
            search_.within(rims[v] + 0.5 * highest * up, 0.5 * highest + aside * noise_, near_);
            double least = 1e300;
            for (const int i : near_)
            {
                const Vector offset = points_[i] - rims[v];
                const double height = offset.dot(up);
                if (height > beside_slab * noise_ && (offset - height * up).norm() < aside * noise_)
                    least = std::min(least, height);
            }
            tops.push_back(least < 1e300 ? least : 0);
        }
        return tops;
    }

    /// Height that most tops have, 0 if there is none.
    double find_height(const std::vector<double>& tops) const
    {
        std::vector<double> heights;
        std::copy_if(tops.begin(), tops.end(), std::back_inserter(heights), [](double top) { return top > 0; });
        if (double(heights.size()) < share_of_tops * double(tops.size()))
            return 0;
        const double height = median(heights);
        const auto level = std::count_if(heights.begin(), heights.end(),
                                         [&](double h) { return std::abs(h - height) < level_top * noise_; });
        return double(level) < share_of_tops * double(tops.size()) ? 0 : height;
    }

    /// Tops of a wall that ends in steps: each level with those of both its neighbours or of the next two on one side.
    /// The others take the nearest such; empty if these are fewer than a wall has.
    std::vector<double> find_steps(const Loop& loop, const std::vector<double>& tops) const
    {
        const std::size_t n = tops.size();
        std::vector<std::vector<int>> next(n);
        for (const auto& [a, b] : loop.edges)
        {
            next[a].push_back(b);
            next[b].push_back(a);
        }
        const auto is_level_with = [&](int a, int b)
        { return tops[a] > 0 && tops[b] > 0 && std::abs(tops[a] - tops[b]) < level_top * noise_; };
        std::vector<double> result(n, 0);
        std::vector<int> known;
        for (int v = 0; v < int(n); ++v)
        {
            int level = 0;
            for (const int w : next[v])
                if (is_level_with(v, w))
                {
                    ++level;
                    for (const int u : next[w])
                        level += u != v && is_level_with(v, u);
                }
            if (level >= 2)
            {
                result[v] = tops[v];
                known.push_back(v);
            }
        }
        if (double(known.size()) < share_of_tops * double(n))
            return {};
        while (!known.empty())
        {
            std::vector<int> reached;
            for (const int v : known)
                for (const int w : next[v])
                    if (result[w] == 0)
                    {
                        result[w] = result[v];
                        reached.push_back(w);
                    }
            known = std::move(reached);
        }
        return result;
    }

    struct Wall
    {
        double height = 0; ///< 0 = none.
        double side = 0;   ///< -1 where it falls off below the face, 1 where it rises over it.
        double length = 0; ///< Of the loop.
        std::vector<double> steps = {}; ///< Heights at the rim samples if they differ.
    };

    /// Diagonal of the box around a rim.
    static double measure_box(const Loop& loop, const Points& rims)
    {
        Point low = rims[loop.rim[0]], high = low;
        for (const int v : loop.rim)
        {
            low = low.cwiseMin(rims[v]);
            high = high.cwiseMax(rims[v]);
        }
        return (high - low).norm();
    }

    /// \param is_hole only a hole's walls may end in steps: an outline's are faces with rims of their own.
    Wall find_wall(const FlatFace& face, const Loop& loop, const Points& rims, bool is_hole)
    {
        Wall wall;
        for (const auto& edge : loop.edges)
            wall.length += (rims[loop.rim[edge[0]]] - rims[loop.rim[edge[1]]]).norm();
        const double highest = highest_wall * measure_box(loop, rims);
        const std::vector<double> tops_below = find_tops(loop, rims, -face.normal, highest),
                                  tops_above = find_tops(loop, rims, face.normal, highest);
        const double below = find_height(tops_below), above = find_height(tops_above);
        if (is_hole && below == 0 && above == 0)
        {
            wall.steps = find_steps(loop, tops_below);
            if (!wall.steps.empty() && find_steps(loop, tops_above).empty())
            {
                wall.side = -1;
                wall.height = median(wall.steps);
            }
            else
                wall.steps.clear();
            return wall;
        }
        // As high on both sides: a surface that crosses the plane.
        if (std::max(below, above) < one_sided * std::min(below, above) || std::max(below, above) == 0)
            return wall;
        wall.side = above == 0 || (below > 0 && below < above) ? -1 : 1;
        wall.height = wall.side < 0 ? below : above;
        // The first points lie lower than most.
        const Vector up = wall.side * face.normal;
        for (int round = 0; round < 3; ++round)
        {
            std::vector<double> heights;
            for (const int v : loop.rim)
            {
                search_.within(rims[v] + wall.height * up, level_top * noise_, near_);
                for (const int i : near_)
                    heights.push_back((points_[i] - rims[v]).dot(up));
            }
            if (!heights.empty())
                wall.height = median(heights);
        }
        return wall;
    }

    /// \returns whether most of the face's rim has walls, so that it is a face.
    bool raise_walls(const FlatFace& face, const Points& rims)
    {
        const std::vector<Loop> loops = list_loops(face);
        double outline = 0;
        for (const Loop& loop : loops)
            outline = std::max(outline, measure_box(loop, rims));
        std::vector<Wall> walls;
        double length = 0, walled = 0;
        for (const Loop& loop : loops)
        {
            walls.push_back(find_wall(face, loop, rims, measure_box(loop, rims) < outline));
            length += walls.back().length;
            walled += walls.back().side < 0 ? walls.back().length : 0;
        }
        if (walled < least_walled * length)
            return false;
        // Most of the rim has walls of one height: there the opposite face lies, as of a prism.
        double depth = 0, most = least_walled * length;
        for (const Wall& wall : walls)
        {
            double same = 0;
            std::vector<double> heights;
            for (const Wall& other : walls)
                if (wall.side < 0 && other.side < 0 && is_level(wall, other.height))
                {
                    same += other.length;
                    heights.push_back(other.height);
                }
            if (same > most)
            {
                // A rim may be bevelled; most are not.
                depth = median(heights);
                most = same;
            }
        }
        // Above a known opposite face it is enough that most points of a rim have some there.
        for (std::size_t k = 0; k < loops.size() && depth > 0; ++k)
            if (walls[k].height == 0 && ends_at(loops[k], rims, -depth * face.normal))
            {
                walls[k].height = depth;
                walls[k].side = -1;
            }
        for (const int v : face.rim)
            rim_normals_[v] += face.normal;
        std::vector<char> is_base(rims.size(), 0);
        for (std::size_t k = 0; k < loops.size(); ++k)
            if (walls[k].height > 0)
            {
                const bool ends_at_base =
                    depth > 0 && walls[k].side < 0 && walls[k].steps.empty() && is_level(walls[k], depth);
                append_wall(face, loops[k], walls[k], rims, ends_at_base);
                if (ends_at_base)
                    for (const int v : loops[k].rim)
                        is_base[v] = 1;
            }
        if (depth > 0)
            append_base(face, depth, rims, is_base);
        return true;
    }

    /// Whether most samples of a rim have points beside the place that lies off them by `offset`.
    bool ends_at(const Loop& loop, const Points& rims, const Vector& offset)
    {
        const auto count = std::count_if(loop.rim.begin(), loop.rim.end(),
                                         [&](int v)
                                         {
                                             search_.within(rims[v] + offset, level_top * noise_, near_);
                                             return !near_.empty();
                                         });
        return double(count) >= share_of_tops * double(loop.rim.size());
    }

    bool is_level(const Wall& wall, double height) const { return std::abs(wall.height - height) < level_top * noise_; }

    void append_wall(const FlatFace& face, const Loop& loop, const Wall& wall, const Points& rims, bool ends_at_base)
    {
        const Vector up = wall.side * face.normal;
        const double spacing = spacing_of(loop, rims);
        const auto raise = [&](const Point& foot, const Vector& away, double height)
        {
            const int pieces = std::max(1, int(std::ceil(height / spacing)));
            for (int j = 1; j <= pieces; ++j)
            {
                const Vector normal = -wall.side * away;
                wall_points_.push_back(foot + (height * j / pieces) * up);
                placed_.push_back(wall_points_.back());
                wall_normals_.push_back(ends_at_base && j == pieces ? Vector(normal - face.normal) : normal);
                wall_radii_.push_back(wall_density * spacing);
            }
        };
        for (std::size_t k = 0; k < loop.rim.size(); ++k)
            rim_normals_[loop.rim[k]] -= wall.side * loop.away[k];
        for (const auto& edge : loop.edges)
        {
            const Point &a = rims[loop.rim[edge[0]]], &b = rims[loop.rim[edge[1]]];
            const Vector &first = loop.away[edge[0]], &second = loop.away[edge[1]];
            if (first.dot(second) <= 0)
                continue;
            const int pieces = std::max(1, int(std::ceil((b - a).norm() / spacing)));
            for (int j = 0; j < 2 * pieces; ++j)
            {
                const double t = 0.5 * j / pieces;
                raise(a + t * (b - a), ((1 - t) * first + t * second).normalized(),
                      wall.steps.empty() ? wall.height : wall.steps[edge[t < 0.5 ? 0 : 1]]);
            }
        }
    }

    /// Median distance of neighbours on a rim.
    double spacing_of(const Loop& loop, const Points& rims) const
    {
        std::vector<double> lengths;
        for (const auto& edge : loop.edges)
            lengths.push_back((rims[loop.rim[edge[0]]] - rims[loop.rim[edge[1]]]).norm());
        return median(std::move(lengths));
    }

    /// The face again, seen from behind, where rims with walls of that depth are nearest.
    void append_base(const FlatFace& face, double depth, const Points& rims, const std::vector<char>& is_base)
    {
        Base base{face, rims};
        for (const int v : face.rim)
            base.rims[v] -= depth * face.normal;
        base.face.origin -= depth * face.normal;
        base.face.normal = -face.normal;
        auto& triangles = base.face.triangles;
        triangles.erase(std::remove_if(triangles.begin(), triangles.end(),
                                       [&](const std::array<int, 3>& t)
                                       { return !is_base[t[0]] && !is_base[t[1]] && !is_base[t[2]]; }),
                        triangles.end());
        bases_.push_back(std::move(base));
    }

    /// A face's copy on the other side of a prism.
    struct Base
    {
        FlatFace face;
        Points rims;
    };

    const Points& points_;
    double noise_;
    const Points& samples_;
    const Vectors& normals_;
    BlockSearch search_;
    NeighbourSearch sample_search_;
    std::vector<int> near_;
    Vectors rim_normals_; ///< Sums over what meets at each rim sample.
    Points placed_;       ///< On rims and walls so far.
    Points wall_points_;
    Vectors wall_normals_;
    std::vector<double> wall_radii_;
    std::vector<Base> bases_;
    NoisyFlatCompletion result_;
};

} // namespace

NoisyFlatCompletion complete_noisy_flats(const Points& points, double noise, const Points& samples,
                                         const Vectors& normals, int threads, const Progress& progress)
{
    const NoisyFaces found = find_noisy_faces(points, noise, threads, progress);
    if (found.faces.empty())
        return {};
    return NoisyFlatCompleter(points, noise, samples, normals).complete(found);
}

} // namespace recon
