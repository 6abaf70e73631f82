#include "host_document.h"

#include <recon/errors.h>

#include <Eigen/LU>

#include <cmath>
#include <limits>
#include <set>

namespace plugin
{
namespace
{

constexpr char radius_attribute[] = "radius"; // the name that MeshLab's own filters use

using Allocator = vcg::tri::Allocator<CMeshO>;
using Radii = CMeshO::PerVertexAttributeHandle<Scalarm>;

recon::Point to_point(const Point3m& p)
{
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

Point3m from_point(const recon::Point& p)
{
    return Point3m(static_cast<Scalarm>(p.x()), static_cast<Scalarm>(p.y()), static_cast<Scalarm>(p.z()));
}

vcg::Color4b from_colour(const Colour& c)
{
    return vcg::Color4b(c[0], c[1], c[2], c[3]);
}

/// The vertices in the order in which the filter sees them.
std::vector<CVertexO*> live_vertices(CMeshO& mesh)
{
    std::vector<CVertexO*> vertices;
    vertices.reserve(mesh.vn);
    for (CVertexO& vertex : mesh.vert)
        if (!vertex.IsD())
            vertices.push_back(&vertex);
    return vertices;
}

InputLayer read_layer(MeshModel& model)
{
    CMeshO& mesh = model.cm;
    const std::vector<CVertexO*> vertices = live_vertices(mesh);
    const std::size_t n = vertices.size();

    InputLayer layer;
    layer.name = model.label().toStdString();
    layer.faces = mesh.fn;
    layer.points.reserve(n);
    layer.normals.reserve(n);
    layer.selected.reserve(n);
    for (const CVertexO* v : vertices)
    {
        layer.points.push_back(to_point(v->cP()));
        layer.normals.push_back(to_point(v->cN()));
        layer.selected.push_back(v->IsS() ? 1 : 0);
    }
    if (model.hasDataMask(MeshModel::MM_VERTCOLOR))
        for (const CVertexO* v : vertices)
            layer.colours.push_back({v->cC()[0], v->cC()[1], v->cC()[2], v->cC()[3]});
    if (model.hasDataMask(MeshModel::MM_VERTQUALITY))
        for (const CVertexO* v : vertices)
            layer.quality.push_back(static_cast<double>(v->cQ()));
    Radii radii = Allocator::FindPerVertexAttribute<Scalarm>(mesh, radius_attribute);
    if (Allocator::IsValidHandle(mesh, radii))
        for (const CVertexO* v : vertices)
            layer.radii.push_back(static_cast<double>(radii[v]));
    else if (model.hasDataMask(MeshModel::MM_VERTRADIUS))
        for (const CVertexO* v : vertices)
            layer.radii.push_back(static_cast<double>(v->cR()));
    return layer;
}

/// The layer of that name among the others, moved from its own coordinates to those of `current`.
InputLayer read_other_layer(MeshDocument& document, const MeshModel& current, const std::string& name)
{
    MeshModel* found = nullptr;
    std::string names;
    int count = 0;
    for (MeshModel* model : layers_of(document))
    {
        const std::string label = model->label().toStdString();
        names += (names.empty() ? "'" : ", '") + label + "'";
        if (label == name)
        {
            found = model;
            ++count;
        }
    }
    if (count != 1)
        throw recon::InvalidInput((count == 0 ? "There is no layer named '" : "More than one layer is named '") + name +
                                  "'. The layers are " + names + ".");
    InputLayer layer = read_layer(*found);
    const Matrix44m& from = found->cm.Tr;
    const Matrix44m& to = current.cm.Tr;
    Eigen::Matrix4d a, b;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
        {
            a(i, j) = static_cast<double>(from.ElementAt(i, j));
            b(i, j) = static_cast<double>(to.ElementAt(i, j));
        }
    if (a == b)
        return layer;
    const Eigen::Matrix4d move = b.inverse() * a;
    const Eigen::Matrix3d linear = move.topLeftCorner<3, 3>();
    const Eigen::Vector3d shift = move.topRightCorner<3, 1>();
    const Eigen::Matrix3d of_normals = linear.inverse().transpose();
    if (!of_normals.allFinite())
        throw recon::InvalidInput("The transform of a layer cannot be inverted. Freeze or reset it first.");
    for (recon::Point& p : layer.points)
        p = linear * p + shift;
    for (recon::Vector& n : layer.normals)
        n = (of_normals * n).eval();
    return layer;
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
        Allocator::GetPerVertexAttribute<Scalarm>(model.cm, radius_attribute);
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
        Radii radii = Allocator::GetPerVertexAttribute<Scalarm>(model.cm, radius_attribute);
        for (std::size_t i = 0; i < n; ++i)
        {
            vertices[i]->R() = static_cast<Scalarm>((*values.radii)[i]);
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
        vcg::tri::UpdateNormal<CMeshO>::PerFaceNormalized(mesh);
        if (layer.normals.empty())
        {
            vcg::tri::UpdateNormal<CMeshO>::PerVertexAngleWeighted(mesh);
            vcg::tri::UpdateNormal<CMeshO>::NormalizePerVertex(mesh);
        }
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
    if (!changed.points.empty() && mesh.fn > 0)
        vcg::tri::UpdateNormal<CMeshO>::PerFaceNormalized(mesh);
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
    for (CFaceO& face : mesh.face)
        if (!face.IsD())
            for (int corner = 0; corner < 3; ++corner)
                if (doomed[static_cast<std::size_t>(face.V(corner) - &mesh.vert[0])])
                {
                    Allocator::DeleteFace(mesh, face);
                    break;
                }
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

recon::Progress host_progress(vcg::CallBackPos* callback)
{
    if (!callback)
        return {};
    // One call per per cent and phase: enough for a window to stay alive, and meshlabserver prints every call.
    return recon::Progress(
        [callback, last = -1, last_phase = std::string()](double fraction, const std::string& phase) mutable
        {
            const int per_cent = static_cast<int>(100 * fraction);
            if (per_cent == last && phase == last_phase)
                return true;
            last = per_cent;
            last_phase = phase;
            return callback(per_cent, phase.c_str());
        });
}

class RichValues : public ParameterValues
{
public:
    explicit RichValues(const RichParameterList& list) : list_(list) {}
    double number(const std::string& name) const override { return list_.getFloat(text_of(name)); }
    int count(const std::string& name) const override { return list_.getInt(text_of(name)); }
    int choice(const std::string& name) const override { return list_.getEnum(text_of(name)); }
    bool flag(const std::string& name) const override { return list_.getBool(text_of(name)); }
    double length(const std::string& name) const override { return list_.getAbsPerc(text_of(name)); }
    std::string text(const std::string& name) const override { return list_.getString(text_of(name)).toStdString(); }

private:
    static QString text_of(const std::string& s) { return QString::fromStdString(s); }

    const RichParameterList& list_;
};

/// The layer's own box may be stale.
double diagonal_of(const MeshModel* model)
{
    if (!model)
        return 1;
    recon::Box box;
    for (const CVertexO& vertex : model->cm.vert)
    {
        const recon::Point p = to_point(vertex.cP());
        if (!vertex.IsD() && p.allFinite())
        {
            box.minimum = box.minimum.cwiseMin(p);
            box.maximum = box.maximum.cwiseMax(p);
        }
    }
    const double diagonal = box.diagonal();
    return diagonal > 0 && std::isfinite(static_cast<Scalarm>(diagonal)) ? diagonal : 1;
}

} // namespace

RichParameterList rich_parameters(const FilterSpec& spec, const MeshDocument& document)
{
    RichParameterList list;
    const Scalarm diagonal = static_cast<Scalarm>(diagonal_of(document.mm()));
    for (const ParameterDeclaration& p : spec.parameters())
    {
        const QString name = QString::fromStdString(p.name);
        const QString label = QString::fromStdString(p.label);
        const QString tooltip = QString::fromStdString(p.tooltip);
        switch (p.kind)
        {
        case ParameterKind::number:
            list.addParam(RichFloat(name, static_cast<Scalarm>(std::get<double>(p.default_value)), label, tooltip));
            break;
        case ParameterKind::length:
            // pymeshlab maps per cent onto [min, max].
            list.addParam(
                RichLength(name, static_cast<Scalarm>(std::get<double>(p.default_value)), 0, diagonal, label, tooltip));
            break;
        case ParameterKind::count:
            list.addParam(RichInt(name, std::get<int>(p.default_value), label, tooltip));
            break;
        case ParameterKind::flag:
            list.addParam(RichBool(name, std::get<bool>(p.default_value), label, tooltip));
            break;
        case ParameterKind::text:
            list.addParam(
                RichString(name, QString::fromStdString(std::get<std::string>(p.default_value)), label, tooltip));
            break;
        case ParameterKind::choice:
        {
            QStringList texts;
            for (const std::string& text : p.choices)
                texts << QString::fromStdString(text);
            list.addParam(RichEnum(name, std::get<int>(p.default_value), texts, label, tooltip));
            break;
        }
        }
    }
    return list;
}

FilterResult run_on_document(const FilterSpec& spec, const RichParameterList& parameters, MeshDocument& document,
                             vcg::CallBackPos* callback)
{
    MeshModel* current = document.mm();
    if (!current)
        throw recon::InvalidInput("The document has no layer: load or create a point cloud first.");
    InputLayer input = read_layer(*current);
    input.find_layer = [&document, current](const std::string& name)
    { return read_other_layer(document, *current, name); };
    FilterResult result = spec.run(input, RichValues(parameters), host_progress(callback));
    write_result(document, *current, result, input);
    return result;
}

int changed_elements(const FilterSpec& spec)
{
    const std::pair<unsigned, int> elements[] = {
        {Effect::makes_layer, MeshModel::MM_VERTNUMBER | MeshModel::MM_FACENUMBER},
        {Effect::moves_vertices, MeshModel::MM_VERTCOORD | MeshModel::MM_FACENORMAL},
        {Effect::changes_normals, MeshModel::MM_VERTNORMAL},
        {Effect::changes_colours, MeshModel::MM_VERTCOLOR},
        {Effect::changes_quality, MeshModel::MM_VERTQUALITY},
        {Effect::changes_selection, MeshModel::MM_VERTFLAGSELECT},
        {Effect::changes_radii, MeshModel::MM_VERTRADIUS},
        {Effect::removes_vertices, MeshModel::MM_VERTNUMBER | MeshModel::MM_FACENUMBER},
        {Effect::appends_vertices, MeshModel::MM_VERTNUMBER | MeshModel::MM_VERTCOORD},
    };
    int mask = MeshModel::MM_NONE;
    for (const auto& [effect, element] : elements)
        if (spec.effects & effect)
            mask |= element;
    return mask;
}

} // namespace plugin
