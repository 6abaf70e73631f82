#include "crease_shapes.h"
#include "one_thread.h"

#include "filter_pn_refine/step/crease_sides.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <vector>

namespace
{

using namespace recon;

TEST(Corners, AreFoundWhereFewSamplesShowThem)
{
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
    {
        const PnRefinement refined = refine_points(shapes::box(4000, Vector(2, 2, 2), seed), one_thread(0));
        int corners = 0;
        for (int i = 0; i < refined.crease_points; ++i)
            corners += (refined.points[std::size_t(i)].cwiseAbs() - Vector::Ones()).norm() < 1e-9;
        EXPECT_EQ(corners, 8 * 3) << seed;
    }
}

TEST(Corners, AreFoundAroundWhichAFaceGoesOn)
{
    int found = 0;
    constexpr int seeds = 5;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed)
        for (const Point& p : corners_of(refine_points(l_shape(seed), one_thread(0))))
            for (const Eigen::Vector2d& corner : l_outline)
                found += (p.head<2>() - corner).norm() < 1e-9 && std::abs(p.z() - 0.5) > 0.5 - 1e-9;
    EXPECT_GE(found, seeds * 11); // of twelve
}

TEST(Corners, FacesReachThemAndEndThere)
{
    int asked = 0, bare = 0, beyond = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
    {
        const PnRefinement refined = refine_points(l_shape(seed), one_thread(3));
        for (const double z : {0.0, 1.0})
        {
            const Point corner(1, 1, z);
            const Points found = corners_of(refined);
            if (std::none_of(found.begin(), found.end(), [&](const Point& p) { return (p - corner).norm() < 1e-9; }))
                continue;
            ++asked;
            const double in = z > 0 ? -1 : 1;
            const auto is_bare = [&](const Vector& offset, const Vector& normal)
            {
                for (std::size_t i = 0; i < refined.points.size(); ++i)
                    if ((refined.points[i] - corner - l_spacing * offset).norm() < 0.5 * l_spacing &&
                        refined.normals[i].dot(normal) > 0.9)
                        return false;
                return true;
            };
            for (double u = -1.5; u < 1.6; u += 0.125)
                for (double v = -1.5; v < 1.6; v += 0.125)
                    if (u > 0 && v > 0)
                        bare += is_bare({u, 0, in * v}, Vector::UnitY()) + is_bare({0, u, in * v}, Vector::UnitX());
                    else
                        bare += is_bare({u, v, 0}, -in * Vector::UnitZ());
            for (const Point& p : refined.points)
                beyond += p.x() > 1.01 && p.y() > 1.01 && (p - corner).norm() < 3 * l_spacing;
        }
    }
    EXPECT_GE(asked, 11);
    EXPECT_LE(bare, 5);
    EXPECT_EQ(beyond, 0);
}

TEST(Corners, TheirFacesAreToldFromTheSamplesAround)
{
    // Exact edges and corners, so that only the sides are asked for. At a void of the top its nearest samples are those
    // on the other side of the inner corner, beyond the plane of the wall.
    int asked = 0, wrong = 0, unknown = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
    {
        OrientedSamples samples;
        const OrientedSamples all = l_shape(seed);
        for (std::size_t i = 0; i < all.points.size(); ++i)
            if ((all.points[i] - Point(1 + l_spacing, 1 - l_spacing, 1)).norm() > 1.6 * l_spacing)
                append(samples, all.points[i], all.normals[i]);
        const auto add = [&](const Point& p, std::initializer_list<Vector> normals)
        {
            for (const Vector& n : normals)
                append(samples, p, n);
        };
        const Vector x = Vector::UnitX(), y = Vector::UnitY(), z = Vector::UnitZ();
        add({1, 1, 1}, {x, y, z});
        for (int i = 1; i <= 5; ++i)
        {
            add({1 + i * l_spacing, 1, 1}, {y, z});
            add({1, 1 + i * l_spacing, 1}, {x, z});
            add({1, 1, 1 - i * l_spacing}, {x, y});
        }
        pn::UsableSamples usable;
        pn::choose_usable_samples(samples, {}, UnitFrame(samples.points), 0.8, 1, {}, usable);
        const std::vector<std::uint32_t> sides = pn::sides_of_faces(usable);
        const std::vector<pn::FaceSector> sectors = pn::sectors_of_faces(usable, sides);
        for (std::size_t i = 0; i < sides.size(); ++i)
        {
            if (!usable.is_crease[i])
                continue;
            const Point p = samples.points[std::size_t(usable.input[i])];
            const Vector n = usable.samples.normals[i];
            // Some way into each face beside the point, and some way off it.
            const Vector diagonal = Vector(1, 1, -1) - Vector(1, 1, -1).dot(n) * n;
            const bool is_top = n.z() > 0.5, is_corner = (p - Point(1, 1, 1)).norm() < 1e-9;
            Vector inward = is_top ? Vector(-diagonal) : diagonal;
            if (!is_corner) // across the edge
            {
                const Vector along = (p - Point(1, 1, 1)).normalized();
                inward -= inward.dot(along) * along;
            }
            const pn::FaceDirection in = pn::as_floats(inward), out = pn::as_floats(-inward);
            ++asked;
            if (!sectors[i].is_known())
                ++unknown;
            else
                wrong +=
                    sectors[i].leads_behind(in[0], in[1], in[2]) || !sectors[i].leads_behind(out[0], out[1], out[2]);
        }
    }
    EXPECT_EQ(asked, 20 * (3 + 5 * 6));
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(unknown, 0);
}

/// A comb of four teeth of six spacings; the mouths between them are two and a half wide.
constexpr double tooth = 0.3, mouth = 0.125, root = 0.3, tip = 0.8;

std::vector<Eigen::Vector2d> comb_outline()
{
    std::vector<Eigen::Vector2d> outline = {{0, 0}, {4 * tooth + 3 * mouth, 0}};
    for (int k = 3; k >= 0; --k)
    {
        const double left = k * (tooth + mouth), right = left + tooth;
        outline.insert(outline.end(), {{right, tip}, {left, tip}});
        if (k > 0)
            outline.insert(outline.end(), {{left, root}, {left - mouth, root}});
    }
    return outline;
}

bool is_in_comb(double x, double y)
{
    return y < root || std::fmod(x, tooth + mouth) < tooth;
}

TEST(Corners, NothingLeadsAcrossMouthsBetweenTeeth)
{
    // The ends of the teeth lie in one plane, and their edges on common lines.
    int corners = 0, across = 0;
    constexpr int seeds = 4;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed)
    {
        const PnRefinement refined = refine_points(prism(comb_outline(), is_in_comb, 0.4, 400, seed), one_thread(3));
        for (const Point& p : corners_of(refined))
            for (const Eigen::Vector2d& corner : comb_outline())
                corners += (p.head<2>() - corner).norm() < 1e-9;
        for (const Point& p : refined.points)
        {
            const double x = std::fmod(p.x(), tooth + mouth) - tooth;
            across += p.y() > root + mouth / 2 && x > 0.2 * mouth && x < 0.8 * mouth;
        }
    }
    EXPECT_GE(corners, seeds * 2 * 16 * 0.95);
    EXPECT_LE(across, seeds * 2);
}

TEST(Corners, EdgesOfAThinRimDoNotMeetBesideThem)
{
    // A box that is open above: in the plane of its rim the lines of inner edges lead on to the outer ones.
    constexpr double inner = 0.93;
    const Point outer_corner(1, 1, 1);
    int right = 0, wrong = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
    {
        OrientedSamples samples;
        shapes::Random random(seed);
        const auto uniform = [&] { return 2 * shapes::uniform(random) - 1; };
        for (int i = 0; i < 1000; ++i)
            for (int axis = 0; axis < 3; ++axis)
                for (const double side : {-1.0, 1.0})
                {
                    Point p = shapes::draw_vector(uniform);
                    p[axis] = side;
                    Vector n = Vector::Zero();
                    n[axis] = side;
                    if (axis == 2 && side > 0 && std::abs(p.x()) < inner && std::abs(p.y()) < inner)
                        p.z() = -inner;
                    append(samples, p, n);
                    p[axis] = side * inner;
                    if (axis < 2 && std::abs(p[1 - axis]) < inner && p.z() > -inner)
                    {
                        append(samples, p, -n);
                    }
                }
        for (const Point& p : corners_of(refine_points(samples, one_thread(0))))
        {
            const Point a = p.cwiseAbs(), inner_corner(inner, inner, p.z() > 0 ? 1 : inner);
            ++((a - outer_corner).norm() < 1e-9 || (a - inner_corner).norm() < 1e-9 ? right : wrong);
        }
    }
    EXPECT_GE(right, 6 * 16 * 0.9);
    EXPECT_LE(wrong, 8);
}

TEST(Corners, RimsOfPinsHaveNone)
{
    constexpr double radius = 2, length = 8; // [spacings]
    int corners = 0, crease_points = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed)
    {
        OrientedSamples samples;
        shapes::Random random(seed);
        const auto uniform = [&] { return 2 * shapes::uniform(random) - 1; };
        for (int i = 0; i < int(2 * M_PI * radius * length); ++i)
        {
            const double angle = M_PI * uniform();
            const Vector out(std::cos(angle), std::sin(angle), 0);
            append(samples, radius * out + length / 2 * uniform() * Vector::UnitZ(), out);
        }
        for (const double side : {-1.0, 1.0})
            for (int i = 0; i < int(4 * radius * radius); ++i)
                if (const Eigen::Vector2d p = radius * shapes::draw_pair(uniform); p.norm() < radius)
                    append(samples, Point(p.x(), p.y(), side * length / 2), side * Vector::UnitZ());
        const PnRefinement refined = refine_points(samples, one_thread(0));
        corners += int(corners_of(refined).size());
        crease_points += refined.crease_points;
    }
    EXPECT_GT(crease_points, 1700);
    EXPECT_LT(3 * corners, 0.08 * crease_points);
}

} // namespace
