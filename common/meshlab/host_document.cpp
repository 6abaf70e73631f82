#include "host_document.h"

#include "read_layer.h"
#include "write_result.h"

#include <recon/errors.h>

#include <cmath>
#include <limits>

namespace plugin
{
namespace
{

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
    bool has(const std::string& name) const override { return list_.hasParameter(text_of(name)); }
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
        // As rich text, since Qt breaks the lines of no other tooltip.
        const QString tooltip = "<p>" + QString::fromStdString(p.tooltip).toHtmlEscaped() + "</p>";
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
        case ParameterKind::count: list.addParam(RichInt(name, std::get<int>(p.default_value), label, tooltip)); break;
        case ParameterKind::flag: list.addParam(RichBool(name, std::get<bool>(p.default_value), label, tooltip)); break;
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
