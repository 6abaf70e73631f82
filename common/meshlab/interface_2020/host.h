#pragma once

// MeshLab up to 2020.12.
#include <common/interfaces.h>
#include <common/meshmodel.h>

using RichLength = RichAbsPerc;

inline void remove_layer(MeshDocument& document, MeshModel& model)
{
    document.delMesh(&model);
}
