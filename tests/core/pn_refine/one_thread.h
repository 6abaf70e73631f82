#pragma once

#include <filter_pn_refine/refine.h>

namespace recon
{

/// Options of a test that does not ask for threads.
inline PnRefineOptions one_thread(int steps)
{
    PnRefineOptions options;
    options.steps = steps;
    options.threads = 1;
    return options;
}

} // namespace recon
