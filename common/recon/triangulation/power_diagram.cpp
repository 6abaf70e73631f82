#include <recon/triangulation/power_diagram.h>

#include <recon/scramble.h>
#include <recon/triangulation/regular_triangulation.h>
#include <recon/triangulation/remove_sites.h>

#include <algorithm>
#include <cstdint>

namespace recon
{
namespace
{

/// Uniform in [0, 1), a fixed function of the index.
double pseudo_random(std::uint64_t index)
{
    return scramble_to_unit(index * splitmix_step);
}

} // namespace

PowerDiagram::PowerDiagram(const std::vector<Ball>& balls, const std::vector<char>& is_left_out)
{
    centres_.reserve(balls.size());
    weights_.reserve(balls.size());
    for (std::size_t i = 0; i < balls.size(); ++i)
    {
        centres_.push_back(balls[i].centre);
        weights_.push_back(balls[i].radius * balls[i].radius * (1 - 1e-9 * pseudo_random(i)));
        if (is_left_out.empty() || !is_left_out[i])
            present_.push_back(int(i));
    }
}

Triangulation PowerDiagram::triangulation(int threads, const Progress& progress)
{
    Triangulation result =
        RegularTriangulation(centres_, weights_, present_, threads, progress).flatten(centres_, weights_, threads);
    std::vector<char> is_vertex(centres_.size(), 0);
    for (int c = 0; c < result.finite_cells; ++c)
        for (const int v : result.cells[c].vertices)
            is_vertex[v] = 1;
    const auto is_hidden = [&](int ball) { return !is_vertex[ball]; };
    present_.erase(std::remove_if(present_.begin(), present_.end(), is_hidden), present_.end());
    return result;
}

void PowerDiagram::remove(const std::vector<int>& balls, Triangulation& current, int threads)
{
    std::vector<char> leaves(centres_.size(), 0);
    for (const int ball : balls)
        leaves[ball] = 1;
    std::vector<int> removed;
    for (const int ball : present_)
        if (leaves[ball])
            removed.push_back(ball);
    present_.erase(std::remove_if(present_.begin(), present_.end(), [&](int ball) { return leaves[ball]; }),
                   present_.end());
    // Taking one out costs as much as inserting some ten.
    const bool few = removed.size() < 0.1 * double(present_.size());
    if (!few || !remove_sites(current, centres_, weights_, removed))
        current = triangulation(threads);
}

} // namespace recon
