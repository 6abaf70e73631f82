// Sheets without an inside: open_sheets <first seed> <seeds> [sheet...]
// Random samples of terrains, domes, rolls and the like. One Markdown row a sheet, a column per noise in spacings; each
// cell: of the clouds of 3,000 and 10,000 samples with each seed those whose normals are on one side (0.99 of them),
// and whose crust and AMLS mesh with `open_holes` are right: one component, no handle, the true number of rims, next to
// nothing missed or farther off than a spacing, and through the points if these have no noise.
#include "mesh_distance.h"
#include "models.h"
#include "pn_models.h"

#include "filter_amls/mesh/reconstruct_amls.h"
#include "filter_amls/normals/outward_normals.h"
#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

using namespace benchmarks;
using recon::Point;
using recon::Points;

namespace
{

constexpr double pi = 3.14159265358979323846;
using Map = shapes::SheetMap;
using shapes::wavy_terrain;

struct Sheet
{
    std::string name;
    int rims;
    Map at; ///< Over the unit square.
};

/// A height over the square from -1 to 1.
template <class Height>
Map over_square(Height height)
{
    return [=](double u, double v)
    {
        const double x = 2 * u - 1, y = 2 * v - 1;
        return Point(x, y, height(x, y));
    };
}

/// A surface of revolution around z: its radius at heights from `lowest` to `highest`.
template <class Radius>
Map revolved(double lowest, double highest, Radius radius)
{
    return [=](double u, double v)
    {
        const double z = lowest + (highest - lowest) * u, turn = 2 * pi * v;
        return Point(radius(z) * std::cos(turn), radius(z) * std::sin(turn), z);
    };
}

Map sphere_above(double z)
{
    return revolved(z, 1, [](double h) { return std::sqrt(std::max(0.0, 1 - h * h)); });
}

double rough(double x, double y)
{
    double z = 0;
    for (int k = 0; k < 5; ++k)
    {
        const double finer = std::pow(1.9, k);
        z += 0.15 * std::pow(0.5, k) * std::sin(2.1 * finer * x + 1.3 * k) * std::cos(1.7 * finer * y + 0.7 * k);
    }
    return z;
}

Point face(double u, double v)
{
    const double r = std::sqrt(1 - u * u), turn = 2 * pi * v;
    const Point p(r * std::cos(turn), 1.3 * r * std::sin(turn), 0.7 * u);
    const double nose = 0.2 * std::exp(-20 * (p.x() * p.x() + p.y() * p.y()));
    return p * (1 + 0.08 * std::sin(7 * p.x()) * std::cos(6 * p.y()) + nose);
}

const std::vector<Sheet> sheets = {
    {"terrain, low", 1, wavy_terrain(0.05, 1, 1)},
    {"terrain, hills", 1, wavy_terrain(0.2, 1.5, 2)},
    {"terrain, waves", 1, wavy_terrain(0.2, 3, 4)},
    {"terrain, short waves", 1, wavy_terrain(0.1, 6, 5)},
    {"terrain, egg carton", 1, wavy_terrain(0.1, 9, 9)},
    {"terrain, steep", 1, wavy_terrain(0.4, 3, 3)},
    {"terrain, rough", 1, over_square(rough)},
    {"corrugated", 1, over_square([](double x, double) { return 0.1 * std::sin(9 * x); })},
    {"saddle", 1, over_square([](double x, double y) { return 0.4 * (x * x - y * y); })},
    {"bowl", 1, revolved(0, 0.6, [](double z) { return std::sqrt(z / 0.6); })},
    {"shallow cap", 1, sphere_above(0.8)},
    {"half sphere", 1, sphere_above(0)},
    {"sphere without a cap", 1, sphere_above(-0.6)},
    {"half cylinder", 1,
     [](double u, double v) { return Point(0.5 * std::cos(pi * u), 1.6 * v, 0.5 * std::sin(pi * u)); }},
    {"tube", 2, revolved(-1, 1, [](double) { return 0.5; })},
    {"face", 1, face},
    {"S", 1, shapes::s_sheet},
    {"roll", 1, shapes::rolled_sheet},
    {"helicoid", 1, shapes::winding_sheet},
};

recon::TriangleMesh tessellate(const Map& at)
{
    constexpr int cells = 300;
    recon::TriangleMesh mesh;
    for (int i = 0; i <= cells; ++i)
        for (int j = 0; j <= cells; ++j)
            mesh.vertices.push_back(at(double(i) / cells, double(j) / cells));
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j)
        {
            const int a = i * (cells + 1) + j, b = a + cells + 1;
            mesh.triangles.push_back({a, b, b + 1});
            mesh.triangles.push_back({a, b + 1, a + 1});
        }
    return mesh;
}

/// How many of the clouds are right.
struct Counts
{
    int clouds = 0, normals = 0, crust = 0, amls = 0;
};

class Cell
{
public:
    Cell(const Sheet& sheet, double noise) : sheet_(sheet), noise_(noise), truth_mesh_(tessellate(sheet.at)) {}

    void add(int n, unsigned seed)
    {
        const recon::OrientedSamples samples = shapes::sheet(n, sheet_.at, seed);
        spacing_ = std::sqrt(surface_area(truth_mesh_) / n);
        const Points points = shapes::with_noise(samples.points, noise_ * spacing_, seed + 1);
        ++counts_.clouds;
        const double facing = checks::share_facing(recon::find_outward_normals(points).normals, samples.normals);
        counts_.normals += std::max(facing, 1 - facing) >= 0.99;
        recon::NoisyPowerCrustOptions crust;
        recon::AmlsReconstructionOptions amls;
        crust.open_holes = amls.open_holes = true;
        counts_.crust += is_right(recon::reconstruct_noisy_power_crust(points, crust), samples.points);
        counts_.amls += is_right(recon::reconstruct_amls(points, amls), samples.points);
    }
    const Counts& counts() const { return counts_; }

private:
    template <class Result>
    bool is_right(const Result& found, const Points& samples) const
    {
        constexpr double many_vertices = 0.9, hardly_any = 0.002;
        if (found.components != 1 || found.genus != 0 || found.boundary_loops != sheet_.rims)
            return false;
        if (noise_ == 0 && double(found.mesh.vertices.size()) < many_vertices * double(samples.size()))
            return false;
        return measure_far(MeshDistance(found.mesh), samples, 1.5) <= hardly_any &&
               measure_far(truth_, found.mesh.vertices, 1) <= hardly_any;
    }
    /// Share of points farther from a mesh than so many spacings.
    double measure_far(const MeshDistance& mesh, const Points& points, double spacings) const
    {
        const auto far = std::count_if(points.begin(), points.end(),
                                       [&](const Point& p) { return mesh.nearest(p).distance > spacings * spacing_; });
        return double(far) / double(points.size());
    }

    const Sheet& sheet_;
    double noise_;
    recon::TriangleMesh truth_mesh_;
    MeshDistance truth_{truth_mesh_};
    double spacing_ = 0;
    Counts counts_;
};

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3)
    {
        std::fprintf(stderr, "usage: open_sheets <first seed> <seeds> [sheet...]\n");
        return 2;
    }
    const unsigned first = unsigned(std::atoi(argv[1])), seeds = unsigned(std::atoi(argv[2]));
    const std::vector<std::string> names(argv + 3, argv + argc);
    const std::vector<double> noises = {0, 0.1, 0.3};
    std::printf("| sheet: normals, crust, AMLS right |");
    for (const double noise : noises)
        std::printf(" noise %g |", noise);
    std::printf("\n|---|---|---|---|\n");
    std::vector<Counts> all(noises.size());
    const auto print = [](const Counts& c)
    { std::printf(" %d, %d, %d of %d |", c.normals, c.crust, c.amls, c.clouds); };
    for (const Sheet& sheet : sheets)
    {
        if (!names.empty() && std::find(names.begin(), names.end(), sheet.name) == names.end())
            continue;
        std::printf("| %s |", sheet.name.c_str());
        for (std::size_t k = 0; k < noises.size(); ++k)
        {
            Cell cell(sheet, noises[k]);
            for (const int n : {3000, 10000})
                for (unsigned seed = first; seed < first + seeds; ++seed)
                    cell.add(n, seed);
            print(cell.counts());
            all[k].clouds += cell.counts().clouds;
            all[k].normals += cell.counts().normals;
            all[k].crust += cell.counts().crust;
            all[k].amls += cell.counts().amls;
            std::fflush(stdout);
        }
        std::printf("\n");
    }
    std::printf("| all |");
    for (const Counts& counts : all)
        print(counts);
    std::printf("\n");
}
