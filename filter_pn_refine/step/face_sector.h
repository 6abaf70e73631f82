#pragma once

#include <recon/geometry.h>

#include <array>
#include <cstdint>
#include <vector>

namespace recon::pn
{

/// From an edge into the face of a crease point, in its tangent plane, of unit length.
using FaceDirection = std::array<float, 3>;

inline FaceDirection as_floats(const Vector& v)
{
    return {float(v.x()), float(v.y()), float(v.z())};
}

/// Where the face of a point of an edge or corner lies: on the positive side of `first`; at a corner of `second` as
/// well, or of either if it is reflex. 0 where that is not known.
struct FaceSector
{
    FaceDirection first{}, second{};
    bool is_reflex = false;

    bool is_known() const { return first != FaceDirection{}; }
    /// Whether d leads away from the face beyond its edges. Along an edge it may, since edges are curved.
    bool leads_behind(float x, float y, float z) const;
};

/// \param flags of the point (WorkPoint::Flag). \param others normals of the others at its position, in any order.
FaceSector face_sector(std::uint32_t flags, const FaceDirection& normal, std::vector<FaceDirection> others);

} // namespace recon::pn
