#include <recon/labelling/ball_scale.h>

#include <recon/median.h>
#include <recon/noise/cleanness.h>
#include <recon/parallel.h>
#include <recon/search/nearest_samples.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace recon
{
namespace
{

constexpr int largest_subset = 20'000;
constexpr int fine_count = 6, coarse_count = 30;
/// Smallest polar ball kept, in the fine scale and in the coarse one.
constexpr double fine_ball = 0.3, coarse_ball = 0.7;
/// Shares of samples around one above which its scale is fine: of those with clean poles, or, at thin walls, whose
/// poles are short and slant, of neighbours that lie flat.
constexpr double clean_above = 0.45, flat_above = 0.75;
/// In a cloud more of whose neighbours than this lie flat, a smaller share is enough.
constexpr double flat_cloud = 0.9, flat_above_in_flat_cloud = 0.6;
constexpr double pi = 3.14159265358979323846;

void append_scale(BallScale& result, double scale, double count, double factor)
{
    result.scale.push_back(scale);
    result.density.push_back(count / (pi * scale * scale));
    result.threshold.push_back(factor * scale);
}

/// About the distance within which member i has `count` neighbours, as a start for searches.
double guess_reach(const SampleSpacing& spacing, std::size_t i, double count)
{
    return 1.15 * spacing.fine[i] * std::sqrt(count / fine_count);
}

/// sqrt(2 x mean squared distance) of the nearest, the first of which is the sample itself.
double spread(const double* squared, int count)
{
    double sum = 0;
    for (int j = 1; j < count; ++j)
        sum += squared[j];
    return std::sqrt(2 * sum / std::max(count - 1, 1));
}

/// Coarse spacing of the members that are not fine, 0 of the others.
std::vector<double> measure_coarse(const SampleSpacing& spacing, const std::vector<char>& is_fine,
                                   const Points& samples, const BlockSearch& search, int threads)
{
    constexpr int around = 9;
    const std::size_t m = spacing.subset.size();
    std::vector<int> coarse;
    for (std::size_t i = 0; i < m; ++i)
        if (!is_fine[i])
            coarse.push_back(int(i));
    std::vector<std::array<int, around>> near(coarse.size());
    std::vector<int> found(coarse.size());
    parallel_for(coarse.size(), threads, {},
                 [&](std::size_t k)
                 {
                     double squared[around];
                     found[k] =
                         spacing.search.nearest(samples[spacing.subset[coarse[k]]], around, near[k].data(), squared);
                 });
    std::vector<char> is_near(m, 0);
    for (std::size_t k = 0; k < coarse.size(); ++k)
        for (int j = 0; j < found[k]; ++j)
            is_near[near[k][j]] = 1;
    std::vector<double> raw(m, 0), result(m, 0);
    parallel_for(m, threads, {},
                 [&](std::size_t i)
                 {
                     if (!is_near[i])
                         return;
                     int indices[coarse_count + 1];
                     double squared[coarse_count + 1];
                     double reach = guess_reach(spacing, i, coarse_count);
                     const int count =
                         search.nearest(samples[spacing.subset[i]], coarse_count + 1, indices, squared, reach);
                     raw[i] = spread(squared, count);
                 });
    parallel_for(coarse.size(), threads, {},
                 [&](std::size_t k)
                 {
                     std::vector<double> values;
                     for (int j = 0; j < found[k]; ++j)
                         values.push_back(raw[near[k][j]]);
                     result[coarse[k]] = median(std::move(values));
                 });
    return result;
}

} // namespace

SampleSpacing measure_spacing(const Points& samples, const BlockSearch& search, int threads)
{
    SampleSpacing result;
    const int n = int(samples.size());
    const int stride = (n + largest_subset - 1) / largest_subset;
    for (int i = 0; i < n; i += std::max(stride, 1))
        result.subset.push_back(i);
    const std::size_t m = result.subset.size();
    result.mates.resize(m, {-1, -1, -1});
    result.eighth.resize(m);
    result.fine.resize(m);
    const auto measure = [&](std::size_t begin, std::size_t end)
    {
        constexpr int around = 9;
        int indices[around];
        double squared[around], reach = 0;
        for (std::size_t i = begin; i < end; ++i)
        {
            const int found = search.nearest(samples[result.subset[i]], around, indices, squared, reach);
            for (int j = 1; j < std::min(found, 4); ++j)
                result.mates[i][j - 1] = indices[j];
            result.eighth[i] = std::sqrt(squared[found - 1]);
            result.fine[i] = spread(squared, std::min(found, fine_count + 1));
        }
    };
    parallel_chunks(m, threads, 256, {}, measure);
    const Points members = points_at(result.subset, samples);
    result.search = BlockSearch(members, threads);
    result.nearest = find_nearest_samples(samples, members, threads).sample;
    return result;
}

BallScale choose_scale(const SampleSpacing& spacing, const Points& samples, const BlockSearch& search,
                       const Triangulation& delaunay, const Poles& poles, double noise, int threads)
{
    const std::size_t m = spacing.subset.size();
    std::vector<char> clean(m);
    std::vector<double> flat(m, 0);
    parallel_for(m, threads, {},
                 [&](std::size_t i)
                 {
                     const int v = spacing.subset[i];
                     const auto& cells = poles.cells[v];
                     if (cells[0] == Poles::none)
                         return;
                     const Vector first = delaunay.centres[cells[0]] - samples[v];
                     std::array<Point, 3> mates;
                     int count = 0;
                     for (const int mate : spacing.mates[i])
                         if (mate >= 0)
                             mates[count++] = samples[mate] - samples[v];
                     flat[i] = share_of_flat(first, mates.data(), count);
                     if (cells[1] == Poles::none)
                         return;
                     const Vector second = delaunay.centres[cells[1]] - samples[v];
                     clean[i] = has_clean_poles(first, second, spacing.eighth[i]);
                 });
    // Corners and small holes of a cloud that is clean all over are no noise; noisy parts of it have half of their
    // neighbours flat.
    const bool is_flat_cloud = std::accumulate(flat.begin(), flat.end(), 0.0) > flat_cloud * double(m);
    const double flat_limit = is_flat_cloud ? flat_above_in_flat_cloud : flat_above;
    constexpr int around = 24;
    const double samples_per_member = double(samples.size()) / double(m);
    std::vector<char> is_fine(m);
    parallel_for(m, threads, {},
                 [&](std::size_t i)
                 {
                     if (noise > 0)
                     {
                         is_fine[i] = noise < 0.1 * spacing.fine[i];
                         return;
                     }
                     int indices[around];
                     double squared[around];
                     double reach = guess_reach(spacing, i, around * samples_per_member);
                     const int found =
                         spacing.search.nearest(samples[spacing.subset[i]], around, indices, squared, reach);
                     double cleanness = 0, flatness = 0;
                     for (int j = 0; j < found; ++j)
                     {
                         cleanness += clean[indices[j]] ? 1.0 / found : 0;
                         flatness += flat[indices[j]] / found;
                     }
                     is_fine[i] = cleanness > clean_above || flatness > flat_limit;
                 });
    const std::vector<double> coarse = measure_coarse(spacing, is_fine, samples, search, threads);
    BallScale result;
    for (const int i : spacing.nearest)
        if (is_fine[i])
            append_scale(result, spacing.fine[i], fine_count, fine_ball);
        else
            append_scale(result, coarse[i], coarse_count, coarse_ball);
    result.median_spacing = median(spacing.fine);
    return result;
}

BallScale choose_fine_scale(const SampleSpacing& spacing)
{
    BallScale result;
    for (const int i : spacing.nearest)
        append_scale(result, spacing.fine[i], fine_count, fine_ball);
    result.median_spacing = median(spacing.fine);
    return result;
}

} // namespace recon
