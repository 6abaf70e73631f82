#include "surface.h"

#include "filter_amls/cells/anchors.h"
#include "filter_amls/cells/cell_sides.h"
#include "filter_amls/cells/surface_cells.h"
#include "filter_amls/fits/robust_scale.h"
#include "filter_amls/paper/feature_size.h"
#include "filter_amls/sides/face_cameras.h"
#include "filter_amls/sides/orient.h"
#include "filter_amls/sides/sides_of_thin_walls.h"
#include "filter_amls/sides/turn_pieces.h"
#include "project.h"
#include "surface_data.h"

#include <recon/errors.h>
#include <recon/median.h>
#include <recon/mesh/level_sheet.h>
#include <recon/parallel.h>
#include <recon/scan/depth_image.h>
#include <recon/scan/viewpoint.h>
#include <recon/search/block_search.h>
#include <recon/search/nearest_samples.h>
#include <recon/search/neighbours.h>
#include <recon/search/spatial_order.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace recon
{
namespace
{

constexpr double fine_spacing = 0.5; // widths: how far a cell without landmark listens
/// Least noise [spacings] from which widths are chosen again. What clean clouds read as noise, up to 0.086 but for the
/// coarsest, is shape, which wider fits would round; noise of 0.1 % of coarse models is 0.123 and more.
constexpr double noisy = 0.1;
/// For choose_fit_widths(): with the first, bores of three spacings stay open in a crust; with the second, projected
/// points err less on sharp models.
constexpr double labels_clearance = 1.5, projection_clearance = 0.35;
/// By how much the width of a fit grows at most where the window holds fewer points than its width was chosen for: in
/// sparse places, at rims, and along edges, beyond which none count.
constexpr double most_growth = 1.3;
constexpr double narrowest_spacings = 1.2; // a width by rho_e below it would find no neighbours
constexpr int reported_sizes = 2000;       // places of which the median rho_e is told
constexpr double widest = 0.25;            // diagonals
const double rho_per_width = std::pow(2.0, 0.25);

void check_options(const Points& points, const AmlsOptions& options, const Vectors& normals)
{
    const auto good = [](double value) { return value >= 0 && std::isfinite(value); };
    if (!good(options.rho_e))
        throw InvalidInput("rho_e must be 0 (automatic) or a positive number; the paper uses 0.75.");
    if (!good(options.noise))
        throw InvalidInput("The noise must be 0 (estimate) or a positive length.");
    if (!normals.empty() && normals.size() != points.size())
        throw InvalidInput("There are " + std::to_string(normals.size()) + " normals for " +
                           std::to_string(points.size()) + " points; there must be one each, or none.");
}

/// Signs of all cells' normals: those on a plain piece of surface from its landmark, then the others from the oriented
/// ones around them.
void orient_cells(const Cells& cells, const Points& feet, const AnchorChoice& choice, const Vectors& landmark_normals,
                  Vectors& normals, int threads)
{
    constexpr int voters = 8;
    constexpr double clear_cosine = 0.7;
    for (std::size_t l = 0; l < choice.landmarks.size(); ++l)
        normals[choice.landmarks[l]] = landmark_normals[l];
    std::vector<char> known(normals.size(), 0);
    for (const int c : choice.landmarks)
        known[c] = 1;
    for (int c = 0; c < cells.size(); ++c)
        if (choice.landmark_of_cell[c] >= 0 && !known[c])
        {
            const double cosine = normals[c].dot(landmark_normals[choice.landmark_of_cell[c]]);
            known[c] = std::abs(cosine) >= clear_cosine;
            if (cosine < 0)
                normals[c] = -normals[c];
        }
    std::vector<char> asked(normals.size(), 0);
    for (const auto* list : {&choice.landmarks, &choice.anchors})
        for (const int c : *list)
            asked[c] = 1;
    Points positions;
    Vectors directions;
    for (int c = 0; c < cells.size(); ++c)
        if (asked[c] && known[c])
        {
            positions.push_back(feet[c]);
            directions.push_back(normals[c]);
        }
    const BlockSearch search(positions, threads);
    parallel_for(
        std::size_t(cells.size()), threads, {},
        [&](std::size_t c)
        {
            if (known[c])
                return;
            int near[voters];
            double squared[voters];
            const double h = fine_spacing * cells.scales[c].width;
            double reach = 2.5 * h;
            const int count = search.nearest(feet[c], voters, near, squared, reach);
            double vote = 0;
            for (int k = 0; k < count; ++k)
            {
                // Around the nearest one, so that a far cell hears it at all.
                const double weight = std::exp(-(squared[k] - squared[0]) / (h * h));
                vote += weight * normals[c].dot(directions[near[k]]);
            }
            if (vote < 0)
                normals[c] = -normals[c];
        },
        1024);
}

/// Signs from given normals: the sum over each cell's points decides.
void orient_by_given(const Cells& cells, const Vectors& given, Vectors& normals)
{
    Vectors sums(normals.size(), Vector::Zero());
    for (std::size_t i = 0; i < given.size(); ++i)
    {
        const double length = given[i].norm();
        if (length > 0 && std::isfinite(length))
            sums[cells.cell_of_point[i]] += given[i] / length;
    }
    for (std::size_t c = 0; c < normals.size(); ++c)
        if (sums[c].dot(normals[c]) < 0)
            normals[c] = -normals[c];
}

/// Whether what is open is a terrain that faces down.
bool faces_down(const Points& points, const Orientation& orientation, const std::vector<double>& spacing)
{
    const Vectors normals = times_area(orientation.normals, spacing);
    Points open;
    Vectors normals_of_open;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!orientation.is_closed[i])
        {
            open.push_back(points[i]);
            normals_of_open.push_back(normals[i]);
        }
    return !open.empty() && is_upside_down(open, normals_of_open);
}

/// Sides of the landmarks, from which all cells take theirs, or from given normals. \param find_viewpoints finds those
/// of an open sheet.
Orientation orient(AmlsSurface::Data& data, const AnchorChoice& choice,
                   const std::function<Viewpoints(const Progress&)>& find_viewpoints, const Vectors& given_normals,
                   int threads, const Progress& progress)
{
    CellNormals& normals = data.cell_normals;
    Points landmarks;
    Vectors landmark_normals;
    for (const int c : choice.landmarks)
    {
        landmarks.push_back(normals.feet[c]);
        landmark_normals.push_back(normals.normals[c]);
    }
    Orientation orientation = orient_normals(landmarks, landmark_normals, choice.landmark_spacing, threads,
                                             progress.part(0, 0.5, "Orientation"));
    Points& seen_from = data.report.seen_from;
    if (orientation.open)
    {
        const Viewpoints viewpoints = find_viewpoints(progress.part(0.5, 0.6, "Places of scanners"));
        seen_from = viewpoints.places();
        if (!viewpoints.empty())
            face_cameras(viewpoints.in(data.frame), landmarks, orientation.normals, threads);
        else if (faces_down(landmarks, orientation, choice.landmark_spacing))
            turn_over(orientation.normals, orientation.is_closed);
    }
    orient_cells(data.cells, normals.feet, choice, orientation.normals, normals.normals, threads);
    if (!given_normals.empty()) // cells of which none says anything keep the sides found
    {
        orient_by_given(data.cells, points_at(data.spatial.order, given_normals), normals.normals);
        seen_from.clear(); // they may face anything
    }
    if (!given_normals.empty() || !seen_from.empty())
        return orientation;
    if (const auto better = find_sides_of_thin_walls(data.points, data.cells, normals.normals, orientation.contradicted,
                                                     orientation.open, *data.crust, threads,
                                                     progress.part(0.5, 1, "Sides of thin walls")))
    {
        orient_by_given(data.cells, *better, normals.normals);
        orientation.open = false;
    }
    return orientation;
}

/// Gives the cells of a noisy cloud the widths that fits bear, which leave out what faces elsewhere.
void follow_fit_widths(AmlsSurface::Data& data, const FitSamples& samples, const NoiseEstimate& noise, double clearance,
                       int threads, const Progress& progress)
{
    Cells& cells = data.cells;
    if (noise.least_noise() < noisy)
        return;
    const std::vector<int> cell_of_seed =
        find_nearest_samples(noise.seeds(), cells.means, data.cell_search, threads).sample;
    const Vectors facing = points_at(cell_of_seed, data.cell_normals.normals);
    const LocalScales scales = choose_fit_widths(samples, facing, noise, clearance, threads, progress);
    for (int c = 0; c < cells.size(); ++c)
        if (cells.seeds[c] >= 0)
            cells.scales[c].width = scales.at_seed[cells.seeds[c]].width * data.cell_normals.widening[c];
}

/// Where the fits of the anchors begin.
struct AnchorStarts
{
    std::vector<FitStart> starts;
    double median_rho_e = 0; ///< That their widths amount to.
};

/// \param rho_e 0 = widths are what the cells say; else these follow. \param growth factor by which the width of a fit
/// may exceed that of its cell.
AnchorStarts choose_starts(AmlsSurface::Data& data, std::vector<int> anchors, const Points& poles, double rho_e,
                           double growth, int threads)
{
    Cells& cells = data.cells;
    const CellNormals& normals = data.cell_normals;
    std::vector<double> widths;
    // The mass is that of a window which may have been widened already.
    for (const int c : anchors)
        widths.push_back(cells.scales[c].width * std::clamp(1 / (normals.mass[c] * normals.widening[c]), 1.0, growth));
    // Without rho_e the feature size only serves the report.
    const std::size_t stride = rho_e > 0 ? 1 : std::max<std::size_t>(1, anchors.size() / reported_sizes);
    Points asked;
    for (std::size_t a = 0; a < anchors.size(); a += stride)
        asked.push_back(normals.feet[anchors[a]]);
    FeatureSizeOptions feature_options;
    feature_options.threads = threads;
    const std::vector<double> feature_size = measure_feature_size(asked, poles, feature_options);
    if (rho_e > 0)
        for (std::size_t a = 0; a < anchors.size(); ++a)
            widths[a] = std::min(std::max(rho_e * feature_size[a] / rho_per_width,
                                          narrowest_spacings / std::sqrt(cells.scales[anchors[a]].density)),
                                 widest);
    std::vector<double> equivalent;
    for (std::size_t i = 0; i < asked.size(); ++i)
        if (std::isfinite(feature_size[i]))
            equivalent.push_back(rho_per_width * widths[i * stride] / feature_size[i]);
    AnchorStarts result;
    result.median_rho_e = median(std::move(equivalent));
    if (rho_e > 0)
    {
        std::vector<int> kept;
        std::vector<double> kept_widths;
        for (const int a : thin_anchors(anchors, widths, normals))
        {
            kept.push_back(anchors[a]);
            kept_widths.push_back(widths[a]);
        }
        anchors = std::move(kept);
        widths = std::move(kept_widths);
        const Points feet = points_at(anchors, normals.feet);
        const NeighbourSearch search(feet);
        parallel_for(
            std::size_t(cells.size()), threads, {},
            [&](std::size_t c)
            { cells.scales[c].width = data.sampling_widths[c] = widths[search.nearest(normals.feet[c])]; },
            1024);
    }
    for (std::size_t a = 0; a < anchors.size(); ++a)
    {
        const int c = anchors[a];
        data.anchor_spacing.push_back(std::max(widths[a] * fine_spacing, 1 / std::sqrt(cells.scales[c].density)));
        result.starts.push_back({normals.feet[c], normals.normals[c], widths[a], cells.scales[c].sigma});
    }
    return result;
}

/// The points with the sides of their cells.
FitSamples list_fit_samples(const AmlsSurface::Data& data, int threads)
{
    FitSamples samples{data.points, data.point_search, std::vector<double>(data.points.size()),
                       Vectors(data.points.size())};
    parallel_for(
        data.points.size(), threads, {},
        [&](std::size_t i)
        {
            const int c = data.cells.cell_of_point[i];
            samples.weights[i] = data.cell_normals.kinds[c] == CellKind::outlier ? 0 : 1;
            samples.normals[i] = data.cell_normals.normals[c];
        },
        4096);
    return samples;
}

double median_width(const std::vector<FitStart>& starts)
{
    std::vector<double> widths;
    for (const FitStart& start : starts)
        widths.push_back(start.width);
    return median(std::move(widths));
}

} // namespace

bool AmlsSurfaceReport::has_only_lattice_noise() const
{
    return lattice_step > 0 && noise < most_error_of_lattice * lattice_error;
}

const AmlsSurfaceReport& AmlsSurface::report() const
{
    return data_->report;
}

OrientedSamples AmlsSurface::anchors() const
{
    OrientedSamples samples;
    for (const Anchor& a : data_->anchors)
    {
        samples.points.push_back(data_->frame.from_unit(a.position));
        samples.normals.push_back(a.normal);
    }
    return samples;
}

AmlsSurface build_amls_surface(const Points& points, const AmlsOptions& options, const Progress& progress,
                               const Vectors& given_normals, const AmlsSurface* earlier)
{
    const ThreadTeam team;
    check_options(points, options, given_normals);
    const int threads = resolve_threads(options.threads);
    check_spans_volume(points);
    const UnitFrame frame(points);
    PhaseTimes times;

    auto data = std::make_shared<AmlsSurface::Data>(frame);
    data->spatial = order_input(points, threads);
    for (int i : data->spatial.order)
        data->points.push_back(frame.to_unit(points[i]));
    data->point_search = BlockSearch(data->points, threads);
    data->crust =
        earlier && earlier->data().points == data->points ? earlier->data().crust : std::make_shared<CrustOfPoints>();
    // Whether they are a depth image must not hang on their order.
    const Points sorted = points_at(data->spatial.order, points);
    const Rounding rounding = options.noise == 0 ? find_rounding(sorted) : Rounding{};
    SurfaceCells made = make_surface_cells(data->points, data->point_search, options.noise / frame.scale(),
                                           rounding.in(frame), threads, times, progress.part(0, 0.35));
    const NoiseEstimate noise = std::move(made.noise);
    data->cells = std::move(made.cells);
    data->cell_search = std::move(made.search);
    data->cell_normals = std::move(made.normals);
    Cells& cells = data->cells;
    CellNormals& normals = data->cell_normals;
    for (int c = 0; c < cells.size(); ++c)
    {
        cells.scales[c].width *= normals.widening[c];
        data->sampling_widths.push_back(cells.scales[c].width);
    }
    AnchorChoice choice = choose_anchors(cells, normals, threads);
    if (choice.anchors.empty())
    {
        // Too few points to tell outliers from surface: all are surface.
        std::fill(normals.kinds.begin(), normals.kinds.end(), CellKind::regular);
        choice = choose_anchors(cells, normals, threads);
    }

    times.begin("orientation");
    const auto viewpoints = [&](const Progress& part)
    { return find_viewpoints(options.as_scanned != nullptr ? *options.as_scanned : points, sorted, threads, part); };
    const Orientation orientation =
        orient(*data, choice, viewpoints, given_normals, threads, progress.part(0.35, 0.85));

    const FitSamples samples = list_fit_samples(*data, threads);
    const bool for_labels = options.for_crust || options.for_labels;
    if (options.rho_e == 0)
    {
        times.begin("width");
        follow_fit_widths(*data, samples, noise, for_labels ? labels_clearance : projection_clearance, threads,
                          progress.part(0.85, 0.87, "Width"));
    }
    times.begin("fit");
    progress.part(0.87, 0.95, "Fit").report(0);
    // In folds crusts get handles else.
    const bool may_grow = noise.least_noise() >= noisy && !for_labels;
    const AnchorStarts anchors =
        choose_starts(*data, choice.anchors, orientation.poles, options.rho_e, may_grow ? most_growth : 1, threads);
    const double robust_scale = choose_robust_scale(samples, anchors.starts, threads);
    data->anchors = fit_anchors(samples, anchors.starts, robust_scale, threads, progress.part(0.87, 0.95, "Fit"));
    for (const Anchor& anchor : data->anchors)
        data->anchor_positions.push_back(anchor.position);
    data->anchor_search = BlockSearch(data->anchor_positions, threads);
    data->cell_sides = normals.normals;
    follow_anchors(cells, data->anchors, data->anchor_search, data->cell_sides, threads);
    for (const int i : order_spatially(orientation.poles).order)
        data->poles.push_back(orientation.poles[std::size_t(i)]);
    data->pole_search = BlockSearch(data->poles, threads);
    if (robust_scale < picky_scale)
    {
        times.begin("residuals");
        AmlsProjectionOptions projection;
        projection.sharp = data->sharp = !options.for_crust;
        data->projected = project_in_frame(*data, data->points, cells.cell_of_point, projection, threads,
                                           progress.part(0.95, 1, "Residuals"));
        progress.part(0.95, 1, "Residuals").report(1);
        data->residuals = measure_residuals_in_passes(*data, data->projected, threads);
    }
    times.end();

    AmlsSurfaceReport& report = data->report;
    report.noise = frame.scale() * noise.median_sigma();
    report.least_noise = noise.least_noise();
    report.most_noise = frame.scale() * noise.most_sigma();
    report.spacing = frame.scale() * noise.median_spacing();
    report.lattice_step = rounding.lattice_step;
    report.lattice_error = rounding.lattice_error;
    report.width = frame.scale() * median_width(anchors.starts);
    report.rho_e = anchors.median_rho_e;
    report.cells = cells.size();
    report.anchors = int(anchors.starts.size());
    report.contradicted = orientation.contradicted;
    report.open = orientation.open;
    report.seconds = times.seconds();
    return AmlsSurface(std::move(data));
}

} // namespace recon
