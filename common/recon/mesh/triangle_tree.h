#pragma once

#include <recon/geometry.h>

#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace recon
{

/// Squared distance [length^2] from p to the segment from a to b, which may be a point.
double squared_distance(const Point& p, const Point& a, const Point& b);

/// The place on the triangle a, b, c nearest to p. The triangle may be a segment or a point.
Point nearest_place(const Point& p, const Point& a, const Point& b, const Point& c);

/// Squared distance [length^2] from p to it.
double squared_distance(const Point& p, const Point& a, const Point& b, const Point& c);

/// A tree of boxes around triangles, made for few questions to many triangles. Any number of threads may ask.
class TriangleTree
{
public:
    using Triangles = std::vector<std::array<int, 3>>;

    /// \param triangles indices of vertices; fastest if neighbours in the list lie side by side, as those of a crust
    /// do. \pre Both outlive the tree.
    TriangleTree(const Points& vertices, const Triangles& triangles);
    ~TriangleTree();

    /// Squared distance [length^2] from p to the nearest triangle; infinite if there is none.
    double squared_distance_from(const Point& p) const;

    struct Nearest
    {
        int triangle;
        Point place; ///< On it.
    };
    /// The nearest triangle. \pre There is one.
    Nearest nearest(const Point& p) const;

    /// Calls visit(triangle) for those whose boxes meet this one, in any order.
    void visit_near(const Box& box, const std::function<void(int)>& visit) const;

private:
    struct Boxes;
    std::unique_ptr<const Boxes> boxes_;
};

} // namespace recon
