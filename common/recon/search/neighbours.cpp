#include <recon/search/neighbours.h>

#include <recon/search/block_search.h>

#include <nanoflann.hpp>

#include <cmath>
#include <limits>
#include <utility>

namespace recon
{
namespace
{

struct Adaptor
{
    const Points* points;

    std::size_t kdtree_get_point_count() const { return points->size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const { return (*points)[i][Eigen::Index(axis)]; }
    template <class Bounds>
    bool kdtree_get_bbox(Bounds&) const
    {
        return false;
    }
};

using Index = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Adaptor>, Adaptor, 3, int>;

/// Collects indices in a closed ball without a second array of distances.
class IndicesWithin
{
public:
    using DistanceType = double;
    using IndexType = int;

    IndicesWithin(double squared_radius, std::vector<int>& indices)
        : limit_(std::nextafter(squared_radius, std::numeric_limits<double>::infinity())), indices_(indices)
    {
    }
    std::size_t size() const { return indices_.size(); }
    bool full() const { return true; }
    bool addPoint(double squared, int index)
    {
        if (squared < limit_)
            indices_.push_back(index);
        return true;
    }
    double worstDist() const { return limit_; }
    void sort() {} // asked for from nanoflann 1.5 on

private:
    double limit_;
    std::vector<int>& indices_;
};

} // namespace

struct NeighbourSearch::Tree
{
    explicit Tree(const Points& points)
        : adaptor{&points}, index(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(12))
    {
        if (!points.empty())
            index.buildIndex();
    }
    Adaptor adaptor;
    Index index;
};

NeighbourSearch::NeighbourSearch(const Points& points) : tree_(std::make_unique<Tree>(points)) {}
NeighbourSearch::~NeighbourSearch() = default;
NeighbourSearch::NeighbourSearch(NeighbourSearch&&) noexcept = default;
NeighbourSearch& NeighbourSearch::operator=(NeighbourSearch&&) noexcept = default;

int NeighbourSearch::nearest(const Point& query, int k, int* indices, double* squared) const
{
    if (tree_->adaptor.points->empty() || k <= 0)
        return 0;
    return int(tree_->index.knnSearch(query.data(), std::size_t(k), indices, squared));
}

int NeighbourSearch::nearest(const Point& query) const
{
    int index = -1;
    double squared = 0;
    return nearest(query, 1, &index, &squared) > 0 ? index : -1;
}

void NeighbourSearch::within(const Point& query, double radius, std::vector<int>& indices) const
{
    indices.clear();
    if (tree_->adaptor.points->empty())
        return;
    IndicesWithin found(radius * radius, indices);
    tree_->index.findNeighbors(found, query.data(), {});
}

namespace
{

template <class Search>
double measure_mean_distance(const Point& point, const Search& search)
{
    constexpr int around = 7; // the point itself is the first
    int indices[around];
    double squared[around], sum = 0;
    const int found = search.nearest(point, around, indices, squared);
    for (int k = 1; k < found; ++k)
        sum += std::sqrt(squared[k]);
    return found > 1 ? sum / (found - 1) : 0;
}

} // namespace

double measure_spacing_at(const Point& point, const NeighbourSearch& search)
{
    return measure_mean_distance(point, search);
}

double measure_spacing_at(const Point& point, const BlockSearch& search)
{
    return measure_mean_distance(point, search);
}

} // namespace recon
