#include "sample_surface.h"

#include "filter_pn_refine/patch/hermite_surface.h"

namespace recon::pn
{
namespace
{

constexpr double flat = 0.98;     ///< Of normals that agree so far a PN triangle is as good as anything.
constexpr int fitted = 10;        ///< Samples that the surface interpolates: 12 gain 1 % and cost a half more.
constexpr int around = 40;        ///< Among so many nearest,
constexpr double same_side = 0.3; ///< those whose normals agree so far with that of the triangle.
constexpr double least_move = 0.01, largest_move = 0.5; ///< Nothing is moved less or farther [spacings].

bool is_flat(const CornerNormals& normals)
{
    return normals[0]->dot(*normals[1]) >= flat && normals[1]->dot(*normals[2]) >= flat &&
           normals[2]->dot(*normals[0]) >= flat;
}

} // namespace

void move_onto_sample_surface(const UsableSamples& usable, double slack, const CornerNormals& normals, WorkPoint& made)
{
    if (is_flat(normals))
        return;
    int nearest[around], chosen[fitted], count = 0;
    double squared[around];
    double reach = likely_reach(double(made.spacing), around);
    const int found = usable.search->nearest(made.position, around, nearest, squared, reach);
    for (int m = 0; m < found && count < fitted; ++m)
    {
        const auto j = std::size_t(nearest[m]);
        if (usable.is_crease[j])
            return;
        if (usable.samples.normals[j].dot(made.normal) > same_side)
            chosen[count++] = nearest[m];
    }
    if (count < fitted)
        return;
    const HermiteSurface surface(usable.samples, chosen, count, made.position, double(made.spacing), slack);
    Point p = made.position;
    const Vector gradient = surface.project(p);
    const double slope = gradient.norm(); // 1 at the samples
    // Where the two agree the triangle is kept: it is exact on spheres, the surface is not.
    const double move = (p - made.position).norm() / double(made.spacing);
    if (slope > 0.2 && slope < 5 && move > least_move && move < largest_move)
    {
        made.position = p;
        made.normal = gradient / slope;
    }
}

} // namespace recon::pn
