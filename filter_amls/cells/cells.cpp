#include "cells.h"

#include "filter_amls/fits/runs.h"
#include "filter_amls/fits/weighted_sums.h"
#include "sparse_parts.h"
#include "voxel_table.h"

#include <recon/parallel.h>
#include <recon/search/block_search.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr double cell_edge = 0.6;    // widths
constexpr double normal_cut = 2.3;   // normal widths
constexpr double normal_points = 30; // effective points that a normal needs
constexpr double least_spread = 0.3; // of the variance that a filled window has
constexpr double widening_step = 1.4;
constexpr int most_widenings = 3;
constexpr double isolated_company = 0.2;
constexpr double detail_radius = 1.9, detail_sigmas = 1.5; // spacings, and so much of the noise
constexpr double sparse_width = 1.6;                       // spacings: width of a sparse part beside a dense one,
constexpr double empty_width = 2;                          // whose own width is so much narrower than these spacings
constexpr double stray_mass = 0.5, stray_share = 0.3, stray_radius = 4.5; // radius in sigmas
constexpr double run_radius = 0.9;                                        // widths
constexpr int longest_run = 32, longest_seed_run = 64;

/// Width of the plane fits: somewhat below the width of the surface, or as few points as a normal needs.
double normal_width(const LocalScale& s)
{
    return std::max(0.6 * s.width, std::min(0.8 * s.width, std::sqrt(normal_points / (2 * pi * s.density))));
}

/// Fits the planes of cells, run by run.
class PlaneFitter
{
public:
    PlaneFitter(const Cells& cells, const BlockSearch& search) : cells_(cells), search_(search) {}

    void fit(const Run& run, CellNormals& result)
    {
        const double reach =
            largest_in(run, [&](int c) { return reach_of(normal_width(cells_.scales[c]), cells_.scales[c]); });
        search_.within(run.centre, run.radius + reach, found_);
        around_run_.gather(cells_.means, cells_.counts, found_, run.centre);
        for (int c = run.begin; c < run.end; ++c)
        {
            const LocalScale& scale = cells_.scales[c];
            double h = normal_width(scale);
            Point foot = cells_.means[c] - run.centre, origin = run.centre;
            WeightedPlane plane = fit_at_foot(around_run_, foot, h);
            // Where points are much sparser than around, the window holds one clump, which has no direction.
            for (int i = 0; i < most_widenings && is_clump(plane, h, scale); ++i)
            {
                h *= widening_step;
                result.widening[c] *= widening_step;
                origin = cells_.means[c];
                foot = Point::Zero();
                search_.within(origin, reach_of(h, scale), found_);
                around_cell_.gather(cells_.means, cells_.counts, found_, origin);
                plane = fit_at_foot(around_cell_, foot, h);
            }
            result.normals[c] = plane.normal;
            result.feet[c] = origin + foot;
            const double slab = std::sqrt(1 + 2 * scale.sigma * scale.sigma / (h * h));
            const double full = pi * h * h * scale.density / slab;
            result.mass[c] = plane.mass / full;
            result.company[c] = (plane.mass - cells_.counts[c]) / full;
        }
    }

private:
    /// The variance that noise alone gives a clump, or somewhat more, in place of what a window full of points has.
    static bool is_clump(const WeightedPlane& plane, double h, const LocalScale& scale)
    {
        return plane.spread < std::min(least_spread * 0.5 * h * h, 2.5 * scale.sigma * scale.sigma);
    }

    static double reach_of(double h, const LocalScale& scale) { return normal_cut * h + 2 * scale.sigma; }

    /// Plane by principal directions, twice, the second time around the foot of the first; moves `foot` onto it.
    static WeightedPlane fit_at_foot(const Gathered& gathered, Point& foot, double h)
    {
        WeightedPlane plane;
        for (int i = 0; i < 2; ++i)
        {
            plane = fit_plane(gathered, foot, h, normal_cut);
            foot += plane.normal * plane.normal.dot(plane.mean - foot);
        }
        return plane;
    }

    const Cells& cells_;
    const BlockSearch& search_;
    std::vector<int> found_;
    Gathered around_run_, around_cell_;
};

/// Sees to cells with hardly any others within their width that belong to a sparse part beside a dense one, whose
/// scales they have by their seed: where the width holds none of the part's samples, scales are replaced and planes
/// fitted again.
void rescale_sparse_parts(Cells& cells, const BlockSearch& search, CellNormals& result, int threads)
{
    std::vector<int> lonely;
    for (int c = 0; c < cells.size(); ++c)
        if (result.company[c] < isolated_company)
            lonely.push_back(c);
    const std::vector<LonelyCell> found = find_sparse_parts(cells, search, lonely, threads);
    PlaneFitter fitter(cells, search);
    for (std::size_t k = 0; k < lonely.size(); ++k)
    {
        if (!found[k].belongs)
            continue;
        const int c = lonely[k];
        LocalScale& scale = cells.scales[c];
        const double spacing = found[k].spacing;
        if (spacing > empty_width * scale.width * result.widening[c])
        {
            scale.density = std::min(scale.density, cells.counts[c] / (spacing * spacing));
            scale.width = std::max(scale.width, sparse_width * spacing);
            cells.seeds[c] = -1;
            result.widening[c] = 1;
            fitter.fit({c, c + 1, cells.means[c], 0}, result);
        }
        result.company[c] = std::max(result.company[c], isolated_company);
    }
}

/// Calls cells outliers that have no company, nor anyone near by who has.
void find_outliers(const Cells& cells, const BlockSearch& search, CellNormals& result, int threads,
                   const Progress& progress)
{
    parallel_chunks(std::size_t(cells.size()), threads, 1024, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> found;
                        for (std::size_t c = begin; c < end; ++c)
                        {
                            if (result.company[c] >= isolated_company)
                                continue;
                            const LocalScale& scale = cells.scales[c];
                            // Near others noise or detail may explain it.
                            search.within(
                                cells.means[c],
                                std::max(stray_radius * scale.sigma,
                                         detail_radius / std::sqrt(scale.density) + detail_sigmas * scale.sigma),
                                found);
                            if (std::none_of(found.begin(), found.end(),
                                             [&](int i) { return result.company[i] >= isolated_company; }))
                                result.kinds[c] = CellKind::outlier;
                        }
                    });
}

/// Per cell in the tails of the noise the neighbour that knows the surface better, -1 for others.
std::vector<int> find_better_than_strays(const Cells& cells, const BlockSearch& search, const CellNormals& result,
                                         int threads)
{
    std::vector<int> better(std::size_t(cells.size()), -1);
    parallel_chunks(better.size(), threads, 1024, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> found;
                        for (std::size_t c = begin; c < end; ++c)
                        {
                            if (result.kinds[c] == CellKind::outlier || result.mass[c] >= stray_mass)
                                continue;
                            const double sigma = cells.scales[c].sigma;
                            search.within(cells.means[c], stray_radius * sigma, found);
                            double largest = 0, best = 0;
                            for (int i : found)
                            {
                                if (result.kinds[i] == CellKind::outlier)
                                    continue;
                                largest = std::max(largest, result.mass[i]);
                                const double squared = (cells.means[i] - cells.means[c]).squaredNorm();
                                const double score = result.mass[i] * std::exp(-squared / (8 * sigma * sigma));
                                if (score > best)
                                {
                                    best = score;
                                    better[c] = i;
                                }
                            }
                            if (result.mass[c] >= stray_share * largest)
                                better[c] = -1;
                        }
                    });
    return better;
}

/// Strays take over normals and feet from regular cells only, so the order in which they are found does not matter.
void replace_strays(const std::vector<int>& better, CellNormals& result)
{
    const Vectors normals = result.normals;
    const Points feet = result.feet;
    for (std::size_t c = 0; c < better.size(); ++c)
        if (better[c] >= 0)
        {
            result.kinds[c] = CellKind::stray;
            result.normals[c] = normals[better[c]];
            result.feet[c] = feet[better[c]];
        }
}

} // namespace

Cells average_cells(const Points& points, const LocalScales& scales, int threads, const Progress& progress)
{
    const std::size_t n = points.size();
    // One seed for points that lie close together compared with the distance of seeds.
    const std::vector<Run> runs = split_into_runs(points, longest_seed_run, [&](int) { return scales.seed_reach; });
    std::vector<int> seed(n);
    parallel_for(
        runs.size(), threads, progress,
        [&](std::size_t r)
        {
            const int nearest = scales.seeds.nearest_seed(runs[r].centre);
            std::fill(seed.begin() + runs[r].begin, seed.begin() + runs[r].end, nearest);
        },
        1024);

    std::vector<int> level(scales.at_seed.size());
    std::vector<double> inverse_edge(scales.at_seed.size());
    for (std::size_t s = 0; s < level.size(); ++s)
    {
        level[s] = int(std::lround(2 * std::log2(cell_edge * scales.at_seed[s].width)));
        inverse_edge[s] = VoxelTable::inverse_edge(level[s]);
    }
    Cells cells;
    cells.cell_of_point.resize(n);
    VoxelTable voxels(n / 2);
    Vectors offsets; // from the first point, so that nothing cancels
    std::vector<int> first;
    for (std::size_t i = 0; i < n; ++i)
    {
        const int s = seed[i], c = voxels.find_or_add(points[i], level[s], inverse_edge[s]);
        if (c == int(first.size()))
        {
            first.push_back(int(i));
            offsets.push_back(Vector::Zero());
            cells.counts.push_back(0);
        }
        offsets[c] += points[i] - points[first[c]];
        cells.counts[c] += 1;
        cells.cell_of_point[i] = c;
    }
    for (std::size_t c = 0; c < first.size(); ++c)
    {
        cells.means.push_back(points[first[c]] + offsets[c] / cells.counts[c]);
        cells.seeds.push_back(seed[first[c]]);
        cells.scales.push_back(scales.at_seed[cells.seeds[c]]);
    }
    return cells;
}

CellNormals estimate_cell_normals(Cells& cells, const BlockSearch& search, int threads, const Progress& progress)
{
    const int n = cells.size();
    CellNormals result;
    result.normals.assign(n, Vector::UnitZ());
    result.feet = cells.means;
    result.mass.assign(n, 0);
    result.company.assign(n, 0);
    result.kinds.assign(n, CellKind::regular);
    result.widening.assign(n, 1);

    const std::vector<Run> runs =
        split_into_runs(cells.means, longest_run, [&](int i) { return run_radius * cells.scales[i].width; });
    visit_runs(
        runs, threads, progress.part(0, 0.8, "Normals"), [&] { return PlaneFitter(cells, search); },
        [&](PlaneFitter& fitter, const Run& run) { fitter.fit(run, result); });

    rescale_sparse_parts(cells, search, result, threads);
    find_outliers(cells, search, result, threads, progress.part(0.8, 1, "Normals"));
    replace_strays(find_better_than_strays(cells, search, result, threads), result);
    return result;
}

} // namespace recon
