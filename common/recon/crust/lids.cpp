#include <recon/crust/lids.h>

#include <recon/search/neighbours.h>

#include <algorithm>
#include <array>

namespace recon
{
namespace
{

/// Distance from a face to the nearest sample that makes it part of a lid [spacings], and the radius that a ball under
/// it has at least [scales].
constexpr double bare_beyond = 3, large_from = 3;

/// A corner of the face between the cells of two balls.
struct FaceCorner
{
    int inner, outer, cell;
    bool operator<(const FaceCorner& b) const
    {
        return std::array{inner, outer, cell} < std::array{b.inner, b.outer, b.cell};
    }
    bool is_of_face(const FaceCorner& b) const { return inner == b.inner && outer == b.outer; }
};

std::vector<FaceCorner> list_corners_at_large_balls(const LabelledBalls& labelled)
{
    std::vector<FaceCorner> corners;
    const auto is_large = [&](int b) { return labelled.kept.balls[b].radius > large_from * labelled.scale[b]; };
    for (int c = 0; c < labelled.regular.finite_cells; ++c)
        for (const int a : labelled.regular.cells[c].vertices)
            for (const int b : labelled.regular.cells[c].vertices)
                if (labelled.labels[a] == Side::inner && labelled.labels[b] == Side::outer && is_large(a))
                    corners.push_back({a, b, c});
    std::sort(corners.begin(), corners.end());
    return corners;
}

} // namespace

std::vector<int> list_balls_under_lids(const Points& samples, const LabelledBalls& labelled)
{
    const NeighbourSearch search(samples);
    const auto is_bare = [&](const Point& p)
    {
        const Point& sample = samples[search.nearest(p)];
        return (p - sample).norm() > bare_beyond * measure_spacing_at(sample, search);
    };
    std::vector<int> result;
    const std::vector<FaceCorner> corners = list_corners_at_large_balls(labelled);
    for (auto face = corners.begin(); face != corners.end();)
    {
        const auto end = std::find_if(face, corners.end(), [&](const FaceCorner& c) { return !c.is_of_face(*face); });
        Point sum = Point::Zero();
        for (auto c = face; c != end; ++c)
            sum += labelled.regular.centres[c->cell];
        if ((result.empty() || result.back() != face->inner) && is_bare(sum / double(end - face)))
            result.push_back(face->inner);
        face = end;
    }
    return result;
}

std::optional<LabelledBalls> label_with_open_lids(const Points& samples, const Vectors& normals,
                                                  const LabelledBalls& labelled, BallLabellingOptions options,
                                                  PhaseTimes& times, const Progress& progress)
{
    if (labelled.is_shared) // the balls of the next run would have other numbers
        return {};
    options.opened = list_balls_under_lids(samples, labelled);
    if (options.opened.empty())
        return {};
    options.most_violated = clearly_fewer_votes * labelled.violated_votes;
    LabelledBalls opened = label_polar_balls(samples, normals, options, times, progress);
    return opened.violated_votes < options.most_violated ? std::optional(std::move(opened)) : std::nullopt;
}

std::string describe_thin_walls(bool opened, bool found_with_less_noise, double violated_votes)
{
    constexpr double votes_of_holes = 0.03; // 0.033 to 0.042 of those of walls of two sigma
    if (!opened && !(found_with_less_noise && violated_votes > votes_of_holes))
        return {};
    return "Walls are hardly thicker than the noise or the spacing. What they hold was left hollow, since the points "
           "object to filling it; the walls may have holes. Scan them more densely.";
}

} // namespace recon
