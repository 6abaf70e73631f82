#include <recon/crust/back_sheets.h>

#include <recon/disjoint_sets.h>
#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/level_sheet.h>
#include <recon/mesh/mismatch.h>
#include <recon/parallel.h>
#include <recon/search/block_search.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon
{
namespace
{

/// Samples looked at around each [count], itself included; of these the nearest hang together with it.
constexpr int around = 31, touching = 9;
/// Fewer samples without an inside that hang together are noise: up to 3 in clouds of closed models, 24 at the rim of a
/// scan, 23 to 119 in fins scanned from one side [count].
constexpr int least_sheet = 20;
/// Share of samples without an inside around one that makes it part of a lost sheet, and that has its back put up too.
constexpr double lost_above = 0.5, backed_above = 0.1;
/// Least distance of a back from all samples [spacings].
constexpr double room = 1;
/// Share of its samples that the crust misses where a lost sheet is gone or lace: .13 on the dragon's jaw, .67 to 1 of
/// fins; 0 to .011 where thin parts have a face without samples, which the crust closes in its place.
constexpr double gone_above = 0.05;
/// Share of these, and of the violated votes, that backs may leave. Most votes that a scan violates lie elsewhere: .88
/// of them are left on the dragon, .1 to .3 behind fins.
constexpr double found_again = 0.5, fewer_violated = 0.97;
/// Share of the lost samples in the largest sheet below which they are all over an open scene, as roofs and walls seen
/// from the air (0.24), whose backs have more handles than they spare.
constexpr double scattered_below = 0.3;

bool has_no_inside(const LabelledBalls& labelled, bool oriented, std::size_t sample)
{
    const auto& [first, second] = labelled.kept.of_sample[sample];
    if (first < 0 || second < 0)
        return false;
    // With normals the first ball is the one in front.
    return labelled.labels[second] == Side::outer && (oriented || labelled.labels[first] == Side::outer);
}

bool is_lost(double share_around)
{
    return share_around > lost_above;
}

/// Sheets of samples that hang together, around which more than a share has no inside.
class Sheets
{
public:
    Sheets(const std::vector<double>& around, double above, const Points& samples, const BlockSearch& search,
           int threads)
        : around_(around), above_(above), sheets_(around.size())
    {
        parallel_for(samples.size(), threads, {},
                     [&](std::size_t i)
                     {
                         if (around[i] <= above)
                             return;
                         int indices[touching];
                         double squared[touching];
                         const int found = search.nearest(samples[i], touching, indices, squared);
                         for (int k = 0; k < found; ++k)
                             if (around[std::size_t(indices[k])] > above)
                                 sheets_.join(int(i), indices[k]);
                     });
    }
    int find(std::size_t sample) { return sheets_.find(int(sample)); }
    /// Samples of each sheet, at its representative [count].
    std::vector<int> sizes()
    {
        std::vector<int> result(around_.size(), 0);
        for (std::size_t i = 0; i < around_.size(); ++i)
            if (around_[i] > above_)
                ++result[std::size_t(find(i))];
        return result;
    }

private:
    const std::vector<double>& around_;
    double above_;
    DisjointSets sheets_;
};

/// Only sheets of least_sheet samples and more, each with what borders on it.
LostSheets without_rims(LostSheets lost, const Points& samples, int threads)
{
    const BlockSearch search(samples, threads);
    Sheets cores(lost.around, lost_above, samples, search, threads);
    Sheets wide(lost.around, backed_above, samples, search, threads);
    const std::vector<int> sizes = cores.sizes();
    std::vector<char> has_core(samples.size(), 0);
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (is_lost(lost.around[i]) && sizes[std::size_t(cores.find(i))] >= least_sheet)
            has_core[std::size_t(wide.find(i))] = 1;
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (!has_core[std::size_t(wide.find(i))])
            lost.around[i] = 0;
    return lost;
}

/// Share of the lost samples that the crust of the labels misses [0..1].
double measure_missed(const LostSheets& lost, const Points& samples, const LabelledBalls& labelled, int threads)
{
    Points members;
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (is_lost(lost.around[i]))
            members.push_back(samples[i]);
    const TriangleMesh crust =
        triangulate_polygons(list_crust_polygons(labelled.regular, labelled.labels, threads), threads);
    return measure_missed_points(members, crust, threads);
}

} // namespace

std::string describe_lost(double share)
{
    const long percent = std::lround(100 * share);
    return (percent > 0 ? std::to_string(percent) + " %" : std::string("Some")) +
           " of the samples are of sheets that have no inside, as of a scan from one side only. ";
}

std::string describe_backs(double share)
{
    return describe_lost(share) + "They were given a back, some three spacings behind the points.";
}

LostSheets find_lost_sheets(const Points& samples, const LabelledBalls& labelled, bool oriented, int threads,
                            const Progress& progress)
{
    const std::size_t n = samples.size();
    std::vector<char> is_hollow(n);
    for (std::size_t i = 0; i < n; ++i)
        is_hollow[i] = has_no_inside(labelled, oriented, i);
    if (std::count(is_hollow.begin(), is_hollow.end(), 1) < least_sheet / 2)
        return {};
    LostSheets result;
    result.around.resize(n, 0);
    const BlockSearch search(samples, threads);
    const auto look_around = [&](bool hollow_ones)
    {
        parallel_for(n, threads, progress,
                     [&](std::size_t i)
                     {
                         if (bool(is_hollow[i]) != hollow_ones)
                             return;
                         int indices[around];
                         double squared[around];
                         const int found = search.nearest(samples[i], around, indices, squared);
                         const auto hollow =
                             std::count_if(indices, indices + found, [&](int j) { return is_hollow[std::size_t(j)]; });
                         result.around[i] = double(hollow) / found;
                     });
    };
    // Most clouds have hollow samples here and there, but no sheet: then the many others need not be asked.
    look_around(true);
    const auto lost = [&] { return std::count_if(result.around.begin(), result.around.end(), is_lost); };
    if (lost() < least_sheet / 2)
        return {};
    look_around(false);
    const std::vector<int> sizes = Sheets(result.around, lost_above, samples, search, threads).sizes();
    const int largest = *std::max_element(sizes.begin(), sizes.end());
    result.share = double(lost()) / double(n);
    if (largest < least_sheet && result.share <= bearable_lost)
        return {};
    result.largest = largest / double(n);
    return result;
}

bool may_be_a_sheet(const LostSheets& lost, bool is_open, double violated)
{
    return lost.largest > bearable_lost || (is_open && violated > open_behind);
}

bool add_ground(const Points& samples, const Vectors& normals, LostSheets& lost, int threads)
{
    const BlockSearch search(samples, threads);
    std::vector<double> spacing(samples.size());
    parallel_for(samples.size(), threads, {},
                 [&](std::size_t i) { spacing[i] = measure_spacing_at(samples[i], search); });
    const std::optional<Ground> ground = find_ground(samples, times_area(normals, spacing));
    if (!ground || !ground->faces_things)
        return false;
    lost.around.resize(samples.size(), 0);
    for (const int i : ground->members)
        lost.around[i] = 1;
    lost.share = std::max(lost.share, double(ground->members.size()) / double(samples.size()));
    return true;
}

int back_sheets(const LostSheets& lost, Points& samples, Vectors& normals, int threads, double thickness)
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

std::optional<BackedSheets> label_with_backs(const LostSheets& lost, const Points& samples, bool oriented,
                                             const std::function<Vectors(const Progress&)>& list_normals,
                                             const LabelledBalls& labelled, const BallLabellingOptions& options,
                                             PhaseTimes& times, const Progress& progress)
{
    if (lost.around.empty() || lost.largest < scattered_below * lost.share)
        return {};
    times.begin("backs of sheets");
    const double missed = measure_missed(lost, samples, labelled, options.threads);
    if (missed <= gone_above)
        return {};
    Points all = samples;
    Vectors normals = list_normals(progress.part(0, 0.4, "normals"));
    times.begin("backs of sheets");
    const int backs = back_sheets(without_rims(lost, samples, options.threads), all, normals, options.threads);
    if (backs == 0)
        return {};
    if (!oriented)
        normals.clear();
    const BallLabellingOptions fewer = options.within(fewer_violated * labelled.violated_votes);
    LabelledBalls backed = label_polar_balls(all, normals, fewer, times, progress.part(0.4, 1, "polar balls"));
    if (backed.violated_votes > fewer.most_violated)
        return {};
    times.begin("backs of sheets");
    const double left = measure_missed(lost, samples, backed, options.threads);
    times.end();
    if (left > found_again * missed)
        return {};
    return BackedSheets{std::move(all), std::move(normals), std::move(backed), backs, lost.share};
}

} // namespace recon
