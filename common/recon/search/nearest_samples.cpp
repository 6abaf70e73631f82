#include <recon/search/nearest_samples.h>

#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/simd.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recon
{
namespace
{

using simd::HalfLanes;

/// Some samples, ascending, as columns that end in whole lanes, infinitely far ones at the end.
struct Candidates
{
    std::vector<int> index;
    std::vector<double> x, y, z;

    void gather(const Points& samples)
    {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        const std::size_t padded = std::size_t(simd::padded(int(index.size())));
        for (auto* column : {&x, &y, &z})
            column->assign(padded, infinity);
        for (std::size_t k = 0; k < index.size(); ++k)
        {
            const Point& p = samples[index[k]];
            x[k] = p.x();
            y[k] = p.y();
            z[k] = p.z();
        }
    }
};

/// For each of the points the position of the nearest candidate, of equally near ones the first.
RECON_VECTOR_CLONES
void find_nearest(const Point* points, int count, const Candidates& candidates, int* nearest)
{
    const int n = int(candidates.x.size());
    const double *x = candidates.x.data(), *y = candidates.y.data(), *z = candidates.z.data();
    for (int i = 0; i < count; ++i)
    {
        const double px = points[i].x(), py = points[i].y(), pz = points[i].z();
        HalfLanes least = std::numeric_limits<double>::infinity() - HalfLanes{}, at{}, here = {0, 1, 2, 3};
        for (int k = 0; k < n; k += 4, here += 4.0)
        {
            const HalfLanes dx = simd::load_half(x + k) - px, dy = simd::load_half(y + k) - py,
                            dz = simd::load_half(z + k) - pz;
            const HalfLanes d = dx * dx + dy * dy + dz * dz;
            at = d < least ? here : at;
            least = d < least ? d : least;
        }
        int best = 0;
        for (int j = 1; j < 4; ++j)
            if (least[j] < least[best] || (least[j] == least[best] && at[j] < at[best]))
                best = j;
        nearest[i] = int(at[best]);
    }
}

/// The candidates are listed once for a run of points that lie side by side.
class RunSearch
{
public:
    RunSearch(const BlockSearch& search, const Points& samples) : search_(search), samples_(samples) {}

    /// Writes the nearest samples of points [begin, the end of the run). \returns that end.
    std::size_t answer(const Points& points, std::size_t begin, std::size_t end, int* nearest)
    {
        const Point& first = points[begin];
        double offset = last_ >= 0 ? (first - samples_[last_]).norm() : 2 * reach_;
        if (!(offset < 2 * reach_)) // a jump, or the first point
        {
            int index[around];
            double squared[around];
            const int found = search_.nearest(first, around, index, squared);
            offset = std::sqrt(squared[0]);
            reach_ = std::sqrt(squared[found - 1]);
        }
        double farthest = 0;
        std::size_t run = begin + 1;
        for (; run < end && run - begin < longest_run; ++run)
        {
            const double distance = (points[run] - first).norm();
            if (!(distance <= reach_))
                break;
            farthest = std::max(farthest, distance);
        }
        // A point at a distance r from the first one has its nearest sample within 2 r + offset of that one.
        constexpr double rounding = 1 + 1e-9;
        search_.within(first, rounding * (2 * farthest + offset), candidates_.index);
        candidates_.gather(samples_);
        find_nearest(&first, int(run - begin), candidates_, nearest);
        for (std::size_t i = 0; i < run - begin; ++i)
            nearest[i] = candidates_.index[nearest[i]];
        last_ = nearest[run - begin - 1];
        // Only the time depends on the reach.
        if (candidates_.index.size() > most_candidates)
            reach_ /= 1.5;
        else if (candidates_.index.size() < fewest_candidates)
            reach_ *= 1.5;
        return run;
    }

private:
    static constexpr int around = 8;
    static constexpr std::size_t longest_run = 64, fewest_candidates = 24, most_candidates = 72;

    const BlockSearch& search_;
    const Points& samples_;
    Candidates candidates_;
    double reach_ = 0; ///< Of a run.
    int last_ = -1;
};

} // namespace

NearestSamples find_nearest_samples(const Points& points, const Points& samples, int threads, const Progress& progress)
{
    return find_nearest_samples(points, samples, BlockSearch(samples, threads), threads, progress);
}

NearestSamples find_nearest_samples(const Points& points, const Points& samples, const BlockSearch& search, int threads,
                                    const Progress& progress)
{
    constexpr std::size_t grain = 4096;
    NearestSamples result{std::vector<int>(points.size()), std::vector<double>(points.size())};
    parallel_chunks(points.size(), threads, grain, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        RunSearch runs(search, samples);
                        for (std::size_t i = begin; i < end;)
                            i = runs.answer(points, i, end, &result.sample[i]);
                        for (std::size_t i = begin; i < end; ++i)
                            result.squared[i] = (points[i] - samples[result.sample[i]]).squaredNorm();
                    });
    return result;
}

} // namespace recon
