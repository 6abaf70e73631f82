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
/// Places asked [count], and the share of them that must lie on fibres: 0.26 at most of 1,279 models and scans, mostly
/// parts of CAD programs; 0.65 and more of copies along normals, 0.47 and more along one axis.
constexpr std::size_t asked = 200;
constexpr double least_share = 0.35;
/// Neighbours among which a fibre is sought, and others on it, at least; neighbours that must lie beside it, and of how
/// many these are sought [count].
constexpr int most_neighbours = 48, fewest_on_fibre = 2, most_around = 1'536;
constexpr std::size_t fewest_beside = 24;
/// Distance from the line by the distance along it, at most.
constexpr double off_line = 0.002;
/// Spread of the neighbours beside it, seen along the fibre: the second direction's by the first's, at least. Rows of a
/// scan and edges of a mesh lie in one surface with their neighbours.
constexpr double least_breadth = 0.4;
/// Points of a row are as far apart one as the other, or those of the next row begin where its own do; what noise
/// scatters does not: the least gap by the largest, at most, and share of the heights that others have, too.
constexpr double most_even = 0.5, same_height = 0.001, most_at_height = 0.4;

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
        const std::optional<Vector> along = find_direction(at);
        if (!along)
            return {};
        Fibre fibre{*along, {}, {}};
        for (int count = most_neighbours; count <= most_around && fibre.beside.size() < fewest_beside; count *= 2)
        {
            find_neighbours(at, count);
            fibre.on.clear();
            fibre.beside.clear();
            for (const int k : near_)
            {
                const Vector from = points_[std::size_t(k)] - at;
                (is_along(from, *along) ? fibre.on : fibre.beside).push_back(from);
            }
        }
        return !fibre.beside.empty() && are_spread(fibre) && is_scattered(fibre)
                   ? std::optional<Fibre>(std::move(fibre))
                   : std::nullopt;
    }
    /// Radius around the place that holds `count` points.
    double find_radius(const Point& at, int count)
    {
        find_neighbours(at, count);
        return std::sqrt(squared_[near_.size() - 1]);
    }

private:
    static bool is_along(const Vector& from, const Vector& line)
    {
        const double length = from.dot(line);
        return from.squaredNorm() - length * length <= off_line * off_line * from.squaredNorm();
    }
    void find_neighbours(const Point& at, int count)
    {
        near_.resize(std::size_t(count));
        squared_.resize(near_.size());
        near_.resize(std::size_t(search_.nearest(at, count, near_.data(), squared_.data())));
    }
    /// In which most of the neighbours lie, if there are enough.
    std::optional<Vector> find_direction(const Point& at)
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
                                             [&](const Vector& other) { return is_along(other, direction); });
            if (count > most)
            {
                most = count;
                best = direction;
            }
        }
        return best.isZero(0) ? std::nullopt : std::optional<Vector>(best);
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
        const auto is_shared = [&](double height)
        {
            return std::any_of(fibre.beside.begin(), fibre.beside.end(),
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
    std::vector<char> is_on_fibre(asked);
    const auto look = [&](std::size_t k) {
        is_on_fibre[k] =
            FibreSearch(points, search).find(points[(2 * k + 1) * points.size() / (2 * asked)]).has_value();
    };
    parallel_for(asked, threads, {}, look, 8);
    return double(std::count(is_on_fibre.begin(), is_on_fibre.end(), 1)) > least_share * double(asked);
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
