#include "fake_values.h"

#include "../../checks.h"
#include "../../shapes.h"

#include <meshlab/filter_spec.h>

#include <gtest/gtest.h>

#include <set>

namespace
{

plugin::FilterSpec filter()
{
    return plugin::describe_plugin().filters.at(0);
}

plugin::InputLayer layer_of(const recon::Points& points)
{
    plugin::InputLayer layer;
    layer.name = "cloud.ply";
    layer.points = points;
    layer.normals.assign(points.size(), recon::Vector::Zero());
    layer.selected.assign(points.size(), 0);
    return layer;
}

} // namespace

TEST(NoisyPowerCrustPlugin, NamesAndParametersAreFrozen)
{
    const plugin::FilterSpec spec = filter();
    EXPECT_EQ(spec.name, "Surface Reconstruction: Noisy Power Crust");
    EXPECT_EQ(spec.python_name, "generate_surface_reconstruction_noisy_power_crust");
    std::set<std::string> names;
    for (const auto& parameter : spec.parameters())
    {
        EXPECT_FALSE(parameter.label.empty());
        EXPECT_FALSE(parameter.tooltip.empty());
        names.insert(parameter.name);
    }
    for (const char* name :
         {"ball_threshold", "noise", "deep_intersection", "keep_components", "selected_only", "threads"})
        EXPECT_EQ(names.count(name), 1u) << name;
}

TEST(NoisyPowerCrustPlugin, MakesOneLayerThatTakesColourFromTheNearestUsedVertex)
{
    recon::Points points = shapes::with_noise(shapes::sphere(1500, 1, 1).points, 0.005, 2);
    points.insert(points.begin(), {50, 50, 50}); // not selected
    plugin::InputLayer layer = layer_of(points);
    layer.selected.assign(points.size(), 1);
    layer.selected[0] = 0;
    const plugin::FilterSpec spec = filter();
    const FakeValues values(spec.parameters(), {{"selected_only", true}});
    const plugin::FilterResult result = spec.run(layer, values, {});

    ASSERT_EQ(result.new_layers.size(), 1u);
    const plugin::NewLayer& made = result.new_layers[0];
    EXPECT_TRUE(result.changed.vertices.empty());
    EXPECT_TRUE(result.appended.points.empty());
    EXPECT_TRUE(checks::examine_mesh(made.mesh).is_closed_oriented_manifold());
    ASSERT_EQ(made.source.size(), made.mesh.vertices.size());
    for (std::size_t i = 0; i < made.source.size(); i += 97)
    {
        int nearest = 1;
        for (std::size_t j = 1; j < points.size(); ++j)
            if ((points[j] - made.mesh.vertices[i]).squaredNorm() <
                (points[nearest] - made.mesh.vertices[i]).squaredNorm())
                nearest = static_cast<int>(j);
        EXPECT_EQ(made.source[i], nearest);
    }
}

TEST(NoisyPowerCrustPlugin, RefusesAnEmptySelection)
{
    const plugin::FilterSpec spec = filter();
    const FakeValues values(spec.parameters(), {{"selected_only", true}});
    EXPECT_THROW(spec.run(layer_of(shapes::sphere(100, 1, 1).points), values, {}), recon::InvalidInput);
}
