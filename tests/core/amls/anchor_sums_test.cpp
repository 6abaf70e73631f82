#include "filter_amls/surface/anchor_sums.h"
#include "filter_amls/surface/surface_data.h"

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

using namespace recon;

namespace
{

constexpr double spacing = 0.1, width = 0.3;

/// What the anchors make of a point: the mean of their distances. \param side of the point's cell.
double distance_by(const std::vector<Anchor>& anchors, const Point& p, const Vector& side, double crease)
{
    Points positions;
    for (const Anchor& anchor : anchors)
        positions.push_back(anchor.position);
    AmlsSurface::Data data{UnitFrame(positions)};
    data.anchors = anchors;
    data.anchor_search = BlockSearch(positions);
    constexpr double cut_off = 2.2;
    GatheredAnchors gathered;
    gathered.gather(data, p, 0, width, cut_off);
    const Eigen::Vector3f facing = side.cast<float>(), local = Eigen::Vector3f::Zero();
    Agreement agreement;
    agreement.crease = float(crease / (spacing * spacing));
    Eigen::Vector3f::Map(agreement.normal) = facing;
    AnchorSums sums;
    sum_anchors(gathered.values(), gathered.stride(), local.data(), facing.data(), float(1 / width), float(cut_off),
                agreement, &sums);
    return sums.distance / sums.weight;
}

/// Two square faces that meet in the y axis: one lies in z = 0, x < 0, the other falls (convex) or rises by 70 degrees.
std::vector<Anchor> two_faces(bool convex)
{
    constexpr double turn = 1.22; // radians
    const double sine = std::sin(turn), cosine = std::cos(turn), fall = convex ? 1 : -1;
    const Vector normal(fall * sine, 0, cosine), away(cosine, 0, -fall * sine);
    std::vector<Anchor> result;
    for (int i = 0; i < 10; ++i)
        for (int j = -10; j <= 10; ++j)
        {
            const Vector along = spacing * j * Vector::UnitY();
            const double off = spacing * (i + 0.5);
            result.push_back({along - off * Vector::UnitX(), Vector::UnitZ(), {}, 1, width});
            result.push_back({along + off * away, normal, {}, 1, width});
        }
    return result;
}

} // namespace

TEST(AnchorSums, TheFaceBeyondACreaseIsNotHeard)
{
    const Point near_edge(-0.15, 0, 0);
    for (const bool convex : {true, false})
    {
        const std::vector<Anchor> faces = two_faces(convex);
        // The point lies behind the plane of the face that falls, before that of the face that rises.
        const double heard = distance_by(faces, near_edge, Vector::UnitZ(), 0);
        EXPECT_GT(convex ? -heard : heard, 0.03) << convex;
        EXPECT_NEAR(distance_by(faces, near_edge, Vector::UnitZ(), 100), 0, 0.003) << convex;
    }
}

TEST(AnchorSums, PointsOffACreaseHearBothFaces)
{
    // Outside of a convex edge, and behind a concave one: both faces are in front of the point, or both behind it.
    for (const auto& [convex, p] : {std::pair{true, Point(0.1, 0, 0.1)}, std::pair{false, Point(0.1, 0, -0.1)}})
    {
        const std::vector<Anchor> faces = two_faces(convex);
        EXPECT_NEAR(distance_by(faces, p, Vector::UnitZ(), 100), distance_by(faces, p, Vector::UnitZ(), 0), 1e-3)
            << convex;
    }
}

TEST(AnchorSums, ASmoothBendIsNoCrease)
{
    constexpr double bend = 0.5; // of a unit ball: d(x) = u.n - |u|^2 / 2
    for (const double outward : {1.0, -1.0})
    {
        std::vector<Anchor> ball;
        for (const Point& p : shapes::sphere(2000, 1, 3).points)
            ball.push_back({p, outward * p, {-outward * bend, -outward * bend, -outward * bend, 0, 0, 0}, 1, width});
        for (const double off : {-0.05, 0.0, 0.05})
        {
            const Point p((1 + off) * Vector::UnitX());
            const Vector side = outward * Vector::UnitX();
            EXPECT_NEAR(distance_by(ball, p, side, 100), distance_by(ball, p, side, 0), 2e-3) << outward << ' ' << off;
        }
    }
}
