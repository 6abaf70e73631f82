#include <recon/collapse_edges.h>

#include <recon/crust_mesh.h>

#include <Eigen/Geometry>

#include <algorithm>

namespace recon
{
namespace
{

class Collapser
{
public:
    Collapser(TriangleMesh& mesh, const std::vector<double>& scale, const EdgeCollapseOptions& options)
        : mesh_(mesh), scale_(scale), options_(options), at_(mesh.vertices.size()), alive_(mesh.triangles.size(), 1),
          merged_(mesh.vertices.size(), 1), vertices_left_(int(mesh.vertices.size())), marks_(mesh.vertices.size(), 0)
    {
        for (int t = 0; t < int(mesh.triangles.size()); ++t)
            for (const int v : mesh.triangles[t])
                at_[v].push_back(t);
    }

    void run()
    {
        // Rising limits instead of a queue by length: nearly the same order, and memory is walked in order.
        for (const double share : {0.01, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0})
            collapse_below(share * options_.always_below, 0);
        for (const double share : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0})
            collapse_below(options_.always_below + share * (options_.never_above - options_.always_below),
                           options_.target_vertices);
    }

    const std::vector<char>& alive() const { return alive_; }

private:
    /// One walk over all edges.
    void collapse_below(double limit, int target)
    {
        for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
            for (int e = 0; e < 3 && alive_[t]; ++e)
            {
                if (vertices_left_ <= target)
                    return;
                const int a = mesh_.triangles[t][e], b = mesh_.triangles[t][(e + 1) % 3];
                if (a < b && squared_length(a, b) <= limit * limit && is_allowed(a, b))
                    collapse(a, b);
            }
    }

    /// Relative to the scale.
    double squared_length(int a, int b) const
    {
        const double scale = std::min(scale_[a], scale_[b]);
        return (mesh_.vertices[a] - mesh_.vertices[b]).squaredNorm() / (scale * scale);
    }

    /// Power vertices crowd at the samples, so the end that has swallowed more lies on one: it stays.
    Point target_of(int a, int b) const
    {
        if (merged_[a] >= 2 * merged_[b])
            return mesh_.vertices[a];
        if (merged_[b] >= 2 * merged_[a])
            return mesh_.vertices[b];
        return 0.5 * (mesh_.vertices[a] + mesh_.vertices[b]);
    }

    Vector area_normal(const std::array<int, 3>& t, int moved_a, int moved_b, const Point& to) const
    {
        const auto corner = [&](int k) -> const Point&
        { return t[k] == moved_a || t[k] == moved_b ? to : mesh_.vertices[t[k]]; };
        return (corner(1) - corner(0)).cross(corner(2) - corner(0));
    }

    bool is_allowed(int a, int b)
    {
        if (at_[a].size() + at_[b].size() > 40)
            return false; // fans of such size are slivers again
        // Link condition on a closed manifold: the ends share just the two vertices opposite their edge, and those keep
        // three neighbours.
        const int mark_a = ++mark_, mark_common = ++mark_;
        for (const int t : at_[a])
            for (const int v : mesh_.triangles[t])
                marks_[v] = mark_a;
        int common = 0;
        for (const int t : at_[b])
            for (const int v : mesh_.triangles[t])
                if (marks_[v] == mark_a && v != a && v != b)
                {
                    marks_[v] = mark_common;
                    ++common;
                    if (at_[v].size() <= 3)
                        return false;
                }
        if (common != 2)
            return false;
        if (squared_length(a, b) < 1e-6)
            return true; // the corners of one sample's cluster; their triangles have no direction to keep
        const Point target = target_of(a, b);
        Vector mean = Vector::Zero();
        for (const int v : {a, b})
            for (const int t : at_[v])
                mean += area_normal(mesh_.triangles[t], -1, -1, target);
        mean.normalize();
        for (const int v : {a, b})
            for (const int t : at_[v])
            {
                const auto& corners = mesh_.triangles[t];
                const bool goes = std::count(corners.begin(), corners.end(), a) && std::count(corners.begin(), corners.end(), b);
                if (goes)
                    continue;
                const Vector before = area_normal(corners, -1, -1, target), after = area_normal(corners, a, b, target);
                const double size = after.norm();
                if (!(after.dot(mean) > 0.2 * size) && !(after.dot(before) > 0.7 * size * before.norm()))
                    return false;
            }
        return true;
    }

    void collapse(int a, int b)
    {
        mesh_.vertices[a] = target_of(a, b);
        merged_[a] += merged_[b];
        for (const int t : at_[b])
        {
            auto& corners = mesh_.triangles[t];
            if (std::count(corners.begin(), corners.end(), a))
            {
                alive_[t] = 0;
                for (const int v : corners)
                    if (v != b)
                        at_[v].erase(std::find(at_[v].begin(), at_[v].end(), t));
                continue;
            }
            std::replace(corners.begin(), corners.end(), b, a);
            at_[a].push_back(t);
        }
        at_[b].clear();
        --vertices_left_;
    }

    TriangleMesh& mesh_;
    const std::vector<double>& scale_;
    const EdgeCollapseOptions& options_;
    std::vector<std::vector<int>> at_; ///< Triangles at each vertex.
    std::vector<char> alive_;
    std::vector<int> merged_; ///< Vertices that each one stands for.
    int vertices_left_;
    std::vector<int> marks_; ///< Per vertex: which test saw it last.
    int mark_ = 0;
};

} // namespace

std::vector<int> collapse_short_edges(TriangleMesh& mesh, const std::vector<double>& scale, const EdgeCollapseOptions& options)
{
    mesh.faux_edges.clear();
    Collapser collapser(mesh, scale, options);
    collapser.run();
    return keep_triangles(mesh, collapser.alive());
}

} // namespace recon
