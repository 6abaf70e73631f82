// Other kinds of noise than each vertex plus Gaussian copies: crust_kinds <folder of models> <seed> <points> [model...]
// Points spread at random over the surface. One Markdown row a kind: per model the RMS distance of the crust's vertices
// to the true mesh in 1e-6 of the diagonal, and what is wrong with the crust if it is not right.
#include "mesh_distance.h"
#include "models.h"
#include "pn_models.h"

#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/lattices.h"
#include "tests/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>

using namespace benchmarks;
using recon::Point;
using recon::Points;
using recon::Vector;

namespace
{

class Cloud
{
public:
    Cloud(const Model& model, int n, unsigned seed)
        : model_(model), n_(n), seed_(seed), random_(seed), box_(recon::bounding_box(model.mesh.vertices))
    {
    }

    recon::OrientedSamples samples(int n) { return sample_mesh(model_.mesh, n, ++seed_); }
    Points surface(int n) { return samples(n).points; }
    Points surface() { return surface(n_); }
    double uniform() { return shapes::uniform(random_); }
    /// A length in per cent of the diagonal.
    double length(double percent) const { return percent / 100 * model_.diagonal; }
    /// Where a point lies along an axis of the box, 0 to 1.
    double along(const Point& p, int axis) const
    {
        return (p[axis] - box_.minimum[axis]) / (box_.maximum[axis] - box_.minimum[axis]);
    }
    Point anywhere()
    {
        Point p;
        for (int k = 0; k < 3; ++k)
            p[k] = box_.minimum[k] + uniform() * (box_.maximum[k] - box_.minimum[k]);
        return p;
    }
    /// \param percent_at per point the standard deviation.
    template <class PercentAt>
    Points with_noise(const Points& points, const PercentAt& percent_at)
    {
        Points result = points, unit = shapes::with_noise(points, 1, ++seed_);
        for (std::size_t i = 0; i < points.size(); ++i)
            result[i] += length(percent_at(points[i])) * (unit[i] - points[i]);
        return result;
    }
    Points with_noise(const Points& points, double percent)
    {
        return with_noise(points, [&](const Point&) { return percent; });
    }
    /// `copies` of each sample in turn, moved along its direction by a length drawn by `draw`.
    template <class Draw>
    static Points moved_along(const recon::OrientedSamples& samples, int copies, const Draw& draw)
    {
        Points points;
        for (std::size_t i = 0; i < samples.points.size(); ++i)
            for (int k = 0; k < copies; ++k)
                points.push_back(samples.points[i] + draw() * samples.normals[i].normalized());
        return points;
    }
    /// Noise of 0.02 and 0.3 % by turns, in stripes across an axis of a width in per cent.
    Points with_noisy_stripes(double width)
    {
        return with_noise(surface(), [&](const Point& p)
                          { return std::fmod(std::abs(p.y()) / length(width), 2) < 1 ? 0.02 : 0.3; });
    }
    double gaussian() { return std::normal_distribution<double>()(random_); }
    int count() const { return n_; }
    /// A direction and, times it, a length drawn by `draw`.
    template <class Draw>
    Points with_offsets(Points points, const Draw& draw)
    {
        const Points directions = shapes::with_noise(Points(points.size(), Point::Zero()), 1, ++seed_);
        for (std::size_t i = 0; i < points.size(); ++i)
            points[i] += draw() * directions[i].normalized();
        return points;
    }
    /// Whether a point lies within `percent` of one of the places.
    bool is_near(const Point& p, const Points& places, double percent) const
    {
        bool near = false;
        for (const Point& place : places)
            near |= (p - place).norm() < length(percent);
        return near;
    }

    /// Where planes across the longest axis cut the surface. Percents: their distance, and that of the points of an
    /// outline.
    Points slices(double apart, double along)
    {
        int axis;
        (box_.maximum - box_.minimum).maxCoeff(&axis);
        Points points;
        for (const auto& t : model_.mesh.triangles)
        {
            double lowest = box_.maximum[axis], highest = box_.minimum[axis];
            for (const int v : t)
            {
                lowest = std::min(lowest, model_.mesh.vertices[v][axis]);
                highest = std::max(highest, model_.mesh.vertices[v][axis]);
            }
            for (double k = std::ceil(lowest / length(apart)); k * length(apart) < highest; ++k)
                add_cut(t, axis, k * length(apart), length(along), points);
        }
        return points;
    }

private:
    /// Points of a triangle in a plane across an axis, as far apart as given on average.
    void add_cut(const std::array<int, 3>& triangle, int axis, double at, double apart, Points& points)
    {
        Points ends;
        for (int k = 0; k < 3; ++k)
        {
            const Point &a = model_.mesh.vertices[triangle[k]], &b = model_.mesh.vertices[triangle[(k + 1) % 3]];
            if ((a[axis] < at) != (b[axis] < at))
                ends.push_back(a + (at - a[axis]) / (b[axis] - a[axis]) * (b - a));
        }
        if (ends.size() != 2)
            return;
        const Vector side = ends[1] - ends[0];
        for (double s = apart * uniform(); s < side.norm(); s += apart)
            points.push_back(ends[0] + s / side.norm() * side);
    }

    const Model& model_;
    int n_;
    unsigned seed_;
    shapes::Random random_;
    recon::Box box_;
};

Points rounded(const Points& points, double step)
{
    return shapes::rounded(points, Vector::Constant(step));
}

struct Kind
{
    const char* name;
    std::function<Points(Cloud&)> make;
};

const std::vector<Kind> kinds = {
    {"clean", [](Cloud& c) { return c.surface(); }},
    {"Gaussian, 0.2 %", [](Cloud& c) { return c.with_noise(c.surface(), 0.2); }},
    {"Laplace, 0.2 %",
     [](Cloud& c) { return c.with_offsets(c.surface(), [&] { return -c.length(0.2) * std::log(1 - c.uniform()); }); }},
    {"uniform in balls of 0.4 %",
     [](Cloud& c) { return c.with_offsets(c.surface(), [&] { return c.length(0.4) * std::cbrt(c.uniform()); }); }},
    {"along one axis, 0.3 %",
     [](Cloud& c)
     {
         const Points exact = c.surface();
         Points points = c.with_noise(exact, 0.3);
         for (std::size_t i = 0; i < points.size(); ++i)
             points[i].head<2>() = exact[i].head<2>();
         return points;
     }},
    {"0 to 0.5 % along an axis",
     [](Cloud& c) { return c.with_noise(c.surface(), [&](const Point& p) { return 0.5 * c.along(p, 1); }); }},
    {"rounded to 0.1 %", [](Cloud& c) { return rounded(c.surface(), c.length(0.1)); }},
    {"rounded to 0.3 %", [](Cloud& c) { return rounded(c.surface(), c.length(0.3)); }},
    {"scan lines 0.8 % apart, 0.05 %",
     [](Cloud& c)
     {
         Points lines;
         for (const Point& p : c.surface())
         {
             const double line = p.y() / c.length(0.8);
             if (std::abs(line - std::round(line)) < 0.1)
                 lines.push_back(p);
         }
         return c.with_noise(lines, 0.05);
     }},
    {"0.1 %, 20 clusters of outliers",
     [](Cloud& c)
     {
         Points points = c.with_noise(c.surface(), 0.1);
         for (int cluster = 0; cluster < 20; ++cluster)
             for (const Point& p : c.with_noise(Points(50, c.anywhere()), 0.5))
                 points.push_back(p);
         return points;
     }},
    {"0.1 %, 3 % of them 2 % off",
     [](Cloud& c)
     {
         const Points exact = c.surface();
         return c.with_noise(exact, [&](const Point&) { return c.uniform() < 0.03 ? 2 : 0.1; });
     }},
    {"0.1 %, 30 holes of 1.5 %",
     [](Cloud& c)
     {
         const Points places = c.surface(30);
         Points kept;
         for (const Point& p : c.with_noise(c.surface(), 0.1))
             if (!c.is_near(p, places, 1.5))
                 kept.push_back(p);
         return kept;
     }},
    {"a noisy half, 0.3 %",
     [](Cloud& c) { return c.with_noise(c.surface(), [&](const Point& p) { return c.along(p, 0) > 0.5 ? 0.3 : 0; }); }},
    {"a noisy half, 0.1 %",
     [](Cloud& c) { return c.with_noise(c.surface(), [&](const Point& p) { return c.along(p, 0) > 0.5 ? 0.1 : 0; }); }},
    {"a noisy quarter, 0.3 %", [](Cloud& c)
     { return c.with_noise(c.surface(), [&](const Point& p) { return c.along(p, 1) > 0.75 ? 0.3 : 0; }); }},
    {"five noisy balls of 12 %, 0.3 %",
     [](Cloud& c)
     {
         const Points places = c.surface(5);
         return c.with_noise(c.surface(), [&](const Point& p) { return c.is_near(p, places, 12) ? 0.3 : 0; });
     }},
    {"halves of 0.03 and 0.4 %", [](Cloud& c)
     { return c.with_noise(c.surface(), [&](const Point& p) { return c.along(p, 2) > 0.5 ? 0.4 : 0.03; }); }},
    {"a noisy end, 0.3 %", [](Cloud& c)
     { return c.with_noise(c.surface(), [&](const Point& p) { return c.along(p, 0) > 0.88 ? 0.3 : 0; }); }},
    {"the other end, 0.3 %", [](Cloud& c)
     { return c.with_noise(c.surface(), [&](const Point& p) { return c.along(p, 1) < 0.12 ? 0.3 : 0; }); }},
    {"rounded to 0.8 %", [](Cloud& c) { return rounded(c.surface(), c.length(0.8)); }},
    {"0.4 %, rounded to 0.5 %", [](Cloud& c) { return rounded(c.with_noise(c.surface(), 0.4), c.length(0.5)); }},
    {"slices 1 % apart, 0.2 % in them", [](Cloud& c) { return c.slices(1, 0.2); }},
    {"evenly to 0.6 % along normals", [](Cloud& c)
     { return Cloud::moved_along(c.samples(c.count()), 1, [&] { return c.length(0.6) * (2 * c.uniform() - 1); }); }},
    {"5 along each normal, 0.2 %", [](Cloud& c)
     { return Cloud::moved_along(c.samples(c.count() / 5), 5, [&] { return c.length(0.2) * c.gaussian(); }); }},
    {"10 along each normal, 0.1 %", [](Cloud& c)
     { return Cloud::moved_along(c.samples(c.count() / 10), 10, [&] { return c.length(0.1) * c.gaussian(); }); }},
    {"5 along one axis each, 0.3 %",
     [](Cloud& c)
     {
         recon::OrientedSamples samples = c.samples(c.count() / 5);
         for (Vector& direction : samples.normals)
             direction = Vector::UnitZ();
         return Cloud::moved_along(samples, 5, [&] { return c.length(0.3) * c.gaussian(); });
     }},
    {"0.3 %, one in five",
     [](Cloud& c) { return c.with_noise(c.surface(), [&](const Point&) { return c.uniform() < 0.2 ? 0.3 : 0; }); }},
    {"stripes of 1 %, 0.02 and 0.3 %", [](Cloud& c) { return c.with_noisy_stripes(1); }},
    {"stripes of 2 %, 0.02 and 0.3 %", [](Cloud& c) { return c.with_noisy_stripes(2); }},
};

} // namespace

int main(int argc, char** argv)
{
    if (argc < 4)
    {
        std::fprintf(stderr, "usage: %s <folder of models> <seed> <points> [model...]\n", argv[0]);
        return 2;
    }
    std::vector<std::string> models(argv + 4, argv + argc);
    if (models.empty())
        models = {"bunny_closed", "armadillo_43k", "horse", "rocker_arm", "fertility", "block", "fandisk"};
    std::vector<Model> loaded;
    std::string header = "| noise |", rule = "|---|";
    for (const std::string& name : models)
    {
        loaded.push_back(load_model(argv[1] + ("/" + name) + ".ply"));
        header += " " + name + " |";
        rule += "---|";
    }
    std::printf("%s\n%s\n", header.c_str(), rule.c_str());
    int right = 0, cells = 0;
    for (const Kind& kind : kinds)
    {
        std::printf("| %s |", kind.name);
        for (const Model& model : loaded)
        {
            Cloud cloud(model, std::atoi(argv[3]), 1000 * unsigned(std::atoi(argv[2])) + 10 * unsigned(cells++));
            try
            {
                const recon::TriangleMesh crust = recon::reconstruct_noisy_power_crust(kind.make(cloud)).mesh;
                const checks::MeshReport report = checks::examine_mesh(crust);
                const double volume = report.volume / model.volume;
                std::printf(" %.0f", 1e6 * MeshDistance(model.mesh).summarise(crust.vertices).rms / model.diagonal);
                if (is_right(report, model.genus, volume))
                    ++right;
                else
                    std::printf(", %sgenus %d of %d, volume %.3f",
                                report.is_closed_oriented_manifold() ? "" : "NOT CLOSED, ", report.genus(), model.genus,
                                volume);
                std::printf(" |");
            }
            catch (const std::exception& e)
            {
                std::printf(" failed: %s |", e.what());
            }
            std::fflush(stdout);
        }
        std::printf("\n");
    }
    std::printf("\n%d of %d right\n", right, cells);
}
