#include "adapter.h"

#include "../host_document.h"

PointSurfacesAdapter::PointSurfacesAdapter() : plugin_(plugin::describe_plugin())
{
    for (std::size_t i = 0; i < plugin_.filters.size(); ++i)
    {
        typeList << static_cast<int>(i);
        actionList << new QAction(filterName(static_cast<int>(i)), this);
    }
}

const plugin::FilterSpec& PointSurfacesAdapter::spec(const QAction* action) const
{
    return plugin_.filters.at(ID(const_cast<QAction*>(action)));
}

QString PointSurfacesAdapter::pluginName() const
{
    return QString::fromStdString(plugin_.name);
}

QString PointSurfacesAdapter::filterName(FilterIDType id) const
{
    return QString::fromStdString(plugin_.filters.at(id).name);
}

QString PointSurfacesAdapter::filterInfo(FilterIDType id) const
{
    return QString::fromStdString(plugin_.filters.at(id).info);
}

MeshFilterInterface::FilterClass PointSurfacesAdapter::getClass(QAction* action)
{
    return static_cast<FilterClass>(spec(action).category);
}

MeshFilterInterface::FILTER_ARITY PointSurfacesAdapter::filterArity(QAction*) const
{
    return SINGLE_MESH;
}

int PointSurfacesAdapter::getRequirements(QAction*)
{
    return MeshModel::MM_NONE;
}

int PointSurfacesAdapter::getPreConditions(QAction*) const
{
    return MeshModel::MM_NONE; // The filters check their input themselves and name the remedy.
}

int PointSurfacesAdapter::postCondition(QAction* action) const
{
    return plugin::changed_elements(spec(action));
}

void PointSurfacesAdapter::initParameterSet(QAction* action, MeshDocument& document, RichParameterList& parameters)
{
    parameters = plugin::rich_parameters(spec(action), document);
}

bool PointSurfacesAdapter::applyFilter(QAction* action, MeshDocument& document, const RichParameterList& parameters,
                                       vcg::CallBackPos* callback)
{
    // An exception that leaves this function ends the process.
    try
    {
        const plugin::FilterResult result = plugin::run_on_document(spec(action), parameters, document, callback);
        for (const std::string& line : result.log)
            Log(GLLogStream::FILTER, line);
        for (const auto& value : result.values)
            Log(GLLogStream::FILTER, plugin::describe_value(value));
        for (const std::string& line : result.warnings)
            Log(GLLogStream::WARNING, line);
        return true;
    }
    catch (...)
    {
        const std::string message = plugin::message_of_current_exception();
        errorMessage = QString::fromStdString(message);
        Log(GLLogStream::WARNING, message); // meshlabserver prints the log, but not errorMessage.
        return false;
    }
}
