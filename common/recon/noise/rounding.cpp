#include <recon/noise/rounding.h>

#include <recon/scramble.h>

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

Rounding find_lattice(const Points& points)
{
    if (points.size() < fewest)
        return {};
    std::array<LatticeAxis, 3> axes;
    for (int k = 0; k < 3; ++k)
    {
        const std::optional<LatticeAxis> axis = find_lattice_axis(points, k);
        if (!axis)
            return {};
        axes[k] = *axis;
    }
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
            return {steps[k], steps, {}};
    return {steps.maxCoeff(), steps, {}};
}

} // namespace

Rounding Rounding::in(const UnitFrame& frame) const
{
    Rounding result{lattice_step / frame.scale(), lattice_steps / frame.scale(), {}};
    if (camera)
        result.camera = camera->in(frame);
    return result;
}

Points Rounding::dither(const Points& points) const
{
    Points result = points;
    for (std::size_t i = 0; i < points.size(); ++i)
        for (int k = 0; k < 3; ++k)
            result[i][k] += lattice_steps[k] * (double(scramble(3 * i + std::size_t(k)) >> 11) * 0x1p-53 - 0.5);
    return result;
}

Rounding find_rounding(const Points& points)
{
    Rounding result = find_lattice(points);
    if (!result)
        result.camera = find_coarse_depth_camera(points);
    return result;
}

} // namespace recon
