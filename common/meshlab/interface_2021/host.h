#pragma once

// MeshLab from 2021.07 on, and pymeshlab.
#include <common/ml_document/mesh_document.h>
#include <common/plugins/interfaces/filter_plugin.h>

using RichLength = RichPercentage;

inline void remove_layer(MeshDocument& document, MeshModel& model)
{
    document.delMesh(model.id());
}
