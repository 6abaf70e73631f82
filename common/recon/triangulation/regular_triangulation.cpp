#include <recon/triangulation/regular_triangulation.h>

#include <recon/parallel.h>
#include <recon/scramble.h>
#include <recon/search/spatial_order.h>

#include <algorithm>
#include <atomic>
#include <thread>

namespace recon
{
namespace
{

/// Points on a surface have some seven cells each, polar balls eight.
constexpr int expected_cells = 9;
/// Fewer sites are not worth threads.
constexpr std::size_t parallel_above = 2048;
constexpr std::size_t report_every = 4096;

} // namespace

RegularTriangulation::RegularTriangulation(const Points& points, const std::vector<double>& weights,
                                           const std::vector<int>& members, int threads, const Progress& progress)
{
    order_sites(points, weights, members);
    grow(expected_cells * sites_.size() + 64);
    serial_.unused_end = int(marks_.size());
    progress.report(0);
    if (make_first_cells())
        insert_all(threads, progress);
}

void RegularTriangulation::order_sites(const Points& points, const std::vector<double>& weights,
                                       const std::vector<int>& members)
{
    Points own;
    own.reserve(members.size());
    for (const int i : members)
        own.push_back(points[i]);
    const SpatialOrder along = order_spatially(own);
    indices_.assign(along.order.size(), none);
    for (std::size_t k = 0; k < members.size(); ++k)
    {
        int& best = indices_[along.representative[k]];
        const int i = members[k];
        if (best == none ||
            (weights.empty() ? i < best : weights[i] > weights[best] || (weights[i] == weights[best] && i < best)))
            best = i;
    }
    sites_.reserve(indices_.size());
    for (const int i : indices_)
        sites_.push_back({points[i].x(), points[i].y(), points[i].z(), weights.empty() ? 0 : weights[i]});
}

void RegularTriangulation::grow(std::size_t capacity)
{
    std::unique_ptr<Cell[]> larger(new Cell[capacity]);
    std::copy_n(cells_.get(), marks_.size(), larger.get());
    cells_ = std::move(larger);
    marks_.resize(capacity, 0);
    owners_.reset();
}

bool RegularTriangulation::make_first_cells()
{
    const int n = int(sites_.size());
    if (n < 4)
        return false;
    // The flattest start is as good as any: exact signs find four sites that span a volume if there are any. Sites far
    // apart along the curve come first, for the exact tests of flat ones are slow.
    const auto spans_area = [&](int c)
    {
        for (int axis = 0; axis < 3; ++axis)
        {
            Site apex = sites_[0];
            (axis == 0 ? apex.x : axis == 1 ? apex.y : apex.z) += 1;
            if (find_orientation(sites_[0], sites_[n - 1], sites_[c], apex) != 0)
                return true;
        }
        return false;
    };
    int c = 1;
    while (c < n - 1 && !spans_area(c))
        ++c;
    int d = 1, orientation = 0;
    for (; c < n - 1 && d < n - 1; ++d)
        if (d != c && (orientation = find_orientation(sites_[0], sites_[n - 1], sites_[c], sites_[d])) != 0)
            break;
    if (orientation == 0)
        return false;

    Cell& first = cells_[0];
    first.vertices = {0, n - 1, c, d};
    if (orientation < 0)
        std::swap(first.vertices[2], first.vertices[3]);
    first.neighbours = {1, 2, 3, 4};
    for (int i = 0; i < 4; ++i)
    {
        // An odd permutation turns the facet to see the outside.
        Cell& outer = cells_[1 + i];
        const int j = (i + 1) % 4, k = (i + 2) % 4;
        outer.vertices = first.vertices;
        outer.vertices[i] = Triangulation::infinite;
        std::swap(outer.vertices[j], outer.vertices[k]);
        for (int m = 0; m < 4; ++m)
        {
            // Across the facet opposite a finite vertex lies the outer cell without it.
            const int position = first.position_of(outer.vertices[m]);
            outer.neighbours[m] = position < 4 ? 1 + position : 0;
        }
    }
    used_ = 5;
    serial_.unused_begin = used_;
    serial_.hint = 0;
    return true;
}

void RegularTriangulation::insert_all(int threads, const Progress& progress)
{
    // Rounds of random subsets, each eight times the one before, bound the expected work (Amenta, Choi and Rote 2003);
    // along the curve within a round, so that the next site is near the last.
    int rounds = 1;
    for (std::size_t left = sites_.size(); left > 512; left /= 8)
        ++rounds;
    const auto round_of = [&](std::size_t site)
    {
        int round = rounds - 1;
        for (std::uint64_t bits = scramble(site * splitmix_step); round > 0 && (bits & 7) == 0; bits >>= 3)
            --round;
        return round;
    };
    std::vector<std::vector<int>> members(rounds);
    for (std::size_t i = 0; i < sites_.size(); ++i)
        if (cells_[0].position_of(int(i)) == 4) // not in the first cell
            members[round_of(i)].push_back(int(i));
    double done = 0;
    for (const std::vector<int>& round : members)
    {
        const double end = done + double(round.size());
        const Progress part = progress.part(done / double(sites_.size()), end / double(sites_.size()));
        done = end;
        if (threads > 1 && round.size() > parallel_above)
            insert_side_by_side(round, threads, part);
        else
            insert_one_by_one(round, part);
    }
}

void RegularTriangulation::insert_one_by_one(const std::vector<int>& sites, const Progress& progress)
{
    for (std::size_t i = 0; i < sites.size(); ++i)
    {
        if (i % report_every == 0)
            progress.report(double(i) / double(sites.size()));
        if (insert(sites[i], serial_) != Outcome::out_of_cells)
            continue;
        const int capacity = int(marks_.size());
        grow(std::size_t(capacity) + std::size_t(capacity) / 2 + serial_.hull.size());
        serial_.unused_end = int(marks_.size());
        insert(sites[i], serial_);
    }
}

void RegularTriangulation::insert_side_by_side(const std::vector<int>& sites, int threads, const Progress& progress)
{
    const std::size_t count = std::min({std::size_t(threads), sites.size() / (parallel_above / 4), std::size_t(255)});
    const auto share = [&](std::size_t k) { return k * sites.size() / count; };
    const std::size_t cells = expected_cells * sites.size();
    if (std::size_t(serial_.unused_end - serial_.unused_begin) < cells)
        grow(std::size_t(serial_.unused_begin) + cells);
    if (!owners_)
        owners_.reset(new std::atomic<std::uint8_t>[marks_.size()]());
    const int hint = find_any_cell();
    std::vector<Worker> workers(count);
    next_slab_ = serial_.unused_begin;
    for (std::size_t k = 0; k < count; ++k)
    {
        Worker& w = workers[k];
        w.owner = std::uint8_t(k + 1);
        w.hint = hint;
        w.random = std::uint32_t(k + 1);
    }
    const auto caller = std::this_thread::get_id();
    std::atomic<bool> is_stopped{false};
    const auto report = [&](double fraction)
    {
        try
        {
            progress.report(fraction);
        }
        catch (...)
        {
            is_stopped = true;
            throw;
        }
    };
    parallel_for(
        count, threads, {},
        [&](std::size_t k)
        {
            Worker& w = workers[k];
            for (std::size_t i = share(k); i < share(k + 1) && !is_stopped; ++i)
            {
                if (i % report_every == 0 && std::this_thread::get_id() == caller)
                    report(double(i - share(k)) / double(share(k + 1) - share(k)));
                const Outcome outcome = insert(sites[i], w);
                if (outcome == Outcome::put_off || outcome == Outcome::out_of_cells)
                    w.put_off.push_back(sites[i]);
            }
        },
        1);

    progress.report(1); // also where the caller's thread came too late for any stretch
    std::vector<int> put_off;
    for (Worker& w : workers)
    {
        put_off.insert(put_off.end(), w.put_off.begin(), w.put_off.end());
        serial_.free.insert(serial_.free.end(), w.free.begin(), w.free.end());
        for (int c = w.unused_begin; c < w.unused_end; ++c)
        {
            cells_[c].vertices[0] = dead;
            serial_.free.push_back(c);
        }
    }
    serial_.unused_end = int(marks_.size());
    used_ = serial_.unused_begin = std::min(int(next_slab_), serial_.unused_end);
    serial_.hint = find_any_cell();
    insert_one_by_one(put_off, progress.part(1, 1));
}

int RegularTriangulation::find_any_cell() const
{
    int c = 0;
    while (cells_[c].vertices[0] == dead || is_infinite(cells_[c]))
        ++c;
    return c;
}

} // namespace recon
