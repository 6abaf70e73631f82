#include "anchors.h"

#include "voxel_table.h"

#include <recon/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace recon
{
namespace
{

constexpr double fine_edge = 0.5; // widths
constexpr int anchor_levels = 1;  // half octaves above it where the surface is plain: 0.7 widths
constexpr int landmark_levels = 2;
constexpr double plain_radius = 2;     // of a landmark's voxel
constexpr double plain_cosine = 0.6;   // of normals on a plain piece
constexpr double plain_balance = 0.22; // of the radius: how far the middle of what lies around may be off
constexpr double plain_slope = 0.5;    // height over the tangent plane [distance]
constexpr double plain_offset = 0.15;  // the same, of the voxel: what noise leaves

/// Whether q, with normal m, continues the piece of surface at p with normal n.
bool continues(const Point& p, const Vector& n, const Point& q, const Vector& m, double edge)
{
    const Vector d = q - p;
    return std::abs(m.dot(n)) >= plain_cosine && std::abs(d.dot(n)) <= plain_slope * d.norm() + plain_offset * edge;
}

/// Of the items that fall into each voxel the one with most mass, the first of equals.
class HeaviestOfVoxels
{
public:
    explicit HeaviestOfVoxels(std::size_t expected) : voxels_(expected) {}

    /// \returns the voxel.
    int add(int item, const Point& place, int level, double mass)
    {
        const int voxel = voxels_.find_or_add(place, level, VoxelTable::inverse_edge(level));
        if (voxel == int(items.size()))
        {
            items.push_back(item);
            masses_.push_back(mass);
        }
        else if (mass > masses_[voxel])
        {
            items[voxel] = item;
            masses_[voxel] = mass;
        }
        return voxel;
    }

    std::vector<int> items; ///< Per voxel.

private:
    VoxelTable voxels_;
    std::vector<double> masses_;
};

/// Regular cells thinned to voxels of half a width, and these to voxels two half octaves wider.
struct ThinnedCells
{
    const CellNormals& normals;
    std::vector<int> voxel_of_cell;  ///< Per cell: its fine voxel, -1 of strays and outliers.
    std::vector<int> cell, level;    ///< Per fine voxel: its cell with most mass, and its size as VoxelTable has it.
    std::vector<int> coarse_of;      ///< Per fine voxel: its coarse one.
    std::vector<int> representative; ///< Per coarse voxel: its fine one with most mass.
    std::vector<char> is_stood_for;  ///< Per fine voxel: is that one, or lies on its piece of surface.

    ThinnedCells(const Cells& cells, const CellNormals& all_normals, int threads)
        : normals(all_normals), voxel_of_cell(cells.size(), -1)
    {
        std::vector<int> level_of_cell(cells.means.size());
        parallel_for(
            level_of_cell.size(), threads, {},
            [&](std::size_t c) { level_of_cell[c] = VoxelTable::level_of(fine_edge * cells.scales[c].width); }, 4096);
        HeaviestOfVoxels fine(cells.means.size() / 2);
        for (int c = 0; c < cells.size(); ++c)
        {
            if (normals.kinds[c] != CellKind::regular)
                continue;
            voxel_of_cell[c] = fine.add(c, normals.feet[c], level_of_cell[c], normals.mass[c]);
            if (voxel_of_cell[c] == int(level.size()))
                level.push_back(level_of_cell[c]);
        }
        cell = std::move(fine.items);
        HeaviestOfVoxels coarse(cell.size() / 2);
        for (int f = 0; f < size(); ++f)
            coarse_of.push_back(coarse.add(f, foot(f), level[f] + landmark_levels, mass(f)));
        representative = std::move(coarse.items);
        is_stood_for.resize(cell.size());
        parallel_for(
            cell.size(), threads, {},
            [&](std::size_t i)
            {
                const int f = int(i);
                is_stood_for[i] = f == representative_of(f) || are_on_one_piece(representative_of(f), f);
            },
            4096);
    }

    int size() const { return int(cell.size()); } ///< Fine voxels.
    const Point& foot(int f) const { return normals.feet[cell[f]]; }
    double mass(int f) const { return normals.mass[cell[f]]; }
    int representative_of(int f) const { return representative[coarse_of[f]]; }
    double coarse_edge(int f) const { return 1 / VoxelTable::inverse_edge(level[f] + landmark_levels); }
    /// Whether fine voxel g continues the piece of surface at f.
    bool are_on_one_piece(int f, int g) const
    {
        return continues(foot(f), normals.normals[cell[f]], foot(g), normals.normals[cell[g]], coarse_edge(f));
    }
};

/// Per coarse voxel whether the surface is plain there: what lies around is on the same piece, and on all sides.
std::vector<std::uint8_t> find_plain_voxels(const ThinnedCells& thinned, int threads)
{
    // What stands for others, and what no other stands for: how many fine cells each is, and their middle.
    Points places;
    std::vector<int> place_of(thinned.size(), -1), fine_of_place;
    for (int f = 0; f < thinned.size(); ++f)
        if (f == thinned.representative_of(f) || !thinned.is_stood_for[f])
        {
            place_of[f] = int(places.size());
            places.push_back(thinned.foot(f));
            fine_of_place.push_back(f);
        }
    std::vector<double> counts(places.size(), 0);
    Points middles(places.size(), Point::Zero());
    for (int f = 0; f < thinned.size(); ++f)
    {
        const int place = place_of[thinned.is_stood_for[f] ? thinned.representative_of(f) : f];
        counts[place] += 1;
        middles[place] += thinned.foot(f);
    }
    for (std::size_t i = 0; i < places.size(); ++i)
        middles[i] /= counts[i];

    std::vector<std::uint8_t> plain(thinned.representative.size());
    const BlockSearch search(places, threads);
    parallel_chunks(plain.size(), threads, 512, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> near;
                        for (std::size_t v = begin; v < end; ++v)
                        {
                            const int f = thinned.representative[v];
                            const double radius = plain_radius * thinned.coarse_edge(f);
                            search.within(thinned.foot(f), radius, near);
                            // Where all lies to one side the surface ends, and balls slip through between few
                            // landmarks.
                            Vector offset = Vector::Zero();
                            double total = 0;
                            for (const int k : near)
                            {
                                const Vector d = middles[k] - thinned.foot(f);
                                const double weight =
                                    counts[k] * std::max(0.0, 1 - d.squaredNorm() / (radius * radius));
                                offset += weight * d;
                                total += weight;
                            }
                            plain[v] =
                                offset.norm() <= plain_balance * radius * total &&
                                std::all_of(near.begin(), near.end(),
                                            [&](int k) { return thinned.are_on_one_piece(f, fine_of_place[k]); });
                        }
                    });
    return plain;
}

} // namespace

AnchorChoice choose_anchors(const Cells& cells, const CellNormals& normals, int threads)
{
    const ThinnedCells thinned(cells, normals, threads);
    const std::vector<std::uint8_t> plain = find_plain_voxels(thinned, threads);

    // Landmarks: of plain voxels the representative, elsewhere all fine cells. Anchors: somewhat more.
    AnchorChoice choice;
    std::vector<int> landmark_of_fine(thinned.size(), -1); // as a cell
    HeaviestOfVoxels kept(thinned.size());
    for (int f = 0; f < thinned.size(); ++f)
    {
        const int c = thinned.cell[f];
        if (!plain[thinned.coarse_of[f]] || !thinned.is_stood_for[f])
        {
            choice.landmarks.push_back(c);
            choice.anchors.push_back(c);
            continue;
        }
        if (f == thinned.representative_of(f))
            choice.landmarks.push_back(c);
        landmark_of_fine[f] = thinned.cell[thinned.representative_of(f)];
        kept.add(c, thinned.foot(f), thinned.level[f] + anchor_levels, thinned.mass(f));
    }
    choice.anchors.insert(choice.anchors.end(), kept.items.begin(), kept.items.end());
    std::sort(choice.anchors.begin(), choice.anchors.end());
    std::sort(choice.landmarks.begin(), choice.landmarks.end());

    std::vector<int> position(cells.size(), -1);
    for (std::size_t i = 0; i < choice.landmarks.size(); ++i)
        position[choice.landmarks[i]] = int(i);
    choice.landmark_of_cell.assign(cells.size(), -1);
    for (int c = 0; c < cells.size(); ++c)
        if (const int f = thinned.voxel_of_cell[c]; f >= 0 && landmark_of_fine[f] >= 0)
            choice.landmark_of_cell[c] = position[landmark_of_fine[f]];
    for (const int c : choice.landmarks)
        choice.landmark_spacing.push_back(
            std::max(fine_edge * cells.scales[c].width, 1 / std::sqrt(cells.scales[c].density)));
    return choice;
}

std::vector<int> thin_anchors(const std::vector<int>& anchors, const std::vector<double>& widths,
                              const CellNormals& normals)
{
    HeaviestOfVoxels voxels(anchors.size());
    for (std::size_t a = 0; a < anchors.size(); ++a)
        voxels.add(int(a), normals.feet[anchors[a]], VoxelTable::level_of(fine_edge * widths[a]),
                   normals.mass[anchors[a]]);
    std::sort(voxels.items.begin(), voxels.items.end());
    return voxels.items;
}

} // namespace recon
