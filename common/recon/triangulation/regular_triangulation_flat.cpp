#include <recon/triangulation/regular_triangulation.h>

#include <recon/parallel.h>
#include <recon/triangulation/power_centre.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace recon
{
namespace
{

constexpr std::size_t grain = 8192; ///< Cells or buckets a thread takes at a time.

} // namespace

/// The cell with indices of points for vertices, in ascending order but for the last two.
RegularTriangulation::Cell RegularTriangulation::name_vertices(Cell cell) const
{
    for (int& v : cell.vertices)
        v = v == Triangulation::infinite ? v : indices_[v];
    bool odd = false;
    const auto exchange = [&](int p, int q)
    {
        std::swap(cell.vertices[p], cell.vertices[q]);
        std::swap(cell.neighbours[p], cell.neighbours[q]);
        odd = !odd;
    };
    for (const auto& [p, q] : {std::pair(0, 1), std::pair(2, 3), std::pair(0, 2), std::pair(1, 3), std::pair(1, 2)})
        if (cell.vertices[p] > cell.vertices[q])
            exchange(p, q);
    if (odd)
        exchange(2, 3);
    return cell;
}

RegularTriangulation::Buckets RegularTriangulation::sort_into_buckets(std::size_t n, int threads) const
{
    std::vector<int> bucket(used_);
    parallel_for(
        bucket.size(), threads, {},
        [&](std::size_t i)
        {
            const auto& v = cells_[i].vertices;
            bucket[i] = none;
            if (v[0] == dead)
                return;
            int lowest = std::numeric_limits<int>::max();
            for (const int k : v)
                lowest = k == Triangulation::infinite ? lowest : std::min(lowest, indices_[k]);
            bucket[i] = is_infinite(cells_[i]) ? int(n) + lowest : lowest;
        },
        grain);
    Buckets result;
    result.first.assign(2 * n + 1, 0);
    parallel_for(
        bucket.size(), threads, {},
        [&](std::size_t i)
        {
            if (bucket[i] != none)
                fetch_add(result.first[bucket[i] + 1], 1);
        },
        grain);
    std::partial_sum(result.first.begin(), result.first.end(), result.first.begin());
    result.cells.resize(result.first.back());
    std::vector<int> next(result.first.begin(), result.first.end() - 1);
    parallel_for(
        bucket.size(), threads, {},
        [&](std::size_t i)
        {
            if (bucket[i] != none)
                result.cells[fetch_add(next[bucket[i]], 1)] = int(i);
        },
        grain);
    return result;
}

std::vector<int> RegularTriangulation::name_cells(const Buckets& buckets, Triangulation& flat, int threads) const
{
    struct Named
    {
        Cell cell;
        int number;
    };
    flat.cells.resize(buckets.cells.size());
    std::vector<int> position(used_);
    parallel_chunks(buckets.first.size() - 1, threads, grain, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<Named> in_bucket;
                        for (std::size_t b = begin; b < end; ++b)
                        {
                            in_bucket.clear();
                            for (int k = buckets.first[b]; k < buckets.first[b + 1]; ++k)
                            {
                                // They lie where the insertion has put them: without this, half the time goes in
                                // waiting for memory.
                                constexpr int ahead = 24;
                                if (k + ahead < int(buckets.cells.size()))
                                    __builtin_prefetch(&cells_[buckets.cells[k + ahead]]);
                                const int number = buckets.cells[k];
                                in_bucket.push_back({name_vertices(cells_[number]), number});
                            }
                            std::sort(in_bucket.begin(), in_bucket.end(),
                                      [](const Named& p, const Named& q) { return p.cell.vertices < q.cell.vertices; });
                            int k = buckets.first[b];
                            for (const Named& named : in_bucket)
                            {
                                flat.cells[k] = named.cell;
                                position[named.number] = k++;
                            }
                        }
                    });
    return position;
}

Triangulation RegularTriangulation::flatten(const Points& points, const std::vector<double>& weights, int threads) &&
{
    marks_ = {};
    owners_.reset();
    serial_ = {};
    Triangulation flat;
    std::vector<int> position;
    {
        const Buckets buckets = sort_into_buckets(points.size(), threads);
        flat.finite_cells = buckets.first[points.size()];
        position = name_cells(buckets, flat, threads);
    }
    cells_.reset();
    flat.centres.resize(std::size_t(flat.finite_cells));
    parallel_for(
        flat.cells.size(), threads, {},
        [&](std::size_t k)
        {
            for (int& neighbour : flat.cells[k].neighbours)
                neighbour = position[neighbour];
            if (!flat.is_finite(int(k)))
                return;
            const auto& v = flat.cells[k].vertices;
            const auto weight = [&](int i) { return weights.empty() ? 0 : weights[v[i]]; };
            flat.centres[k] = find_power_centre({points[v[0]], points[v[1]], points[v[2]], points[v[3]]},
                                                {weight(0), weight(1), weight(2), weight(3)});
        },
        grain);
    return flat;
}

} // namespace recon
