#include <recon/noise/pooled_noise.h>

#include <recon/noise/noisy_patches.h>
#include <recon/parallel.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace recon
{

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

namespace
{

constexpr double settled_share = 0.2; // of the seeds; if fewer have settled, all are taken
/// A sheet with twice the noise looks like a part not much thicker than the noise. But noise changes over long
/// distances, so what exceeds that of the region around by more than this is taken for a thin part.
constexpr double largest_excess = 1.2;
constexpr double region_share = 0.2;  // of the seeds
constexpr int region_stride = 8;      // of its seeds so many that one is asked
constexpr double denser_by_far = 2.5; // [ratio of spacings]
constexpr int fewest_alike = 4;       // of the region's seeds
/// Where noises meet that differ by this factor, each of such a share of the places, the median is the noise of
/// neither.
constexpr double of_one_noise = 0.3, other_noise = 4;
/// Spacings of noise beyond which places with less of it may be such whose neighbours all lie inside the noise.
constexpr double most_noise_beside_less = 2;
/// Seeds around that tell an evenly filled layer from two sheets, and how many of these must see any. The halves of a
/// layer have a kurtosis of 2.2 to 2.3 and .05 of the points in their middle, sheets 4 and 3.5 times their noise apart
/// 2.6 and .03 to .05; sheets whose noise is even have nothing there.
constexpr int asked_of_layer = 105, fewest_with_sheets = 26;
constexpr double most_kurtosis_of_layer = 2.42, least_between_in_layer = 0.025;
constexpr std::size_t asked_for_noise = 48; // places of which it is asked whether there is any noise

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

/// Medians over the seeds around each.
class SeedPool
{
public:
    struct Around
    {
        PooledNoise pooled;        ///< In the unit frame: noise of the settled or, beside noisier ones, of those alike.
        std::vector<double> limit; ///< Of the noise: somewhat more than the region's.
        std::vector<SeedNoise> known;
        std::vector<char> meets; ///< Whether noises meet there.
    };

    /// Keeps references to all.
    SeedPool(const Points& seeds, const NeighbourSearch& seed_search, const std::vector<LocalNoise>& raw)
        : seeds_(seeds), seed_search_(seed_search), raw_(raw), settled_(list_settled(raw)),
          region_(list_region(settled_)), settled_seeds_(points_at(settled_, seeds)),
          region_seeds_(points_at(region_, seeds)), settled_search_(settled_seeds_), region_search_(region_seeds_),
          region_count_(std::max(smoothing_seeds, int(region_share * double(region_.size()))))
    {
    }

    const std::vector<int>& settled() const { return settled_; }

    /// \param may_meet whether there is noise.
    Around look(bool may_meet, int threads) const
    {
        const std::size_t n = seeds_.size();
        Around around{{std::vector<double>(n), std::vector<double>(n)},
                      std::vector<double>(n),
                      std::vector<SeedNoise>(n),
                      std::vector<char>(n)};
        parallel_chunks(n, threads, 32, {},
                        [&](std::size_t begin, std::size_t end)
                        {
                            Scratch scratch(region_count_);
                            for (std::size_t i = begin; i < end; ++i)
                                look_at(i, may_meet, scratch, around);
                        });
        return around;
    }

private:
    struct Scratch
    {
        explicit Scratch(int most) : near(most), squared(most), values(most) {}
        std::vector<int> near;
        std::vector<double> squared, values;
    };

    static std::vector<int> list_region(const std::vector<int>& settled)
    {
        std::vector<int> region;
        for (std::size_t k = 0; k < settled.size(); k += region_stride)
            region.push_back(settled[k]);
        return region;
    }

    /// Fills `near` and `values`. \param value of an index of the search. \returns how many.
    template <class Value>
    int find(const NeighbourSearch& search, const Point& seed, int wanted, Scratch& scratch, Value&& value) const
    {
        const int count = search.nearest(seed, wanted, scratch.near.data(), scratch.squared.data());
        for (int k = 0; k < count; ++k)
            scratch.values[k] = value(scratch.near[k]);
        return count;
    }

    /// Of the first `found` in `near`, seeds of the region, moves those to the front whose samples are not denser by
    /// far: of the region of a coarse body most can lie on a fine one, far away perhaps. \param density of the seeds at
    /// this one, which outliers do not change. \returns how many, or all of them if they are most, or too few.
    int choose_alike(double density, int found, std::vector<int>& near) const
    {
        const double most = denser_by_far * denser_by_far * density;
        const auto end = std::stable_partition(near.begin(), near.begin() + found,
                                               [&](int k) { return raw_[region_[k]].density <= most; });
        const int alike = int(end - near.begin());
        return alike < fewest_alike || 2 * alike >= found ? found : alike;
    }

    void look_at(std::size_t i, bool may_meet, Scratch& scratch, Around& around) const
    {
        double* const values = scratch.values.data();
        const Point& seed = seeds_[i];
        const int of_settled =
            find(settled_search_, seed, smoothing_seeds, scratch, [&](int k) { return raw_[settled_[k]].sigma; });
        const double settled_sigma = middle_of(values, of_settled);

        const int of_all = find(seed_search_, seed, smoothing_seeds, scratch, [&](int k) { return raw_[k].density; });
        const double density = middle_of(values, of_all);
        const double sigma = may_meet
                                 ? noise_beside_noisier(raw_, i, scratch.near.data(), of_all, settled_sigma, density)
                                 : settled_sigma;

        const int found = region_search_.nearest(seed, region_count_, scratch.near.data(), scratch.squared.data());
        const int of_region = may_meet ? choose_alike(density, found, scratch.near) : found;
        for (int k = 0; k < of_region; ++k)
            values[k] = raw_[region_[scratch.near[k]]].density;
        const double region_spacing = 1 / std::sqrt(middle_of(values, of_region));
        for (int k = 0; k < of_region; ++k)
            values[k] = raw_[region_[scratch.near[k]]].sigma;
        const RegionNoise region = find_region_noise(values, of_region, region_spacing, may_meet);
        around.limit[i] = largest_excess * region.more;
        around.pooled.density[i] = density;
        around.pooled.sigma[i] = sigma;
        around.meets[i] = of_region < found || region.less < region.more || sigma < settled_sigma;
        around.known[i] = {raw_[i].sigma,  region.less,     1 / std::sqrt(raw_[i].density),
                           region_spacing, raw_[i].settled, raw_[i].sheets.has_value()};
    }

    const Points& seeds_;
    const NeighbourSearch& seed_search_;
    const std::vector<LocalNoise>& raw_;
    std::vector<int> settled_, region_; // seeds
    Points settled_seeds_, region_seeds_;
    NeighbourSearch settled_search_, region_search_;
    int region_count_;
};

/// What each seed saw, but without the sheets that are the halves of an evenly filled layer, as those around tell
/// together.
std::vector<LocalNoise> without_halves_of_layers(const Points& seeds, const NeighbourSearch& search,
                                                 const std::vector<LocalNoise>& raw, int threads)
{
    std::vector<LocalNoise> result = raw;
    const auto ask = [&](std::size_t i)
    {
        if (!raw[i].sheets)
            return;
        std::array<int, asked_of_layer> near;
        std::array<double, asked_of_layer> squared;
        const int found = search.nearest(seeds[i], asked_of_layer, near.data(), squared.data());
        int with_sheets = 0;
        double kurtosis = 0, between = 0;
        for (int k = 0; k < found; ++k)
            if (const std::optional<TwoSheets>& sheets = raw[near[k]].sheets)
            {
                ++with_sheets;
                kurtosis += sheets->kurtosis;
                between += sheets->between;
            }
        if (with_sheets >= fewest_with_sheets && kurtosis < most_kurtosis_of_layer * with_sheets &&
            between > least_between_in_layer * with_sheets)
            result[i].sheets.reset();
    };
    parallel_for(seeds.size(), threads, {}, ask, 32);
    return result;
}

/// Where most around a seed see two sheets, noise is at most that of each sheet.
void take_noise_of_sheets(const Points& seeds, const NeighbourSearch& search, const std::vector<LocalNoise>& raw,
                          double scale, int threads, std::vector<double>& sigma)
{
    const auto limit = [&](std::size_t i)
    {
        std::array<int, smoothing_seeds> near;
        std::array<double, smoothing_seeds> squared, sheets;
        const int found = search.nearest(seeds[i], smoothing_seeds, near.data(), squared.data());
        int with_sheets = 0;
        for (int k = 0; k < found; ++k)
            if (raw[near[k]].sheets)
                sheets[with_sheets++] = raw[near[k]].sheets->sigma;
        if (2 * with_sheets > found)
            sigma[i] = std::min(sigma[i], scale * middle_of(sheets.data(), with_sheets));
    };
    parallel_for(seeds.size(), threads, {}, limit, 32);
}

} // namespace

PooledNoise pool_noise(const Points& samples, const BlockSearch& sample_search, const Points& seeds,
                       const std::vector<LocalNoise>& told, double scale, int threads)
{
    const NeighbourSearch seed_search(seeds);
    const std::vector<LocalNoise> raw = without_halves_of_layers(seeds, seed_search, told, threads);
    const SeedPool seed_pool(seeds, seed_search, raw);
    SeedPool::Around around = seed_pool.look(true, threads);
    // Asked last, since it takes triangulations, and in most clouds no noises meet.
    if (std::find(around.meets.begin(), around.meets.end(), 1) != around.meets.end() &&
        !has_noise(samples, sample_search, seeds, raw, threads))
        around = seed_pool.look(false, threads);
    const std::vector<char> noisy_patch = find_noisy_patches(samples, sample_search, seeds, around.known, threads);
    PooledNoise result = std::move(around.pooled);
    take_noise_of_patches(seeds, raw, seed_pool.settled(), around.known, noisy_patch, threads, result.sigma);
    for (std::size_t i = 0; i < seeds.size(); ++i)
    {
        double& sigma = result.sigma[i];
        sigma = noise_truncation * scale * (noisy_patch[i] ? sigma : std::min(sigma, around.limit[i]));
        result.density[i] /= scale * scale;
    }
    take_noise_of_sheets(seeds, seed_search, raw, scale, threads, result.sigma);
    return result;
}

} // namespace recon
