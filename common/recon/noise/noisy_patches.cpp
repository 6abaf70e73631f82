#include <recon/noise/noisy_patches.h>

#include <recon/noise/cleanness.h>
#include <recon/parallel.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace recon
{
namespace
{

constexpr int asked_seeds = 21;
constexpr double least_excess = 2.5; // times the region's noise
/// Noise of the region above which nothing is told [spacings]: what is thinner than some of it, such as claws, then
/// looks like thicker noise in all of this.
constexpr double most_around = 0.4;
/// Times the region's spacing; what is sparser are outliers.
constexpr double most_sparse = 2.5;
constexpr double least_share = 0.5; // of the seeds asked, in the middle of a patch
constexpr double settled_share = 0.1, sheets_share = 0.4;
/// Mean share of flat neighbours, see share_of_flat(), of what noise from 0.2 spacings leaves (0.5 to 0.65); what looks
/// like noise in coarse clean clouds has 0.6 to 0.95.
constexpr double most_flat = 0.67;

/// Whether the seeds around tell noise.
bool looks_like_noise(const std::vector<SeedNoise>& noise, const int* near, int count)
{
    int noisy = 0, sheets = 0, settled = 0;
    for (int k = 0; k < count; ++k)
    {
        const SeedNoise& seed = noise[std::size_t(near[k])];
        if (!exceeds_region(seed))
            continue;
        ++noisy;
        sheets += seed.two_sheets;
        settled += seed.settled;
    }
    return noisy >= least_share * count && settled >= settled_share * noisy && sheets <= sheets_share * noisy;
}

std::vector<double> measure_flat(const Points& samples, const BlockSearch& search, const Points& places, int threads)
{
    std::vector<double> flat(places.size());
    parallel_for(
        places.size(), threads, {},
        [&](std::size_t k) { flat[k] = measure_flat_neighbours(samples, search, places[k]); }, 4);
    return flat;
}

/// The noisy seeds beside those of a patch are of it: of a noisy seed at its rim half of the seeds around are clean.
std::vector<char> add_rims(const NeighbourSearch& search, const Points& seeds, const std::vector<SeedNoise>& noise,
                           const std::vector<char>& middle, int threads)
{
    std::vector<char> result = middle;
    parallel_for(
        seeds.size(), threads, {},
        [&](std::size_t i)
        {
            if (middle[i] || !exceeds_region(noise[i]))
                return;
            std::array<int, asked_seeds> near;
            std::array<double, asked_seeds> squared;
            const int count = search.nearest(seeds[i], asked_seeds, near.data(), squared.data());
            result[i] =
                std::any_of(near.begin(), near.begin() + count,
                            [&](int k) { return middle[std::size_t(k)] && exceeds_region(noise[std::size_t(k)]); });
        },
        64);
    return result;
}

} // namespace

bool exceeds_region(const SeedNoise& seed)
{
    return seed.region < most_around * seed.spacing && seed.sigma > least_excess * seed.region &&
           seed.sigma > least_noise_told * seed.spacing && seed.spacing < most_sparse * seed.region_spacing;
}

bool lie_in_noise(const Points& samples, const BlockSearch& search, const Points& places, int threads)
{
    const std::vector<double> flat = measure_flat(samples, search, places, threads);
    return !flat.empty() && std::accumulate(flat.begin(), flat.end(), 0.0) <= most_flat * double(flat.size());
}

std::vector<char> find_noisy_patches(const Points& samples, const BlockSearch& search, const Points& seeds,
                                     const std::vector<SeedNoise>& noise, int threads)
{
    const std::size_t m = seeds.size();
    std::vector<char> result(m, 0);
    std::vector<int> noisy;
    for (std::size_t i = 0; i < m; ++i)
        if (exceeds_region(noise[i]))
            noisy.push_back(int(i));
    if (noisy.empty())
        return result;
    const NeighbourSearch seed_search(seeds);
    parallel_for(
        m, threads, {},
        [&](std::size_t i)
        {
            std::array<int, asked_seeds> near;
            std::array<double, asked_seeds> squared;
            const int count = seed_search.nearest(seeds[i], asked_seeds, near.data(), squared.data());
            result[i] = looks_like_noise(noise, near.data(), count);
        },
        64);

    // Triangulations cost more than the rest, so only what looks like noise is asked, and every other seed of it.
    Points asked;
    for (std::size_t k = 0; k < noisy.size(); k += 2)
        if (result[std::size_t(noisy[k])])
            asked.push_back(seeds[std::size_t(noisy[k])]);
    const std::vector<double> flat = measure_flat(samples, search, asked, threads);
    const NeighbourSearch asked_search(asked);
    for (std::size_t i = 0; i < m; ++i)
    {
        if (!result[i])
            continue;
        std::array<int, asked_seeds> near;
        std::array<double, asked_seeds> squared;
        const int count = asked_search.nearest(seeds[i], asked_seeds, near.data(), squared.data());
        double sum = 0;
        for (int k = 0; k < count; ++k)
            sum += flat[std::size_t(near[std::size_t(k)])];
        result[i] = count > 0 && sum <= most_flat * count;
    }
    return add_rims(seed_search, seeds, noise, result, threads);
}

} // namespace recon
