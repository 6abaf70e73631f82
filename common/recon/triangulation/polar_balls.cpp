#include <recon/triangulation/polar_balls.h>

#include <recon/parallel.h>

#include <algorithm>
#include <cstdint>

namespace recon
{
namespace
{

/// Calls body(cell, vertex) for all finite cells and their vertices below `samples`; for each vertex on one thread, by
/// ascending cells.
template <class Body>
void for_each_corner(const Triangulation& delaunay, std::size_t samples, int threads, Body&& body)
{
    constexpr int most_parts = 8; // each walks through all cells
    const std::size_t parts = std::size_t(std::clamp(threads, 1, most_parts));
    parallel_for(
        parts, threads, {},
        [&](std::size_t part)
        {
            const int begin = int(samples * part / parts), end = int(samples * (part + 1) / parts);
            for (int c = 0; c < delaunay.finite_cells; ++c)
                for (const int v : delaunay.cells[c].vertices)
                    if (v >= begin && v < end)
                        body(c, v);
        },
        1);
}

/// Per sample, the farthest Voronoi vertex among those for which accept(sample, offset) holds.
template <class Accept>
void find_farthest(const Triangulation& delaunay, const Points& samples, int which, int threads, Poles& poles,
                   Accept&& accept)
{
    std::vector<double> farthest(samples.size(), 0);
    for_each_corner(delaunay, samples.size(), threads,
                    [&](int c, int v)
                    {
                        const Vector offset = delaunay.centres[c] - samples[v];
                        const double squared = offset.squaredNorm();
                        if (squared > farthest[v] && accept(v, offset))
                        {
                            farthest[v] = squared;
                            poles.cells[v][which] = c;
                        }
                    });
}

} // namespace

Poles find_poles(const Triangulation& delaunay, const Points& samples, int threads)
{
    Poles poles;
    poles.cells.assign(samples.size(), {Poles::none, Poles::none});
    find_farthest(delaunay, samples, 0, threads, poles, [](int, const Vector&) { return true; });
    const auto opposes_first = [&](int v, const Vector& offset)
    { return offset.dot(delaunay.centres[poles.cells[v][0]] - samples[v]) < 0; };
    find_farthest(delaunay, samples, 1, threads, poles, opposes_first);
    return poles;
}

Poles find_poles_along_normals(const Triangulation& delaunay, const Points& samples, const Vectors& normals,
                               int threads)
{
    Poles poles;
    poles.cells.assign(samples.size(), {Poles::none, Poles::none});
    const int oriented = int(normals.size());
    find_farthest(delaunay, samples, 0, threads, poles,
                  [&](int v, const Vector& offset) { return v >= oriented || offset.dot(normals[v]) > 0; });
    find_farthest(delaunay, samples, 1, threads, poles,
                  [&](int v, const Vector& offset)
                  {
                      const Vector direction =
                          v < oriented ? normals[v] : Vector(delaunay.centres[poles.cells[v][0]] - samples[v]);
                      return offset.dot(direction) < 0;
                  });
    return poles;
}

void find_slant_poles(const Triangulation& delaunay, const Points& samples, Poles& poles, int threads)
{
    constexpr double largest_squared_cosine = 0.5, smallest_squared_ratio = 0.49;
    struct Side
    {
        Vector pole = Vector::Zero();
        double squared = 0, farthest = 0;
    };
    std::vector<std::array<Side, 2>> sides(samples.size() - box_corner_count);
    for (std::size_t v = 0; v < sides.size(); ++v)
        for (int k = 0; k < 2; ++k)
            if (const int c = poles.cells[v][k]; c != Poles::none)
            {
                sides[v][k].pole = delaunay.centres[c] - samples[v];
                sides[v][k].squared = sides[v][k].pole.squaredNorm();
            }
    poles.slant.assign(samples.size(), {Poles::none, Poles::none});
    for_each_corner(delaunay, sides.size(), threads,
                    [&](int c, int v)
                    {
                        const Vector offset = delaunay.centres[c] - samples[v];
                        const double squared = offset.squaredNorm();
                        for (int k = 0; k < 2; ++k)
                        {
                            Side& own = sides[v][k];
                            const double along = offset.dot(own.pole);
                            if (along <= 0 || squared <= own.farthest ||
                                squared < smallest_squared_ratio * own.squared ||
                                along * along > largest_squared_cosine * squared * own.squared ||
                                offset.dot(sides[v][1 - k].pole) > 0)
                                continue;
                            own.farthest = squared;
                            poles.slant[v][k] = c;
                        }
                    });
}

void share_poles(const Triangulation& delaunay, const Points& samples, Poles& poles, int threads)
{
    // Looser ones leave hardly fewer balls, and a crust that is coarser than the samples.
    constexpr double smallest_cosine = 0.95, smallest_ratio = 0.7;
    const int n = int(samples.size()) - box_corner_count;
    const auto can_serve = [&](const Vector& offset, int v, int side)
    {
        const int own = poles.cells[v][side];
        if (own == Poles::none || (!poles.slant.empty() && poles.slant[v][side] != Poles::none))
            return false;
        const Vector own_offset = delaunay.centres[own] - samples[v];
        const double squared = offset.squaredNorm(), own_squared = own_offset.squaredNorm(),
                     along = offset.dot(own_offset);
        return along > 0 && along * along >= smallest_cosine * smallest_cosine * squared * own_squared &&
               squared >= smallest_ratio * smallest_ratio * own_squared;
    };
    // Per cell, bit 2 k + side: it can be the pole of its vertex k on that side.
    using Bits = std::uint8_t;
    std::vector<Bits> serves(std::size_t(delaunay.finite_cells), 0);
    constexpr std::size_t grain = 8192;
    parallel_for(
        serves.size(), threads, {},
        [&](std::size_t c)
        {
            for (int k = 0; k < 4; ++k)
                if (const int v = delaunay.cells[c].vertices[k]; v < n)
                    for (int side = 0; side < 2; ++side)
                        if (can_serve(delaunay.centres[c] - samples[v], v, side))
                            serves[c] |= Bits(1 << (2 * k + side));
        },
        grain);
    // A set cover, greedily: first cells that serve four samples, then three, then two; who is left keeps its own.
    std::vector<Bits> is_served(std::size_t(n), 0); // bit: side
    for (int least = 4; least > 1; --least)
        for (int c = 0; c < delaunay.finite_cells; ++c)
        {
            if (__builtin_popcount(serves[c]) < least)
                continue;
            const auto& vertices = delaunay.cells[c].vertices;
            for (int k = 0; k < 4; ++k)
                if (vertices[k] < n)
                    serves[c] &= Bits(~(is_served[vertices[k]] << (2 * k)));
            if (__builtin_popcount(serves[c]) < least)
                continue;
            for (int k = 0; k < 4; ++k)
                for (int side = 0; side < 2; ++side)
                    if (serves[c] >> (2 * k + side) & 1)
                    {
                        poles.cells[vertices[k]][side] = c;
                        is_served[vertices[k]] |= Bits(1 << side);
                    }
            serves[c] = 0;
        }
}

void append_box_corners(Points& samples)
{
    for (int corner = 0; corner < box_corner_count; ++corner)
        samples.emplace_back(corner & 1 ? 2.5 : -2.5, corner & 2 ? 2.5 : -2.5, corner & 4 ? 2.5 : -2.5);
}

PolarBalls keep_polar_balls(const Triangulation& delaunay, const Points& samples, const Poles& poles,
                            const std::function<bool(double radius, const std::array<int, 4>& touched)>& keep)
{
    PolarBalls result;
    result.of_sample.assign(samples.size(), {Poles::none, Poles::none});
    result.slant_of_sample = result.of_sample;
    constexpr int unseen = -2, dropped = -1;
    std::vector<int> ball_of_cell(std::size_t(delaunay.finite_cells), unseen);
    const int first_corner = int(samples.size()) - box_corner_count;
    // Corners first: their balls are kept whatever their size.
    for (int step = 0; step < int(samples.size()); ++step)
    {
        const int v = step < box_corner_count ? first_corner + step : step - box_corner_count;
        const auto keep_ball = [&](int c, int& of_sample)
        {
            if (c == Poles::none)
                return;
            int& ball = ball_of_cell[c];
            if (ball == unseen)
            {
                const auto& touched = delaunay.cells[c].vertices;
                const double radius = (delaunay.centres[c] - samples[touched[0]]).norm();
                const bool is_outside = v >= first_corner;
                ball = dropped;
                if (is_outside || keep(radius, touched))
                {
                    ball = int(result.balls.size());
                    result.balls.push_back({delaunay.centres[c], radius});
                    result.touched.push_back(touched);
                    result.is_outside.push_back(is_outside);
                }
            }
            of_sample = ball;
        };
        for (int side = 0; side < 2; ++side)
        {
            keep_ball(poles.cells[v][side], result.of_sample[v][side]);
            if (!poles.slant.empty())
                keep_ball(poles.slant[v][side], result.slant_of_sample[v][side]);
        }
    }
    return result;
}

double measure_outwardness(const PolarBalls& balls, int ball, const Points& samples, const Vectors& normals)
{
    double sum = 0;
    int count = 0;
    for (const int v : balls.touched[ball])
        if (v < int(normals.size()))
        {
            sum += normals[v].dot((balls.balls[ball].centre - samples[v]).normalized());
            ++count;
        }
    return count > 0 ? sum / count : 0;
}

} // namespace recon
