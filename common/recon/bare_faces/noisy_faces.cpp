#include <recon/bare_faces/noisy_faces.h>

#include <recon/bare_faces/planar_faces.h>
#include <recon/median.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/search/keep_apart.h>
#include <recon/search/neighbours.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

namespace recon
{
namespace
{

using Flat = Eigen::Vector2d;

/// Rounds in which rims are drawn together, and the reach of each fit [noise].
constexpr int rounds = 4;
constexpr double reach = 6;
/// Distances of denoised rim samples that are tried [noise].
constexpr double rim_steps[] = {2, 1.5, 2.5};
/// Where rims are sparse all samples of a spot become one: within this share of the distance to the next [count; 1].
constexpr int of_a_spot = 5;
constexpr double spot_share = 0.2;
/// Share of points on no rim: the rims that explain most come first.
constexpr double strays[] = {0.05, 0.1, 0.2};
/// Points that say where a curve runs.
constexpr int fewest_in_fit = 16;
/// What is left of a rim has this share of the median number of points at least; less is far off by chance.
constexpr double fewest_share = 0.3;
/// Least mean width of a face [distances of its rim samples].
constexpr double least_width = 2;
/// Where four in five of at most so many members have at least this many times as many within four reaches as within
/// one, they cover an area, and lie on no rim: 11 to 12 on walls and floors of scans, up to 8.7 where faces are.
constexpr double as_in_area = 9.75;
constexpr std::size_t most_asked = 500;
/// Within this distance the surface is seen to cross a plane [noise].
constexpr double crossing_reach = 8;
/// Half the width of what noise makes of a line in the plane [noise].
constexpr double beside_line = 4;
/// Share of the heights' variance that a slope explains where the surface leans instead of ending.
constexpr double leaning = 0.4;
constexpr int fewest_samples = 12;

/// Fills `away` of a face whose triangles and rim are known.
void find_away(FlatFace& face, const Points& samples)
{
    std::map<std::pair<int, int>, int> opposite; // -1 inside the face
    for (const auto& t : face.triangles)
        for (int i = 0; i < 3; ++i)
        {
            const auto added = opposite.insert({std::minmax(t[i], t[(i + 1) % 3]), t[(i + 2) % 3]});
            if (!added.second)
                added.first->second = -1;
        }
    std::map<int, Vector> sums;
    for (const auto& edge : opposite)
    {
        if (edge.second < 0)
            continue;
        const auto [a, b] = edge.first;
        const Vector along = (samples[b] - samples[a]).normalized();
        Vector off = samples[a] - samples[edge.second];
        off = (off - off.dot(along) * along).normalized();
        for (const int v : {a, b})
            sums.insert({v, Vector::Zero()}).first->second += off;
    }
    for (const int v : face.rim)
    {
        const auto found = sums.find(v);
        const double length = found == sums.end() ? 0 : found->second.norm();
        face.away.push_back(length > 0.1 ? Vector(found->second / length) : Vector::Zero());
    }
}

class NoisyFaceFinder
{
public:
    NoisyFaceFinder(const Points& points, double noise, Leaning leaning)
        : points_(points), noise_(noise), leaning_(leaning), search_(points)
    {
    }

    NoisyFaces find(int threads, const Progress& progress) const
    {
        return find_on(find_noisy_planes(points_, noise_, threads), threads, progress);
    }

    NoisyFaces find_on(const std::vector<NoisyPlane>& planes, int threads, const Progress& progress) const
    {
        std::vector<NoisyFaces> of_plane(planes.size());
        parallel_for(
            planes.size(), threads, progress, [&](std::size_t k) { of_plane[k] = find_on(planes[k]); }, 1);
        NoisyFaces result;
        for (NoisyFaces& own : of_plane)
            append(std::move(own), result);
        return result;
    }

private:
    /// Whether the surface goes on above the plane and below it.
    bool is_crossing(const NoisyPlane& plane, const Point& p, std::vector<int>& near) const
    {
        search_.within(p, crossing_reach * noise_, near);
        bool above = false, below = false;
        for (const int other : near)
        {
            above |= plane.height(points_[other]) > beside_slab * noise_;
            below |= plane.height(points_[other]) < -beside_slab * noise_;
        }
        return above && below;
    }

    /// Points of a plane that may lie on rims.
    struct Members
    {
        NoisyPlane plane;
        Vector first, second;
        Points flat; ///< Their places in the plane.
        std::vector<double> heights;
    };

    Members list_members(const NoisyPlane& plane) const
    {
        Members result;
        result.plane = plane;
        result.first = plane.normal.unitOrthogonal();
        result.second = plane.normal.cross(result.first);
        std::vector<int> near;
        for (const Point& p : points_)
            if (std::abs(plane.height(p)) <= slab_half * noise_ && !is_crossing(plane, p, near))
            {
                result.flat.emplace_back(result.first.dot(p - plane.origin), result.second.dot(p - plane.origin), 0);
                result.heights.push_back(plane.height(p));
            }
        return result;
    }

    /// Members around a place, and what their weighted moments say.
    struct Moments
    {
        Point mean = Point::Zero();
        Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
        Flat slope = Flat::Zero(); ///< Of heights with places.
        double variance = 0;       ///< Of heights.
        double effective = 0;      ///< As many members of equal weight would say as much [count].

        /// Whether heights lean with the place.
        bool is_leaning(Leaning told) const
        {
            const double explained = slope.dot(spread.ldlt().solve(slope));
            if (told == Leaning::by_share)
                return explained > leaning * variance;
            constexpr double unknowns = 3; // of a plane
            if (!(effective > unknowns))
                return false;
            return (variance - explained) * (effective - 1) < (1 - leaning) * variance * (effective - unknowns);
        }
    };

    Moments sum_up(const Members& members, const NeighbourSearch& search, const Point& p, double radius,
                   std::vector<int>& near) const
    {
        Moments result;
        search.within(p, radius, near);
        double sum = 0, squares = 0, height = 0;
        std::vector<double> weights;
        for (const int i : near)
        {
            weights.push_back(std::exp(-8 * (members.flat[i] - p).squaredNorm() / (radius * radius)));
            sum += weights.back();
            squares += weights.back() * weights.back();
            result.mean += weights.back() * members.flat[i];
            height += weights.back() * members.heights[i];
        }
        if (near.empty())
            return result;
        result.mean /= sum;
        height /= sum;
        result.effective = sum * sum / squares;
        for (std::size_t k = 0; k < near.size(); ++k)
        {
            const Flat off = (members.flat[near[k]] - result.mean).head<2>();
            const double up = members.heights[near[k]] - height;
            result.spread += weights[k] * off * off.transpose();
            result.slope += weights[k] * up * off;
            result.variance += weights[k] * up * up;
        }
        return result;
    }

    double choose_reach(const NeighbourSearch& search, const Point& p) const
    {
        int indices[fewest_in_fit];
        double squared[fewest_in_fit];
        const int found = search.nearest(p, fewest_in_fit, indices, squared);
        return std::max(reach * noise_, std::sqrt(squared[found - 1]));
    }

    /// Leaves out those around which heights lean with the place: there the surface crosses the plane.
    Members drop_leaning(const Members& members) const
    {
        const NeighbourSearch search(members.flat);
        Members result = members;
        result.flat.clear();
        result.heights.clear();
        std::vector<int> near;
        for (std::size_t k = 0; k < members.flat.size(); ++k)
        {
            const Point& p = members.flat[k];
            const Moments moments = sum_up(members, search, p, choose_reach(search, p), near);
            if (moments.is_leaning(leaning_))
                continue;
            result.flat.push_back(p);
            result.heights.push_back(members.heights[k]);
        }
        return result;
    }

    bool are_on_a_line(const Members& members) const
    {
        std::vector<Flat> places;
        for (const Point& p : members.flat)
            places.push_back(p.head<2>());
        return lie_on_a_line(places, beside_line * noise_);
    }

    bool cover_an_area(const Members& members) const
    {
        const NeighbourSearch search(members.flat);
        std::vector<int> near;
        int asked = 0, as_area = 0;
        for (std::size_t k = 0; k < members.flat.size(); k += members.flat.size() / most_asked + 1)
        {
            const double radius = choose_reach(search, members.flat[k]);
            search.within(members.flat[k], radius, near);
            const double few = double(near.size());
            search.within(members.flat[k], 4 * radius, near);
            as_area += double(near.size()) > as_in_area * few;
            ++asked;
        }
        return as_area > (1 - strays[2]) * asked;
    }

    /// Least squares through the members.
    NoisyPlane fit(const Members& members) const
    {
        const double count = double(members.flat.size());
        Eigen::Vector3d right = Eigen::Vector3d::Zero();
        Eigen::Matrix3d left = Eigen::Matrix3d::Zero();
        for (std::size_t k = 0; k < members.flat.size(); ++k)
        {
            const Eigen::Vector3d row(members.flat[k].x(), members.flat[k].y(), 1);
            left += row * row.transpose() / count;
            right += row * members.heights[k] / count;
        }
        const Eigen::Vector3d tilt = left.ldlt().solve(right);
        NoisyPlane result = members.plane;
        result.origin += tilt.z() * result.normal;
        result.normal = (result.normal - tilt.x() * members.first - tilt.y() * members.second).normalized();
        return result;
    }

    /// Draws points that lie along curves onto these: each moves across the main direction of those around it.
    Points draw_rims(const Members& members) const
    {
        const NeighbourSearch search(members.flat);
        Points drawn = members.flat;
        std::vector<int> near;
        for (Point& p : drawn)
        {
            const double radius = choose_reach(search, p);
            for (int round = 0; round < rounds; ++round)
            {
                const Moments moments = sum_up(members, search, p, radius, near);
                if (near.empty())
                    break;
                const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(moments.spread);
                const Flat along = solver.eigenvectors().col(1), off = (moments.mean - p).head<2>();
                p.head<2>() += off - along.dot(off) * along;
            }
        }
        return drawn;
    }

    /// One point for all within reach of each that stays, their mean.
    Points merge(const Points& drawn, double step) const
    {
        const NeighbourSearch around(drawn);
        std::vector<double> radii;
        for (const Point& p : drawn)
        {
            int indices[of_a_spot + 1];
            double squared[of_a_spot + 1];
            const int count = around.nearest(p, of_a_spot + 1, indices, squared);
            radii.push_back(std::max(step * noise_, spot_share * std::sqrt(squared[count - 1])));
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
            if (counts[k] >= fewest_share * usual || radii[std::size_t(kept[k])] > 2 * step * noise_)
                result.push_back(sums[k] / counts[k]);
        return result;
    }

    struct FilledRims
    {
        std::vector<Flat> rims;
        PlanarFaces found; ///< Bare ones.
    };

    FilledRims fill(const Points& drawn, double step) const
    {
        FilledRims result;
        for (const Point& p : merge(drawn, step))
            result.rims.push_back(p.head<2>());
        result.found = fill_planar_rims(result.rims, *std::rbegin(strays));
        std::vector<PlanarFace>& faces = result.found.faces;
        faces.erase(std::remove_if(faces.begin(), faces.end(),
                                   [&](const PlanarFace& face) { return !is_bare(face, result.rims); }),
                    faces.end());
        drop_discs_within(faces, result.rims);
        return result;
    }

    /// Of the steps the first with faces that leaves out the least share.
    FilledRims fill(const Points& drawn) const
    {
        std::vector<FilledRims> tried;
        for (const double left_out : strays)
            for (std::size_t k = 0; k < std::size(rim_steps); ++k)
            {
                if (k == tried.size())
                    tried.push_back(fill(drawn, rim_steps[k]));
                const PlanarFaces& found = tried[k].found;
                if (!found.faces.empty() && are_all_but(left_out, found.on_rims, tried[k].rims.size()))
                    return std::move(tried[k]);
            }
        return {};
    }

    NoisyFaces find_on(const NoisyPlane& found) const
    {
        NoisyFaces result;
        Members members = list_members(found);
        if (are_on_a_line(members))
            return result;
        members = drop_leaning(members);
        if (int(members.flat.size()) < fewest_samples || cover_an_area(members))
            return result;
        const NoisyPlane plane = fit(members);
        members = drop_leaning(list_members(plane));
        if (int(members.flat.size()) < fewest_samples)
            return result;
        const auto [rims, found_faces] = fill(draw_rims(members));
        for (const PlanarFace& planar : found_faces.faces)
        {
            FlatFace face;
            face.origin = plane.origin;
            face.normal = plane.normal;
            std::map<int, int> of_rim;
            for (const int v : planar.rim)
            {
                of_rim[v] = int(result.rims.size());
                face.rim.push_back(int(result.rims.size()));
                result.rims.push_back(plane.origin + rims[v].x() * members.first + rims[v].y() * members.second);
            }
            for (const auto& t : planar.triangles)
                face.triangles.push_back({of_rim[t[0]], of_rim[t[1]], of_rim[t[2]]});
            if (!settle(face, result.rims))
                continue;
            find_away(face, result.rims);
            result.faces.push_back(std::move(face));
        }
        return result;
    }

    /// Fits a face's plane to the points around its rims alone, and puts these on it. \returns whether they lie in it
    /// but for noise; in any slab through a body they fill it evenly.
    bool settle(FlatFace& face, Points& rims) const
    {
        std::vector<int> around, near;
        for (const int v : face.rim)
        {
            search_.within(rims[v], reach * noise_, near);
            around.insert(around.end(), near.begin(), near.end());
        }
        std::sort(around.begin(), around.end());
        around.erase(std::unique(around.begin(), around.end()), around.end());
        NoisyPlane plane = {face.origin, face.normal};
        const PointsOfPlanes fitted(points_, around);
        if (!fitted.refit(plane, noise_) || !fitted.refit(plane, noise_))
            return false;
        double squared = 0, count = 0;
        for (const int i : around)
        {
            const double height = plane.height(points_[i]) / noise_;
            if (std::abs(height) > slab_half)
                continue;
            squared += height * height;
            ++count;
        }
        face.origin = plane.origin;
        face.normal = plane.normal;
        for (const int v : face.rim)
            rims[v] -= plane.height(rims[v]) * plane.normal;
        return squared <= widest_spread * widest_spread * count;
    }

    /// A disc in a hole of another face is more often what crosses the plane there.
    static void drop_discs_within(std::vector<PlanarFace>& faces, const std::vector<Flat>& rims)
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
    bool is_bare(const PlanarFace& face, const std::vector<Flat>& rims) const
    {
        if (int(face.rim.size()) < fewest_samples)
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
        return area > 0.5 * length * std::max(least_width * length / double(face.rim.size()), 4 * noise_);
    }

    const Points& points_;
    double noise_;
    Leaning leaning_;
    BlockSearch search_;
};

} // namespace

void append(NoisyFaces&& more, NoisyFaces& all)
{
    const int before = int(all.rims.size());
    all.rims.insert(all.rims.end(), more.rims.begin(), more.rims.end());
    for (FlatFace& face : more.faces)
    {
        for (auto& t : face.triangles)
            for (int& v : t)
                v += before;
        for (int& v : face.rim)
            v += before;
        all.faces.push_back(std::move(face));
    }
}

NoisyFaces find_noisy_faces_on(const Points& points, const std::vector<NoisyPlane>& planes, double noise,
                               Leaning leaning, int threads)
{
    return NoisyFaceFinder(points, noise, leaning).find_on(planes, threads, {});
}

NoisyFaces find_noisy_faces(const Points& points, double noise, Leaning leaning, int threads, const Progress& progress)
{
    return NoisyFaceFinder(points, noise, leaning).find(threads, progress);
}

} // namespace recon
