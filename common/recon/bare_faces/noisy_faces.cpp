#include <recon/bare_faces/noisy_faces.h>

#include <recon/bare_faces/noisy_rims.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>

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

/// Points this near say where the plane of a face lies [noise].
constexpr double reach = 6;
/// Where four in five of at most so many members have at least this many times as many within four reaches as within
/// one, they cover an area, and lie on no rim: 11 to 12 on walls and floors of scans, up to 8.7 where faces are.
constexpr double as_in_area = 9.75;
constexpr std::size_t most_asked = 500;
/// Within this distance the surface is seen to cross a plane [noise].
constexpr double crossing_reach = 8;
/// Half the width of what noise makes of a line in the plane [noise].
constexpr double beside_line = 4;

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
        Vector first, second; ///< Directions of the places.
        SlabPoints points;
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
                result.points.places.emplace_back(result.first.dot(p - plane.origin),
                                                  result.second.dot(p - plane.origin), 0);
                result.points.heights.push_back(plane.height(p));
            }
        return result;
    }

    /// Leaves out those around which heights lean with the place: there the surface crosses the plane.
    Members drop_leaning(const Members& members) const
    {
        SlabSpots spots(members.points, noise_);
        Members result = members;
        result.points = {};
        for (std::size_t k = 0; k < members.points.places.size(); ++k)
        {
            const Point& p = members.points.places[k];
            if (spots.sum_up(p, spots.choose_radius(p)).is_leaning(leaning_))
                continue;
            result.points.places.push_back(p);
            result.points.heights.push_back(members.points.heights[k]);
        }
        return result;
    }

    bool are_on_a_line(const Members& members) const
    {
        std::vector<Flat> places;
        for (const Point& p : members.points.places)
            places.push_back(p.head<2>());
        return lie_on_a_line(places, beside_line * noise_);
    }

    bool cover_an_area(const SlabPoints& points) const
    {
        SlabSpots spots(points, noise_);
        int asked = 0, as_area = 0;
        for (std::size_t k = 0; k < points.places.size(); k += points.places.size() / most_asked + 1)
        {
            const Point& p = points.places[k];
            const double radius = spots.choose_radius(p), few = spots.count(p, radius);
            as_area += spots.count(p, 4 * radius) > as_in_area * few;
            ++asked;
        }
        return as_area > (1 - *std::rbegin(rim_strays)) * asked;
    }

    /// Least squares through the members.
    NoisyPlane fit(const Members& members) const
    {
        const double count = double(members.points.places.size());
        Eigen::Vector3d right = Eigen::Vector3d::Zero();
        Eigen::Matrix3d left = Eigen::Matrix3d::Zero();
        for (std::size_t k = 0; k < members.points.places.size(); ++k)
        {
            const Eigen::Vector3d row(members.points.places[k].x(), members.points.places[k].y(), 1);
            left += row * row.transpose() / count;
            right += row * members.points.heights[k] / count;
        }
        const Eigen::Vector3d tilt = left.ldlt().solve(right);
        NoisyPlane result = members.plane;
        result.origin += tilt.z() * result.normal;
        result.normal = (result.normal - tilt.x() * members.first - tilt.y() * members.second).normalized();
        return result;
    }

    NoisyFaces find_on(const NoisyPlane& found) const
    {
        NoisyFaces result;
        Members members = list_members(found);
        if (are_on_a_line(members))
            return result;
        members = drop_leaning(members);
        if (int(members.points.places.size()) < fewest_rim_samples || cover_an_area(members.points))
            return result;
        const NoisyPlane plane = fit(members);
        members = drop_leaning(list_members(plane));
        if (int(members.points.places.size()) < fewest_rim_samples)
            return result;
        const auto [rims, found_faces] = fill_noisy_rims(members.points, noise_);
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
