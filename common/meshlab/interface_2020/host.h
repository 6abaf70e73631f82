#pragma once

// MeshLab up to 2020.12.
#include <common/interfaces.h>
#include <common/meshmodel.h>

#include <vector>

using RichLength = RichAbsPerc;

inline void remove_layer(MeshDocument& document, MeshModel& model)
{
    document.delMesh(&model);
}

inline std::vector<MeshModel*> layers_of(MeshDocument& document)
{
    std::vector<MeshModel*> layers;
    for (MeshModel* model : document.meshList)
        layers.push_back(model);
    return layers;
}
