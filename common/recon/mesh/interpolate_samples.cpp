#include <recon/mesh/interpolate_samples.h>

#include <recon/mesh/flip_edges.h>
#include <recon/mesh/half_edge_mesh.h>
#include <recon/mesh/triangle_tree.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>

#include <algorithm>
#include <array>
#include <utility>

namespace recon
{
namespace
{

/// A sample farther from the surface than this belongs to another part [longest side of the triangle there].
constexpr double farthest = 0.5;
/// The same of one that lies beside a vertex, which moves along the surface to it.
constexpr double farthest_beside = 0.15;
/// Moves that neighbours forbid succeed when these have moved and edges have flipped.
constexpr int rounds = 6;

class Interpolator
{
public:
    Interpolator(TriangleMesh& mesh, const std::vector<int>& seats, const Points& samples, int threads)
        : mesh_(mesh, pair_half_edges(mesh, threads)), samples_(samples), seats_(seats), is_vertex_(samples.size(), 0),
          threads_(threads)
    {
        std::vector<char> has_seat(samples.size(), 0);
        for (const int sample : seats)
            if (sample >= 0)
                has_seat[sample] = 1;
        for (int i = 0; i < int(samples.size()); ++i)
            if (!has_seat[i])
                seatless_.push_back(i);
    }

    void run()
    {
        EdgeFlipOptions flips;
        flips.threads = threads_;
        for (int round = 0; round < rounds; ++round)
        {
            changed_.assign(std::size_t(mesh_.vertices()), 0);
            move_to_seats();
            insert_missing();
            changed_.resize(std::size_t(mesh_.vertices()), 1);
            if (std::find(changed_.begin(), changed_.end(), 1) == changed_.end())
                break;
            flip_edges(mesh_, flips, round == 0 ? nullptr : &changed_);
        }
    }

private:
    void move_to_seats()
    {
        for (int v = 0; v < int(seats_.size()); ++v)
            if (const int sample = seats_[v]; sample >= 0 && !is_vertex_[sample] && is_near(v, samples_[sample]))
            {
                is_vertex_[sample] = mesh_.move(v, samples_[sample]);
                // Half the way may do, and edges flip before the other half.
                changed_[v] = is_vertex_[sample] || mesh_.move(v, (samples_[sample] + mesh_.position(v)) / 2);
            }
    }

    /// Whether the sample is near the vertex, or so near to the surface around it that it lies along that.
    bool is_near(int v, const Point& sample) const
    {
        double longest = 0;
        mesh_.for_each_from(
            v, [&](int h)
            { longest = std::max(longest, (mesh_.position(v) - mesh_.position(mesh_.target(h))).squaredNorm()); });
        if ((mesh_.position(v) - sample).squaredNorm() < farthest * farthest * longest)
            return true;
        double least = longest;
        mesh_.for_each_from(v,
                            [&](int h)
                            {
                                least = std::min(least, squared_distance(sample, mesh_.position(v),
                                                                         mesh_.position(mesh_.target(h)),
                                                                         mesh_.position(mesh_.opposite(h))));
                            });
        return least < farthest_beside * farthest_beside * longest;
    }

    void insert_missing()
    {
        seatless_.erase(
            std::remove_if(seatless_.begin(), seatless_.end(), [&](int sample) { return is_vertex_[sample]; }),
            seatless_.end());
        if (seatless_.empty())
            return;
        Points vertices;
        for (int v = 0; v < mesh_.vertices(); ++v)
            vertices.push_back(mesh_.position(v));
        const BlockSearch search(vertices);
        for (const int i : seatless_)
            is_vertex_[i] = insert(samples_[i], search);
    }

    bool insert(const Point& p, const BlockSearch& search)
    {
        constexpr int around = 3;
        int vertices[around], nearest = -1;
        double squared[around], least = 1e300;
        const int count = search.nearest(p, around, vertices, squared);
        for (int k = 0; k < count; ++k)
            mesh_.for_each_from(vertices[k],
                                [&](int h)
                                {
                                    const double here = squared_distance(p, mesh_.position(mesh_.origin(h)),
                                                                         mesh_.position(mesh_.target(h)),
                                                                         mesh_.position(mesh_.opposite(h)));
                                    if (here < least)
                                    {
                                        least = here;
                                        nearest = h >> 2;
                                    }
                                });
        double longest = 0;
        for (int h = 4 * nearest; h < 4 * nearest + 3; ++h)
            longest =
                std::max(longest, (mesh_.position(mesh_.origin(h)) - mesh_.position(mesh_.target(h))).squaredNorm());
        if (!(least < farthest * farthest * longest))
            return false;
        if (mesh_.split(nearest, p))
            return true;
        std::array<std::pair<double, int>, 3> sides;
        for (int k = 0; k < 3; ++k)
        {
            const int h = 4 * nearest + k;
            sides[k] = {squared_distance(p, mesh_.position(mesh_.origin(h)), mesh_.position(mesh_.target(h))), h};
        }
        std::sort(sides.begin(), sides.end());
        return std::any_of(sides.begin(), sides.end(),
                           [&](const auto& side) { return mesh_.split_edge(side.second, p); });
    }

    HalfEdgeMesh mesh_;
    const Points& samples_;
    const std::vector<int>& seats_;
    std::vector<int> seatless_;   ///< Samples, ascending, that are no vertices yet.
    std::vector<char> is_vertex_; ///< Per sample.
    std::vector<char> changed_;   ///< Per vertex, in this round.
    int threads_;
};

} // namespace

std::vector<int> seat_samples(const NearestSamples& nearest, std::size_t sample_count)
{
    std::vector<int> seat(sample_count, -1);
    for (int v = 0; v < int(nearest.sample.size()); ++v)
        if (int& taken = seat[nearest.sample[v]]; taken < 0 || nearest.squared[v] < nearest.squared[taken])
            taken = v;
    std::vector<int> result(nearest.sample.size(), -1);
    for (int i = 0; i < int(seat.size()); ++i)
        if (seat[i] >= 0)
            result[seat[i]] = i;
    return result;
}

void interpolate_samples(TriangleMesh& mesh, const std::vector<int>& seats, const Points& samples, int threads)
{
    if (!mesh.triangles.empty())
        Interpolator(mesh, seats, samples, threads).run();
}

} // namespace recon
