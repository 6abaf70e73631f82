#include "sparse_parts.h"

#include <recon/parallel.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr int most_asked = 128, around = 16, spanning = 8;
constexpr double apart = 0.5;       // of the distance of the farther one: else a dense part would be all that is seen
constexpr double near_sheet = 0.15; // of the distance, and
constexpr double near_sigmas = 1;   // of the noise
constexpr double least_sine = 0.3, least_bent_sine = 0.1; // of what spans a plane, a sphere
constexpr double farthest_from_sheet = 0.25;              // of the distance at most
/// Of 16. Points scattered through space reach either in one place of 50.
constexpr int fewest_on_plane = 9, fewest_on_sphere = 11;
constexpr double thinned_reach = 4.1;     // spacings of random samples of a plane within which 16 are kept
constexpr double beside_sheet = 2;        // spacings of it
constexpr int company = 6;                // other lonely cells, within a ball that
constexpr double expected_company = 0.75; // would have of evenly scattered ones

/// Directions and distances of the nearest cells, each at least half its distance from those before it.
struct Surroundings
{
    int count = 0;
    Vector directions[around];
    double distances[around];
};

Surroundings look_around(const Points& means, const BlockSearch& search, int cell)
{
    int near[most_asked];
    double squared[most_asked];
    const int found = search.nearest(means[cell], most_asked, near, squared);
    Surroundings result;
    Vector offsets[around];
    for (int k = 0; k < found && result.count < around; ++k)
    {
        const Vector offset = means[near[k]] - means[cell];
        const double closest = apart * apart * squared[k];
        if (!(squared[k] > 0) || std::any_of(offsets, offsets + result.count,
                                             [&](const Vector& o) { return (o - offset).squaredNorm() < closest; }))
            continue;
        offsets[result.count] = offset;
        result.distances[result.count] = std::sqrt(squared[k]);
        result.directions[result.count] = offset / result.distances[result.count];
        ++result.count;
    }
    return result;
}

/// Whether most of what is around lies on one plane or sphere through the cell: n . e = bend d for direction e and
/// distance d of a neighbour.
bool lie_on_sheet(const Surroundings& s, double slack)
{
    double tolerance[around];
    for (int k = 0; k < s.count; ++k)
        tolerance[k] = std::min(near_sheet + slack / s.distances[k], farthest_from_sheet);
    const auto count_near = [&](const Vector& normal, double bend)
    {
        int near = 0;
        for (int k = 0; k < s.count; ++k)
            near += std::abs(normal.dot(s.directions[k]) - bend * s.distances[k]) <= tolerance[k];
        return near;
    };
    const int asked = std::min(s.count, spanning);
    for (int a = 0; a < asked; ++a)
        for (int b = a + 1; b < asked; ++b)
        {
            const Vector plane = s.directions[a].cross(s.directions[b]);
            if (plane.norm() > least_sine && count_near(plane.normalized(), 0) >= fewest_on_plane)
                return true;
            // Inversion turns the sphere into a plane.
            const Vector p = s.directions[a] / s.distances[a], ab = s.directions[b] / s.distances[b] - p;
            for (int c = b + 1; c < asked; ++c)
            {
                const Vector ac = s.directions[c] / s.distances[c] - p, sphere = ab.cross(ac);
                if (sphere.norm() > least_bent_sine * ab.norm() * ac.norm() &&
                    count_near(sphere.normalized(), sphere.normalized().dot(p)) >= fewest_on_sphere)
                    return true;
            }
        }
    return false;
}

/// Volume of the box around the cells that are not lonely.
double room_of_others(const Points& means, const std::vector<int>& lonely)
{
    Points others;
    std::size_t next = 0;
    for (int c = 0; c < int(means.size()); ++c)
        if (next < lonely.size() && lonely[next] == c)
            ++next;
        else
            others.push_back(means[c]);
    if (others.empty())
        return 0;
    const Box box = bounding_box(others);
    return (box.maximum - box.minimum).prod();
}

} // namespace

bool is_on_sheet(const Points& points, const BlockSearch& search, int point, double slack)
{
    return lie_on_sheet(look_around(points, search, point), slack);
}

std::vector<LonelyCell> find_sparse_parts(const Cells& cells, const BlockSearch& search, const std::vector<int>& lonely,
                                          int threads)
{
    std::vector<LonelyCell> result(lonely.size());
    if (lonely.empty())
        return result;
    parallel_for(lonely.size(), threads, {},
                 [&](std::size_t k)
                 {
                     const Surroundings s = look_around(cells.means, search, lonely[k]);
                     result[k].belongs = lie_on_sheet(s, near_sigmas * cells.scales[lonely[k]].sigma);
                     if (result[k].belongs)
                         result[k].spacing = s.distances[s.count - 1] / thinned_reach;
                 });
    Points all, sheet;
    std::vector<double> spacing;
    for (std::size_t k = 0; k < lonely.size(); ++k)
    {
        all.push_back(cells.means[lonely[k]]);
        if (result[k].belongs)
        {
            sheet.push_back(all.back());
            spacing.push_back(result[k].spacing);
        }
    }
    const BlockSearch all_search(all), sheet_search(sheet);
    const double room = room_of_others(cells.means, lonely), scattered = double(all.size() - sheet.size());
    for (std::size_t k = 0; k < lonely.size(); ++k)
    {
        if (result[k].belongs)
            continue;
        int near[company + 1];
        double squared[company + 1];
        const bool in_company = all_search.nearest(all[k], company + 1, near, squared) == company + 1 &&
                                4 * pi / 3 * std::pow(squared[company], 1.5) * scattered < expected_company * room;
        const int nearest = sheet_search.nearest(all[k]);
        const bool is_beside = nearest >= 0 && (sheet[std::size_t(nearest)] - all[k]).norm() <=
                                                   beside_sheet * spacing[std::size_t(nearest)];
        result[k].belongs = in_company || is_beside;
        if (is_beside && !in_company)
            result[k].spacing = spacing[std::size_t(nearest)];
    }
    return result;
}

} // namespace recon
