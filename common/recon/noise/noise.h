#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <memory>
#include <vector>

namespace recon
{

/// Options of estimate_noise().
struct NoiseOptions
{
    int seeds =
        0; ///< Places at which to estimate [count], >= 0. 0 = automatic, 1,000 to 3,000 by the number of points.
    int threads = 0; ///< Threads to use [count], >= 0. 0 = all cores. The result does not depend on it.
};

/// Local noise and density of a cloud that samples a surface, at seeds spread over it. Lengths are in input units.
/// Copies share their data; queries may run on many threads at once.
class NoiseEstimate
{
public:
    NoiseEstimate(Points seeds, std::vector<double> sigma, std::vector<double> density);

    int size() const;
    const Points& seeds() const;
    /// Per seed: standard deviation of the points' distances to the surface [length], >= 0.
    const std::vector<double>& sigma() const;
    /// Per seed: distinct points per area of the surface [1 / length^2], > 0.
    const std::vector<double>& density() const;
    int nearest_seed(const Point& query) const;

    double sigma_at(const Point& query) const { return sigma()[nearest_seed(query)]; }
    /// Edge of the square that holds one point: 1 / sqrt(density) [length].
    double spacing_at(const Point& query) const;
    double median_sigma() const;   ///< Over the seeds [length].
    double most_sigma() const;     ///< That one seed in fifty exceeds [length].
    double median_spacing() const; ///< Over the seeds [length].
    /// Noise that nine of ten seeds exceed [spacings of the place]: corners and thin walls read as noise, but seldom
    /// everywhere.
    double least_noise() const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

/// Estimates noise and density without normals: around each seed the scale is enlarged until the neighbourhood is
/// clearly wider than what a quadric leaves unexplained, so that it is a piece of surface and not the inside of a slab
/// of noise; medians over neighbouring seeds suppress outliers. Of sheets one above the other, such as fins, it is the
/// noise of one, see sheet_stack.h; of lines whose noise lies in planes through them, that across these, and points
/// count as far apart as the lines, see noisy_lines.h. Equal points count once. Does not depend on the order of the
/// points. With noise far below the spacing the value tells how far the points stray from smooth quadrics instead.
/// \throws InvalidInput for no points, a point that is not finite or an option out of range. \throws Cancelled.
NoiseEstimate estimate_noise(const Points& points, const NoiseOptions& options = {}, const Progress& progress = {});

} // namespace recon
