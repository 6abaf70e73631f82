#include <recon/triangulation/power_predicates.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace recon
{
namespace
{

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 point(const Site& s)
{
    return {s.x, s.y, s.z};
}

Kernel::Weighted_point_3 weighted(const Site& s)
{
    return {point(s), s.weight};
}

} // namespace

int find_orientation_exactly(const Site& a, const Site& b, const Site& c, const Site& d)
{
    return int(Kernel().orientation_3_object()(point(a), point(b), point(c), point(d)));
}

int find_power_side_exactly(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e)
{
    return int(Kernel().power_side_of_oriented_power_sphere_3_object()(weighted(a), weighted(b), weighted(c),
                                                                       weighted(d), weighted(e)));
}

} // namespace recon
