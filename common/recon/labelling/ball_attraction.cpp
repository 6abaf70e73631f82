#include <recon/labelling/ball_attraction.h>

#include <recon/parallel.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b)
{
    return a.x() * b.y() - a.y() * b.x();
}

/// Signed area of disc and triangle (origin, a, b).
double intersect_disc_with_wedge(double radius, const Eigen::Vector2d& a, const Eigen::Vector2d& b)
{
    const double r2 = radius * radius;
    const auto sector = [&](const Eigen::Vector2d& p, const Eigen::Vector2d& q)
    { return 0.5 * r2 * std::atan2(cross(p, q), p.dot(q)); };
    const Eigen::Vector2d d = b - a;
    const double length2 = d.squaredNorm();
    if (length2 == 0)
        return 0;
    const bool a_inside = a.squaredNorm() <= r2, b_inside = b.squaredNorm() <= r2;
    if (a_inside && b_inside)
        return 0.5 * cross(a, b);
    // a + t d on the circle.
    const double middle = -a.dot(d) / length2;
    const double root2 = middle * middle - (a.squaredNorm() - r2) / length2;
    if (root2 <= 0)
        return sector(a, b);
    const double root = std::sqrt(root2), enter = middle - root, leave = middle + root;
    if (a_inside)
    {
        const Eigen::Vector2d out = a + std::clamp(leave, 0.0, 1.0) * d;
        return 0.5 * cross(a, out) + sector(out, b);
    }
    if (b_inside)
    {
        const Eigen::Vector2d in = a + std::clamp(enter, 0.0, 1.0) * d;
        return sector(a, in) + 0.5 * cross(in, b);
    }
    if (enter >= 1 || leave <= 0)
        return sector(a, b);
    const Eigen::Vector2d in = a + enter * d, out = a + leave * d;
    return sector(a, in) + 0.5 * cross(in, out) + sector(out, b);
}

/// Discs that hold few samples prove little: their weight fades, but never below a quarter.
double evidence(double samples_in_disc)
{
    return std::max(0.25, 1 - 5 / samples_in_disc);
}

/// Discs with more samples may merge their balls at once.
constexpr double telling_samples = 10;

/// Weighs pairs of neighbouring balls, one after the other.
class PairWeigher
{
public:
    PairWeigher(const Triangulation& regular, const std::vector<Ball>& balls, const std::vector<double>& density,
                const std::vector<char>& is_on_hull, const BallAttractionOptions& options)
        : regular_(regular), balls_(balls), density_(density), is_on_hull_(is_on_hull), options_(options)
    {
    }

    /// The balls at positions i and j of a cell, if this is the lowest of the cells around their power facet.
    void weigh(int c, int i, int j, BallAttraction& out)
    {
        if (!regular_.can_be_lowest(c, i, j))
            return;
        const int a = regular_.cells[c].vertices[i], b = regular_.cells[c].vertices[j];
        const Ball &first = balls_[a], &second = balls_[b];
        const Vector axis = second.centre - first.centre;
        const double squared = axis.squaredNorm();
        const double r1 = first.radius, r2 = second.radius;
        // The disc's radius squared times 4 squared.
        const double twice_along = squared + r1 * r1 - r2 * r2;
        const double scaled_disc2 = 4 * squared * r1 * r1 - twice_along * twice_along;
        if (!(scaled_disc2 > 0) || (is_on_hull_[a] && is_on_hull_[b]))
            return;
        if (!regular_.list_ring_from_lowest(c, a, b, ring_))
            return;

        const double distance = std::sqrt(squared), along = twice_along / (2 * distance);
        const double disc2 = scaled_disc2 / (4 * squared);
        const double cosine = (r1 * r1 + r2 * r2 - squared) / (2 * r1 * r2);
        if (options_.deep_intersection > 0)
        {
            if (cosine > options_.deep_intersection)
                out.edges.push_back({a, b, cosine});
            return;
        }
        // Of a big ball that touches fine and coarse parts the other ball knows at which of them the two meet.
        const double lambda = std::min(density_[a], density_[b]);
        const double in_disc = lambda * pi * disc2;
        if (cosine > options_.merge_above && in_disc > telling_samples)
        {
            out.edges.push_back({a, b, 0.5 * in_disc * evidence(in_disc)});
            out.merged.push_back({a, b});
            return;
        }
        const Vector u = axis / distance;
        const double weight =
            lambda * std::min(cut_disc(first.centre + along * u, u, disc2), pi * disc2) * evidence(in_disc);
        if (weight > 0)
            out.edges.push_back({a, b, weight});
    }

private:
    /// Area in which the power facet, whose corners are the centres of the ring's cells, cuts the disc.
    double cut_disc(const Point& centre, const Vector& normal, double squared_radius)
    {
        const Vector e1 = normal.unitOrthogonal(), e2 = normal.cross(e1);
        polygon_.clear();
        for (const int k : ring_)
        {
            const Vector d = regular_.centres[k] - centre;
            polygon_.emplace_back(d.dot(e1), d.dot(e2));
        }
        return std::abs(intersect_disc_with_polygon(std::sqrt(squared_radius), polygon_));
    }

    const Triangulation& regular_;
    const std::vector<Ball>& balls_;
    const std::vector<double>& density_;
    const std::vector<char>& is_on_hull_;
    const BallAttractionOptions& options_;
    std::vector<int> ring_; ///< Cells around the pair last asked for.
    std::vector<Eigen::Vector2d> polygon_;
};

} // namespace

double intersect_disc_with_polygon(double radius, const std::vector<Eigen::Vector2d>& polygon)
{
    double area = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i)
        area += intersect_disc_with_wedge(radius, polygon[i], polygon[(i + 1) % polygon.size()]);
    return area;
}

BallAttraction weigh_attraction(const Triangulation& regular, const std::vector<Ball>& balls,
                                const std::vector<double>& density, const BallAttractionOptions& options,
                                const Progress& progress)
{
    BallAttraction result;
    result.is_on_hull.assign(balls.size(), 0);
    for (std::size_t c = std::size_t(regular.finite_cells); c < regular.cells.size(); ++c)
        for (const int v : regular.cells[c].vertices)
            if (v != Triangulation::infinite)
                result.is_on_hull[v] = 1;

    constexpr std::size_t grain = 2048;
    const std::size_t cells = std::size_t(regular.finite_cells);
    std::vector<BallAttraction> chunks((cells + grain - 1) / grain);
    const auto weigh_chunk = [&](std::size_t begin, std::size_t end)
    {
        PairWeigher weigher(regular, balls, density, result.is_on_hull, options);
        for (std::size_t c = begin; c < end; ++c)
            for (int i = 0; i < 4; ++i)
                for (int j = i + 1; j < 4; ++j)
                    weigher.weigh(int(c), i, j, chunks[begin / grain]);
    };
    parallel_chunks(cells, options.threads, grain, progress, weigh_chunk);
    std::size_t total = 0;
    for (const BallAttraction& chunk : chunks)
        total += chunk.edges.size();
    result.edges.reserve(total);
    for (const BallAttraction& chunk : chunks)
    {
        result.edges.insert(result.edges.end(), chunk.edges.begin(), chunk.edges.end());
        result.merged.insert(result.merged.end(), chunk.merged.begin(), chunk.merged.end());
    }
    return result;
}

} // namespace recon
