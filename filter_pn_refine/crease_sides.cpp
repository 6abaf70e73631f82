#include "crease_sides.h"

#include <cmath>

namespace recon::pn
{
namespace
{

int side_of_face(const UsableSamples& usable, int sample, int other)
{
    constexpr double same_face = 0.7; // normals that agree more
    constexpr double least = 0.25;    // sine of the angle to the plane of the other
    constexpr int asked = 3;          // nearest samples of the face
    const auto i = std::size_t(sample);
    const Vector &own = usable.samples.normals[i], &across = usable.samples.normals[std::size_t(other)];
    int sum = 0, found = 0;
    for (int m = 0; m < usable.nearest.count && found < asked; ++m)
    {
        const auto j = std::size_t(usable.nearest.of(i)[m]);
        const Vector& normal = usable.samples.normals[j];
        const Vector d = usable.samples.points[j] - usable.samples.points[i];
        const double height = d.dot(across);
        if (usable.is_crease[j] || normal.dot(own) < same_face || normal.dot(own) <= normal.dot(across) ||
            std::abs(height) < least * d.norm())
            continue;
        sum += height > 0 ? 1 : -1;
        ++found;
    }
    return (sum > 0) - (sum < 0);
}

} // namespace

std::vector<int> sides_of_faces(const UsableSamples& usable)
{
    const std::size_t n = usable.input.size();
    std::vector<int> sharers(n, 0), last(n, -1), first(n, -1), sides(n, 0);
    for (std::size_t i = 0; i < n; ++i)
        if (usable.is_crease[i])
        {
            const auto position = std::size_t(usable.sharing[i]);
            ++sharers[position];
            last[position] = int(i);
            if (first[position] < 0)
                first[position] = int(i);
        }
    for (std::size_t position = 0; position < n; ++position)
        if (sharers[position] == 2)
        {
            const int a = first[position], b = last[position];
            sides[std::size_t(a)] = side_of_face(usable, a, b);
            sides[std::size_t(b)] = side_of_face(usable, b, a);
        }
    return sides;
}

} // namespace recon::pn
