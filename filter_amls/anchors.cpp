#include "anchors.h"

#include "voxel_table.h"

#include <recon/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

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

} // namespace

AnchorChoice choose_anchors(const Cells& cells, const CellNormals& normals, int threads)
{
    const int n = cells.size();
    AnchorChoice choice;
    choice.landmark_of_cell.assign(n, -1);

    // One cell per fine voxel, the one with most mass.
    std::vector<int> fine, level, fine_of_cell(n, -1);
    VoxelTable voxels(cells.means.size() / 2);
    for (int c = 0; c < n; ++c)
    {
        if (normals.kinds[c] != CellKind::regular)
            continue;
        const int l = VoxelTable::level_of(fine_edge * cells.scales[c].width);
        const int voxel = voxels.find_or_add(normals.feet[c], l, VoxelTable::inverse_edge(l));
        if (voxel == int(fine.size()))
        {
            fine.push_back(c);
            level.push_back(l);
        }
        else if (normals.mass[c] > normals.mass[fine[voxel]])
            fine[voxel] = c;
        fine_of_cell[c] = voxel;
    }

    // One fine cell per coarse voxel stands for those that continue its piece of surface.
    const int fine_count = int(fine.size());
    std::vector<int> coarse, coarse_of_fine(fine_count);
    VoxelTable coarse_voxels(fine.size() / 2);
    for (int f = 0; f < fine_count; ++f)
    {
        const int l = level[f] + landmark_levels;
        const int voxel = coarse_voxels.find_or_add(normals.feet[fine[f]], l, VoxelTable::inverse_edge(l));
        if (voxel == int(coarse.size()))
            coarse.push_back(f);
        else if (normals.mass[fine[f]] > normals.mass[fine[coarse[voxel]]])
            coarse[voxel] = f;
        coarse_of_fine[f] = voxel;
    }
    const auto edge_of = [&](int f) { return 1 / VoxelTable::inverse_edge(level[f] + landmark_levels); };
    const auto on_one_piece = [&](int f, int g)
    {
        return continues(normals.feet[fine[f]], normals.normals[fine[f]], normals.feet[fine[g]],
                         normals.normals[fine[g]], edge_of(f));
    };
    std::vector<char> stands_for(fine_count);
    Points places;
    std::vector<int> place_of_fine(fine_count, -1);
    std::vector<int> fine_of_place;
    for (int f = 0; f < fine_count; ++f)
    {
        const int representative = coarse[coarse_of_fine[f]];
        stands_for[f] = f == representative || on_one_piece(representative, f);
        if (f == representative || !stands_for[f])
        {
            place_of_fine[f] = int(places.size());
            places.push_back(normals.feet[fine[f]]);
            fine_of_place.push_back(f);
        }
    }
    // What a place stands for: how many fine cells, and their middle.
    std::vector<double> counts(places.size(), 0);
    Points middles(places.size(), Point::Zero());
    for (int f = 0; f < fine_count; ++f)
    {
        const int place = place_of_fine[stands_for[f] ? coarse[coarse_of_fine[f]] : f];
        counts[place] += 1;
        middles[place] += normals.feet[fine[f]];
    }
    for (std::size_t i = 0; i < places.size(); ++i)
        middles[i] /= counts[i];

    // Plain: all around lies on the same piece.
    std::vector<std::uint8_t> plain(coarse.size());
    const BlockSearch search(places);
    parallel_chunks(coarse.size(), threads, 512, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        std::vector<int> near;
                        for (std::size_t v = begin; v < end; ++v)
                        {
                            const int f = coarse[v];
                            search.within(normals.feet[fine[f]], plain_radius * edge_of(f), near);
                            // Where all lies to one side the surface ends, and balls slip through between few
                            // landmarks.
                            const double radius = plain_radius * edge_of(f);
                            Vector offset = Vector::Zero();
                            double total = 0;
                            for (const int k : near)
                            {
                                const Vector d = middles[k] - normals.feet[fine[f]];
                                const double weight =
                                    counts[k] * std::max(0.0, 1 - d.squaredNorm() / (radius * radius));
                                offset += weight * d;
                                total += weight;
                            }
                            plain[v] = offset.norm() <= plain_balance * radius * total &&
                                       std::all_of(near.begin(), near.end(),
                                                   [&](int k) { return on_one_piece(f, fine_of_place[k]); });
                        }
                    });

    // Landmarks: of plain voxels the representative, elsewhere all fine cells. Anchors: somewhat more.
    std::vector<int> landmark_cell_of_fine(fine_count, -1);
    std::vector<int> kept;
    VoxelTable anchor_voxels(fine.size());
    for (int f = 0; f < fine_count; ++f)
    {
        const int v = coarse_of_fine[f];
        if (!plain[v] || !stands_for[f])
        {
            choice.landmarks.push_back(fine[f]);
            choice.anchors.push_back(fine[f]);
            continue;
        }
        if (f == coarse[v])
            choice.landmarks.push_back(fine[f]);
        landmark_cell_of_fine[f] = fine[coarse[v]];
        const int l = level[f] + anchor_levels;
        const int voxel = anchor_voxels.find_or_add(normals.feet[fine[f]], l, VoxelTable::inverse_edge(l));
        if (voxel == int(kept.size()))
            kept.push_back(fine[f]);
        else if (normals.mass[fine[f]] > normals.mass[kept[voxel]])
            kept[voxel] = fine[f];
    }
    choice.anchors.insert(choice.anchors.end(), kept.begin(), kept.end());
    std::sort(choice.anchors.begin(), choice.anchors.end());
    std::sort(choice.landmarks.begin(), choice.landmarks.end());

    std::vector<int> position(n, -1);
    for (std::size_t i = 0; i < choice.landmarks.size(); ++i)
        position[choice.landmarks[i]] = int(i);
    for (int c = 0; c < n; ++c)
        if (fine_of_cell[c] >= 0 && landmark_cell_of_fine[fine_of_cell[c]] >= 0)
            choice.landmark_of_cell[c] = position[landmark_cell_of_fine[fine_of_cell[c]]];
    for (const int c : choice.landmarks)
        choice.landmark_spacing.push_back(
            std::max(fine_edge * cells.scales[c].width, 1 / std::sqrt(cells.scales[c].density)));
    return choice;
}

} // namespace recon
