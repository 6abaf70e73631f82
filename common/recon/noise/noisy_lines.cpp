#include <recon/noise/noisy_lines.h>

#include <recon/noise/patch_fit.h>
#include <recon/parallel.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace recon
{
namespace
{

/// Clouds of fewer points say nothing, since those of CAD programs have few, most of them on rims in faces [count].
constexpr std::size_t fewest_points = 2'000;
/// Places asked [count], and share of them on lines: 0.47 and 0.51 of two sweeps of a car's scanner, 0.45 to 0.98 of
/// simulated ones, 0.22 at most of 250 models and scans, most of them parts of CAD programs.
constexpr std::size_t asked = 200;
constexpr double least_share = 0.3;
/// Neighbours that may lie within a line, the fewest that may reach beyond it, by how many more are taken if they do
/// not, and the most [count].
constexpr int within_line = 12, beyond_line = 36, most_neighbours = 1'500;
constexpr double growth = 1.5;
/// Spread of the second direction by that of the first, at most within a line, and at least beyond it.
constexpr double of_line = 0.7, of_several = 0.5;
/// Of points from their plane within a line, by that in the plane: at most.
constexpr double in_plane = 0.07;
/// What strays in the plane is noise and not shape: half the squared steps from one to the next by the squares, 1 of
/// noise, and the fourth power's mean by the squared one's, 1 of two lines beside each other.
constexpr double least_whiteness = 0.75, least_kurtosis = 1.7;
/// Noise within a line by that which several show, at least: they are seen at a slant.
constexpr double of_all_noise = 0.5;
/// Cosine between the plane within the line and the surface, at most.
constexpr double turned = 0.985;

/// Spread of the second direction by that of the first [1].
double measure_breadth(const std::vector<PatchResidual>& residuals)
{
    double across = 0, along = 0;
    for (const PatchResidual& r : residuals)
    {
        across += r.place[1] * r.place[1];
        along += r.place[2] * r.place[2];
    }
    return along > 0 ? std::sqrt(across / along) : 1;
}

/// How points stray from a parabola along them, in their plane.
struct Stray
{
    double deviation; ///< [radii of the neighbourhood]
    bool is_noise;
};

Stray measure_stray(const std::vector<PatchResidual>& residuals)
{
    const auto row_of = [](const PatchResidual& r) { return Eigen::Vector3d(1, r.place[2], r.place[2] * r.place[2]); };
    Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const PatchResidual& r : residuals)
    {
        normal_matrix += row_of(r) * row_of(r).transpose();
        right += r.place[1] * row_of(r);
    }
    const Eigen::Vector3d parabola = normal_matrix.ldlt().solve(right);
    std::vector<std::pair<double, double>> strays; // place along the line, and what is off
    for (const PatchResidual& r : residuals)
        strays.emplace_back(r.place[2], r.place[1] - row_of(r).dot(parabola));
    std::sort(strays.begin(), strays.end());
    double squares = 0, fourth = 0, steps = 0;
    for (std::size_t i = 0; i < strays.size(); ++i)
    {
        const double square = strays[i].second * strays[i].second;
        squares += square;
        fourth += square * square;
        if (i > 0)
            steps += std::pow(strays[i].second - strays[i - 1].second, 2);
    }
    const double count = double(strays.size());
    return {std::sqrt(squares / (count - 3)),
            steps >= 2 * least_whiteness * squares && count * fourth >= least_kurtosis * squares * squares};
}

/// Radius of a neighbourhood of several noisy lines; 0 if there are none.
double measure_reach(const Points& points, const BlockSearch& search, const Point& seed)
{
    std::vector<int> near;
    std::vector<double> squared;
    std::vector<PatchResidual> residuals;
    double radius = 0;
    const auto fit = [&](int count)
    {
        near.resize(std::size_t(count));
        squared.resize(near.size());
        const int found = search.nearest(seed, count, near.data(), squared.data());
        radius = std::sqrt(squared[std::size_t(found - 1)]);
        return fit_patch(points, seed, near.data(), found, radius, residuals);
    };
    const PatchFit narrow = fit(within_line);
    if (measure_breadth(residuals) >= of_line)
        return 0;
    const Stray stray = measure_stray(residuals);
    const double beside = radius * stray.deviation;
    if (!stray.is_noise || narrow.distance > in_plane * beside)
        return 0;
    const int largest = std::min(most_neighbours, int(points.size() / 3));
    for (double count = beyond_line; count <= largest; count *= growth)
    {
        const PatchFit wide = fit(int(count));
        if (measure_breadth(residuals) >= of_several)
            return radius >= patch_flatness * wide.height && beside >= of_all_noise * wide.distance &&
                           std::abs(narrow.normal.dot(wide.normal)) <= turned
                       ? radius
                       : 0;
    }
    return 0;
}

} // namespace

bool has_noisy_lines(const Points& points, const BlockSearch& search, int threads)
{
    if (points.size() < fewest_points)
        return false;
    std::vector<char> is_on_line(asked);
    const auto look = [&](std::size_t k)
    { is_on_line[k] = measure_reach(points, search, points[(2 * k + 1) * points.size() / (2 * asked)]) > 0; };
    parallel_for(asked, threads, {}, look, 8);
    return double(std::count(is_on_line.begin(), is_on_line.end(), 1)) > least_share * double(asked);
}

std::vector<double> find_noisy_lines(const Points& points, const BlockSearch& search, const Points& seeds, int threads)
{
    if (!has_noisy_lines(points, search, threads))
        return {};
    std::vector<double> reach(seeds.size());
    parallel_for(
        seeds.size(), threads, {}, [&](std::size_t i) { reach[i] = measure_reach(points, search, seeds[i]); }, 8);
    return reach;
}

} // namespace recon
