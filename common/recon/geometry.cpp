#include <recon/geometry.h>

#include <recon/errors.h>
#include <recon/median.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

namespace recon
{

double Box::diagonal() const
{
    // Through the largest side, so that 1e200 does not overflow and 1e-200 does not vanish.
    const Vector sides = maximum - minimum;
    const double largest = sides.maxCoeff();
    if (!(largest > 0))
        return 0;
    return largest * (sides / largest).norm();
}

Points points_at(const std::vector<int>& indices, const Points& points)
{
    Points result;
    result.reserve(indices.size());
    for (const int i : indices)
        result.push_back(points[i]);
    return result;
}

std::vector<int> list_others(std::size_t count, const std::vector<int>& left_out)
{
    std::vector<int> result;
    result.reserve(count - left_out.size());
    auto next = left_out.begin();
    for (int i = 0; i < int(count); ++i)
        if (next != left_out.end() && *next == i)
            ++next;
        else
            result.push_back(i);
    return result;
}

Box bounding_box(const Points& points)
{
    Box box;
    for (const Point& p : points)
    {
        box.minimum = box.minimum.cwiseMin(p);
        box.maximum = box.maximum.cwiseMax(p);
    }
    return box;
}

void check_finite(const Point& point, std::size_t vertex)
{
    if (!point.allFinite())
        throw InvalidInput("Vertex " + std::to_string(vertex) +
                           " has a coordinate that is not a finite number. Delete such vertices first.");
    if (point.lpNorm<Eigen::Infinity>() > largest_coordinate)
        throw InvalidInput("Vertex " + std::to_string(vertex) +
                           " has a coordinate above 1e300. Delete such vertices, or scale the layer down.");
}

UnitFrame::UnitFrame(const Points& points)
{
    if (points.empty())
        throw InvalidInput("There are no points. Load or select a point cloud first.");
    for (std::size_t i = 0; i < points.size(); ++i)
        check_finite(points[i], i);
    const Box box = bounding_box(points);
    centre_ = box.centre();
    scale_ = box.diagonal();
    if (!(scale_ > 0))
        scale_ = 1;
}

Points UnitFrame::to_unit(const Points& points) const
{
    Points result;
    result.reserve(points.size());
    for (const Point& p : points)
        result.push_back(to_unit(p));
    return result;
}

void UnitFrame::from_unit_in_place(Points& points) const
{
    for (Point& p : points)
        p = from_unit(p);
}

namespace
{

/// Of extents, relative to the largest: the eigenvalues of a double covariance are right to about 1e-16 of the largest,
/// their roots to 1e-8.
constexpr double nothing = 1e-7;
constexpr double nearly_all = 0.9;

/// \throws InvalidInput if a point lies so far from nearly all others that these are one place beside it.
void check_far_points(const Points& points)
{
    std::vector<double> coordinates[3];
    for (const Point& p : points)
        for (int k = 0; k < 3; ++k)
            coordinates[k].push_back(p[k]);
    const Point middle(median(coordinates[0]), median(coordinates[1]), median(coordinates[2]));
    const auto distance = [&](const Point& p) { return (p - middle).lpNorm<Eigen::Infinity>(); };
    const Point& farthest = *std::max_element(
        points.begin(), points.end(), [&](const Point& a, const Point& b) { return distance(a) < distance(b); });
    const double one_place = nothing * distance(farthest);
    const auto near =
        std::count_if(points.begin(), points.end(), [&](const Point& p) { return distance(p) <= one_place; });
    if (double(near) < nearly_all * double(points.size()))
        return;
    std::ostringstream text;
    text << "The point at (" << farthest.transpose().format(Eigen::IOFormat(6, Eigen::DontAlignCols, ", "))
         << ") lies so far from the others that these are one place beside it. Delete it, and others like it.";
    throw InvalidInput(text.str());
}

} // namespace

void check_spans_volume(const Points& points)
{
    if (points.size() < 4)
        throw InvalidInput("Too few points (" + std::to_string(points.size()) +
                           "): at least 4 that do not lie in one plane are needed. Load or select more points.");
    const UnitFrame frame(points);
    Vector mean = Vector::Zero();
    for (const Point& p : points)
        mean += frame.to_unit(p);
    mean /= double(points.size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const Point& p : points)
    {
        const Vector d = frame.to_unit(p) - mean;
        covariance += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    const Vector extent = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
    if (extent[2] <= 1e-12)
        throw InvalidInput("All points are equal. A surface needs points that spread in three dimensions.");
    if (extent[0] <= nothing * extent[2])
        check_far_points(points);
    if (extent[1] <= nothing * extent[2])
        throw InvalidInput("All points lie on one line. A surface needs points that spread in three dimensions.");
    if (extent[0] <= nothing * extent[2])
        throw InvalidInput("All points lie in one plane. A closed surface needs points that spread in three "
                           "dimensions; for a flat set use a two-dimensional triangulation.");
}

} // namespace recon
