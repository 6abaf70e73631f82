#pragma once

#include "filter_amls/surface/surface.h"

#include <recon/bare_faces/complete_flats.h>
#include <recon/geometry.h>
#include <recon/progress.h>

#include <optional>
#include <vector>

namespace recon
{

enum class Denoise
{
    automatic, ///< Where the noise is not far below the spacing.
    on,
    off ///< The points as they are, as the paper has it.
};

/// Options of prepare_samples(). Lengths are in input units.
struct SamplePreparationOptions
{
    Denoise denoise = Denoise::automatic;
    double noise = 0;             ///< Standard deviation of the noise [length], >= 0. 0 = estimate.
    bool finds_any_noise = false; ///< Take a cloud for noisy from a hundredth of the spacing on, not from a twentieth.
    bool needs_surface = false;   ///< Make the AMLS surface of a noisy cloud even if the samples are not projected.
    int threads = 0;              ///< 0 = all cores.
};

/// The AMLS surface that was asked for last: attempts at one cloud ask for the same one up to four times.
class LatestSurface
{
public:
    /// \param points the input, whose order can tell from where it was seen. \param sorted those that are distinct, in
    /// spatial order. \throws as build_amls_surface() does.
    const AmlsSurface& find(const Points& points, const Points& sorted, const SamplePreparationOptions& options,
                            const Progress& progress);

private:
    std::optional<AmlsSurface> surface_;
    double noise_ = 0; ///< That it was told.
};

/// A cloud made ready for label_polar_balls().
struct PreparedSamples
{
    explicit PreparedSamples(const Points& points) : frame(points) {}
    /// Makes `frame` that of the points that `spanning` holds, and `distinct` fit it. \param points the input.
    void choose_frame(const Points& spanning, const Points& points);
    /// Takes these of the distinct points, ascending, for outliers. \param points the input.
    void leave_out(const std::vector<int>& ones, const Points& points);

    UnitFrame frame;
    std::vector<int> order;             ///< Input index of each distinct point but the isolated, in spatial order.
    Points distinct;                    ///< Those points in the unit frame; outliers lie anywhere.
    double cleanness = 0;               ///< Share of points that look free of noise [0..1].
    double stacked = 0;                 ///< Share of points with other sheets beside their own [0..1].
    bool is_noisy = false;              ///< What the gate found.
    bool is_doubtful = false;           ///< Only the roughness says so: that can be thin walls.
    bool denoised = false;              ///< Whether `samples` are projected and thinned.
    std::optional<AmlsSurface> surface; ///< Of a cloud that is noisy or denoised.
    Points samples;                     ///< In the unit frame: `distinct`, or cleaned.
    Vectors normals;                    ///< Outward, one per sample if denoised, else empty.
    int isolated = 0;                   ///< Points of a cloud that looks clean which lie alone: `order` lacks them.
    int outliers = 0;                   ///< Points left out, these and those that denoising dropped [count].
    std::vector<int> claimed;           ///< The distinct points that are no outliers, if denoised.
    bool may_have_flats = false;        ///< Whether bare faces that are exactly flat are to be sought.
    std::optional<FlatCompletion> completion; ///< Of these, once sought; not among the samples.
    /// Seeks them, unless that was done. \throws Cancelled.
    const FlatCompletion& complete(PhaseTimes& times, int threads, const Progress& progress = {});
    double noise = 0;       ///< Standard deviation, given or estimated [input units].
    double given_noise = 0; ///< As it was given; 0 if it was estimated.
};

/// Sorts the points, tells whether they are noisy, and if so projects them onto their AMLS surface and thins them.
/// \param latest of the points. \throws InvalidInput for points that do not span a volume or are not finite.
/// \throws Cancelled.
PreparedSamples prepare_samples(const Points& points, const SamplePreparationOptions& options, LatestSurface& latest,
                                PhaseTimes& times, const Progress& progress = {});

} // namespace recon
