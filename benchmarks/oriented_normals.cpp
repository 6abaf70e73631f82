#include "oriented_normals.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/mst_orient_normals.h>
#include <CGAL/pca_estimate_normals.h>
#include <CGAL/property_map.h>

#include <tuple>
#include <vector>

namespace benchmarks
{

recon::Vectors pca30_spanning_tree_normals(const recon::Points& points)
{
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Oriented = std::tuple<Kernel::Point_3, Kernel::Vector_3, int>;
    std::vector<Oriented> copy;
    for (std::size_t i = 0; i < points.size(); ++i)
        copy.emplace_back(Kernel::Point_3(points[i].x(), points[i].y(), points[i].z()), Kernel::Vector_3(0, 0, 0),
                          int(i));
    const auto parameters = CGAL::parameters::point_map(CGAL::Nth_of_tuple_property_map<0, Oriented>())
                                .normal_map(CGAL::Nth_of_tuple_property_map<1, Oriented>());
    CGAL::pca_estimate_normals<CGAL::Sequential_tag>(copy, 30, parameters);
    CGAL::mst_orient_normals(copy, 30, parameters); // puts those it cannot orient last; they keep some direction
    recon::Vectors normals(points.size());
    for (const Oriented& p : copy)
        normals[std::get<2>(p)] = recon::Vector(std::get<1>(p).x(), std::get<1>(p).y(), std::get<1>(p).z());
    return normals;
}

} // namespace benchmarks
