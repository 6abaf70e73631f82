#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace recon
{

using Point = Eigen::Vector3d;
using Vector = Eigen::Vector3d;
using Points = std::vector<Point>;
using Vectors = std::vector<Vector>;

/// Points with outward unit normals, one each.
struct OrientedSamples
{
    Points points;
    Vectors normals;
};

/// Triangles counter-clockwise seen from outside.
struct TriangleMesh
{
    Points vertices;
    std::vector<std::array<int, 3>> triangles;
    /// Per triangle, bit e set: its edge from corner e to corner (e + 1) % 3 is a diagonal inside a polygon. Empty:
    /// none.
    std::vector<std::uint8_t> faux_edges;
};

/// Axis-aligned bounding box. Empty for no points: minimum > maximum.
struct Box
{
    Point minimum = Point::Constant(std::numeric_limits<double>::max());
    Point maximum = Point::Constant(std::numeric_limits<double>::lowest());

    Point centre() const { return 0.5 * minimum + 0.5 * maximum; }
    double diagonal() const;
};

/// Larger coordinates have differences that are not finite.
constexpr double largest_coordinate = 1e300;
/// \throws InvalidInput that names `vertex` if the point has a coordinate that is not finite, or larger than that.
void check_finite(const Point& point, std::size_t vertex);

/// The points of those indices.
Points points_at(const std::vector<int>& indices, const Points& points);

/// The numbers below `count` but those in `left_out`, which ascend.
std::vector<int> list_others(std::size_t count, const std::vector<int>& left_out);

Box bounding_box(const Points& points);

/// The frame in which all algorithms compute: centred, box diagonal 1. Coordinates like UTM's or of 1e-30 lose nothing
/// there that the input had.
class UnitFrame
{
public:
    /// \throws InvalidInput for no points or as check_finite() does.
    explicit UnitFrame(const Points& points);

    double scale() const { return scale_; } ///< Length of one unit [input units]; 1 if all points are equal.
    Point to_unit(const Point& p) const { return (p - centre_) / scale_; }
    Point from_unit(const Point& p) const { return p * scale_ + centre_; }
    Points to_unit(const Points& points) const;
    void from_unit_in_place(Points& points) const;

private:
    Point centre_;
    double scale_;
};

/// Checks what every volumetric method needs: at least 4 distinct finite points that do not lie in one plane.
/// \throws InvalidInput naming the cause (too few, not finite, one too far from all others, all equal, collinear,
/// coplanar) and the remedy.
void check_spans_volume(const Points& points);

} // namespace recon
