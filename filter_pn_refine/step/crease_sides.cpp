#include "crease_sides.h"

#include "level.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <utility>

namespace recon::pn
{
namespace
{

class SideFinder
{
public:
    explicit SideFinder(const UsableSamples& usable)
        : usable_(usable), points_(usable.samples.points), normals_(usable.samples.normals),
          next_(next_at_position(usable)), votes_(points_.size(), 0)
    {
    }

    std::vector<std::uint32_t> find()
    {
        std::vector<std::uint32_t> flags(points_.size(), 0);
        for (std::size_t i = 0; i < flags.size(); ++i)
            if (faces_at(i) == 2)
                votes_[i] = vote(i);
        for (std::size_t i = 0; i < flags.size(); ++i)
            if (const int n = faces_at(i); n == 2)
            {
                const int sum = votes_along(i);
                flags[i] = sum > 0 ? WorkPoint::above : sum < 0 ? WorkPoint::below : 0u;
            }
            else if (n == 3)
                flags[i] = sector(i);
        return flags;
    }

private:
    int faces_at(std::size_t i) const
    {
        int n = 1;
        for (int t = next_[i]; t != int(i); t = next_[std::size_t(t)])
            ++n;
        return n;
    }

    /// How many more of the nearest samples of an edge point's face lie above the plane of the other than below.
    int vote(std::size_t i) const
    {
        constexpr int asked = 3;       // nearest samples of the face
        constexpr double least = 0.25; // sine of the angle to the plane of the other
        const Vector& across = normals_[std::size_t(next_[i])];
        int sum = 0, found = 0;
        for (int m = 0; m < usable_.nearest.count && found < asked; ++m)
        {
            const int j = usable_.nearest.of(i)[m];
            const Vector d = points_[std::size_t(j)] - points_[i];
            const double height = d.dot(across);
            if (!is_of_face(j, normals_[i], {across}) || std::abs(height) < least * d.norm())
                continue;
            sum += height > 0 ? 1 : -1;
            ++found;
        }
        return sum;
    }

    /// The votes at points on this edge together: at a void a face's nearest samples may be those around a corner.
    int votes_along(std::size_t i) const
    {
        const Vector& across = normals_[std::size_t(next_[i])];
        int sum = votes_[i];
        for (int m = 0; m < usable_.nearest.count; ++m)
        {
            const int j = usable_.nearest.of(i)[m];
            if (lies_along(j, points_[std::size_t(j)] - points_[i], normals_[i], across))
                sum += votes_[std::size_t(j)];
        }
        return sum;
    }

    /// Flags of a corner of three faces.
    std::uint32_t sector(std::size_t i) const
    {
        constexpr int looked_at = 64, asked = 5; // the latter of the face
        constexpr double in_plane = 0.3;         // sine
        const Vector &own = normals_[i], *first = &normals_[std::size_t(next_[i])],
                     *second = &normals_[std::size_t(next_[std::size_t(next_[i])])];
        if (as_floats(*second) < as_floats(*first))
            std::swap(first, second);
        std::array<int, looked_at> near{};
        std::array<double, looked_at> squared{};
        double reach = 0;
        const int count = usable_.search->nearest(points_[i], std::min(looked_at, int(points_.size())), near.data(),
                                                  squared.data(), reach);
        // Edges show the sector of less than half a turn between them, samples whether the face is that or the rest.
        const auto side_of_edge = [&](const Vector& with, const Vector& third)
        {
            for (int m = 0; m < count; ++m)
            {
                const int j = near[std::size_t(m)];
                const Vector d = points_[std::size_t(j)] - points_[i];
                if (lies_along(j, d, own, with))
                    return d.dot(third) > 0 ? 1 : -1;
            }
            return 0;
        };
        const int first_side = side_of_edge(*second, *first), second_side = side_of_edge(*first, *second);
        if (first_side == 0 || second_side == 0)
            return 0;
        int sum = 0, found = 0;
        for (int m = 0; m < count && found < asked; ++m)
        {
            const int j = near[std::size_t(m)];
            const Vector d = points_[std::size_t(j)] - points_[i];
            if (!is_of_face(j, own, {*first, *second}) || std::abs(d.dot(own)) > in_plane * d.norm())
                continue;
            sum += d.dot(*first) * first_side > 0 && d.dot(*second) * second_side > 0 ? 1 : -1;
            ++found;
        }
        if (sum == 0)
            return 0;
        const bool is_reflex = sum < 0;
        return WorkPoint::sector | (is_reflex ? WorkPoint::reflex : 0u) |
               ((first_side > 0) != is_reflex ? WorkPoint::above_first : 0u) |
               ((second_side > 0) != is_reflex ? WorkPoint::above_second : 0u);
    }

    /// Whether sample j lies on the face with this normal, not on one of the others, nor on an edge.
    bool is_of_face(int j, const Vector& own, std::initializer_list<Vector> others) const
    {
        constexpr double same_face = 0.7; // normals that agree more
        const Vector& normal = normals_[std::size_t(j)];
        const double agreement = normal.dot(own);
        return !usable_.is_crease[std::size_t(j)] && agreement >= same_face &&
               std::all_of(others.begin(), others.end(), [&](const Vector& o) { return agreement > normal.dot(o); });
    }

    /// Whether crease sample j, d away, lies on the edge of faces with these normals.
    bool lies_along(int j, const Vector& d, const Vector& a, const Vector& b) const
    {
        constexpr double along = 0.9, same_face = 0.9; // cosines
        const Vector line = a.cross(b);
        if (!usable_.is_crease[std::size_t(j)] || normals_[std::size_t(j)].dot(a) < same_face || d.isZero(0) ||
            !(std::abs(d.dot(line)) > along * d.norm() * line.norm())) // nor where the normals are opposite
            return false;
        for (int t = next_[std::size_t(j)]; t != j; t = next_[std::size_t(t)])
            if (normals_[std::size_t(t)].dot(b) > same_face)
                return true;
        return false;
    }

    const UsableSamples& usable_;
    const Points& points_;
    const Vectors& normals_;
    const std::vector<int> next_;
    std::vector<int> votes_; ///< Per edge point: vote().
};

} // namespace

std::vector<std::uint32_t> sides_of_faces(const UsableSamples& usable)
{
    return SideFinder(usable).find();
}

std::vector<FaceSector> sectors_of_faces(const UsableSamples& usable, const std::vector<std::uint32_t>& sides)
{
    const std::vector<int> next = next_at_position(usable);
    const auto normal = [&](int i) { return as_floats(usable.samples.normals[std::size_t(i)]); };
    std::vector<FaceSector> sectors(sides.size());
    std::vector<FaceDirection> others;
    for (std::size_t i = 0; i < sides.size(); ++i)
    {
        if (!sides[i])
            continue;
        others.clear();
        for (int t = next[i]; t != int(i); t = next[std::size_t(t)])
            others.push_back(normal(t));
        sectors[i] = face_sector(sides[i], normal(int(i)), others);
    }
    return sectors;
}

} // namespace recon::pn
