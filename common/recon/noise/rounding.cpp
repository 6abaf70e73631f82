#include <recon/noise/rounding.h>

#include <recon/median.h>
#include <recon/scramble.h>
#include <recon/search/block_search.h>
#include <recon/search/neighbours.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_set>
#include <vector>

namespace recon
{
namespace
{

constexpr std::size_t fewest = 200; // points that can tell a lattice
/// Values of a coordinate looked at first [count]; at least this share of them occurs twice on a lattice.
constexpr std::size_t most_looked_at = 4096;
constexpr double often_twice = 0.125;
constexpr std::size_t fewest_values = 6, most_values = 1 << 20;
/// Values are the same up to so many float roundings of the largest; a step is much more.
constexpr double same_value = 2, least_step = 16;
constexpr double off_lattice = 0.05; // steps
/// Points asked for their neighbours on the lattice, and the share that has some.
constexpr std::size_t most_asked = 1000;
constexpr double dense = 0.95;
/// A height field has one point above nearly each place; else every axis was rounded.
constexpr double of_height_field = 0.9;
/// Share with all of these in one lattice plane, above which these planes are the shape's own: up to 0.26 of voxels of
/// five models that lie askew or are round, 0.24 to 0.58 of a part with faces along the axes, 0.33 of three cubes of
/// six steps in a corner, 0.39 of a box of eight.
constexpr double flat = 0.3;

struct LatticeAxis
{
    double origin, step;

    std::int64_t index(double value) const { return std::llround((value - origin) / step); }
};

std::vector<double> list_values(const Points& points, int axis, std::size_t stride)
{
    std::vector<double> values;
    for (std::size_t i = 0; i < points.size(); i += stride)
        values.push_back(points[i][axis]);
    std::sort(values.begin(), values.end());
    return values;
}

std::optional<LatticeAxis> find_lattice_axis(const Points& points, int axis)
{
    std::vector<double> values = list_values(points, axis, points.size() / most_looked_at + 1);
    const double rounding =
        std::numeric_limits<float>::epsilon() * std::max(std::abs(values.front()), std::abs(values.back()));
    const auto are_same = [&](double a, double b) { return b - a <= same_value * rounding; };
    std::size_t twice = 0;
    for (std::size_t i = 1; i < values.size(); ++i)
        twice += are_same(values[i - 1], values[i]);
    if (double(twice) < often_twice * double(values.size()))
        return {};
    values = list_values(points, axis, 1);
    values.erase(std::unique(values.begin(), values.end(), are_same), values.end());
    if (values.size() < fewest_values || values.size() > most_values)
        return {};
    double shortest = std::numeric_limits<double>::infinity(), sum = 0;
    for (std::size_t i = 1; i < values.size(); ++i)
        shortest = std::min(shortest, values[i] - values[i - 1]);
    if (shortest < least_step * rounding)
        return {};
    int count = 0;
    for (std::size_t i = 1; i < values.size(); ++i)
        if (const double gap = values[i] - values[i - 1]; gap < 1.5 * shortest)
        {
            sum += gap;
            ++count;
        }
    const double range = values.back() - values.front();
    if (range > double(most_values) * shortest)
        return {};
    const LatticeAxis found{values.front(), range / std::round(range / (sum / count))};
    for (const double value : values)
        if (std::abs((value - found.origin) / found.step - double(found.index(value))) > off_lattice)
            return {};
    return found;
}

/// Points of a lattice by their indices.
class LatticePoints
{
public:
    LatticePoints(const Points& points, const std::array<LatticeAxis, 3>& axes) : axes_(axes)
    {
        for (const Point& p : points)
            keys_.insert(key(p, {0, 0, 0}));
    }

    /// How many columns along an axis hold points, per point.
    double measure_columns(int axis) const
    {
        std::unordered_set<std::uint64_t> columns;
        for (const std::uint64_t k : keys_)
            columns.insert(k & ~(index_mask << shift(axis)));
        return double(columns.size()) / double(keys_.size());
    }

    enum class Neighbours
    {
        none,
        in_one_plane,
        in_several
    };
    Neighbours find_neighbours(const Point& p) const
    {
        int count = 0, in_plane[3] = {0, 0, 0};
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    if ((x != 0 || y != 0 || z != 0) && keys_.count(key(p, {x, y, z})) > 0)
                    {
                        ++count;
                        in_plane[0] += x == 0;
                        in_plane[1] += y == 0;
                        in_plane[2] += z == 0;
                    }
        if (count == 0)
            return Neighbours::none;
        return *std::max_element(in_plane, in_plane + 3) == count ? Neighbours::in_one_plane : Neighbours::in_several;
    }

private:
    /// Of the lattice point so many steps beside a point.
    std::uint64_t key(const Point& p, const std::array<int, 3>& beside) const
    {
        std::uint64_t result = 0;
        for (int k = 0; k < 3; ++k)
            result |= std::uint64_t(axes_[k].index(p[k]) + beside[k] + 1) << shift(k);
        return result;
    }
    static constexpr int index_bits = 21;
    static constexpr std::uint64_t index_mask = (std::uint64_t(1) << index_bits) - 1;
    static constexpr int shift(int axis) { return axis * index_bits; }

    const std::array<LatticeAxis, 3>& axes_;
    std::unordered_set<std::uint64_t> keys_;
};

Rounding find_lattice(const Points& points, const std::array<LatticeAxis, 3>& axes)
{
    const LatticePoints lattice(points, axes);
    std::size_t asked = 0, in_one_plane = 0, alone = 0;
    for (std::size_t i = 0; i < points.size(); i += points.size() / most_asked + 1, ++asked)
    {
        const LatticePoints::Neighbours found = lattice.find_neighbours(points[i]);
        alone += found == LatticePoints::Neighbours::none;
        in_one_plane += found == LatticePoints::Neighbours::in_one_plane;
    }
    if (double(alone) > (1 - dense) * double(asked) || double(in_one_plane) > flat * double(asked))
        return {};
    const Vector steps(axes[0].step, axes[1].step, axes[2].step);
    for (int k = 0; k < 3; ++k)
        if (lattice.measure_columns(k) > of_height_field)
            return {steps[k], error_of_lattice * steps[k], steps, {}};
    return {steps.maxCoeff(), error_of_lattice * steps.maxCoeff(), steps, {}};
}

/// Neighbours among which it is looked for the terraces of a rounded axis, and how many of them one must hold.
constexpr int around_terrace = 64, fewest_on_terrace = 6;
/// Least extent of a few neighbours on a terrace across, over that along it.
constexpr double least_width = 0.15;
/// Share of the next terrace's points that are not above the former.
constexpr double least_beyond = 0.2;
/// Share of the points asked that lie at the edge of a terrace. Of 460 clouds that were not rounded none has an axis so
/// coarse that it is asked.
constexpr double at_edges = 0.15;
/// Standard deviation that the points of terraces are taken to have [steps]. They err by 0.29, but those of one all
/// alike, and only what spans several averages that.
constexpr double error_of_terraces = 0.7;
/// Steps of an axis that is rounded much finer [steps of the coarse one].
constexpr double much_finer = 0.25;

/// Whether points fill an area: most have their nearest in both directions, which those of bent curves have at the bend
/// only.
bool is_wide(const std::vector<Eigen::Vector2d>& points)
{
    if (int(points.size()) < fewest_on_terrace)
        return false;
    std::vector<Eigen::Vector2d> near = points;
    int wide = 0;
    for (const Eigen::Vector2d& at : points)
    {
        constexpr int around = 5; // with the point
        std::partial_sort(near.begin(), near.begin() + around, near.end(),
                          [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b)
                          { return (a - at).squaredNorm() < (b - at).squaredNorm(); });
        Eigen::Matrix<double, 2, around> offsets;
        for (int k = 0; k < around; ++k)
            offsets.col(k) = near[std::size_t(k)];
        offsets.colwise() -= Eigen::Vector2d(offsets.rowwise().mean());
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(offsets * offsets.transpose());
        wide += axes.eigenvalues()[0] >= least_width * least_width * axes.eigenvalues()[1];
    }
    return 2 * wide >= int(points.size());
}

/// Whether a point lies on a terrace, a piece of a plane across the axis, that ends where the next one begins: so it is
/// if that axis was rounded, more coarsely than the points are dense. Slices are curves, and so is what the walls
/// around an exact face have of the next plane.
bool is_at_edge_of_terrace(const Points& points, const Points& flattened, const BlockSearch& search, std::size_t i,
                           int axis, const LatticeAxis& lattice)
{
    std::array<int, around_terrace> near;
    std::array<double, around_terrace> squared;
    const int found = search.nearest(flattened[i], around_terrace, near.data(), squared.data());
    const std::int64_t level = lattice.index(points[i][axis]);
    const auto across = [&](const Point& p) { return Eigen::Vector2d(p[(axis + 1) % 3], p[(axis + 2) % 3]); };
    std::vector<Eigen::Vector2d> own, next;
    for (int k = 0; k < found; ++k)
    {
        const Point& p = points[std::size_t(near[std::size_t(k)])];
        const std::int64_t beside = std::abs(lattice.index(p[axis]) - level);
        if (beside == 0)
            own.push_back(across(p));
        else if (beside == 1)
            next.push_back(across(p));
    }
    if (!is_wide(own) || !is_wide(next))
        return false;
    // As near to the next terrace as points of one lie to each other, and the next one goes on beside it, not above it
    // as in a stack of sheets.
    const auto nearest_to = [&](const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& others)
    {
        double least = std::numeric_limits<double>::infinity();
        for (const Eigen::Vector2d& q : others)
            if (q != p)
                least = std::min(least, (q - p).squaredNorm());
        return least;
    };
    double within = 0, step = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& p : own)
        within = std::max(within, nearest_to(p, own));
    int beyond = 0;
    for (const Eigen::Vector2d& p : next)
    {
        const double squared_distance = nearest_to(p, own);
        step = std::min(step, squared_distance);
        beyond += squared_distance > within;
    }
    return step <= within && beyond >= least_beyond * double(next.size());
}

double measure_spacing(const Points& points)
{
    const BlockSearch search(points);
    std::vector<double> spacings;
    for (std::size_t i = 0; i < points.size(); i += points.size() / most_asked + 1)
        spacings.push_back(measure_spacing_at(points[i], search));
    return median(std::move(spacings));
}

/// Of an axis rounded more coarsely than the points are dense, as those of metres far north in single
/// precision, half a metre. \param coarsest step.
Rounding find_rounded_axes(const Points& points, const std::array<std::optional<LatticeAxis>, 3>& axes, double coarsest)
{
    const auto is_asked = [&](int k) { return axes[k] && axes[k]->step >= much_finer * coarsest; };
    if (is_asked(0) && is_asked(1) && is_asked(2))
        return {}; // a lattice, of a shape that is its own
    const double spacing = measure_spacing(points);
    // Flat enough that terraces are near to the next.
    Points flattened = points;
    for (int k = 0; k < 3; ++k)
        if (is_asked(k))
            for (Point& p : flattened)
                p[k] = axes[k]->origin + (p[k] - axes[k]->origin) * std::min(1.0, 0.5 * spacing / axes[k]->step);
    const BlockSearch search(flattened);
    Vector steps = Vector::Zero();
    for (int k = 0; k < 3; ++k)
    {
        if (!is_asked(k))
            continue;
        std::size_t asked = 0, edges = 0;
        for (std::size_t i = 0; i < points.size(); i += points.size() / most_asked + 1, ++asked)
            edges += is_at_edge_of_terrace(points, flattened, search, i, k, *axes[k]);
        if (double(edges) >= at_edges * double(asked))
            steps[k] = axes[k]->step;
    }
    return {steps.maxCoeff(), error_of_terraces * steps.norm(), steps, {}};
}

/// Of an axis in single precision the steps of its largest values.
std::optional<LatticeAxis> find_float_axis(const Points& points, int axis)
{
    double largest = 0;
    for (const Point& p : points)
    {
        if (double(float(p[axis])) != p[axis])
            return {};
        largest = std::max(largest, std::abs(p[axis]));
    }
    if (largest == 0)
        return {};
    return LatticeAxis{points.front()[axis],
                       std::ldexp(1.0, std::ilogb(largest) + 1 - std::numeric_limits<float>::digits)};
}

Rounding find_axes(const Points& points)
{
    if (points.size() < fewest)
        return {};
    std::array<std::optional<LatticeAxis>, 3> axes;
    for (int k = 0; k < 3; ++k)
        axes[k] = find_lattice_axis(points, k);
    if (axes[0] && axes[1] && axes[2])
        if (const Rounding lattice = find_lattice(points, {*axes[0], *axes[1], *axes[2]}))
            return lattice;
    double coarsest = 0;
    for (int k = 0; k < 3; ++k)
    {
        if (!axes[k])
            axes[k] = find_float_axis(points, k);
        if (axes[k])
            coarsest = std::max(coarsest, axes[k]->step);
    }
    constexpr double least_coarse = 0.1; // of what spacing there may be; most clouds are in single precision
    if (coarsest < least_coarse * bounding_box(points).diagonal() / std::sqrt(double(points.size())))
        return {};
    return find_rounded_axes(points, axes, coarsest);
}

} // namespace

Rounding Rounding::in(const UnitFrame& frame) const
{
    Rounding result{lattice_step / frame.scale(), lattice_error / frame.scale(), lattice_steps / frame.scale(), {}};
    if (camera)
        result.camera = camera->in(frame);
    return result;
}

Points Rounding::dither(const Points& points) const
{
    Points result = points;
    for (std::size_t i = 0; i < points.size(); ++i)
        for (int k = 0; k < 3; ++k)
            result[i][k] += lattice_steps[k] * (scramble_to_unit(3 * i + std::size_t(k)) - 0.5);
    return result;
}

Rounding find_rounding(const Points& points)
{
    Rounding result = find_axes(points);
    if (!result)
        result.camera = find_coarse_depth_camera(points);
    return result;
}

} // namespace recon
