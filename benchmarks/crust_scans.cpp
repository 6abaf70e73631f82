// Clouds as a range scanner would take them: views from all sides (or few), samples on each view's own grid, so density
// falls with the slope and folds stay hidden; noise along the rays, views out of register, flying points at
// silhouettes. crust_scans <pixels> <seed> [-o folder] [-f first scanner] <model.ply>...
// One Markdown row a cell, for both filters that make surfaces; `pixels` across the model's bounding sphere.
#include "bare_delaunay.h"
#include "mesh_distance.h"
#include "models.h"

#include "filter_amls/mesh/reconstruct_amls.h"
#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/shapes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

using namespace benchmarks;
using recon::Point;
using recon::Points;
using recon::TriangleMesh;
using recon::Vector;

namespace
{

struct Scanner
{
    const char* name;
    int views;
    double noise;         ///< Along the rays [% of the diagonal].
    double misregistered; ///< Shift of each view; its rotation moves the rim as far [% of the diagonal].
    double flying;        ///< Share of the silhouette's pixels that give a point between front and back.
};

const std::vector<Scanner> scanners = {
    {"20 views, clean", 20, 0, 0, 0},
    {"20 views, noise 0.05 %", 20, 0.05, 0, 0},
    {"20 views, noise 0.2 %", 20, 0.2, 0, 0},
    {"20 views, noise 0.05 %, 0.1 % out of register", 20, 0.05, 0.1, 0},
    {"20 views, noise 0.05 %, 0.05 % out of register, flying points", 20, 0.05, 0.05, 0.3},
    {"8 views, noise 0.05 %, 0.05 % out of register", 8, 0.05, 0.05, 0},
    {"20 views, noise 0.05 %, 0.3 % out of register", 20, 0.05, 0.3, 0},
    {"8 views, noise 0.05 %, 0.3 % out of register", 8, 0.05, 0.3, 0},
    {"8 views, noise 0.05 %, 0.6 % out of register", 8, 0.05, 0.6, 0},
    {"12 views, noise 0.1 %, 1.2 % out of register", 12, 0.1, 1.2, 0},
};

Points scan(const Model& model, const MeshDistance& surface, const Scanner& scanner, int pixels, unsigned seed)
{
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    const auto gaussian = [&] { return shapes::draw_vector([&] { return normal(random); }); };
    const recon::Box box = recon::bounding_box(model.mesh.vertices);
    const Point centre = box.centre();
    const double percent = model.diagonal / 100, radius = model.diagonal / 2, pixel = 2 * radius / pixels;
    Points points;
    const Vector axis = gaussian();
    const Eigen::Quaterniond turn(Eigen::Quaterniond(normal(random), axis.x(), axis.y(), axis.z()).normalized());
    for (int view = 0; view < scanner.views; ++view)
    {
        // Fibonacci's points on the sphere.
        const double z = 1 - (2 * view + 1.0) / scanner.views, phi = view * 2.399963229728653, r = std::sqrt(1 - z * z);
        const Vector back = turn * Vector(r * std::cos(phi), r * std::sin(phi), z);
        const Vector right = back.unitOrthogonal(), up = back.cross(right);
        const Vector shift = scanner.misregistered * percent * gaussian() / std::sqrt(3.0);
        const Vector axis = scanner.misregistered * percent / radius * gaussian() / std::sqrt(3.0);
        std::vector<double> depth(std::size_t(pixels) * pixels, -1);
        const auto at = [&](int i, int j, double d) -> Point
        {
            return centre + (i + 0.5 - 0.5 * pixels) * pixel * right + (j + 0.5 - 0.5 * pixels) * pixel * up +
                   (2 * radius - d) * back;
        };
        for (int j = 0; j < pixels; ++j)
            for (int i = 0; i < pixels; ++i)
            {
                const auto hit = surface.first_hit(at(i, j, 0), -back);
                if (hit.triangle < 0)
                    continue;
                const auto& t = model.mesh.triangles[hit.triangle];
                const auto& v = model.mesh.vertices;
                const Vector n = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).normalized();
                if (std::abs(n.dot(back)) > 0.17) // slopes beyond 80 degrees give no echo
                    depth[std::size_t(j) * pixels + i] = hit.distance;
            }
        const auto add = [&](int i, int j, double d)
        {
            const Point p = at(i, j, d + scanner.noise * percent * normal(random));
            points.push_back(p + shift + axis.cross(p - centre));
        };
        for (int j = 0; j < pixels; ++j)
            for (int i = 0; i < pixels; ++i)
            {
                const double d = depth[std::size_t(j) * pixels + i];
                if (d < 0)
                    continue;
                const double beside = i + 1 < pixels ? depth[std::size_t(j) * pixels + i + 1] : -1;
                if (beside >= 0 && std::abs(beside - d) > 5 * pixel && uniform(random) < scanner.flying)
                    add(i, j, d + uniform(random) * (beside - d));
                else
                    add(i, j, d);
            }
    }
    return points;
}

TriangleMesh make_crust(const Points& points)
{
    recon::NoisyPowerCrustOptions options;
    options.threads = 1;
    return recon::reconstruct_noisy_power_crust(points, options).mesh;
}

TriangleMesh make_amls(const Points& points)
{
    recon::AmlsReconstructionOptions options;
    options.threads = 1;
    return recon::reconstruct_amls(points, options).mesh;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 4)
    {
        std::fprintf(stderr, "usage: %s <pixels> <seed> [-o folder] [-f first scanner] <model.ply>...\n", argv[0]);
        return 2;
    }
    const int pixels = std::atoi(argv[1]);
    const unsigned seed = unsigned(std::atoi(argv[2]));
    std::string folder;
    std::size_t first = 1;
    int right[2] = {}, cells = 0;
    std::printf("| model | scanner | points | power crust | RMS | x DT | AMLS | RMS | x DT "
                "|\n|---|---|---|---|---|---|---|---|---|\n");
    for (int k = 3; k < argc; ++k)
    {
        if (argv[k] == std::string("-o") && k + 1 < argc)
        {
            folder = argv[++k];
            continue;
        }
        if (argv[k] == std::string("-f") && k + 1 < argc)
        {
            first = std::size_t(std::max(1, std::atoi(argv[++k])));
            continue;
        }
        const Model model = load_model(argv[k]);
        const std::string name = std::filesystem::path(argv[k]).stem().string();
        const MeshDistance truth(model.mesh);
        for (std::size_t s = first - 1; s < scanners.size(); ++s)
        {
            const Points points = scan(model, truth, scanners[s], pixels, seed);
            const double unit = time_bare_delaunay(points);
            const std::string file = folder + "/" + name + "_" + std::to_string(s);
            if (!folder.empty())
                save_ply(file + "_cloud.ply", points);
            std::printf("| %s | %s | %zu |", name.c_str(), scanners[s].name, points.size());
            ++cells;
            for (const int filter : {0, 1})
                try
                {
                    const double begin = cpu_seconds();
                    const recon::TriangleMesh mesh = filter == 0 ? make_crust(points) : make_amls(points);
                    const double seconds = cpu_seconds() - begin;
                    const checks::MeshReport report = checks::examine_mesh(mesh);
                    const double volume = report.volume / model.volume;
                    const bool ok = is_right(report, model.genus, volume);
                    right[filter] += ok;
                    if (ok)
                        std::printf(" right");
                    else
                        std::printf(" %d c, genus %d / %d, %.3f", report.components, report.genus(), model.genus,
                                    volume);
                    std::printf(" | %.0f | %.1f |", 1e6 * truth.summarise(mesh.vertices).rms / model.diagonal,
                                seconds / unit);
                    if (!folder.empty())
                        save_ply(file + (filter == 0 ? "_crust.ply" : "_amls.ply"), mesh);
                }
                catch (const std::exception& e)
                {
                    std::printf(" failed: %s | | |", e.what());
                }
            std::printf("\n");
            std::fflush(stdout);
        }
    }
    std::printf("\npower crust %d, AMLS %d of %d right\n", right[0], right[1], cells);
}
