#include <recon/bare_faces/complete_noisy_flats.h>

#include <recon/bare_faces/noisy_faces.h>
#include <recon/bare_faces/noisy_walls.h>
#include <recon/bare_faces/wall_samples.h>
#include <recon/bare_faces/way_out.h>

#include <recon/bare_faces/complete_flats.h>
#include <recon/median.h>
#include <recon/search/keep_apart.h>
#include <recon/search/neighbours.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <optional>

namespace recon
{
namespace
{

/// Distance of samples on walls [rim spacings].
constexpr double wall_density = 0.4;
/// Nearer than this to samples of an earlier wall whose normals agree as much, but so far off that wall, a wall gets
/// none [rim spacings; cosine; noise].
constexpr double beside_wall = 1.2, same_wall = 0.5, off_wall = 1;
/// Denoised samples so near to the new ones give way: no surface could be fitted there [noise].
constexpr double replaced_within = 3.5;
/// Share of a face's rim that has walls, at least.
constexpr double least_walled = 0.5;
/// Mean cosine of normals around a rim with that of the face above which they tell its outer side.
constexpr double agreeing = 0.1;
/// Cosine between the normals of planes that are the same if a place lies in both.
constexpr double parallel = 0.99;
/// Faces of two slabs are the same if their planes are, and centres and sizes of their boxes differ by less than this
/// share of the size.
constexpr double same_box = 0.15;
/// Share of a rim above which larger faces account for it.
constexpr double explained = 0.7;

class NoisyFlatCompleter
{
public:
    NoisyFlatCompleter(const Points& points, double noise, const Points& samples, const Vectors& normals)
        : noise_(noise), samples_(samples), normals_(normals), walls_(points, noise), sample_search_(samples)
    {
        result_.is_replaced.assign(samples.size(), 0);
    }

    NoisyFlatCompletion complete(const NoisyFaces& found, int threads)
    {
        rim_normals_.assign(found.rims.size(), Vector::Zero());
        std::vector<FlatFace> faces;
        std::vector<WalledFace> walled = std::move(walled_);
        std::vector<FlatFace> bounded;
        for (const WalledFace& entry : walled)
            bounded.push_back(entry.face);
        const WayOut way_out(found, bounded, samples_, noise_);
        for (WalledFace& entry : walled)
        {
            if (is_explained(entry.face, found.rims))
                continue;
            if (!turn_outward(entry, found.rims, way_out) || !raise_walls(entry, found.rims))
                continue;
            for (const int v : entry.face.rim)
                placed_.push_back(found.rims[v]);
            planes_.push_back({entry.face.origin, entry.face.normal});
            faces.push_back(std::move(entry.face));
        }
        for (std::size_t v = 0; v < found.rims.size(); ++v)
            if (rim_normals_[v].norm() > 0.1)
                append(found.rims[v], rim_normals_[v].normalized());
        const OrientedSamples on_walls = choose_wall_samples();
        for (std::size_t i = 0; i < on_walls.points.size(); ++i)
            append(on_walls.points[i], on_walls.normals[i]);
        Points present = result_.points;
        for (std::size_t i = 0; i < samples_.size(); ++i)
            if (!result_.is_replaced[i])
                present.push_back(samples_[i]);
        for (const FlatFace& face : faces)
            for (const Point& p : fill_face(face, found.rims, present, threads))
                append(p, face.normal);
        for (const Base& base : bases_)
            for (const Point& p : fill_face(base.face, base.rims, present, threads))
                append(p, base.face.normal);
        return std::move(result_);
    }

    /// Takes in those faces from `first` on that have walls; of one that is known the version with more of them stays.
    void add_walled(const NoisyFaces& found, std::size_t first)
    {
        const auto known = std::ptrdiff_t(walled_.size());
        for (std::size_t k = first; k < found.faces.size(); ++k)
        {
            std::optional<WalledFace> entry = make_walled(found.faces[k], found.rims);
            if (!entry)
                continue;
            const auto same = std::find_if(walled_.begin(), walled_.begin() + known,
                                           [&](const WalledFace& other) { return is_same(*entry, other); });
            if (same == walled_.begin() + known)
                walled_.push_back(std::move(*entry));
            else if (entry->walled > same->walled)
                *same = std::move(*entry);
        }
        std::stable_sort(walled_.begin(), walled_.end(),
                         [](const WalledFace& a, const WalledFace& b) { return a.area > b.area; });
    }

    /// Planes parallel to a face, in which none lies, where walls end that fall off from it.
    std::vector<NoisyPlane> list_planes_at_wall_ends(const NoisyFaces& found) const
    {
        std::vector<NoisyPlane> known, result;
        for (const FlatFace& face : found.faces)
            known.push_back({face.origin, face.normal});
        for (const WalledFace& entry : walled_)
        {
            const double outline = find_outline(entry.loops);
            double solid = 0; // is where the outline's wall is
            for (std::size_t k = 0; k < entry.loops.size(); ++k)
                if (entry.loops[k].box == outline)
                    solid = entry.walls[k].side;
            for (std::size_t k = 0; k < entry.loops.size(); ++k)
            {
                const RimWall& wall = entry.walls[k];
                if (wall.side == 0 || wall.side != solid || !wall.steps.empty())
                    continue;
                const Point& foot = found.rims[entry.loops[k].rim.front()];
                const NoisyPlane plane{foot + wall.side * wall.height * entry.face.normal, entry.face.normal};
                if (is_among(plane, known))
                    continue;
                known.push_back(plane);
                result.push_back(plane);
            }
        }
        return result;
    }

private:
    bool is_among(const NoisyPlane& plane, const std::vector<NoisyPlane>& planes) const
    {
        return std::any_of(planes.begin(), planes.end(),
                           [&](const NoisyPlane& other) { return is_same(plane, other); });
    }

    /// Whether `b` is parallel and holds the origin of `a`.
    bool is_same(const NoisyPlane& a, const NoisyPlane& b) const
    {
        return std::abs(b.normal.dot(a.normal)) > parallel && std::abs(b.height(a.origin)) < slab_half * noise_;
    }

    /// A face, its rims, and the wall along each.
    struct WalledFace
    {
        FlatFace face;
        std::vector<RimLoop> loops;
        std::vector<RimWall> walls;
        Eigen::AlignedBox3d box;
        double area = 0;
        double walled = 0; ///< Length of its rims that have walls.
    };

    bool is_same(const WalledFace& a, const WalledFace& b) const
    {
        const double size = b.box.diagonal().norm();
        return is_same({a.face.origin, a.face.normal}, NoisyPlane{b.face.origin, b.face.normal}) &&
               (a.box.center() - b.box.center()).norm() < same_box * size &&
               std::abs(a.box.diagonal().norm() - size) < same_box * size;
    }

    /// What may become samples of a wall.
    struct RaisedWall
    {
        OrientedSamples samples;
        std::vector<double> gaps; ///< To the next of each [length].
    };

    /// What two faces say of a wall between them may differ by what noise leaves of their rims: samples of both would
    /// make grooves, so those of the larger face stay.
    OrientedSamples choose_wall_samples() const
    {
        OrientedSamples chosen;
        for (const RaisedWall& raised : raised_)
        {
            const OrientedSamples& wall = raised.samples;
            std::optional<NeighbourSearch> others;
            if (!chosen.points.empty())
                others.emplace(chosen.points);
            std::vector<double> apart;
            for (const double gap : raised.gaps)
                apart.push_back(wall_density * gap);
            const auto is_new = [&](int i)
            {
                if (!others)
                    return true;
                const int nearest = others->nearest(wall.points[i]);
                const Vector offset = wall.points[i] - chosen.points[nearest], normal = chosen.normals[nearest];
                return offset.norm() > beside_wall * raised.gaps[i] || normal.dot(wall.normals[i]) < same_wall ||
                       std::abs(offset.dot(normal)) < off_wall * noise_;
            };
            for (const int i : keep_apart(wall.points, apart, is_new))
            {
                chosen.points.push_back(wall.points[i]);
                chosen.normals.push_back(wall.normals[i]);
            }
        }
        return chosen;
    }

    void append(const Point& p, const Vector& normal)
    {
        result_.points.push_back(p);
        result_.normals.push_back(normal);
        sample_search_.within(p, replaced_within * noise_, near_);
        for (const int i : near_)
            result_.is_replaced[i] = 1;
    }

    /// A face that has walls along enough of its rims, on whichever side.
    std::optional<WalledFace> make_walled(const FlatFace& face, const Points& rims)
    {
        WalledFace entry;
        entry.face = face;
        entry.loops = list_rim_loops(face, rims);
        for (const auto& t : face.triangles)
            entry.area += 0.5 * (rims[t[1]] - rims[t[0]]).cross(rims[t[2]] - rims[t[0]]).norm();
        for (const int v : face.rim)
            entry.box.extend(rims[v]);
        find_walls(entry, rims);
        double length = 0;
        for (const RimWall& wall : entry.walls)
        {
            length += wall.length;
            entry.walled += wall.side != 0 ? wall.length : 0;
        }
        return entry.walled >= least_walled * length ? std::optional(std::move(entry)) : std::nullopt;
    }

    void find_walls(WalledFace& entry, const Points& rims)
    {
        const double outline = find_outline(entry.loops);
        entry.walls.clear();
        for (const RimLoop& loop : entry.loops)
            entry.walls.push_back(walls_.find(entry.face, loop, rims, loop.box < outline));
    }

    /// Box of the loop around all others.
    static double find_outline(const std::vector<RimLoop>& loops)
    {
        double outline = 0;
        for (const RimLoop& loop : loops)
            outline = std::max(outline, loop.box);
        return outline;
    }

    /// Whether the rim lies on rims and walls of larger faces: then these have its ground already.
    bool is_explained(const FlatFace& face, const Points& rims) const
    {
        if (placed_.empty())
            return false;
        const NeighbourSearch search(placed_);
        const auto near = std::count_if(
            face.rim.begin(), face.rim.end(),
            [&](int v) { return (placed_[search.nearest(rims[v])] - rims[v]).norm() < replaced_within * noise_; });
        return double(near) > explained * double(face.rim.size());
    }

    /// By where straight lines get away; else by what the denoised samples around the rims say together: each alone
    /// knows little, and beyond bare walls all may be wrong. \returns whether one of these tells; where none does the
    /// plane is a cut through a body whose samples lie in rows.
    bool turn_outward(WalledFace& entry, const Points& rims, const WayOut& way_out)
    {
        std::vector<double> spacings;
        for (const RimLoop& loop : entry.loops)
            spacings.push_back(median(loop.gaps));
        const int way = way_out.find(entry.face, std::max(replaced_within * noise_, median(std::move(spacings))));
        double along = way;
        if (way == 0)
            for (const int v : entry.face.rim)
                along += normals_[sample_search_.nearest(rims[v])].dot(entry.face.normal);
        if (along < 0)
            turn(entry, rims);
        return way != 0 || std::abs(along) > agreeing * double(entry.face.rim.size());
    }

    /// Walls are not the same seen from behind: only holes in what falls off may end in steps.
    void turn(WalledFace& entry, const Points& rims)
    {
        entry.face.normal = -entry.face.normal;
        for (auto& t : entry.face.triangles)
            std::swap(t[0], t[1]);
        find_walls(entry, rims);
    }

    /// \returns whether most of the face's rim has walls, so that it is a face.
    bool raise_walls(WalledFace& entry, const Points& rims)
    {
        const FlatFace& face = entry.face;
        const std::vector<RimLoop>& loops = entry.loops;
        std::vector<RimWall>& walls = entry.walls;
        if (!is_bounded(entry))
            return false;
        const double depth = find_depth(walls);
        // Above a known opposite face it is enough that most points of a rim have some there.
        for (std::size_t k = 0; k < loops.size() && depth > 0; ++k)
            if (walls[k].height == 0 && walls_.ends_at(loops[k], rims, -depth * face.normal))
            {
                walls[k].height = depth;
                walls[k].side = -1;
            }
        for (const int v : face.rim)
            rim_normals_[v] += face.normal;
        // A face that has its place there already is larger and knows better.
        const bool has_base =
            depth > 0 && !is_among({rims[face.rim.front()] - depth * face.normal, face.normal}, planes_);
        std::vector<char> is_base(rims.size(), 0);
        for (std::size_t k = 0; k < loops.size(); ++k)
            if (walls[k].height > 0)
            {
                const bool ends_at_base =
                    has_base && walls[k].side < 0 && walls[k].steps.empty() && walls_.is_level(walls[k], depth);
                append_wall(face, loops[k], walls[k], rims, ends_at_base);
                if (ends_at_base)
                    for (const int v : loops[k].rim)
                        is_base[v] = 1;
            }
        if (has_base)
            append_base(face, depth, rims, is_base);
        return true;
    }

    /// Walls that rise over the outline of a face count as well, as over the ground of a pocket, if bores show the
    /// solid below; a disc may be the end of a void as well as of a solid.
    static bool is_bounded(const WalledFace& entry)
    {
        const double outline = find_outline(entry.loops);
        bool is_bored = false;
        double length = 0, below = 0, above = 0;
        for (std::size_t k = 0; k < entry.loops.size(); ++k)
        {
            const RimWall& wall = entry.walls[k];
            is_bored |= entry.loops[k].box < outline && wall.side < 0;
            length += wall.length;
            below += wall.side < 0 ? wall.length : 0;
            above += wall.side > 0 ? wall.length : 0;
        }
        return below + (is_bored ? above : 0) >= least_walled * length;
    }

    /// Where the opposite face lies, as of a prism: the height of the walls along most of the rim; 0 if these differ.
    double find_depth(const std::vector<RimWall>& walls) const
    {
        double length = 0;
        for (const RimWall& wall : walls)
            length += wall.length;
        double depth = 0, most = least_walled * length;
        for (const RimWall& wall : walls)
        {
            double same = 0;
            std::vector<double> heights;
            for (const RimWall& other : walls)
                if (wall.side < 0 && other.side < 0 && walls_.is_level(wall, other.height))
                {
                    same += other.length;
                    heights.push_back(other.height);
                }
            if (same > most)
            {
                // A rim may be bevelled; most are not.
                depth = median(heights);
                most = same;
            }
        }
        return depth;
    }

    void append_wall(const FlatFace& face, const RimLoop& loop, const RimWall& wall, const Points& rims,
                     bool ends_at_base)
    {
        const Vector up = wall.side * face.normal;
        const double spacing = median(loop.gaps);
        RaisedWall raised;
        auto& [places, normals] = raised.samples;
        const auto raise = [&](const Point& foot, const Vector& away, double height)
        {
            const Vector normal = -wall.side * away;
            const auto add = [&](double above, double gap, bool is_top)
            {
                places.push_back(foot + above * up);
                placed_.push_back(places.back());
                raised.gaps.push_back(gap);
                normals.push_back(ends_at_base && is_top ? Vector(normal - face.normal).normalized() : normal);
            };
            const double rows = std::max(1.0, std::ceil(height / spacing));
            if (rows <= 2 * even_rows)
            {
                for (int j = 1; j <= int(rows); ++j)
                    add(height * j / rows, spacing, j == int(rows));
                return;
            }
            add(height, spacing, true);
            list_rows(height, spacing,
                      [&](double above, double gap)
                      {
                          add(above, gap, false);
                          add(height - above, gap, false);
                      });
        };
        for (std::size_t k = 0; k < loop.rim.size(); ++k)
            rim_normals_[loop.rim[k]] -= wall.side * loop.away[k];
        for (const auto& edge : loop.edges)
        {
            const Point &a = rims[loop.rim[edge[0]]], &b = rims[loop.rim[edge[1]]];
            const Vector &first = loop.away[edge[0]], &second = loop.away[edge[1]];
            if (first.dot(second) <= 0)
                continue;
            const int pieces = std::max(1, int(std::ceil((b - a).norm() / spacing)));
            for (int j = 0; j < 2 * pieces; ++j)
            {
                const double t = 0.5 * j / pieces;
                const Vector away = ((1 - t) * first + t * second).normalized();
                raise(a + t * (b - a) + wall.out * away, away,
                      wall.steps.empty() ? wall.height : wall.steps[edge[t < 0.5 ? 0 : 1]]);
            }
        }
        raised_.push_back(std::move(raised));
    }

    /// The face again, seen from behind, where rims with walls of that depth are nearest.
    void append_base(const FlatFace& face, double depth, const Points& rims, const std::vector<char>& is_base)
    {
        Base base{face, rims};
        for (const int v : face.rim)
            base.rims[v] -= depth * face.normal;
        base.face.origin -= depth * face.normal;
        base.face.normal = -face.normal;
        auto& triangles = base.face.triangles;
        triangles.erase(std::remove_if(triangles.begin(), triangles.end(),
                                       [&](const std::array<int, 3>& t)
                                       { return !is_base[t[0]] && !is_base[t[1]] && !is_base[t[2]]; }),
                        triangles.end());
        bases_.push_back(std::move(base));
    }

    /// A face's copy on the other side of a prism.
    struct Base
    {
        FlatFace face;
        Points rims;
    };

    double noise_;
    const Points& samples_;
    const Vectors& normals_;
    WallFinder walls_;
    std::vector<WalledFace> walled_; ///< The largest first.
    NeighbourSearch sample_search_;
    std::vector<int> near_;
    std::vector<NoisyPlane> planes_; ///< Of the faces so far.
    Vectors rim_normals_;            ///< Sums over what meets at each rim sample.
    Points placed_;                  ///< On rims and walls so far.
    std::vector<RaisedWall> raised_; ///< Those of the largest face first.
    std::vector<Base> bases_;
    NoisyFlatCompletion result_;
};

} // namespace

NoisyFlatCompletion complete_noisy_flats(const Points& points, double noise, const std::vector<NoisyFaces>& in_slabs,
                                         Leaning leaning, const Points& samples, const Vectors& normals, int threads)
{
    if (std::all_of(in_slabs.begin(), in_slabs.end(), [](const NoisyFaces& some) { return some.faces.empty(); }))
        return {};
    NoisyFlatCompleter completer(points, noise, samples, normals);
    NoisyFaces found;
    const auto add = [&](NoisyFaces more)
    {
        const std::size_t known = found.faces.size();
        append(std::move(more), found);
        completer.add_walled(found, known);
    };
    for (const NoisyFaces& some : in_slabs)
        add(some);
    // A bevel or a fillet beside it hides the plane on the other side of a plate; the bores through it end there.
    add(find_noisy_faces_on(points, completer.list_planes_at_wall_ends(found), noise, leaning, threads));
    return completer.complete(found, threads);
}

} // namespace recon
