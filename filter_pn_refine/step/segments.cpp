#include "segments.h"

#include "crease_sides.h"

#include <recon/search/neighbours.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>

namespace recon::pn
{
namespace
{

/// Two crease splats at each end, as places in the usable samples.
struct CreaseLink
{
    int place_a, place_b; ///< First sample at the position.
    std::array<int, 2> a, b;
    double length;
};

/// Tangent of a curve at one of its ends: along the crease where two normals meet, in the tangent plane of a rim.
Vector end_tangent(const Vector& chord, const Vector& n0, const Vector& n1, bool is_crease)
{
    const double length = chord.norm();
    Vector t = is_crease ? n0.cross(n1).eval() : (chord - chord.dot(n0) * n0).eval();
    if (is_crease)
        t = t.dot(chord) < 0 ? Vector(-t) : t;
    const double size = t.norm();
    // Where it would turn away by more than 45 degrees (corners), the chord tells more.
    if (!(size > 1e-6 * (is_crease ? 1 : length)) || t.dot(chord) < 0.7 * size * length)
        return chord / 3;
    return t * (length / (3 * size));
}

Vector normal_on_curve(const Vector& nearer, const Vector& farther, const Vector& tangent)
{
    const Vector mean = 2 * nearer + farther;
    const Vector flat = mean - mean.dot(tangent) / tangent.squaredNorm() * tangent;
    const double length = flat.norm();
    return length > 0.5 * mean.norm() && length > 0 ? Vector(flat / length) : mean.normalized();
}

} // namespace

std::vector<Segment> find_boundary_segments(const UsableSamples& usable, const InitialFans& fans,
                                            const std::vector<float>& spacing, double boundary_angle)
{
    constexpr double longest = 3; // [spacings] what is farther apart lies on two sides of a bay
    const int n = int(usable.input.size());
    std::vector<int> next(std::size_t(n), -1), previous(std::size_t(n), -1);
    for (std::size_t i = 0; i < std::size_t(n); ++i)
    {
        const int size = fans.first[i + 1] - fans.first[i];
        if (size < 2 || fans.widest_gap[i] < boundary_angle)
            continue;
        const int from = fans.gap_from[i], to = from + 1 == fans.first[i + 1] ? fans.first[i] : from + 1;
        next[i] = fans.member[std::size_t(from)];
        previous[i] = fans.member[std::size_t(to)];
    }
    std::vector<Segment> segments;
    for (int i = 0; i < n; ++i)
    {
        const int j = next[std::size_t(i)];
        // The other splats of a crease end where it does: that is no rim.
        if (j >= 0 && previous[std::size_t(j)] == i && usable.sharing[std::size_t(i)] == i &&
            !usable.is_crease[std::size_t(i)] && !usable.is_crease[std::size_t(j)] &&
            (usable.samples.points[std::size_t(i)] - usable.samples.points[std::size_t(j)]).norm() <=
                longest * double(spacing[std::size_t(i)]))
        {
            Segment s;
            s.a = {usable.input[std::size_t(i)], -1};
            s.b = {usable.input[std::size_t(j)], -1};
            segments.push_back(s);
        }
    }
    return segments;
}

namespace
{

/// Links of splats per pair of positions (the lower first), both ways into one key.
using SplatLinks = std::map<std::pair<int, int>, std::vector<std::array<int, 2>>>;

void add_link(const UsableSamples& usable, int i, int j, SplatLinks& links)
{
    const int a = usable.sharing[std::size_t(i)], b = usable.sharing[std::size_t(j)];
    if (a < b)
        links[{a, b}].push_back({i, j});
    else if (b < a)
        links[{b, a}].push_back({j, i});
}

/// Links between near positions along their creases. Fans alone miss many: samples of the faces that lie nearer than
/// the next crease sample, as beside detected ones, hide it.
void add_links_along(const UsableSamples& usable, const InitialFans& fans, double same, SplatLinks& links)
{
    const Points& points = usable.samples.points;
    const Vectors& normals = usable.samples.normals;
    const std::vector<int> next = next_at_position(usable);
    std::vector<int> places;
    Points positions;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (usable.sharing[i] == int(i) && next[i] != int(i))
        {
            places.push_back(int(i));
            positions.push_back(points[i]);
        }
    if (places.size() < 2)
        return;
    const auto splats_at = [&](int place)
    {
        std::vector<int> splats = {place};
        for (int t = next[std::size_t(place)]; t != place; t = next[std::size_t(t)])
            splats.push_back(t);
        std::sort(splats.begin(), splats.end());
        return splats;
    };
    const NeighbourSearch search(positions);
    const auto follows = [&](const std::vector<int>& own, const Vector& unit)
    {
        // At a corner along any two of its faces.
        for (std::size_t p = 0; p < own.size(); ++p)
            for (std::size_t q = 0; q < p; ++q)
            {
                const Vector tangent = normals[std::size_t(own[p])].cross(normals[std::size_t(own[q])]);
                if (std::abs(tangent.dot(unit)) > 0.8 * tangent.norm())
                    return true;
            }
        return false;
    };
    for (int a : places)
    {
        constexpr int k = 9;
        int nearest[k];
        double squared[k];
        const int found = search.nearest(points[std::size_t(a)], std::min(k, int(places.size())), nearest, squared);
        for (int m = 0; m < found; ++m)
        {
            const int b = places[std::size_t(nearest[m])];
            const double length = std::sqrt(squared[m]);
            if (length == 0 || a > b || length > std::max(fans.radius[std::size_t(a)], fans.radius[std::size_t(b)]))
                continue;
            const Vector unit = (points[std::size_t(b)] - points[std::size_t(a)]) / length;
            const std::vector<int> at_a = splats_at(a), at_b = splats_at(b);
            if (!follows(at_a, unit) || !follows(at_b, unit))
                continue;
            for (int i : at_a)
                for (int j : at_b)
                    if (normals[std::size_t(i)].dot(normals[std::size_t(j)]) >= same)
                        add_link(usable, i, j, links);
        }
    }
}

/// Links between splats whose normals agree, found by fans and along creases.
SplatLinks list_splat_links(const UsableSamples& usable, const InitialFans& fans, double crease_angle)
{
    const double same = std::cos(crease_angle);
    SplatLinks links;
    for (int i = 0; i < int(usable.input.size()); ++i)
    {
        if (!usable.is_crease[std::size_t(i)])
            continue;
        for (int m = fans.first[std::size_t(i)]; m < fans.first[std::size_t(i) + 1]; ++m)
        {
            const int j = fans.member[std::size_t(m)];
            if (!usable.is_crease[std::size_t(j)] ||
                usable.samples.normals[std::size_t(i)].dot(usable.samples.normals[std::size_t(j)]) < same)
                continue;
            add_link(usable, i, j, links);
        }
    }
    add_links_along(usable, fans, same, links);
    return links;
}

/// Whether a crease with these splats beside it, `p` on one side and `q` on the other, runs from end to end: between
/// two crests of a thread all normals agree as well, yet no crease leads from one to the other.
bool lies_along(const UsableSamples& usable, const std::array<int, 2>& p, const std::array<int, 2>& q)
{
    constexpr double least = 0.7; // cosine; as in end_tangent()
    const Vector chord = usable.samples.points[std::size_t(p[1])] - usable.samples.points[std::size_t(p[0])];
    const auto follows = [&](std::size_t end)
    {
        const Vector tangent =
            usable.samples.normals[std::size_t(p[end])].cross(usable.samples.normals[std::size_t(q[end])]);
        return std::abs(tangent.dot(chord)) >= least * tangent.norm() * chord.norm();
    };
    return follows(0) && follows(1);
}

/// Per pair of positions the two links, one a side, whose normals agree best.
std::vector<CreaseLink> choose_sides(const UsableSamples& usable, const std::vector<FaceSector>& sectors,
                                     SplatLinks links)
{
    const auto leads_behind = [&](int from, int to)
    {
        const FaceDirection d =
            as_floats(usable.samples.points[std::size_t(to)] - usable.samples.points[std::size_t(from)]);
        return sectors[std::size_t(from)].leads_behind(d[0], d[1], d[2]);
    };
    std::vector<CreaseLink> found;
    for (auto& [key, pairs] : links)
    {
        CreaseLink link{key.first, key.second, {}, {}, 0};
        // Beyond a corner the line of an edge may be that of another, across a mouth.
        pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                                   [&](const std::array<int, 2>& p)
                                   { return leads_behind(p[0], p[1]) || leads_behind(p[1], p[0]); }),
                    pairs.end());
        double best = -2;
        for (const auto& p : pairs)
            for (const auto& q : pairs)
                if (p[0] < q[0] && p[1] != q[1] && lies_along(usable, p, q))
                {
                    const auto& normals = usable.samples.normals;
                    const double agreement = normals[std::size_t(p[0])].dot(normals[std::size_t(p[1])]) +
                                             normals[std::size_t(q[0])].dot(normals[std::size_t(q[1])]);
                    if (agreement > best)
                    {
                        best = agreement;
                        link.a = {p[0], q[0]};
                        link.b = {p[1], q[1]};
                    }
                }
        if (best < -1)
            continue;
        link.length =
            (usable.samples.points[std::size_t(key.first)] - usable.samples.points[std::size_t(key.second)]).norm();
        found.push_back(link);
    }
    return found;
}

/// The nearest link in each direction, seen from both ends.
std::vector<CreaseLink> keep_nearest(const UsableSamples& usable, std::vector<CreaseLink> links)
{
    std::stable_sort(links.begin(), links.end(),
                     [](const CreaseLink& x, const CreaseLink& y) { return x.length < y.length; });
    std::map<int, Vectors> taken;
    std::vector<CreaseLink> kept;
    for (const CreaseLink& link : links)
    {
        const Vector d =
            (usable.samples.points[std::size_t(link.place_b)] - usable.samples.points[std::size_t(link.place_a)]) /
            link.length;
        const auto is_free = [&](int place, const Vector& direction)
        {
            const Vectors& t = taken[place];
            return std::none_of(t.begin(), t.end(), [&](const Vector& other) { return other.dot(direction) > 0.5; });
        };
        if (!is_free(link.place_a, d) || !is_free(link.place_b, -d))
            continue;
        taken[link.place_a].push_back(d);
        taken[link.place_b].push_back(-d);
        kept.push_back(link);
    }
    return kept;
}

} // namespace

std::vector<Segment> find_crease_segments(const UsableSamples& usable, const InitialFans& fans,
                                          const std::vector<std::uint32_t>& sides, double crease_angle)
{
    SplatLinks links = list_splat_links(usable, fans, crease_angle);
    if (links.empty())
        return {};
    std::vector<Segment> segments;
    for (const CreaseLink& link :
         keep_nearest(usable, choose_sides(usable, sectors_of_faces(usable, sides), std::move(links))))
    {
        Segment s;
        s.sides = 2;
        for (std::size_t k = 0; k < 2; ++k)
        {
            s.a[k] = usable.input[std::size_t(link.a[k])];
            s.b[k] = usable.input[std::size_t(link.b[k])];
        }
        segments.push_back(s);
    }
    return segments;
}

std::vector<InsertedThirds> insert_thirds(const std::vector<Segment>& segments, const Level& level, float spacing_ratio,
                                          int ids, int threads, std::vector<LeafChildren>& children,
                                          std::vector<WorkPoint>& made)
{
    std::vector<InsertedThirds> inserted(segments.size());
    if (segments.empty())
        return inserted;
    const std::vector<int> places = places_of_ids(level, ids, threads);
    for (std::size_t s = 0; s < segments.size(); ++s)
    {
        const Segment& segment = segments[s];
        std::array<int, 2> at_a{}, at_b{};
        std::array<const WorkPoint*, 2> a{}, b{};
        for (std::size_t side = 0; side < std::size_t(segment.sides); ++side)
        {
            at_a[side] = places[std::size_t(segment.a[side])];
            at_b[side] = places[std::size_t(segment.b[side])];
            a[side] = &level.points[std::size_t(at_a[side])];
            b[side] = &level.points[std::size_t(at_b[side])];
        }
        if (!(a[0]->flags & WorkPoint::refined) || !(b[0]->flags & WorkPoint::refined))
            continue;
        const bool is_crease = segment.sides == 2;
        const Vector chord = b[0]->position - a[0]->position;
        // Short already against what lies around it: its turn comes when the rest has become as dense.
        // Radii of a crease's points say little, they were made with it. Without this each run over the result of
        // another would divide again what that has made three times as dense.
        const double least = is_crease ? 0.6 * double(spacing_ratio) * double(std::min(a[0]->spacing, b[0]->spacing))
                                       : 0.25 * double(std::min(a[0]->radius, b[0]->radius));
        if (chord.norm() < least)
            continue;
        const std::size_t other = is_crease ? 1 : 0;
        const Vector ta = end_tangent(chord, a[0]->normal, a[other]->normal, is_crease);
        const Vector tb = -end_tangent(-chord, b[0]->normal, b[other]->normal, is_crease);
        InsertedThirds& done = inserted[s];
        done.is_done = true;
        for (std::size_t third = 0; third < 2; ++third)
        {
            const double t = third == 0 ? 1.0 / 3 : 2.0 / 3, u = 1 - t;
            // Relative to the nearer end, so that straight creases through it stay exactly straight.
            const Vector from_a = 3 * u * u * t * ta + 3 * u * t * t * (chord - tb) + t * t * t * chord;
            const Vector tangent = u * u * ta + 2 * u * t * (chord - ta - tb) + t * t * tb;
            for (std::size_t side = 0; side < std::size_t(segment.sides); ++side)
            {
                const WorkPoint &nearer = third == 0 ? *a[side] : *b[side], &farther = third == 0 ? *b[side] : *a[side];
                WorkPoint p;
                p.id = 0; // given when the level grows
                p.position = a[0]->position + from_a;
                p.normal = normal_on_curve(nearer.normal, farther.normal, tangent);
                p.radius = float(0.5 * chord.norm());
                p.spacing = nearer.spacing;
                constexpr std::uint32_t sides = WorkPoint::above | WorkPoint::below; // corners have none
                p.flags = WorkPoint::refined | (nearer.flags & WorkPoint::near_mouth);
                if (is_crease)
                    p.flags |= WorkPoint::crease | (sides & ((nearer.flags & sides) ? nearer.flags : farther.flags));
                const int place = third == 0 ? at_a[side] : at_b[side],
                          other_end = third == 0 ? at_b[side] : at_a[side];
                const int leaf = leaf_of_place(level, place);
                const Vector d = p.position - level.leaves[std::size_t(leaf)].box.centre();
                LeafChildren& list = children[std::size_t(leaf)];
                done.place[third][side] = {leaf, list.count()};
                list.append_made(int(made.size()), {place, place, other_end},
                                 {float(d.x()), float(d.y()), float(d.z()), float(p.normal.x()), float(p.normal.y()),
                                  float(p.normal.z()), p.radius, 0.9f * nearer.radius});
                made.push_back(p);
            }
        }
    }
    return inserted;
}

std::vector<Segment> divide_segments(const std::vector<Segment>& segments, const std::vector<InsertedThirds>& inserted,
                                     const std::vector<int>& first, int first_id)
{
    std::vector<Segment> divided;
    divided.reserve(3 * segments.size());
    for (std::size_t s = 0; s < segments.size(); ++s)
    {
        const Segment& segment = segments[s];
        if (!inserted[s].is_done)
        {
            divided.push_back(segment);
            continue;
        }
        std::array<std::array<int, 2>, 2> ids{};
        for (std::size_t third = 0; third < 2; ++third)
            for (std::size_t side = 0; side < std::size_t(segment.sides); ++side)
            {
                const auto [leaf, index] = inserted[s].place[third][side];
                ids[third][side] = first_id + first[std::size_t(leaf)] + index;
            }
        divided.push_back({segment.a, ids[0], segment.sides});
        divided.push_back({ids[0], ids[1], segment.sides});
        divided.push_back({ids[1], segment.b, segment.sides});
    }
    return divided;
}

} // namespace recon::pn
