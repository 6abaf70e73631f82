#include "crease_places.h"

#include "face_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon::pn
{

namespace
{

constexpr double room = 0.65;         ///< Between crease samples [spacings].
constexpr int beside_an_edge = 12;    ///< Samples that are asked about it,
constexpr int around_a_corner = 24;   ///< and about a corner.
constexpr double corner_volume = 0.3; ///< Least of three normals: else their planes nearly share a line.

} // namespace

Points positions_of(const std::vector<CreasePlace>& places)
{
    Points positions;
    for (const CreasePlace& p : places)
        positions.push_back(p.point);
    return positions;
}

Thinning::Thinning(const std::vector<CreasePlace>& proposed, const Points& taken)
    : proposed_(proposed), positions_(positions_of(proposed))
{
    is_taken_.assign(positions_.size(), 0);
    positions_.insert(positions_.end(), taken.begin(), taken.end());
    is_taken_.resize(positions_.size(), 1);
    search_ = std::make_unique<NeighbourSearch>(positions_);
}

bool Thinning::is_free(std::size_t k)
{
    search_->within(positions_[k], room * proposed_[k].spacing, near_);
    return std::none_of(near_.begin(), near_.end(), [&](int m) { return is_taken_[std::size_t(m)] != 0; });
}

CreasePlace Faces::place(const Point& x, std::vector<int> around) const
{
    double sum = 0;
    for (int i : around)
        sum += double(spacing_[std::size_t(i)]);
    const double mean = sum / double(around.size());
    return {x, std::move(around), mean};
}

bool Faces::meet(int a, int b, int c, Point& x) const
{
    Eigen::Matrix3d planes;
    planes << normal(a).transpose(), normal(b).transpose(), normal(c).transpose();
    if (std::abs(planes.determinant()) < corner_volume)
        return false;
    const Vector heights(0, normal(b).dot(point(b) - point(a)), normal(c).dot(point(c) - point(a)));
    x = point(a) + planes.inverse() * heights;
    return true;
}

bool Faces::is_edge(int i, int j, const Point& x) const
{
    const Vector &a = normal(i), &b = normal(j);
    const double side_of_i = (point(i) - x).dot(b), side_of_j = (point(j) - x).dot(a);
    if (side_of_i * side_of_j <= 0)
        return false;
    constexpr double same_face = 0.9, in_plane = 0.3; // cosine, sine
    constexpr double beyond = 0.2;                    // sine of the angle to the plane of the other
    const double nearby = std::max((point(i) - x).norm(), (point(j) - x).norm());
    const auto goes_on = [&](int m, const Vector& own, const Vector& other, double side)
    {
        const Vector d = point(m) - x;
        const double length = d.norm();
        return length < nearby && normal(m).dot(own) > same_face && std::abs(d.dot(own)) < in_plane * length &&
               d.dot(other) * (side > 0 ? 1 : -1) < -beyond * length;
    };
    const std::vector<int> near = nearest(x, beside_an_edge, 1.5 * nearby);
    return !is_hidden_by(near, x, {i, j}) && !bends_between(near, i, j, x, 1.5 * nearby) &&
           std::none_of(near.begin(), near.end(),
                        [&](int m) { return goes_on(m, a, b, side_of_i) || goes_on(m, b, a, side_of_j); });
}

bool Faces::are_edges(const CreasePlace& at) const
{
    for (std::size_t p = 0; p < at.around.size(); ++p)
        for (std::size_t q = 0; q < p; ++q)
            if (!is_edge(at.around[p], at.around[q], at.point))
                return false;
    return true;
}

bool Faces::are_sharp(const CreasePlace& at) const
{
    for (std::size_t p = 0; p < at.around.size(); ++p)
        for (std::size_t q = 0; q < p; ++q)
            if (!ends_sharply(usable_, std::size_t(at.around[p]), std::size_t(at.around[q]), at.point,
                              least_agreement_))
                return false;
    return true;
}

bool Faces::has_sample_near(const Point& x, int face, double distance) const
{
    constexpr double same_face = 0.9, in_plane = 0.2; // cosine, [spacings]
    const double off = in_plane * double(spacing_[std::size_t(face)]);
    const std::vector<int> near = nearest(x, around_a_corner, 0);
    return std::any_of(near.begin(), near.end(),
                       [&](int m)
                       {
                           const Vector d = point(m) - x;
                           return d.norm() < distance && normal(m).dot(normal(face)) > same_face &&
                                  std::abs(d.dot(normal(face))) < off;
                       });
}

bool Faces::is_hidden(const Point& x, const std::vector<int>& samples) const
{
    return is_hidden_by(nearest(x, around_a_corner, 0), x, samples);
}

bool Faces::is_hidden_by(const std::vector<int>& near, const Point& x, const std::vector<int>& samples) const
{
    return std::any_of(near.begin(), near.end(),
                       [&](int m)
                       { return std::any_of(samples.begin(), samples.end(), [&](int i) { return hides(m, i, x); }); });
}

/// Whether the sheet of sample m lies between a sample and x.
bool Faces::hides(int m, int from, const Point& x) const
{
    constexpr double beside = 1.1, least_height = 0.1; // [spacings]
    const Vector& n = normal(m);
    const double spacing = double(spacing_[std::size_t(m)]), h0 = n.dot(point(from) - point(m)),
                 h1 = n.dot(x - point(m));
    if (h0 * h1 >= 0 || std::min(std::abs(h0), std::abs(h1)) < least_height * spacing)
        return false;
    const Point crossing = point(from) + h0 / (h0 - h1) * (x - point(from));
    return (crossing - point(m)).norm() < beside * spacing;
}

bool Faces::bends_between(int i, int j, const Point& x, double reach) const
{
    return bends_between(nearest(x, beside_an_edge, reach), i, j, x, reach);
}

bool Faces::bends_between(const std::vector<int>& near, int i, int j, const Point& x, double reach) const
{
    return std::any_of(near.begin(), near.end(),
                       [&](int m) { return (point(m) - x).norm() < reach && is_between(m, i, j); });
}

bool Faces::is_between(int m, int i, int j) const
{
    constexpr double between = 0.75; // of the angle from one normal to the other, seen from either
    const double least = std::cos(between * std::acos(std::clamp(normal(i).dot(normal(j)), -1.0, 1.0)));
    return normal(m).dot(normal(i)) > least && normal(m).dot(normal(j)) > least;
}

/// The samples nearest to x. \param reach a guess of how far they lie, 0 for none.
std::vector<int> Faces::nearest(const Point& x, int count, double reach) const
{
    std::vector<int> near(std::size_t(count), 0);
    std::vector<double> squared(near.size());
    near.resize(std::size_t(usable_.search->nearest(x, count, near.data(), squared.data(), reach)));
    return near;
}

} // namespace recon::pn
