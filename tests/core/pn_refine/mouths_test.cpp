#include "crease_shapes.h"
#include "one_thread.h"

#include "filter_pn_refine/creases/mouths.h"
#include "filter_pn_refine/refine.h"
#include "filter_pn_refine/step/spacing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace
{

using namespace recon;
using Outline = std::vector<Eigen::Vector2d>;

constexpr double spacing = 0.1;

/// Samples of what lies below a profile over [0, 4], one to a square of `spacing`; 1 long.
OrientedSamples extrude(const Outline& profile, std::uint64_t seed)
{
    Outline outline = {{0, 0}, {4, 0}};
    outline.insert(outline.end(), profile.rbegin(), profile.rend());
    const auto is_inside = [&](double x, double y)
    {
        bool inside = false;
        for (std::size_t k = 0; k < outline.size(); ++k)
        {
            const Eigen::Vector2d &a = outline[k], &b = outline[(k + 1) % outline.size()];
            if ((a.y() > y) != (b.y() > y) && x < a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
                inside = !inside;
        }
        return inside;
    };
    return prism(outline, is_inside, 1, 1 / (spacing * spacing), seed);
}

/// Boxes of `width` on a base or, of negative height, slits in it.
Outline with_boxes(double width, double height)
{
    Outline profile = {{0, 1}};
    for (double x = 0.5; x < 4; x += 0.5)
        for (const Eigen::Vector2d& p : Outline{{x, 1}, {x, 1 + height}, {x + width, 1 + height}, {x + width, 1}})
            profile.push_back(p);
    profile.emplace_back(4, 1);
    return profile;
}

/// How many points lie farther than 0.4 spacings from a profile. Ends are left out.
int count_off(const Points& points, const Outline& profile)
{
    const auto distance = [&](const Eigen::Vector2d& p)
    {
        double nearest = 1e300;
        for (std::size_t k = 1; k < profile.size(); ++k)
        {
            const Eigen::Vector2d a = profile[k - 1], d = profile[k] - a;
            nearest = std::min(nearest, (p - a - std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) * d).norm());
        }
        return nearest;
    };
    return int(std::count_if(points.begin(), points.end(),
                             [&](const Point& p)
                             {
                                 return p.y() > 0.5 && p.x() > 0.2 && p.x() < 3.8 && p.z() > 0.1 && p.z() < 0.9 &&
                                        distance(p.head<2>()) > 0.4 * spacing;
                             }));
}

/// Refined from four seeds' samples of it.
struct Refined
{
    int off = 0, folds = 0;
};
Refined refine(const Outline& profile)
{
    Refined all;
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
    {
        const PnRefinement refined = refine_points(extrude(profile, seed), one_thread(3));
        all.off += count_off(refined.points, profile);
        all.folds += refined.fold_points;
    }
    return all;
}

TEST(Mouths, OfSmallBoresStayOpen)
{
    constexpr double samples = 280, bore = 1.25 / 16.73, beside = 0.4 / 16.73; // 2.5 and 0.4 spacings
    int in_mouths = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed)
    {
        const PnRefinement refined = refine_points(bored_plate(0.4, bore, samples, seed), one_thread(3));
        in_mouths += int(std::count_if(refined.points.begin(), refined.points.end(),
                                       [&](const Point& p) { return p.head<2>().norm() < bore - beside; }));
    }
    EXPECT_LE(in_mouths, 3); // 30 where only triangles are asked
}

TEST(Mouths, NothingIsPutIntoFeetOfThinRibs)
{
    const Refined refined = refine(with_boxes(0.7 * spacing, 0.4));
    EXPECT_LE(refined.off, 15); // 42 where only triangles are asked
    EXPECT_EQ(refined.folds, 0) << "a flat flank does not bend round the rib's top";
}

TEST(Mouths, AreToldByTheirWalls)
{
    const OrientedSamples samples = extrude(with_boxes(0.25, -0.4), 1);
    const UnitFrame frame(samples.points);
    pn::UsableSamples usable;
    pn::choose_usable_samples(samples, {}, frame, 0.8, 1, {}, usable);
    const double unit = spacing / frame.scale();
    const pn::Mouths mouths(usable, std::vector<float>(usable.input.size(), float(unit)), 1);
    const auto hold = [&](double x, double y, const Vector& normal) {
        return mouths.hold(frame.to_unit({x, y, 0.5}), normal, unit);
    };
    const Vector up = Vector::UnitY(), right = Vector::UnitX();
    for (double slit = 0.5; slit < 4; slit += 0.5)
    {
        EXPECT_TRUE(hold(slit + 0.125, 1, up)) << slit;
        EXPECT_FALSE(hold(slit + 0.125, 0.6, up)) << "on its bottom";
        EXPECT_FALSE(hold(slit, 0.8, right)) << "on its wall";
        EXPECT_FALSE(hold(slit - 0.1, 1, up)) << "beside it";
        EXPECT_FALSE(hold(slit + 0.125, 0, -up)) << "under it, on the other side of a sheet";
        EXPECT_TRUE(hold(slit - 0.06, 0.6, up)) << "in the foot of the rib beside it";
    }
}

TEST(Creases, OfAThreadLeadAlongIt)
{
    Outline thread;
    for (int i = 0; i <= 40; ++i)
        thread.emplace_back(0.1 * i, i % 2 ? 1.2 : 1.0);
    EXPECT_LE(refine(thread).off, 20); // 8,174 where crests are linked whose normals agree
}

} // namespace
