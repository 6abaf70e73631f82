#include <recon/spatial_order.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace recon
{
namespace
{

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

/// Stable, by the key: digit by digit from the lowest, in a third of std::sort's time.
void sort_by_key(std::vector<Entry>& entries)
{
    constexpr int digit_bits = 11, key_bits = 63;
    std::vector<Entry> sorted(entries.size());
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
}

} // namespace

SpatialOrder order_spatially(const Points& points)
{
    const Box box = bounding_box(points);
    const double diagonal = box.diagonal();
    const double cells = diagonal > 0 ? 2097151 / diagonal : 0;
    std::vector<Entry> entries(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const Vector v = (points[i] - box.minimum) * cells;
        entries[i] = {spread_bits(std::uint64_t(v.x())) | spread_bits(std::uint64_t(v.y())) << 1 |
                          spread_bits(std::uint64_t(v.z())) << 2,
                      int(i)};
    }
    const auto by_key = [](const Entry& a, const Entry& b) { return a.key < b.key; };
    if (!std::is_sorted(entries.begin(), entries.end(), by_key))
        sort_by_key(entries);
    // Points of one cell of the curve: few, unless many coincide.
    for (auto begin = entries.begin(); begin != entries.end();)
    {
        auto end = begin + 1;
        while (end != entries.end() && end->key == begin->key)
            ++end;
        if (end - begin > 1)
            std::sort(begin, end,
                      [&](const Entry& a, const Entry& b)
                      {
                          const Point &p = points[a.index], &q = points[b.index];
                          for (int k = 0; k < 3; ++k)
                              if (p[k] != q[k])
                                  return p[k] < q[k];
                          return a.index < b.index;
                      });
        begin = end;
    }
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

} // namespace recon
