#pragma once

#include <recon/geometry.h>
#include <recon/noise/patch_fit.h>
#include <recon/noise/sheet_stack.h>
#include <recon/search/block_search.h>

#include <optional>
#include <vector>

namespace recon
{

/// What a neighbourhood tells of a place.
struct LocalNoise
{
    double sigma;        ///< Standard deviation of the points' distances to their quadric [length].
    double density;      ///< Points per area [1 / length^2].
    bool settled = true; ///< Whether that is noise and not shape.
    std::optional<TwoSheets> sheets = {};
    std::optional<StackedSheet> stacked = {}; ///< Only of places that are asked.
};

/// The cloud and even subsamples of it: many neighbours of the whole are as well described by fewer of a subsample.
struct CloudPyramid
{
    static constexpr int step = 4;
    static constexpr std::size_t coarsest = 2000;
    std::vector<Points> levels;
    std::vector<BlockSearch> searches;

    CloudPyramid(Points points, int threads);
};

/// Neighbourhoods of one place at growing scales, until one is a piece of surface rather than the inside of the noise.
/// One per thread. Keeps a reference.
class ScaleLadder
{
public:
    /// \param most neighbours that are looked at.
    ScaleLadder(const CloudPyramid& pyramid, int most);

    /// \param ask_for_stack whether a thick layer may be a stack of sheets.
    LocalNoise estimate(const Point& seed, bool ask_for_stack);
    /// The same of a neighbourhood of many fibres, see noisy_fibres.h, each of which counts as few points. \param reach
    /// its radius.
    LocalNoise estimate_over_fibres(const Point& seed, double reach);
    /// The same of a neighbourhood of several noisy lines, see noisy_lines.h, as dense as if points were as far apart
    /// along these. \param reach its radius.
    LocalNoise estimate_across_lines(const Point& seed, double reach);

private:
    struct Wanted
    {
        std::size_t level;
        int share, count;
    };

    /// \param least radius.
    LocalNoise climb(const Point& seed, double least = 0);
    std::optional<StackedSheet> find_sheet(const Point& at);
    /// Whether what lies beside a sheet is in sheets as well, which noisy copies of exact samples are not.
    /// \param sheet just found.
    bool has_sheets_beside(const StackedSheet& sheet);
    Wanted wanted(double k) const;
    /// Makes the neighbours for `k` ready, and those for up to `largest` if they come from the same subsample.
    void find_neighbours(const Point& centre, double k, double largest);
    void measure(const Point& centre, double k, double largest);

    const CloudPyramid& pyramid_;
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

} // namespace recon
