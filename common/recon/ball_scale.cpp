#include <recon/ball_scale.h>

#include <recon/cleanness.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon
{
namespace
{

constexpr int largest_subset = 20'000;
constexpr int fine_count = 6, coarse_count = 30;
/// Shares of samples around one above which its scale is fine: of those with clean poles, or, at thin walls, whose
/// poles are short and slant, of neighbours that lie flat.
constexpr double clean_above = 0.45, flat_above = 0.75;
constexpr double pi = 3.14159265358979323846;

double median(std::vector<double> values)
{
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

void append_scale(BallScale& result, double scale, double count, double factor)
{
    result.scale.push_back(scale);
    result.density.push_back(count / (pi * scale * scale));
    result.threshold.push_back(factor * scale);
}

} // namespace

SampleSpacing measure_spacing(const Points& samples, const NeighbourSearch& search, int threads,
                              const Progress& progress)
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
    std::vector<double> raw(m);
    parallel_for(m, threads, progress.part(0, 0.6, "local spacing"),
                 [&](std::size_t i)
                 {
                     int indices[coarse_count + 1];
                     double squared[coarse_count + 1];
                     const int found = search.nearest(samples[result.subset[i]], coarse_count + 1, indices, squared);
                     const auto spread = [&](int k)
                     {
                         k = std::min(k, found - 1);
                         double sum = 0;
                         for (int j = 1; j <= k; ++j)
                             sum += squared[j];
                         return std::sqrt(2 * sum / std::max(k, 1));
                     };
                     for (int j = 1; j < std::min(found, 4); ++j)
                         result.mates[i][j - 1] = indices[j];
                     result.eighth[i] = std::sqrt(squared[std::min(8, found - 1)]);
                     result.fine[i] = spread(fine_count);
                     raw[i] = spread(coarse_count);
                 });

    const Points members = points_at(result.subset, samples);
    const NeighbourSearch member_search(members);
    result.coarse.resize(m);
    parallel_for(m, threads, progress.part(0.6, 0.8, "local spacing"),
                 [&](std::size_t i)
                 {
                     int indices[9];
                     double squared[9];
                     const int found = member_search.nearest(members[i], 9, indices, squared);
                     std::vector<double> values;
                     for (int j = 0; j < found; ++j)
                         values.push_back(raw[indices[j]]);
                     result.coarse[i] = median(std::move(values));
                 });
    result.nearest.resize(samples.size());
    parallel_for(samples.size(), threads, progress.part(0.8, 1, "local spacing"),
                 [&](std::size_t i) { result.nearest[i] = member_search.nearest(samples[i]); });
    return result;
}

BallScale choose_scale(const SampleSpacing& spacing, const Points& samples, const Triangulation& delaunay,
                       const Poles& poles, double noise, int threads)
{
    const std::size_t m = spacing.subset.size();
    std::vector<char> clean(m);
    std::vector<double> flat(m, 0);
    for (std::size_t i = 0; i < m; ++i)
    {
        const int v = spacing.subset[i];
        const auto& cells = poles.cells[v];
        if (cells[0] == Poles::none)
            continue;
        const Vector first = delaunay.centres[cells[0]] - samples[v];
        Points mates;
        for (const int mate : spacing.mates[i])
            if (mate >= 0)
                mates.push_back(samples[mate] - samples[v]);
        flat[i] = share_of_flat(first, mates.data(), int(mates.size()));
        if (cells[1] == Poles::none)
            continue;
        const Vector second = delaunay.centres[cells[1]] - samples[v];
        clean[i] = has_clean_poles(first, second, spacing.eighth[i]);
    }
    const Points members = points_at(spacing.subset, samples);
    const NeighbourSearch search(members);
    constexpr int around = 24;
    std::vector<double> cleanness(m), flatness(m);
    parallel_for(m, threads, {},
                 [&](std::size_t i)
                 {
                     int indices[around];
                     double squared[around];
                     const int found = search.nearest(members[i], around, indices, squared);
                     for (int j = 0; j < found; ++j)
                     {
                         cleanness[i] += clean[indices[j]] ? 1.0 / found : 0;
                         flatness[i] += flat[indices[j]] / found;
                     }
                 });
    BallScale result;
    for (const int i : spacing.nearest)
        if (noise > 0 ? noise < 0.1 * spacing.fine[i] : cleanness[i] > clean_above || flatness[i] > flat_above)
            append_scale(result, spacing.fine[i], fine_count, 0.3);
        else
            append_scale(result, spacing.coarse[i], coarse_count, 0.7);
    result.median_spacing = median(spacing.fine);
    return result;
}

BallScale choose_fine_scale(const SampleSpacing& spacing)
{
    BallScale result;
    for (const int i : spacing.nearest)
        append_scale(result, spacing.fine[i], fine_count, 0.3);
    result.median_spacing = median(spacing.fine);
    return result;
}

} // namespace recon
