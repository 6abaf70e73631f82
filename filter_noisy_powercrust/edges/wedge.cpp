#include "wedge.h"

#include <recon/median.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

/// Between the normals of the faces. Above the first the bend is too slight to tell, below the second it is a wall's
/// rim.
constexpr double edge_cosine = 0.82, rim_cosine = -0.75;
/// Normals belong to a face within 30 degrees, and surely within 26.
constexpr double group_cosine = 0.87, face_cosine = 0.9;
constexpr double least_share = 0.6;                 // of the vertices that are surely of one of the two faces
constexpr int least_vertices = 4, least_points = 8; // of a face
constexpr double judged_within = 1.2, widely_judged_within = 2; // reaches
constexpr double noise_within = 2 * judged_within;
constexpr double capped_square = 9; // of a residual [sigma^2]: farther points are of something else
/// Of a wedge [sigma^2]: noise leaves about 1; what has details beside the edge leaves more.
constexpr double worst_misfit = 2.1;
/// Of a coefficient [sigma^2]. Akaike's is 2; more, since choosing among windows fits, too.
constexpr double price = 3;
constexpr int most_points = 250; // of a fit, an even choice
constexpr int grouping_rounds = 5, fitting_rounds = 3, projection_steps = 8;
constexpr double curved_ridge = 2e-4, flat_ridge = 1e6;
constexpr int sheet_coefficients = 6, flat_coefficients = 3;

void thin_evenly(std::vector<int>& indices)
{
    const std::size_t stride = (indices.size() + most_points - 1) / most_points;
    if (stride < 2)
        return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < indices.size(); i += stride)
        indices[kept++] = indices[i];
    indices.resize(kept);
}

} // namespace

Sheet::Foot Sheet::foot_of(const Point& p) const
{
    const Vector d = p - origin;
    const double u = d.dot(frame.t1) / width, v = d.dot(frame.t2) / width;
    return {d.dot(frame.normal) - (c[0] + c[1] * u + c[2] * v + c[3] * u * u + c[4] * u * v + c[5] * v * v),
            (c[1] + 2 * c[3] * u + c[4] * v) / width, (c[2] + c[4] * u + 2 * c[5] * v) / width};
}

double Sheet::distance(const Point& p) const
{
    const Foot foot = foot_of(p);
    return foot.height / std::sqrt(1 + foot.slope_u * foot.slope_u + foot.slope_v * foot.slope_v);
}

Vector Sheet::normal(const Point& p) const
{
    const Foot foot = foot_of(p);
    return (frame.normal - foot.slope_u * frame.t1 - foot.slope_v * frame.t2).normalized();
}

int Wedge::facing(const Point& p) const
{
    return side * sheets[0].distance(p) > side * sheets[1].distance(p) ? 0 : 1;
}

double Wedge::distance(const Point& p) const
{
    return side * std::max(side * sheets[0].distance(p), side * sheets[1].distance(p));
}

Point Wedge::project(Point p) const
{
    for (int step = 0; step < projection_steps; ++step)
    {
        const Sheet& sheet = sheets[facing(p)];
        p -= sheet.distance(p) * sheet.normal(p);
    }
    return p;
}

bool is_other_sheet(const Vector& a, const Vector& b)
{
    return a.dot(b) <= -0.4;
}

std::optional<JudgedWedge> WedgeFitter::fit(int vertex)
{
    constexpr std::array<Window, 4> windows{{{false, 1.2}, {false, 1.75}, {true, 2}, {true, 3}}};
    if (!prepare(vertex))
        return {};
    std::optional<JudgedWedge> best;
    const double rival = misfit_of_one_sheet();
    for (const Window& window : windows)
        if (const auto wedge = fit_in(window))
        {
            const int coefficients = 2 * (window.is_flat ? flat_coefficients : sheet_coefficients);
            const double left = misfit(*wedge, coefficients, fitted_.size()), gain = rival - left;
            if (left > worst_misfit)
                continue;
            if (!best || gain > best->gain)
                best = {*wedge, gain, 0};
        }
    if (!best)
        return {};
    collect_points(widely_judged_within, judged_);
    best->wide_gain = misfit_of_one_sheet() - misfit(best->wedge, 2 * sheet_coefficients, judged_.size());
    return best;
}

/// Makes the points by which wedges are judged ready. \returns false if there are too few.
bool WedgeFitter::prepare(int vertex)
{
    vertex_ = vertex;
    collected_ = 0;
    collect_points(noise_within, judged_);
    if (int(judged_.size()) < 2 * least_points)
        return false;
    measure_noise();
    collect_points(judged_within, judged_);
    return int(judged_.size()) >= 2 * least_points && sigma_ > 0;
}

/// Begins with the vertices, then lets each point count for the sheet that bounds the solid there.
std::optional<Wedge> WedgeFitter::fit_in(const Window& window)
{
    Wedge wedge;
    if (!find_faces(window, wedge))
        return {};
    collect_points(window.radius, fitted_);
    for (int round = 0; round < fitting_rounds; ++round)
    {
        for (auto& indices : of_sheet_)
            indices.clear();
        for (const int i : fitted_)
            of_sheet_[wedge.facing(surface_.points[i])].push_back(i);
        for (int k = 0; k < 2; ++k)
            if (int(of_sheet_[k].size()) < least_points ||
                !fit_sheet(surface_.points, of_sheet_[k], window.is_flat, true, wedge.sheets[k]))
                return {};
    }
    return wedge;
}

/// Two groups of vertices by their normals, a sheet through each, and how they meet.
bool WedgeFitter::find_faces(const Window& window, Wedge& wedge)
{
    const Vectors& normals = surface_.normals;
    const double radius = window.radius * surface_.reach[vertex_];
    surface_.vertex_search.within(surface_.vertices[vertex_], radius, around_);
    const auto is_other = [&](int v) { return is_other_sheet(normals[v], normals[vertex_]); };
    around_.erase(std::remove_if(around_.begin(), around_.end(), is_other), around_.end());
    thin_evenly(around_);
    std::array<Vector, 2> mean;
    if (!group_normals(mean))
        return false;
    for (int k = 0; k < 2; ++k)
    {
        of_sheet_[k].clear();
        Sheet& sheet = wedge.sheets[k];
        for (const int v : around_)
            if (normals[v].dot(mean[k]) > face_cosine)
            {
                of_sheet_[k].push_back(v);
                sheet.origin += surface_.vertices[v];
            }
        sheet.origin /= std::max(1.0, double(of_sheet_[k].size()));
        sheet.frame = TangentFrame(mean[k]);
        sheet.width = 2 * radius; // all points weigh about the same
        if (int(of_sheet_[k].size()) < least_vertices ||
            !fit_sheet(surface_.vertices, of_sheet_[k], window.is_flat, false, sheet))
            return false;
    }
    if (double(of_sheet_[0].size() + of_sheet_[1].size()) < least_share * double(around_.size()))
        return false;
    const auto rises_over = [&](int k)
    {
        heights_.clear();
        for (const int v : of_sheet_[1 - k])
            heights_.push_back(wedge.sheets[k].distance(surface_.vertices[v]));
        return median(heights_) > 0;
    };
    const bool is_concave = rises_over(0);
    wedge.side = is_concave ? -1 : 1;
    return rises_over(1) == is_concave;
}

/// Means of two groups, beginning with the two normals that differ most.
bool WedgeFitter::group_normals(std::array<Vector, 2>& mean)
{
    const Vectors& normals = surface_.normals;
    double least = 1;
    for (const int a : around_)
        for (const int b : around_)
            if (const double cosine = normals[a].dot(normals[b]); cosine < least)
            {
                least = cosine;
                mean = {normals[a], normals[b]};
            }
    if (least > edge_cosine || least < rim_cosine)
        return false;
    for (int round = 0; round < grouping_rounds; ++round)
    {
        std::array<Vector, 2> sum{Vector::Zero(), Vector::Zero()};
        std::array<int, 2> count{};
        for (const int v : around_)
        {
            const double cosines[2] = {normals[v].dot(mean[0]), normals[v].dot(mean[1])};
            const int k = cosines[0] > cosines[1] ? 0 : 1;
            if (cosines[k] > group_cosine)
            {
                sum[k] += normals[v];
                ++count[k];
            }
        }
        if (count[0] < least_vertices || count[1] < least_vertices)
            return false;
        mean = {sum[0].normalized(), sum[1].normalized()};
    }
    return mean[0].dot(mean[1]) <= edge_cosine;
}

bool WedgeFitter::fit_sheet(const Points& points, const std::vector<int>& indices, bool is_flat, bool robust,
                            Sheet& sheet)
{
    gathered_.gather(points, {}, indices, sheet.origin);
    QuadricWeights how{sheet.width, 4};
    how.ridge_quadratic = is_flat ? flat_ridge : curved_ridge;
    QuadricFit about;
    about.c = sheet.c;
    if (robust)
        how.robust_about = &about;
    how.robust_scale = 2 * sigma_;
    const QuadricFit fit = fit_quadric(gathered_, Point::Zero(), sheet.frame, how);
    sheet.c = fit.c;
    return fit.valid;
}

double WedgeFitter::misfit_of_one_sheet()
{
    Sheet sheet;
    sheet.origin = surface_.vertices[vertex_];
    sheet.frame = TangentFrame(surface_.normals[vertex_]);
    sheet.width = 2 * judged_within * surface_.reach[vertex_];
    for (int round = 0; round <= fitting_rounds; ++round)
        if (!fit_sheet(surface_.points, judged_, false, round > 0, sheet))
            return capped_square;
    return misfit(sheet, sheet_coefficients, judged_.size());
}

/// Mean square of the residuals, capped, with the price of the coefficients [noise^2]. Of a fit to more points than are
/// judged a part of it is paid here.
template <class Model>
double WedgeFitter::misfit(const Model& model, int coefficients, std::size_t fitted) const
{
    double sum = 0;
    const double unit = 1 / (sigma_ * sigma_);
    for (const int i : judged_)
    {
        const double d = model.distance(surface_.points[i]);
        sum += std::min(d * d * unit, capped_square);
    }
    const double judged = double(judged_.size());
    return (sum + price * coefficients * std::min(1.0, judged / double(fitted))) / judged;
}

void WedgeFitter::collect_points(double radius, std::vector<int>& indices)
{
    const Point& centre = surface_.vertices[vertex_];
    const double length = radius * surface_.reach[vertex_];
    if (radius > collected_)
    {
        collected_ = radius;
        surface_.point_search.within(centre, length, collected_points_);
        const Vector& normal = surface_.normals[vertex_];
        const auto is_other = [&](int i) { return is_other_sheet(surface_.normals[surface_.nearest[i]], normal); };
        collected_points_.erase(std::remove_if(collected_points_.begin(), collected_points_.end(), is_other),
                                collected_points_.end());
    }
    indices.clear();
    for (const int i : collected_points_)
        if ((surface_.points[i] - centre).squaredNorm() <= length * length)
            indices.push_back(i);
    thin_evenly(indices);
}

/// From heights over the surface as it is; by a high quantile, since clouds hold exact points.
void WedgeFitter::measure_noise()
{
    constexpr double quantile = 0.84, gaussian = 1.405;
    heights_.clear();
    for (const int i : judged_)
        heights_.push_back(surface_.height[i]);
    const auto high = heights_.begin() + std::ptrdiff_t(quantile * double(heights_.size()));
    std::nth_element(heights_.begin(), high, heights_.end());
    sigma_ = *high / gaussian;
}

} // namespace recon
