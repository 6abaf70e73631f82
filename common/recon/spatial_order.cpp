#include <recon/spatial_order.h>

#include <algorithm>
#include <cstdint>

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
    std::sort(entries.begin(), entries.end(),
              [&](const Entry& a, const Entry& b)
              {
                  if (a.key != b.key)
                      return a.key < b.key;
                  const Point &p = points[a.index], &q = points[b.index];
                  for (int k = 0; k < 3; ++k)
                      if (p[k] != q[k])
                          return p[k] < q[k];
                  return a.index < b.index;
              });
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
