#include "cells_across.h"

#include <recon/parallel.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <vector>

namespace recon
{
namespace
{

/// Noise below which a window is wider than thick [widths].
constexpr double thick = 0.2;
/// Mass from which a cell is not in the tails.
constexpr double full_mass = 0.75;
constexpr int asked_cells = 16;
/// Cosine of the turn from which normals are across each other.
constexpr double across = 0.7;
/// Share of the normals around along their main direction from which they agree.
constexpr double agreeing = 0.8;
constexpr double window = 1.5; ///< Radius around the foot in which points tell a plane [widths].
/// Root mean square distance from a plane up to which points lie in it but for noise [sigmas].
constexpr double noise_alone = 1.25;
/// Farthest that their mean lies from the foot along the plane, or the window is not full [radii].
constexpr double off_centre = 0.3;
constexpr std::size_t fewest_points = 24;

class CellTurner
{
public:
    CellTurner(const Points& points, const BlockSearch& search, const Cells& cells, const BlockSearch& cell_search,
               const CellNormals& normals)
        : points_(points), search_(search), cells_(cells), cell_search_(cell_search), normals_(normals)
    {
    }

    /// The cell's normal, or that of those around.
    Vector settle(int cell)
    {
        const std::size_t c = std::size_t(cell);
        const Vector& own = normals_.normals[c];
        Vector around;
        const LocalScale& scale = cells_.scales[c];
        const bool stays = scale.sigma < thick * scale.width || normals_.kinds[c] == CellKind::outlier ||
                           normals_.mass[c] >= full_mass || !find_consensus(cell, around) ||
                           std::abs(around.dot(own)) >= across || !lie_in_a_plane(cell, around);
        return stays ? own : around;
    }

private:
    /// What the cells around agree on.
    bool find_consensus(int cell, Vector& normal) const
    {
        int near[asked_cells];
        double squared[asked_cells];
        const int count = cell_search_.nearest(cells_.means[std::size_t(cell)], asked_cells, near, squared);
        Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
        Vector sum = Vector::Zero();
        double mass = 0;
        for (int k = 0; k < count; ++k)
        {
            const std::size_t i = std::size_t(near[k]);
            if (near[k] == cell || normals_.kinds[i] != CellKind::regular)
                continue;
            const Vector& n = normals_.normals[i];
            squares += normals_.mass[i] * n * n.transpose();
            sum += normals_.mass[i] * n;
            mass += normals_.mass[i];
        }
        if (!(mass > 0))
            return false;
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
        solver.computeDirect(squares / mass);
        normal = solver.eigenvectors().col(2);
        if (normal.dot(sum) < 0)
            normal = -normal;
        return solver.eigenvalues()[2] >= agreeing;
    }

    /// Whether the points around the cell's place on the surface do, but for noise.
    bool lie_in_a_plane(int cell, const Vector& normal)
    {
        const LocalScale& scale = cells_.scales[std::size_t(cell)];
        const double radius = window * scale.width;
        Point foot = cells_.means[std::size_t(cell)];
        Vector along;
        double variance = 0;
        for (int round = 0; round < 2; ++round)
        {
            search_.within(foot, radius, found_);
            if (found_.size() < fewest_points)
                return false;
            Vector sum = Vector::Zero();
            double squares = 0;
            for (const int i : found_)
            {
                const Vector d = points_[std::size_t(i)] - foot;
                sum += d;
                squares += normal.dot(d) * normal.dot(d);
            }
            const Vector mean = sum / double(found_.size());
            const double height = normal.dot(mean);
            variance = squares / double(found_.size()) - height * height;
            along = mean - height * normal;
            foot += height * normal;
        }
        return variance <= noise_alone * noise_alone * scale.sigma * scale.sigma && along.norm() <= off_centre * radius;
    }

    const Points& points_;
    const BlockSearch& search_;
    const Cells& cells_;
    const BlockSearch& cell_search_;
    const CellNormals& normals_;
    std::vector<int> found_;
};

} // namespace

Vectors turn_cells_across(const Points& points, const BlockSearch& search, const Cells& cells,
                          const BlockSearch& cell_search, const CellNormals& normals, int threads)
{
    Vectors result(std::size_t(cells.size()));
    parallel_chunks(result.size(), threads, 1024, {},
                    [&](std::size_t begin, std::size_t end)
                    {
                        CellTurner turner(points, search, cells, cell_search, normals);
                        for (std::size_t c = begin; c < end; ++c)
                            result[c] = turner.settle(int(c));
                    });
    return result;
}

} // namespace recon
