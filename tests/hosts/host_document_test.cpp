// The bridge to a document, with filters made for this test; compiled for each generation of MeshLab.
#include <meshlab/host_document.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace
{

using plugin::Effect;

using Runner = plugin::FilterResult (*)(const plugin::InputLayer&);

plugin::FilterSpec filter(std::function<plugin::FilterResult(const plugin::InputLayer&, const recon::Progress&)> run)
{
    plugin::FilterSpec spec;
    spec.name = "Test";
    spec.parameters = [] { return std::vector<plugin::ParameterDeclaration>(); };
    spec.run = [run](const plugin::InputLayer& layer, const plugin::ParameterValues&, const recon::Progress& progress)
    { return run(layer, progress); };
    return spec;
}

/// A layer of five vertices, the second deleted, the last selected.
MeshModel& add_layer(MeshDocument& document)
{
    MeshModel& model = *document.addNewMesh(QString(), "cloud.ply", true);
    vcg::tri::Allocator<CMeshO>::AddVertices(model.cm, 5);
    for (int i = 0; i < 5; ++i)
    {
        model.cm.vert[i].P() = Point3m(Scalarm(i), Scalarm(i * i), 1);
        model.cm.vert[i].N() = Point3m(0, 0, 1);
    }
    vcg::tri::Allocator<CMeshO>::DeleteVertex(model.cm, model.cm.vert[1]);
    model.cm.vert[4].SetS();
    model.cm.Tr.SetTranslate(Point3m(1, 2, 3));
    vcg::tri::UpdateBounding<CMeshO>::Box(model.cm);
    return model;
}

recon::TriangleMesh tetrahedron()
{
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}, {1, 2, 4, 0}};
}

recon::Vector to_vector(const Point3m& p)
{
    return {double(p[0]), double(p[1]), double(p[2])};
}

int number_of_layers(const MeshDocument& document)
{
    int layers = 0;
    for (int id = 0; id < 10; ++id)
        layers += document.getMesh(id) ? 1 : 0;
    return layers;
}

plugin::FilterResult run(const plugin::FilterSpec& spec, MeshDocument& document)
{
    return plugin::run_on_document(spec, RichParameterList(), document, nullptr);
}

} // namespace

TEST(HostDocument, FilterSeesLiveVerticesOnly)
{
    MeshDocument document;
    MeshModel& model = add_layer(document);
    model.updateDataMask(MeshModel::MM_VERTCOLOR | MeshModel::MM_VERTQUALITY);
    model.cm.vert[2].C() = vcg::Color4b(1, 2, 3, 4);
    model.cm.vert[2].Q() = 0.5;
    plugin::InputLayer seen;
    run(filter(
            [&](const plugin::InputLayer& layer, const recon::Progress&)
            {
                seen = layer;
                return plugin::FilterResult();
            }),
        document);
    EXPECT_EQ(seen.name, "cloud.ply");
    ASSERT_EQ(seen.points.size(), 4u);
    EXPECT_EQ(seen.points[1], recon::Point(2, 4, 1));
    EXPECT_EQ(seen.normals[1], recon::Vector(0, 0, 1));
    EXPECT_EQ(seen.selected, (std::vector<char>{0, 0, 0, 1}));
    ASSERT_EQ(seen.colours.size(), 4u);
    EXPECT_EQ(seen.colours[1], (plugin::Colour{1, 2, 3, 4}));
    ASSERT_EQ(seen.quality.size(), 4u);
    EXPECT_EQ(seen.quality[1], 0.5);
    EXPECT_TRUE(seen.radii.empty());
}

TEST(HostDocument, WritesRadiiToBothPlacesAndReadsEither)
{
    MeshDocument document;
    MeshModel& model = add_layer(document);
    std::vector<double> radii_before;
    const auto add_one = filter(
        [&](const plugin::InputLayer& layer, const recon::Progress&)
        {
            radii_before = layer.radii;
            plugin::FilterResult result;
            result.changed.vertices = {0, 1, 2, 3};
            for (int i = 0; i < 4; ++i)
                result.changed.radii.push_back((layer.radii.empty() ? 0 : layer.radii[i]) + 1 + i);
            return result;
        });
    run(add_one, document);
    EXPECT_TRUE(radii_before.empty());
    EXPECT_TRUE(model.hasDataMask(MeshModel::MM_VERTRADIUS));
    EXPECT_EQ(model.cm.vert[2].R(), Scalarm(2));
    auto radius = vcg::tri::Allocator<CMeshO>::FindPerVertexAttribute<Scalarm>(model.cm, "radius");
    ASSERT_TRUE(vcg::tri::Allocator<CMeshO>::IsValidHandle(model.cm, radius));
    EXPECT_EQ(radius[model.cm.vert[2]], Scalarm(2));
    run(add_one, document);
    EXPECT_EQ(radii_before, (std::vector<double>{1, 2, 3, 4}));
    vcg::tri::Allocator<CMeshO>::DeletePerVertexAttribute(model.cm, "radius");
    run(add_one, document);
    EXPECT_EQ(radii_before, (std::vector<double>{2, 4, 6, 8})); // of the component
}

TEST(HostDocument, LeavesAnAttributeOfAUserThatIsCalledRadiusButHoldsSomethingElse)
{
    MeshDocument document;
    MeshModel& model = add_layer(document);
    auto letters = vcg::tri::Allocator<CMeshO>::AddPerVertexAttribute<char>(model.cm, "radius");
    for (CVertexO& vertex : model.cm.vert)
        letters[vertex] = 'r';
    std::vector<double> radii_before;
    const auto write = filter(
        [&](const plugin::InputLayer& layer, const recon::Progress&)
        {
            radii_before = layer.radii;
            plugin::FilterResult result;
            result.changed.vertices = {0, 1, 2, 3};
            result.changed.radii = {1, 2, 3, 4};
            return result;
        });
    run(write, document);
    EXPECT_TRUE(radii_before.empty());
    for (const CVertexO& vertex : model.cm.vert)
        EXPECT_EQ(letters[vertex], 'r');
    run(write, document);
    EXPECT_EQ(radii_before, (std::vector<double>{1, 2, 3, 4})); // of the component
}

TEST(HostDocument, ChangesVerticesInPlace)
{
    MeshDocument document;
    MeshModel& model = add_layer(document);
    run(filter(
            [](const plugin::InputLayer&, const recon::Progress&)
            {
                plugin::FilterResult result;
                result.changed.vertices = {1, 3};
                result.changed.points = {{10, 0, 0}, {20, 0, 0}};
                result.changed.normals = {{1, 0, 0}, {0, 1, 0}};
                result.changed.quality = {5, 6};
                result.changed.colours = {{9, 8, 7, 6}, {5, 4, 3, 2}};
                result.changed.selected = {1, 0};
                return result;
            }),
        document);
    EXPECT_EQ(number_of_layers(document), 1);
    EXPECT_EQ(model.cm.vert[2].P(), Point3m(10, 0, 0));
    EXPECT_EQ(model.cm.vert[4].P(), Point3m(20, 0, 0));
    EXPECT_EQ(model.cm.vert[3].P(), Point3m(3, 9, 1));
    EXPECT_EQ(model.cm.vert[2].N(), Point3m(1, 0, 0));
    EXPECT_EQ(model.cm.vert[4].Q(), Scalarm(6));
    EXPECT_EQ(model.cm.vert[2].C(), vcg::Color4b(9, 8, 7, 6));
    EXPECT_TRUE(model.cm.vert[2].IsS());
    EXPECT_FALSE(model.cm.vert[4].IsS());
    EXPECT_TRUE(model.hasDataMask(MeshModel::MM_VERTCOLOR));
    EXPECT_TRUE(model.hasDataMask(MeshModel::MM_VERTQUALITY));
    EXPECT_EQ(model.cm.bbox.max[0], Scalarm(20));
}

TEST(HostDocument, AppendsVertices)
{
    MeshDocument document;
    MeshModel& model = add_layer(document);
    model.updateDataMask(MeshModel::MM_VERTCOLOR);
    model.cm.vert[3].C() = vcg::Color4b(1, 2, 3, 4);
    run(filter(
            [](const plugin::InputLayer&, const recon::Progress&)
            {
                plugin::FilterResult result;
                result.changed.vertices = {0};
                result.changed.points = {{-7, 0, 0}};
                result.appended.points = {{100, 0, 0}, {200, 0, 0}};
                result.appended.normals = {{1, 0, 0}, {0, 1, 0}};
                result.appended.source = {2, -1};
                result.appended.radii = {0.5, 0.25};
                result.appended.selected = true;
                return result;
            }),
        document);
    EXPECT_EQ(model.cm.vn, 6);
    EXPECT_EQ(model.cm.vert[0].P(), Point3m(-7, 0, 0));
    EXPECT_EQ(model.cm.vert[5].P(), Point3m(100, 0, 0));
    EXPECT_EQ(model.cm.vert[6].N(), Point3m(0, 1, 0));
    EXPECT_EQ(model.cm.vert[5].C(), vcg::Color4b(1, 2, 3, 4));
    EXPECT_EQ(model.cm.vert[6].C(), vcg::Color4b(255, 255, 255, 255));
    EXPECT_EQ(model.cm.vert[6].R(), Scalarm(0.25));
    EXPECT_TRUE(model.cm.vert[5].IsS());
    EXPECT_EQ(model.cm.bbox.max[0], Scalarm(200));
}

TEST(HostDocument, NewLayerHasFacesFauxEdgesNormalsAndTheTransform)
{
    MeshDocument document;
    MeshModel& model = add_layer(document);
    run(filter(
            [](const plugin::InputLayer&, const recon::Progress&)
            {
                plugin::FilterResult result;
                plugin::NewLayer layer;
                layer.name = "made";
                layer.mesh = tetrahedron();
                result.new_layers = {layer};
                return result;
            }),
        document);
    EXPECT_EQ(number_of_layers(document), 2);
    MeshModel& made = *document.mm();
    EXPECT_NE(&made, &model);
    EXPECT_EQ(made.label(), QString("made"));
    EXPECT_EQ(made.cm.vn, 4);
    ASSERT_EQ(made.cm.fn, 4);
    EXPECT_TRUE(made.cm.face[0].IsF(0));
    EXPECT_FALSE(made.cm.face[0].IsF(1));
    EXPECT_TRUE(made.cm.face[1].IsF(1));
    EXPECT_TRUE(made.cm.face[2].IsF(2));
    EXPECT_NEAR(made.cm.face[0].N()[2], -1, 1e-6);
    EXPECT_NEAR(made.cm.vert[0].N().Norm(), 1, 1e-6);
    EXPECT_LT(made.cm.vert[0].N()[0], 0);
    EXPECT_EQ(made.cm.Tr[1][3], Scalarm(2));
    EXPECT_EQ(made.cm.bbox.max[2], Scalarm(1));
    EXPECT_FALSE(made.hasDataMask(MeshModel::MM_VERTCOLOR));
}

TEST(HostDocument, NormalsDoNotDependOnTheScale)
{
    for (const double scale : {1e-30, 1.0, 1e30}) // in single precision the squares of both ends are lost
    {
        MeshDocument document;
        add_layer(document);
        plugin::FilterResult result;
        result.new_layers.emplace_back().mesh = tetrahedron();
        for (recon::Point& p : result.new_layers[0].mesh.vertices)
            p *= scale;
        run(filter([&](const plugin::InputLayer&, const recon::Progress&) { return result; }), document);
        const CMeshO& made = document.mm()->cm;
        ASSERT_EQ(made.fn, 4);
        EXPECT_NEAR(made.face[3].cN()[0], std::sqrt(1 / 3.0), 1e-6);
        EXPECT_NEAR(made.vert[0].cN()[2], -std::sqrt(1 / 3.0), 1e-6);
        const double apex = std::atan(1.0), slanted = 4 * apex / 3; // angles of the two kinds of faces at corner 3
        const recon::Vector expected =
            (recon::Vector(-apex, -apex, 0) + slanted / std::sqrt(3.0) * recon::Vector(1, 1, 1)).normalized();
        EXPECT_LT((to_vector(made.vert[3].cN()) - expected).norm(), 1e-6);
    }
}

TEST(HostDocument, NothingIsWrittenWhenTheFilterThrows)
{
    MeshDocument document;
    MeshModel& model = add_layer(document);
    const auto failing = filter([](const plugin::InputLayer&, const recon::Progress&) -> plugin::FilterResult
                                { throw recon::AlgorithmFailure("no"); });
    EXPECT_THROW(run(failing, document), recon::AlgorithmFailure);
    EXPECT_EQ(number_of_layers(document), 1);
    EXPECT_EQ(document.mm(), &model);
}

TEST(HostDocument, NothingIsWrittenOfAnInconsistentResult)
{
    const std::vector<Runner> wrong = {
        [](const plugin::InputLayer&)
        {
            plugin::FilterResult result;
            result.changed.vertices = {0, 4}; // there are 4
            result.changed.points = {{9, 9, 9}, {9, 9, 9}};
            return result;
        },
        [](const plugin::InputLayer&)
        {
            plugin::FilterResult result;
            result.changed.vertices = {0};
            result.changed.points = {{9, 9, 9}};
            result.changed.normals = {{0, 0, 1}, {0, 0, 1}};
            return result;
        },
        [](const plugin::InputLayer&)
        {
            plugin::FilterResult result;
            result.changed.vertices = {0};
            result.changed.points = {{9, 9, 9}};
            result.new_layers.emplace_back().mesh = {{{0, 0, 0}}, {{0, 0, 1}}, {}};
            return result;
        },
        [](const plugin::InputLayer&)
        {
            plugin::FilterResult result;
            result.changed.vertices = {0};
            result.changed.points = {{9, 9, 9}};
            result.appended.points = {{1, 1, 1}};
            result.appended.source = {4};
            return result;
        },
    };
    for (const Runner runner : wrong)
    {
        MeshDocument document;
        MeshModel& model = add_layer(document);
        EXPECT_THROW(run(filter([&](const plugin::InputLayer& layer, const recon::Progress&) { return runner(layer); }),
                         document),
                     std::logic_error);
        EXPECT_EQ(model.cm.vert[0].P(), Point3m(0, 0, 1));
        EXPECT_EQ(model.cm.vn, 4);
        EXPECT_EQ(number_of_layers(document), 1);
    }
}

TEST(HostDocument, ADocumentWithoutLayersIsRefused)
{
    MeshDocument document;
    EXPECT_THROW(
        run(filter([](const plugin::InputLayer&, const recon::Progress&) { return plugin::FilterResult(); }), document),
        recon::InvalidInput);
}

TEST(HostDocument, LengthsGoUpToTheDiagonalOfTheFinitePoints)
{
    plugin::FilterSpec spec;
    spec.parameters = []
    {
        plugin::ParameterDeclaration length;
        length.name = "length";
        length.kind = plugin::ParameterKind::length;
        return std::vector<plugin::ParameterDeclaration>{length};
    };
    MeshDocument document;
    EXPECT_EQ(dynamic_cast<const RichLength&>(plugin::rich_parameters(spec, document).at(0)).max, Scalarm(1));
    MeshModel& model = add_layer(document);
    for (CVertexO& vertex : model.cm.vert)
        vertex.P() = Point3m(0, 0, 0);
    model.cm.vert[1].P() = Point3m(100, 0, 0); // deleted
    model.cm.vert[2].P() = Point3m(3, 4, 0);
    model.cm.vert[3].P()[0] = std::numeric_limits<Scalarm>::quiet_NaN();
    model.cm.vert[4].P()[1] = std::numeric_limits<Scalarm>::infinity();
    EXPECT_EQ(dynamic_cast<const RichLength&>(plugin::rich_parameters(spec, document).at(0)).max, Scalarm(5));
}

TEST(HostDocument, TooltipsAreTextThatBreaksItsLines)
{
    plugin::FilterSpec spec;
    spec.parameters = []
    {
        plugin::ParameterDeclaration flag;
        flag.name = "flag";
        flag.tooltip = "a < b & c";
        flag.kind = plugin::ParameterKind::flag;
        flag.default_value = true;
        return std::vector<plugin::ParameterDeclaration>{flag};
    };
    MeshDocument document;
    EXPECT_EQ(plugin::rich_parameters(spec, document).at(0).toolTip(), QString("<p>a &lt; b &amp; c</p>"));
}

TEST(HostDocument, TheCallbackHearsWholePerCentsAndCancels)
{
    static std::vector<int> heard;
    heard.clear();
    MeshDocument document;
    add_layer(document);
    const auto slow = filter(
        [](const plugin::InputLayer&, const recon::Progress& progress)
        {
            for (int i = 0; i <= 1000; ++i)
                progress.report(i / 1000.0);
            return plugin::FilterResult();
        });
    plugin::run_on_document(slow, RichParameterList(), document,
                            [](const int per_cent, const char*)
                            {
                                heard.push_back(per_cent);
                                return true;
                            });
    EXPECT_LE(heard.size(), 102u);
    EXPECT_EQ(heard.back(), 100);
    const auto stop = [](const int per_cent, const char*) { return per_cent < 50; };
    EXPECT_THROW(plugin::run_on_document(slow, RichParameterList(), document, stop), recon::Cancelled);
}

TEST(HostDocument, MasksNameWhatChanges)
{
    plugin::FilterSpec spec;
    spec.effects = Effect::moves_vertices | Effect::changes_quality;
    const int mask = plugin::changed_elements(spec);
    EXPECT_TRUE(mask & MeshModel::MM_VERTCOORD);
    EXPECT_TRUE(mask & MeshModel::MM_VERTQUALITY);
    EXPECT_FALSE(mask & MeshModel::MM_VERTCOLOR);
    EXPECT_FALSE(mask & MeshModel::MM_FACENUMBER);
}
