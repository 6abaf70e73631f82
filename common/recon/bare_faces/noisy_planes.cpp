#include <recon/bare_faces/noisy_planes.h>

#include <recon/parallel.h>
#include <recon/scramble.h>
#include <recon/search/block_search.h>
#include <recon/simd.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace recon
{

template <class Number>
struct SlabSumsOf
{
    Number count = {}, squared_heights = {}, beside = {};
    Number first[3] = {}, second[6] = {}; ///< Moments: x, y, z; xx, xy, xz, yy, yz, zz.
};
/// Sums over the points of a slab, and what lies just beside it.
struct SlabSums : SlabSumsOf<double>
{
};

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

/// Over points with n . p - offset within `half`. What is beside it lies within twice that. \param is_point 0 where
/// the arrays are padded.
RECON_VECTOR_CLONES
void sum_slab(const double* px, const double* py, const double* pz, const double* is_point, int size, double nx,
              double ny, double nz, double offset, double half, SlabSums* sums)
{
    using simd::HalfLanes;
    SlabSumsOf<HalfLanes> parts[2];
    // One half of each Lanes after the other: AVX2 has sixteen registers, which hold the sums of one.
    for (int part = 0; part < 2; ++part)
    {
        const HalfLanes nothing = {};
        SlabSumsOf<HalfLanes> own;
        for (int i = part * simd::lane_count / 2; i < size; i += simd::lane_count)
        {
            const HalfLanes x = simd::load_half(px + i), y = simd::load_half(py + i), z = simd::load_half(pz + i),
                            one = simd::load_half(is_point + i);
            const HalfLanes height = nx * x + ny * y + nz * z - offset, h = height < nothing ? -height : height;
            const HalfLanes in = h <= half ? one : nothing, wx = in * x, wy = in * y, wz = in * z;
            own.count += in;
            own.squared_heights += in * h * h;
            own.beside += h <= 2 * half ? one - in : nothing;
            own.first[0] += wx;
            own.first[1] += wy;
            own.first[2] += wz;
            own.second[0] += wx * x;
            own.second[1] += wx * y;
            own.second[2] += wx * z;
            own.second[3] += wy * y;
            own.second[4] += wy * z;
            own.second[5] += wz * z;
        }
        parts[part] = own;
    }
    const auto& [low, high] = parts;
    sums->count = simd::sum(low.count, high.count);
    sums->squared_heights = simd::sum(low.squared_heights, high.squared_heights);
    sums->beside = simd::sum(low.beside, high.beside);
    for (int k = 0; k < 3; ++k)
        sums->first[k] = simd::sum(low.first[k], high.first[k]);
    for (int k = 0; k < 6; ++k)
        sums->second[k] = simd::sum(low.second[k], high.second[k]);
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
            std::size_t(count), threads, {},
            [&](std::size_t k)
            { look_around(int(std::int64_t(k) * n / count), &candidates[k * std::size(surroundings)]); },
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
    /// Writes a candidate for each of the surroundings.
    void look_around(int seed, Candidate* candidates) const
    {
        const int most = std::min(*std::rbegin(surroundings), int(points_.size()));
        std::vector<int> around(static_cast<std::size_t>(most));
        std::vector<double> squared(static_cast<std::size_t>(most));
        search_.nearest(points_[seed], most, around.data(), squared.data());
        for (std::size_t k = std::size(surroundings); k-- > 0;) // the nearest of those before
        {
            around.resize(std::size_t(std::min(surroundings[k], most)));
            candidates[k] = find_plane(seed, around, std::sqrt(squared[around.size() - 1]));
        }
    }

    Candidate find_plane(int seed, const std::vector<int>& around, double radius) const
    {
        const PointsOfPlanes fitted(points_, around);
        Candidate best;
        best.seed = points_[seed];
        best.radius = radius;
        std::uint64_t random = scramble(std::uint64_t(seed) * 1000 + around.size());
        const auto draw = [&] { return points_[around[(random = scramble(random)) % around.size()]]; };
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
            if (!fitted.refit(plane, noise_) || !fitted.refit(plane, noise_))
                continue;
            const double support = fitted.measure_support(plane, noise_);
            if (support > best.support && std::abs(plane.height(best.seed)) <= slab_half * noise_)
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
            const PointsOfPlanes fitted(points_, around);
            if (!fitted.refit(plane, 1.5 * noise_) || !fitted.refit(plane, noise_))
                return;
            const double support = fitted.measure_support(plane, noise_);
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

PointsOfPlanes::PointsOfPlanes(const Points& points, const std::vector<int>& chosen)
    : size_(simd::padded(int(chosen.size()))), base_(chosen.empty() ? Point::Zero() : points[chosen.front()])
{
    for (auto* values : {&x_, &y_, &z_, &is_point_})
        values->assign(std::size_t(size_), 0);
    for (std::size_t i = 0; i < chosen.size(); ++i)
    {
        const Vector p = points[chosen[i]] - base_;
        x_[i] = p.x();
        y_[i] = p.y();
        z_[i] = p.z();
        is_point_[i] = 1;
    }
}

bool PointsOfPlanes::refit(NoisyPlane& plane, double noise) const
{
    SlabSums sums;
    sum(plane, noise, &sums);
    if (sums.count < 4)
        return false;
    const Vector centre = Eigen::Map<const Vector>(sums.first) / sums.count;
    const auto& [xx, xy, xz, yy, yz, zz] = sums.second;
    Eigen::Matrix3d spread;
    spread << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(spread / sums.count - centre * centre.transpose());
    plane.origin = base_ + centre;
    const Vector normal = solver.eigenvectors().col(0);
    plane.normal = normal.dot(plane.normal) < 0 ? Vector(-normal) : normal;
    // On a line or in a blob no plane is told from others.
    return solver.eigenvalues()[1] > 4 * noise * noise;
}

double PointsOfPlanes::measure_support(const NoisyPlane& plane, double noise) const
{
    SlabSums sums;
    sum(plane, noise, &sums);
    const bool is_even = sums.squared_heights > widest_spread * widest_spread * noise * noise * sums.count;
    return is_even ? 0 : sums.count - weight_beside * sums.beside;
}

void PointsOfPlanes::sum(const NoisyPlane& plane, double noise, SlabSums* sums) const
{
    const Vector& n = plane.normal;
    sum_slab(x_.data(), y_.data(), z_.data(), is_point_.data(), size_, n.x(), n.y(), n.z(), n.dot(plane.origin - base_),
             slab_half * noise, sums);
}

std::vector<NoisyPlane> find_noisy_planes(const Points& points, double noise, int threads)
{
    return PlaneFinder(points, noise).find(threads);
}

} // namespace recon
