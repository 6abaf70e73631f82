#include "shapes.h"

#include <cmath>

/// Noise on the points of any shape.
namespace shapes
{
namespace
{

using recon::OrientedSamples;
using recon::Point;
using recon::Points;

constexpr double pi = 3.14159265358979323846;

double gaussian(Random& random)
{
    // Box-Muller, since std::normal_distribution differs between standard libraries.
    const double first = uniform(random), second = uniform(random);
    return std::sqrt(-2 * std::log(1 - first)) * std::cos(2 * pi * second);
}

} // namespace

Points with_noise(const Points& points, double sigma, std::uint64_t seed)
{
    Random random(seed);
    Points result = points;
    for (Point& p : result)
        for (int k = 0; k < 3; ++k)
            p[k] += sigma * gaussian(random);
    return result;
}

Points with_noise_where(const std::function<bool(const Point&)>& is_noisy, const Points& points, double sigma,
                        std::uint64_t seed)
{
    Points result = with_noise(points, sigma, seed);
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!is_noisy(points[i]))
            result[i] = points[i];
    return result;
}

Points with_noise_beyond(double x, const Points& points, double sigma, std::uint64_t seed)
{
    return with_noise_where([&](const Point& p) { return p.x() > x; }, points, sigma, seed);
}

Points with_noisy_share(double share, const Points& points, double sigma, std::uint64_t seed)
{
    Random random(seed + 1);
    return with_noise_where([&](const Point&) { return uniform(random) < share; }, points, sigma, seed);
}

Points noisy_copies(const Points& points, double sigma, int copies, std::uint64_t seed)
{
    Points result;
    for (int copy = 0; copy < copies; ++copy)
        for (const Point& p : with_noise(points, sigma, seed + std::uint64_t(copy)))
            result.push_back(p);
    return result;
}

Points with_noisy_copies(const Points& points, double sigma, int copies, std::uint64_t seed)
{
    Random random(seed);
    Points result = points;
    result.reserve(points.size() * std::size_t(copies + 1));
    for (const Point& p : points)
        for (int c = 0; c < copies; ++c)
        {
            Point q = p;
            for (int k = 0; k < 3; ++k)
                q[k] += sigma * gaussian(random);
            result.push_back(q);
        }
    return result;
}

OrientedSamples copies_along_normals(const OrientedSamples& samples, double sigma, int copies, std::uint64_t seed)
{
    Random random(seed);
    OrientedSamples result;
    for (std::size_t i = 0; i < samples.points.size(); ++i)
        for (int k = 0; k < copies; ++k)
        {
            result.points.push_back(samples.points[i] + sigma * gaussian(random) * samples.normals[i]);
            result.normals.push_back(samples.normals[i]);
        }
    return result;
}

Pipe pipe(double wall, double noise, std::uint64_t seed)
{
    constexpr int samples = 4000;
    constexpr double radius = 1, half_length = 1.5;
    const double spacing = std::sqrt(8 * pi * radius * half_length / samples); // nearly
    Pipe result;
    result.samples = tube(samples, radius, wall * spacing, half_length, seed);
    result.noisy = noise > 0 ? with_noise(result.samples.points, noise * spacing, seed + 1) : result.samples.points;
    result.volume = 4 * pi * (radius - wall * spacing / 2) * wall * spacing * half_length;
    return result;
}

} // namespace shapes
