#include <recon/scan/scan_splitter.h>

#include <recon/median.h>
#include <recon/parallel.h>
#include <recon/scan/ray_meeting.h>
#include <recon/scan/scan_rows.h>
#include <recon/scramble.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace recon
{
namespace
{

/// Fewer points say nothing [count].
constexpr std::size_t fewest_points = 200;
/// Windows in which places are sought, up to so many [count], each with these gaps at least; and how: a place that few
/// of a window's gaps see is found in a smaller one.
constexpr std::size_t most_windows = 32, few_gaps = 8, most_gaps = 2'000;
constexpr MeetingTrials of_windows{100, 50};
/// Least share of a window's gaps whose rays meet.
constexpr double large_part = 0.3;
/// Rows are broken where rays saw nothing. Such scans are as even as this all the same.
constexpr double broken_rows = 0.85;
/// Points in a block, and blocks, up to so many [count], and points of it that are asked.
constexpr std::size_t least_block = 32, most_blocks = 2'000, most_asked = 10;
/// Blocks whose points follow each other so much less evenly than those of a scan may be of one that is not known yet,
/// those that deviate by so much are of none, and what it takes to pass from one scan to the next [logarithm of the
/// deviation, block by block].
constexpr double far_less_even = 8, uneven = 0.2, of_change = 6;
/// As even as rounding leaves them.
constexpr double least_deviation = 1e-4;
/// Least share of the gaps that places of scans see across: 0.58 to 1 of scenes of more than one thing, simulated; up
/// to 0.3 of range scans by a line that moves, whose rays meet in no place.
constexpr double least_seen = 0.4;
/// Parts of one scan are as even from the place of one as from each's own, up to this factor, and its gaps are seen
/// from there as from its own.
constexpr double as_even = 1.5, as_seen = 0.8;
/// Places that are tried where none is known: of the points' box, each moved to where they are most even.
constexpr std::size_t starts = 12;
constexpr int rounds = 6;
/// Distance of two places that are the same [distance from the points].
constexpr double same = 0.02;

class ScanSplitter
{
public:
    ScanSplitter(const Points& points, const std::vector<std::size_t>& gaps, int threads, const Progress& progress)
        : points_(points), box_(bounding_box(points)), gaps_(gaps), threads_(threads), progress_(progress),
          block_(std::max(least_block, points.size() / most_blocks + 1)), blocks_((points.size() + block_ - 1) / block_)
    {
    }

    std::vector<Scan> split()
    {
        look_at_windows(progress_.part(0, 0.5));
        if (candidates_.empty())
            return {};
        std::vector<Run> runs = list_runs(far_less_even * least_of_candidates());
        for (int k = 0; k < rounds && are_seen_across(scans_of(runs)) &&
                        look_at_unknown(runs, progress_.part(0.5, 0.5 + 0.05 * (k + 1)));
             ++k)
            runs = list_runs(far_less_even * least_of_candidates());
        runs = list_runs(uneven);
        for (std::size_t k = 1; k < runs.size(); ++k)
            if (runs[k - 1].candidate >= 0 && runs[k].candidate >= 0)
                runs[k - 1].end = runs[k].begin = find_change(runs[k - 1], runs[k]);
        std::vector<Scan> scans;
        for (Scan& scan : scans_of(runs))
        {
            progress_.part(0.8, 1).report(double(scan.begin) / double(points_.size()));
            const Points points = slice(scan.begin, scan.end);
            const std::optional<Candidate> found = settle(points, scan.place);
            if (!found || !is_seen_from(*found, points))
                continue;
            scan.place = found->place;
            if (scans.empty() || !join(scans.back(), scan))
                scans.push_back(scan);
        }
        return are_seen_across(scans) ? scans : std::vector<Scan>();
    }

private:
    struct Candidate
    {
        Point place;
        Evenness seen; ///< Of the points that it was found of.
    };
    /// Points in a row.
    struct Run
    {
        std::size_t begin, end;
        int candidate; ///< -1 if none is known.
    };

    double deviation_at(std::size_t i, const Point& place) const { return measure_deviation(points_, i, place); }

    Points slice(std::size_t begin, std::size_t end) const
    {
        return Points(points_.begin() + std::ptrdiff_t(begin), points_.begin() + std::ptrdiff_t(end));
    }

    static bool is_same(const Point& a, const Point& b, const Point& seen)
    {
        return (a - b).norm() < same * (seen - a).norm();
    }

    /// A place moved to where points are most even, if they are as even as those of a scan from there; that it sees all
    /// is asked later, for it takes longer.
    static std::optional<Candidate> settle(const Points& points, const Point& start)
    {
        if (points.size() < fewest_points)
            return {};
        const Point most_even = find_most_even(points, start);
        Candidate result{most_even, measure_evenness(points, most_even)};
        if (const Evenness before = measure_evenness(points, start); before.deviation < result.seen.deviation)
            result = {start, before};
        const bool is_even = result.seen.share >= broken_rows || result.seen.is_exact();
        return is_even ? std::optional(result) : std::nullopt;
    }

    static bool is_seen_from(const Candidate& candidate, const Points& points)
    {
        return candidate.seen.is_exact() || sees_all(points, candidate.place);
    }

    bool is_known(const Point& place, const Point& seen) const
    {
        return std::any_of(candidates_.begin(), candidates_.end(),
                           [&](const Candidate& other) { return is_same(place, other.place, seen); });
    }

    /// Places where the rays of windows meet.
    void look_at_windows(const Progress& progress)
    {
        for (std::size_t windows = 1; windows <= most_windows && gaps_.size() >= few_gaps * windows; windows *= 2)
        {
            std::vector<std::optional<Candidate>> found(windows);
            parallel_for(
                windows, threads_, progress, [&](std::size_t k) { found[k] = look_at_window(k, windows); }, 1);
            for (std::size_t k = 0; k < windows; ++k)
                if (found[k] && !is_known(found[k]->place, points_[gaps_[gaps_.size() * k / windows]]))
                    candidates_.push_back(*found[k]);
        }
    }

    std::optional<Candidate> look_at_window(std::size_t k, std::size_t windows) const
    {
        const std::size_t first = gaps_.size() * k / windows, end = gaps_.size() * (k + 1) / windows;
        std::vector<std::size_t> asked;
        for (std::size_t g = first; g < end; g += (end - first) / most_gaps + 1)
            asked.push_back(gaps_[g]);
        const std::optional<Meeting> meeting = find_meeting(points_, asked, of_windows);
        const auto is_large_part = [&] { return meeting->rays >= few_gaps && meeting->share() >= large_part; };
        if (!meeting || !meeting->is_sharp() || !(meeting->has_many() || is_large_part()))
            return {};
        const Points points = slice(gaps_[first], gaps_[end - 1]);
        const std::optional<Candidate> found = settle(points, meeting->place);
        const bool is_new = found && !is_known(found->place, points.front());
        return is_new && is_seen_from(*found, points) ? found : std::nullopt;
    }

    /// What is said against a place by a block, `none` by one too short to say anything.
    double measure_cost(std::size_t block, const Point& place, double none) const
    {
        const std::size_t begin = std::max<std::size_t>(1, block * block_),
                          end = std::min(points_.size() - 1, (block + 1) * block_);
        std::vector<double> deviations;
        for (std::size_t i = begin; i < end; i += block_ / most_asked)
            deviations.push_back(deviation_at(i, place));
        return deviations.empty() ? none : std::log(std::max(least_deviation, median(std::move(deviations))));
    }

    double least_of_candidates() const
    {
        double least = std::numeric_limits<double>::infinity();
        for (const Candidate& candidate : candidates_)
            least = std::min(least, candidate.seen.deviation);
        return std::max(least_deviation, least);
    }

    /// Blocks in a row of the same scan, as told by all that is said against each: Viterbi's way. \param least_of_none
    /// deviation above which a block is of none that is known.
    std::vector<Run> list_runs(double least_of_none) const
    {
        const std::size_t labels = candidates_.size() + 1;
        const double none = std::log(least_of_none);
        std::vector<double> costs(labels, 0), against(blocks_ * labels, none);
        parallel_for(
            blocks_, threads_, progress_.part(0.5, 0.5),
            [&](std::size_t b)
            {
                for (std::size_t k = 0; k < candidates_.size(); ++k)
                    against[b * labels + k] = measure_cost(b, candidates_[k].place, none);
            },
            16);
        std::vector<std::vector<int>> before(blocks_, std::vector<int>(labels));
        for (std::size_t b = 0; b < blocks_; ++b)
        {
            const int cheapest = int(std::min_element(costs.begin(), costs.end()) - costs.begin());
            const double changed = costs[std::size_t(cheapest)] + of_change;
            for (std::size_t k = 0; k < labels; ++k)
            {
                before[b][k] = changed < costs[k] ? cheapest : int(k);
                costs[k] = std::min(costs[k], changed) + against[b * labels + k];
            }
        }
        std::vector<Run> runs;
        int label = int(std::min_element(costs.begin(), costs.end()) - costs.begin());
        for (std::size_t b = blocks_; b-- > 0; label = before[b][std::size_t(label)])
        {
            const int candidate = label < int(candidates_.size()) ? label : -1;
            if (runs.empty() || runs.back().candidate != candidate)
                runs.push_back({b * block_, std::min(points_.size(), (b + 1) * block_), candidate});
            runs.back().begin = b * block_;
        }
        std::reverse(runs.begin(), runs.end());
        return runs;
    }

    /// Whether there are more candidates now.
    bool look_at_unknown(const std::vector<Run>& runs, const Progress& progress)
    {
        bool found = false;
        for (const Run& run : runs)
            if (run.candidate < 0)
                for (std::size_t parts = 1; parts <= 4; parts *= 2)
                    for (std::size_t k = 0; k < parts; ++k)
                        found |= look_at(run.begin + (run.end - run.begin) * k / parts,
                                         run.begin + (run.end - run.begin) * (k + 1) / parts, progress);
        return found;
    }

    bool look_at(std::size_t begin, std::size_t end, const Progress& progress)
    {
        const Points points = slice(begin, end);
        std::vector<Candidate> found = parallel_collect<Candidate>(
            starts, threads_, progress,
            [&](std::size_t k, std::vector<Candidate>& settled)
            {
                const auto draw = [&](std::size_t axis) { return double(scramble(3 * k + axis) % 1'000) / 1'000; };
                const Point start =
                    box_.minimum + Vector(draw(0), draw(1), draw(2)).cwiseProduct(box_.maximum - box_.minimum);
                if (const std::optional<Candidate> candidate = settle(points, start))
                    settled.push_back(*candidate);
            },
            1);
        std::stable_sort(found.begin(), found.end(),
                         [](const Candidate& a, const Candidate& b) { return a.seen.deviation < b.seen.deviation; });
        const auto best = std::find_if(found.begin(), found.end(),
                                       [&](const Candidate& candidate) { return is_seen_from(candidate, points); });
        if (best == found.end() || is_known(best->place, points.front()))
            return false;
        candidates_.push_back(*best);
        return true;
    }

    /// Where, of the blocks about the end of a run, the points begin to be more even as seen by the next.
    std::size_t find_change(const Run& run, const Run& next) const
    {
        const std::size_t begin = std::max({std::size_t(1), run.begin, run.end - std::min(run.end, 2 * block_)}),
                          end = std::min({points_.size() - 1, next.end, run.end + 2 * block_});
        std::size_t best = run.end;
        int sum = 0, most = std::numeric_limits<int>::min();
        for (std::size_t i = begin; i < end; ++i)
        {
            if (sum > most)
            {
                most = sum;
                best = i;
            }
            sum += deviation_at(i, candidates_[std::size_t(run.candidate)].place) <
                           deviation_at(i, candidates_[std::size_t(next.candidate)].place)
                       ? 1
                       : -1;
        }
        return best;
    }

    std::vector<Scan> scans_of(const std::vector<Run>& runs) const
    {
        std::vector<Scan> scans;
        for (const Run& run : runs)
            if (run.candidate >= 0)
                scans.push_back({run.begin, run.end, candidates_[std::size_t(run.candidate)].place});
        return scans;
    }

    struct Gaps
    {
        std::size_t all = 0, seen = 0; ///< [count]
    };
    /// Of a scan, as seen from a place.
    Gaps count_gaps(const Scan& scan, const Point& place) const
    {
        Gaps gaps;
        for (auto gap = std::lower_bound(gaps_.begin(), gaps_.end(), scan.begin + 1);
             gap != gaps_.end() && *gap + 2 < scan.end; ++gap)
        {
            ++gaps.all;
            gaps.seen += sees_across(place, points_, *gap);
        }
        return gaps;
    }

    bool are_seen_across(const std::vector<Scan>& scans) const
    {
        Gaps sum;
        for (const Scan& scan : scans)
        {
            const Gaps gaps = count_gaps(scan, scan.place);
            sum.all += gaps.all;
            sum.seen += gaps.seen;
        }
        return double(sum.seen) >= least_seen * double(sum.all);
    }

    /// Whether a scan may have been seen from another place.
    bool can_be_from(const Scan& scan, const Point& place) const
    {
        const Points points = slice(scan.begin, scan.end);
        const Evenness seen = measure_evenness(points, place), own = measure_evenness(points, scan.place);
        return (seen.is_exact() || seen.deviation <= as_even * std::max(least_deviation, own.deviation)) &&
               double(count_gaps(scan, place).seen) >= as_seen * double(count_gaps(scan, scan.place).seen);
    }

    /// One of both, if the place of one may be that of the other. \returns whether they are.
    bool join(Scan& scan, const Scan& next) const
    {
        const bool is_first = can_be_from(next, scan.place), is_next = can_be_from(scan, next.place);
        if (!is_first && !is_next)
            return false;
        if (!is_first || (is_next && count_gaps(next, next.place).seen > count_gaps(scan, scan.place).seen))
            scan.place = next.place;
        scan.end = next.end;
        return true;
    }

    const Points& points_;
    Box box_;
    const std::vector<std::size_t>& gaps_;
    const int threads_;
    const Progress progress_;
    std::size_t block_, blocks_; ///< Points in a block, and blocks [count].
    std::vector<Candidate> candidates_;
};

} // namespace

std::vector<Scan> split_scans(const Points& points, const std::vector<std::size_t>& gaps, int threads,
                              const Progress& progress)
{
    return points.size() < fewest_points ? std::vector<Scan>() : ScanSplitter(points, gaps, threads, progress).split();
}

} // namespace recon
