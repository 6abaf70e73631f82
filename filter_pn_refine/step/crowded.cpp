#include "crowded.h"

#include "workspace.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace recon::pn
{
namespace
{

struct Offset
{
    float x, y, z, squared;
};
Offset offset(const LocalPoints& points, const Centre& c, int j)
{
    const float x = points.x[j] - c.x, y = points.y[j] - c.y, z = points.z[j] - c.z;
    return {x, y, z, x * x + y * y + z * z};
}

int thin_hits(const LocalPoints& points, const Centre& c, std::int32_t* hits, int count)
{
    constexpr int sectors = 24, each = largest_ring / sectors;
    int best[sectors][each];
    float distance[sectors][each];
    int filled[sectors] = {};
    for (int k = 0; k < count; ++k)
    {
        const Offset d = offset(points, c, hits[k]);
        const float u = d.x * c.e1[0] + d.y * c.e1[1] + d.z * c.e1[2],
                    v = d.x * c.e2[0] + d.y * c.e2[1] + d.z * c.e2[2];
        const int s = std::clamp(int((std::atan2(v, u) + 3.14159265f) * (sectors / 6.2831853f)), 0, sectors - 1);
        int place = filled[s] < each ? filled[s]++ : each;
        if (place == each)
        {
            if (d.squared >= distance[s][each - 1])
                continue;
            place = each - 1;
        }
        for (; place > 0 && distance[s][place - 1] > d.squared; --place)
        {
            distance[s][place] = distance[s][place - 1];
            best[s][place] = best[s][place - 1];
        }
        distance[s][place] = d.squared;
        best[s][place] = hits[k];
    }
    int kept = 0;
    for (int s = 0; s < sectors; ++s)
        for (int m = 0; m < filled[s]; ++m)
            hits[kept++] = best[s][m];
    return kept;
}

float agreement(const LocalPoints& points, int i, int j)
{
    return points.nx[i] * points.nx[j] + points.ny[i] * points.ny[j] + points.nz[i] * points.nz[j];
}

/// Whether hits lie on the centre's side of a crease: their normals agree enough and, at a crease point, not more with
/// another normal of that point; and neither lies beyond the edge where the face of the other ends.
class CreaseSide
{
public:
    CreaseSide(const LocalPoints& points, const Centre& c, float least, const FaceSector& own_face,
               const std::vector<FaceSector>& faces)
        : points_(points), c_(c), least_(least), own_face_(own_face), faces_(faces)
    {
        const float same = 1e-12f / (c.inverse_radius * c.inverse_radius);
        for (int j = 0; j < points.count; ++j)
            if (offset(points, c, j).squared <= same)
                twins_.push_back(j);
    }
    bool holds(int j) const
    {
        const float own = c_.n[0] * points_.nx[j] + c_.n[1] * points_.ny[j] + c_.n[2] * points_.nz[j];
        const Offset d = offset(points_, c_, j);
        if (own_face_.leads_behind(d.x, d.y, d.z) ||
            (!faces_.empty() && faces_[std::size_t(j)].leads_behind(-d.x, -d.y, -d.z)))
            return false;
        return own >= least_ && std::all_of(twins_.begin(), twins_.end(),
                                            [&](int t) { return agreement(points_, t, j) <= own + 1e-5f; });
    }

private:
    const LocalPoints& points_;
    const Centre& c_;
    float least_;
    const FaceSector& own_face_;
    const std::vector<FaceSector>& faces_;
    std::vector<int> twins_;
};

} // namespace

int choose_hits(const LocalPoints& points, const Centre& c, float least_crease_agreement, bool has_creases,
                const FaceSector& own_face, const std::vector<FaceSector>& faces, std::int32_t* hits, int count)
{
    if (has_creases)
    {
        const CreaseSide side(points, c, least_crease_agreement, own_face, faces);
        count = int(std::remove_if(hits, hits + count, [&](int j) { return !side.holds(j); }) - hits);
    }
    return count > largest_ring ? thin_hits(points, c, hits, count) : count;
}

void find_faces(const Level& level, Workspace& w)
{
    const LocalPoints& points = w.old_points;
    const auto flags_of = [&](int j) { return level.points[std::size_t(points.index[j])].flags; };
    w.faces.assign(std::size_t(points.count), FaceSector{});
    w.edge_points.clear();
    w.is_crease.resize(std::size_t(points.count));
    for (int j = 0; j < points.count; ++j)
        w.is_crease[std::size_t(j)] = (flags_of(j) & WorkPoint::crease) != 0;
    std::vector<int> creases;
    for (int j = 0; j < points.count; ++j)
        if (flags_of(j) & WorkPoint::crease)
            creases.push_back(j);
    const auto normal = [&](int j) { return FaceDirection{points.nx[j], points.ny[j], points.nz[j]}; };
    for (int j : creases)
    {
        std::vector<FaceDirection> others;
        for (int t : creases)
        {
            const float dx = points.x[t] - points.x[j], dy = points.y[t] - points.y[j], dz = points.z[t] - points.z[j];
            constexpr float same = 1e-6f; // [largest radius of the leaf]
            if (t != j && dx * dx + dy * dy + dz * dz <= same * same)
                others.push_back(normal(t));
        }
        FaceSector& face = w.faces[std::size_t(j)];
        face = face_sector(flags_of(j), normal(j), others);
        if (face.is_known())
            w.edge_points.push_back(j);
    }
}

void reject_behind_edges(Workspace& w, const Centre& c)
{
    constexpr float same_face = 0.8f, in_plane = 0.3f; // cosine, sine
    constexpr float beside = 3;                        // [distance to the centre] edges farther away end other faces
    const LocalPoints& points = w.old_points;
    Candidates& of = w.candidates;
    const float radius = 1 / c.inverse_radius;
    for (int k = 0; k < lane_count; ++k)
    {
        if (!(of.usable >> k & 1u))
            continue;
        const float x = of.x[k] * radius + c.x, y = of.y[k] * radius + c.y, z = of.z[k] * radius + c.z;
        float nearest = beside * beside * radius * radius *
                        (of.x[k] * of.x[k] + of.y[k] * of.y[k] + of.z[k] * of.z[k]); // the farthest that is asked
        bool is_behind = false;
        for (int j : w.edge_points)
        {
            const float dx = x - points.x[j], dy = y - points.y[j], dz = z - points.z[j],
                        squared = dx * dx + dy * dy + dz * dz;
            if (squared >= nearest ||
                of.nx[k] * points.nx[j] + of.ny[k] * points.ny[j] + of.nz[k] * points.nz[j] < same_face)
                continue;
            const float height = dx * points.nx[j] + dy * points.ny[j] + dz * points.nz[j];
            if (height * height > in_plane * in_plane * squared)
                continue;
            nearest = squared;
            is_behind = w.faces[std::size_t(j)].leads_behind(dx, dy, dz);
        }
        if (is_behind)
            of.usable &= ~(1u << k);
    }
}

void reject_in_mouths(Workspace& w, const Centre& c, const Mouths& mouths, double spacing)
{
    Candidates& of = w.candidates;
    const float radius = 1 / c.inverse_radius;
    for (int k = 0; k < lane_count; ++k)
    {
        if (!(of.usable >> k & 1u))
            continue;
        const Point x(double(of.x[k] * radius + c.x), double(of.y[k] * radius + c.y), double(of.z[k] * radius + c.z));
        const Vector normal(double(of.nx[k]), double(of.ny[k]), double(of.nz[k]));
        if (mouths.hold(w.centre + x / w.scale, normal, spacing))
            of.usable &= ~(1u << k);
    }
}

void reject_other_side(Workspace& w, const Centre& c, const FaceSector& own_face, float least_crease_agreement,
                       float least_distance)
{
    const std::vector<FaceSector> unknown;
    const CreaseSide side(w.new_points, c, least_crease_agreement, own_face, unknown);
    Arrivals& a = w.arrivals;
    for (int k = 0; k < a.count; ++k)
        if (!side.holds(a.source[k]))
        {
            a.free[k / lane_count] &= ~(1u << k % lane_count);
            a.reach[k] = least_distance;
        }
}

} // namespace recon::pn
