#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <string>

namespace recon
{

/// A surface is bare where it is farther than this from every point [spacings of the nearest].
constexpr double bare_beyond = 2;

/// How far a surface and the points that it is to be of part, whatever the labels that made it say.
struct Mismatch
{
    double missed_points =
        0; ///< Share of points farther from the surface than their spacing [0..1]: lost limbs, buried walls.
    double missed_by = 0; ///< Root mean square of their distances, those of all others counted as 0 [spacings].
    double bare_area = 0; ///< Share of the area farther than two spacings from any point [0..1]: closed gaps, bulges.
    double sum() const { return missed_points + bare_area; }
    /// Where a limb is lost, its end is missed by more than its root.
    double weighted_sum() const { return missed_by + bare_area; }
};

/// Below this share of violated votes crusts of clean clouds missed next to no points; the question would take a tenth
/// of the time.
inline constexpr double suspicious_votes = 0.004;
/// Share of points that a right surface of a clean cloud may miss, at ears and folds: up to 0.001; 0.007 and more where
/// limbs are lost.
inline constexpr double bearable_miss = 0.0015;
/// Mismatch above which a hollow may have been closed over, of the points and the crust of a clean cloud.
inline constexpr double bearable_mismatch = 0.05;

/// Of at most 20,000 of the points and at most 4,000 places on the mesh. Spacing: mean distance of the six nearest
/// others. A mesh without triangles misses all points. \param threads >= 1. \throws Cancelled.
Mismatch measure_mismatch(const Points& points, const TriangleMesh& mesh, int threads = 1,
                          const Progress& progress = {});

/// Share of points that the finished crust may miss without a word, under noise or not: each of 73 right ones missed at
/// most 0.0019, 7 of 31 wrong ones 0.0032 to 0.27.
inline constexpr double missed_without_a_word = 0.0025;
/// What to tell users of points that the finished crust misses. Empty: nothing.
std::string describe_missed(double missed_points);

/// Share of bare area above which a denoised crust may have lost walls: they read as noise, a lid closes what they
/// hold, and no vote objects. An open scan is bare as well.
inline constexpr double bare_lid = 0.02;

/// Noise below which nothing was taken for it, so no walls were lost [spacings of the samples]: two sheets that read as
/// noise are farther apart.
inline constexpr double least_noise_of_walls = 0.1;

/// How often the noise assumed is halved to find lost walls again. Where half of it leaves more than this share of the
/// points missed, the rest is sought with the least alone: noise was not what lost them, or not half of it.
inline constexpr int halvings = 3;
inline constexpr double barely_less = 0.8;
/// Share of the mismatch that balls by the spacing alone, or open lids, may leave.
inline constexpr double clearly_better = 0.5;

/// What to tell users where walls seem lost.
inline constexpr char lost_walls_text[] =
    "Parts of the surface have no points, and others lie beside it as no noise does: walls may have been taken for "
    "noise and what they hold filled.";

/// How points lie beside a surface: about that of an open scan as noise does, but walls that were taken for noise lie
/// on either side of theirs.
struct NoiseMisfit
{
    double beyond_noise = 0; ///< Share of points farther from it than three standard deviations [0..1]; 0.003 by noise.
    /// Share of places whose points are all about as far from it, mean above 0.9 of the root mean square [0..1]: half
    /// on either side. Gaussian noise has 0.8, two sheets 1.
    double two_sheets = 0;
    /// Mean distance over root mean square, mean over places of 128 points: 0.80 by Gaussian noise, 0.82 to 0.84 by
    /// sheets 2 to 2.5 standard deviations apart, and by noise of bounded reach, which has less in its tails.
    double evenness = 0;
    double tails = 0; ///< Share of points farther than twice the root mean square of their place [0..1].
    int points = 0;   ///< Asked [count].

    bool is_noise() const;
};

/// Of at most 20,000 of the points, without outliers. \param noise standard deviation [length], > 0. \throws Cancelled.
NoiseMisfit measure_noise_misfit(const Points& points, const TriangleMesh& mesh, double noise, int threads = 1,
                                 const Progress& progress = {});

/// Each alone; the area takes a fifth of the time. \param noise standard deviation [length]: points within five of it
/// are not missed either. \throws Cancelled.
double measure_missed_points(const Points& points, const TriangleMesh& mesh, int threads = 1,
                             const Progress& progress = {}, double noise = 0);
double measure_bare_area(const Points& points, const TriangleMesh& mesh, int threads = 1,
                         const Progress& progress = {});

} // namespace recon
