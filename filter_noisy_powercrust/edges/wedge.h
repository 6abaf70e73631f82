#pragma once

#include "filter_amls/fits/weighted_sums.h"

#include <recon/geometry.h>
#include <recon/search/block_search.h>

#include <array>
#include <optional>
#include <vector>

namespace recon
{

/// A quadric over a tangent frame. \see QuadricFit
struct Sheet
{
    Point origin = Point::Zero();
    TangentFrame frame{Vector::UnitZ()};
    double width = 1;          ///< Unit of the places over the frame [length].
    std::array<double, 6> c{}; ///< Of the heights over it, as in QuadricFit.

    double distance(const Point& p) const; ///< Signed, to first order [length].
    Vector normal(const Point& p) const;   ///< Unit length, of the sheet below or above p.

private:
    struct Foot
    {
        double height, slope_u, slope_v; ///< Of p over the sheet [length], of the sheet there.
    };
    Foot foot_of(const Point& p) const;
};

/// Two sheets that end where they meet: a sharp edge.
struct Wedge
{
    std::array<Sheet, 2> sheets;
    double side = 1; ///< 1 where the edge is convex, -1 where it is concave.

    /// The sheet that bounds the solid there, 0 or 1.
    int facing(const Point& p) const;
    double distance(const Point& p) const; ///< Signed, to first order.
    Point project(Point p) const;
};

/// A rounded surface and the noisy points that it was made from, in the same units.
struct RoundedSurface
{
    explicit RoundedSurface(const Points& noisy) : points(noisy) {}

    Points vertices; ///< In spatial order.
    Vectors normals; ///< Of the vertices, outward, unit length.
    /// Twice the mesh's edges around each vertex, about an AMLS width [length]: "reaches" below are relative to it.
    std::vector<double> reach;
    BlockSearch vertex_search;

    const Points& points; ///< In spatial order.
    /// Per point: the nearest vertex and how high the point lies over the plane there [length].
    std::vector<int> nearest;
    std::vector<double> height;
    BlockSearch point_search;
};

/// Whether what has these unit normals is two sides of a wall, not of an edge.
bool is_other_sheet(const Vector& a, const Vector& b);

/// A wedge and how much better than one quadric it explains the points: squared residuals saved per point, less the
/// price of the coefficients [noise^2].
struct JudgedWedge
{
    Wedge wedge;
    double gain;      ///< Near the vertex.
    double wide_gain; ///< Farther around, where a bend shows that noise hides nearby.
};

/// Fits wedges around vertices, one after the other.
class WedgeFitter
{
public:
    /// \param surface outlives this object.
    explicit WedgeFitter(const RoundedSurface& surface) : surface_(surface) {}

    /// The best of the wedges fitted to the points in windows of several widths, with flat and with curved sheets;
    /// none where there are too few points or the normals around are not of two faces.
    std::optional<JudgedWedge> fit(int vertex);

private:
    struct Window
    {
        bool is_flat;
        double radius; ///< [reaches]
    };

    bool prepare(int vertex);
    std::optional<Wedge> fit_in(const Window& window);
    bool find_faces(const Window& window, Wedge& wedge);
    bool group_normals(std::array<Vector, 2>& mean);
    bool fit_sheet(const Points& points, const std::vector<int>& indices, bool is_flat, bool robust, Sheet& sheet);
    double misfit_of_one_sheet();
    template <class Model>
    double misfit(const Model& model, int coefficients, std::size_t fitted) const;
    void collect_points(double radius, std::vector<int>& indices);
    void measure_noise();

    const RoundedSurface& surface_;
    int vertex_ = 0;
    double collected_ = 0;                     ///< How far points were collected [reaches].
    std::vector<int> collected_points_;        ///< Those of the vertex's own sheet.
    double sigma_ = 0;                         ///< Noise around the vertex [length].
    std::vector<int> around_;                  ///< Vertices.
    std::vector<int> judged_, fitted_;         ///< Points.
    std::array<std::vector<int>, 2> of_sheet_; ///< Vertices or points.
    std::vector<double> heights_;
    Gathered gathered_;
};

} // namespace recon
