#include "filter_noisy_powercrust/labels/prepare_samples.h"
#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"
#include "tests/flat_shapes.h"
#include "tests/shapes.h"

#include <recon/bare_faces/complete_flats.h>
#include <recon/bare_faces/planar_faces.h>
#include <recon/errors.h>
#include <recon/search/spatial_order.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

using namespace recon;
using namespace flat_shapes;

TEST(FillPlanarRims, FillsEverySecondRegion)
{
    Points ring;
    for (const double radius : {0.1, 0.2, 0.3, 0.4})
        append_ring(ring, 0.02, 0, 0, radius, 60);
    std::vector<Eigen::Vector2d> points;
    for (const Point& p : ring)
        points.emplace_back(p.x(), p.y());
    const auto faces = fill_planar_rims(points, 0).faces;
    ASSERT_EQ(faces.size(), 2u);
    double area = 0;
    for (const PlanarFace& face : faces)
        for (const auto& t : face.triangles)
        {
            const Eigen::Vector2d u = points[t[1]] - points[t[0]], v = points[t[2]] - points[t[0]];
            EXPECT_GT(u.x() * v.y() - u.y() * v.x(), 0);
            area += 0.5 * (u.x() * v.y() - u.y() * v.x());
        }
    EXPECT_NEAR(area, pi * (0.16 - 0.09 + 0.04 - 0.01), 0.01);
}

TEST(FillPlanarRims, TellsRimsNearerToEachOtherThanTheirSamples)
{
    // A disc with holes 0.005 from its rim and 0.01 from each other, sampled 0.026 to 0.03 apart.
    constexpr double edge = 0.445, hole = 0.075;
    Points ring;
    append_ring(ring, 0, 0, 0, edge, 95);
    for (const double angle : {0.0, 0.43, 2.0})
        append_ring(ring, 0.365 * std::cos(angle), 0.365 * std::sin(angle), 0, angle == 0.43 ? 0.07 : hole, 17);
    std::vector<Eigen::Vector2d> points;
    for (const Point& p : ring)
        points.emplace_back(p.x(), p.y());
    const auto faces = fill_planar_rims(points, 0).faces;
    ASSERT_EQ(faces.size(), 1u);
    EXPECT_EQ(faces.front().rim.size(), points.size());
    // As many triangles as rim samples and two per hole, less two: no rim leads from one circle to another.
    EXPECT_EQ(faces.front().triangles.size(), points.size() + 2 * 3 - 2);
}

TEST(FillPlanarRims, LeavesOutStraysOnlyIfTold)
{
    Points ring;
    append_ring(ring, 0, 0, 0, 0.2, 60);
    append_ring(ring, 0, 0, 0, 0.4, 120);
    std::vector<Eigen::Vector2d> points;
    for (const Point& p : ring)
        points.emplace_back(p.x(), p.y());
    points.emplace_back(0.03, 0.02);
    EXPECT_TRUE(fill_planar_rims(points, 0).faces.empty());
    EXPECT_TRUE(fill_planar_rims(points, 0.005).faces.empty());
    for (const double share : {0.01, 0.1, 0.5}) // more than suffices changes nothing
    {
        const PlanarFaces filled = fill_planar_rims(points, share);
        ASSERT_EQ(filled.faces.size(), 1u);
        EXPECT_EQ(filled.faces.front().rim.size(), 180u);
        EXPECT_EQ(filled.on_rims, 180u);
        EXPECT_TRUE(are_all_but(0.01, filled.on_rims, points.size()));
        EXPECT_FALSE(are_all_but(0.005, filled.on_rims, points.size()));
    }
}

TEST(FillPlanarRims, NoFaceThroughAGap)
{
    Points ring;
    append_ring(ring, 0, 0, 0, 0.4, 120);
    std::vector<Eigen::Vector2d> points;
    for (const Point& p : ring)
        points.emplace_back(p.x(), p.y());
    points.emplace_back(-0.01, 0); // a rim of two ends
    points.emplace_back(0.01, 0);
    EXPECT_TRUE(fill_planar_rims(points, 0).faces.empty());
    EXPECT_TRUE(fill_planar_rims({}, 0).faces.empty());
    EXPECT_TRUE(fill_planar_rims({{0, 0}, {0.1, 0}, {0.2, 0}}, 0.1).faces.empty());
}

TEST(LieOnALine, SoDoNineInTenWhateverTheOthersDo)
{
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < 95; ++i)
        points.emplace_back(0.01 * i, 0.005 * i + (i % 3 - 1) * 1e-4);
    for (int i = 0; i < 5; ++i)
        points.emplace_back(0.3 - 0.1 * i, 0.1 * i * i - 0.7);
    EXPECT_TRUE(lie_on_a_line(points, 4e-4));
    EXPECT_FALSE(lie_on_a_line(points, 2e-5));
    for (int i = 0; i < 20; ++i)
        points.emplace_back(0.05 * i, -0.5);
    EXPECT_FALSE(lie_on_a_line(points, 4e-4));
    EXPECT_FALSE(lie_on_a_line({}, 1));
    // Equal points have no line between them that all others would lie on.
    EXPECT_FALSE(lie_on_a_line({{0, 0}, {0, 0}, {1, 0}, {0, 1}}, 1e-3));
}

TEST(CompleteFlats, PutsSamplesOnFacesAndStraightWallsOnly)
{
    const Points points = flange();
    const FlatCompletion completion = complete_flats(points);
    EXPECT_EQ(completion.faces, 2);
    int on_faces = 0;
    for (const Point& p : completion.points)
    {
        const bool on_face = std::min(std::abs(p.z()), std::abs(p.z() - thickness)) < 1e-9;
        on_faces += on_face;
        // Walls: polygons with their corners on the circles.
        EXPECT_TRUE(on_face ? is_ground(p) : p.z() > 0 && p.z() < thickness) << p.transpose();
    }
    EXPECT_GT(on_faces, 300);
    EXPECT_GT(int(completion.points.size()) - on_faces, 300);
}

TEST(CompleteFlats, FindsNoFaceBetweenOppositeEdgesOfAPlate)
{
    // Its edges are sampled so finely that around their samples there are no others: any plane through an edge fits.
    Points plate = bored_plate(120);
    for (Point& p : plate)
        p = p.cast<float>().cast<double>();
    plate = points_at(order_spatially(plate).order, plate);
    const FlatFaces faces = find_flat_faces(UnitFrame(plate).to_unit(plate));
    EXPECT_EQ(faces.bare.size(), 2u);
    for (const FlatFace& face : faces.bare)
        EXPECT_GT(std::abs(face.normal.z()), 0.999);
    EXPECT_EQ(reconstruct_noisy_power_crust(plate).genus, plate_bores);
}

TEST(CompleteFlats, RimsDividedEverFinerHaveSamplesInProportion)
{
    // Its walls are as high whatever the spacing of the rims.
    const auto complete = [](int pieces)
    {
        Points tube;
        for (const double z : {0.0, 0.3})
            for (const double radius : {0.1, 0.4})
                append_ring(tube, 0, 0, z, radius, pieces);
        return complete_flats(tube);
    };
    const FlatCompletion coarse = complete(200), fine = complete(800); // pieces of less than half a degree
    EXPECT_EQ(coarse.faces, 2);
    EXPECT_EQ(fine.faces, 2);
    EXPECT_LT(double(fine.points.size()), 6 * double(coarse.points.size()));
}

TEST(CompleteFlats, FaceOfTooManyPiecesStaysBare)
{
    // Triangles run along a row of samples, and get pieces as small as its spacing from end to end.
    const auto fill = [](int samples)
    {
        Points rims;
        FlatFace face{Point::Zero(), Vector::UnitZ(), {}, {}, {}};
        for (int i = 0; i <= samples; ++i)
            rims.emplace_back(double(i) / samples, 0, 0);
        rims.emplace_back(0.5, 3.0 / samples, 0);
        for (int i = 0; i < int(rims.size()); ++i)
            face.rim.push_back(i);
        face.triangles.assign(4, {0, samples, samples + 1});
        return fill_face(face, rims, {Point(9, 9, 9)}, 1);
    };
    EXPECT_FALSE(fill(20).empty());
    EXPECT_TRUE(fill(2000).empty());
}

TEST(CompleteFlats, LeavesWellSampledCloudsAlone)
{
    EXPECT_TRUE(complete_flats(shapes::box(6000, Vector(0.6, 0.5, 0.4), 3).points).points.empty());
    EXPECT_TRUE(complete_flats(shapes::torus(5000, 0.35, 0.12, 2).points).points.empty());
    EXPECT_TRUE(complete_flats(shapes::sphere(3000, 0.5, 1).points).points.empty());
    EXPECT_TRUE(complete_flats({}).points.empty());
    EXPECT_TRUE(complete_flats(Points(20, Point::Zero())).points.empty());
}

TEST(CompleteFlats, DoesNotCloseTheMouthOfABowl)
{
    // Two circles in the plane of the mouth, and the bowl between them below.
    Points points;
    for (int k = 0; k <= 30; ++k)
        append_ring(points, 0, 0, -0.35 * std::sin(pi / 2 * k / 30), 0.01 + 0.39 * std::cos(pi / 2 * k / 30), 90);
    EXPECT_EQ(complete_flats(points).faces, 0);
}

TEST(CompleteFlats, DoesNotCutAcrossASolidWhereItsChamfersEnd)
{
    // The chamfers' upper rims lie in one plane too, a cross-section of the solid.
    Points points;
    append_ring(points, 0, 0, 0, 0.42, 120);
    append_ring(points, 0, 0, 0, 0.23, 70);
    for (const double z : {0.03, 0.15})
    {
        append_ring(points, 0, 0, z, 0.45, 120);
        append_ring(points, 0, 0, z, 0.2, 70);
    }
    for (const Point& p : complete_flats(points).points)
        EXPECT_TRUE(std::min(std::abs(p.z()), std::abs(p.z() - 0.15)) < 1e-9 || std::hypot(p.x(), p.y()) > 0.44 ||
                    std::hypot(p.x(), p.y()) < 0.21)
            << p.transpose();
    EXPECT_EQ(complete_flats(points).faces, 2);
}

TEST(CompleteFlats, LeavesNarrowRingsAlone)
{
    Points points;
    for (const double z : {0.0, 0.3})
    {
        append_ring(points, 0, 0, z, 0.4, 120);
        append_ring(points, 0, 0, z, 0.38, 120);
    }
    EXPECT_EQ(complete_flats(points).faces, 0);
}

TEST(CompleteFlats, PutsSamplesBetweenChamfersAndInCounterbores)
{
    const FlatCompletion completion = complete_flats(coupling());
    EXPECT_EQ(completion.faces, 2);
    int outside = 0, in_bore = 0, in_counterbores = 0, above_fillets = 0;
    for (const Point& p : completion.with_all_walls)
    {
        if (std::min(p.z(), 0.25 - p.z()) < 1e-9)
            continue;
        const double r = std::hypot(p.x(), p.y());
        double at = 1e300;
        for (int k = 0; k < counterbores; ++k)
            at = std::min(at, std::hypot(p.x() - counterbore_at * std::cos(2 * pi / counterbores * k),
                                         p.y() - counterbore_at * std::sin(2 * pi / counterbores * k)));
        // Chords of a circle of 20 are off by 0.012 of its radius.
        const bool is_outside = distance_to_profile(coupling_outside, p.z(), r) < 1e-3,
                   is_in_bore = distance_to_profile(coupling_bore, p.z(), r) < 1e-3,
                   is_in_counterbore = distance_to_profile(coupling_counterbore, p.z(), at) < 1e-3;
        EXPECT_TRUE(is_outside || is_in_bore || is_in_counterbore) << p.transpose();
        outside += is_outside;
        in_bore += is_in_bore;
        in_counterbores += is_in_counterbore;
        above_fillets += is_in_counterbore && p.z() > 0.13;
    }
    EXPECT_GT(outside, 200);
    EXPECT_GT(in_bore, 50);
    EXPECT_GT(in_counterbores, counterbores * 50);
    EXPECT_GT(above_fillets, counterbores * 50);
}

TEST(CompleteFlats, PutsNoWallsIntoALathedShape)
{
    // Rings on one side of a waist or a bulge lie straight above those on the other. As far from the next ring as
    // samples of one from each other, or three and six times as far.
    for (const auto& [wide, swing, height, rings, around] :
         {std::array<double, 5>{0.25, 0.15, 0.6, 30, 60}, std::array<double, 5>{0.3, 0.1, 0.9, 24, 200},
          std::array<double, 5>{0.25, -0.15, 0.8, 30, 90}})
    {
        std::vector<Ring> profile;
        for (int k = 0; k <= int(rings); ++k)
            profile.push_back({height * k / rings, wide + swing * std::cos(2 * pi * k / rings)});
        Points points;
        for (const auto& [z, radius] : profile)
            append_ring(points, 0, 0, z, radius, int(around));
        const double hole = 0.4 * profile.front().radius;
        for (const double z : {0.0, height})
            append_ring(points, 0, 0, z, hole, 30);
        const FlatCompletion completion = complete_flats(points);
        for (const Point& p : completion.with_all_walls)
        {
            const double r = std::hypot(p.x(), p.y());
            EXPECT_TRUE(std::min(p.z(), height - p.z()) < 1e-9 || std::abs(r - hole) < 0.02 * hole ||
                        distance_to_profile(profile, p.z(), r) < 2e-3)
                << p.transpose() << " " << around;
        }
        EXPECT_EQ(completion.faces, 2);
        EXPECT_GT(completion.with_all_walls.size(), 100u);
    }
}

TEST(CompleteFlats, StopsWhenAskedBetweenRims)
{
    const Points points = coupling();
    int calls = 0;
    const auto count = [&](double, const std::string&)
    {
        ++calls;
        return true;
    };
    complete_flats(points, {}, Progress(count));
    const int all = calls;
    for (const int last : {all / 2, all - 1})
    {
        calls = 0;
        const Progress stops([&](double, const std::string&) { return ++calls < last; });
        EXPECT_THROW(complete_flats(points, {}, stops), Cancelled);
        EXPECT_EQ(calls, last);
    }
}

TEST(CompleteFlats, SameForAnyNumberOfThreads)
{
    FlatFaceOptions one, two;
    one.threads = 1;
    two.threads = 2;
    const FlatCompletion a = complete_flats(flange(), one), b = complete_flats(flange(), two);
    ASSERT_EQ(a.points.size(), b.points.size());
    for (std::size_t i = 0; i < a.points.size(); ++i)
        EXPECT_EQ(a.points[i], b.points[i]);
}

TEST(CompleteFlats, CrustOfAFlangeHasItsBores)
{
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(flange());
    expect_bored_flange(crust.mesh);
    EXPECT_GT(crust.completed, 0);
    EXPECT_EQ(crust.samples, crust.points_used + crust.completed);
}

TEST(CompleteFlats, CrustOfACouplingHasItsBores)
{
    expect_bored_coupling(reconstruct_noisy_power_crust(coupling()).mesh);
}

TEST(CompleteFlats, CrustOfAFlatBracketSampledAlongItsEdges)
{
    const Points points = prism({{0, 0}, {1, 0}, {1, 0.2}, {0.2, 0.2}, {0.2, 0.8}, {0, 0.8}}, 0.5, 0.03);
    const FlatCompletion completion = complete_flats(points);
    EXPECT_EQ(completion.faces, 8);
    for (const Point& p : completion.points)
    {
        const double x = std::min({p.x(), std::abs(p.x() - 0.2), std::abs(p.x() - 1)});
        const double y = std::min({p.y(), std::abs(p.y() - 0.2), std::abs(p.y() - 0.8)});
        EXPECT_LT(std::min({x, y, p.z(), std::abs(p.z() - 0.5)}), 1e-6) << "inside: " << p.transpose();
    }
    const checks::MeshReport report = checks::examine_mesh(reconstruct_noisy_power_crust(points).mesh);
    EXPECT_TRUE(report.is_closed_oriented_manifold()) << report.text();
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.genus(), 0);
    EXPECT_NEAR(report.volume / 0.16, 1, 0.03);
}

TEST(CompleteFlats, NoWallRisesWhereTheRimMeetsAnotherFace)
{
    // An H-beam: the floors of its slots lie across the web from each other, rim above rim.
    const std::vector<Eigen::Vector2d> polygon = {{0, 0}, {0.3, 0}, {0.3, 0.4}, {0.7, 0.4}, {0.7, 0}, {1, 0},
                                                  {1, 1}, {0.7, 1}, {0.7, 0.6}, {0.3, 0.6}, {0.3, 1}, {0, 1}};
    const double height = 0.5;
    const FlatCompletion completion = complete_flats(prism(polygon, height, 0.03));
    EXPECT_GE(completion.faces, 12);
    for (const Point& p : completion.points)
    {
        double off = std::min(p.z(), height - p.z());
        for (std::size_t i = 0; i < polygon.size(); ++i)
            off = std::min(off, distance_to_segment(p.head<2>(), polygon[i], polygon[(i + 1) % polygon.size()]));
        EXPECT_LT(off, 1e-6) << "inside: " << p.transpose();
    }
}

TEST(CompleteFlats, DiscThatMeetsNoOtherFaceStaysOpen)
{
    // The rim of a hollow: nothing tells it from the end of a rod.
    Points points;
    append_ring(points, 0, 0, 0, 0.3, 60);
    append_ring(points, 0, 0, -0.2, 0.3, 60);
    EXPECT_EQ(complete_flats(points).faces, 0);
}

TEST(CompleteFlats, OutlinesOfSlicesAreNotFilled)
{
    // Some pass for rims of flat faces, but no vote says that one is missing.
    constexpr int slices = 40, finer = 5;
    constexpr double apart = 2.0 / slices, lobe = 0.25;
    Points points;
    for (int i = 0; i < slices; ++i)
    {
        const double z = -1 + (i + 0.5) * apart, radius = std::sqrt(1 - z * z);
        const int count = int(2 * pi * radius / apart * finer);
        for (int k = 0; k < count; ++k)
        {
            const double angle = 2 * pi * k / count, r = radius * (1 + lobe * std::cos(3 * angle));
            points.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
        }
    }
    ASSERT_FALSE(complete_flats(points).points.empty());
    const NoisyPowerCrust crust = reconstruct_noisy_power_crust(points);
    EXPECT_EQ(crust.completed, 0);
    EXPECT_TRUE(std::none_of(crust.seconds.begin(), crust.seconds.end(),
                             [](const auto& phase) { return phase.first == "flat faces"; }));
    EXPECT_EQ(crust.genus, 0);
    EXPECT_NEAR(checks::examine_mesh(crust.mesh).volume, 4 * pi / 3 * (1 + lobe * lobe / 2), 0.03);
}

TEST(CompleteFlats, PointsAsTheyAreStayAsTheyAre)
{
    SamplePreparationOptions options;
    LatestSurface latest;
    PhaseTimes times;
    const auto complete = [&] { return prepare_samples(flange(), options, latest, times).complete(times, 1); };
    EXPECT_GT(complete().points.size(), 0u);
    options.denoise = Denoise::off;
    EXPECT_TRUE(complete().points.empty());
    EXPECT_EQ(prepare_samples(flange(), options, latest, times).samples.size(), flange().size());
}
