#pragma once

// MeshLab from 2021.07 on, and pymeshlab.
#include <common/ml_document/mesh_document.h>
#include <common/plugins/interfaces/filter_plugin.h>

#include <vector>

using RichLength = RichPercentage;

inline void remove_layer(MeshDocument& document, MeshModel& model)
{
    document.delMesh(model.id());
}

inline std::vector<MeshModel*> layers_of(MeshDocument& document)
{
    std::vector<MeshModel*> layers;
    for (MeshModel& model : document.meshIterator())
        layers.push_back(&model);
    return layers;
}
