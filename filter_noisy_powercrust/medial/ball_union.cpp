#include "ball_union.h"

#include <recon/disjoint_sets.h>
#include <recon/geometry.h>
#include <recon/parallel.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;

/// Uniform among rotations (Shoemake 1992).
Eigen::Matrix3d turn_at_random(unsigned seed)
{
    std::minstd_rand random(seed + 1);
    random.discard(3); // the first follow the seed
    std::uniform_real_distribution<double> uniform;
    const double share = uniform(random), first = 2 * pi * uniform(random), second = 2 * pi * uniform(random);
    const double a = std::sqrt(1 - share), b = std::sqrt(share);
    return Eigen::Quaterniond(b * std::cos(second), a * std::sin(first), a * std::cos(first), b * std::sin(second))
        .toRotationMatrix();
}

} // namespace

UnionMeasure measure_union(const Triangulation& regular, const std::vector<Ball>& balls,
                           const std::vector<char>& is_member, int threads, const Progress& progress)
{
    // Of many balls a hair's breadth apart on a curve each shows a sliver, which few directions meet.
    constexpr int fewest = 256, most = 16384, in_all = 1 << 24;
    const int directions =
        std::clamp(in_all / std::max(int(std::count(is_member.begin(), is_member.end(), 1)), 1), fewest, most);
    std::vector<Vector> sphere;
    for (int k = 0; k < directions; ++k)
    {
        const double z = 1 - (2 * k + 1.0) / directions, angle = pi * (3 - std::sqrt(5.0)) * k,
                     r = std::sqrt(1 - z * z);
        sphere.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
    const CellsAtVertices at = list_cells_at_vertices(regular, int(balls.size()));
    struct Part
    {
        double area = 0, flux = 0;       // of the position
        Vector moment = Vector::Zero();  // of the boundary
        Vector outward = Vector::Zero(); // sum of the normals, 0 but for the directions' steps
    };
    std::vector<Part> parts(balls.size());
    DisjointSets components(balls.size());
    parallel_for(balls.size(), threads, progress,
                 [&](std::size_t i)
                 {
                     if (!is_member[i])
                         return;
                     std::vector<int> neighbours;
                     for (int k = at.first[i]; k < at.first[i + 1]; ++k)
                         for (const int v : regular.cells[at.cell[k]].vertices)
                             if (v != int(i) && v != Triangulation::infinite && is_member[v])
                                 neighbours.push_back(v);
                     std::sort(neighbours.begin(), neighbours.end());
                     neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
                     const Ball& ball = balls[i];
                     for (const int j : neighbours)
                         if ((ball.centre - balls[j].centre).norm() < ball.radius + balls[j].radius)
                             components.join(int(i), j);
                     const double weight = 4 * pi * ball.radius * ball.radius / directions;
                     const Eigen::Matrix3d turn = turn_at_random(unsigned(i));
                     std::size_t last = 0; // what held one point may hold the next
                     for (const Vector& direction : sphere)
                     {
                         const Vector u = turn * direction;
                         const Point p = ball.centre + ball.radius * u;
                         const auto holds = [&](int j)
                         { return (p - balls[j].centre).squaredNorm() < balls[j].radius * balls[j].radius; };
                         if (last < neighbours.size() && holds(neighbours[last]))
                             continue;
                         last = std::size_t(std::find_if(neighbours.begin(), neighbours.end(), holds) -
                                            neighbours.begin());
                         if (last == neighbours.size())
                         {
                             parts[i].area += weight;
                             parts[i].flux += weight * p.dot(u);
                             parts[i].moment += weight * p;
                             parts[i].outward += weight * u;
                         }
                     }
                 });
    std::vector<Part> sums(balls.size());
    for (std::size_t i = 0; i < balls.size(); ++i)
    {
        Part& sum = sums[std::size_t(components.find(int(i)))];
        sum.area += parts[i].area;
        sum.flux += parts[i].flux;
        sum.moment += parts[i].moment;
        sum.outward += parts[i].outward;
    }
    UnionMeasure result;
    for (const Part& sum : sums)
        if (sum.area > 0)
        {
            result.area += sum.area;
            result.volume += (sum.flux - sum.moment.dot(sum.outward) / sum.area) / 3;
        }
    return result;
}

} // namespace recon
