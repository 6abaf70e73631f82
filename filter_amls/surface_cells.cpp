#include "surface_cells.h"

#include <cmath>
#include <utility>

namespace recon
{
namespace
{

/// Shares of the points: fewer outliers are not worth a second look, more are no outliers.
constexpr double few_outliers = 0.001, many_outliers = 0.3;
/// Widths from the nearest other cell from which an outlier is no part of a thin, sparse wall.
constexpr double far_off = 3;
/// Share of the error of rounding to a step below which the estimate looked at one step alone.
constexpr double within_step = 0.3;

/// The noise the user gave in place of the estimate's.
NoiseEstimate with_given_noise(const NoiseEstimate& estimate, double sigma)
{
    return NoiseEstimate(estimate.seeds(), std::vector<double>(std::size_t(estimate.size()), sigma),
                         estimate.density());
}

/// With the error of rounding where all around lie in one step of the camera's.
NoiseEstimate with_steps(const NoiseEstimate& estimate, const DepthCamera& camera, const Points& points,
                         const BlockSearch& search)
{
    std::vector<double> sigma = estimate.sigma();
    for (std::size_t i = 0; i < sigma.size(); ++i)
    {
        const double rounding = camera.step_at(estimate.seeds()[i]) / std::sqrt(12.0);
        if (sigma[i] < within_step * rounding && camera.is_in_step(estimate.seeds()[i], points, search))
            sigma[i] = rounding;
    }
    return NoiseEstimate(estimate.seeds(), std::move(sigma), estimate.density());
}

/// How many of the outliers lie far from everything else.
int count_far(const std::vector<int>& outliers, const Points& points, const SurfaceCells& made)
{
    const Cells& cells = made.cells;
    Points means;
    std::vector<double> reach;
    for (int c = 0; c < cells.size(); ++c)
        if (made.normals.kinds[std::size_t(c)] != CellKind::outlier)
        {
            means.push_back(cells.means[std::size_t(c)]);
            reach.push_back(far_off * cells.scales[std::size_t(c)].width);
        }
    const BlockSearch search(means);
    int far = 0;
    for (const int i : outliers)
    {
        const int nearest = search.nearest(points[std::size_t(i)]);
        far +=
            nearest >= 0 && (means[std::size_t(nearest)] - points[std::size_t(i)]).norm() > reach[std::size_t(nearest)];
    }
    return far;
}

} // namespace

std::vector<int> list_outliers(const Cells& cells, const CellNormals& normals)
{
    std::vector<int> outliers;
    for (std::size_t i = 0; i < cells.cell_of_point.size(); ++i)
        if (normals.kinds[std::size_t(cells.cell_of_point[i])] == CellKind::outlier)
            outliers.push_back(int(i));
    return outliers;
}

SurfaceCells make_cells(const Points& points, const BlockSearch& search, double given_noise,
                        const std::optional<DepthCamera>& camera, int threads, PhaseTimes& times,
                        const Progress& progress)
{
    times.begin("noise");
    NoiseOptions options;
    options.threads = threads;
    SurfaceCells made{estimate_noise(points, options, progress.part(0, 0.15, "Noise")), {}, {}, {}};
    if (given_noise > 0)
        made.noise = with_given_noise(made.noise, given_noise);
    else if (camera)
        made.noise = with_steps(made.noise, *camera, points, search);
    times.begin("width");
    const LocalScales scales = choose_widths(points, search, made.noise, threads, progress.part(0.15, 0.45, "Width"));
    times.begin("cells");
    made.cells = average_cells(points, scales, threads, progress.part(0.45, 0.6, "Cells"));
    made.search = BlockSearch(made.cells.means, threads);
    times.begin("normals");
    made.normals = estimate_cell_normals(made.cells, made.search, threads, progress.part(0.6, 1, "Normals"));
    return made;
}

SurfaceCells make_cells_twice(const Points& points, const BlockSearch& search, double given_noise,
                              const std::optional<DepthCamera>& camera, int threads, PhaseTimes& times,
                              const Progress& progress)
{
    SurfaceCells first = make_cells(points, search, given_noise, camera, threads, times, progress.part(0, 0.6));
    const std::vector<int> outliers = list_outliers(first.cells, first.normals);
    const auto few = few_outliers * double(points.size()), many = many_outliers * double(points.size());
    if (double(outliers.size()) > many || double(outliers.size()) < few || count_far(outliers, points, first) < few)
        return first;
    const std::vector<int> others = list_others(points.size(), outliers);
    const Points rest = points_at(others, points);
    SurfaceCells made =
        make_cells(rest, BlockSearch(rest, threads), given_noise, camera, threads, times, progress.part(0.6, 1));
    Cells& cells = made.cells;
    std::vector<int> cell_of_point(points.size());
    for (std::size_t i = 0; i < rest.size(); ++i)
        cell_of_point[std::size_t(others[i])] = cells.cell_of_point[i];
    for (const int i : outliers)
    {
        const Point& point = points[std::size_t(i)];
        cell_of_point[std::size_t(i)] = cells.size();
        cells.means.push_back(point);
        cells.counts.push_back(1);
        cells.scales.push_back(first.cells.scales[std::size_t(first.cells.cell_of_point[std::size_t(i)])]);
        made.normals.normals.push_back(Vector::UnitZ());
        made.normals.feet.push_back(point);
        made.normals.mass.push_back(0);
        made.normals.company.push_back(0);
        made.normals.kinds.push_back(CellKind::outlier);
        made.normals.widening.push_back(1);
    }
    cells.cell_of_point = std::move(cell_of_point);
    made.search = BlockSearch(cells.means, threads);
    return made;
}

} // namespace recon
