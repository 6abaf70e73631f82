#include "cell_sides.h"

#include "filter_amls/fits/runs.h"
#include "filter_amls/fits/weighted_sums.h"

#include <recon/simd.h>

#include <algorithm>

namespace recon
{
namespace
{

constexpr double cut = 2.2;             // widths
constexpr double nearby = 1.4;          // sigmas: anchors that pass farther off lose weight
constexpr double least_agreement = 0.1; // length of the mean of their normals
constexpr double agreeing_cosine = 0.9; // of a normal that stays as it is
constexpr double run_radius = 0.7;      // widths
constexpr int longest_run = 32;

using Lanes = simd::FloatLanes;

/// Sums of w n and w over the anchors, w = confidence exp(-|u|^2 / h^2) (1 + (u.n / 2 sigma)^2)^-2.
RECON_VECTOR_CLONES
void sum_normals(const Gathered& around, const float* place, float inverse_width, float inverse_distance, double* sums)
{
    const Lanes zero = {};
    Lanes x = zero, y = zero, z = zero, mass = zero;
    for (int i = 0; i < around.size; i += simd::lane_count)
    {
        const std::size_t k = std::size_t(i);
        const Lanes ux = simd::load(&around.x[k]) - place[0], uy = simd::load(&around.y[k]) - place[1],
                    uz = simd::load(&around.z[k]) - place[2];
        const Lanes nx = simd::load(&around.nx[k]), ny = simd::load(&around.ny[k]), nz = simd::load(&around.nz[k]);
        const Lanes e = (ux * ux + uy * uy + uz * uz) * (inverse_width * inverse_width);
        const Lanes off = (ux * nx + uy * ny + uz * nz) * inverse_distance;
        const Lanes near = 1.0f / (1.0f + off * off);
        Lanes w = simd::load(&around.weight[k]) * near * near;
        w *= e <= float(cut * cut) ? simd::exp_negative(e) : zero;
        x += w * nx;
        y += w * ny;
        z += w * nz;
        mass += w;
    }
    sums[0] = simd::sum(x);
    sums[1] = simd::sum(y);
    sums[2] = simd::sum(z);
    sums[3] = simd::sum(mass);
}

} // namespace

void follow_anchors(const Cells& cells, const std::vector<Anchor>& anchors, const BlockSearch& search, Vectors& normals,
                    int threads)
{
    Points positions;
    Vectors directions;
    std::vector<double> confidences;
    for (const Anchor& anchor : anchors)
    {
        positions.push_back(anchor.position);
        directions.push_back(anchor.normal);
        confidences.push_back(anchor.confidence);
    }
    struct Worker
    {
        std::vector<int> found;
        Gathered around;
    };
    const auto width_of = [&](int c) { return cells.scales[std::size_t(c)].width; };
    const std::vector<Run> runs =
        split_into_runs(cells.means, longest_run, [&](int c) { return run_radius * width_of(c); });
    visit_runs(
        runs, threads, {}, [] { return Worker(); },
        [&](Worker& worker, const Run& run)
        {
            search.within(run.centre, run.radius + cut * largest_in(run, width_of), worker.found);
            worker.around.gather(positions, confidences, worker.found, run.centre);
            worker.around.gather_directions(directions, worker.found);
            for (int c = run.begin; c < run.end; ++c)
            {
                const LocalScale& scale = cells.scales[std::size_t(c)];
                const Eigen::Vector3f place = (cells.means[std::size_t(c)] - run.centre).cast<float>();
                double sums[4];
                sum_normals(worker.around, place.data(), float(1 / scale.width), float(1 / (nearby * scale.sigma)),
                            sums);
                const Vector mean(sums[0], sums[1], sums[2]);
                const double length = mean.norm();
                Vector& normal = normals[std::size_t(c)];
                if (length > least_agreement * sums[3] && mean.dot(normal) < agreeing_cosine * length)
                    normal = mean / length;
            }
        });
}

} // namespace recon
