#include <recon/noise.h>

#include <recon/block_search.h>
#include <recon/errors.h>
#include <recon/median.h>
#include <recon/neighbours.h>
#include <recon/noisy_patches.h>
#include <recon/parallel.h>
#include <recon/patch_fit.h>
#include <recon/sheet_stack.h>
#include <recon/spatial_order.h>

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

/// Reorders the values.
double middle_of(double* values, int count)
{
    std::nth_element(values, values + count / 2, values + count);
    return values[count / 2];
}

} // namespace

double NoiseEstimate::median_sigma() const
{
    return median(sigma());
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

constexpr double pi = 3.14159265358979323846;
constexpr int smallest_count = 3 * patch_coefficients;
constexpr int many = 150; // neighbours; beyond it a subsample does
/// Neighbours that are looked at. In noise of nine spacings and more none of so many are a piece of surface: where
/// fewer than half of the seeds have settled four times as many are, up to that share of the cloud.
constexpr int largest_count = 6000, largest_share = 10;
constexpr double growth = 1.5;
/// A neighbourhood this many residual heights wide is a piece of surface rather than the inside of the noise.
constexpr double flatness = 4;
/// The residual at the scale chosen is a little below the noise, since a ball cuts off its tails.
constexpr double truncation = 1.055;
constexpr int smoothing_seeds = 21;
/// A residual that grows more than this from one scale to the next is not noise but shape: a thin part, a crease.
constexpr double settled = 1.2;
constexpr double settled_share = 0.2; // of the seeds; if fewer have settled, all are taken
/// A sheet with twice the noise looks like a part not much thicker than the noise. But noise changes over long
/// distances, so what exceeds that of the region around by more than this is taken for a thin part.
constexpr double largest_excess = 1.2;
constexpr double region_share = 0.2; // of the seeds
constexpr int region_stride = 8;     // of its seeds so many that one is asked
/// Noise above which it may be a stack of sheets [spacings]; of the seeds so many that one is asked.
constexpr double thick = 0.3;
/// Noise above which exact samples among noisy copies look like a sheet of a stack [spacings].
constexpr double very_thick = 3;
constexpr int stack_stride = 4;
/// Share of those asked around that must see a sheet: 0.04 do in thick noise, 0.4 to 0.85 in stacks.
constexpr double stacked_share = 0.3;
/// Both sheets of a plate count as one, and widths that follow from it keep them apart; so two of a stack do.
constexpr double sheets_of_plate = 2;

struct Local
{
    double sigma, density;
    bool settled = true;
    double sheet_sigma = -1;                  ///< Of each of two sheets; negative if there are not two.
    std::optional<StackedSheet> stacked = {}; ///< Only of seeds that are asked.
};

/// What a Gaussian slab shows inside a ball of radius R around its middle: at height z the ball cuts a disc of area
/// pi (R^2 - z^2), so that the variance falls to (1 - 3 t) / (1 - t) and the count to 1 - t, t = sigma^2 / R^2.
Local correct_for_ball(double residual, int count, double radius)
{
    const double squared = std::max(radius * radius, 1e-300);
    double t = 0;
    for (int i = 0; i < 8; ++i)
        t = std::min(1.0 / 9, residual * residual / squared * (1 - t) / (1 - 3 * t));
    return {std::sqrt(t) * radius, count / (pi * squared * (1 - t))};
}

/// The cloud and even subsamples of it: many neighbours of the whole are as well described by fewer of a subsample.
struct Pyramid
{
    static constexpr int step = 4;
    static constexpr std::size_t coarsest = 2000;
    std::vector<Points> levels;
    std::vector<BlockSearch> searches;

    explicit Pyramid(Points points)
    {
        levels.push_back(std::move(points));
        while (levels.back().size() > step * coarsest && levels.size() < 6)
        {
            const Points& finer = levels.back();
            Points coarser;
            for (std::size_t i = step / 2; i < finer.size(); i += step)
                coarser.push_back(finer[i]);
            levels.push_back(std::move(coarser));
        }
        for (const Points& level : levels)
            searches.emplace_back(level);
    }
};

/// Neighbourhoods of one seed at growing scales.
class ScaleLadder
{
public:
    /// \param most neighbours that are looked at.
    ScaleLadder(const Pyramid& pyramid, int most) : pyramid_(pyramid)
    {
        const int all = int(pyramid.levels[0].size());
        // Of a small cloud take a part, or the quadric would have to follow the whole shape.
        limit_ = std::min({all, most, std::max(all / 3, smallest_count)});
        neighbours_.resize(std::size_t(std::max(limit_, most_around_stack)));
        squared_.resize(neighbours_.size());
    }

    /// \param ask_for_stack whether a thick layer may be a stack of sheets.
    Local estimate(const Point& seed, bool ask_for_stack)
    {
        Local result = climb(seed);
        if (ask_for_stack && (!result.settled || result.sigma * std::sqrt(result.density) > thick))
        {
            result.stacked = find_sheet(seed);
            if (result.stacked && result.sigma * std::sqrt(result.density) > very_thick &&
                !has_sheets_beside(*result.stacked))
                result.stacked.reset();
        }
        return result;
    }

private:
    std::optional<StackedSheet> find_sheet(const Point& at)
    {
        const int found = pyramid_.searches[0].nearest(at, most_around_stack, neighbours_.data(), squared_.data());
        return find_stacked_sheet(pyramid_.levels[0], at, neighbours_.data(), squared_.data(), found);
    }

    /// Whether what lies beside a sheet is in sheets as well, which noisy copies of exact samples are not.
    /// \param sheet just found.
    bool has_sheets_beside(const StackedSheet& sheet)
    {
        constexpr std::size_t asked = 4;
        const int reach = std::min(most_around_stack, int(pyramid_.levels[0].size()));
        std::vector<int> beside;
        auto member = sheet.members.begin();
        for (int i = 0; beside.size() < asked && i < reach; ++i)
            if (member != sheet.members.end() && *member == i)
                ++member;
            else
                beside.push_back(neighbours_[i]);
        return std::any_of(beside.begin(), beside.end(),
                           [&](int i) { return find_sheet(pyramid_.levels[0][i]).has_value(); });
    }

    Local climb(const Point& seed)
    {
        double k = smallest_count;
        found_ = 0;
        while (true)
        {
            // Few do where there is little noise.
            measure(seed, k, k < 2 * smallest_count ? k * growth : k * growth * growth * growth);
            if (radius_ >= flatness * fit_.height || k * growth > limit_)
                break;
            k *= growth;
        }
        // Around the foot from now on, where the correction for the ball holds.
        const Point foot = fit_.foot;
        measure(foot, k, k * growth);
        const Local narrow = correct_for_ball(fit_.distance, count_, radius_);
        const double narrow_radius = radius_;
        if (k * growth > limit_)
            return {narrow.sigma, narrow.density, false};
        measure(foot, k * growth, k * growth);
        const Local wide = correct_for_ball(fit_.distance, count_, radius_);
        // What a quadric cannot follow grows with the third power of the radius: the two scales tell it from the noise.
        // Only upwards: of a few clusters of points a quadric leaves too little at first.
        const double ratio = std::pow(radius_ / std::max(narrow_radius, 1e-300), 6);
        const double a = narrow.sigma * narrow.sigma, b = wide.sigma * wide.sigma;
        const double variance = ratio > 1.5 ? std::max(a, (ratio * a - b) / (ratio - 1)) : a;
        // A thin part is as flat as a thick layer of noise, but its residuals keep to both faces.
        const double n = count_ / share_, doubt = std::max(0.5, 1.2 * std::sqrt(24 / n));
        const bool gaussian = fit_.kurtosis >= 3 * (n - 1) / (n + 1) - doubt;
        return {std::sqrt(variance), wide.density, gaussian && wide.sigma <= settled * narrow.sigma,
                radius_ * fit_two_sheets(residuals_)};
    }

    struct Wanted
    {
        std::size_t level;
        int share, count;
    };
    Wanted wanted(double k) const
    {
        Wanted w{0, 1, 0};
        for (double c = k; c > many && w.level + 1 < pyramid_.levels.size();
             c /= Pyramid::step, w.share *= Pyramid::step)
            ++w.level;
        w.count = std::max(1, std::min(int(k), limit_) / w.share);
        return w;
    }

    /// Makes the neighbours for `k` ready, and those for up to `largest` if they come from the same subsample.
    void find_neighbours(const Point& centre, double k, double largest)
    {
        const Wanted now = wanted(k), later = wanted(largest);
        if (found_ >= now.count && level_ == now.level && centre_ == centre)
            return;
        const int count = later.level == now.level ? later.count : now.count;
        if (reach_ > 0) // of the search before, among neighbours of another number
            reach_ *= std::sqrt(double(count * now.share) / reach_count_);
        reach_count_ = count * now.share;
        level_ = now.level;
        centre_ = centre;
        found_ = pyramid_.searches[level_].nearest(centre, count, neighbours_.data(), squared_.data(), reach_);
    }

    void measure(const Point& centre, double k, double largest)
    {
        find_neighbours(centre, k, largest);
        const Wanted w = wanted(k);
        const int count = std::min(w.count, found_);
        radius_ = std::sqrt(squared_[count - 1]);
        fit_ = fit_patch(pyramid_.levels[level_], centre, neighbours_.data(), count, radius_, residuals_);
        count_ = count * w.share;
        share_ = w.share;
    }

    const Pyramid& pyramid_;
    std::vector<int> neighbours_;
    std::vector<double> squared_;
    int limit_ = 0;
    PatchFit fit_{};
    std::vector<PatchResidual> residuals_; ///< Of the last fit.
    double radius_ = 0;
    int count_ = 0, share_ = 1;
    Point centre_ = Point::Zero(); ///< Of the neighbours at hand.
    std::size_t level_ = 0;
    int found_ = 0;
    double reach_ = 0; ///< Only saves time.
    int reach_count_ = 1;
};

/// \param most neighbours that are looked at. \returns what each seed sees.
std::vector<Local> look_around(const Points& seeds, const Pyramid& pyramid, int most, int threads,
                               const Progress& progress)
{
    std::vector<Local> raw(seeds.size());
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
std::vector<int> list_settled(const std::vector<Local>& raw)
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
void take_noise_of_patches(const Points& seeds, const std::vector<Local>& raw, const std::vector<int>& settled,
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

/// Medians over the seeds around each: noise of the settled ones, at most somewhat more than that of the region but in
/// noisy patches, where noisy seeds speak for noisy ones, or, where most see two sheets, that of each sheet; density of
/// all. \param scale of the unit frame. \param samples the cloud.
Pooled pool(const Points& samples, const BlockSearch& sample_search, const Points& seeds, const std::vector<Local>& raw,
            double scale, int threads)
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
    const NeighbourSearch seed_search(seeds), settled_search(settled_seeds), region_search(region_seeds);
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
                            const double around = median_of(of_region, [&](int k) { return region_sigma[k]; });
                            const double dense = median_of(of_region, [&](int k) { return region_density[k]; });
                            limit[i] = largest_excess * around;
                            const int of_all = find(seed_search, i, smoothing_seeds);
                            result.density[i] = median_of(of_all, [&](int k) { return raw[k].density; });
                            known[i] = {raw[i].sigma,         around,         1 / std::sqrt(raw[i].density),
                                        1 / std::sqrt(dense), raw[i].settled, raw[i].sheet_sigma >= 0};
                        }
                    });
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

/// Where many of those seeds that were asked see stacked sheets: noise and density of one.
void take_one_of_stack(const Points& seeds, const std::vector<Local>& raw, double scale, int threads, Pooled& pooled)
{
    Points asked_seeds;
    std::vector<const std::optional<StackedSheet>*> sheets;
    bool has_stacks = false;
    for (std::size_t i = 0; i < seeds.size(); i += stack_stride)
    {
        asked_seeds.push_back(seeds[i]);
        sheets.push_back(&raw[i].stacked);
        has_stacks = has_stacks || raw[i].stacked;
    }
    if (!has_stacks)
        return;
    const NeighbourSearch search(asked_seeds);
    const auto correct = [&](std::size_t i)
    {
        std::array<int, smoothing_seeds> near;
        std::array<double, smoothing_seeds> squared, sigma, density;
        const int asked = search.nearest(seeds[i], smoothing_seeds, near.data(), squared.data());
        int stacked = 0;
        for (int k = 0; k < asked; ++k)
            if (const auto& sheet = *sheets[std::size_t(near[k])])
            {
                sigma[stacked] = sheet->sigma;
                density[stacked++] = sheet->density;
            }
        if (stacked <= stacked_share * asked)
            return;
        pooled.sigma[i] = std::min(pooled.sigma[i], scale * middle_of(sigma.data(), stacked));
        pooled.density[i] =
            std::min(pooled.density[i], sheets_of_plate * middle_of(density.data(), stacked) / scale / scale);
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

    const SpatialOrder spatial = order_spatially(points);
    const int n = int(spatial.order.size());
    Points unit(n);
    for (int i = 0; i < n; ++i)
        unit[i] = frame.to_unit(points[spatial.order[i]]);

    const int wanted = options.seeds > 0 ? options.seeds : std::clamp(n / 25, 1000, 3000);
    const int m = std::min(n, wanted);
    Points seeds(m);
    for (int i = 0; i < m; ++i)
        seeds[i] = unit[std::size_t((i + 0.5) * n / m)];
    const Pyramid pyramid(std::move(unit));
    std::vector<Local> raw;
    double left = 1; // of the progress
    for (int most = largest_count;; most *= 4, left /= 2)
    {
        raw = look_around(seeds, pyramid, most, threads, progress.part(1 - left, 1 - left / 2));
        const auto settled = std::count_if(raw.begin(), raw.end(), [](const Local& l) { return l.settled; });
        if (2 * settled >= m || 4 * most > n / largest_share)
            break;
    }
    Pooled pooled = pool(pyramid.levels[0], pyramid.searches[0], seeds, raw, frame.scale(), threads);
    take_one_of_stack(seeds, raw, frame.scale(), threads, pooled);
    progress.report(1);
    frame.from_unit_in_place(seeds);
    return NoiseEstimate(std::move(seeds), std::move(pooled.sigma), std::move(pooled.density));
}

} // namespace recon
