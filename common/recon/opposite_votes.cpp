#include <recon/opposite_votes.h>

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

} // namespace

std::vector<SignedEdge> list_opposite_votes(const Points& samples, const PolarBalls& kept, const BlockSearch& search,
                                            int threads, const Progress& progress)
{
    const int n = int(samples.size()) - box_corner_count;
    std::vector<SignedEdge> votes;
    std::vector<int> thin; // samples that miss a ball
    for (int v = 0; v < n; ++v)
    {
        const int a = kept.of_sample[v][0], b = kept.of_sample[v][1];
        if (a < 0 || b < 0)
        {
            thin.push_back(v);
            continue;
        }
        for (const auto& pair : {std::array{a, b}, std::array{kept.slant_of_sample[v][0], b}, std::array{a, kept.slant_of_sample[v][1]}})
        {
            if (pair[0] < 0 || pair[1] < 0)
                continue;
            const double weight =
                opposition(kept.balls[pair[0]].centre - samples[v], kept.balls[pair[1]].centre - samples[v]);
            if (weight > 0)
                votes.push_back({pair[0], pair[1], -weight});
        }
    }

    constexpr int most_voters = 50'000;
    const int stride = std::max(1, (n + most_voters - 1) / most_voters);
    std::vector<int> voters;
    for (const int v : thin)
        if (v % stride == 0)
            voters.push_back(v);
    std::vector<SignedEdge> across(voters.size(), {-1, -1, 0});
    const auto vote = [&](std::size_t i)
    {
        constexpr int widest = 128;
        int indices[widest];
        double squared[widest];
        for (int k = 16; k <= widest; k *= 2)
        {
            const int found = search.nearest(samples[voters[i]], k, indices, squared);
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
            {
                across[i] = {largest, opposite, -best * stride};
                return;
            }
        }
    };
    parallel_for(voters.size(), threads, progress, vote, 64);
    for (const SignedEdge& edge : across)
        if (edge.a >= 0)
            votes.push_back(edge);
    return votes;
}

} // namespace recon
