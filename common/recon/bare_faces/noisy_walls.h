#pragma once

#include <recon/bare_faces/flat_faces.h>
#include <recon/search/block_search.h>

#include <array>
#include <vector>

namespace recon
{

/// A closed curve of the rim of a noisy face, and what lies along it.
struct RimLoop
{
    std::vector<int> rim;                  ///< Indices of rim samples.
    std::vector<Vector> away;              ///< Per rim sample, as in FlatFace.
    std::vector<std::array<int, 2>> edges; ///< Of places in `rim`.
    std::vector<double> gaps;              ///< Lengths of the edges.
    double box = 0;                        ///< Diagonal of the box around it [length].
};

/// \param rims what the face refers to, here and below.
std::vector<RimLoop> list_rim_loops(const FlatFace& face, const Points& rims);

/// What rises straight from a loop, or falls off from it.
struct RimWall
{
    double height = 0;              ///< 0 = none [length].
    double side = 0;                ///< -1 where it falls off below the face, 1 where it rises over it.
    double length = 0;              ///< Of the loop.
    double out = 0;                 ///< It stands so far off the face, beyond a bevel or a fillet [length].
    std::vector<double> steps = {}; ///< Heights at the rim samples if they differ.
};

/// Finds walls of a noisy cloud by where their other ends are: between these they have no samples.
class WallFinder
{
public:
    /// \param points outlive this object. \param noise standard deviation > 0 [length].
    WallFinder(const Points& points, double noise) : points_(points), noise_(noise), search_(points) {}

    /// \param is_hole only a hole's walls may end in steps: an outline's are faces with rims of their own.
    RimWall find(const FlatFace& face, const RimLoop& loop, const Points& rims, bool is_hole);

    /// Whether most samples of a rim have points beside the place that lies off them by `offset`.
    bool ends_at(const RimLoop& loop, const Points& rims, const Vector& offset);

    /// Whether the wall is so high, but for the noise.
    bool is_level(const RimWall& wall, double height) const;

private:
    /// Where the other end of a wall is looked for.
    struct Reach
    {
        double highest = 0, lowest = 0; ///< Over the rim [length].
        double out = 0;                 ///< Off the face [length].
        double along = 0;               ///< To both sides along the rim [length].
    };

    std::vector<double> find_tops(const RimLoop& loop, const Points& rims, const Vector& up, const Reach& reach);
    double find_top(const Point& foot, const Vector& up, const Vector& away, const Reach& reach, double along);
    double find_height(const std::vector<double>& tops) const;
    std::vector<double> find_steps(const RimLoop& loop, const std::vector<double>& tops) const;

    const Points& points_;
    double noise_;
    BlockSearch search_;
    std::vector<int> near_;
};

} // namespace recon
