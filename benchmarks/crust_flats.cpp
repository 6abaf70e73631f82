// Flat faces that carry samples on their rims only: shapes sampled along their edges, as coarse CAD models are.
// Usage: crust_flats <seed> [sigma,...]
#include "models.h"

#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"

#include <recon/geometry.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

using namespace benchmarks;

namespace
{

constexpr double pi = 3.14159265358979323846;
using Polygon = std::vector<Eigen::Vector2d>;

Polygon circle(double x, double y, double radius, int corners)
{
    Polygon result;
    for (int k = 0; k < corners; ++k)
        result.emplace_back(x + radius * std::cos(2 * pi * k / corners), y + radius * std::sin(2 * pi * k / corners));
    return result;
}

double area(const Polygon& polygon)
{
    double twice = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i)
    {
        const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        twice += a.x() * b.y() - a.y() * b.x();
    }
    return twice / 2;
}

struct Shape
{
    const char* name;
    Polygon outline;
    std::vector<Polygon> holes;
    double height, spacing;
};

/// Along the edges, `spacing` apart; sides of circles as they are.
recon::Points sample_edges(const Shape& shape)
{
    recon::Points points;
    const auto append_edge = [&](const recon::Point& from, const recon::Point& to)
    {
        const int count = std::max(1, int(std::lround((to - from).norm() / shape.spacing)));
        for (int k = 0; k < count; ++k)
            points.push_back(from + (to - from) * (double(k) / count));
    };
    std::vector<Polygon> loops = shape.holes;
    loops.push_back(shape.outline);
    for (const Polygon& loop : loops)
        for (std::size_t i = 0; i < loop.size(); ++i)
        {
            const Eigen::Vector2d &a = loop[i], &b = loop[(i + 1) % loop.size()];
            const recon::Point low(a.x(), a.y(), 0), high(b.x(), b.y(), shape.height);
            append_edge(low, recon::Point(b.x(), b.y(), 0));
            append_edge(high, recon::Point(a.x(), a.y(), shape.height));
            // Many-sided loops are round: no edge runs along their walls.
            if (loop.size() < 12)
                append_edge(low, recon::Point(a.x(), a.y(), shape.height));
        }
    return points;
}

std::vector<Shape> list_shapes()
{
    std::vector<Polygon> bores, bolts = {circle(0, 0, 0.2, 70)};
    for (const double x : {0.2, 0.5, 0.8})
        for (const double y : {0.17, 0.43})
            bores.push_back(circle(x, y, 0.07, 16));
    for (int k = 0; k < 4; ++k)
        bolts.push_back(circle(0.33 * std::cos(pi / 2 * k), 0.33 * std::sin(pi / 2 * k), 0.03, 18));
    std::vector<Polygon> crowded = {circle(0, 0, 0.15, 50)};
    for (int k = 0; k < 5; ++k)
        crowded.push_back(circle(0.36 * std::cos(2 * pi / 5 * k), 0.36 * std::sin(2 * pi / 5 * k), 0.075, 26));
    const Polygon ell = {{0, 0}, {1, 0}, {1, 0.2}, {0.2, 0.2}, {0.2, 0.8}, {0, 0.8}};
    const Polygon channel = {{0, 0}, {1, 0}, {1, 0.8}, {0.8, 0.8}, {0.8, 0.2}, {0.2, 0.2}, {0.2, 0.8}, {0, 0.8}};
    return {
        {"box", {{0, 0}, {1, 0}, {1, 0.8}, {0, 0.8}}, {}, 0.5, 0.05},
        {"thin box", {{0, 0}, {1, 0}, {1, 0.8}, {0, 0.8}}, {}, 0.1, 0.03},
        {"L-bracket", ell, {}, 0.5, 0.03},
        {"channel", channel, {}, 0.4, 0.03},
        {"plate with 6 bores", {{0, 0}, {1, 0}, {1, 0.6}, {0, 0.6}}, bores, 0.05, 0.03},
        {"flange with 4 bores", circle(0, 0, 0.45, 150), bolts, 0.06, 0.02},
        {"flange, bores at its rim", circle(0, 0, 0.445, 95), crowded, 0.08, 0.03},
        {"plate, bores in a row",
         {{0, 0}, {1, 0}, {1, 0.4}, {0, 0.4}},
         {circle(0.2, 0.2, 0.14, 40), circle(0.488, 0.2, 0.14, 40), circle(0.776, 0.2, 0.14, 40)},
         0.07,
         0.03},
        {"tube", circle(0, 0, 0.4, 90), {circle(0, 0, 0.3, 70)}, 0.6, 0.03},
        {"rod", circle(0, 0, 0.3, 60), {}, 0.5, 0.03},
    };
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2)
    {
        std::fprintf(stderr, "usage: %s <seed> [sigma,...]\n", argv[0]);
        return 2;
    }
    std::printf("| shape | sigma | ok | samples | completed | components | genus / true | volume | violated votes |\n");
    std::printf("|---|---|---|---|---|---|---|---|---|\n");
    for (const Shape& shape : list_shapes())
        for (const std::string& sigma : split_at_commas(argc > 2 ? argv[2] : "0,0.1,0.2"))
        {
            Model model;
            model.mesh.vertices = sample_edges(shape);
            model.diagonal = recon::bounding_box(model.mesh.vertices).diagonal();
            model.genus = int(shape.holes.size());
            double ground = area(shape.outline);
            for (const Polygon& hole : shape.holes)
                ground -= area(hole);
            recon::NoisyPowerCrustOptions options;
            options.threads = 1;
            try
            {
                const recon::NoisyPowerCrust crust = recon::reconstruct_noisy_power_crust(
                    noisy_cloud(model, std::atof(sigma.c_str()), unsigned(std::atoi(argv[1]))), options);
                const checks::MeshReport report = checks::examine_mesh(crust.mesh);
                const double volume = report.volume / (ground * shape.height);
                const bool ok = is_right(report, model.genus, volume);
                std::printf("| %s | %s | %s | %zu | %d | %d | %d / %d | %.3f | %.3f |\n", shape.name, sigma.c_str(),
                            ok ? "yes" : "-", model.mesh.vertices.size(), crust.completed, report.components,
                            report.genus(), model.genus, volume, crust.violated_votes);
            }
            catch (const std::exception& e)
            {
                std::printf("| %s | %s | - | %zu | %s |\n", shape.name, sigma.c_str(), model.mesh.vertices.size(),
                            e.what());
            }
            std::fflush(stdout);
        }
}
