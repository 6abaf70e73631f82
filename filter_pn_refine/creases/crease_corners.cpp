#include "crease_corners.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace recon::pn
{

namespace
{

constexpr double nearest = 1.2;    ///< The nearest sample lies no farther from a corner,
constexpr double farthest = 2.3;   ///< and the nearest places of its edges no farther [spacings].
constexpr double next_on_edge = 4; ///< Places that show that an edge leads to it lie no farther.

class CornerFinder
{
public:
    CornerFinder(const Faces& faces, const std::vector<CreasePlace>& places)
        : faces_(faces), places_(places), positions_(positions_of(places)), search_(positions_)
    {
    }

    std::vector<CreasePlace> propose() const
    {
        std::vector<CreasePlace> proposed;
        std::vector<int> near;
        for (std::size_t i = 0; i < places_.size(); ++i)
        {
            search_.within(places_[i].point, 2 * farthest * places_[i].spacing, near);
            std::sort(near.begin(), near.end());
            CreasePlace corner;
            for (int m : near)
                if (const auto j = std::size_t(m); j > i && !places_[i].is_corner() && !places_[j].is_corner() &&
                                                   corner_of(places_[i], places_[j], corner))
                    proposed.push_back(corner);
        }
        return proposed;
    }

    /// Whether other places show all of a corner's edges; or two, and near samples all of its faces. Else another
    /// plane just cuts an edge there.
    bool is_shown(const CreasePlace& corner) const
    {
        std::vector<int> near;
        search_.within(corner.point, next_on_edge * corner.spacing, near);
        const auto shows = [&](int m, int a, int b)
        { return leads_along(places_[std::size_t(m)], corner.point, a, b); };
        const std::vector<int>& f = corner.around;
        int edges = 0;
        for (std::size_t p = 0; p < f.size(); ++p)
            edges +=
                std::any_of(near.begin(), near.end(), [&](int m) { return shows(m, f[p], f[(p + 1) % f.size()]); });
        return edges == 3 || (edges == 2 && std::all_of(f.begin(), f.end(),
                                                        [&](int face) {
                                                            return faces_.has_sample_near(corner.point, face,
                                                                                          nearest * corner.spacing);
                                                        }));
    }

    /// Marks places on edges nearer to x.
    void mark_near(const Point& x, double distance, std::vector<char>& is_marked) const
    {
        std::vector<int> near;
        search_.within(x, distance, near);
        for (int m : near)
            if (!places_[std::size_t(m)].is_corner())
                is_marked[std::size_t(m)] = 1;
    }

private:
    /// Finds the corner to which edges at two places lead that share a face. \returns whether there is one.
    bool corner_of(const CreasePlace& first, const CreasePlace& second, CreasePlace& corner) const
    {
        constexpr double same_face = 0.9, in_plane = 0.2; // cosine, sine
        const Vector d = second.point - first.point;
        for (std::size_t f = 0; f < 2; ++f)
            for (std::size_t g = 0; g < 2; ++g)
            {
                const int a = first.around[f], b = first.around[1 - f], a2 = second.around[g], c = second.around[1 - g];
                Point x;
                if (faces_.normal(a).dot(faces_.normal(a2)) < same_face || !faces_.differ(b, c) ||
                    std::abs(faces_.normal(a).dot(d)) > in_plane * d.norm() || !faces_.meet(a, b, c, x))
                    continue;
                corner = faces_.place(x, {a, b, c});
                const double reach = farthest * corner.spacing;
                if ((x - first.point).norm() <= reach && (x - second.point).norm() <= reach &&
                    faces_.distance_to_samples(x) < nearest * corner.spacing && !bends(b, c, x) &&
                    !faces_.is_hidden(x, {a, a2, b, c}) && faces_.are_sharp(corner))
                    return true;
            }
        return false;
    }

    /// Whether a place lies on the edge of the faces of a and b that leads from x.
    bool leads_along(const CreasePlace& place, const Point& x, int a, int b) const
    {
        constexpr double same_face = 0.9, along = 0.9; // cosines
        const Vector d = place.point - x, line = faces_.normal(a).cross(faces_.normal(b));
        const auto is_on = [&](int face)
        {
            return std::any_of(place.around.begin(), place.around.end(),
                               [&](int m) { return faces_.normal(m).dot(faces_.normal(face)) > same_face; });
        };
        return d.norm() > 0 && std::abs(d.dot(line)) > along * d.norm() * line.norm() && is_on(a) && is_on(b);
    }

    /// Whether b and c lie on one face that just bends at x, as at the rim of a bore.
    bool bends(int b, int c, const Point& x) const
    {
        const double reach = 1.5 * std::max((faces_.point(b) - x).norm(), (faces_.point(c) - x).norm());
        const auto is_between = [&](const CreasePlace& p)
        { return std::any_of(p.around.begin(), p.around.end(), [&](int m) { return faces_.is_between(m, b, c); }); };
        std::vector<int> near;
        search_.within(x, reach, near);
        return faces_.bends_between(b, c, x, reach) ||
               std::any_of(near.begin(), near.end(), [&](int m) { return is_between(places_[std::size_t(m)]); });
    }

    const Faces& faces_;
    const std::vector<CreasePlace>& places_;
    const Points positions_;
    const NeighbourSearch search_;
};

} // namespace

void close_corners(const Faces& faces, std::vector<CreasePlace>& places)
{
    const std::vector<CreasePlace> proposed = CornerFinder(faces, places).propose();
    Points taken;
    for (const CreasePlace& p : places)
        if (p.is_corner())
            taken.push_back(p.point);
    Thinning thinning(proposed, taken);
    std::vector<CreasePlace> all;
    for (std::size_t k = 0; k < proposed.size(); ++k)
        if (thinning.is_free(k))
        {
            thinning.take(k);
            all.push_back(proposed[k]);
        }
    const std::size_t added = all.size();
    all.insert(all.end(), places.begin(), places.end());
    const CornerFinder finder(faces, all);
    std::vector<char> is_given_up(all.size(), 0);
    constexpr double crowded = 0.4; // [spacings]
    for (std::size_t k = 0; k < all.size(); ++k)
        if (all[k].is_corner() && !finder.is_shown(all[k]))
            is_given_up[k] = 1;
        else if (k < added)
            finder.mark_near(all[k].point, crowded * all[k].spacing, is_given_up);
    places.clear();
    for (std::size_t k = 0; k < all.size(); ++k)
        if (!is_given_up[k])
            places.push_back(std::move(all[k]));
}

} // namespace recon::pn
