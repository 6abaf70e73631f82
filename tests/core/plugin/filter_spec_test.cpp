#include <meshlab/filter_spec.h>

#include <gtest/gtest.h>

#include <limits>
#include <new>

namespace
{

plugin::InputLayer three_points()
{
    plugin::InputLayer layer;
    layer.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    layer.normals = {{0, 0, 2}, {0, 1e-200, 0}, {0, 0, 0}};
    layer.selected = {0, 1, 0};
    return layer;
}

std::string message(void (*thrower)())
{
    try
    {
        thrower();
    }
    catch (...)
    {
        return plugin::message_of_current_exception();
    }
    return "nothing was thrown";
}

} // namespace

TEST(VerticesToUse, AllOrTheSelected)
{
    EXPECT_EQ(plugin::vertices_to_use(three_points(), false), (std::vector<int>{0, 1, 2}));
    EXPECT_EQ(plugin::vertices_to_use(three_points(), true), (std::vector<int>{1}));
}

TEST(VerticesToUse, RefusesNoVerticesAndAnEmptySelection)
{
    plugin::InputLayer layer = three_points();
    layer.selected = {0, 0, 0};
    EXPECT_THROW(plugin::vertices_to_use(layer, true), recon::InvalidInput);
    EXPECT_THROW(plugin::vertices_to_use(plugin::InputLayer(), false), recon::InvalidInput);
}

TEST(OrientedSamples, HaveUnitNormals)
{
    const recon::OrientedSamples samples = plugin::oriented_samples(three_points(), {0, 1});
    EXPECT_EQ(samples.points[1], recon::Point(1, 0, 0));
    EXPECT_NEAR(samples.normals[0].z(), 1, 1e-15);
    EXPECT_NEAR(samples.normals[1].y(), 1, 1e-15);
}

TEST(OrientedSamples, RefuseZeroAndInfiniteNormals)
{
    plugin::InputLayer layer = three_points();
    EXPECT_THROW(plugin::oriented_samples(layer, {0, 2}), recon::InvalidInput);
    layer.normals[0].x() = std::numeric_limits<double>::infinity();
    EXPECT_THROW(plugin::oriented_samples(layer, {0}), recon::InvalidInput);
    layer.normals[0].x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(plugin::oriented_samples(layer, {0}), recon::InvalidInput);
}

TEST(MessageOfCurrentException, TellsUsersTheCause)
{
    EXPECT_EQ(message([] { throw recon::InvalidInput("cause"); }), "cause");
    EXPECT_EQ(message([] { throw recon::AlgorithmFailure("step"); }), "step");
    EXPECT_EQ(message([] { throw recon::Cancelled(); }).find("The filter was cancelled"), 0u);
    EXPECT_NE(message([] { throw std::bad_alloc(); }).find("memory"), std::string::npos);
    EXPECT_NE(message([] { throw std::out_of_range("vector"); }).find("vector"), std::string::npos);
    EXPECT_NE(message([] { throw 7; }).find("unknown"), std::string::npos);
}

TEST(ResultValues, AreReadableInALog)
{
    EXPECT_EQ(plugin::describe_value({"count", 3}), "count: 3");
    EXPECT_EQ(plugin::describe_value({"length", 0.25}), "length: 0.25");
    EXPECT_EQ(plugin::describe_value({"closed", true}), "closed: yes");
    EXPECT_EQ(plugin::key_of_seconds("Delaunay triangulation"), "seconds_delaunay_triangulation");
}

TEST(NameWithoutEnding, DropsTheEndingOfFileNames)
{
    plugin::InputLayer layer;
    for (const auto& [name, expected] :
         {std::pair("bunny.ply", "bunny"), std::pair("bunny", "bunny"), std::pair("a.b.x3d", "a.b"),
          std::pair(".ply", ".ply"), std::pair("version 1.5", "version 1.5"), std::pair("v1.5 final", "v1.5 final"),
          std::pair("", "unnamed layer")})
    {
        layer.name = name;
        EXPECT_EQ(plugin::name_without_ending(layer), expected);
    }
}
