#pragma once

#include <recon/geometry.h>
#include <recon/search/block_search.h>

#include <algorithm>
#include <cstddef>

namespace recon
{

/// What tells a cloud without noise from a noisy one; shares of its samples are [0..1].
struct Cleanness
{
    /// The Voronoi cell is long and thin on both sides, see has_clean_poles(). Measured: 0.73 to 1 on clean clouds (0.3
    /// on walls thinner than three spacings), 0.1 to 0.35 on clouds of noisy copies, 0.47 and 0.62 on merged range
    /// scans.
    double long_cells = 0;
    /// The three nearest lie flat, see share_of_flat(), thin walls or not. Measured: 0.66 (coarse CAD) to 1 on clean
    /// clouds, 0.38 to 0.51 on clouds of noisy copies, 0.52 and 0.56 on merged range scans.
    double flat_neighbours = 0;
    /// Distance of the 12 nearest to their best quadric over that of the 32 nearest to theirs (root mean squares of the
    /// degrees of freedom), the lower quartile of the samples. What a quadric cannot follow grows with the piece, noise
    /// does not. Measured: 0 to 0.45 on clean clouds however coarse (0.53 on fractal rock), 0.5 to 0.83 on scans and
    /// noisy samples where the projection onto the AMLS surface lowered the error. In a stack of sheets it is that of
    /// the sample's own, see sheet_stack.h; so are the following.
    double whiteness = 0;
    /// The former distance [spacings of the place]: its median, and what nine of ten samples exceed.
    double roughness = 0, least_roughness = 0;
    /// The roughness that three of four exceed, and the share of samples with cells that are not long, hardly a flat
    /// neighbour, and white residuals above 0.1 spacings. Measured: 0.01 to 0.02 and 0.14 to 0.37 on clouds of
    /// which half is noisy (armadillo 0.03); of 100 clean clouds none with a share above 0.09 has a roughness below
    /// 0.07.
    double lower_roughness = 0, noisy_places = 0;
    static constexpr double many_noisy = 0.1; ///< Of the latter: more need not lie side by side.
    /// The same share while it is at most many_noisy, each such sample weighed by the share of such among 8 of its 256
    /// nearest: a noisy part has them side by side, detail here and there. 0 of few samples, which share their
    /// neighbours and are alike. Measured on 58 models: 0.003 to 0.02 with a noisy tenth, an eighth to 0.43 of the
    /// former share; of 2,700 clean clouds up to 0.0037, on thin walls 0.006, a tenth of that share, on coarse models
    /// 0.012, 0.35 times the lower roughness.
    double noisy_part = 0;
    /// Of the rough places with cells that are not long and hardly a flat neighbour the median whiteness (0 of few
    /// samples, as vertices of parts), and the share of samples where it exceeds 0.7. Where noise comes and goes within
    /// few spacings neighbourhoods are a mix of both, and only these tell: 0.77 to 1.03 and 0.145 to 0.24 on stripes of
    /// noise as wide as 4 spacings or less, or of a noisy third; 0.74 to 1.09 and 0.035 to 0.12 on spots of 7 and 11
    /// spacings, a tenth and a fifth of the surface, beside noise of 0.07. Of 2,580 clean clouds, those without stacks
    /// of which nothing else says that they are noisy: with 0.12 and more of the latter 0.68 at most; with 0.7 and more
    /// of the former 0.115 at most (a femur), others 0.07, and a noisy part of up to 0.0044.
    double uneven_whiteness = 0, white_places = 0;
    static constexpr std::size_t fewest_for_mixed = 2'000; ///< Fewer are few [count].
    /// Share of samples with other sheets beside their own, see sheet_stack.h: 0.3 to 0.95 where thin walls are many.
    double stacked = 0;
    /// Share of single noisy samples among exact ones, see stray_samples.h. Only known of clouds that look clean
    /// otherwise, have no stacks and are not few; else 0.
    double strays = 0;
    static constexpr double few_stacked = 0.1; ///< Of `stacked`: less is no stack.
    /// Samples lie on noisy lines or fibres, see noisy_lines.h and noisy_fibres.h: what is near looks clean there.
    bool has_noisy_lines = false;
    /// Median distance to the quadric of the 12 nearest [length]: the noise, unless curvature hides it.
    double noise = 0;
    double spacing = 0; ///< Median of the places [length].

    /// Share of samples that look free of noise.
    double share() const { return std::max(long_cells, flat_neighbours); }
    bool is_clean() const { return long_cells > 0.7 || flat_neighbours > 0.63; }
    /// Whether a wider fit follows the samples nearly as well as a narrow one, so that averages gain more than they
    /// blur. Noise of more than 0.45 spacings leaves neither long cells nor flat neighbours; two near sheets are as
    /// rough.
    bool is_smooth_but_noisy() const { return whiteness > 0.5 && is_rough_from(0.05); }
    /// The same of noise that a surface through the samples does not show, but its medial axis does. On boxes, whose
    /// edges no quadric follows, residuals are less white: 0.41 to 0.5.
    bool is_hardly_noisy() const { return whiteness > 0.4 && is_rough_from(0.003); }
    bool is_rough_from(double least) const { return roughness > least && roughness < 0.45; }
    /// Whether only the roughness says that a cloud is noisy, nearly everywhere [spacings]: clean coarse models
    /// have 0.06 at most, clouds with one sample a spot 0.12 at a noise of 0.2. That can be thin tubes, but hardly thin
    /// walls, whose neighbours lie flat: 0.83 on casting, which reads as noise of 1.1 spacings, 0.77 to 0.84 on sheets
    /// one spacing thick, 0.68 to 0.74 at a noise of 0.2.
    bool is_doubtful() const
    {
        return share() > 0.6 && !is_smooth_but_noisy() && flat_neighbours < 0.75 && least_roughness > 0.11;
    }
    /// Whether noise comes and goes: in single samples and in stripes or spots, where what tells of either adds up, or
    /// in some larger spots. Clean clouds have 0.94 of the sum at most (a femur; others 0.82). Nearly exact ones have
    /// fewer white places than coarse ones.
    bool has_mixed_noise() const
    {
        constexpr double enough_strays = 0.0085, enough_part = 0.0048, least_whiteness = 0.73;
        const double enough_places = lower_roughness < 0.09 ? 0.09 : 0.13;
        if (uneven_whiteness < least_whiteness || stacked >= few_stacked)
            return strays > enough_strays;
        return strays / enough_strays + white_places / enough_places > 1 || noisy_part > enough_part;
    }
    /// Whether some of it at least is noisy, the rest clean or less so: scans of several qualities merged, side by side
    /// or one over the other, or lines that look clean each alone. Coarse clouds look noisy in places, too, but nowhere
    /// smooth, or not side by side.
    bool is_noisy_in_parts() const
    {
        return has_noisy_lines || has_mixed_noise() ||
               (noisy_places > many_noisy && (lower_roughness < 0.05 || whiteness > 0.5)) ||
               noisy_part > std::max({0.004, 0.375 * lower_roughness, 0.12 * noisy_places});
    }
};

/// Taken at 400 samples and the Delaunay triangulations of the 32 nearest of half of them, so it costs little beside
/// any triangulation of the whole. \param samples distinct, in spatial order.
Cleanness measure_cleanness(const Points& samples, int threads);

/// Whether the directions to a sample's two poles and their lengths are those of a surface without noise.
/// \param eighth distance to the 8th nearest sample.
bool has_clean_poles(const Vector& first, const Vector& second, double eighth);

/// Share of a sample's neighbours in the plane across its first pole, within 17 degrees. Noise lets them sink to any
/// depth; the nearest on the far side of a thin wall are not among the first three. \param first pole relative to the
/// sample. \param neighbours likewise.
double share_of_flat(const Vector& first, const Point* neighbours, int count);

/// The same of the three nearest of a sample, from the Delaunay triangulation of the 32 nearest; 1 if it has no poles.
/// \param search of the samples. \param sample one of them.
double measure_flat_neighbours(const Points& samples, const BlockSearch& search, const Point& sample);

} // namespace recon
