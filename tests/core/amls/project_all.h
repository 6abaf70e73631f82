#pragma once

#include "filter_amls/surface/project.h"

/// Points onto the surface that they define, by defaults.
inline recon::AmlsProjection project_all(const recon::Points& points, int threads = 0)
{
    recon::AmlsOptions options;
    options.threads = threads;
    recon::AmlsProjectionOptions projection;
    projection.threads = threads;
    return recon::project_to_amls(points, recon::build_amls_surface(points, options), projection);
}
