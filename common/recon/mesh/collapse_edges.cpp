#include <recon/mesh/collapse_edges.h>

#include <recon/mesh/crust_mesh.h>
#include <recon/mesh/half_edge_mesh.h>
#include <recon/parallel.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace recon
{
namespace
{

/// Triangles on an edge shorter than this have no direction to keep [scale].
constexpr double coinciding = 1e-3;
/// Fans of more triangles are slivers again.
constexpr int most_neighbours = 40;
/// Vertices of a block lie side by side, as the crust's are numbered along a space-filling curve.
constexpr int block_size = 1 << 14;
constexpr int gone = -1;

int block_of(int vertex)
{
    return vertex / block_size;
}

/// Collapses edges in classes of rising length: nearly the order of a queue, and memory is walked in order. An edge is
/// asked for its length when its class comes up, and moves on to a later class if it has grown.
class Collapser
{
public:
    Collapser(TriangleMesh& mesh, const HalfEdges& half_edges, const std::vector<double>& scale,
              const std::vector<int>& merged, const EdgeCollapseOptions& options)
        : mesh_(mesh), options_(options), triangles_(mesh.triangles.size()), vertices_left_(int(mesh.vertices.size()))
    {
        for (const double share : {0.01, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0})
            limits_.push_back(share * options.always_below);
        unconditional_ = limits_.size();
        for (int step = 1; step <= 10; ++step)
            limits_.push_back(options.always_below + 0.1 * step * (options.never_above - options.always_below));
        if (!options.stays.empty())
            unconditional_ = limits_.size();

        constexpr std::size_t grain = 8192;
        vertices_.resize(mesh.vertices.size());
        parallel_for(
            vertices_.size(), options.threads, {},
            [&](std::size_t v)
            {
                vertices_[v] = {mesh.vertices[v],     scale[v],  half_edges.outgoing[v],
                                half_edges.degree[v], merged[v], !options.stays.empty() && options.stays[v]};
            },
            grain);
        parallel_for(
            triangles_.size(), options.threads, {},
            [&](std::size_t t)
            {
                const auto& corners = mesh.triangles[t];
                triangles_[t] = {{corners[0], corners[1], corners[2], gone}, half_edges.twin[t]};
            },
            grain);
        blocks_.resize(std::size_t(block_of(int(vertices_.size()) - 1)) + 1);
        parallel_for(
            blocks_.size(), options.threads, {}, [&](std::size_t b) { enlist_block(int(b)); }, 1);
    }

    void run()
    {
        for (std::size_t c = 0; c < limits_.size(); ++c)
            if (c < unconditional_)
                collapse_side_by_side(c);
            else
                collapse_to_target(c);
    }

    std::vector<int> copy_back() &&
    {
        for (std::size_t v = 0; v < vertices_.size(); ++v)
            mesh_.vertices[v] = vertices_[v].position;
        std::vector<char> alive(triangles_.size());
        for (std::size_t t = 0; t < alive.size(); ++t)
        {
            const auto& corners = triangles_[t].origin;
            alive[t] = corners[0] != gone;
            if (alive[t])
                mesh_.triangles[t] = {corners[0], corners[1], corners[2]};
        }
        return keep_triangles(mesh_, alive);
    }

private:
    /// Half-edge 4 t + k leads from corner k of triangle t to the next one.
    struct Triangle
    {
        std::array<int, 4> origin; ///< Of each half-edge; `gone` where the triangle is.
        std::array<int, 4> twin;   ///< Of each half-edge: the one back.
    };
    struct Vertex
    {
        Point position;
        double scale;
        int outgoing; ///< A half-edge from here; `gone` where the vertex is.
        int degree;   ///< Triangles here.
        int merged;   ///< Vertices that this one stands for.
        bool stays;
    };
    /// Vertices on which one thread works.
    struct Block
    {
        std::vector<std::vector<int>> edges; ///< Per class of length half-edges, one per edge or both, that start here.
        std::vector<int> crossing;           ///< Half-edges whose collapse would touch other blocks.
        int collapsed = 0;
    };
    /// The half-edges from both ends of an edge.
    struct Surroundings
    {
        int count_a = 0, count_b = 0;
        std::array<int, most_neighbours> from_a, from_b;
        std::array<int, most_neighbours> around_a, around_b; ///< Where they lead.
    };

    int& origin(int h) { return triangles_[h >> 2].origin[h & 3]; }
    int origin(int h) const { return triangles_[h >> 2].origin[h & 3]; }
    int target(int h) const { return origin(next_half_edge(h)); }
    int& twin(int h) { return triangles_[h >> 2].twin[h & 3]; }
    int twin(int h) const { return triangles_[h >> 2].twin[h & 3]; }

    /// Relative to the scale.
    double squared_length(int a, int b) const
    {
        const Vertex &p = vertices_[a], &q = vertices_[b];
        const double scale = std::min(p.scale, q.scale);
        return (p.position - q.position).squaredNorm() / (scale * scale);
    }

    /// Adds h to its class, but not to one before `earliest`.
    void enlist(int h, std::size_t earliest, Block& block)
    {
        if (vertices_[origin(h)].stays && vertices_[target(h)].stays)
            return;
        const double length = std::sqrt(squared_length(origin(h), target(h)));
        std::size_t c = earliest;
        while (c < limits_.size() && length > limits_[c])
            ++c;
        if (c < limits_.size())
            block.edges[c].push_back(h);
    }

    /// Enlists the edges from the block's vertices to later ones.
    void enlist_block(int b)
    {
        blocks_[b].edges.resize(limits_.size());
        const int end = std::min((b + 1) * block_size, int(vertices_.size()));
        for (int v = b * block_size; v < end; ++v)
        {
            int h = vertices_[v].outgoing;
            do
            {
                if (v < target(h))
                    enlist(h, 0, blocks_[b]);
                h = twin(previous_half_edge(h));
            } while (h != vertices_[v].outgoing);
        }
    }

    /// Blocks go side by side; what touches several comes after them, one by one.
    void collapse_side_by_side(std::size_t c)
    {
        parallel_for(
            blocks_.size(), options_.threads, {}, [&](std::size_t b) { collapse_block(int(b), c); }, 1);
        std::vector<int> crossing;
        for (Block& block : blocks_)
        {
            vertices_left_ -= block.collapsed;
            block.collapsed = 0;
            crossing.insert(crossing.end(), block.crossing.begin(), block.crossing.end());
            block.crossing.clear();
        }
        // By index: what a collapse makes of the edges around it comes up again here.
        for (std::size_t i = 0; i < crossing.size(); ++i)
        {
            const int h = crossing[i];
            if (origin(h) == gone)
                continue;
            Block& block = blocks_[block_of(origin(h))];
            vertices_left_ -= visit(h, c, block);
            crossing.insert(crossing.end(), block.edges[c].begin(), block.edges[c].end());
            block.edges[c].clear();
        }
    }

    void collapse_block(int b, std::size_t c)
    {
        Block& block = blocks_[b];
        // By index: a collapse can append to it.
        for (std::size_t i = 0; i < block.edges[c].size(); ++i)
        {
            const int h = block.edges[c][i];
            if (origin(h) == gone)
                continue;
            // Of an edge to another block not even the length may be asked for: that end may move meanwhile.
            if (block_of(origin(h)) != b || block_of(target(h)) != b)
                block.crossing.push_back(h);
            else
                block.collapsed += visit(h, c, block, b);
        }
        block.edges[c] = {};
    }

    void collapse_to_target(std::size_t c)
    {
        for (Block& block : blocks_)
        {
            for (std::size_t i = 0; i < block.edges[c].size(); ++i)
            {
                if (vertices_left_ <= options_.target_vertices)
                    return;
                const int h = block.edges[c][i];
                if (origin(h) != gone)
                    vertices_left_ -= visit(h, c, block);
            }
            block.edges[c] = {};
        }
    }

    static constexpr int any_block = -1;

    /// Collapses h if class c is its class and nothing forbids it, else puts it off. \returns the number of vertices
    /// that went.
    int visit(int h, std::size_t c, Block& block, int only_in = any_block)
    {
        const bool origin_stays = vertices_[origin(h)].stays, target_stays = vertices_[target(h)].stays;
        if (origin_stays && target_stays)
            return 0;
        if (target_stays || (!origin_stays && origin(h) > target(h)))
            h = twin(h); // so that the lower number is left
        const int a = origin(h), b = target(h);
        const double length2 = squared_length(a, b);
        if (length2 > limits_[c] * limits_[c])
        {
            enlist(h, c + 1, block);
            return 0;
        }
        Surroundings around;
        if (vertices_[a].degree + vertices_[b].degree <= most_neighbours)
        {
            gather(h, around);
            if (only_in != any_block && !lies_in_block(around, only_in))
            {
                block.crossing.push_back(h);
                return 0;
            }
            if (keeps_topology(around) && (length2 < coinciding * coinciding || keeps_directions(a, b, around)))
            {
                collapse(h, around, c, block);
                return 1;
            }
        }
        if (c + 1 < limits_.size())
            block.edges[c + 1].push_back(h);
        return 0;
    }

    void gather(int h, Surroundings& around) const
    {
        const auto walk = [&](int start, auto& half_edges, auto& ends)
        {
            int count = 0, g = start;
            do
            {
                half_edges[count] = g;
                ends[count++] = target(g);
                g = twin(previous_half_edge(g));
            } while (g != start);
            return count;
        };
        around.count_a = walk(h, around.from_a, around.around_a);
        around.count_b = walk(twin(h), around.from_b, around.around_b);
    }

    static bool lies_in_block(const Surroundings& around, int block)
    {
        const auto inside = [&](int v) { return block_of(v) == block; };
        return std::all_of(around.around_a.begin(), around.around_a.begin() + around.count_a, inside) &&
               std::all_of(around.around_b.begin(), around.around_b.begin() + around.count_b, inside);
    }

    /// Link condition on a closed manifold: the ends share just the two vertices opposite their edge, and those keep
    /// three neighbours.
    bool keeps_topology(const Surroundings& around) const
    {
        const auto end_a = around.around_a.begin() + around.count_a;
        int common = 0;
        for (int i = 0; i < around.count_b; ++i)
            if (std::find(around.around_a.begin(), end_a, around.around_b[i]) != end_a)
            {
                if (++common > 2 || vertices_[around.around_b[i]].degree <= 3)
                    return false;
            }
        return common == 2;
    }

    /// Whether no triangle turns against the mean of those around the edge from a to b, or much against what it was.
    bool keeps_directions(int a, int b, const Surroundings& around) const
    {
        const Point to = merge_point(a, b);
        std::array<Vector, most_neighbours> before, after; // twice the area times the normal; of triangles that stay
        int count = 0;
        Vector mean = Vector::Zero();
        const auto add_fan = [&](int centre, int other, const auto& ends, int number)
        {
            // Half-edges turn counter-clockwise: the triangle of the one to ends[i] lies towards ends[i + 1].
            for (int i = 0; i < number; ++i)
            {
                const int v = ends[i], w = ends[i + 1 < number ? i + 1 : 0];
                const Point &p = vertices_[centre].position, &q = vertices_[v].position, &r = vertices_[w].position;
                const Vector normal = (q - p).cross(r - p);
                mean += normal;
                if (v == other || w == other)
                    continue;
                before[count] = normal;
                after[count++] = (q - to).cross(r - to);
            }
        };
        add_fan(a, b, around.around_a, around.count_a);
        add_fan(b, a, around.around_b, around.count_b);
        mean.normalize();
        for (int i = 0; i < count; ++i)
            if (!keeps_direction(before[i], after[i], mean))
                return false;
        return true;
    }

    /// Power vertices crowd at the samples, so the end that has swallowed more lies on one: it stays.
    Point merge_point(int a, int b) const
    {
        const Vertex &p = vertices_[a], &q = vertices_[b];
        if (p.stays)
            return p.position;
        if (p.merged >= 2 * q.merged)
            return p.position;
        if (q.merged >= 2 * p.merged)
            return q.position;
        return 0.5 * (p.position + q.position);
    }

    /// Moves the target of h into its origin. Edges that become one stand for both from now on.
    void collapse(int h, const Surroundings& around, std::size_t c, Block& block)
    {
        const int a = origin(h), b = target(h), g = twin(h);
        vertices_[a].position = merge_point(a, b);
        vertices_[a].merged += vertices_[b].merged;
        vertices_[a].degree += vertices_[b].degree - 4;
        vertices_[b].outgoing = gone;
        for (int i = 0; i < around.count_b; ++i)
            origin(around.from_b[i]) = a;
        for (const int removed : {h, g})
        {
            const int one = twin(next_half_edge(removed)), other = twin(previous_half_edge(removed));
            const int opposite = origin(previous_half_edge(removed));
            twin(one) = other;
            twin(other) = one;
            const bool one_leaves = origin(one) == opposite;
            vertices_[opposite].outgoing = one_leaves ? one : other;
            --vertices_[opposite].degree;
            vertices_[a].outgoing = one_leaves ? other : one;
            block.edges[c].push_back(one);
        }
        triangles_[h >> 2].origin = triangles_[g >> 2].origin = {gone, gone, gone, gone};
    }

    TriangleMesh& mesh_;
    const EdgeCollapseOptions& options_;
    std::vector<double> limits_;    ///< Upper ends of the classes of length [scale].
    std::size_t unconditional_ = 0; ///< Classes that go whatever the number of vertices.
    std::vector<Triangle> triangles_;
    std::vector<Vertex> vertices_;
    int vertices_left_;
    std::vector<Block> blocks_;
};

} // namespace

std::vector<int> collapse_short_edges(TriangleMesh& mesh, const HalfEdges& half_edges, const std::vector<double>& scale,
                                      const std::vector<int>& merged, const EdgeCollapseOptions& options)
{
    mesh.faux_edges.clear();
    if (mesh.triangles.empty())
        return {};
    Collapser collapser(mesh, half_edges, scale, merged, options);
    collapser.run();
    return std::move(collapser).copy_back();
}

} // namespace recon
