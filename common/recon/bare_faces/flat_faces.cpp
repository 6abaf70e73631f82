#include <recon/bare_faces/flat_faces.h>

#include <recon/bare_faces/planar_faces.h>
#include <recon/median.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/search/keep_apart.h>
#include <recon/search/neighbours.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr int most_seeds = 2000, around = 16;
/// Samples around a seed that must lie in one plane with it, of `around`.
constexpr int fewest_around = 6;
/// Share of its rim samples that may see the surface fold in over the ground.
constexpr double folded_rims = 0.2;
/// Share of a disc's rim along which it meets one other face.
constexpr double shared_rim = 0.7;
/// Samples of a level are no farther apart than this in height [tolerances].
constexpr double level_step = 0.2;
/// A curve of samples has two beside each, amid others there are six: most there may be within so many spacings.
constexpr int most_beside_on_curve = 4;
constexpr double nearby = 1.5;
/// Circumradius of a planar Delaunay triangle, in rim spacings, above which it is bare ground.
constexpr double bare_above = 1.2;

struct Plane
{
    Point origin = Point::Zero();
    Vector normal = Vector::Zero();
    double tolerance = 0;

    double height(const Point& p) const { return normal.dot(p - origin); }
    bool holds(const Point& p) const { return std::abs(height(p)) <= tolerance; }
};

using SeedPlanes = std::array<Plane, 3>;

struct Neighbourhood
{
    int count = 0;
    int indices[around];
    double squared[around];
};

Neighbourhood look_around(const BlockSearch& search, const Point& p)
{
    Neighbourhood result;
    result.count = search.nearest(p, around, result.indices, result.squared);
    return result;
}

void fit(Plane& plane, const Points& samples, const std::vector<int>& members)
{
    Point centre = Point::Zero();
    for (const int i : members)
        centre += samples[i];
    centre /= double(members.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const int i : members)
        spread += (samples[i] - centre) * (samples[i] - centre).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
    plane.origin = centre;
    // Through what is all on one straight rim go many planes: it says nothing but that it lies in this one.
    const double across = solver.eigenvalues()[1] / double(members.size());
    if (across <= plane.tolerance * plane.tolerance)
    {
        const Vector along = solver.eigenvectors().col(2);
        plane.normal = (plane.normal - plane.normal.dot(along) * along).normalized();
        return;
    }
    const Vector normal = solver.eigenvectors().col(0);
    plane.normal = normal.dot(plane.normal) < 0 ? Vector(-normal) : normal;
}

class FlatFaceFinder
{
public:
    FlatFaceFinder(const Points& samples, const FlatFaceOptions& options)
        : samples_(samples), options_(options), search_(samples, options.threads)
    {
    }

    FlatFaces find(const Progress& progress)
    {
        const int n = int(samples_.size());
        const int stride = std::max(1, n / most_seeds);
        std::vector<int> seeds;
        for (int i = 0; i < n; i += stride)
            seeds.push_back(i);
        std::vector<SeedPlanes> around_seed(seeds.size());
        parallel_for(seeds.size(), options_.threads, progress.part(0, 0.7, "flat faces"),
                     [&](std::size_t k)
                     {
                         const Neighbourhood near = look_around(search_, samples_[seeds[k]]);
                         around_seed[k] = fit_around(seeds[k], near);
                     });
        std::vector<Plane> candidates;
        for (const SeedPlanes& planes : around_seed)
            std::copy_if(planes.begin(), planes.end(), std::back_inserter(candidates),
                         [](const Plane& plane) { return plane.tolerance > 0; });
        FlatFaces found;
        // Few enough at a time that they seldom grow into the same plane.
        constexpr std::size_t batch = 16;
        for (std::size_t begin = 0; begin < candidates.size(); begin += batch)
        {
            progress.part(0.7, 1, "flat faces").report(double(begin) / double(candidates.size()));
            std::vector<Plane> grown;
            for (std::size_t k = begin; k < std::min(begin + batch, candidates.size()); ++k)
                if (!is_known(candidates[k]))
                    grown.push_back(candidates[k]);
            std::vector<std::vector<int>> members(grown.size());
            parallel_for(
                grown.size(), options_.threads, {}, [&](std::size_t k) { members[k] = grow(grown[k]); }, 1);
            for (std::size_t k = 0; k < grown.size(); ++k)
            {
                if (int(members[k].size()) < options_.fewest_samples || is_known(grown[k]))
                    continue;
                planes_.push_back(grown[k]);
                append_faces(grown[k], members[k], found);
            }
        }
        drop_mouths(found);
        append_levels(found);
        return found;
    }

private:
    /// The planes that hold most of the samples around a seed, as many as meet at a corner; tolerance 0 where there is
    /// none with bare ground at the seed.
    SeedPlanes fit_around(int seed, const Neighbourhood& near) const
    {
        const Point& p = samples_[seed];
        SeedPlanes best;
        if (near.count < fewest_around)
            return best;
        const double spacing = std::sqrt(near.squared[2]);
        std::array<int, std::tuple_size<SeedPlanes>::value> most;
        most.fill(fewest_around - 1);
        Plane plane;
        plane.origin = p;
        plane.tolerance = options_.tolerance * spacing;
        for (int a = 1; a < std::min(near.count, 5); ++a)
            for (int b = a + 1; b < near.count; ++b)
            {
                const Vector u = samples_[near.indices[a]] - p, v = samples_[near.indices[b]] - p;
                const Vector across = u.cross(v);
                const double squared = across.squaredNorm();
                if (squared < 1e-4 * near.squared[a] * near.squared[b])
                    continue;
                plane.normal = across / std::sqrt(squared);
                int count = 0;
                for (int j = 0; j < near.count; ++j)
                    count += plane.holds(samples_[near.indices[j]]);
                // In the place of one that is nearly the same, else of the poorest.
                std::size_t place = std::size_t(std::min_element(most.begin(), most.end()) - most.begin());
                for (std::size_t k = 0; k < best.size(); ++k)
                    if (std::abs(best[k].normal.dot(plane.normal)) > 0.95)
                        place = k;
                if (count > most[place])
                {
                    most[place] = count;
                    best[place] = plane;
                }
            }
        for (Plane& found : best)
            if (found.tolerance > 0 && !has_bare_ground(found, spacing))
                found.tolerance = 0;
        return best;
    }

    bool has_bare_ground(const Plane& plane, double spacing) const
    {
        const Vector first = plane.normal.unitOrthogonal(), second = plane.normal.cross(first);
        for (int k = 0; k < 8; ++k)
        {
            const double angle = k * 0.25 * pi;
            const Point q = plane.origin + 4 * spacing * (std::cos(angle) * first + std::sin(angle) * second);
            if ((samples_[search_.nearest(q)] - q).norm() > 3 * spacing)
                return true;
        }
        return false;
    }

    bool is_known(const Plane& plane) const
    {
        return std::any_of(planes_.begin(), planes_.end(),
                           [&](const Plane& known)
                           { return known.holds(plane.origin) && is_parallel(known, plane.normal); });
    }
    static bool is_parallel(const Plane& plane, const Vector& normal)
    {
        return std::abs(plane.normal.dot(normal)) > 0.999;
    }

    /// Fits the plane to ever more of its samples. \returns all it has.
    std::vector<int> grow(Plane& plane) const
    {
        const Neighbourhood near = look_around(search_, plane.origin);
        const Point seed = plane.origin;
        std::vector<int> found, members;
        for (double radius = std::sqrt(near.squared[near.count - 1]);; radius *= 2)
        {
            search_.within(seed, radius, found);
            members.clear();
            for (const int i : found)
                if (plane.holds(samples_[i]))
                    members.push_back(i);
            std::sort(members.begin(), members.end());
            if (int(members.size()) < (found.size() > 1000 ? options_.fewest_samples : fewest_around) || radius > 1)
                return members;
            fit(plane, samples_, members);
        }
    }

    /// Whether the surface crosses the plane at a sample, instead of ending or bending there.
    bool is_crossing(const Plane& plane, int sample) const
    {
        const Neighbourhood near = look_around(search_, samples_[sample]);
        Vector nearest[2] = {Vector::Zero(), Vector::Zero()};
        for (int j = near.count - 1; j > 0; --j)
        {
            const Vector offset = samples_[near.indices[j]] - samples_[sample];
            const double height = plane.normal.dot(offset);
            if (std::abs(height) > std::max(2 * plane.tolerance, 0.3 * offset.norm()))
                nearest[height > 0] = offset;
        }
        const double below = nearest[0].norm(), above = nearest[1].norm();
        return below > 0 && above > 0 && std::max(below, above) < 1.5 * std::min(below, above) &&
               nearest[0].dot(nearest[1]) < -0.5 * below * above;
    }

    /// Where most of a few members lie in their plane.
    struct Ground
    {
        bool is_bare;  ///< On rims of bare ground: neither amid others, nor where the surface crosses the plane.
        bool has_rims; ///< On curves at least.
    };
    Ground look_at_ground(const Plane& plane, const std::vector<int>& members) const
    {
        constexpr int few = 40;
        const int count = std::min(few, int(members.size()));
        int on_bare_ground = 0, on_curves = 0;
        for (int k = 0; k < count; ++k)
        {
            const int v = members[members.size() * std::size_t(k) / std::size_t(count)];
            const Neighbourhood near = look_around(search_, samples_[v]);
            Plane here = plane;
            here.origin = samples_[v];
            on_bare_ground += !is_crossing(plane, v) && has_bare_ground(here, std::sqrt(near.squared[2]));
            int beside = 0;
            for (int j = 1; j < near.count; ++j)
                beside += near.squared[j] < nearby * nearby * near.squared[2] && plane.holds(samples_[near.indices[j]]);
            on_curves += beside <= most_beside_on_curve;
        }
        return {2 * on_bare_ground >= count, 2 * on_curves >= count};
    }

    /// Share of rim samples at which samples nearby lie above or below the face's ground: there the surface folds in
    /// over it.
    double measure_folds(const Plane& plane, const FlatFace& face) const
    {
        std::map<int, std::vector<std::array<int, 2>>> wedges;
        for (const auto& t : face.triangles)
            for (int i = 0; i < 3; ++i)
                wedges[t[i]].push_back({t[(i + 1) % 3], t[(i + 2) % 3]});
        std::map<int, std::vector<int>> along;
        for (const auto& [a, b] : list_border_edges(face.triangles))
        {
            along[a].push_back(b);
            along[b].push_back(a);
        }
        const Points rim = points_at(face.rim, samples_);
        const NeighbourSearch rim_search(rim);
        const auto distance_to_rim = [&](const Point& q)
        {
            int nearest[3];
            double squared[3], least = 1e300;
            const int found = rim_search.nearest(q, 3, nearest, squared);
            for (int j = 0; j < found; ++j)
                for (const int w : along[face.rim[nearest[j]]])
                {
                    const Vector edge = samples_[w] - rim[nearest[j]], offset = q - rim[nearest[j]];
                    const double t = std::clamp(offset.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
                    least = std::min(least, (offset - t * edge).norm());
                }
            return least;
        };
        int folded = 0;
        for (const int v : face.rim)
        {
            const Point& p = samples_[v];
            const Neighbourhood near = look_around(search_, p);
            bool is_folded = false;
            double reach = 16 * near.squared[std::min(2, near.count - 1)]; // farther off it is another part
            for (int j = 1; j < near.count && near.squared[j] < reach; ++j)
            {
                const Vector offset = samples_[near.indices[j]] - p;
                const double height = plane.normal.dot(offset);
                const Vector lateral = offset - height * plane.normal;
                if (std::abs(height) <= 2 * plane.tolerance)
                    continue;
                // What is much farther than the nearest may be the other side of a sheet.
                reach = std::min(reach, 2 * near.squared[j]);
                if (distance_to_rim(p + lateral) < 0.3 * std::abs(height))
                    continue;
                for (const auto& w : wedges[v])
                    is_folded |= plane.normal.dot((samples_[w[0]] - p).cross(lateral)) > 0 &&
                                 plane.normal.dot(lateral.cross(samples_[w[1]] - p)) > 0;
            }
            folded += is_folded;
        }
        return face.rim.empty() ? 1 : double(folded) / double(face.rim.size());
    }

    /// Leaves samples at least `distance` apart: equal ones would be ends of rims.
    void thin(double distance, std::vector<int>& indices) const
    {
        const std::vector<double> radii(indices.size(), distance);
        std::vector<int> left;
        for (const int k : keep_apart(points_at(indices, samples_), radii))
            left.push_back(indices[k]);
        indices = std::move(left);
    }

    /// A disc may as well be the mouth of a hollow. It is a face where it meets one other face along its rim, as on a
    /// polyhedron; at a mouth two others meet, or none is flat.
    void drop_mouths(FlatFaces& found) const
    {
        std::vector<int> count(samples_.size(), 0);
        for (const FlatFace& face : found.bare)
            for (const int v : face.rim)
                ++count[v];
        const auto is_mouth = [&](const FlatFace& face)
        {
            // A face with holes has as many triangles as rim samples, or more.
            if (face.triangles.size() >= face.rim.size())
                return false;
            const auto shared = std::count_if(face.rim.begin(), face.rim.end(), [&](int v) { return count[v] == 2; });
            return double(shared) < shared_rim * double(face.rim.size());
        };
        const auto mouths = std::stable_partition(found.bare.begin(), found.bare.end(),
                                                  [&](const FlatFace& face) { return !is_mouth(face); });
        std::move(mouths, found.bare.end(), std::back_inserter(found.mere_rims));
        found.bare.erase(mouths, found.bare.end());
    }

    /// Median of its rim.
    double measure_spacing(const FlatFace& face) const
    {
        std::vector<double> spacings;
        for (const int v : face.rim)
            spacings.push_back(std::sqrt(look_around(search_, samples_[v]).squared[2]));
        return median(std::move(spacings));
    }

    /// Whether some of the face lies far from its rim, in spacings of the rim.
    bool is_bare(const FlatFace& face) const
    {
        const double spacing = measure_spacing(face);
        double largest = 0;
        for (const auto& t : face.triangles)
        {
            const Vector u = samples_[t[1]] - samples_[t[0]], v = samples_[t[2]] - samples_[t[0]];
            const double twice = u.cross(v).norm();
            largest = std::max(largest, u.norm() * v.norm() * (u - v).norm() / (2 * twice));
        }
        return largest > bare_above * spacing;
    }

    void append_faces(const Plane& plane, const std::vector<int>& members, FlatFaces& found) const
    {
        const Ground ground = look_at_ground(plane, members);
        if (!ground.is_bare)
        {
            if (ground.has_rims)
                append(list_regions(plane, members), found.mere_rims);
            return;
        }
        std::vector<int> uncrossed;
        std::copy_if(members.begin(), members.end(), std::back_inserter(uncrossed),
                     [&](int i) { return !is_crossing(plane, i); });
        for (FlatFace& face : list_regions(plane, std::move(uncrossed)))
        {
            const bool is_face = measure_folds(plane, face) <= folded_rims;
            (!is_face ? found.mere_rims : is_bare(face) ? found.bare : found.narrow).push_back(std::move(face));
        }
    }

    static void append(std::vector<FlatFace>&& regions, std::vector<FlatFace>& list)
    {
        std::move(regions.begin(), regions.end(), std::back_inserter(list));
    }

    /// What the rims of a plane enclose.
    std::vector<FlatFace> list_regions(const Plane& plane, std::vector<int> on_plane) const
    {
        thin(plane.tolerance, on_plane);
        std::vector<FlatFace> regions;
        if (int(on_plane.size()) < options_.fewest_samples)
            return regions;
        const Vector first = plane.normal.unitOrthogonal(), second = plane.normal.cross(first);
        std::vector<Eigen::Vector2d> flat;
        for (const int i : on_plane)
            flat.emplace_back(first.dot(samples_[i] - plane.origin), second.dot(samples_[i] - plane.origin));
        if (lie_on_a_line(flat, plane.tolerance))
            return regions;
        for (const PlanarFace& planar : fill_planar_rims(flat, 0).faces)
        {
            FlatFace region;
            region.origin = plane.origin;
            region.normal = plane.normal;
            for (const auto& t : planar.triangles)
                region.triangles.push_back({on_plane[t[0]], on_plane[t[1]], on_plane[t[2]]});
            for (const int v : planar.rim)
                region.rim.push_back(on_plane[v]);
            if (int(region.rim.size()) >= options_.fewest_samples)
                regions.push_back(std::move(region));
        }
        return regions;
    }

    /// Rims on levels that no seed's neighbours show: those of a fillet lie nearer to each other than their samples.
    void append_levels(FlatFaces& found) const
    {
        std::vector<Plane> directions;
        for (const FlatFace& face : found.bare)
        {
            const auto is_along = [&](const Plane& plane) { return is_parallel(plane, face.normal); };
            if (std::any_of(directions.begin(), directions.end(), is_along))
                continue;
            Plane plane;
            plane.origin = Point::Zero();
            plane.normal = face.normal;
            plane.tolerance = options_.tolerance * measure_spacing(face);
            directions.push_back(plane);
        }
        for (const Plane& plane : directions)
            append_levels_along(plane, found);
    }

    void append_levels_along(const Plane& direction, FlatFaces& found) const
    {
        std::vector<std::pair<double, int>> heights;
        for (int i = 0; i < int(samples_.size()); ++i)
            heights.emplace_back(direction.height(samples_[i]), i);
        std::sort(heights.begin(), heights.end());
        for (auto begin = heights.begin(), end = begin; begin != heights.end(); begin = end)
        {
            end = std::adjacent_find(begin, heights.end(),
                                     [&](const auto& a, const auto& b)
                                     { return b.first - a.first > level_step * direction.tolerance; });
            end = end == heights.end() ? end : end + 1;
            if (end - begin < options_.fewest_samples || (end - 1)->first - begin->first > 2 * direction.tolerance)
                continue;
            Plane level = direction;
            level.origin = samples_[begin->second];
            if (std::any_of(planes_.begin(), planes_.end(),
                            [&](const Plane& known) {
                                return is_parallel(known, level.normal) &&
                                       std::abs(known.height(level.origin)) < 4 * level.tolerance;
                            }))
                continue;
            std::vector<int> members;
            std::transform(begin, end, std::back_inserter(members), [](const auto& entry) { return entry.second; });
            std::sort(members.begin(), members.end());
            if (look_at_ground(level, members).has_rims)
                append(list_regions(level, std::move(members)), found.mere_rims);
        }
    }

    const Points& samples_;
    const FlatFaceOptions& options_;
    BlockSearch search_;
    std::vector<Plane> planes_;
};

} // namespace

FlatFaces find_flat_faces(const Points& samples, const FlatFaceOptions& options, const Progress& progress)
{
    if (int(samples.size()) < options.fewest_samples)
        return {};
    return FlatFaceFinder(samples, options).find(progress);
}

} // namespace recon
