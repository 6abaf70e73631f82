#include <recon/bare_faces/way_out.h>

#include <recon/bare_faces/noisy_planes.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace recon
{
namespace
{

/// By how much of the area one side must be more open than the other.
constexpr double clearly_open = 0.5;
/// Cosine below which a line passes along a face.
constexpr double grazing = 0.1;

} // namespace

int WayOut::find(const FlatFace& face, double beside) const
{
    const Share front = measure(face, face.normal, beside), back = measure(face, -face.normal, beside);
    if (front.free + back.stopped > 1 + clearly_open)
        return 1;
    return back.free + front.stopped > 1 + clearly_open ? -1 : 0;
}

WayOut::Share WayOut::measure(const FlatFace& face, const Vector& up, double beside) const
{
    Share result;
    double whole = 0;
    for (const auto& t : face.triangles)
    {
        const Point &a = all_.rims[t[0]], &b = all_.rims[t[1]], &c = all_.rims[t[2]];
        const double area = (b - a).cross(c - a).norm();
        const Point from = (a + b + c) / 3;
        whole += area;
        if (meets_samples(from, up, beside) || meets(sure_, from, up))
            result.stopped += area;
        else if (!meets(all_.faces, from, up))
            result.free += area;
    }
    if (whole > 0)
    {
        result.free /= whole;
        result.stopped /= whole;
    }
    return result;
}

bool WayOut::meets(const std::vector<FlatFace>& faces, const Point& from, const Vector& up) const
{
    return std::any_of(faces.begin(), faces.end(),
                       [&](const FlatFace& face)
                       {
                           const double along = up.dot(face.normal);
                           if (std::abs(along) < grazing)
                               return false;
                           const double distance = (face.origin - from).dot(face.normal) / along;
                           // Nearer ones are the same face, found once more.
                           if (distance < beside_slab * noise_)
                               return false;
                           const Point hit = from + distance * up;
                           return std::any_of(face.triangles.begin(), face.triangles.end(),
                                              [&](const std::array<int, 3>& t)
                                              {
                                                  bool is_left = false, is_right = false;
                                                  for (int i = 0; i < 3; ++i)
                                                  {
                                                      const Point &a = all_.rims[t[i]], &b = all_.rims[t[(i + 1) % 3]];
                                                      const double side = (b - a).cross(hit - a).dot(face.normal);
                                                      is_left |= side > 0;
                                                      is_right |= side < 0;
                                                  }
                                                  return !(is_left && is_right);
                                              });
                       });
}

bool WayOut::meets_samples(const Point& from, const Vector& up, double beside) const
{
    return std::any_of(samples_.begin(), samples_.end(),
                       [&](const Point& p)
                       {
                           const Vector offset = p - from;
                           const double height = offset.dot(up);
                           return height > beside && offset.squaredNorm() - height * height < beside * beside;
                       });
}

} // namespace recon
