#include <recon/search/spatial_order.h>

#include <recon/parallel.h>
#include <recon/search/block_search.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>

namespace recon
{
namespace
{

/// How many spots around one are empty, and its most points: it is no object.
constexpr double alone_within = 100;
constexpr int most_in_spot = 1000;
/// Extent of twins at most [diagonals of the cloud], how many of theirs around are empty, of nearly all of them, and
/// the share that has one.
constexpr double twin_size = 1e-4, twins_alone_within = 5, nearly_all_twins = 0.9, many_twins = 0.05;
/// Twins of one point at most, itself among them: more are an object.
constexpr int most_twins = 8;
/// Of a coarse flat box all corners are twins.
constexpr std::size_t fewest_with_twins = 1000;

/// Spreads the low 21 bits so that two zero bits follow each.
std::uint64_t spread_bits(std::uint64_t x)
{
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffffULL;
    x = (x | x << 16) & 0x1f0000ff0000ffULL;
    x = (x | x << 8) & 0x100f00f00f00f00fULL;
    x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
    x = (x | x << 2) & 0x1249249249249249ULL;
    return x;
}

struct Entry
{
    std::uint64_t key;
    int index;
};

using Entries = std::vector<Entry>;

bool by_key(const Entry& a, const Entry& b)
{
    return a.key < b.key;
}

/// Stable, by the key: digit by digit from the lowest, in a third of std::sort's time where there are many.
void sort_by_key(Entries::iterator begin, Entries::iterator end)
{
    constexpr std::ptrdiff_t many = 2000;
    if (std::is_sorted(begin, end, by_key))
        return;
    if (end - begin < many)
    {
        std::stable_sort(begin, end, by_key);
        return;
    }
    constexpr int digit_bits = 11, key_bits = 63;
    Entries entries(begin, end), sorted(entries.size());
    for (int shift = 0; shift < key_bits; shift += digit_bits)
    {
        const auto digit = [shift](const Entry& e) { return std::size_t(e.key >> shift & ((1u << digit_bits) - 1)); };
        std::array<std::size_t, 1u << digit_bits> next{};
        for (const Entry& e : entries)
            ++next[digit(e)];
        std::size_t total = 0;
        for (std::size_t& n : next)
            n = std::exchange(total, total + n);
        for (const Entry& e : entries)
            sorted[next[digit(e)]++] = e;
        entries.swap(sorted);
    }
    std::copy(entries.begin(), entries.end(), begin);
}

void sort_by_coordinates(const Points& points, Entries::iterator begin, Entries::iterator end)
{
    std::sort(begin, end,
              [&](const Entry& a, const Entry& b)
              {
                  const Point &p = points[a.index], &q = points[b.index];
                  for (int k = 0; k < 3; ++k)
                      if (p[k] != q[k])
                          return p[k] < q[k];
                  return a.index < b.index;
              });
}

/// Sorts along a curve through the bounding box of these points. A crowd in one cell of it gets a curve of its own: one
/// stray point far away can put all others into a few cells.
void sort_along_curve(const Points& points, Entries::iterator begin, Entries::iterator end, int threads)
{
    constexpr std::ptrdiff_t crowd = 64;
    constexpr std::size_t grain = 8192;
    const std::size_t n = std::size_t(end - begin);
    const Box start{points[begin->index], points[begin->index]};
    std::vector<Box> boxes((n + grain - 1) / grain, start);
    parallel_for(
        n, threads, {},
        [&](std::size_t i)
        {
            Box& box = boxes[i / grain];
            box.minimum = box.minimum.cwiseMin(points[begin[std::ptrdiff_t(i)].index]);
            box.maximum = box.maximum.cwiseMax(points[begin[std::ptrdiff_t(i)].index]);
        },
        grain);
    Box box = start;
    for (const Box& part : boxes)
    {
        box.minimum = box.minimum.cwiseMin(part.minimum);
        box.maximum = box.maximum.cwiseMax(part.maximum);
    }
    const double diagonal = box.diagonal();
    if (diagonal < 1e-290) // all but equal
    {
        sort_by_coordinates(points, begin, end);
        return;
    }
    const double cells = 2097151 / diagonal;
    parallel_for(
        n, threads, {},
        [&](std::size_t i)
        {
            Entry& e = begin[std::ptrdiff_t(i)];
            const Vector v = (points[e.index] - box.minimum) * cells;
            e.key = spread_bits(std::uint64_t(v.x())) | spread_bits(std::uint64_t(v.y())) << 1 |
                    spread_bits(std::uint64_t(v.z())) << 2;
        },
        grain);
    sort_by_key(begin, end);
    for (auto first = begin; first != end;)
    {
        auto last = first + 1;
        while (last != end && last->key == first->key)
            ++last;
        if (last - first > crowd)
            sort_along_curve(points, first, last, threads);
        else if (last - first > 1)
            sort_by_coordinates(points, first, last);
        first = last;
    }
}

/// Extent of spots that hold the twins of a cloud [length], 0 if it has hardly any. Neighbours in the order tell: they
/// are mostly twins if there are such.
double find_twin_spot(const Points& sorted, double diagonal)
{
    const double n = double(sorted.size()), most = twin_size * diagonal;
    std::vector<double> steps;
    int near = 0;
    for (std::size_t i = 1; i < sorted.size(); ++i)
        if (const double step = (sorted[i] - sorted[i - 1]).norm(); step <= twins_alone_within * most)
        {
            steps.push_back(step);
            near += step <= most;
        }
    if (sorted.size() < fewest_with_twins || near < many_twins * n)
        return 0;
    std::sort(steps.begin(), steps.end());
    const auto up_to = [&](double step)
    { return double(std::upper_bound(steps.begin(), steps.end(), step) - steps.begin()); };
    const double least = spot_size * diagonal;
    for (double spot = most; spot > least; spot /= 2)
        if (const double twins = up_to(spot);
            twins >= many_twins * n && twins >= nearly_all_twins * up_to(twins_alone_within * spot))
        {
            while (spot / 2 > least && up_to(spot / 2) >= 0.99 * twins)
                spot /= 2;
            return spot;
        }
    return 0;
}

/// Sorted points that lie in a spot with the next one of them.
std::vector<int> list_crowded(const Points& sorted, double spot)
{
    std::vector<int> result;
    for (int i = 0; i + 1 < int(sorted.size()); ++i)
        if ((sorted[i + 1] - sorted[i]).norm() <= spot)
            result.push_back(i);
    return result;
}

/// Per sorted point the first one of its spot, mostly itself.
std::vector<int> find_spots(const Points& sorted, const std::vector<int>& crowded, double spot, double alone_within,
                            int most)
{
    std::vector<int> first(sorted.size()), group;
    std::iota(first.begin(), first.end(), 0);
    const BlockSearch search(sorted);
    for (const int i : crowded)
    {
        if (first[i] != i || search.has_within(sorted[i], alone_within * spot, most + 1))
            continue;
        search.within(sorted[i], spot, group);
        if (!search.has_within(sorted[i], alone_within * spot, int(group.size()) + 1))
            for (const int member : group)
                first[member] = group.front();
    }
    return first;
}

} // namespace

SpatialOrder order_spatially(const Points& points, int threads)
{
    Entries entries(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        entries[i] = {0, int(i)};
    if (!entries.empty())
        sort_along_curve(points, entries.begin(), entries.end(), threads);
    SpatialOrder result;
    result.order.reserve(points.size());
    result.representative.resize(points.size());
    for (const Entry& entry : entries)
    {
        if (result.order.empty() || points[result.order.back()] != points[entry.index])
            result.order.push_back(entry.index);
        result.representative[entry.index] = int(result.order.size()) - 1;
    }
    return result;
}

SpatialOrder order_input(const Points& points, int threads)
{
    SpatialOrder result = order_spatially(points, threads);
    const Points sorted = points_at(result.order, points);
    const double diagonal = sorted.empty() ? 0 : bounding_box(sorted).diagonal(), spot = spot_size * diagonal;
    std::vector<int> first;
    if (const double twins = find_twin_spot(sorted, diagonal); twins > spot)
    {
        std::vector<int> all(sorted.size());
        std::iota(all.begin(), all.end(), 0);
        first = find_spots(sorted, all, twins, twins_alone_within, most_twins);
    }
    else
    {
        const std::vector<int> crowded = list_crowded(sorted, spot);
        if (crowded.empty())
            return result;
        first = find_spots(sorted, crowded, spot, alone_within, std::min(most_in_spot, int(sorted.size()) / 20));
    }
    std::vector<int> kept, place(sorted.size());
    for (int i = 0; i < int(sorted.size()); ++i)
    {
        if (first[i] == i)
            kept.push_back(result.order[i]);
        place[i] = first[i] == i ? int(kept.size()) - 1 : place[first[i]];
    }
    result.order = std::move(kept);
    for (int& representative : result.representative)
        representative = place[representative];
    return result;
}

std::vector<int> order_without(const std::vector<int>& left_out, const std::vector<int>& order, const Points& points)
{
    std::vector<int> kept, result;
    for (const int i : list_others(order.size(), left_out))
        kept.push_back(order[i]);
    for (const int i : order_input(points_at(kept, points)).order)
        result.push_back(kept[i]);
    return result;
}

} // namespace recon
