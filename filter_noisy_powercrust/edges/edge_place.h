#pragma once

#include "filter_amls/fits/weighted_sums.h"

#include <recon/geometry.h>
#include <recon/search/block_search.h>

#include <array>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace recon
{

/// A ball of the medial axis. Lengths in one unit.
struct AxisBall
{
    Point centre;
    double radius;
    double scale;   ///< Local spacing of the samples.
    Points touched; ///< Samples on its sphere.
};

/// Where a sheet of the medial axis ends: the place of a sharp edge that lies below a ball.
struct EdgePlace
{
    Point place;
    Vector along;                  ///< Direction of the edge, unit length.
    std::array<Vector, 2> normals; ///< Of the faces, away from the ball.
    double depth;                  ///< Of the ball's centre below the edge [length].
};

/// The sharp edge of the two faces that a ball touches. Planes are fitted to the points around, beginning with those
/// that touch the ball; where they meet is an edge if hardly a point lies off them, and if they explain the points
/// better than round edges of one spacing and more, and than one quadric.
class EdgePlaceFinder
{
public:
    /// Keeps references. \param points in spatial order. \param noise standard deviation [length], >= 0.
    EdgePlaceFinder(const Points& points, const BlockSearch& search, double noise)
        : points_(points), search_(search), noise_(noise)
    {
    }

    /// For each two directions in which the ball touches samples one place, or none where the edge is not sharp or the
    /// points do not tell. \param is_known asked with a first guess of the place: whether it need not be sought.
    /// \param is_asked becomes whether one was sought: two directions may be those of two faces, not of a bend or a
    /// rim.
    std::vector<EdgePlace> find(const AxisBall& ball, const std::function<bool(const Point&)>& is_known,
                                bool& is_asked);

private:
    struct Plane
    {
        Point origin;
        Vector normal; ///< Away from the ball.
        double distance(const Point& p) const { return normal.dot(p - origin); }
    };
    using Planes = std::array<Plane, 2>;

    std::optional<EdgePlace> find_in(double widened, const AxisBall& ball, Planes planes);
    static int facing(const Planes& planes, const Point& p);
    static double distance(const Planes& planes, const Point& p);
    static bool may_meet(const Planes& planes);
    static Point place_on(const Planes& planes, const Point& from, double below);
    static bool meet(const AxisBall& ball, const Planes& planes, EdgePlace& edge);
    void collect(const AxisBall& ball, const EdgePlace& edge, double along);
    bool lie_along(const Planes& planes, double capture) const;
    bool refit(Planes& planes, double capture) const;
    bool fit(Plane& plane, const std::vector<int>& of_face) const;
    bool have_both_faces(const AxisBall& ball, const EdgePlace& edge, const Planes& planes, double along) const;
    bool is_sharp(const AxisBall& ball, const EdgePlace& edge, const Planes& planes);
    double misfit_of_planes(const Planes& planes, double cap) const;
    double misfit_of_round_edge(const EdgePlace& edge, Planes planes, double radius, double cap) const;
    double misfit_of_quadric(const EdgePlace& edge, double width, double cap);
    double tolerance(const AxisBall& ball) const;

    const Points& points_;
    const BlockSearch& search_;
    double noise_;
    std::vector<int> around_; ///< Points in the window.
    Gathered gathered_;
    std::vector<int> collected_;
    Point collected_at_ = Point::Zero();
    double collected_within_ = -1; ///< [length]
};

} // namespace recon
