#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <cstdint>
#include <vector>

namespace recon
{

/// Implicit functions of point-set surfaces over samples with normals v_p, theta_p = exp(-sqrt(2) |x-p|^2 / (rho_e^2
/// f_p f_x)).
enum class PlainSurface
{
    normalised, ///< I = sum (x-p).v_p theta_p / sum theta_p, Newton's method on it (Dey and Sun 2005, eqs 3.5 to 7.11).
    plain_n,    ///< N = sum (x-p).v_p theta_p: the same zeros, a smaller domain of convergence (figure 11).
    vmls,       ///< G = sum (x-p).n(x) theta_p with n(x) the mean normal; projection along n(x) (eq. 8.12).
    pmls        ///< J = n(x) . dE/dy (eq. 1.2), Newton's method along n(x); has two more zero layers (section 8.3).
};

/// Options of project_to_plain_mls().
struct PlainMlsOptions
{
    PlainSurface surface = PlainSurface::normalised;
    double rho_e = 0.75;     ///< Gaussian width [local feature size], > 0. The paper's value in all its experiments.
    double cut_off = 5;      ///< Samples farther than this do not count [widths], > 0.
    int max_iterations = 30; ///< Steps per point [count], >= 1.
    double tolerance =
        1e-3; ///< A point has converged when the error that its last steps tell is below this [width], > 0.
    double largest_step = 0.5; ///< Limit of a step [local feature size], > 0.
    int threads = 0;           ///< Threads to use [count], >= 0. 0 = all cores. The result does not depend on it.
};

/// Projected points, one per query.
struct PlainMlsProjection
{
    Points points;
    Vectors normals; ///< Unit gradient of I; for VMLS and PMLS n(x).
    std::vector<char> converged;
    std::vector<int> iterations; ///< [count]
    std::vector<int> neighbours; ///< Samples that counted in the last step [count]. 0: the point is where it was, with
                                 ///< the normal of the nearest sample, since there were none around it.
};

/// Projects `queries` onto the plain surface of `samples`.
/// \pre `feature_size`: one per sample, > 0 and finite, in input units.
/// \throws InvalidInput for arrays of different length or an option out of range. \throws Cancelled.
PlainMlsProjection project_to_plain_mls(const Points& queries, const OrientedSamples& samples,
                                        const std::vector<double>& feature_size, const PlainMlsOptions& options = {},
                                        const Progress& progress = {});

} // namespace recon
