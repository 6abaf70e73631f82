#include "noisy_planes.h"

#include <recon/block_search.h>
#include <recon/parallel.h>
#include <recon/scramble.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr int most_seeds = 400, most_planes = 40;
/// Points around a seed among which planes are looked for: as few as a small rim has, and more where that is a straight
/// piece of a large one.
constexpr int surroundings[] = {48, 160, 512};
constexpr int triples = 40, fewest_members = 30;
/// Share of the disc around a seed that is bare.
constexpr double bare_share = 0.3;
/// A point found beside the slab weighs as much against a plane.
constexpr double weight_beside = 2;
struct Candidate
{
    NoisyPlane plane;
    Point seed = Point::Zero();
    double radius = 0, support = 0;
};

bool is_inside(const NoisyPlane& plane, const Point& p, double noise)
{
    return std::abs(plane.height(p)) <= slab_half * noise;
}

/// Points in the slab less those beside it; 0 if they fill the slab evenly.
double measure_support(const NoisyPlane& plane, const Points& points, const std::vector<int>& around, double noise)
{
    double support = 0, count = 0, squared = 0;
    for (const int i : around)
    {
        const double height = std::abs(plane.height(points[i])) / noise;
        if (height <= slab_half)
        {
            ++count;
            squared += height * height;
        }
        else if (height <= 2 * slab_half)
            support -= weight_beside;
    }
    return squared > widest_spread * widest_spread * count ? 0 : support + count;
}

class PlaneFinder
{
public:
    PlaneFinder(const Points& points, double noise) : points_(points), noise_(noise), search_(points) {}

    std::vector<NoisyPlane> find(int threads) const
    {
        const int n = int(points_.size());
        const int count = std::min(n, most_seeds);
        std::vector<Candidate> candidates(std::size_t(count) * std::size(surroundings));
        parallel_for(
            candidates.size(), threads, {},
            [&](std::size_t k)
            {
                const auto seed = int(std::int64_t(k / std::size(surroundings)) * n / count);
                candidates[k] = look_around(seed, surroundings[k % std::size(surroundings)]);
            },
            1);
        parallel_for(
            candidates.size(), threads, {},
            [&](std::size_t k)
            {
                if (candidates[k].support > 0)
                    grow(candidates[k]);
            },
            1);
        std::stable_sort(candidates.begin(), candidates.end(),
                         [](const Candidate& a, const Candidate& b) { return a.support > b.support; });
        std::vector<NoisyPlane> found;
        for (Candidate& c : candidates)
        {
            if (c.support < fewest_members || int(found.size()) >= most_planes)
                break;
            if (!is_known(c, found))
                found.push_back(c.plane);
        }
        return found;
    }

private:
    Candidate look_around(int seed, int count) const
    {
        count = std::min(count, int(points_.size()));
        std::vector<int> around(static_cast<std::size_t>(count));
        std::vector<double> squared(static_cast<std::size_t>(count));
        search_.nearest(points_[seed], count, around.data(), squared.data());
        Candidate best;
        best.seed = points_[seed];
        best.radius = std::sqrt(squared.back());
        std::uint64_t random = scramble(std::uint64_t(seed) * 1000 + std::uint64_t(count));
        const auto draw = [&] { return points_[around[(random = scramble(random)) % std::uint64_t(count)]]; };
        for (int k = 0; k < triples; ++k)
        {
            NoisyPlane plane;
            plane.origin = points_[seed];
            const Vector u = draw() - plane.origin, v = draw() - plane.origin;
            plane.normal = u.cross(v);
            const double twice = plane.normal.norm();
            // Long and thin, or small: noise turns it.
            if (twice < 4 * noise_ * std::max(u.norm(), v.norm()))
                continue;
            plane.normal /= twice;
            if (!refit_plane(plane, points_, around, noise_) || !refit_plane(plane, points_, around, noise_))
                continue;
            const double support = measure_support(plane, points_, around, noise_);
            if (support > best.support && is_inside(plane, best.seed, noise_))
            {
                best.plane = plane;
                best.support = support;
            }
        }
        if (best.support < fewest_members || !has_bare_ground(best))
            best.support = 0;
        return best;
    }

    /// Whether much of the disc is farther from all points than points spread evenly over it are from each other.
    bool has_bare_ground(const Candidate& c) const
    {
        const Vector first = c.plane.normal.unitOrthogonal(), second = c.plane.normal.cross(first);
        const Point centre = c.seed - c.plane.height(c.seed) * c.plane.normal;
        const double apart = std::max(3 * c.radius / std::sqrt(c.support), 4 * noise_);
        constexpr int asked = 64;
        int bare = 0;
        for (int k = 0; k < asked; ++k)
        {
            // Evenly over the disc, by the golden angle.
            const double radius = 0.8 * c.radius * std::sqrt((k + 0.5) / asked), angle = k * pi * (3 - std::sqrt(5.0));
            const Point q = centre + radius * (std::cos(angle) * first + std::sin(angle) * second);
            bare += (points_[search_.nearest(q)] - q).norm() > apart;
        }
        return bare > bare_share * asked;
    }

    void grow(Candidate& c) const
    {
        std::vector<int> around;
        NoisyPlane plane = c.plane;
        for (double radius = 1.5 * c.radius; radius < 2; radius *= 1.5)
        {
            search_.within(c.seed, radius, around);
            // Twice as wide at first: the rim of what was fitted so far bends away.
            if (!refit_plane(plane, points_, around, 1.5 * noise_) || !refit_plane(plane, points_, around, noise_))
                return;
            const double support = measure_support(plane, points_, around, noise_);
            if (support <= 0.9 * c.support)
                return;
            c.support = support;
            c.plane = plane;
            c.radius = radius;
        }
    }

    bool is_known(const Candidate& c, const std::vector<NoisyPlane>& found) const
    {
        const Vector first = c.plane.normal.unitOrthogonal(), second = c.plane.normal.cross(first);
        const Point centre = c.seed - c.plane.height(c.seed) * c.plane.normal;
        return std::any_of(found.begin(), found.end(),
                           [&](const NoisyPlane& known)
                           {
                               double worst = 0;
                               for (const Vector& off : {first, second, Vector(-first), Vector(-second)})
                                   worst = std::max(worst, std::abs(known.height(centre + c.radius * off)));
                               return worst < slab_half * noise_;
                           });
    }

    const Points& points_;
    double noise_;
    BlockSearch search_;
};

} // namespace

bool refit_plane(NoisyPlane& plane, const Points& points, const std::vector<int>& around, double noise)
{
    Point centre = Point::Zero();
    double count = 0;
    for (const int i : around)
        if (is_inside(plane, points[i], noise))
        {
            centre += points[i];
            ++count;
        }
    if (count < 4)
        return false;
    centre /= count;
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const int i : around)
        if (is_inside(plane, points[i], noise))
            spread += (points[i] - centre) * (points[i] - centre).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread / count);
    plane.origin = centre;
    plane.normal = solver.eigenvectors().col(0);
    // On a line or in a blob no plane is told from others.
    return solver.eigenvalues()[1] > 4 * noise * noise;
}

std::vector<NoisyPlane> find_noisy_planes(const Points& points, double noise, int threads)
{
    return PlaneFinder(points, noise).find(threads);
}

} // namespace recon
