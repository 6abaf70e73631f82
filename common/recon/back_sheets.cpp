#include <recon/back_sheets.h>

#include <recon/disjoint_sets.h>
#include <recon/level_sheet.h>
#include <recon/neighbours.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

/// Samples looked at around each [count], itself included; of these the nearest hang together with it.
constexpr int around = 31, touching = 9;
/// Up to this share of samples without an inside, rims of scans, no sheet is lost.
constexpr double least_share = 0.01;
/// Share of samples without an inside around one that makes it part of a lost sheet, and that has its back put up too.
constexpr double lost_above = 0.5, backed_above = 0.1;
/// Distance from a sheet to its back, and least distance of the back from all samples [spacings]. Slabs of two spacings
/// and more come out whole.
constexpr double thickness = 3, room = 1;

bool has_no_inside(const LabelledBalls& labelled, bool oriented, std::size_t sample)
{
    const auto& [first, second] = labelled.kept.of_sample[sample];
    if (first < 0 || second < 0)
        return false;
    // With normals the first ball is the one in front.
    return labelled.labels[second] == Side::outer && (oriented || labelled.labels[first] == Side::outer);
}

} // namespace

std::string describe_lost(double share)
{
    return std::to_string(int(std::lround(100 * share))) +
           " % of the samples are of sheets that have no inside, as of a scan from one side only. ";
}

std::string describe_backs(double share)
{
    return describe_lost(share) + "They were given a back, three spacings behind the points.";
}

LostSheets find_lost_sheets(const Points& samples, const LabelledBalls& labelled, bool oriented, int threads)
{
    LostSheets result;
    std::vector<char> is_hollow(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i)
        is_hollow[i] = has_no_inside(labelled, oriented, i);
    if (std::count(is_hollow.begin(), is_hollow.end(), 1) <= least_share * double(samples.size()))
        return result;
    result.around.resize(samples.size());
    const NeighbourSearch search(samples);
    parallel_for(samples.size(), threads, {},
                 [&](std::size_t i)
                 {
                     int indices[around];
                     double squared[around];
                     const int found = search.nearest(samples[i], around, indices, squared);
                     const auto hollow = std::count_if(indices, indices + found, [&](int j) { return is_hollow[j]; });
                     result.around[i] = double(hollow) / found;
                 });
    const auto is_lost = [&](int i) { return result.around[std::size_t(i)] > lost_above; };
    DisjointSets sheets(samples.size());
    const auto join_neighbours = [&](std::size_t i)
    {
        if (!is_lost(int(i)))
            return;
        int indices[touching];
        double squared[touching];
        const int found = search.nearest(samples[i], touching, indices, squared);
        for (int k = 0; k < found; ++k)
            if (is_lost(indices[k]))
                sheets.join(int(i), indices[k]);
    };
    parallel_for(samples.size(), threads, {}, join_neighbours);
    std::vector<int> sizes(samples.size(), 0);
    int lost = 0, largest = 0;
    for (int i = 0; i < int(samples.size()); ++i)
        if (is_lost(i))
        {
            ++lost;
            largest = std::max(largest, ++sizes[std::size_t(sheets.find(i))]);
        }
    result.share = lost / double(samples.size());
    result.largest = largest / double(samples.size());
    return result;
}

bool add_ground(const Points& samples, const Vectors& normals, LostSheets& lost)
{
    const std::optional<Ground> ground = find_ground(samples, normals);
    if (!ground || !ground->faces_things)
        return false;
    lost.around.resize(samples.size(), 0);
    for (const int i : ground->members)
        lost.around[i] = 1;
    lost.share = std::max(lost.share, double(ground->members.size()) / double(samples.size()));
    return true;
}

int back_sheets(const LostSheets& lost, Points& samples, Vectors& normals, int threads)
{
    std::vector<int> backed;
    for (int i = 0; i < int(lost.around.size()); ++i)
        if (lost.around[i] > backed_above)
            backed.push_back(i);
    Points backs(backed.size());
    std::vector<char> has_room(backed.size());
    const NeighbourSearch search(samples);
    parallel_for(backed.size(), threads, {},
                 [&](std::size_t k)
                 {
                     const Point& p = samples[backed[k]];
                     const double spacing = measure_spacing_at(p, search);
                     backs[k] = p - thickness * spacing * normals[backed[k]];
                     has_room[k] = (samples[search.nearest(backs[k])] - backs[k]).norm() >= room * spacing;
                 });
    int added = 0;
    for (std::size_t k = 0; k < backed.size(); ++k)
        if (has_room[k])
        {
            samples.push_back(backs[k]);
            normals.push_back(-normals[backed[k]]);
            ++added;
        }
    return added;
}

} // namespace recon
