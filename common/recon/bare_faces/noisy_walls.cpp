#include <recon/bare_faces/noisy_walls.h>

#include <recon/bare_faces/noisy_planes.h>

#include <recon/bare_faces/rim_curves.h>
#include <recon/median.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

namespace recon
{
namespace
{

/// Share of a rim's samples at which a wall must end, within so much of its height [noise].
constexpr double share_of_tops = 0.75, level_top = 3.5;
/// Farthest from the straight line that rises from a rim sample that the wall's other end lies [noise].
constexpr double aside = 3;
/// Beyond a bevel or fillet a wall stands so far off the face, and is no lower than this: less is the bevel [noise].
constexpr double beyond_bevels[] = {0, 2, 4};
constexpr double above_bevel = 7;
/// Share of a rim's edges that are no longer than what two samples on the wall's other end may be apart: rims of a wall
/// are divided alike, but one may be turned against the other.
constexpr double usual_gap = 0.9;
/// Of walls on both sides of a plane the lower one counts if the other is so many times as high.
constexpr double one_sided = 1.5;
/// Highest wall looked for [diagonals of the rim's box].
constexpr double highest_wall = 3;

/// Diagonal of the box around a rim.
double measure_box(const std::vector<int>& rim, const Points& rims)
{
    Point low = rims[rim[0]], high = low;
    for (const int v : rim)
    {
        low = low.cwiseMin(rims[v]);
        high = high.cwiseMax(rims[v]);
    }
    return (high - low).norm();
}

/// What most neighbours on a rim are apart at most.
double find_usual_gap(std::vector<double> gaps)
{
    const auto place = gaps.begin() + std::ptrdiff_t(usual_gap * double(gaps.size() - 1));
    std::nth_element(gaps.begin(), place, gaps.end());
    return *place;
}

} // namespace

std::vector<RimLoop> list_rim_loops(const FlatFace& face, const Points& rims)
{
    std::vector<RimLoop> result;
    for (RimCurve& curve : list_rim_curves(face))
    {
        RimLoop loop;
        for (const int k : curve.places)
        {
            loop.rim.push_back(face.rim[k]);
            loop.away.push_back(face.away[k]);
        }
        for (const auto& [a, b] : curve.edges)
            loop.gaps.push_back((rims[loop.rim[a]] - rims[loop.rim[b]]).norm());
        loop.edges = std::move(curve.edges);
        loop.box = measure_box(loop.rim, rims);
        result.push_back(std::move(loop));
    }
    return result;
}

RimWall WallFinder::find(const FlatFace& face, const RimLoop& loop, const Points& rims, bool is_hole)
{
    RimWall wall;
    for (const double gap : loop.gaps)
        wall.length += gap;
    Reach reach{highest_wall * loop.box, beside_slab * noise_, 0, aside * noise_};
    const std::vector<double> tops_below = find_tops(loop, rims, -face.normal, reach),
                              tops_above = find_tops(loop, rims, face.normal, reach);
    double below = find_height(tops_below), above = find_height(tops_above);
    if (below == 0 && above == 0)
    {
        reach.lowest = above_bevel * noise_;
        reach.along = std::max(reach.along, find_usual_gap(loop.gaps));
        for (const double out : beyond_bevels)
        {
            wall.out = reach.out = out * noise_;
            below = find_height(find_tops(loop, rims, -face.normal, reach));
            above = find_height(find_tops(loop, rims, face.normal, reach));
            if (below > 0 || above > 0)
                break;
        }
    }
    if (is_hole && below == 0 && above == 0)
    {
        wall.out = 0;
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
    {
        wall.out = 0; // of no bevel: the opposite face may still tell how high it is
        return wall;
    }
    wall.side = above == 0 || (below > 0 && below < above) ? -1 : 1;
    wall.height = wall.side < 0 ? below : above;
    // The first points lie lower than most.
    const Vector up = wall.side * face.normal;
    for (int round = 0; round < 3; ++round)
    {
        std::vector<double> heights;
        for (std::size_t k = 0; k < loop.rim.size(); ++k)
        {
            const Point foot = rims[loop.rim[k]] + wall.out * loop.away[k];
            search_.within(foot + wall.height * up, level_top * noise_, near_);
            for (const int i : near_)
                heights.push_back((points_[i] - foot).dot(up));
        }
        if (!heights.empty())
            wall.height = median(heights);
    }
    return wall;
}

bool WallFinder::ends_at(const RimLoop& loop, const Points& rims, const Vector& offset)
{
    const auto count = std::count_if(loop.rim.begin(), loop.rim.end(),
                                     [&](int v)
                                     {
                                         search_.within(rims[v] + offset, level_top * noise_, near_);
                                         return !near_.empty();
                                     });
    return double(count) >= share_of_tops * double(loop.rim.size());
}

bool WallFinder::is_level(const RimWall& wall, double height) const
{
    return std::abs(wall.height - height) < level_top * noise_;
}

/// Heights of the first points along `up`, per rim sample; 0 where there are none.
std::vector<double> WallFinder::find_tops(const RimLoop& loop, const Points& rims, const Vector& up, const Reach& reach)
{
    std::vector<double> tops;
    for (std::size_t k = 0; k < loop.rim.size(); ++k)
    {
        const Vector& away = loop.away[k];
        // Where two rims meet no direction leads along one.
        const double along = away.isZero() ? aside * noise_ : reach.along;
        tops.push_back(find_top(rims[loop.rim[k]] + reach.out * away, up, away, reach, along));
    }
    return tops;
}

/// Height of the first point along `up`; 0 if there is none.
double WallFinder::find_top(const Point& foot, const Vector& up, const Vector& away, const Reach& reach, double along)
{
    // In slices, each higher than the last: most points lie far beyond the first.
    double piece = 2 * along;
    for (double low = reach.lowest; low < reach.highest; piece *= 2)
    {
        const double high = std::min(low + piece, reach.highest);
        search_.within(foot + 0.5 * (low + high) * up, std::hypot(0.5 * (high - low), along), near_);
        double least = 1e300;
        for (const int i : near_)
        {
            const Vector offset = points_[i] - foot;
            const double height = offset.dot(up), off = offset.dot(away);
            const Vector beside = offset - height * up;
            if (height > low && height <= high && height < least && beside.norm() < along &&
                std::abs(off) < aside * noise_)
                least = height;
        }
        if (least <= high)
            return least;
        low = high;
    }
    return 0;
}

/// Height that most tops have, 0 if there is none.
double WallFinder::find_height(const std::vector<double>& tops) const
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
std::vector<double> WallFinder::find_steps(const RimLoop& loop, const std::vector<double>& tops) const
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

} // namespace recon
