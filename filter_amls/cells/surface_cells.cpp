#include "surface_cells.h"

#include "scattered_points.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon
{
namespace
{

/// Share of the points: fewer outliers are not worth another look.
constexpr double few_outliers = 0.001;
/// Share of the points from which on outliers are company of each other. Fewer are nearly all found alone; to look for
/// more like them would cost parts that are sparser than they are.
constexpr double many_outliers = 0.05;
constexpr int most_looks = 5;
/// Widths from the nearest other cell from which an outlier is no part of a thin, sparse wall.
constexpr double far_off = 3;
/// Share of the error of rounding to a step below which the estimate looked at one step alone.
constexpr double within_step = 0.3;

struct Outlier
{
    int point;        ///< Its index.
    LocalScale scale; ///< Of its cell when it was found.
};

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
        const double error = camera.step_at(estimate.seeds()[i]) / std::sqrt(12.0);
        if (sigma[i] < within_step * error && camera.is_in_step(estimate.seeds()[i], points, search))
            sigma[i] = error;
    }
    return NoiseEstimate(estimate.seeds(), std::move(sigma), estimate.density());
}

/// Of dithered points, with the lattice's own error in the place of the dither's.
NoiseEstimate with_lattice(const NoiseEstimate& estimate, double error)
{
    const double dithered = estimate_of_dithered * error;
    std::vector<double> sigma = estimate.sigma();
    for (double& s : sigma)
        s = std::sqrt(error * error + std::max(0.0, s * s - dithered * dithered));
    return NoiseEstimate(estimate.seeds(), std::move(sigma), estimate.density());
}

/// How many of the outliers lie far from everything else.
int count_far(const std::vector<int>& outliers, const Points& points, const SurfaceCells& made)
{
    const Cells& cells = made.cells;
    std::vector<char> is_sound(std::size_t(cells.size()), 1);
    for (const int i : outliers)
        is_sound[std::size_t(cells.cell_of_point[std::size_t(i)])] = 0;
    Points means;
    std::vector<double> reach;
    for (std::size_t c = 0; c < is_sound.size(); ++c)
        if (is_sound[c])
        {
            means.push_back(cells.means[c]);
            reach.push_back(far_off * cells.scales[c].width);
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

SurfaceCells make_cells(const Points& points, const BlockSearch& search, double given_noise, const Rounding& rounding,
                        int threads, PhaseTimes& times, const Progress& progress)
{
    times.begin("noise");
    NoiseOptions options;
    options.threads = threads;
    const bool on_lattice = given_noise == 0 && rounding.lattice_step > 0;
    const Points dithered = on_lattice ? rounding.dither(points) : Points();
    const Progress part = progress.part(0, 0.15, "Noise");
    SurfaceCells made{estimate_noise(on_lattice ? dithered : points, options, part), {}, {}, {}};
    if (given_noise > 0)
        made.noise = with_given_noise(made.noise, given_noise);
    else if (on_lattice)
        made.noise = with_lattice(made.noise, rounding.lattice_error);
    else if (rounding.camera)
        made.noise = with_steps(made.noise, *rounding.camera, points, search);
    times.begin("width");
    const LocalScales scales = choose_widths(points, search, made.noise, threads, progress.part(0.15, 0.45, "Width"));
    times.begin("cells");
    made.cells = average_cells(points, scales, threads, progress.part(0.45, 0.6, "Cells"));
    made.search = BlockSearch(made.cells.means, threads);
    times.begin("normals");
    made.normals = estimate_cell_normals(made.cells, made.search, threads, progress.part(0.6, 1, "Normals"));
    return made;
}

SurfaceCells make_surface_cells(const Points& points, const BlockSearch& search, double given_noise,
                                const Rounding& rounding, int threads, PhaseTimes& times, const Progress& progress)
{
    double done = 0.6;
    SurfaceCells made = make_cells(points, search, given_noise, rounding, threads, times, progress.part(0, done));
    const double few = few_outliers * double(points.size()), most = most_outliers * double(points.size());
    std::vector<Outlier> outliers;
    std::vector<int> remaining; // the other points, once there are outliers
    Points rest;
    BlockSearch rest_search;
    bool are_many = true;
    for (int look = 1; look < (are_many ? most_looks : 2); ++look)
    {
        const bool is_first = outliers.empty();
        const double looked = 0.9 * done + 0.1, half_way = 0.5 * done + 0.5;
        const Points& seen = is_first ? points : rest;
        std::vector<int> more = list_outliers(made.cells, made.normals);
        if (double(more.size()) < few)
            break;
        if (is_first)
            are_many = double(more.size()) > many_outliers * double(points.size());
        if (are_many)
            more = with_scattered_points(seen, is_first ? search : rest_search, std::move(more), threads,
                                         progress.part(done, looked, "Outliers"));
        if (count_far(more, seen, made) < few || double(outliers.size() + more.size()) > most)
            break;
        for (const int i : more)
            outliers.push_back({is_first ? i : remaining[std::size_t(i)],
                                made.cells.scales[std::size_t(made.cells.cell_of_point[std::size_t(i)])]});
        std::sort(outliers.begin(), outliers.end(),
                  [](const Outlier& a, const Outlier& b) { return a.point < b.point; });
        std::vector<int> indices;
        for (const Outlier& outlier : outliers)
            indices.push_back(outlier.point);
        remaining = list_others(points.size(), indices);
        rest = points_at(remaining, points);
        rest_search = BlockSearch(rest, threads);
        made = make_cells(rest, rest_search, given_noise, rounding, threads, times, progress.part(looked, half_way));
        done = half_way;
    }
    if (outliers.empty())
        return made;
    Cells& cells = made.cells;
    std::vector<int> cell_of_point(points.size());
    for (std::size_t i = 0; i < remaining.size(); ++i)
        cell_of_point[std::size_t(remaining[i])] = cells.cell_of_point[i];
    for (const Outlier& outlier : outliers)
    {
        const Point& point = points[std::size_t(outlier.point)];
        cell_of_point[std::size_t(outlier.point)] = cells.size();
        cells.means.push_back(point);
        cells.counts.push_back(1);
        cells.scales.push_back(outlier.scale);
        cells.seeds.push_back(-1);
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
