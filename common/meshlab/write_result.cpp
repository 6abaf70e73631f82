#include "write_result.h"

#include "read_layer.h"

#include <Eigen/Geometry>

#include <cmath>
#include <set>
#include <stdexcept>

namespace plugin
{
namespace
{

using Allocator = vcg::tri::Allocator<CMeshO>;

Point3m from_point(const recon::Point& p)
{
    return Point3m(static_cast<Scalarm>(p.x()), static_cast<Scalarm>(p.y()), static_cast<Scalarm>(p.z()));
}

vcg::Color4b from_colour(const Colour& c)
{
    return vcg::Color4b(c[0], c[1], c[2], c[3]);
}

/// Values that go to vertices; each is empty or has one entry per vertex.
struct VertexValues
{
    const recon::Points* points = nullptr;
    const recon::Vectors* normals = nullptr;
    const std::vector<Colour>* colours = nullptr;
    const std::vector<double>* quality = nullptr;
    const std::vector<double>* radii = nullptr;
    const std::vector<char>* selected = nullptr;
};

/// Makes room for the values. The only step that may fail for lack of memory.
void enable_components(MeshModel& model, const VertexValues& values)
{
    int mask = 0;
    if (values.normals && !values.normals->empty())
        mask |= MeshModel::MM_VERTNORMAL;
    if (values.colours && !values.colours->empty())
        mask |= MeshModel::MM_VERTCOLOR;
    if (values.quality && !values.quality->empty())
        mask |= MeshModel::MM_VERTQUALITY;
    if (values.radii && !values.radii->empty())
    {
        mask |= MeshModel::MM_VERTRADIUS;
        if (!find_radius_attribute(model.cm)) // another of a user's stays
            Allocator::AddPerVertexAttribute<Scalarm>(model.cm, radius_attribute);
    }
    if (mask != 0)
        model.updateDataMask(mask);
}

void write_values(MeshModel& model, const std::vector<CVertexO*>& vertices, const VertexValues& values)
{
    enable_components(model, values);
    const std::size_t n = vertices.size();
    if (values.points && !values.points->empty())
        for (std::size_t i = 0; i < n; ++i)
            vertices[i]->P() = from_point((*values.points)[i]);
    if (values.normals && !values.normals->empty())
        for (std::size_t i = 0; i < n; ++i)
            vertices[i]->N() = from_point((*values.normals)[i]);
    if (values.colours && !values.colours->empty())
        for (std::size_t i = 0; i < n; ++i)
            vertices[i]->C() = from_colour((*values.colours)[i]);
    if (values.quality && !values.quality->empty())
        for (std::size_t i = 0; i < n; ++i)
            vertices[i]->Q() = static_cast<Scalarm>((*values.quality)[i]);
    if (values.radii && !values.radii->empty())
    {
        Radii radii = find_radii(model.cm);
        const bool has_attribute = Allocator::IsValidHandle(model.cm, radii);
        for (std::size_t i = 0; i < n; ++i)
        {
            vertices[i]->R() = static_cast<Scalarm>((*values.radii)[i]);
            if (has_attribute)
                radii[vertices[i]] = static_cast<Scalarm>((*values.radii)[i]);
        }
    }
    if (values.selected && !values.selected->empty())
        for (std::size_t i = 0; i < n; ++i)
            (*values.selected)[i] ? vertices[i]->SetS() : vertices[i]->ClearS();
}

/// One value per entry of `source`, `missing` for -1; nothing if the input has none.
template <class T>
std::vector<T> values_of_sources(const std::vector<T>& input, const std::vector<int>& source, const T& missing)
{
    std::vector<T> values;
    if (input.empty() || source.empty())
        return values;
    values.reserve(source.size());
    for (int i : source)
        values.push_back(i < 0 ? missing : input.at(i));
    return values;
}

constexpr Colour white = {255, 255, 255, 255};

/// Sets the faces' normals and, on request, the vertices': the mean of their faces', weighted by the angle there. As
/// vcglib does, but in double precision and free of scale: squares of float coordinates overflow from 1e19.
void update_normals(CMeshO& mesh, bool of_vertices)
{
    std::vector<recon::Vector> sums(of_vertices ? mesh.vert.size() : 0, recon::Vector::Zero());
    for (CFaceO& face : mesh.face)
    {
        if (face.IsD())
            continue;
        std::array<recon::Vector, 3> edges; // edges[i] leads from corner i to the next
        for (int i = 0; i < 3; ++i)
            edges[i] = to_point(face.cP((i + 1) % 3)) - to_point(face.cP(i));
        for (recon::Vector& edge : edges)
            edge.stableNormalize();
        recon::Vector normal = edges[0].cross(edges[1]);
        normal.stableNormalize();
        face.N() = from_point(normal);
        if (of_vertices)
            for (int i = 0; i < 3; ++i)
            {
                const recon::Vector &out = edges[i], in = -edges[(i + 2) % 3];
                sums[vcg::tri::Index(mesh, face.V(i))] += std::atan2(out.cross(in).norm(), out.dot(in)) * normal;
            }
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
        mesh.vert[i].N() = from_point(sums[i].stableNormalized());
}

void fill_layer(MeshModel& model, const NewLayer& layer, const InputLayer& input, const Matrix44m& transform)
{
    CMeshO& mesh = model.cm;
    mesh.Tr = transform;
    const recon::TriangleMesh& source = layer.mesh;
    Allocator::AddVertices(mesh, source.vertices.size());
    const std::vector<CVertexO*> vertices = live_vertices(mesh);

    const auto source_colours = values_of_sources(input.colours, layer.source, white);
    const auto source_quality = values_of_sources(input.quality, layer.source, 0.0);
    VertexValues values;
    values.points = &source.vertices;
    values.normals = &layer.normals;
    values.colours = layer.colours.empty() ? &source_colours : &layer.colours;
    values.quality = layer.quality.empty() ? &source_quality : &layer.quality;
    values.radii = &layer.radii;
    write_values(model, vertices, values);

    if (!source.triangles.empty())
    {
        auto face = Allocator::AddFaces(mesh, source.triangles.size());
        for (const std::array<int, 3>& triangle : source.triangles)
        {
            for (int corner = 0; corner < 3; ++corner)
                face->V(corner) = vertices[triangle[corner]];
            ++face;
        }
        for (std::size_t i = 0; i < source.faux_edges.size(); ++i)
            for (int edge = 0; edge < 3; ++edge)
                if (source.faux_edges[i] >> edge & 1)
                    mesh.face[i].SetF(edge);
        for (const std::uint8_t faux : source.faux_edges)
            if (faux)
            {
                model.updateDataMask(MeshModel::MM_POLYGONAL);
                break;
            }
        update_normals(mesh, layer.normals.empty());
    }
    if (!layer.edges.empty())
    {
        auto edge = Allocator::AddEdges(mesh, layer.edges.size());
        for (const std::array<int, 2>& ends : layer.edges)
        {
            edge->V(0) = vertices[ends[0]];
            edge->V(1) = vertices[ends[1]];
            ++edge;
        }
    }
    vcg::tri::UpdateBounding<CMeshO>::Box(mesh);
}

void append_vertices(MeshModel& model, const AppendedVertices& appended, const InputLayer& input)
{
    if (appended.points.empty())
        return;
    CMeshO& mesh = model.cm;
    const auto source_colours = values_of_sources(input.colours, appended.source, white);
    const auto source_quality = values_of_sources(input.quality, appended.source, 0.0);
    const std::vector<char> selected(appended.points.size(), appended.selected ? 1 : 0);
    VertexValues values;
    values.points = &appended.points;
    values.normals = &appended.normals;
    values.colours = appended.colours.empty() ? &source_colours : &appended.colours;
    values.quality = appended.quality.empty() ? &source_quality : &appended.quality;
    values.radii = &appended.radii;
    values.selected = &selected;
    enable_components(model, values);

    std::vector<CVertexO*> vertices;
    vertices.reserve(appended.points.size());
    const std::size_t first = mesh.vert.size();
    Allocator::AddVertices(mesh, appended.points.size());
    for (std::size_t i = first; i < mesh.vert.size(); ++i)
        vertices.push_back(&mesh.vert[i]);
    write_values(model, vertices, values);
}

void change_vertices(MeshModel& model, const ChangedVertices& changed)
{
    CMeshO& mesh = model.cm;
    const std::vector<CVertexO*> all = live_vertices(mesh);
    std::vector<CVertexO*> vertices;
    vertices.reserve(changed.vertices.size());
    for (int i : changed.vertices)
        vertices.push_back(all[i]);
    VertexValues values;
    values.points = &changed.points;
    values.normals = &changed.normals;
    values.colours = &changed.colours;
    values.quality = &changed.quality;
    values.radii = &changed.radii;
    values.selected = &changed.selected;
    write_values(model, vertices, values);
    if (!changed.points.empty())
        update_normals(mesh, false);
}

void remove_vertices(MeshModel& model, const std::vector<int>& removed)
{
    if (removed.empty())
        return;
    CMeshO& mesh = model.cm;
    const std::vector<CVertexO*> all = live_vertices(mesh);
    std::vector<char> doomed(mesh.vert.size(), 0);
    for (int i : removed)
        doomed[static_cast<std::size_t>(all[i] - &mesh.vert[0])] = 1;
    const auto is_doomed = [&](const CVertexO* v) { return doomed[static_cast<std::size_t>(v - &mesh.vert[0])] != 0; };
    for (CFaceO& face : mesh.face)
        if (!face.IsD())
            for (int corner = 0; corner < 3; ++corner)
                if (is_doomed(face.V(corner)))
                {
                    Allocator::DeleteFace(mesh, face);
                    break;
                }
    for (auto& edge : mesh.edge)
        if (!edge.IsD() && (is_doomed(edge.V(0)) || is_doomed(edge.V(1))))
            Allocator::DeleteEdge(mesh, edge);
    for (std::size_t i = 0; i < doomed.size(); ++i)
        if (doomed[i])
            Allocator::DeleteVertex(mesh, mesh.vert[i]);
    Allocator::CompactEveryVector(mesh);
}

void require(bool condition, const char* what)
{
    if (!condition)
        throw std::logic_error(std::string("inconsistent filter result: ") + what);
}

template <class T>
bool empty_or(const std::vector<T>& values, std::size_t n)
{
    return values.empty() || values.size() == n;
}

void require_indices(const std::vector<int>& indices, int lowest, std::size_t n, const char* what)
{
    for (int i : indices)
        require(i >= lowest && i < static_cast<int>(n), what);
}

/// Everything is checked before the first write.
void check(const FilterResult& result, const InputLayer& input)
{
    const std::size_t inputs = input.points.size();
    for (const NewLayer& layer : result.new_layers)
    {
        const std::size_t n = layer.mesh.vertices.size();
        require(empty_or(layer.source, n) && empty_or(layer.normals, n) && empty_or(layer.colours, n) &&
                    empty_or(layer.quality, n) && empty_or(layer.radii, n),
                "new layer, values per vertex");
        require(empty_or(layer.mesh.faux_edges, layer.mesh.triangles.size()), "new layer, faux edges");
        require_indices(layer.source, -1, inputs, "new layer, sources");
        for (const std::array<int, 3>& triangle : layer.mesh.triangles)
            for (int corner : triangle)
                require(corner >= 0 && corner < static_cast<int>(n), "new layer, triangles");
        for (const std::array<int, 2>& edge : layer.edges)
            for (int end : edge)
                require(end >= 0 && end < static_cast<int>(n), "new layer, edges");
    }
    const ChangedVertices& changed = result.changed;
    const std::size_t n = changed.vertices.size();
    require(empty_or(changed.points, n) && empty_or(changed.normals, n) && empty_or(changed.colours, n) &&
                empty_or(changed.quality, n) && empty_or(changed.radii, n) && empty_or(changed.selected, n),
            "changed vertices, values per vertex");
    require_indices(changed.vertices, 0, inputs, "changed vertices");
    require_indices(result.removed, 0, inputs, "removed vertices");
    require(std::set<int>(result.removed.begin(), result.removed.end()).size() == result.removed.size(),
            "removed vertices, repeated");
    const AppendedVertices& appended = result.appended;
    const std::size_t m = appended.points.size();
    require(empty_or(appended.normals, m) && empty_or(appended.source, m) && empty_or(appended.colours, m) &&
                empty_or(appended.quality, m) && empty_or(appended.radii, m),
            "appended vertices, values per vertex");
    require_indices(appended.source, -1, inputs, "appended vertices, sources");
}

} // namespace

void write_result(MeshDocument& document, MeshModel& current, const FilterResult& result, const InputLayer& input)
{
    check(result, input);
    // New layers first: if memory runs out, they are the ones that can be taken back.
    const Matrix44m transform = current.cm.Tr;
    std::vector<MeshModel*> made;
    try
    {
        for (const NewLayer& layer : result.new_layers)
        {
            made.push_back(document.addNewMesh(QString(), QString::fromStdString(layer.name), true));
            fill_layer(*made.back(), layer, input, transform);
        }
    }
    catch (...)
    {
        document.setCurrentMesh(current.id());
        for (MeshModel* model : made)
            remove_layer(document, *model);
        throw;
    }
    // Changed, then removed, then appended: each moves the vertices in memory or renumbers them.
    if (!result.changed.vertices.empty())
        change_vertices(current, result.changed);
    remove_vertices(current, result.removed);
    append_vertices(current, result.appended, input);
    if (!result.changed.points.empty() || !result.appended.points.empty() || !result.removed.empty())
        vcg::tri::UpdateBounding<CMeshO>::Box(current.cm);
}

} // namespace plugin
