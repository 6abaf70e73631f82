#include <recon/labelling/opposite_votes.h>

#include <recon/parallel.h>

#include <algorithm>
#include <array>

namespace recon
{
namespace
{

/// -cos of the angle between two directions.
double opposition(const Vector& a, const Vector& b)
{
    const double norms = a.norm() * b.norm();
    return norms > 0 ? -a.dot(b) / norms : 0;
}

/// What a sample with both its balls says: they, and its slant ones, lie on opposite sides.
void append_own_votes(const Point& sample, const std::array<int, 2>& own, const std::array<int, 2>& slant,
                      const std::vector<Ball>& balls, std::vector<SignedEdge>& votes)
{
    for (const auto& pair : {own, std::array{slant[0], own[1]}, std::array{own[0], slant[1]}})
    {
        if (pair[0] < 0 || pair[1] < 0)
            continue;
        const double weight = opposition(balls[pair[0]].centre - sample, balls[pair[1]].centre - sample);
        if (weight > 0)
            votes.push_back({pair[0], pair[1], -weight});
    }
}

/// The largest ball of ever more samples around, and the one most opposite to it across their middle: a slab of noise.
/// No edge (-1) if there are none.
SignedEdge vote_across(const Point& sample, const Points& samples, const PolarBalls& kept, const BlockSearch& search)
{
    constexpr int widest = 128;
    int indices[widest];
    double squared[widest];
    for (int k = 16; k <= widest; k *= 2)
    {
        const int found = search.nearest(sample, k, indices, squared);
        Point centroid = Point::Zero();
        int largest = -1;
        for (int j = 0; j < found; ++j)
        {
            centroid += samples[indices[j]] / found;
            for (const int ball : kept.of_sample[indices[j]])
                if (ball >= 0 && (largest < 0 || kept.balls[ball].radius > kept.balls[largest].radius))
                    largest = ball;
        }
        if (largest < 0)
            continue;
        const Vector direction = kept.balls[largest].centre - centroid;
        int opposite = -1;
        double best = 0.5;
        for (int j = 0; j < found; ++j)
            for (const int ball : kept.of_sample[indices[j]])
            {
                if (ball < 0)
                    continue;
                const double value = opposition(direction, kept.balls[ball].centre - centroid);
                if (value > best)
                {
                    best = value;
                    opposite = ball;
                }
            }
        if (opposite >= 0)
            return {largest, opposite, -best};
    }
    return {-1, -1, 0};
}

} // namespace

std::vector<SignedEdge> list_opposite_votes(const Points& samples, const PolarBalls& kept, const BlockSearch& search,
                                            int threads, const Progress& progress)
{
    const int n = int(samples.size()) - box_corner_count;
    std::vector<SignedEdge> votes;
    std::vector<int> thin; // samples that miss a ball
    for (int v = 0; v < n; ++v)
    {
        const std::array<int, 2>& own = kept.of_sample[v];
        if (own[0] < 0 || own[1] < 0)
            thin.push_back(v);
        else
            append_own_votes(samples[v], own, kept.slant_of_sample[v], kept.balls, votes);
    }

    constexpr int most_voters = 50'000;
    const int stride = std::max(1, (n + most_voters - 1) / most_voters);
    std::vector<int> voters;
    for (const int v : thin)
        if (v % stride == 0)
            voters.push_back(v);
    std::vector<SignedEdge> across(voters.size());
    parallel_for(
        voters.size(), threads, progress,
        [&](std::size_t i)
        {
            across[i] = vote_across(samples[voters[i]], samples, kept, search);
            across[i].weight *= stride;
        },
        64);
    for (const SignedEdge& edge : across)
        if (edge.a >= 0)
            votes.push_back(edge);
    return votes;
}

} // namespace recon
