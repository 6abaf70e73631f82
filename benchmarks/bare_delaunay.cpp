#include "bare_delaunay.h"

#include "models.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace benchmarks
{

double time_bare_delaunay(const recon::Points& points)
{
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    std::vector<Kernel::Point_3> copy;
    copy.reserve(points.size());
    for (const recon::Point& p : points)
        copy.emplace_back(p.x(), p.y(), p.z());
    const double begin = cpu_seconds();
    const CGAL::Delaunay_triangulation_3<Kernel> delaunay(copy.begin(), copy.end());
    return cpu_seconds() - begin;
}

} // namespace benchmarks
