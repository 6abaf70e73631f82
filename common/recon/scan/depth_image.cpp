#include <recon/scan/depth_image.h>

#include <recon/median.h>
#include <recon/scramble.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

constexpr std::size_t most_asked = 1'000;
/// Fewer say nothing [count].
constexpr std::size_t fewest = 100;
/// Least cosine between the axis and any ray: a camera sees 66 degrees to each side at most.
constexpr double least_cosine = 0.4;
/// Share of the points whose nearest in the image is as far as the median, within a twentieth: 1 of a frame, 0.15 of
/// one that was moved, 0.03 to 0.07 of models and of a scan, 0.08 to 0.36 of planes with a grid of their own.
constexpr double on_grid = 0.8, even = 0.05;
/// Farthest depth by the nearest, but for a twentieth of the points each.
constexpr double least_relief = 1.25;
/// Relative difference of equal depths, and share of the points up to which different ones come in steps.
constexpr double equal_depths = 1e-6, few_depths = 0.1;
/// Depths on either side that tell the step [count]; steps that are coarse [pixels].
constexpr std::ptrdiff_t around = 2;
constexpr double coarse = 0.5;
/// Points asked whether they lie in a step [count], and share in steps that makes a cloud coarse.
constexpr int neighbours = 12;
constexpr double many_in_steps = 0.1;
/// Of a grid of angles: 0.91 and more of two sweeps of a car's scanner within a tenth of the median, 0.42 of models at
/// most; the nearest lie along a circle about the axis or across it, 0.22 of models.
constexpr double even_angles = 0.1, aslant = 0.1;
/// Bundles of rays that are looked at, and points in each [count].
constexpr std::size_t bundles = 16, most_in_bundle = 4'000;
/// Ranges of neighbours between which there is a gap [range by range], if the ones before are so much more alike [1 =
/// equal differences], and least share of points with such: 0.0005 and more in a room with a ball in it, none on
/// bodies.
constexpr double far_apart = 1.1, smooth_before = 0.3, least_gaps = 0.0003;

/// Where the rays meet a plane at depth 1. Empty if some do not, or not all on one side.
Points list_pixels(const Points& points, int axis)
{
    Points pixels;
    const double side = points.front()[axis] < 0 ? -1 : 1;
    for (const Point& p : points)
    {
        const double depth = side * p[axis];
        if (!(depth > least_cosine * p.norm()))
            return {};
        pixels.emplace_back(p[(axis + 1) % 3] / depth, p[(axis + 2) % 3] / depth, 0);
    }
    return pixels;
}

bool has_relief(const Points& points, int axis)
{
    std::vector<double> depths;
    for (const Point& p : points)
        depths.push_back(std::abs(p[axis]));
    return quantile(depths, 0.95) > least_relief * quantile(depths, 0.05);
}

/// The median of distances between neighbours, 0 if too few are like it.
double find_even_step(const std::vector<double>& steps, double tolerance)
{
    const double usual = median(steps);
    const auto alike = std::count_if(steps.begin(), steps.end(),
                                     [&](double step) { return std::abs(step - usual) <= tolerance * usual; });
    return double(alike) >= on_grid * double(steps.size()) ? usual : 0;
}

/// Distance of neighbours in the image; 0 if they are on no grid.
double measure_pixel(const Points& pixels)
{
    const NeighbourSearch search(pixels);
    std::vector<double> steps;
    for (std::size_t i = 0; i < pixels.size(); i += pixels.size() / most_asked + 1)
    {
        int nearest[2];
        double squared[2];
        search.nearest(pixels[i], 2, nearest, squared);
        steps.push_back(std::sqrt(squared[1]));
    }
    return find_even_step(steps, even);
}

/// Those points that from the origin lie next to the k-th of some random ones.
Points list_bundle(const Points& points, std::size_t k)
{
    struct Ray
    {
        double cosine;
        std::size_t point;
    };
    constexpr double nowhere = -2;
    std::vector<Ray> rays(points.size());
    const Vector ahead = points[scramble(k) % points.size()].normalized();
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const double cosine = points[i].dot(ahead) / points[i].norm();
        rays[i] = {cosine >= -1 ? cosine : nowhere, i}; // none at the origin
    }
    const auto end = rays.begin() + std::ptrdiff_t(std::min(points.size(), most_in_bundle));
    std::nth_element(rays.begin(), end - 1, rays.end(),
                     [](const Ray& a, const Ray& b)
                     { return a.cosine > b.cosine || (a.cosine == b.cosine && a.point < b.point); });
    Points bundle;
    for (auto ray = rays.begin(); ray != end; ++ray)
        if (ray->cosine > nowhere)
            bundle.push_back(points[ray->point]);
    return bundle;
}

/// Whether the surface ends at a reading: on one side the next is far away, that on the other near. \param near those
/// around it, nearest first.
bool is_at_gap(const Points& bundle, const Points& image, std::size_t i, const std::vector<int>& near)
{
    const auto farther = [&](int k) { return std::log(bundle[std::size_t(k)].norm() / bundle[i].norm()); };
    for (const int k : near)
    {
        const double beyond = std::abs(farther(k));
        if (beyond <= std::log(far_apart))
            continue;
        const Vector off = image[std::size_t(k)] - image[i];
        for (const int before : near)
            if ((image[std::size_t(before)] - image[i] + off).norm() < 0.5 * off.norm() &&
                std::abs(farther(before)) < smooth_before * beyond)
                return true;
    }
    return false;
}

/// What tells a scanner's readings.
class ScannerSigns
{
public:
    /// \param axis about which it turns.
    explicit ScannerSigns(int axis) : axis_(axis) {}

    void add(const Points& bundle)
    {
        constexpr int asked_around = 9;
        Points image; // angles about the axis and over the plane across it
        for (const Point& p : bundle)
            image.emplace_back(std::atan2(p[(axis_ + 2) % 3], p[(axis_ + 1) % 3]), std::asin(p[axis_] / p.norm()), 0);
        const NeighbourSearch search(image);
        for (std::size_t i = 0; i < image.size(); ++i)
        {
            std::vector<int> near(asked_around);
            double squared[asked_around];
            near.resize(std::size_t(search.nearest(image[i], asked_around, near.data(), squared)));
            const Vector off = (image[std::size_t(near[1])] - image[i]).cwiseAbs();
            straight_ += std::min(off.x(), off.y()) <= aslant * std::max(off.x(), off.y());
            steps_.push_back(std::sqrt(squared[1]));
            near.erase(near.begin());
            gaps_ += is_at_gap(bundle, image, i, near);
        }
    }

    /// Distance of neighbouring rays [radians]; 0 if they are on no grid of angles.
    double measure_angle() const
    {
        return straight_ >= on_grid * double(steps_.size()) ? find_even_step(steps_, even_angles) : 0;
    }
    bool have_gaps() const { return gaps_ >= least_gaps * double(steps_.size()); }

private:
    int axis_;
    std::vector<double> steps_;
    int straight_ = 0, gaps_ = 0;
};

/// Distance of neighbouring rays of a scanner at the origin, whose readings the points are [radians]; else 0.
double find_scanner(const Points& points)
{
    const Points first = list_bundle(points, 0);
    if (first.size() < fewest) // nearly all points are at the origin
        return 0;
    for (const int axis : {2, 1, 0})
    {
        ScannerSigns signs(axis);
        signs.add(first);
        if (signs.measure_angle() == 0)
            continue;
        for (std::size_t k = 1; k < bundles; ++k)
            signs.add(list_bundle(points, k));
        if (signs.have_gaps())
            return signs.measure_angle();
    }
    return 0;
}

/// Depths that occur, ascending; none if they are many.
std::vector<double> list_depths(const Points& points, int axis)
{
    std::vector<double> depths;
    for (const Point& p : points)
        depths.push_back(std::abs(p[axis]));
    std::sort(depths.begin(), depths.end());
    const auto are_equal = [](double a, double b) { return b - a <= equal_depths * b; };
    depths.erase(std::unique(depths.begin(), depths.end(), are_equal), depths.end());
    if (double(depths.size()) > few_depths * double(points.size()))
        depths.clear();
    return depths;
}

/// Whether some of a thousand points have equal coordinates, as in steps and in planes along the axes.
bool has_equal_depths(const Points& points)
{
    for (int axis = 0; axis < 3; ++axis)
    {
        std::vector<double> depths;
        for (std::size_t i = 0; i < points.size(); i += points.size() / most_asked + 1)
            depths.push_back(points[i][axis]);
        const std::size_t asked = depths.size();
        std::sort(depths.begin(), depths.end());
        depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
        if (double(depths.size()) < 0.9 * double(asked))
            return true;
    }
    return false;
}

} // namespace

double DepthCamera::step_at(const Point& p) const
{
    if (depths.size() < 2)
        return 0;
    const std::ptrdiff_t last = std::ptrdiff_t(depths.size()) - 1,
                         at = std::lower_bound(depths.begin(), depths.end(), ahead.dot(p - place)) - depths.begin();
    // Some depths may not occur, so steps look like multiples of their length.
    double least = std::numeric_limits<double>::infinity();
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(at - around, 0); i < std::min(at + around, last); ++i)
        least = std::min(least, depths[std::size_t(i + 1)] - depths[std::size_t(i)]);
    return std::isfinite(least) ? least : 0;
}

bool DepthCamera::is_in_step(const Point& p, const Points& points, const BlockSearch& search) const
{
    int near[neighbours];
    double squared[neighbours];
    const int count = search.nearest(p, neighbours, near, squared);
    const double depth = ahead.dot(p - place);
    const auto equal = std::count_if(
        near, near + count,
        [&](int i) { return std::abs(ahead.dot(points[std::size_t(i)] - place) - depth) <= 2 * equal_depths * depth; });
    return 4 * equal >= 3 * count;
}

DepthCamera DepthCamera::in(const UnitFrame& frame) const
{
    DepthCamera result = *this;
    result.place = frame.to_unit(place);
    for (double& depth : result.depths)
        depth /= frame.scale();
    return result;
}

std::optional<DepthCamera> find_depth_camera(const Points& points)
{
    if (points.size() < fewest)
        return {};
    for (int axis = 0; axis < 3; ++axis)
    {
        const Points pixels = list_pixels(points, axis);
        if (pixels.empty() || !has_relief(points, axis))
            continue;
        const double pixel = measure_pixel(pixels);
        if (pixel > 0)
            return DepthCamera{Point::Zero(), (points.front()[axis] < 0 ? -1 : 1) * Vector::Unit(axis), pixel,
                               list_depths(points, axis)};
    }
    if (const double angle = find_scanner(points); angle > 0)
        return DepthCamera{Point::Zero(), Vector::Zero(), angle, {}};
    return {};
}

std::optional<DepthCamera> find_coarse_depth_camera(const Points& points)
{
    if (points.size() < fewest || !has_equal_depths(points))
        return {};
    std::optional<DepthCamera> camera = find_depth_camera(points);
    if (!camera || camera->depths.empty())
        return {};
    const BlockSearch search(points);
    int in_steps = 0, asked = 0;
    for (std::size_t i = 0; i < points.size(); i += points.size() / most_asked + 1, ++asked)
        in_steps += camera->step_at(points[i]) >= coarse * camera->pixel * camera->ahead.dot(points[i]) &&
                    camera->is_in_step(points[i], points, search);
    return in_steps > many_in_steps * asked ? camera : std::nullopt;
}

} // namespace recon
