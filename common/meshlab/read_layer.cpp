#include "read_layer.h"

#include <recon/errors.h>

#include <Eigen/LU>

#include <typeindex>

namespace plugin
{
namespace
{

using Allocator = vcg::tri::Allocator<CMeshO>;

} // namespace

const vcg::PointerToAttribute* find_radius_attribute(const CMeshO& mesh)
{
    vcg::PointerToAttribute named;
    named._name = radius_attribute;
    const auto found = mesh.vert_attr.find(named);
    return found == mesh.vert_attr.end() ? nullptr : &*found;
}

Radii find_radii(CMeshO& mesh)
{
    // vcglib asks for the size of a value, not for its type.
    const vcg::PointerToAttribute* found = find_radius_attribute(mesh);
    return found && found->_type == typeid(Scalarm) ? Allocator::FindPerVertexAttribute<Scalarm>(mesh, radius_attribute)
                                                    : Radii(nullptr, 0);
}

recon::Point to_point(const Point3m& p)
{
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

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
    Radii radii = find_radii(mesh); // not const, by vcglib
    if (Allocator::IsValidHandle(mesh, radii))
        for (const CVertexO* v : vertices)
            layer.radii.push_back(static_cast<double>(radii[v]));
    else if (model.hasDataMask(MeshModel::MM_VERTRADIUS))
        for (const CVertexO* v : vertices)
            layer.radii.push_back(static_cast<double>(v->cR()));
    return layer;
}

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

} // namespace plugin
