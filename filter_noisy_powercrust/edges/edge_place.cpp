#include "edge_place.h"

#include "wedge.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

/// Between the faces' normals: 50 and 150 degrees.
constexpr double bend_cosine = 0.64, rim_cosine = -0.87;
/// Of two pairs of touched samples that tell of the same faces: 30 degrees.
constexpr double same_direction = 0.87;
// Lengths in scales of the ball.
constexpr double collected_beyond = 1; // what the first window needs, for those to come
constexpr double farthest_edge = 6;
constexpr double fitted_along = 2.5, tested_along = 1.25, beyond_depth = 1.5; // window around the place
constexpr std::array<double, 2> widths{1, 1.6};                               // of the window along the edge
constexpr double tolerance_of_scale = 0.1, tolerance_of_noise = 3;
constexpr double first_capture = 0.5; // beyond the tolerance, while planes are those of the ball
constexpr double least_noise = 0.05;  // of exact samples of faces that are not quite flat
constexpr int fitting_rounds = 5, first_rounds = 2;
constexpr int least_of_face = 4;                        // points
constexpr double most_off = 0.08, hopelessly_off = 0.5; // of the points
constexpr double most_gap = 0.35;                       // between the ball and the planes [radii]
constexpr double capped_square = 9;                     // of a residual [noise^2]
/// Log-likelihood by which planes must be ahead of a rival.
constexpr double least_lead = 4;
/// Radii of rival round edges; smaller ones do not show between samples.
constexpr std::array<double, 5> roundings{1, 1.4, 2, 2.8, 4};
constexpr int rounding_rounds = 2;

} // namespace

std::vector<EdgePlace> EdgePlaceFinder::find(const AxisBall& ball, const std::function<bool(const Point&)>& is_known,
                                             bool& is_asked)
{
    std::vector<EdgePlace> result;
    is_asked = false;
    Vectors directions;
    for (const Point& p : ball.touched)
        directions.push_back((p - ball.centre).normalized());
    std::vector<std::pair<int, int>> tried;
    const auto was_tried = [&](int i, int j)
    {
        return std::any_of(
            tried.begin(), tried.end(),
            [&](const auto& t)
            {
                const auto alike = [&](int a, int b) { return directions[a].dot(directions[b]) > same_direction; };
                return (alike(i, t.first) && alike(j, t.second)) || (alike(i, t.second) && alike(j, t.first));
            });
    };
    for (int i = 0; i < int(directions.size()); ++i)
        for (int j = 0; j < i; ++j)
        {
            const Planes tangent{Plane{ball.touched[i], directions[i]}, Plane{ball.touched[j], directions[j]}};
            if (!may_meet(tangent) || was_tried(i, j))
                continue;
            tried.emplace_back(i, j);
            if (is_known(place_on(tangent, ball.centre, 0)))
                continue;
            is_asked = true;
            for (const double widened : widths)
                if (const auto edge = find_in(widened, ball, tangent))
                {
                    result.push_back(*edge);
                    break;
                }
        }
    return result;
}

double EdgePlaceFinder::tolerance(const AxisBall& ball) const
{
    return std::max(tolerance_of_scale * ball.scale, tolerance_of_noise * noise_);
}

std::optional<EdgePlace> EdgePlaceFinder::find_in(double widened, const AxisBall& ball, Planes planes)
{
    EdgePlace edge;
    for (int round = 0;; ++round)
    {
        if (!meet(ball, planes, edge))
            return {};
        collect(ball, edge, widened * fitted_along * ball.scale);
        if (round == fitting_rounds)
            break;
        const double capture = tolerance(ball) + (round < first_rounds ? first_capture * ball.scale : 0);
        if (!lie_along(planes, capture) || !refit(planes, capture))
            return {};
    }
    for (const Plane& plane : planes)
        if (std::abs(plane.distance(ball.centre) + ball.radius) > most_gap * ball.radius + tolerance(ball))
            return {};
    if (!have_both_faces(ball, edge, planes, widened * tested_along * ball.scale) || !is_sharp(ball, edge, planes))
        return {};
    return edge;
}

/// The plane that bounds what lies below both.
int EdgePlaceFinder::facing(const Planes& planes, const Point& p)
{
    return planes[0].distance(p) > planes[1].distance(p) ? 0 : 1;
}

/// Signed, from the boundary of what lies below both.
double EdgePlaceFinder::distance(const Planes& planes, const Point& p)
{
    return std::max(planes[0].distance(p), planes[1].distance(p));
}

bool EdgePlaceFinder::may_meet(const Planes& planes)
{
    const double cosine = planes[0].normal.dot(planes[1].normal);
    return cosine <= bend_cosine && cosine >= rim_cosine;
}

/// The place nearest to `from` that lies `below` both planes.
Point EdgePlaceFinder::place_on(const Planes& planes, const Point& from, double below)
{
    const double h0 = -planes[0].distance(from) - below, h1 = -planes[1].distance(from) - below;
    const double cosine = planes[0].normal.dot(planes[1].normal), squared_sine = 1 - cosine * cosine;
    return from + (h0 - cosine * h1) / squared_sine * planes[0].normal +
           (h1 - cosine * h0) / squared_sine * planes[1].normal;
}

/// \returns false if the ball has no edge below.
bool EdgePlaceFinder::meet(const AxisBall& ball, const Planes& planes, EdgePlace& edge)
{
    if (!may_meet(planes) || planes[0].distance(ball.centre) >= 0 || planes[1].distance(ball.centre) >= 0)
        return false;
    edge.normals = {planes[0].normal, planes[1].normal};
    edge.along = planes[0].normal.cross(planes[1].normal).normalized();
    edge.place = place_on(planes, ball.centre, 0);
    edge.depth = (edge.place - ball.centre).norm();
    return edge.depth < farthest_edge * ball.scale;
}

/// Points in a window around the edge.
void EdgePlaceFinder::collect(const AxisBall& ball, const EdgePlace& edge, double along)
{
    const double across = edge.depth + beyond_depth * ball.scale, reach = std::hypot(across, along);
    if ((edge.place - collected_at_).norm() + reach > collected_within_)
    {
        collected_at_ = edge.place;
        collected_within_ = reach + collected_beyond * ball.scale;
        search_.within(collected_at_, collected_within_, collected_);
    }
    around_.clear();
    for (const int i : collected_)
    {
        const Vector d = points_[i] - edge.place;
        const double t = d.dot(edge.along);
        if (std::abs(t) <= along && d.squaredNorm() - t * t <= across * across)
            around_.push_back(i);
    }
}

/// Whether enough of the points to go on.
bool EdgePlaceFinder::lie_along(const Planes& planes, double capture) const
{
    const auto off = std::count_if(around_.begin(), around_.end(),
                                   [&](int i) { return std::abs(distance(planes, points_[i])) > capture; });
    return double(off) <= hopelessly_off * double(around_.size());
}

/// \param capture distance from a plane up to which points are of its face [length].
bool EdgePlaceFinder::refit(Planes& planes, double capture) const
{
    const Planes before = planes;
    for (int k = 0; k < 2; ++k)
    {
        std::vector<int> of_face;
        for (const int i : around_)
            if (const double own = before[k].distance(points_[i]);
                std::abs(own) < capture && own >= before[1 - k].distance(points_[i]))
                of_face.push_back(i);
        if (!fit(planes[k], of_face))
            return false;
    }
    return true;
}

/// The plane through points that goes on facing where it faced. \returns false for too few, or a row of them.
bool EdgePlaceFinder::fit(Plane& plane, const std::vector<int>& of_face) const
{
    if (int(of_face.size()) < least_of_face)
        return false;
    Point sum = Point::Zero();
    for (const int i : of_face)
        sum += points_[i];
    plane.origin = sum / double(of_face.size());
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const int i : of_face)
        moments += (points_[i] - plane.origin) * (points_[i] - plane.origin).transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(moments);
    if (solver.eigenvalues()[1] < 2 * solver.eigenvalues()[0])
        return false;
    const Vector normal = solver.eigenvectors().col(0);
    plane.normal = normal.dot(plane.normal) < 0 ? Vector(-normal) : normal;
    return true;
}

bool EdgePlaceFinder::have_both_faces(const AxisBall& ball, const EdgePlace& edge, const Planes& planes,
                                      double along) const
{
    int tested = 0, off = 0;
    std::array<int, 2> of_face{};
    for (const int i : around_)
    {
        if (std::abs((points_[i] - edge.place).dot(edge.along)) > along)
            continue;
        ++tested;
        if (std::abs(distance(planes, points_[i])) > tolerance(ball))
            ++off;
        else
            ++of_face[facing(planes, points_[i])];
    }
    return off <= most_off * tested && std::min(of_face[0], of_face[1]) >= least_of_face;
}

bool EdgePlaceFinder::is_sharp(const AxisBall& ball, const EdgePlace& edge, const Planes& planes)
{
    const double noise = std::max(noise_, least_noise * ball.scale), unit = noise * noise, cap = capped_square * unit;
    const double bearable = misfit_of_planes(planes, cap) + 2 * least_lead * unit;
    for (const double rounding : roundings)
        if (misfit_of_round_edge(edge, planes, rounding * ball.scale, cap) < bearable)
            return false;
    return misfit_of_quadric(edge, edge.depth + ball.scale, cap) >= bearable;
}

double EdgePlaceFinder::misfit_of_planes(const Planes& planes, double cap) const
{
    double sum = 0;
    for (const int i : around_)
    {
        const double high = distance(planes, points_[i]);
        sum += std::min(high * high, cap);
    }
    return sum;
}

/// Of a cylinder that touches both planes, and of these beyond it, fitted to what lies there: planes through all points
/// of a round edge lie below its faces.
double EdgePlaceFinder::misfit_of_round_edge(const EdgePlace& edge, Planes planes, double radius, double cap) const
{
    double sum = 0;
    for (int round = 0; round <= rounding_rounds; ++round)
    {
        const Vector &n0 = planes[0].normal, &n1 = planes[1].normal;
        const Vector along = n0.cross(n1).normalized();
        const Point axis = place_on(planes, edge.place, radius);
        const double cosine = n0.dot(n1);
        std::array<std::vector<int>, 2> of_face;
        sum = 0;
        for (const int i : around_)
        {
            Vector d = points_[i] - axis;
            d -= d.dot(along) * along;
            const double a = d.dot(n0), b = d.dot(n1);
            double residual = d.norm() - radius;
            if (a <= cosine * b || b <= cosine * a)
            {
                residual = distance(planes, points_[i]);
                if (residual * residual < cap)
                    of_face[facing(planes, points_[i])].push_back(i);
            }
            sum += std::min(residual * residual, cap);
        }
        if (round == rounding_rounds || !fit(planes[0], of_face[0]) || !fit(planes[1], of_face[1]) || !may_meet(planes))
            break;
    }
    return sum;
}

/// \param width within which points lie about the place [length].
double EdgePlaceFinder::misfit_of_quadric(const EdgePlace& edge, double width, double cap)
{
    Sheet sheet;
    sheet.origin = edge.place;
    sheet.frame = TangentFrame((edge.normals[0] + edge.normals[1]).normalized());
    sheet.width = 4 * width; // all points weigh about the same
    gathered_.gather(points_, {}, around_, sheet.origin);
    QuadricWeights how{sheet.width, 4};
    how.ridge_linear = how.ridge_quadratic = 1e-9;
    sheet.c = fit_quadric(gathered_, Point::Zero(), sheet.frame, how).c;
    double sum = 0;
    for (const int i : around_)
    {
        const double d = sheet.distance(points_[i]);
        sum += std::min(d * d, cap);
    }
    return sum;
}

} // namespace recon
