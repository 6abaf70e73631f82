#include <recon/bare_faces/noisy_rims.h>

#include <recon/median.h>
#include <recon/search/keep_apart.h>
#include <recon/search/neighbours.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace recon
{
namespace
{

using Flat = Eigen::Vector2d;

/// Rounds in which rims are drawn together.
constexpr int rounds = 4;
/// Distances of denoised rim samples that are tried [noise].
constexpr double rim_steps[] = {2, 1.5, 2.5};
/// Where rims are sparse all samples of a spot become one: within this share of the distance to the next [count; 1].
constexpr int of_a_spot = 5;
constexpr double spot_share = 0.2;
/// What is left of a rim has this share of the median number of points at least; less is far off by chance.
constexpr double fewest_share = 0.3;
/// Least mean width of a face [distances of its rim samples].
constexpr double least_width = 2;

/// Draws points that lie along curves onto these: each moves across the main direction of those around it.
Points draw_rims(const SlabPoints& points, double noise)
{
    SlabSpots spots(points, noise);
    Points drawn = points.places;
    for (Point& p : drawn)
    {
        const double radius = spots.choose_radius(p);
        for (int round = 0; round < rounds; ++round)
        {
            const SpotMoments moments = spots.sum_up(p, radius);
            if (moments.effective == 0)
                break;
            const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(moments.spread);
            const Flat along = solver.eigenvectors().col(1), off = (moments.mean - p).head<2>();
            p.head<2>() += off - along.dot(off) * along;
        }
    }
    return drawn;
}

/// One point for all within reach of each that stays, their mean.
Points merge(const Points& drawn, double step, double noise)
{
    const NeighbourSearch around(drawn);
    std::vector<double> radii;
    for (const Point& p : drawn)
    {
        int indices[of_a_spot + 1];
        double squared[of_a_spot + 1];
        const int count = around.nearest(p, of_a_spot + 1, indices, squared);
        radii.push_back(std::max(step * noise, spot_share * std::sqrt(squared[count - 1])));
    }
    const std::vector<int> kept = keep_apart(drawn, radii);
    const Points centres = points_at(kept, drawn);
    const NeighbourSearch search(centres);
    Points sums(kept.size(), Point::Zero());
    std::vector<double> counts(kept.size(), 0);
    for (const Point& p : drawn)
    {
        const int k = search.nearest(p);
        sums[k] += p;
        ++counts[k];
    }
    const double usual = median(counts);
    Points result;
    // A spot far from the next is no stray of a rim, however few its points.
    for (std::size_t k = 0; k < sums.size(); ++k)
        if (counts[k] >= fewest_share * usual || radii[std::size_t(kept[k])] > 2 * step * noise)
            result.push_back(sums[k] / counts[k]);
    return result;
}

/// A disc in a hole of another face is more often what crosses the plane there.
void drop_discs_within(std::vector<PlanarFace>& faces, const std::vector<Flat>& rims)
{
    const auto box_of = [&](const PlanarFace& face)
    {
        Eigen::AlignedBox2d box;
        for (const int v : face.rim)
            box.extend(rims[v]);
        return box;
    };
    const std::vector<PlanarFace> all = faces;
    const auto is_within = [&](const PlanarFace& face)
    {
        return face.triangles.size() < face.rim.size() &&
               std::any_of(all.begin(), all.end(),
                           [&](const PlanarFace& other) {
                               return other.triangles.size() >= other.rim.size() &&
                                      box_of(other).contains(box_of(face));
                           });
    };
    faces.erase(std::remove_if(faces.begin(), faces.end(), is_within), faces.end());
}

/// Whether some of it lies far from its rims.
bool is_bare(const PlanarFace& face, const std::vector<Flat>& rims, double noise)
{
    if (int(face.rim.size()) < fewest_rim_samples)
        return false;
    double area = 0, length = 0;
    for (const auto& t : face.triangles)
    {
        const Flat u = rims[t[1]] - rims[t[0]], v = rims[t[2]] - rims[t[0]];
        area += 0.5 * std::abs(u.x() * v.y() - u.y() * v.x());
    }
    for (const auto& [a, b] : list_border_edges(face.triangles))
        length += (rims[a] - rims[b]).norm();
    // Mean width against the distance of rim samples and what noise leaves of a rim.
    return area > 0.5 * length * std::max(least_width * length / double(face.rim.size()), 4 * noise);
}

FilledRims fill(const Points& drawn, double step, double noise)
{
    FilledRims result;
    for (const Point& p : merge(drawn, step, noise))
        result.rims.push_back(p.head<2>());
    result.found = fill_planar_rims(result.rims, *std::rbegin(rim_strays));
    std::vector<PlanarFace>& faces = result.found.faces;
    faces.erase(std::remove_if(faces.begin(), faces.end(),
                               [&](const PlanarFace& face) { return !is_bare(face, result.rims, noise); }),
                faces.end());
    drop_discs_within(faces, result.rims);
    return result;
}

} // namespace

// Of the steps the first with faces that leaves out the least share.
FilledRims fill_noisy_rims(const SlabPoints& points, double noise)
{
    const Points drawn = draw_rims(points, noise);
    std::vector<FilledRims> tried;
    for (const double left_out : rim_strays)
        for (std::size_t k = 0; k < std::size(rim_steps); ++k)
        {
            if (k == tried.size())
                tried.push_back(fill(drawn, rim_steps[k], noise));
            const PlanarFaces& found = tried[k].found;
            if (!found.faces.empty() && are_all_but(left_out, found.on_rims, tried[k].rims.size()))
                return std::move(tried[k]);
        }
    return {};
}

} // namespace recon
