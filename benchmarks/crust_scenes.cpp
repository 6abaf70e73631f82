// Scenes over a floor, ray-cast: tables, chairs, shelves, balls, boxes, seen by one to five scanners around or above.
// crust_scenes <first seed> <scenes> [-o folder] [--depth-camera | --laser-scanner [stations] [--beams n]]
// One Markdown row a scene: share of samples whose normal is right (filter "Compute normals"), by how many degrees it
// is off on average, and share that a crust reaches within 2.5 spacings and faces as they do, by the power crust and by
// AMLS's reconstruction, both with open holes. Odd seeds are turned at random, so that no axis is up. A depth camera
// sees the scene from one place, half of them before a wall, in pixels whose depth is a whole number of steps that grow
// with its square; odd seeds are in its own coordinates. So are those of a laser scanner, which stands in the middle
// and turns, half of them in a room. Of several stations each has half the rays, and sweep follows sweep, in the room's
// coordinates. Of beams, in place of rows, there are few, over 45 degrees, each of which reads every fifth of a degree.
#include "filter_amls/mesh/reconstruct_amls.h"
#include "filter_amls/normals/outward_normals.h"
#include "filter_noisy_powercrust/reconstruct.h"
#include "mesh_distance.h"
#include "models.h"
#include "tests/checks.h"
#include "tests/shapes.h"

#include <recon/median.h>
#include <recon/search/keep_apart.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>

using namespace benchmarks;
using namespace recon;

namespace
{

constexpr double pi = 3.14159265358979323846;

class Scene
{
public:
    explicit Scene(unsigned seed) : random_(seed) {}

    double draw(double from, double to) { return from + (to - from) * shapes::uniform(random_); }
    int draw_index(int count) { return std::min(count - 1, int(draw(0, count))); }

    void add_box(const Point& low, const Point& high)
    {
        const int base = int(mesh.vertices.size());
        for (int k = 0; k < 8; ++k)
            mesh.vertices.emplace_back(k & 1 ? high.x() : low.x(), k & 2 ? high.y() : low.y(),
                                       k & 4 ? high.z() : low.z());
        for (const auto& q : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
                              std::array{2, 6, 7, 3}, std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}})
            for (const auto& t : {std::array{q[0], q[1], q[2]}, std::array{q[0], q[2], q[3]}})
                mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
    }
    void add_ball(const Point& centre, double radius)
    {
        constexpr int rings = 24, sectors = 48;
        const int base = int(mesh.vertices.size());
        for (int i = 0; i <= rings; ++i)
            for (int j = 0; j < sectors; ++j)
            {
                const double a = pi * i / rings, b = 2 * pi * j / sectors;
                mesh.vertices.push_back(
                    centre + radius * Vector(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
            }
        const auto at = [&](int i, int j) { return base + i * sectors + j % sectors; };
        for (int i = 0; i < rings; ++i)
            for (int j = 0; j < sectors; ++j)
            {
                mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
                mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
            }
    }
    /// A top on four legs.
    void add_table(double x, double y, double height, double width, double depth, double top, double leg)
    {
        add_box({x - width / 2, y - depth / 2, height - top}, {x + width / 2, y + depth / 2, height});
        for (const int sx : {-1, 1})
            for (const int sy : {-1, 1})
            {
                const double cx = x + sx * (width / 2 - leg), cy = y + sy * (depth / 2 - leg);
                add_box({cx - leg / 2, cy - leg / 2, 0}, {cx + leg / 2, cy + leg / 2, height - top});
            }
    }
    void add_thing(double x, double y)
    {
        const double r = draw(0.15, 0.35), h = draw(0.3, 1), w = draw(0.2, 0.5);
        switch (draw_index(7))
        {
        case 0: add_box({x - w / 2, y - r / 2, 0}, {x + w / 2, y + r / 2, h}); break;
        case 1: add_table(x, y, draw(0.4, 0.9), draw(0.6, 1.2), draw(0.5, 0.9), 0.04, 0.06); break;
        case 2: // a chair
            add_table(x, y, 0.45, 0.45, 0.45, 0.03, 0.04);
            add_box({x - 0.225, y + 0.19, 0.45}, {x + 0.225, y + 0.225, 0.95});
            break;
        case 3: add_ball({x, y, 0.97 * r}, r); break;
        case 4: // a ball on a pole
            add_box({x - 0.03, y - 0.03, 0}, {x + 0.03, y + 0.03, h});
            add_ball({x, y, h + 0.9 * r}, r);
            break;
        case 5: // a shelf
            for (const int side : {-1, 1})
                add_box({x + side * w - 0.02, y - 0.17, 0}, {x + side * w + 0.02, y + 0.17, 1.3});
            for (const double z : {0.05, 0.6, 1.25})
                add_box({x - w, y - 0.17, z}, {x + w, y + 0.17, z + 0.04});
            break;
        default: // a box on a smaller one
            add_box({x - w / 2, y - w / 2, 0}, {x + w / 2, y + w / 2, h});
            add_box({x - w, y - w, h}, {x + w, y + w, h + 0.1});
        }
    }

    TriangleMesh mesh;

private:
    shapes::Random random_;
};

/// A floor and what stands on it. \param free around the middle. \returns how many.
int add_things(Scene& scene, double length, double width, double free = 0)
{
    scene.add_box({-length, -width, -0.05}, {length, width, 0});
    const int wanted = 1 + scene.draw_index(6);
    Points places;
    for (int trial = 0; trial < 60 && int(places.size()) < wanted; ++trial)
    {
        const Point p(scene.draw(-1, 1) * (length - 0.8), scene.draw(-1, 1) * (width - 0.8), 0);
        if (p.norm() >= free &&
            std::all_of(places.begin(), places.end(), [&](const Point& q) { return (p - q).norm() > 1.1; }))
        {
            places.push_back(p);
            scene.add_thing(p.x(), p.y());
        }
    }
    return int(places.size());
}

Vector normal_of(const TriangleMesh& mesh, int triangle)
{
    const auto& t = mesh.triangles[std::size_t(triangle)];
    const Point& a = mesh.vertices[t[0]];
    return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized();
}

void turn_at_random(Scene& scene, OrientedSamples& samples)
{
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(
        scene.draw(0, 2 * pi), Vector(scene.draw(-1, 1), scene.draw(-1, 1), scene.draw(-1, 1)).normalized()));
    for (Point& p : samples.points)
        p = turn * p;
    for (Vector& n : samples.normals)
        n = turn * n;
}

/// Noisy samples that the scanners saw, with the normals of what they lie on. \param spacing least distance, written.
OrientedSamples scan(Scene& scene, unsigned seed, int& things, int& scanners, double& spacing)
{
    const double length = scene.draw(1.5, 2.5), width = scene.draw(1.5, 2.5);
    things = add_things(scene, length, width);
    const MeshDistance surface(scene.mesh);
    scanners = 1 + scene.draw_index(5);
    const bool from_above = scene.draw(0, 1) < 0.3;
    const double first = scene.draw(0, 2 * pi);
    OrientedSamples seen;
    for (int k = 0; k < scanners; ++k)
    {
        const double turn = first + 2 * pi * k / scanners;
        const Point eye =
            from_above ? Point(scene.draw(-length, length), scene.draw(-width, width), scene.draw(3, 5))
                       : Point((length + 1) * std::cos(turn), (width + 1) * std::sin(turn), scene.draw(1.3, 2.5));
        const Vector ahead = (Point(0, 0.01, 0.1) - eye).normalized(),
                     right = ahead.cross(Vector::UnitZ()).normalized(), up = right.cross(ahead);
        for (int ray = 0; ray < 200'000 / scanners; ++ray)
        {
            const Vector direction = ahead + scene.draw(-0.93, 0.93) * right + scene.draw(-0.93, 0.93) * up;
            const MeshDistance::Nearest hit = surface.first_hit(eye, direction.normalized());
            if (hit.triangle < 0)
                continue;
            seen.points.push_back(hit.point);
            seen.normals.push_back(normal_of(scene.mesh, hit.triangle));
        }
    }
    spacing = 2 * std::max(length, width) / std::array{120.0, 200.0, 300.0}[std::size_t(scene.draw_index(3))];
    const std::vector<int> kept = keep_apart(seen.points, std::vector<double>(seen.points.size(), 0.8 * spacing));
    OrientedSamples result{points_at(kept, seen.points), points_at(kept, seen.normals)};
    const double noise = std::array{0.02, 0.15, 0.4}[std::size_t(scene.draw_index(3))];
    result.points = shapes::with_noise(result.points, noise * spacing, seed);
    if (seed % 2 == 1)
        turn_at_random(scene, result);
    return result;
}

/// The same in one frame of a depth camera. \param spacing of its pixels at the mean depth, written.
OrientedSamples take_frame(Scene& scene, unsigned seed, int& things, double& spacing)
{
    const double length = scene.draw(1, 1.6), width = scene.draw(1, 1.6);
    things = add_things(scene, length, width);
    if (scene.draw(0, 1) < 0.5)
        scene.add_box({-length - 0.05, -width, 0}, {-length, width, 1.5});
    const MeshDistance surface(scene.mesh);
    const Point eye(length + 0.6, scene.draw(-0.5, 0.5), scene.draw(0.8, 2));
    const Vector ahead = (Point(0, 0, 0.2) - eye).normalized(), right = ahead.cross(Vector::UnitZ()).normalized(),
                 up = right.cross(ahead);
    constexpr int columns = 320, rows = 240;
    constexpr double pixel = 1.15 / columns; // at a depth of 1
    const double step = std::array{1e-4, 1e-3, 3e-3}[std::size_t(scene.draw_index(3))];
    OrientedSamples result;
    double depths = 0;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j)
        {
            const Vector direction = ahead + pixel * ((j - columns / 2) * right + (rows / 2 - i) * up);
            const MeshDistance::Nearest hit = surface.first_hit(eye, direction.normalized());
            if (hit.triangle < 0)
                continue;
            const double steps = 1 / (step * (hit.point - eye).dot(ahead));
            const double depth = 1 / (step * std::round(steps + scene.draw(-0.5, 0.5)));
            result.points.push_back(eye + depth * direction);
            result.normals.push_back(normal_of(scene.mesh, hit.triangle));
            depths += depth;
        }
    spacing = pixel * depths / double(result.points.size());
    if (seed % 2 == 1)
    {
        Eigen::Matrix3d to_camera;
        to_camera << right, -up, ahead;
        for (Point& p : result.points)
            p = to_camera.transpose() * (p - eye);
        for (Vector& n : result.normals)
            n = to_camera.transpose() * n;
    }
    return result;
}

/// The same by a laser scanner. \param stations where it stands in turn. \param beams 0 = as far apart as readings of
/// a row. \param spacing of its rays at the median range, written.
OrientedSamples sweep(Scene& scene, unsigned seed, int stations, int beams, int& things, double& spacing)
{
    const double length = scene.draw(2.5, 5), width = scene.draw(2.5, 5), height = scene.draw(1.2, 1.8);
    things = add_things(scene, length, width, 1.5);
    if (scene.draw(0, 1) < 0.5)
    {
        const Point low(-length, -width, 0), high(length, width, 2.6);
        for (int axis = 0; axis < 2; ++axis)
            for (const bool far : {false, true})
            {
                Point from = low, to = high;
                (far ? from : to)[axis] = far ? high[axis] : low[axis];
                (far ? to : from)[axis] += far ? 0.05 : -0.05;
                scene.add_box(from, to);
            }
        scene.add_box({-length, -width, 2.6}, {length, width, 2.65});
    }
    const MeshDistance surface(scene.mesh);
    Points eyes{{0, 0, height}};
    const double even = scene.draw(0.35, 0.6) * pi / 180 * (stations > 1 ? std::sqrt(2.0) : 1),
                 step = beams > 0 ? 0.2 * pi / 180 : even, across = beams > 0 ? pi / 4 / beams : even,
                 lowest = beams > 0 ? -pi / 6 : -pi / 3, highest = beams > 0 ? pi / 12 : pi / 3,
                 noise = std::array{0.0, 0.002, 0.006}[std::size_t(scene.draw_index(3))];
    for (int k = 1; k < stations; ++k)
    {
        const double turn = 2 * pi * (k + scene.draw(-0.3, 0.3)) / (stations - 1);
        eyes.emplace_back(0.75 * length * std::cos(turn), 0.75 * width * std::sin(turn), scene.draw(1.9, 2.3));
    }
    OrientedSamples result;
    std::vector<double> ranges;
    for (const Point& eye : eyes)
        for (double over = lowest; over < highest; over += across)
            for (double about = -pi; about < pi - step / 2; about += step)
            {
                const Vector direction(std::cos(over) * std::cos(about), std::cos(over) * std::sin(about),
                                       std::sin(over));
                const MeshDistance::Nearest hit = surface.first_hit(eye, direction);
                if (hit.triangle < 0)
                    continue;
                // Of variance 1, nearly Gaussian.
                const double off = scene.draw(-1, 1) + scene.draw(-1, 1) + scene.draw(-1, 1);
                ranges.push_back((hit.point - eye).norm() + noise * off);
                result.points.push_back((seed % 2 == 1 && stations == 1 ? Point::Zero() : eye) +
                                        ranges.back() * direction);
                result.normals.push_back(normal_of(scene.mesh, hit.triangle));
            }
    spacing = across * median(std::move(ranges));
    return result;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3)
    {
        std::fprintf(
            stderr,
            "usage: %s <first seed> <scenes> [-o folder] [--depth-camera | --laser-scanner [stations] [--beams n]]\n",
            argv[0]);
        return 2;
    }
    std::string folder;
    bool by_depth_camera = false;
    int stations = 0, beams = 0; // of a laser scanner
    for (int i = 3; i < argc; ++i)
        if (std::strcmp(argv[i], "--depth-camera") == 0)
            by_depth_camera = true;
        else if (std::strcmp(argv[i], "--laser-scanner") == 0)
            stations = i + 1 < argc && std::atoi(argv[i + 1]) > 0 ? std::atoi(argv[++i]) : 1;
        else if (std::strcmp(argv[i], "--beams") == 0 && i + 1 < argc)
            beams = std::atoi(argv[++i]);
        else if (std::strcmp(argv[i], "-o") == 0 && i + 1 < argc)
            folder = argv[++i];
    const int scenes = std::atoi(argv[2]);
    double sums[4] = {0, 0, 0, 0};
    std::printf("| seed | samples | things | scanners | normals | off | power crust | AMLS "
                "|\n|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < scenes; ++i)
    {
        const unsigned seed = unsigned(std::atoi(argv[1]) + i);
        Scene scene(seed);
        int things, scanners = std::max(1, stations);
        double spacing;
        const OrientedSamples cloud = by_depth_camera ? take_frame(scene, seed, things, spacing)
                                      : stations > 0  ? sweep(scene, seed, stations, beams, things, spacing)
                                                      : scan(scene, seed, things, scanners, spacing);
        NoisyPowerCrustOptions crust;
        crust.open_holes = true;
        AmlsReconstructionOptions amls;
        amls.open_holes = true;
        const TriangleMesh meshes[2] = {reconstruct_noisy_power_crust(cloud.points, crust).mesh,
                                        reconstruct_amls(cloud.points, amls).mesh};
        const Vectors normals = find_outward_normals(cloud.points).normals;
        const double shares[4] = {
            checks::share_facing(normals, cloud.normals), checks::mean_angle(normals, cloud.normals),
            checks::share_faced(meshes[0], cloud, 2.5 * spacing), checks::share_faced(meshes[1], cloud, 2.5 * spacing)};
        for (int k = 0; k < 4; ++k)
            sums[k] += shares[k] / scenes;
        std::printf("| %u | %zu | %d | %d | %.4f | %.1f | %.4f | %.4f |\n", seed, cloud.points.size(), things, scanners,
                    shares[0], shares[1], shares[2], shares[3]);
        std::fflush(stdout);
        if (!folder.empty())
        {
            const std::string name = folder + "/" + std::to_string(seed);
            save_ply(name + ".ply", cloud.points, cloud.normals);
            save_ply(name + "_crust.ply", meshes[0]);
            save_ply(name + "_amls.ply", meshes[1]);
        }
    }
    std::printf("| mean | | | | %.4f | %.1f | %.4f | %.4f |\n", sums[0], sums[1], sums[2], sums[3]);
}
