#include <recon/noise.h>

#include <recon/errors.h>
#include <recon/neighbours.h>
#include <recon/parallel.h>
#include <recon/spatial_order.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace recon
{

struct NoiseEstimate::Data
{
    Data(Points s, std::vector<double> noise, std::vector<double> d)
        : seeds(std::move(s)), sigma(std::move(noise)), density(std::move(d)), search(seeds)
    {
    }
    Points seeds;
    std::vector<double> sigma, density;
    NeighbourSearch search;
};

NoiseEstimate::NoiseEstimate(Points seeds, std::vector<double> sigma, std::vector<double> density)
    : data_(std::make_shared<const Data>(std::move(seeds), std::move(sigma), std::move(density)))
{
}
int NoiseEstimate::size() const
{
    return int(data_->seeds.size());
}
const Points& NoiseEstimate::seeds() const
{
    return data_->seeds;
}
const std::vector<double>& NoiseEstimate::sigma() const
{
    return data_->sigma;
}
const std::vector<double>& NoiseEstimate::density() const
{
    return data_->density;
}
int NoiseEstimate::nearest_seed(const Point& query) const
{
    return data_->search.nearest(query);
}
double NoiseEstimate::spacing_at(const Point& query) const
{
    return 1 / std::sqrt(density()[nearest_seed(query)]);
}

namespace
{

double median(std::vector<double> values)
{
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace

double NoiseEstimate::median_sigma() const
{
    return median(sigma());
}
double NoiseEstimate::median_spacing() const
{
    return 1 / std::sqrt(median(density()));
}

namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr int smallest_count = 18; // three points per coefficient of the quadric
constexpr int largest_count = 2400;
constexpr int many = 150; // neighbours; beyond it a subsample does
constexpr double growth = 1.5;
/// A neighbourhood this many residuals wide is a piece of surface rather than the inside of the noise.
constexpr double flatness = 4;
/// The residual at the scale chosen is a little below the noise, since a ball cuts off its tails.
constexpr double truncation = 1.04;
constexpr int smoothing_seeds = 21;

struct QuadricFit
{
    double residual; ///< Root mean square.
    Point foot;      ///< Of the first neighbour, along the normal of the principal frame.
};

/// Best quadric over the first `count` neighbours, in their principal frame; `seed` is where its foot is wanted.
QuadricFit fit_quadric(const Points& points, const Point& seed, const int* neighbours, int count, double radius)
{
    constexpr int coefficients = 6;
    if (count <= coefficients || !(radius > 0))
        return {0, seed};
    Vector mean = Vector::Zero();
    for (int i = 0; i < count; ++i)
        mean += points[neighbours[i]] - seed;
    mean /= count;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (int i = 0; i < count; ++i)
    {
        const Vector d = (points[neighbours[i]] - seed - mean) / radius;
        covariance += d * d.transpose();
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(covariance);
    const Eigen::Matrix3d frame = solver.eigenvectors();

    using Row = Eigen::Matrix<double, coefficients, 1>;
    const auto row_at = [](const Vector& u)
    {
        Row row;
        row << 1, u[1], u[2], u[1] * u[1], u[1] * u[2], u[2] * u[2];
        return row;
    };
    Eigen::Matrix<double, coefficients, coefficients> normal_matrix;
    normal_matrix.setZero();
    Row right = Row::Zero();
    double squares = 0;
    for (int i = 0; i < count; ++i)
    {
        const Vector u = frame.transpose() * ((points[neighbours[i]] - seed - mean) / radius);
        const Row row = row_at(u);
        normal_matrix += row * row.transpose();
        right += row * u[0];
        squares += u[0] * u[0];
    }
    // Keeps collinear neighbours (scan lines) solvable; far below any noise.
    normal_matrix.diagonal().array() += 1e-12 * count;
    const Row solution = normal_matrix.ldlt().solve(right);
    const double rest = squares - solution.dot(right);
    const Vector at_seed = frame.transpose() * (-mean / radius);
    const double height = std::clamp(row_at(at_seed).dot(solution) - at_seed[0], -1.0, 1.0);
    return {radius * std::sqrt(std::max(0.0, rest) / (count - coefficients)), seed + radius * height * frame.col(0)};
}

struct Local
{
    double sigma, density;
};

/// What a Gaussian slab shows inside a ball of radius R around its middle: at height z the ball cuts a disc of area
/// pi (R^2 - z^2), so that the variance falls to (1 - 3 t) / (1 - t) and the count to 1 - t, t = sigma^2 / R^2.
Local correct_for_ball(double residual, int count, double radius)
{
    const double squared = std::max(radius * radius, 1e-300);
    double t = 0;
    for (int i = 0; i < 8; ++i)
        t = std::min(1.0 / 9, residual * residual / squared * (1 - t) / (1 - 3 * t));
    return {std::sqrt(t) * radius, count / (pi * squared * (1 - t))};
}

/// The cloud and even subsamples of it: many neighbours of the whole are as well described by fewer of a subsample.
struct Pyramid
{
    static constexpr int step = 4;
    std::vector<Points> levels;
    std::vector<NeighbourSearch> searches;

    explicit Pyramid(Points points)
    {
        levels.reserve(16); // the searches keep references
        levels.push_back(std::move(points));
        while (levels.back().size() > std::size_t(step * largest_count) && levels.size() < 4)
        {
            const Points& finer = levels.back();
            Points coarser;
            for (std::size_t i = step / 2; i < finer.size(); i += step)
                coarser.push_back(finer[i]);
            levels.push_back(std::move(coarser));
        }
        for (const Points& level : levels)
            searches.emplace_back(level);
    }
};

/// Recipe step 1 at one seed, without the smoothing.
Local estimate_at(const Pyramid& pyramid, const Point& seed, std::vector<int>& neighbours, std::vector<double>& squared)
{
    const int all = int(pyramid.levels[0].size());
    // Of a small cloud take a part, or the quadric would have to follow the whole shape.
    const int limit = std::min({all, largest_count, std::max(all / 3, smallest_count)});
    QuadricFit fit{0, seed};
    double radius = 0;
    int count = 0, share = 1;
    bool flat = false;
    for (double k = smallest_count; count * share < limit; k *= growth)
    {
        std::size_t level = 0;
        share = 1;
        for (double c = k; c > many && level + 1 < pyramid.levels.size(); c /= Pyramid::step, share *= Pyramid::step)
            ++level;
        count = std::min(int(k), limit) / share;
        const Point centre = flat ? fit.foot : seed;
        pyramid.searches[level].nearest(centre, count, neighbours.data(), squared.data());
        radius = std::sqrt(squared[count - 1]);
        fit = fit_quadric(pyramid.levels[level], centre, neighbours.data(), count, radius);
        if (flat)
            break; // one step after the first flat one, around the foot: the residual has settled
        flat = radius >= flatness * fit.residual;
        if (count * share + share > limit)
            break;
    }
    return correct_for_ball(fit.residual, count * share, radius);
}

} // namespace

NoiseEstimate estimate_noise(const Points& points, const NoiseOptions& options, const Progress& progress)
{
    if (options.seeds < 0)
        throw InvalidInput("The number of seeds must be 0 (automatic) or more.");
    const int threads = resolve_threads(options.threads);
    const UnitFrame frame(points);
    progress.report(0);

    const SpatialOrder spatial = order_spatially(points);
    const int n = int(spatial.order.size());
    Points unit(n);
    for (int i = 0; i < n; ++i)
        unit[i] = frame.to_unit(points[spatial.order[i]]);

    const int wanted = options.seeds > 0 ? options.seeds : std::clamp(n / 25, 1000, 3000);
    const int m = std::min(n, wanted);
    Points seeds(m);
    for (int i = 0; i < m; ++i)
        seeds[i] = unit[std::size_t((i + 0.5) * n / m)];
    const Pyramid pyramid(std::move(unit));
    std::vector<Local> raw(m);
    parallel_chunks(std::size_t(m), threads, 32, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> neighbours(largest_count);
                        std::vector<double> squared(largest_count);
                        for (std::size_t i = begin; i < end; ++i)
                            raw[i] = estimate_at(pyramid, seeds[i], neighbours, squared);
                    });

    std::vector<double> sigma(m), density(m);
    const NeighbourSearch seed_search(seeds);
    const double scale = frame.scale();
    parallel_for(std::size_t(m), threads, {},
                 [&](std::size_t i)
                 {
                     int near[smoothing_seeds];
                     double squared[smoothing_seeds], values[smoothing_seeds];
                     const int count = seed_search.nearest(seeds[i], smoothing_seeds, near, squared);
                     const auto smooth = [&](auto member)
                     {
                         for (int k = 0; k < count; ++k)
                             values[k] = raw[near[k]].*member;
                         std::nth_element(values, values + count / 2, values + count);
                         return values[count / 2];
                     };
                     sigma[i] = truncation * scale * smooth(&Local::sigma);
                     density[i] = smooth(&Local::density) / scale / scale;
                 });
    frame.from_unit_in_place(seeds);
    return NoiseEstimate(std::move(seeds), std::move(sigma), std::move(density));
}

} // namespace recon
