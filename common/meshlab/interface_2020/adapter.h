#pragma once

#include <host.h>

#include "../filter_spec.h"

/// Shows the filters of describe_plugin() to MeshLab 2020.
class PointSurfacesAdapter : public QObject, public MeshFilterInterface
{
    Q_OBJECT
    MESHLAB_PLUGIN_IID_EXPORTER(MESH_FILTER_INTERFACE_IID)
    Q_INTERFACES(MeshFilterInterface)

public:
    PointSurfacesAdapter();

    QString pluginName() const override;
    QString filterName(FilterIDType id) const override;
    QString filterInfo(FilterIDType id) const override;
    FilterClass getClass(QAction* action) override;
    FILTER_ARITY filterArity(QAction* action) const override;
    int getRequirements(QAction* action) override;
    int getPreConditions(QAction* action) const override;
    int postCondition(QAction* action) const override;
    using MeshFilterInterface::initParameterSet;
    void initParameterSet(QAction* action, MeshDocument& document, RichParameterList& parameters) override;
    bool applyFilter(QAction* action, MeshDocument& document, const RichParameterList& parameters,
                     vcg::CallBackPos* callback) override;

private:
    const plugin::FilterSpec& spec(const QAction* action) const;

    plugin::PluginSpec plugin_;
};
