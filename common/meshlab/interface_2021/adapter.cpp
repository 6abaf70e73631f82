#include "adapter.h"

#include "../host_document.h"

PointSurfacesAdapter::PointSurfacesAdapter() : plugin_(plugin::describe_plugin())
{
    for (std::size_t i = 0; i < plugin_.filters.size(); ++i)
    {
        typeList.push_back(static_cast<int>(i));
        actionList.push_back(new QAction(filterName(static_cast<int>(i)), this));
    }
}

const plugin::FilterSpec& PointSurfacesAdapter::spec(const QAction* action) const
{
    return plugin_.filters.at(ID(action));
}

QString PointSurfacesAdapter::pluginName() const
{
    return QString::fromStdString(plugin_.name);
}

QString PointSurfacesAdapter::vendor() const
{
    return "MeshLab Point Surfaces";
}

QString PointSurfacesAdapter::filterName(ActionIDType id) const
{
    return QString::fromStdString(plugin_.filters.at(id).name);
}

QString PointSurfacesAdapter::pythonFilterName(ActionIDType id) const
{
    return QString::fromStdString(plugin_.filters.at(id).python_name);
}

QString PointSurfacesAdapter::filterInfo(ActionIDType id) const
{
    return QString::fromStdString(plugin_.filters.at(id).info);
}

FilterPlugin::FilterClass PointSurfacesAdapter::getClass(const QAction* action) const
{
    return static_cast<FilterClass>(spec(action).category);
}

FilterPlugin::FilterArity PointSurfacesAdapter::filterArity(const QAction*) const
{
    return SINGLE_MESH;
}

int PointSurfacesAdapter::getRequirements(const QAction*)
{
    return MeshModel::MM_NONE;
}

int PointSurfacesAdapter::getPreConditions(const QAction*) const
{
    return MeshModel::MM_NONE; // The filters check their input themselves and name the remedy.
}

int PointSurfacesAdapter::postCondition(const QAction* action) const
{
    return plugin::changed_elements(spec(action));
}

RichParameterList PointSurfacesAdapter::initParameterList(const QAction* action, const MeshDocument& document)
{
    return plugin::rich_parameters(spec(action), document);
}

std::map<std::string, QVariant> PointSurfacesAdapter::applyFilter(const QAction* action,
                                                                  const RichParameterList& parameters,
                                                                  MeshDocument& document, unsigned int& post_condition,
                                                                  vcg::CallBackPos* callback)
{
    // MeshLab catches MLException only.
    try
    {
        const plugin::FilterSpec& filter = spec(action);
        const plugin::FilterResult result = plugin::run_on_document(filter, parameters, document, callback);
        post_condition = static_cast<unsigned int>(plugin::changed_elements(filter));
        for (const std::string& line : result.log)
            log(GLLogStream::FILTER, line);
        std::map<std::string, QVariant> values;
        for (const auto& value : result.values)
        {
            log(GLLogStream::FILTER, plugin::describe_value(value));
            values[value.first] = std::visit([](auto v) { return QVariant(v); }, value.second);
        }
        for (const std::string& line : result.warnings)
            log(GLLogStream::WARNING, line);
        return values;
    }
    catch (...)
    {
        throw MLException(QString::fromStdString(plugin::message_of_current_exception()));
    }
}
