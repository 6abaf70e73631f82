#include <recon/noise/noisy_fibres.h>

#include <recon/parallel.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

/// Clouds of fewer points say nothing [count].
constexpr std::size_t fewest_points = 1'000;
/// Places asked [count], and the share of them that must lie on fibres: 0.34 at most of 1,279 models and scans, mostly
/// parts of CAD programs, 0.65 and more of copies along normals, 0.47 and more along one axis.
constexpr std::size_t asked = 200;
constexpr double least_share = 0.4;
/// The same of those asked first, and by what these go on among all places, so that they lie all over the cloud.
constexpr std::size_t asked_first = 40, stride = 73;
constexpr double least_share_first = 0.15;
/// Where the copies of a sample lie anywhere around it, some are in line with the normal by chance, and as often nearly
/// with a direction along the surface. Places on fibres there by those along normals, at most: 0.27 of fibres, 0.39 to
/// 1.2 of thin tubes with five samples a spot. And share of all places that is left without them, at least: 0.44 of
/// fibres, 0.31 of plates with bores.
constexpr double most_by_chance = 0.33, least_share_left = 0.35;
/// Neighbours among which a fibre is sought, and others on it, at least; neighbours that must lie beside it, and of how
/// many these are sought [count].
constexpr int most_neighbours = 48, fewest_on_fibre = 2, most_around = 1'536;
constexpr std::size_t fewest_beside = 24;
/// They must be several fibres: by the points on this one, at least.
constexpr std::size_t beside_by_on = 6;
/// Distance from the line by the distance along it, at most.
constexpr double off_line = 0.002;
/// Neighbours whose normal is asked for fibres that are not exact, how thick these may be by their breadth, points on
/// such a fibre, at most [count], and its length by its thickness, at least.
constexpr int fewest_across = 160, most_across = 2'560;
constexpr double most_thickness = 0.4, least_length = 3;
constexpr std::size_t most_on_fibre = 24;
/// Of the k on it and the next one beside it, the distances r and R from its line: k log(R / r) is that large by chance
/// at one place of fifty.
constexpr double least_evidence = 2.3;
/// Spread of the neighbours beside it, seen along the fibre: the second direction's by the first's, at least. Rows of a
/// scan and edges of a mesh lie in one surface with their neighbours.
constexpr double least_breadth = 0.4;
/// Points of a row are as far apart one as the other, or those of the next row begin where its own do; what noise
/// scatters does not: the least gap by the largest, at most, and share of the heights that others have, too.
constexpr double most_even = 0.5, same_height = 0.001, most_at_height = 0.4;
constexpr std::size_t asked_of_heights = 96; // of many some have the same by chance

/// The line of a fibre through a place.
struct Line
{
    Vector along;      ///< Unit.
    double radius = 0; ///< From it less on the fibre than beside it [length]; 0 if they lie exactly on it.

    double distance(const Vector& from) const { return (from - from.dot(along) * along).norm(); }
    bool has(const Vector& from) const { return distance(from) <= std::max(radius, off_line * from.norm()); }
};

/// A fibre through a place, and what is near that.
struct Fibre
{
    Vector along;                   ///< Unit.
    std::vector<Vector> on, beside; ///< Neighbours, from the place; nearest first.
};

/// One per thread. Keeps references.
class FibreSearch
{
public:
    FibreSearch(const Points& points, const BlockSearch& search) : points_(points), search_(search) {}

    /// The fibre through a place, if it is one among others.
    std::optional<Fibre> find(const Point& at)
    {
        std::optional<Line> line = find_exact(at);
        if (!line)
            line = find_along_normal(at);
        return line ? look_along(*line, at) : std::nullopt;
    }
    /// Whether there seems to be one along the surface there.
    bool lies_along_surface(const Point& at)
    {
        const std::optional<Vector> normal = find_normal(at);
        const std::optional<Line> line = normal ? find_along(at, normal->unitOrthogonal()) : std::nullopt;
        return line && look_along(*line, at).has_value();
    }
    /// Radius around the place that holds `count` points.
    double find_radius(const Point& at, int count)
    {
        find_neighbours(at, count);
        return std::sqrt(squared_[near_.size() - 1]);
    }

private:
    std::optional<Fibre> look_along(const Line& line, const Point& at)
    {
        Fibre fibre{line.along, {}, {}};
        const auto has_enough = [&]
        { return fibre.beside.size() >= std::max(fewest_beside, beside_by_on * fibre.on.size()); };
        for (int count = most_neighbours; count <= most_around && !has_enough(); count *= 2)
        {
            find_neighbours(at, count);
            fibre.on.clear();
            fibre.beside.clear();
            for (const int k : near_)
            {
                const Vector from = points_[std::size_t(k)] - at;
                (line.has(from) ? fibre.on : fibre.beside).push_back(from);
            }
        }
        return !fibre.beside.empty() && are_spread(fibre) && is_scattered(fibre)
                   ? std::optional<Fibre>(std::move(fibre))
                   : std::nullopt;
    }
    void find_neighbours(const Point& at, int count)
    {
        near_.resize(std::size_t(count));
        squared_.resize(near_.size());
        near_.resize(std::size_t(search_.nearest(at, count, near_.data(), squared_.data())));
    }
    /// That on which most of the neighbours lie, if there are enough.
    std::optional<Line> find_exact(const Point& at)
    {
        find_neighbours(at, most_neighbours);
        std::vector<Vector> directions;
        for (const int k : near_)
            if (const Vector from = points_[std::size_t(k)] - at; !from.isZero(0))
                directions.push_back(from.normalized());
        Vector best = Vector::Zero();
        std::ptrdiff_t most = fewest_on_fibre - 1;
        for (const Vector& direction : directions)
        {
            const auto count = std::count_if(directions.begin(), directions.end(),
                                             [&](const Vector& other) { return Line{direction}.has(other); });
            if (count > most)
            {
                most = count;
                best = direction;
            }
        }
        return best.isZero(0) ? std::nullopt : std::optional<Line>(Line{best});
    }
    /// Of the nearest, as many as lie flat.
    std::optional<Vector> find_normal(const Point& at)
    {
        for (int count = fewest_across; count <= most_across; count *= 4)
        {
            find_neighbours(at, count);
            Vector mean = Vector::Zero();
            Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
            for (const int k : near_)
            {
                const Vector from = points_[std::size_t(k)] - at;
                mean += from;
                squares += from * from.transpose();
            }
            mean /= double(near_.size());
            Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
            solver.computeDirect(squares / double(near_.size()) - mean * mean.transpose());
            if (solver.eigenvalues()[0] <= most_thickness * most_thickness * solver.eigenvalues()[1])
                return solver.eigenvectors().col(0);
        }
        return {};
    }
    /// That along the normal of what is around, about which some neighbours lie far nearer than others.
    std::optional<Line> find_along_normal(const Point& at)
    {
        const std::optional<Vector> normal = find_normal(at);
        return normal ? find_along(at, *normal) : std::nullopt;
    }
    /// That along a direction, of the neighbours found last.
    std::optional<Line> find_along(const Point& at, const Vector& direction) const
    {
        Line line{direction};
        std::vector<std::pair<double, double>> places; // distance from the line, height along it
        for (const int k : near_)
        {
            const Vector from = points_[std::size_t(k)] - at;
            places.emplace_back(line.distance(from), from.dot(line.along));
        }
        std::sort(places.begin(), places.end());
        double lowest = 0, highest = 0;
        for (std::size_t k = 1; k < std::min(most_on_fibre, places.size()) - 1; ++k) // the first is the place itself
        {
            const double here = places[k].first, next = places[k + 1].first;
            lowest = std::min(lowest, places[k].second);
            highest = std::max(highest, places[k].second);
            if (k >= fewest_on_fibre && here > 0 && double(k) * std::log(next / here) > least_evidence &&
                highest - lowest > least_length * here)
            {
                line.radius = std::sqrt(here * next);
                return line;
            }
        }
        return {};
    }
    static bool are_spread(const Fibre& fibre)
    {
        const Vector u = fibre.along.unitOrthogonal(), v = fibre.along.cross(u);
        Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
        for (const Vector& from : fibre.beside)
        {
            const Eigen::Vector2d seen(from.dot(u), from.dot(v));
            squares += seen * seen.transpose();
        }
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
        solver.computeDirect(squares, Eigen::EigenvaluesOnly);
        return solver.eigenvalues()[0] >= least_breadth * least_breadth * solver.eigenvalues()[1];
    }
    static bool is_scattered(const Fibre& fibre)
    {
        std::vector<double> heights;
        for (const Vector& from : fibre.on)
            heights.push_back(from.dot(fibre.along));
        std::sort(heights.begin(), heights.end());
        const double length = heights.back() - heights.front();
        double least = length, largest = 0;
        for (std::size_t k = 1; k < heights.size(); ++k)
        {
            least = std::min(least, heights[k] - heights[k - 1]);
            largest = std::max(largest, heights[k] - heights[k - 1]);
        }
        const auto nearest = fibre.beside.begin() + std::ptrdiff_t(std::min(asked_of_heights, fibre.beside.size()));
        const auto is_shared = [&](double height)
        {
            return std::any_of(fibre.beside.begin(), nearest,
                               [&](const Vector& from)
                               { return std::abs(from.dot(fibre.along) - height) < same_height * length; });
        };
        return least <= most_even * largest && double(std::count_if(heights.begin(), heights.end(), is_shared)) <=
                                                   most_at_height * double(heights.size());
    }

    const Points& points_;
    const BlockSearch& search_;
    std::vector<int> near_; ///< Of the search before.
    std::vector<double> squared_;
};

} // namespace

bool has_noisy_fibres(const Points& points, const BlockSearch& search, int threads)
{
    if (points.size() < fewest_points)
        return false;
    const auto count_places = [&](std::size_t first, std::size_t last, const auto& is_one)
    {
        std::vector<char> are(last - first);
        const auto look = [&](std::size_t k)
        {
            const std::size_t place = (first + k) * stride % asked;
            FibreSearch fibres(points, search);
            are[k] = is_one(fibres, points[(2 * place + 1) * points.size() / (2 * asked)]);
        };
        parallel_for(are.size(), threads, {}, look, 8);
        return double(std::count(are.begin(), are.end(), 1));
    };
    const auto is_on_fibre = [](FibreSearch& fibres, const Point& at) { return fibres.find(at).has_value(); };
    double found = count_places(0, asked_first, is_on_fibre);
    if (found < least_share_first * double(asked_first))
        return false;
    found += count_places(asked_first, asked, is_on_fibre);
    if (found <= least_share * double(asked))
        return false;
    const double by_chance =
        count_places(0, asked, [](FibreSearch& fibres, const Point& at) { return fibres.lies_along_surface(at); });
    return by_chance <= most_by_chance * found && found - by_chance > least_share_left * double(asked);
}

std::vector<double> find_noisy_fibres(const Points& points, const BlockSearch& search, const Points& seeds, int threads)
{
    if (!has_noisy_fibres(points, search, threads))
        return {};
    std::vector<double> reach(seeds.size());
    const auto look = [&](std::size_t i)
    {
        FibreSearch fibres(points, search);
        if (const std::optional<Fibre> fibre = fibres.find(seeds[i]))
            reach[i] = fibres.find_radius(seeds[i], int(fibres_in_reach * double(fibre->on.size())));
    };
    parallel_for(seeds.size(), threads, {}, look, 8);
    return reach;
}

} // namespace recon
