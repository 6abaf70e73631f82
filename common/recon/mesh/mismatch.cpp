#include <recon/mesh/mismatch.h>

#include <recon/mesh/triangle_tree.h>
#include <recon/parallel.h>
#include <recon/search/neighbours.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <vector>

namespace recon
{
namespace
{

/// Points so near to the surface may be noise, where it is known [its standard deviation].
constexpr double reach_of_noise = 5;
/// See NoiseMisfit.
constexpr double far_by_noise = 3, about_equal = 0.9;
/// Points of a place [count]: in Gaussian noise 0.13 % of the places pass for two sheets.
constexpr int place = 32;
constexpr int wide_place = 128;
constexpr std::size_t most_asked = 20'000, most_asked_of_area = 4'000;

/// At most most_asked of the points, at equal steps of their order.
Points choose_asked(const Points& points)
{
    Points asked;
    for (std::size_t i = 0; i < points.size(); i += points.size() / most_asked + 1)
        asked.push_back(points[i]);
    return asked;
}

/// Without bare area.
Mismatch measure_missed(const Points& points, const TriangleMesh& mesh, const NeighbourSearch& search, double noise,
                        int threads, const Progress& progress)
{
    Mismatch result;
    if (mesh.triangles.empty())
    {
        result.missed_points = 1;
        result.missed_by = std::numeric_limits<double>::infinity();
        return result;
    }
    const TriangleTree tree(mesh.vertices, mesh.triangles);
    const Points asked = choose_asked(points);
    std::vector<double> missed_by(asked.size(), 0); // squared [spacings]
    parallel_for(asked.size(), threads, progress,
                 [&](std::size_t i)
                 {
                     const double spacing = measure_spacing_at(asked[i], search),
                                  reach = std::max(spacing, reach_of_noise * noise),
                                  squared = tree.squared_distance_from(asked[i]);
                     if (squared > reach * reach)
                         missed_by[i] = squared / (spacing * spacing);
                 });
    double sum = 0;
    for (const double squared : missed_by)
    {
        sum += squared;
        result.missed_points += squared > 0;
    }
    result.missed_points /= double(asked.size());
    result.missed_by = std::sqrt(sum / double(asked.size()));
    return result;
}

double measure_bare_area(const Points& points, const TriangleMesh& mesh, const NeighbourSearch& search, int threads,
                         const Progress& progress)
{
    std::vector<double> area_up_to;
    double area = 0;
    for (const auto& t : mesh.triangles)
    {
        const Point &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        area_up_to.push_back(area += (b - a).cross(c - a).norm());
    }
    if (!(area > 0))
        return 0;
    // At equal steps of area: a lid is a few large triangles among thousands of small ones.
    const std::size_t asked = std::min(mesh.triangles.size(), most_asked_of_area);
    std::vector<char> is_bare(asked);
    parallel_for(asked, threads, progress,
                 [&](std::size_t i)
                 {
                     const double at = area * ((double(i) + 0.5) / double(asked));
                     const auto found = std::lower_bound(area_up_to.begin(), area_up_to.end() - 1, at);
                     const auto& t = mesh.triangles[std::size_t(found - area_up_to.begin())];
                     const Point centre = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
                     const Point& nearest = points[search.nearest(centre)];
                     is_bare[i] = (centre - nearest).norm() > bare_beyond * measure_spacing_at(nearest, search);
                 });
    return double(std::count(is_bare.begin(), is_bare.end(), 1)) / double(asked);
}

/// Mean and root mean square of numbers whose squares are given, of those listed.
struct Spread
{
    double mean = 0, rms = 0;
};

Spread measure_spread(const std::vector<double>& squared, const int* listed, int count)
{
    double sum = 0, squares = 0;
    for (int k = 0; k < count; ++k)
    {
        const double s = squared[std::size_t(listed[k])];
        sum += std::sqrt(s);
        squares += s;
    }
    return {sum / count, std::sqrt(squares / count)};
}

/// All but `beyond_noise`, from places around every point.
NoiseMisfit measure_places(const Points& points, const std::vector<double>& squared, int threads,
                           const Progress& progress)
{
    const NeighbourSearch search(points);
    const std::size_t n = points.size();
    std::vector<char> has_two(n), is_in_tail(n);
    std::vector<double> evenness(n);
    parallel_for(n, threads, progress,
                 [&](std::size_t i)
                 {
                     std::array<int, wide_place> around;
                     std::array<double, wide_place> ignored;
                     const int count = search.nearest(points[i], wide_place, around.data(), ignored.data());
                     const Spread near = measure_spread(squared, around.data(), std::min(count, place)),
                                  wide = measure_spread(squared, around.data(), count);
                     has_two[i] = near.mean > about_equal * near.rms;
                     evenness[i] = wide.rms > 0 ? wide.mean / wide.rms : 0;
                     is_in_tail[i] = squared[i] > 4 * wide.rms * wide.rms;
                 });
    NoiseMisfit result;
    result.points = int(n);
    result.two_sheets = double(std::count(has_two.begin(), has_two.end(), 1)) / double(n);
    result.evenness = std::accumulate(evenness.begin(), evenness.end(), 0.0) / double(n);
    result.tails = double(std::count(is_in_tail.begin(), is_in_tail.end(), 1)) / double(n);
    return result;
}

} // namespace

bool NoiseMisfit::is_noise() const
{
    // The evenness of n Gaussian points scatters by 0.6 / sqrt(n) or less. Noise of bounded reach, as even as two
    // sheets, has up to 0.0352 in its tails; the sum below is at most 0.8962 then.
    const bool are_sheets_mixed =
        evenness > 0.8 + std::max(0.015, 0.6 / std::sqrt(points)) && (tails > 0.0375 || evenness + 2 * tails > 0.9025);
    return beyond_noise <= 0.05 && two_sheets <= 0.01 && !are_sheets_mixed;
}

NoiseMisfit measure_noise_misfit(const Points& points, const TriangleMesh& mesh, double noise, int threads,
                                 const Progress& progress)
{
    if (points.empty() || mesh.triangles.empty())
        return {};
    const TriangleTree tree(mesh.vertices, mesh.triangles);
    const Points asked = choose_asked(points);
    std::vector<double> squared(asked.size());
    parallel_for(asked.size(), threads, progress.part(0, 0.6, "distances"),
                 [&](std::size_t i) { squared[i] = tree.squared_distance_from(asked[i]); });
    const double reach = far_by_noise * noise;
    const auto beyond = std::count_if(squared.begin(), squared.end(), [&](double s) { return s > reach * reach; });
    NoiseMisfit result = measure_places(asked, squared, threads, progress.part(0.6, 1, "sheets"));
    result.beyond_noise = double(beyond) / double(asked.size());
    return result;
}

std::string describe_missed(double missed_points)
{
    if (missed_points <= missed_without_a_word)
        return {};
    char share[16];
    std::snprintf(share, sizeof share, "%.1f", 100 * missed_points);
    return std::string(share) +
           " % of the points lie farther from the surface than their spacing and noise explain: there thin parts are "
           "lost or filled. Look at them, and scan such parts more densely.";
}

Mismatch measure_mismatch(const Points& points, const TriangleMesh& mesh, int threads, const Progress& progress)
{
    if (points.empty())
        return {};
    const NeighbourSearch search(points);
    Mismatch result = measure_missed(points, mesh, search, 0, threads, progress.part(0, 0.5, "points"));
    result.bare_area = measure_bare_area(points, mesh, search, threads, progress.part(0.5, 1, "area"));
    return result;
}

double measure_missed_points(const Points& points, const TriangleMesh& mesh, int threads, const Progress& progress,
                             double noise)
{
    return points.empty()
               ? 0
               : measure_missed(points, mesh, NeighbourSearch(points), noise, threads, progress).missed_points;
}

double measure_bare_area(const Points& points, const TriangleMesh& mesh, int threads, const Progress& progress)
{
    return points.empty() ? 0 : measure_bare_area(points, mesh, NeighbourSearch(points), threads, progress);
}

} // namespace recon
