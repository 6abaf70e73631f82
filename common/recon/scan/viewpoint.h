#pragma once

#include <recon/geometry.h>
#include <recon/progress.h>

#include <memory>
#include <optional>
#include <vector>

namespace recon
{

/// Places of the cameras or scanners that saw points: none known, one for all, or several, each of some of them.
class Viewpoints
{
public:
    /// None.
    Viewpoints() = default;
    /// One for all.
    explicit Viewpoints(const Point& place) : places_{place} {}
    /// Several. \param seen points, of which each was seen from places[seen_from]. \pre as many seen_from.
    Viewpoints(Points places, Points seen, std::vector<int> seen_from);

    const Points& places() const { return places_; }
    bool empty() const { return places_.empty(); }
    /// From which what is nearest to `p` was seen. \pre not empty.
    const Point& of(const Point& p) const;
    /// The same in another frame.
    Viewpoints in(const UnitFrame& frame) const;

private:
    struct Seen;
    Points places_;
    std::shared_ptr<const Seen> seen_; ///< Where there are several.
};

/// The place from which points were seen, told by the order in which they come, along rows or columns of rays. Where
/// what is near ends, the next point lies far behind it: a ray goes through where the near side would have gone on, and
/// through that point. Rays of all such gaps meet where the scanner is, and from there every point is as far from the
/// next, in angle, as that from the one after it. Noise along the rays changes neither. None if the points come in
/// another order, were moved across their rays, or seen from several places. \pre finite. Serial: one look at each
/// point, and some more at the gaps.
std::optional<Point> find_scan_origin(const Points& points);

/// The places of scans that follow each other, each in the order of its rays; one of them is one place. None unless
/// nearly all points are of scans whose place is found. \pre as above. \throws Cancelled.
Viewpoints find_scan_origins(const Points& points, int threads = 1, const Progress& progress = {});

/// Places of the cameras or scanners that all points face: the origin, if they are a camera's pixels as it delivers
/// them (depth_image.h); those that their order tells; or the origin, if that is nearly the only one of these or there
/// are none, and they are a scanner's readings from there (even_angles.h); or the point of which there are the most
/// copies, if they are readings from there, and these what was read of nothing. \param sorted the same in another
/// order, where what does not need theirs must not hang on how they come. \pre finite. \throws Cancelled.
Viewpoints find_viewpoints(const Points& points, const Points& sorted, int threads, const Progress& progress = {});
Viewpoints find_viewpoints(const Points& points, int threads, const Progress& progress = {});

} // namespace recon
