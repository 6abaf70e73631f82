#include <recon/back_sheets.h>

#include <recon/level_sheet.h>
#include <recon/neighbours.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

/// Samples looked at around each [count], itself included.
constexpr int around = 31;
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
    const auto is_lost = [](double share) { return share > lost_above; };
    result.share = double(std::count_if(result.around.begin(), result.around.end(), is_lost)) / double(samples.size());
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
