#pragma once

#include "fit.h"

namespace recon
{

/// How far residuals of the fits that begin at `starts` may be off before they lose weight [sigma]: about that with the
/// least asymptotic variance of the estimate, E psi^2 / (E psi')^2, over a sample of them. Gaussian noise wants least
/// squares; where some points are much better than others, those should decide.
double choose_robust_scale(const FitSamples& samples, const std::vector<FitStart>& starts, int threads);

} // namespace recon
