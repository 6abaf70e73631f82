#include <recon/labelling/tube_slices.h>

#include <recon/labelling/widest_turn.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>

#include <Eigen/Eigenvalues>

#include <cmath>
#include <utility>

namespace recon
{
namespace
{

/// Whether samples lie on the ball all around, as rings of them on a slice of a tube.
bool is_girded(const Ball& ball, const Points& samples, const std::vector<int>& on_ball)
{
    constexpr double quarter_turn = 1.6; // the most between two that follow each other [radians]
    constexpr double polar = 0.7;        // sine of the latitude above which a sample says nothing of that
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const int i : on_ball)
    {
        const Vector d = samples[std::size_t(i)] - ball.centre;
        spread += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
    std::vector<double> angles;
    for (const int i : on_ball)
    {
        const Vector d = axes.eigenvectors().transpose() * (samples[std::size_t(i)] - ball.centre);
        if (std::abs(d[0]) < polar * d.norm())
            angles.push_back(std::atan2(d[1], d[2]));
    }
    return !angles.empty() && widest_turn(std::move(angles)) < quarter_turn;
}

} // namespace

void trust_slices_of_tubes(const std::vector<Ball>& balls, const std::vector<Side>& labels,
                           const std::vector<char>& is_small, const Points& samples, double highest_margin,
                           std::vector<double>& margins, int threads)
{
    constexpr int many = 8; // every ball touches four
    constexpr double nearly_on = 1.05, certain_margin = 1;
    const BlockSearch search(samples);
    const auto trust = [&](std::size_t i)
    {
        const double reach = nearly_on * balls[i].radius;
        if (labels[i] == Side::outer || !is_small[i] || margins[i] >= highest_margin ||
            !search.has_within(balls[i].centre, reach, many))
            return;
        thread_local std::vector<int> found;
        search.within(balls[i].centre, reach, found);
        if (is_girded(balls[i], samples, found))
            margins[i] = certain_margin;
    };
    parallel_for(margins.size(), threads, {}, trust, 1024);
}

} // namespace recon
