#include "sheet_ends.h"

#include <recon/disjoint_sets.h>
#include <recon/parallel.h>
#include <recon/search/keep_apart.h>
#include <recon/search/neighbours.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace recon
{
namespace
{

// Lengths in scales of the ball.
constexpr std::array<double, 3> classes{1, 2, 4}; // of balls by radius, asked one after the other
constexpr double largest_ball = classes.back();
constexpr int scout_every = 8;
constexpr double scouted_within = 6;
constexpr double votes_within = 2, least_votes = 0.5; // of the balls there
constexpr double apart = 0.6;                         // places
constexpr double follows_within = 4, least_ahead_cosine = 0.9, same_face_cosine = 0.8;
constexpr int least_places = 4; // that follow one another
constexpr double corner_within = 4, corner_overlap = 0.5, corner_gap = 0.5, one_corner = 1;
constexpr double gap_of_noise = 3;
constexpr double least_squared_sine = 0.3; // between edges that meet

/// A place, and to which ball it belongs.
struct End : EdgePlace
{
    int ball;
};

class EndFinder
{
public:
    EndFinder(const std::vector<AxisBall>& balls, const Points& points, double noise, int threads)
        : balls_(balls), points_(points), search_(points, threads), noise_(noise), threads_(threads),
          found_(balls.size()), is_asked_(balls.size(), 0)
    {
    }

    SheetEnds run(const Progress& progress)
    {
        collect_ends(progress);
        follow_edges();
        drop_short_edges();
        SheetEnds result;
        result.places = list_places();
        const int first = int(balls_.size());
        for (const auto& [i, j] : follow_)
        {
            const int a = ends_[i].ball, b = ends_[j].ball;
            if (a != b)
                result.triangles.push_back({a, b, first + i});
            result.triangles.push_back({b, first + j, first + i});
        }
        add_corners(result);
        return result;
    }

private:
    double scale_at(std::size_t end) const { return balls_[ends_[end].ball].scale; }

    /// One per place: of the ball that is nearest to the edge.
    void collect_ends(const Progress& progress)
    {
        ask_balls(progress);
        const std::vector<char> is_elected = take_vote();
        std::vector<End> ends;
        for (std::size_t b = 0; b < balls_.size(); ++b)
            if (is_elected[b])
                ends.insert(ends.end(), found_[b].begin(), found_[b].end());
        std::stable_sort(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.depth < b.depth; });
        Points places;
        std::vector<double> radii;
        for (const End& end : ends)
        {
            places.push_back(end.place);
            radii.push_back(apart * balls_[end.ball].scale);
        }
        for (const int i : keep_apart(places, radii))
            ends_.push_back(ends[i]);
    }

    /// A few balls first, then those around which one of these has an edge below: on round shapes that is none. Of
    /// these the smallest first, which lie nearest to an edge: where it is known then the others need not be asked.
    void ask_balls(const Progress& progress)
    {
        std::vector<int> scouts, others;
        for (int b = 0; b < int(balls_.size()); ++b)
            if (balls_[b].radius <= largest_ball * balls_[b].scale)
                (b % scout_every == 0 ? scouts : others).push_back(b);
        ask(scouts, {}, progress.part(0, 0.3));
        drop_unpromising(scouts, others);
        Points places;
        double least = 0;
        for (std::size_t k = 0; k < classes.size(); ++k)
        {
            std::vector<int> chosen;
            for (const int b : others)
                if (const double radius = balls_[b].radius / balls_[b].scale; radius > least && radius <= classes[k])
                    chosen.push_back(b);
            const double share = 0.7 / double(classes.size());
            ask(chosen, places, progress.part(0.3 + share * double(k), 0.3 + share * double(k + 1)));
            for (const int b : chosen)
                for (const End& end : found_[b])
                    places.push_back(end.place);
            least = classes[k];
        }
    }

    /// \param known places: balls that would find one of them again need not be asked.
    void ask(const std::vector<int>& chosen, const Points& known, const Progress& progress)
    {
        const NeighbourSearch search(known);
        const auto ask_one = [&](EdgePlaceFinder& finder, int b)
        {
            const auto is_known = [&](const Point& place)
            {
                const int nearest = search.nearest(place);
                return nearest >= 0 && (known[nearest] - place).norm() < apart * balls_[b].scale;
            };
            bool is_of_two_faces = false;
            for (const EdgePlace& edge : finder.find(balls_[b], is_known, is_of_two_faces))
                found_[b].push_back({edge, b});
            is_asked_[b] = is_of_two_faces;
        };
        constexpr std::size_t grain = 64;
        parallel_chunks(chosen.size(), threads_, grain, progress,
                        [&](std::size_t begin, std::size_t end)
                        {
                            EdgePlaceFinder finder(points_, search_, noise_);
                            for (std::size_t k = begin; k < end; ++k)
                                ask_one(finder, chosen[k]);
                        });
    }

    void drop_unpromising(const std::vector<int>& scouts, std::vector<int>& others) const
    {
        Points successful;
        for (const int b : scouts)
            if (!found_[b].empty())
                successful.push_back(balls_[b].centre);
        const NeighbourSearch search(successful);
        const auto is_far = [&](int b)
        {
            const int nearest = search.nearest(balls_[b].centre);
            return nearest < 0 || (successful[nearest] - balls_[b].centre).norm() > scouted_within * balls_[b].scale;
        };
        others.erase(std::remove_if(others.begin(), others.end(), is_far), others.end());
    }

    /// Per ball, whether enough of those around that were asked have an edge below: a few of a bumpy limb's look so.
    std::vector<char> take_vote() const
    {
        Points centres;
        std::vector<int> asked;
        for (std::size_t b = 0; b < balls_.size(); ++b)
            if (is_asked_[b])
            {
                centres.push_back(balls_[b].centre);
                asked.push_back(int(b));
            }
        const NeighbourSearch search(centres);
        std::vector<char> is_elected(balls_.size(), 0);
        parallel_for(balls_.size(), threads_, {},
                     [&](std::size_t b)
                     {
                         if (found_[b].empty())
                             return;
                         std::vector<int> around;
                         search.within(balls_[b].centre, votes_within * balls_[b].scale, around);
                         const auto agreeing = std::count_if(around.begin(), around.end(),
                                                             [&](int i) { return !found_[asked[i]].empty(); });
                         is_elected[b] = double(agreeing) > least_votes * double(around.size());
                     });
        return is_elected;
    }

    static bool have_same_faces(const End& a, const End& b)
    {
        const auto agree = [&](int i, int j) { return a.normals[i].dot(b.normals[j]) > same_face_cosine; };
        return (agree(0, 0) && agree(1, 1)) || (agree(0, 1) && agree(1, 0));
    }

    /// The next place along the edge, both ways: side 1 is that of `along`.
    void follow_edges()
    {
        is_open_.assign(ends_.size(), {1, 1});
        const Points places = list_places();
        const NeighbourSearch search(places);
        std::vector<int> around;
        for (std::size_t i = 0; i < ends_.size(); ++i)
            for (const int side : {0, 1})
            {
                const Vector way = (side ? 1 : -1) * ends_[i].along;
                int next = -1;
                double least = follows_within * scale_at(i);
                search.within(places[i], least, around);
                for (const int j : around)
                {
                    const Vector d = places[j] - places[i];
                    const double length = d.norm();
                    if (j != int(i) && length < least && d.dot(way) > least_ahead_cosine * length &&
                        have_same_faces(ends_[i], ends_[j]))
                    {
                        next = j;
                        least = length;
                    }
                }
                if (next < 0)
                    continue;
                is_open_[i][side] = 0;
                is_open_[next][way.dot(ends_[next].along) > 0 ? 0 : 1] = 0;
                follow_.push_back({std::min(int(i), next), std::max(int(i), next)});
            }
        std::sort(follow_.begin(), follow_.end());
        follow_.erase(std::unique(follow_.begin(), follow_.end()), follow_.end());
    }

    void drop_short_edges()
    {
        DisjointSets edges(ends_.size());
        for (const auto& [i, j] : follow_)
            edges.join(i, j);
        std::vector<int> count(ends_.size(), 0), number(ends_.size(), -1);
        for (std::size_t i = 0; i < ends_.size(); ++i)
            ++count[std::size_t(edges.find(int(i)))];
        std::size_t kept = 0;
        for (std::size_t i = 0; i < ends_.size(); ++i)
            if (count[std::size_t(edges.find(int(i)))] >= least_places)
            {
                number[i] = int(kept);
                ends_[kept] = ends_[i];
                is_open_[kept++] = is_open_[i];
            }
        ends_.resize(kept);
        is_open_.resize(kept);
        follow_.erase(std::remove_if(follow_.begin(), follow_.end(), [&](const auto& f) { return number[f[0]] < 0; }),
                      follow_.end());
        for (auto& [i, j] : follow_)
        {
            i = number[i];
            j = number[j];
        }
    }

    struct Corner
    {
        Point sum = Point::Zero();
        std::vector<int> members; ///< Ends from which it was found.
        Point place() const { return sum / double(members.size()); }
    };

    /// Where an edge that has no next place meets another such.
    void add_corners(SheetEnds& result) const
    {
        const NeighbourSearch search(result.places);
        std::vector<Corner> corners;
        for (std::size_t i = 0; i < ends_.size(); ++i)
            for (const int side : {0, 1})
                if (is_open_[i][side])
                    if (const auto place = find_corner(int(i), side, search))
                    {
                        const double one = one_corner * scale_at(i) + gap_of_noise * noise_;
                        auto corner =
                            std::find_if(corners.begin(), corners.end(),
                                         [&](const Corner& other) { return (other.place() - *place).norm() < one; });
                        if (corner == corners.end())
                            corner = corners.insert(corners.end(), Corner());
                        corner->sum += *place;
                        corner->members.push_back(int(i));
                    }
        const int first = int(balls_.size());
        for (const Corner& corner : corners)
        {
            const int number = first + int(result.places.size());
            result.places.push_back(corner.place());
            for (const int i : corner.members)
                result.triangles.push_back({ends_[i].ball, first + i, number});
        }
    }

    /// The nearest one that way.
    std::optional<Point> find_corner(int i, int side, const NeighbourSearch& search) const
    {
        const Vector u = (side ? 1 : -1) * ends_[i].along;
        const double scale = scale_at(std::size_t(i)), farthest = corner_within * scale;
        std::vector<int> around;
        search.within(ends_[i].place, 2 * farthest, around);
        std::sort(around.begin(), around.end());
        std::optional<Point> best;
        double nearest = farthest;
        for (const int j : around)
            for (const int other_side : {0, 1})
            {
                if (j == i || !is_open_[j][other_side])
                    continue;
                // s u and t v lead to where the two lines are nearest to one another.
                const Vector v = (other_side ? 1 : -1) * ends_[j].along, d = ends_[j].place - ends_[i].place;
                const double cosine = u.dot(v), squared_sine = 1 - cosine * cosine;
                if (squared_sine < least_squared_sine)
                    continue;
                const double s = (d.dot(u) - cosine * d.dot(v)) / squared_sine,
                             t = (cosine * d.dot(u) - d.dot(v)) / squared_sine;
                if (std::min(s, t) < -corner_overlap * scale || t > farthest || s >= nearest)
                    continue;
                const Point a = ends_[i].place + s * u, b = ends_[j].place + t * v;
                if ((a - b).norm() > corner_gap * scale + gap_of_noise * noise_)
                    continue;
                nearest = s;
                best = (a + b) / 2;
            }
        return best;
    }

    Points list_places() const
    {
        Points places;
        for (const End& end : ends_)
            places.push_back(end.place);
        return places;
    }

    const std::vector<AxisBall>& balls_;
    const Points& points_;
    BlockSearch search_;
    double noise_;
    int threads_;
    std::vector<std::vector<End>> found_; ///< Per ball.
    std::vector<char> is_asked_;          ///< Per ball, whether it touches what may be two faces and was asked.
    std::vector<End> ends_;
    std::vector<std::array<char, 2>> is_open_; ///< Per end and side, whether no other follows.
    std::vector<std::array<int, 2>> follow_;   ///< Ends that follow one another.
};

} // namespace

std::vector<AxisBall> list_axis_balls(const LabelledBalls& labelled, const Points& samples,
                                      const std::vector<int>& chosen)
{
    const PolarBalls& kept = labelled.kept;
    std::vector<AxisBall> balls;
    std::vector<int> number(kept.balls.size(), -1);
    const auto touch = [&](AxisBall& ball, int b)
    {
        for (const int v : kept.touched[b])
            if (v < int(samples.size()))
                ball.touched.push_back(samples[v]);
    };
    for (const int b : chosen)
    {
        number[b] = int(balls.size());
        balls.push_back({kept.balls[b].centre, kept.balls[b].radius, labelled.scale[b], {}});
        touch(balls.back(), b);
    }
    for (const auto& [hidden, visible] : labelled.twins)
        if (number[visible] >= 0)
            touch(balls[number[visible]], hidden);
    return balls;
}

SheetEnds find_sheet_ends(const std::vector<AxisBall>& balls, const Points& points, double noise, int threads,
                          const Progress& progress)
{
    return EndFinder(balls, points, noise, threads).run(progress);
}

} // namespace recon
