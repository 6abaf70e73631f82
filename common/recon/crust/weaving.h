#pragma once

#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/mismatch.h>

#include <cmath>

namespace recon
{

/// Scans of one surface that are out of register are sheets beside each other. Their noise is told of each alone, see
/// estimate_noise(), and the surface weaves between them, which votes object to. So many times that noise reaches over
/// all of them; the second is tried where the first does not do.
inline constexpr double reach_over_sheets[] = {4, 8};

/// A crust that may weave, or that of an attempt with more noise.
struct Woven
{
    double violated = 0;  ///< Share of violated votes [0..1].
    double volume = 0;    ///< Of the crust [length^3].
    int handles = 0;      ///< Its genus.
    double bare_area = 0; ///< See Mismatch.
};

/// \param samples of the attempt with the least noise, in the mesh's units: the others have fewer, and lids of theirs
/// are not bare.
inline Woven describe_woven(double violated_votes, const TriangleMesh& crust, const Points& samples, int threads)
{
    return {violated_votes, measure_volume(crust), measure_closed_topology(crust).genus(),
            measure_bare_area(samples, crust, threads)};
}

/// Whether it is worth asking: between 0.009 and 0.04 of the votes object where a surface weaves so that its shape is
/// wrong, up to 0.0078 where thin parts are taken for noise. \param noise standard deviation told at first [spacings of
/// the samples].
inline bool may_weave(double violated_votes, double noise)
{
    constexpr double woven_above = 0.008;
    return violated_votes > woven_above && noise >= least_noise_of_walls;
}

/// Share of bare area above which an open sheet is one: closed scans out of register that look so have 0.1.
inline constexpr double bare_if_open = 0.15;

/// Whether an attempt with more noise lies between sheets among which the first wove: half as many votes object, it has
/// no more handles, no more points lie beyond that noise than chance puts there, and neither walls nor hollows went
/// under in it. The first may be lace that encloses a half of what it should, or nearly nothing, and of which votes say
/// less; but then no lids may be bare, and the sheets no two that lie everywhere as far apart, as of a thin hollow
/// shell: 0.90 and more as even, sheets of many scans up to 0.80. Both together are a pipe that the first had filled
/// already. \param misfit of the points and the attempt's crust by its noise.
inline bool lies_between_sheets(const Woven& first, const Woven& with_more, const NoiseMisfit& misfit)
{
    constexpr double left = 0.5, left_of_lace = 0.75, beyond_by_chance = 0.0027, same_volume = 0.05, even = 0.85;
    const double growth = with_more.volume - first.volume;
    const bool has_lids = with_more.bare_area > bare_lid, are_walls = misfit.evenness >= even;
    const bool was_lace = 2 * with_more.handles < first.handles && growth > 0 && !has_lids && !are_walls;
    const bool is_same_solid = std::abs(growth) <= same_volume * std::abs(first.volume) && !(has_lids && are_walls);
    const double most = was_lace ? left_of_lace : left;
    return (was_lace || is_same_solid) && with_more.violated <= most * first.violated &&
           with_more.handles <= first.handles && misfit.beyond_noise <= beyond_by_chance;
}

/// What tells of a crust that weaves.
struct WeavingSigns
{
    double violated = 0; ///< Share of violated votes [0..1].
    int handles = 0;     ///< Its genus.
};

/// Noise of an open cloud that passed for detail: the crust of the points as they are comes as near to them as no
/// denoised one does, but weaves between them. Whether it is worth asking.
inline bool may_weave_through_noise(const WeavingSigns& as_they_are)
{
    constexpr double woven = 0.03;
    constexpr int few_handles = 20;
    return as_they_are.violated > woven && as_they_are.handles > few_handles;
}

/// Whether it does, though fewer votes may say so: 8.6 to 113 times as many handles as the denoised one in seven real
/// sweeps, which violates at most 1.6 times as many votes; 2.2 and 23 times in simulated ones without noise.
inline bool weaves_through_noise(const WeavingSigns& as_they_are, const WeavingSigns& denoised)
{
    constexpr double many_times = 6, more_votes = 2;
    return may_weave_through_noise(as_they_are) && denoised.violated <= more_votes * as_they_are.violated &&
           as_they_are.handles > many_times * denoised.handles;
}

/// What to tell users where it lies between sheets.
inline constexpr char out_of_register_text[] =
    "The points lie in sheets beside each other, as those of scans that are out of register do: the surface lies "
    "between the sheets, and what is finer than their distance is lost. Align the scans to see it; if the sheets are "
    "walls, set noise to what the scanner has.";

} // namespace recon
