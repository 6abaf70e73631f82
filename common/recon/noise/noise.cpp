#include <recon/noise/noise.h>

#include <recon/errors.h>
#include <recon/median.h>
#include <recon/noise/noisy_fibres.h>
#include <recon/noise/noisy_lines.h>
#include <recon/noise/pooled_noise.h>
#include <recon/noise/scale_ladder.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/search/neighbours.h>
#include <recon/search/spatial_order.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace recon
{

struct NoiseEstimate::Data
{
    Data(Points s, std::vector<double> noise, std::vector<double> d)
        : seeds(std::move(s)), sigma(std::move(noise)), density(std::move(d)), search(seeds)
    {
    }
    Points seeds;
    std::vector<double> sigma, density;
    NeighbourSearch search;
};

NoiseEstimate::NoiseEstimate(Points seeds, std::vector<double> sigma, std::vector<double> density)
    : data_(std::make_shared<const Data>(std::move(seeds), std::move(sigma), std::move(density)))
{
}
int NoiseEstimate::size() const
{
    return int(data_->seeds.size());
}
const Points& NoiseEstimate::seeds() const
{
    return data_->seeds;
}
const std::vector<double>& NoiseEstimate::sigma() const
{
    return data_->sigma;
}
const std::vector<double>& NoiseEstimate::density() const
{
    return data_->density;
}
int NoiseEstimate::nearest_seed(const Point& query) const
{
    return data_->search.nearest(query);
}
double NoiseEstimate::spacing_at(const Point& query) const
{
    return 1 / std::sqrt(density()[nearest_seed(query)]);
}

double NoiseEstimate::median_sigma() const
{
    return median(sigma());
}
double NoiseEstimate::most_sigma() const
{
    std::vector<double> values = sigma();
    const auto most = values.begin() + std::ptrdiff_t(values.size() * 49 / 50);
    std::nth_element(values.begin(), most, values.end());
    return *most;
}
double NoiseEstimate::median_spacing() const
{
    return 1 / std::sqrt(median(density()));
}
double NoiseEstimate::least_noise() const
{
    std::vector<double> relative(sigma().size());
    for (std::size_t i = 0; i < relative.size(); ++i)
        relative[i] = sigma()[i] * std::sqrt(density()[i]);
    const auto tenth = relative.begin() + std::ptrdiff_t(relative.size() / 10);
    std::nth_element(relative.begin(), tenth, relative.end());
    return *tenth;
}

namespace
{

/// Neighbours that are looked at. In noise of nine spacings and more none of so many are a piece of surface: where
/// fewer than half of the seeds have settled four times as many are, up to that share of the cloud.
constexpr int largest_count = 6000, largest_share = 10;
constexpr int stack_stride = 4; // of the seeds so many that one is asked whether it is in a stack
/// Share of those asked around that must see a sheet: 0.04 do in thick noise, 0.4 to 0.85 in stacks.
constexpr double stacked_share = 0.3;
/// Share of the places around on noisy lines from which on these speak for all.
constexpr double share_on_lines = 0.3;
/// Both sheets of a plate count as one, and widths that follow from it keep them apart; so two of a stack do.
constexpr double sheets_of_plate = 2;

/// \param most neighbours that are looked at. \returns what each seed sees.
std::vector<LocalNoise> look_around(const Points& seeds, const CloudPyramid& pyramid, int most, int threads,
                                    const Progress& progress)
{
    std::vector<LocalNoise> raw(seeds.size());
    parallel_chunks(seeds.size(), threads, 32, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        ScaleLadder ladder(pyramid, most);
                        for (std::size_t i = begin; i < end; ++i)
                            raw[i] = ladder.estimate(seeds[i], i % stack_stride == 0);
                    });
    return raw;
}

/// What places around a seed tell: noise and density.
struct Told
{
    double sigma, density;
};

/// Medians of what the places around a seed tell, if more than `share` of them tell anything. \param tell of a place,
/// something with noise and density, or null.
template <class Tell>
std::optional<Told> find_medians(const NeighbourSearch& search, const Point& seed, double share, Tell&& tell)
{
    std::array<int, smoothing_seeds> near;
    std::array<double, smoothing_seeds> squared, sigma, density;
    const int asked = search.nearest(seed, smoothing_seeds, near.data(), squared.data());
    int told = 0;
    for (int k = 0; k < asked; ++k)
        if (const auto* place = tell(std::size_t(near[k])))
        {
            sigma[told] = place->sigma;
            density[told++] = place->density;
        }
    if (told <= share * asked)
        return {};
    return Told{middle_of(sigma.data(), told), middle_of(density.data(), told)};
}

/// Where many of those seeds that were asked see stacked sheets: noise and density of one.
void take_one_of_stack(const Points& seeds, const std::vector<LocalNoise>& raw, double scale, int threads,
                       PooledNoise& pooled)
{
    Points asked_seeds;
    std::vector<const StackedSheet*> sheets;
    bool has_stacks = false;
    for (std::size_t i = 0; i < seeds.size(); i += stack_stride)
    {
        asked_seeds.push_back(seeds[i]);
        sheets.push_back(raw[i].stacked ? &*raw[i].stacked : nullptr);
        has_stacks = has_stacks || raw[i].stacked;
    }
    if (!has_stacks)
        return;
    const NeighbourSearch search(asked_seeds);
    const auto correct = [&](std::size_t i)
    {
        const auto sheet = find_medians(search, seeds[i], stacked_share, [&](std::size_t k) { return sheets[k]; });
        if (!sheet)
            return;
        pooled.sigma[i] = std::min(pooled.sigma[i], scale * sheet->sigma);
        pooled.density[i] = std::min(pooled.density[i], sheets_of_plate * sheet->density / scale / scale);
    };
    parallel_for(seeds.size(), threads, {}, correct, 32);
}

/// Where many of those around lie on noisy lines or fibres: noise and density as several of these tell.
/// \param reach radii of neighbourhoods that hold several; 0 elsewhere. \param estimate (ladder, seed, reach).
template <class Estimate>
void take_noise_across(const std::vector<double>& reach, const CloudPyramid& pyramid, const Points& seeds, int most,
                       double scale, int threads, PooledNoise& pooled, Estimate&& estimate)
{
    if (reach.empty())
        return;
    std::vector<LocalNoise> across(seeds.size());
    parallel_chunks(seeds.size(), threads, 32, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        ScaleLadder ladder(pyramid, most);
                        for (std::size_t i = begin; i < end; ++i)
                            if (reach[i] > 0)
                                across[i] = estimate(ladder, seeds[i], reach[i]);
                    });
    const NeighbourSearch search(seeds);
    const auto correct = [&](std::size_t i)
    {
        const auto told = find_medians(search, seeds[i], share_on_lines,
                                       [&](std::size_t k) { return reach[k] > 0 ? &across[k] : nullptr; });
        if (!told)
            return;
        pooled.sigma[i] = std::max(pooled.sigma[i], noise_truncation * scale * told->sigma);
        pooled.density[i] = std::min(pooled.density[i], told->density / scale / scale);
    };
    parallel_for(seeds.size(), threads, {}, correct, 32);
}

} // namespace

NoiseEstimate estimate_noise(const Points& points, const NoiseOptions& options, const Progress& progress)
{
    if (options.seeds < 0)
        throw InvalidInput("The number of seeds must be 0 (automatic) or more.");
    const int threads = resolve_threads(options.threads);
    const UnitFrame frame(points);
    progress.report(0);

    const SpatialOrder spatial = order_spatially(points, threads);
    const int n = int(spatial.order.size());
    Points unit(n);
    parallel_for(
        std::size_t(n), threads, {}, [&](std::size_t i) { unit[i] = frame.to_unit(points[spatial.order[i]]); }, 8192);

    const int wanted = options.seeds > 0 ? options.seeds : std::clamp(n / 25, 1000, 3000);
    const int m = std::min(n, wanted);
    Points seeds(m);
    for (int i = 0; i < m; ++i)
        seeds[i] = unit[std::size_t((i + 0.5) * n / m)];
    const CloudPyramid pyramid(std::move(unit), threads);
    std::vector<LocalNoise> raw;
    double left = 1; // of the progress
    int most = largest_count;
    for (;; most *= 4, left /= 2)
    {
        raw = look_around(seeds, pyramid, most, threads, progress.part(1 - left, 1 - left / 2));
        const auto settled = std::count_if(raw.begin(), raw.end(), [](const LocalNoise& l) { return l.settled; });
        if (2 * settled >= m || 4 * most > n / largest_share)
            break;
    }
    PooledNoise pooled = pool_noise(pyramid.levels[0], pyramid.searches[0], seeds, raw, frame.scale(), threads);
    const Points& all = pyramid.levels[0];
    const std::vector<double> fibres = find_noisy_fibres(all, pyramid.searches[0], seeds, threads);
    if (fibres.empty()) // side by side these are like sheets
        take_one_of_stack(seeds, raw, frame.scale(), threads, pooled);
    take_noise_across(fibres, pyramid, seeds, most, frame.scale(), threads, pooled,
                      [](ScaleLadder& ladder, const Point& seed, double reach)
                      { return ladder.estimate_over_fibres(seed, reach); });
    take_noise_across(find_noisy_lines(all, pyramid.searches[0], seeds, threads), pyramid, seeds, most, frame.scale(),
                      threads, pooled,
                      [](ScaleLadder& ladder, const Point& seed, double reach)
                      { return ladder.estimate_across_lines(seed, reach); });
    progress.report(1);
    frame.from_unit_in_place(seeds);
    return NoiseEstimate(std::move(seeds), std::move(pooled.sigma), std::move(pooled.density));
}

} // namespace recon
