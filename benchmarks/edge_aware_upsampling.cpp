#include "pn_models.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/edge_aware_upsample_point_set.h>
#include <CGAL/property_map.h>

#include <iterator>

namespace benchmarks
{

EdgeAwareUpsampling upsample_edge_aware(const recon::OrientedSamples& input, int count)
{
    using Kernel = CGAL::Simple_cartesian<double>;
    using PointWithNormal = std::pair<Kernel::Point_3, Kernel::Vector_3>;
    std::vector<PointWithNormal> points;
    for (std::size_t i = 0; i < input.points.size(); ++i)
    {
        const recon::Point& p = input.points[i];
        const recon::Vector& n = input.normals[i];
        points.emplace_back(Kernel::Point_3(p.x(), p.y(), p.z()), Kernel::Vector_3(n.x(), n.y(), n.z()));
    }
    std::vector<PointWithNormal> appended;
    const double start = cpu_seconds();
    CGAL::edge_aware_upsample_point_set<CGAL::Sequential_tag>(
        points, std::back_inserter(appended),
        CGAL::parameters::point_map(CGAL::First_of_pair_property_map<PointWithNormal>())
            .normal_map(CGAL::Second_of_pair_property_map<PointWithNormal>())
            .edge_sensitivity(0)
            .number_of_output_points(std::size_t(count)));
    EdgeAwareUpsampling result;
    result.cpu_seconds = cpu_seconds() - start;
    for (const PointWithNormal& p : appended)
    {
        result.appended.points.emplace_back(p.first.x(), p.first.y(), p.first.z());
        result.appended.normals.emplace_back(p.second.x(), p.second.y(), p.second.z());
    }
    return result;
}

} // namespace benchmarks
