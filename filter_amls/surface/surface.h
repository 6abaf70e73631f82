#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace recon
{

/// Options of build_amls_surface(). Lengths are in input units.
struct AmlsOptions
{
    double rho_e = 0; ///< Gaussian width [local feature size], >= 0. 0 = automatic from noise, spacing and curvature.
    double noise = 0; ///< Standard deviation of the noise [length], >= 0. 0 = estimate, locally.
    /// The points are to become samples of a crust. It has to close an open level sheet, so outside is where big balls
    /// say, which fewer samples then contradict; else it is above such a sheet. A ground faces what stands on it either
    /// way, see find_ground(). Residuals are told from the projection that samples take, without `sharp`; it is at hand
    /// afterwards, as the sharp one is else.
    bool for_crust = false;
    /// A crust will tell of the surface, as it does where `for_crust`: fits keep the narrower windows in which bores of
    /// three spacings and scans out of register show. Else projected points err less.
    bool for_labels = false;
    /// The cloud in the order in which it was scanned, where `points` come in another: that may tell which places open
    /// sheets face, see viewpoint.h. Read while the surface is built.
    const Points* as_scanned = nullptr;
    int threads = 0; ///< Threads to use [count], >= 0. 0 = all cores. The result does not depend on it.
};

/// What was found while building; lengths are in input units.
struct AmlsSurfaceReport
{
    double noise = 0;         ///< Median standard deviation of the noise, estimated or given [length].
    double least_noise = 0;   ///< Noise that nine of ten places exceed [spacings].
    double most_noise = 0;    ///< Noise that one of fifty places exceeds [length].
    double spacing = 0;       ///< Median distance of neighbouring points [length].
    double lattice_step = 0;  ///< To which the points were rounded [length], see rounding.h. 0 if they were not.
    double lattice_error = 0; ///< Noise that they are taken to have for that, at least [length].
    double width = 0;         ///< Median width h of the weights exp(-d^2 / h^2) [length].
    double rho_e =
        0;         ///< Median of 2^(1/4) h / local feature size [1]: the paper's parameter that this width amounts to.
    int cells = 0; ///< [count]
    int anchors = 0;         ///< [count]
    double contradicted = 0; ///< Share of what was known about sides that the orientation contradicts [0..1].
    bool open = false; ///< The cloud is an open sheet: "outside" has no meaning, the orientation is only consistent.
    Points seen_from = {}; ///< Places of the cameras or scanners that the normals face, if any were found.
    std::vector<std::pair<std::string, double>> seconds; ///< Wall-clock seconds per phase.

    /// Whether what the points are off by is how they were rounded. Planes of a lattice lie beside each other as walls
    /// do that were taken for noise, but no such walls are lost.
    bool has_only_lattice_noise() const;
};

/// A smooth surface through a noisy cloud: the zero set of I(x) = sum theta d_a / sum theta over small quadrics
/// (anchors) that carry the orientation. Copies share their data; projection may run on many threads at once.
class AmlsSurface
{
public:
    struct Data;
    explicit AmlsSurface(std::shared_ptr<const Data> data) : data_(std::move(data)) {}

    const AmlsSurfaceReport& report() const;
    /// Anchors as points with outward unit normals, in input units: a thinned and smoothed cloud.
    OrientedSamples anchors() const;
    const Data& data() const { return *data_; }

private:
    std::shared_ptr<const Data> data_;
};

/// Builds the surface from points alone (after Dey and Sun 2005; widths by local risk, cells, anchors). Equal points
/// count once. Does not depend on the order of the points. `normals`, if not empty, one per point and of any length,
/// decide the sides instead of the Delaunay balls; zero vectors among them have no say.
/// \param earlier a surface of the same points, perhaps of other options: what does not depend on these is not made
/// again. \throws InvalidInput for points that do not span a volume or are not finite, normals of a different number,
/// or an option out of range. \throws Cancelled.
AmlsSurface build_amls_surface(const Points& points, const AmlsOptions& options = {}, const Progress& progress = {},
                               const Vectors& normals = {}, const AmlsSurface* earlier = nullptr);

} // namespace recon
