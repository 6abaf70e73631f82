#include <recon/level_sheet.h>

#include <algorithm>

namespace recon
{

bool is_upside_down(const Points& points, const Vectors& normals)
{
    constexpr double most_height = 0.25; // of the length and the width
    constexpr double least_rise = 0.6;   // of the normals' mean: a dome has .5
    const Box box = bounding_box(points);
    const Vector extent = box.maximum - box.minimum;
    if (extent.z() > most_height * std::min(extent.x(), extent.y()))
        return false;
    double rise = 0, area = 0;
    for (const Vector& n : normals)
    {
        rise += n.z();
        area += n.norm();
    }
    return rise < -least_rise * area;
}

} // namespace recon
