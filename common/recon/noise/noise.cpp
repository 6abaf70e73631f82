#include <recon/noise/noise.h>

#include <recon/errors.h>
#include <recon/median.h>
#include <recon/noise/noisy_lines.h>
#include <recon/noise/noisy_patches.h>
#include <recon/noise/scale_ladder.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/search/neighbours.h>
#include <recon/search/spatial_order.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
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

namespace
{

/// Reorders the values. \param share of them that are smaller.
double quantile_of(double* values, int count, double share)
{
    double* const at = values + std::ptrdiff_t(share * count);
    std::nth_element(values, at, values + count);
    return *at;
}
double middle_of(double* values, int count)
{
    return quantile_of(values, count, 0.5);
}

} // namespace

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
/// The residual at the scale chosen is a little below the noise, since a ball cuts off its tails.
constexpr double truncation = 1.055;
constexpr int smoothing_seeds = 21;
constexpr double settled_share = 0.2; // of the seeds; if fewer have settled, all are taken
/// A sheet with twice the noise looks like a part not much thicker than the noise. But noise changes over long
/// distances, so what exceeds that of the region around by more than this is taken for a thin part.
constexpr double largest_excess = 1.2;
constexpr double region_share = 0.2; // of the seeds
constexpr int region_stride = 8;     // of its seeds so many that one is asked
/// Where noises meet that differ by this factor, each of such a share of the places, the median is the noise of
/// neither.
constexpr double of_one_noise = 0.3, other_noise = 4;
/// Spacings of noise beyond which places with less of it may be such whose neighbours all lie inside the noise.
constexpr double most_noise_beside_less = 2;
constexpr std::size_t asked_for_noise = 48; // places of which it is asked whether there is any noise
constexpr int stack_stride = 4;             // of the seeds so many that one is asked whether it is in a stack
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

/// Noise and density per seed, in input units.
struct Pooled
{
    std::vector<double> sigma, density;
};

/// Seeds whose residual is noise and not shape; all, if these are few.
std::vector<int> list_settled(const std::vector<LocalNoise>& raw)
{
    std::vector<int> settled;
    for (int i = 0; i < int(raw.size()); ++i)
        if (raw[i].settled)
            settled.push_back(i);
    if (settled.size() < settled_share * int(raw.size()))
    {
        settled.resize(raw.size());
        std::iota(settled.begin(), settled.end(), 0);
    }
    return settled;
}

/// The noisy seeds of patches take the median of noisy ones alone: at the rim of a patch half of those around are
/// clean.
void take_noise_of_patches(const Points& seeds, const std::vector<LocalNoise>& raw, const std::vector<int>& settled,
                           const std::vector<SeedNoise>& known, const std::vector<char>& is_patch, int threads,
                           std::vector<double>& sigma)
{
    const auto is_noisy = [&](std::size_t i) { return is_patch[i] && exceeds_region(known[i]); };
    std::vector<int> noisy;
    for (const int i : settled)
        if (is_noisy(i))
            noisy.push_back(i);
    if (noisy.empty())
        return;
    const Points noisy_seeds = points_at(noisy, seeds);
    const NeighbourSearch search(noisy_seeds);
    const auto take = [&](std::size_t i)
    {
        if (!is_noisy(i))
            return;
        std::array<int, smoothing_seeds> near;
        std::array<double, smoothing_seeds> squared, values;
        const int count = search.nearest(seeds[i], smoothing_seeds, near.data(), squared.data());
        for (int k = 0; k < count; ++k)
            values[k] = raw[noisy[near[k]]].sigma;
        sigma[i] = middle_of(values.data(), count);
    };
    parallel_for(seeds.size(), threads, {}, take, 32);
}

/// Whether there is noise, told from detail of coarse exact clouds.
bool has_noise(const Points& samples, const BlockSearch& search, const Points& seeds,
               const std::vector<LocalNoise>& raw, int threads)
{
    std::vector<int> noisy;
    for (int i = 0; i < int(raw.size()); ++i)
        if (raw[i].settled && raw[i].sigma * std::sqrt(raw[i].density) > least_noise_told)
            noisy.push_back(i);
    Points asked;
    for (std::size_t k = 0; k < noisy.size(); k += noisy.size() / asked_for_noise + 1)
        asked.push_back(seeds[std::size_t(noisy[k])]);
    return lie_in_noise(samples, search, asked, threads);
}

/// Noise of the region around a seed: two where noises meet, else their median.
struct RegionNoise
{
    double less, more;
};

/// Reorders the values. \param spacing of the region. \param may_meet whether there is noise.
RegionNoise find_region_noise(double* sigma, int count, double spacing, bool may_meet)
{
    const double less = quantile_of(sigma, count, of_one_noise), more = quantile_of(sigma, count, 1 - of_one_noise);
    if (may_meet && more > other_noise * less && more > least_noise_told * spacing)
        return {less, more};
    const double middle = middle_of(sigma, count);
    return {middle, middle};
}

/// Exact places seldom settle, so that those around which have settled are noisy ones: where places with less noise by
/// far are not rare they speak for each other.
/// \param near the seeds around `seed`. \param sigma of the settled ones around. \returns the seed's.
double noise_beside_noisier(const std::vector<LocalNoise>& raw, std::size_t seed, const int* near, int count,
                            double sigma, double density)
{
    if (other_noise * raw[seed].sigma >= sigma || sigma * std::sqrt(density) > most_noise_beside_less)
        return sigma;
    std::array<double, smoothing_seeds> less;
    int found = 0;
    for (int k = 0; k < count; ++k)
        if (const double value = raw[std::size_t(near[k])].sigma; other_noise * value < sigma)
            less[found++] = value;
    return found < of_one_noise * count ? sigma : middle_of(less.data(), found);
}

/// Medians over the seeds around each: noise of the settled ones or, beside noisier ones, of those like it; at most
/// somewhat more than that of the region but in noisy patches, where noisy seeds speak for noisy ones; where most see
/// two sheets, that of each sheet. Density of all. \param scale of the unit frame. \param samples the cloud.
Pooled pool(const Points& samples, const BlockSearch& sample_search, const Points& seeds,
            const std::vector<LocalNoise>& raw, double scale, int threads)
{
    const std::vector<int> settled = list_settled(raw);
    const Points settled_seeds = points_at(settled, seeds);
    Points region_seeds;
    std::vector<double> region_sigma, region_density;
    for (std::size_t k = 0; k < settled.size(); k += region_stride)
    {
        region_seeds.push_back(settled_seeds[k]);
        region_sigma.push_back(raw[settled[k]].sigma);
        region_density.push_back(raw[settled[k]].density);
    }
    const int region = std::max(smoothing_seeds, int(region_share * double(region_seeds.size())));
    Pooled result{std::vector<double>(seeds.size()), std::vector<double>(seeds.size())};
    std::vector<double> limit(seeds.size());
    std::vector<SeedNoise> known(seeds.size());
    std::vector<char> meets(seeds.size());
    const NeighbourSearch seed_search(seeds), settled_search(settled_seeds), region_search(region_seeds);
    const auto pool_each = [&](bool may_meet)
    {
        parallel_chunks(seeds.size(), threads, 32, {},
                        [&](std::size_t begin, std::size_t end)
                        {
                            std::vector<int> near(region);
                            std::vector<double> squared(region), values(region);
                            const auto median_of = [&](int count, auto value)
                            {
                                for (int k = 0; k < count; ++k)
                                    values[k] = value(near[k]);
                                return middle_of(values.data(), count);
                            };
                            const auto find = [&](const NeighbourSearch& search, std::size_t seed, int wanted)
                            { return search.nearest(seeds[seed], wanted, near.data(), squared.data()); };
                            for (std::size_t i = begin; i < end; ++i)
                            {
                                const int of_settled = find(settled_search, i, smoothing_seeds);
                                result.sigma[i] = median_of(of_settled, [&](int k) { return raw[settled[k]].sigma; });
                                const int of_region = find(region_search, i, region);
                                const double dense = median_of(of_region, [&](int k) { return region_density[k]; });
                                for (int k = 0; k < of_region; ++k)
                                    values[k] = region_sigma[near[k]];
                                const RegionNoise around =
                                    find_region_noise(values.data(), of_region, 1 / std::sqrt(dense), may_meet);
                                limit[i] = largest_excess * around.more;
                                const int of_all = find(seed_search, i, smoothing_seeds);
                                result.density[i] = median_of(of_all, [&](int k) { return raw[k].density; });
                                const double of_settled_ones = result.sigma[i];
                                if (may_meet)
                                    result.sigma[i] = noise_beside_noisier(raw, i, near.data(), of_all, of_settled_ones,
                                                                           result.density[i]);
                                meets[i] = around.less < around.more || result.sigma[i] < of_settled_ones;
                                known[i] = {raw[i].sigma,         around.less,    1 / std::sqrt(raw[i].density),
                                            1 / std::sqrt(dense), raw[i].settled, raw[i].sheet_sigma >= 0};
                            }
                        });
    };
    pool_each(true);
    // Asked last, since it takes triangulations, and in most clouds no noises meet.
    if (std::find(meets.begin(), meets.end(), 1) != meets.end() &&
        !has_noise(samples, sample_search, seeds, raw, threads))
        pool_each(false);
    const std::vector<char> noisy_patch = find_noisy_patches(samples, sample_search, seeds, known, threads);
    take_noise_of_patches(seeds, raw, settled, known, noisy_patch, threads, result.sigma);
    const auto limit_sigma = [&](std::size_t i)
    {
        double& sigma = result.sigma[i];
        sigma = truncation * scale * (noisy_patch[i] ? sigma : std::min(sigma, limit[i]));
        result.density[i] /= scale * scale;
        std::array<int, smoothing_seeds> near;
        std::array<double, smoothing_seeds> squared, sheets;
        const int found = seed_search.nearest(seeds[i], smoothing_seeds, near.data(), squared.data());
        int with_sheets = 0;
        for (int k = 0; k < found; ++k)
            if (raw[near[k]].sheet_sigma >= 0)
                sheets[with_sheets++] = raw[near[k]].sheet_sigma;
        if (2 * with_sheets > found)
            sigma = std::min(sigma, scale * middle_of(sheets.data(), with_sheets));
    };
    parallel_for(seeds.size(), threads, {}, limit_sigma, 32);
    return result;
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
                       Pooled& pooled)
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

/// Where many of those around lie on noisy lines: noise and density as these tell.
void take_noise_across_lines(const CloudPyramid& pyramid, const Points& seeds, int most, double scale, int threads,
                             Pooled& pooled)
{
    const std::vector<double> reach = find_noisy_lines(pyramid.levels[0], pyramid.searches[0], seeds, threads);
    if (reach.empty())
        return;
    std::vector<LocalNoise> across(seeds.size());
    parallel_chunks(seeds.size(), threads, 32, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        ScaleLadder ladder(pyramid, most);
                        for (std::size_t i = begin; i < end; ++i)
                            if (reach[i] > 0)
                                across[i] = ladder.estimate_across_lines(seeds[i], reach[i]);
                    });
    const NeighbourSearch search(seeds);
    const auto correct = [&](std::size_t i)
    {
        const auto told = find_medians(search, seeds[i], share_on_lines,
                                       [&](std::size_t k) { return reach[k] > 0 ? &across[k] : nullptr; });
        if (!told)
            return;
        pooled.sigma[i] = std::max(pooled.sigma[i], truncation * scale * told->sigma);
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
    Pooled pooled = pool(pyramid.levels[0], pyramid.searches[0], seeds, raw, frame.scale(), threads);
    take_one_of_stack(seeds, raw, frame.scale(), threads, pooled);
    take_noise_across_lines(pyramid, seeds, most, frame.scale(), threads, pooled);
    progress.report(1);
    frame.from_unit_in_place(seeds);
    return NoiseEstimate(std::move(seeds), std::move(pooled.sigma), std::move(pooled.density));
}

} // namespace recon
