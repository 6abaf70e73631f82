#pragma once

#include "filter_pn_refine/samples/usable_samples.h"

#include <recon/search/neighbours.h>

#include <memory>
#include <vector>

namespace recon::pn
{

/// A place on an edge or corner, and a sample of each face that meets there.
struct CreasePlace
{
    Point point;
    std::vector<int> around;
    double spacing; ///< Of the cloud here.
    bool is_sharp = false;

    bool is_corner() const { return around.size() > 2; }
};

Points positions_of(const std::vector<CreasePlace>& places);

/// Takes of places near each other those that are asked for first.
class Thinning
{
public:
    /// \param taken positions that are taken from the beginning.
    Thinning(const std::vector<CreasePlace>& proposed, const Points& taken);
    bool is_free(std::size_t k);
    void take(std::size_t k) { is_taken_[k] = 1; }

private:
    const std::vector<CreasePlace>& proposed_;
    Points positions_;
    std::vector<char> is_taken_;
    std::unique_ptr<NeighbourSearch> search_;
    std::vector<int> near_;
};

/// The faces on which samples lie, and whether they meet in edges and corners.
class Faces
{
public:
    /// \param least_agreement cosine of the crease angle.
    Faces(const UsableSamples& usable, const std::vector<float>& spacing, double least_agreement)
        : usable_(usable), points_(usable.samples.points), normals_(usable.samples.normals), spacing_(spacing),
          least_agreement_(least_agreement)
    {
    }

    const Point& point(int i) const { return points_[std::size_t(i)]; }
    const Vector& normal(int i) const { return normals_[std::size_t(i)]; }
    /// Whether the normals of two samples differ enough for a crease.
    bool differ(int i, int j) const { return normal(i).dot(normal(j)) < least_agreement_; }

    double distance_to_samples(const Point& x) const { return (point(usable_.search->nearest(x)) - x).norm(); }

    CreasePlace place(const Point& x, std::vector<int> around) const;
    /// Where the planes of three samples meet. \returns false if they nearly share a line.
    bool meet(int a, int b, int c, Point& x) const;
    /// Whether the faces of samples i and j end at x, as at an edge of the two: each lies on one side of the other, no
    /// other wall hides it, and no sample around has a normal between the two, as where a surface just bends.
    bool is_edge(int i, int j, const Point& x) const;
    /// Whether each two of a place's faces meet there in an edge.
    bool are_edges(const CreasePlace& at) const;
    /// Whether each two of them end there sharply.
    bool are_sharp(const CreasePlace& at) const;
    /// Whether a sample of the same face as sample `face` lies nearer to x.
    bool has_sample_near(const Point& x, int face, double distance) const;
    /// Whether another sheet lies between any of these samples and x: x is on another wall then.
    bool is_hidden(const Point& x, const std::vector<int>& samples) const;
    /// Whether samples nearer to x than `reach` have normals between those of i and j: the face just bends there.
    bool bends_between(int i, int j, const Point& x, double reach) const;
    /// Whether the normal of m lies between those of i and j.
    bool is_between(int m, int i, int j) const;

private:
    std::vector<int> nearest(const Point& x, int count, double reach) const;
    bool is_hidden_by(const std::vector<int>& near, const Point& x, const std::vector<int>& samples) const;
    bool bends_between(const std::vector<int>& near, int i, int j, const Point& x, double reach) const;
    bool hides(int m, int from, const Point& x) const;

    const UsableSamples& usable_;
    const Points& points_;
    const Vectors& normals_;
    const std::vector<float>& spacing_;
    const double least_agreement_;
};

} // namespace recon::pn
