#include "fake_values.h"

#include <gtest/gtest.h>

namespace
{

enum class Colour
{
    red,
    green,
    blue
};

struct Inner
{
    double tolerance = 1e-4;
};

struct Base
{
    double factor = 0.7;
    std::optional<double> radius;
};

struct Options : Base
{
    double length = 0.25;
    int steps = 30;
    Colour colour = Colour::green;
    bool fast = true;
    std::string layer = "result";
    Inner inner;
};

plugin::ParameterTable<Options> table()
{
    return plugin::ParameterTable<Options>()
        .number("factor", &Options::factor, "Factor", "")
        .length("radius", &Options::radius, "Radius", "")
        .length("length", &Options::length, "Length", "")
        .count("steps", &Options::steps, "Steps", "")
        .choice("colour", &Options::colour, {"red", "green", "blue"}, "Colour", "")
        .flag("fast", &Options::fast, "Fast", "")
        .text("layer", &Options::layer, "Layer", "")
        .number(
            "tolerance", [](Options& o) -> double& { return o.inner.tolerance; }, "Tolerance", "");
}

} // namespace

TEST(ParameterTable, DeclaresTheDefaultsOfTheStruct)
{
    const auto declared = table().declare();
    ASSERT_EQ(declared.size(), 8u);
    EXPECT_EQ(std::get<double>(declared[0].default_value), Options().factor);
    EXPECT_EQ(std::get<double>(declared[1].default_value), 0.0); // not set
    EXPECT_EQ(std::get<double>(declared[2].default_value), Options().length);
    EXPECT_EQ(std::get<int>(declared[3].default_value), Options().steps);
    EXPECT_EQ(std::get<int>(declared[4].default_value), 1);
    EXPECT_EQ(std::get<bool>(declared[5].default_value), Options().fast);
    EXPECT_EQ(std::get<std::string>(declared[6].default_value), Options().layer);
    EXPECT_EQ(std::get<double>(declared[7].default_value), Options().inner.tolerance);
    EXPECT_EQ(declared[1].kind, plugin::ParameterKind::length);
    EXPECT_EQ(declared[4].choices, (std::vector<std::string>{"red", "green", "blue"}));
}

TEST(ParameterTable, DefaultsComeBackExactlyThrough32Bits)
{
    const Options read = table().read(FakeValues(table().declare()));
    EXPECT_EQ(read.factor, 0.7);
    EXPECT_FALSE(read.radius.has_value());
    EXPECT_EQ(read.length, 0.25);
    EXPECT_EQ(read.steps, 30);
    EXPECT_EQ(read.colour, Colour::green);
    EXPECT_TRUE(read.fast);
    EXPECT_EQ(read.layer, "result");
    EXPECT_EQ(read.inner.tolerance, 1e-4);
}

TEST(ParameterTable, ReadsWhatTheUserHasChosen)
{
    const FakeValues values(table().declare(), {{"factor", 0.3},
                                                {"radius", 2.5},
                                                {"length", 1e-9},
                                                {"steps", 7},
                                                {"colour", 2},
                                                {"fast", false},
                                                {"layer", std::string("x")},
                                                {"tolerance", 0.001}});
    const Options read = table().read(values);
    EXPECT_EQ(read.factor, 0.3);
    EXPECT_EQ(read.radius, 2.5);
    EXPECT_EQ(read.length, 1e-9);
    EXPECT_EQ(read.steps, 7);
    EXPECT_EQ(read.colour, Colour::blue);
    EXPECT_FALSE(read.fast);
    EXPECT_EQ(read.layer, "x");
    EXPECT_EQ(read.inner.tolerance, 0.001);
}

TEST(ParameterTable, WhatAScriptDoesNotKnowKeepsItsDefault)
{
    FakeValues values(table().declare(), {{"steps", 7}});
    for (const char* name : {"factor", "radius", "length", "colour", "fast", "layer", "tolerance"})
        values.forget(name);
    const Options read = table().read(values);
    EXPECT_EQ(read.steps, 7);
    EXPECT_EQ(read.factor, Options().factor);
    EXPECT_EQ(read.colour, Options().colour);
    EXPECT_EQ(read.layer, Options().layer);
}

TEST(ParameterTable, RefusesAChoiceThatDoesNotExist)
{
    for (const int choice : {-1, 3})
        EXPECT_THROW(table().read(FakeValues(table().declare(), {{"colour", choice}})), recon::InvalidInput);
}

TEST(TypedDecimal, UndoesTheRoundingTo32Bits)
{
    for (const double typed : {0.7, 0.1, 1e-4, 123.456, 0.0, -2.5, 1e30, 16777216.0})
        EXPECT_EQ(plugin::typed_decimal(static_cast<float>(typed)), typed);
}
