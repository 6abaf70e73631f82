#pragma once

#include <host.h>

#include "../filter_spec.h"

/// Shows the filters of describe_plugin() to MeshLab from 2021 on and to pymeshlab.
class PointSurfacesAdapter : public QObject, public FilterPlugin
{
    Q_OBJECT
    MESHLAB_PLUGIN_IID_EXPORTER(FILTER_PLUGIN_IID)
    Q_INTERFACES(FilterPlugin)

public:
    PointSurfacesAdapter();

    QString pluginName() const override;
    QString vendor() const override;
    QString filterName(ActionIDType id) const override;
    QString pythonFilterName(ActionIDType id) const override;
    QString filterInfo(ActionIDType id) const override;
    FilterClass getClass(const QAction* action) const override;
    FilterArity filterArity(const QAction* action) const override;
    int getRequirements(const QAction* action) override;
    int getPreConditions(const QAction* action) const override;
    int postCondition(const QAction* action) const override;
    using FilterPlugin::initParameterList;
    RichParameterList initParameterList(const QAction* action, const MeshDocument& document) override;
    std::map<std::string, QVariant> applyFilter(const QAction* action, const RichParameterList& parameters,
                                                MeshDocument& document, unsigned int& post_condition,
                                                vcg::CallBackPos* callback) override;

private:
    const plugin::FilterSpec& spec(const QAction* action) const;

    plugin::PluginSpec plugin_;
};
