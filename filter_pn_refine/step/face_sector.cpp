#include "face_sector.h"

#include "level.h"

#include <algorithm>
#include <cmath>

namespace recon::pn
{
namespace
{

FaceDirection across(const FaceDirection& own, const FaceDirection& other, bool is_above)
{
    const float c = own[0] * other[0] + own[1] * other[1] + own[2] * other[2],
                scale = (is_above ? 1.f : -1.f) / std::sqrt(std::max(1 - c * c, 1e-12f));
    return {(other[0] - c * own[0]) * scale, (other[1] - c * own[1]) * scale, (other[2] - c * own[2]) * scale};
}

} // namespace

bool FaceSector::leads_behind(float x, float y, float z) const
{
    constexpr float steep = 0.5f; // sine of the angle to the edge
    const float squared = x * x + y * y + z * z;
    const auto is_behind = [&](const FaceDirection& d)
    {
        const float along = d[0] * x + d[1] * y + d[2] * z;
        return along < 0 && along * along > steep * steep * squared;
    };
    return is_reflex ? is_behind(first) && is_behind(second) : is_behind(first) || is_behind(second);
}

FaceSector face_sector(std::uint32_t flags, const FaceDirection& normal, std::vector<FaceDirection> others)
{
    FaceSector face;
    if (flags & WorkPoint::sector && others.size() == 2)
    {
        std::sort(others.begin(), others.end());
        face = {across(normal, others[0], (flags & WorkPoint::above_first) != 0),
                across(normal, others[1], (flags & WorkPoint::above_second) != 0), (flags & WorkPoint::reflex) != 0};
    }
    else if (flags & (WorkPoint::above | WorkPoint::below) && others.size() == 1)
        face.first = across(normal, others[0], (flags & WorkPoint::above) != 0);
    return face;
}

} // namespace recon::pn
