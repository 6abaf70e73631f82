// The paper's own tables with the paper's plain variant: table 1 (iterations and time of NP and PP), figure 11 (domain
// of convergence of I and N), and the local feature size against analytic values. amls_paper <model folder> [table1]
// [convergence] [feature_size]
#include "models.h"

#include "filter_amls/paper/delaunay_ball_normals.h"
#include "filter_amls/paper/plain_mls.h"
#include "filter_amls/surface/local_feature_size.h"
#include "filter_amls/surface/project.h"

#include "tests/shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

using namespace recon;

namespace
{

struct PlainSamples
{
    OrientedSamples oriented;
    std::vector<double> feature_size;
};

/// Normals of all samples, feature size smoothed over 20.
PlainSamples prepare(const Points& points)
{
    DelaunayBallOptions balls;
    balls.threads = 1;
    DelaunayBallNormals found = find_delaunay_ball_normals(points, balls);
    FeatureSizeOptions measure;
    measure.smoothing = 20;
    measure.threads = 1;
    return {{points, std::move(found.normals)}, measure_feature_size(points, found.poles, measure)};
}

double mean(const std::vector<int>& values)
{
    double sum = 0;
    for (int v : values)
        sum += v;
    return sum / double(values.size());
}

/// Distance from where each hundredth point stopped to where it ends if it goes on, in widths: median and 95th
/// percentile.
std::pair<double, double> measure_error(const PlainMlsProjection& stopped, const PlainSamples& samples,
                                        PlainMlsOptions options)
{
    Points queries;
    for (std::size_t i = 0; i < stopped.points.size(); i += 100)
        queries.push_back(stopped.points[i]);
    options.tolerance = 1e-12;
    options.max_iterations = 300;
    const PlainMlsProjection limit = project_to_plain_mls(queries, samples.oriented, samples.feature_size, options);
    std::vector<double> errors;
    for (std::size_t i = 0; i < queries.size(); ++i)
        errors.push_back((limit.points[i] - queries[i]).norm() /
                         (options.rho_e * samples.feature_size[100 * i] / std::pow(2.0, 0.25)));
    std::sort(errors.begin(), errors.end());
    return {errors[errors.size() / 2], errors[errors.size() * 95 / 100]};
}

void print_table1(const std::string& folder)
{
    std::printf("| model | points | noise %% | tolerance [width] | method | neighbours | iterations | converged | "
                "error: median, 95 %% [width] | seconds | PP / NP |\n"
                "|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const char* name : {"maxplanck_25k", "hand_points"})
        for (double tolerance : {1e-2, 1e-3, 1e-4})
        {
            const double percent = 0.4;
            const benchmarks::Model model = benchmarks::load_model(folder + "/" + name + ".ply");
            const Points points = shapes::with_noise(model.mesh.vertices, percent / 100 * model.diagonal, 31);
            const PlainSamples samples = prepare(points);
            double newton = 0;
            for (PlainSurface surface : {PlainSurface::normalised, PlainSurface::vmls})
            {
                PlainMlsOptions options;
                options.surface = surface;
                options.threads = 1;
                options.tolerance = tolerance;
                const double start = benchmarks::cpu_seconds();
                const PlainMlsProjection result =
                    project_to_plain_mls(points, samples.oriented, samples.feature_size, options);
                const double seconds = benchmarks::cpu_seconds() - start;
                const bool is_newton = surface == PlainSurface::normalised;
                if (is_newton)
                    newton = seconds;
                const double converged =
                    double(std::count(result.converged.begin(), result.converged.end(), 1)) / double(points.size());
                const auto [median, most] = measure_error(result, samples, options);
                std::printf("| %s | %zu | %.1f | %g | %s | %.0f | %.2f | %.4f | %.1e, %.1e | %.1f | %.2f |\n", name,
                            points.size(), percent, tolerance, is_newton ? "NP (I)" : "PP (VMLS)",
                            mean(result.neighbours), mean(result.iterations), converged, median, most, seconds,
                            seconds / newton);
                std::fflush(stdout);
            }
        }
}

/// The same from anchors: under noise the paper's own poles lie in the noise and make the widths several times too
/// small.
PlainSamples prepare_from_anchors(const Points& points)
{
    const AmlsSurface surface = build_amls_surface(points);
    AmlsProjection projection = project_to_amls(points, surface);
    std::vector<double> size = find_local_feature_size(projection.points, surface).at_query;
    return {{points, std::move(projection.normals)}, std::move(size)};
}

/// Starting points pushed along the normal by a share of f; they return if they end within a width of where they
/// belong.
void print_convergence()
{
    struct Shape
    {
        const char* name;
        OrientedSamples samples;
        double (*feature_size)(const Point&);
        double (*distance)(const Point&);
    };
    const Shape all[] = {
        {"torus 1, 0.4", shapes::torus(8000, 1, 0.4, 41),
         [](const Point& p) { return std::min(std::hypot(p.head<2>().norm() - 1, p.z()), p.head<2>().norm()); },
         [](const Point& p) { return shapes::distance_to_torus(p, 1, 0.4); }},
        {"sphere", shapes::sphere(8000, 1, 42), [](const Point& p) { return p.norm(); },
         [](const Point& p) { return shapes::distance_to_sphere(p, 1); }},
    };
    std::printf("| shape | pushed by [f] | I returns | N returns |\n|---|---|---|---|\n");
    for (const Shape& shape : all)
    {
        const Points noisy = shapes::with_noise(shape.samples.points, 0.01, 43);
        const PlainSamples samples = prepare_from_anchors(noisy);
        for (double push = 0.1; push < 0.95; push += 0.1)
        {
            double share[2];
            for (int kind = 0; kind < 2; ++kind)
            {
                Points queries;
                for (std::size_t i = 0; i < shape.samples.points.size(); i += 8)
                    queries.push_back(shape.samples.points[i] + (i % 16 == 0 ? push : -push) *
                                                                    shape.feature_size(shape.samples.points[i]) *
                                                                    shape.samples.normals[i]);
                PlainMlsOptions options;
                options.surface = kind == 0 ? PlainSurface::normalised : PlainSurface::plain_n;
                const PlainMlsProjection result =
                    project_to_plain_mls(queries, samples.oriented, samples.feature_size, options);
                int good = 0;
                for (std::size_t i = 0; i < queries.size(); ++i)
                    good += result.converged[i] &&
                            shape.distance(result.points[i]) < 0.3 * shape.feature_size(shape.samples.points[8 * i]) &&
                            (result.points[i] - shape.samples.points[8 * i]).norm() <
                                0.5 * shape.feature_size(shape.samples.points[8 * i]);
                share[kind] = good / double(queries.size());
            }
            std::printf("| %s | %.1f | %.4f | %.4f |\n", shape.name, push, share[0], share[1]);
        }
    }
}

double ellipsoid_feature_size(const Point& p)
{
    const Vector axes(1.5, 1, 0.6);
    const double rx = (axes[0] * axes[0] - axes[2] * axes[2]) / axes[0],
                 ry = (axes[1] * axes[1] - axes[2] * axes[2]) / axes[1];
    double best = 1e300;
    for (int i = 0; i <= 200; ++i)
        for (int j = 0; j < 800; ++j)
        {
            const double r = i / 200.0, angle = M_PI * j / 400;
            best = std::min(best, (p - Point(r * rx * std::cos(angle), r * ry * std::sin(angle), 0)).squaredNorm());
        }
    return std::sqrt(best);
}

double torus_feature_size(const Point& p)
{
    return std::min(std::hypot(p.head<2>().norm() - 1, p.z()), p.head<2>().norm());
}

void print_feature_size()
{
    std::printf("| shape | points | noise | method | median relative error |\n|---|---|---|---|---|\n");
    for (double sigma : {0.0, 0.01, 0.02})
        for (bool torus : {true, false})
        {
            const Points truth = torus ? shapes::torus(20000, 1, 0.4, 51).points
                                       : shapes::ellipsoid(20000, Vector(1.5, 1, 0.6), 52).points;
            const Points points = shapes::with_noise(truth, sigma, 53);
            const AmlsSurface surface = build_amls_surface(points);
            const auto median_error = [&](const std::vector<double>& sizes)
            {
                std::vector<double> errors;
                for (std::size_t i = 0; i < truth.size(); i += 40)
                    errors.push_back(std::abs(
                        sizes[i] / (torus ? torus_feature_size(truth[i]) : ellipsoid_feature_size(truth[i])) - 1));
                std::nth_element(errors.begin(), errors.begin() + std::ptrdiff_t(errors.size() / 2), errors.end());
                return errors[errors.size() / 2];
            };
            const std::vector<double> ours =
                find_local_feature_size(project_to_amls(points, surface).points, surface).at_query;
            std::printf("| %s | %zu | %.2f | automatic | %.3f |\n", torus ? "torus 1, 0.4" : "ellipsoid 1.5, 1, 0.6",
                        points.size(), sigma, median_error(ours));
            std::printf("| %s | %zu | %.2f | paper | %.3f |\n", torus ? "torus 1, 0.4" : "ellipsoid 1.5, 1, 0.6",
                        points.size(), sigma,
                        median_error(measure_feature_size(points, find_delaunay_ball_normals(points).poles)));
        }
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2)
    {
        std::fprintf(stderr, "usage: %s <model folder> [table1] [convergence] [feature_size]\n", argv[0]);
        return 2;
    }
    const std::set<std::string> wanted(argv + 2, argv + argc);
    if (wanted.empty() || wanted.count("feature_size"))
        print_feature_size();
    if (wanted.empty() || wanted.count("convergence"))
        print_convergence();
    if (wanted.empty() || wanted.count("table1"))
        print_table1(argv[1]);
}
