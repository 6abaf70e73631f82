#include <recon/bare_faces/label_noisy_flats.h>

#include <recon/bare_faces/complete_noisy_flats.h>
#include <recon/bare_faces/label_flats.h>
#include <recon/mesh/mismatch.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace recon
{
namespace
{

/// Up to the first share of violated votes a denoised cloud is not searched for bare faces, up to the second only if
/// its crust is bare somewhere: a plate with samples on its rims and bores may come out filled with few objections.
constexpr double calm_votes = 0.001, calm_votes_of_whole = 0.005;
/// Slabs in which planes are sought, in turns, while the votes refuse the completed crust or it is bare or in pieces.
/// Rims with a bevel of one or two sigma fit some of these better; which, the bare area tells.
struct Slabs
{
    double noise;               ///< Assumed in all that follows [1 = the noise].
    std::vector<double> widths; ///< In each of these faces are sought [1 = by that noise].
    Leaning leaning;
};
/// The last four are for sparse rims, and wide: one part may have rims with wide bevels and without, so faces of
/// several widths are taken together.
const Slabs slabs_in_turn[] = {{1, {1}, Leaning::by_share},
                               {1.1, {1}, Leaning::by_share},
                               {1.35, {1}, Leaning::by_share},
                               {1, {1}, Leaning::beyond_chance},
                               {1, {1, 1.35, 1.7, 2.1}, Leaning::beyond_chance},
                               {1.7, {1}, Leaning::beyond_chance},
                               {2.1, {1}, Leaning::beyond_chance}};
/// Wide slabs hold both rims of a bevel, and the face comes to lie between them: these only above this share of
/// violated votes, and if points lie along lines. Below 0.009 plates bevelled by 2.6 to 3.3 sigma were right without.
constexpr double votes_for_last_slabs = 0.01;
/// Share of the lack that other slabs may leave.
constexpr double clearly_less = 0.5;

/// Points of a neighbourhood that may be a line, and seeds of which one is asked [count].
constexpr int on_line = 32, line_seeds = 4000;
/// Spread across a line over that along it, as variances, and share of neighbourhoods of that kind in clouds of rims:
/// 0.06 and more with five samples a spot and noise of up to 0.4 % of the diagonal; at most 0.005 of open scans.
constexpr double slender = 0.1, some_lines = 0.02;

/// What a completed crust still lacks.
struct JudgedFlats
{
    LabelledNoisyFlats flats;
    double lack = 0; ///< See measure_lack().
    int bodies = 1;

    bool is_whole() const { return lack <= bare_lid && bodies == 1; }
    bool is_better_than(const JudgedFlats& other) const
    {
        if (bodies != other.bodies)
            return bodies < other.bodies && lack <= std::max(bare_lid, other.lack);
        return lack < clearly_less * other.lack ||
               (lack < other.lack && flats.labelled.violated_votes < other.flats.labelled.violated_votes);
    }
};

/// Faces of a cloud in slabs, each sought once.
class FacesInSlabs
{
public:
    FacesInSlabs(const DenoisedCloud& cloud, int threads) : cloud_(cloud), threads_(threads) {}

    std::vector<NoisyFaces> list(const Slabs& slabs)
    {
        std::vector<NoisyFaces> result;
        for (const double width : slabs.widths)
        {
            const double noise = width * slabs.noise * cloud_.noise;
            const auto [place, is_new] = known_.insert({{slabs.leaning, noise}, {}});
            if (is_new)
                place->second = find_noisy_faces(cloud_.points, noise, slabs.leaning, threads_);
            result.push_back(place->second);
        }
        return result;
    }

private:
    const DenoisedCloud& cloud_;
    int threads_;
    std::map<std::pair<Leaning, double>, NoisyFaces> known_; ///< By the noise assumed.
};

/// With samples on bare flat faces in the place of those around their rims. None if there are none.
std::optional<LabelledNoisyFlats> complete(const DenoisedCloud& cloud, const Slabs& slabs, FacesInSlabs& faces,
                                           const LabelWithin& label, double bearable_votes, PhaseTimes& times,
                                           int threads)
{
    times.begin("flat faces");
    const NoisyFlatCompletion flats = complete_noisy_flats(cloud.points, slabs.noise * cloud.noise, faces.list(slabs),
                                                           slabs.leaning, cloud.samples, cloud.normals, threads);
    if (flats.points.empty())
        return {};
    Points samples;
    Vectors normals;
    for (std::size_t i = 0; i < cloud.samples.size(); ++i)
        if (!flats.is_replaced[i])
        {
            samples.push_back(cloud.samples[i]);
            normals.push_back(cloud.normals[i]);
        }
    samples.insert(samples.end(), flats.points.begin(), flats.points.end());
    normals.insert(normals.end(), flats.normals.begin(), flats.normals.end());
    LabelledBalls labelled = label(samples, normals, bearable_votes);
    return LabelledNoisyFlats{std::move(samples), std::move(normals), std::move(labelled), int(flats.points.size())};
}

JudgedFlats judge(LabelledNoisyFlats flats, const DenoisedCloud& cloud, double noise, int threads)
{
    flats.polygons = list_crust_polygons(flats.labelled.regular, flats.labelled.labels, threads);
    const TriangleMesh crust = triangulate_polygons(*flats.polygons, threads);
    const double lack = measure_lack(cloud.points, flats.samples, crust, noise, threads);
    return {std::move(flats), lack, measure_closed_topology(crust).components};
}

} // namespace

bool lie_along_lines(const Points& points, const BlockSearch& search)
{
    const std::size_t step = std::max<std::size_t>(1, points.size() / line_seeds);
    int indices[on_line], seeds = 0, lines = 0;
    double squared[on_line];
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    for (std::size_t i = 0; i < points.size(); i += step, ++seeds)
    {
        const int count = search.nearest(points[i], on_line, indices, squared);
        Vector mean = Vector::Zero();
        for (int k = 0; k < count; ++k)
            mean += (points[indices[k]] - points[i]) / count;
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for (int k = 0; k < count; ++k)
        {
            const Vector offset = points[indices[k]] - points[i] - mean;
            covariance += offset * offset.transpose();
        }
        solver.computeDirect(covariance, Eigen::EigenvaluesOnly);
        lines += solver.eigenvalues()[1] < slender * solver.eigenvalues()[2];
    }
    return lines > some_lines * seeds;
}

std::optional<LabelledNoisyFlats> label_with_noisy_flats(const DenoisedCloud& cloud, const LabelledBalls& plain,
                                                         double most_noise, const LabelWithin& label,
                                                         std::optional<CrustPolygons>& polygons, PhaseTimes& times,
                                                         int threads)
{
    const double violated = plain.violated_votes;
    if (violated <= calm_votes || !(cloud.noise > 0))
        return {};
    std::optional<bool> bare;
    const auto is_bare = [&]
    {
        if (!bare)
        {
            times.begin("mismatch");
            polygons = list_crust_polygons(plain.regular, plain.labels, threads);
            bare = measure_bare_area(cloud.points, triangulate_polygons(*polygons, threads), threads) > bare_lid;
        }
        return *bare;
    };
    if (violated <= calm_votes_of_whole && !is_bare())
        return {};
    std::optional<bool> sparse;
    const auto may_be_sparse = [&]
    {
        if (!sparse)
            sparse =
                violated > votes_for_last_slabs && lie_along_lines(cloud.points, BlockSearch(cloud.points, threads));
        return *sparse;
    };
    const double bearable_votes = clearly_fewer_with_flats * violated;
    FacesInSlabs faces(cloud, threads);
    std::optional<JudgedFlats> best;
    for (const Slabs& slabs : slabs_in_turn)
    {
        if (slabs.leaning == Leaning::beyond_chance && !may_be_sparse())
            break;
        std::optional<LabelledNoisyFlats> flats = complete(cloud, slabs, faces, label, bearable_votes, times, threads);
        if (!flats)
        {
            // Few clouds have any; what several slabs do not show one of them does not.
            if (best || !is_bare() || slabs.widths.size() > 1)
                break;
            continue;
        }
        const double now = flats->labelled.violated_votes;
        // Where faces are bare most samples are on them. A few facets of a coarse model, that the votes do not want,
        // are no better in other slabs.
        if (!best && now > violated && flats->added < int(cloud.samples.size()))
            break;
        if (now <= bearable_votes)
        {
            times.begin("mismatch");
            JudgedFlats judged = judge(std::move(*flats), cloud, most_noise, threads);
            if (!best || judged.is_better_than(*best))
                best = std::move(judged);
        }
        // Slabs of another width may show what is missing, or leave out a face that is none.
        if (best && best->is_whole())
            break;
    }
    return best ? std::optional(std::move(best->flats)) : std::nullopt;
}

double measure_lack(const Points& points, const Points& samples, const TriangleMesh& crust, double noise, int threads)
{
    const double bare = measure_bare_area(samples, crust, threads);
    return bare <= bare_lid ? bare : bare + measure_missed_points(points, crust, threads, {}, noise);
}

} // namespace recon
