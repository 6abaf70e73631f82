#include <recon/mesh/flip_edges.h>

#include <recon/parallel.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <optional>

namespace recon
{
namespace
{

class Flipper
{
public:
    Flipper(HalfEdgeMesh& mesh, const EdgeFlipOptions& options)
        : mesh_(mesh), options_(options), faces_(std::size_t(mesh.triangles())), flips_of_(faces_.size(), 0),
          is_waiting_(4 * faces_.size(), 0)
    {
        parallel_for(faces_.size(), options.threads, {},
                     [&](std::size_t t) { faces_[t] = face(mesh.area_vector(int(t))); });
    }

    int run(const std::vector<char>* changed)
    {
        std::vector<char> is_promising(4 * faces_.size(), 0);
        parallel_for(faces_.size(), options_.threads, {},
                     [&](std::size_t t)
                     {
                         for (int h = 4 * int(t); h < 4 * int(t) + 3; ++h)
                             is_promising[h] = h < mesh_.twin(h) && (!changed || is_near(h, *changed)) && find_flip(h);
                     });
        std::vector<int> wave;
        for (int h = 0; h < int(is_promising.size()); ++h)
            if (is_promising[h])
                wave.push_back(h);
        // One flip can spoil the next, so they are made one after the other; most of the time goes in finding that
        // there is none, which threads do side by side between the waves.
        while (!wave.empty())
        {
            for (const int h : wave)
                visit(h);
            wave.clear();
            is_promising.assign(waiting_.size(), 0);
            parallel_for(waiting_.size(), options_.threads, {},
                         [&](std::size_t i) { is_promising[i] = find_flip(waiting_[i]).has_value(); });
            for (std::size_t i = 0; i < waiting_.size(); ++i)
            {
                is_waiting_[waiting_[i]] = 0;
                if (is_promising[i])
                    wave.push_back(waiting_[i]);
            }
            waiting_.clear();
        }
        return flips_;
    }

private:
    /// Of a triangle.
    struct Face
    {
        Vector normal; ///< 0 where the area is.
        double area;   ///< Twice.
    };

    static Face face(const Vector& area_vector)
    {
        const double area = area_vector.norm();
        return {area > 0 ? Vector(area_vector / area) : Vector(Vector::Zero()), area};
    }
    Face face(int a, int b, int c) const
    {
        const Point& p = mesh_.position(a);
        return face((mesh_.position(b) - p).cross(mesh_.position(c) - p));
    }
    double distance(int a, int b) const { return (mesh_.position(a) - mesh_.position(b)).norm(); }

    /// An edge, the two triangles beside it and the four around these.
    struct Surroundings
    {
        int a, b, c, d; ///< Ends of the edge, corners left and right of it.
        const Face *left, *right;
        const Vector *bc, *ca, *ad, *db; ///< Normals beyond the sides.
        double length, bc_length, ca_length, ad_length, db_length;
        double bending, least_gain;
        bool is_delaunay;
    };

    Surroundings look_at(int h) const
    {
        const int g = mesh_.twin(h);
        Surroundings e;
        e.a = mesh_.origin(h);
        e.b = mesh_.target(h);
        e.c = mesh_.opposite(h);
        e.d = mesh_.opposite(g);
        e.left = &faces_[h >> 2];
        e.right = &faces_[g >> 2];
        const auto beyond = [&](int side) { return &faces_[mesh_.twin(side) >> 2].normal; };
        e.bc = beyond(next_half_edge(h));
        e.ca = beyond(previous_half_edge(h));
        e.ad = beyond(next_half_edge(g));
        e.db = beyond(previous_half_edge(g));
        e.length = distance(e.a, e.b);
        e.bc_length = distance(e.b, e.c);
        e.ca_length = distance(e.c, e.a);
        e.ad_length = distance(e.a, e.d);
        e.db_length = distance(e.d, e.b);
        e.bending = e.length * (e.left->normal - e.right->normal).norm() +
                    e.bc_length * (e.left->normal - *e.bc).norm() + e.ca_length * (e.left->normal - *e.ca).norm() +
                    e.ad_length * (e.right->normal - *e.ad).norm() + e.db_length * (e.right->normal - *e.db).norm();
        e.least_gain = options_.gain * (2 * e.length + e.bc_length + e.ca_length + e.ad_length + e.db_length);
        e.is_delaunay = sees_delaunay(e.a, e.b, e.c, e.d, e.left->area, e.right->area);
        return e;
    }

    /// The triangles beside an edge after its flip.
    struct Flip
    {
        Face at_a, at_b;
    };

    /// Nothing if the edge had better stay.
    std::optional<Flip> find_flip(int h) const
    {
        const Surroundings e = look_at(h);
        if (e.is_delaunay && e.bending <= e.least_gain)
            return {};
        const Flip flip{face(e.c, e.a, e.d), face(e.d, e.b, e.c)};
        const Vector mean = e.left->area * e.left->normal + e.right->area * e.right->normal;
        const double least = 0.2 * mean.norm();
        const Vector &at_a = flip.at_a.normal, &at_b = flip.at_b.normal;
        if (!(at_a.dot(mean) > least) || !(at_b.dot(mean) > least))
            return {};
        const double after = distance(e.c, e.d) * (at_a - at_b).norm() + e.bc_length * (at_b - *e.bc).norm() +
                             e.ca_length * (at_a - *e.ca).norm() + e.ad_length * (at_a - *e.ad).norm() +
                             e.db_length * (at_b - *e.db).norm();
        const double gain = e.bending - after;
        if (gain <= e.least_gain && (e.is_delaunay || gain < -e.least_gain))
            return {};
        return flip;
    }

    /// Whether an end of the edge, or a corner beside it, is marked.
    bool is_near(int h, const std::vector<char>& is_marked) const
    {
        return is_marked[mesh_.origin(h)] || is_marked[mesh_.target(h)] || is_marked[mesh_.opposite(h)] ||
               is_marked[mesh_.opposite(mesh_.twin(h))];
    }

    void visit(int h)
    {
        const int t = h >> 2, u = mesh_.twin(h) >> 2;
        if (flips_of_[t] >= options_.most_flips || flips_of_[u] >= options_.most_flips)
            return;
        const std::optional<Flip> flip = find_flip(h);
        if (!flip || !mesh_.can_flip(h))
            return;
        mesh_.flip(h);
        ++flips_;
        faces_[t] = flip->at_a;
        faces_[u] = flip->at_b;
        ++flips_of_[t];
        ++flips_of_[u];
        for (const int changed : {t, u})
            for (int side = 4 * changed; side < 4 * changed + 3; ++side)
            {
                wait(side);
                const int beyond = mesh_.twin(side);
                wait(next_half_edge(beyond));
                wait(previous_half_edge(beyond));
            }
    }

    void wait(int h)
    {
        h = std::min(h, mesh_.twin(h));
        if (is_waiting_[h])
            return;
        is_waiting_[h] = 1;
        waiting_.push_back(h);
    }

    /// Whether the angles at c and d, opposite of the edge from a to b, sum up to two right angles at most.
    bool sees_delaunay(int a, int b, int c, int d, double left_area, double right_area) const
    {
        const Point &p = mesh_.position(a), &q = mesh_.position(b);
        const double cosine_c = (p - mesh_.position(c)).dot(q - mesh_.position(c));
        const double cosine_d = (p - mesh_.position(d)).dot(q - mesh_.position(d));
        const double slack = 1e-3 * (left_area + std::abs(cosine_c)) * (right_area + std::abs(cosine_d));
        return left_area * cosine_d + cosine_c * right_area >= -slack;
    }

    HalfEdgeMesh& mesh_;
    const EdgeFlipOptions& options_;
    std::vector<Face> faces_;
    std::vector<unsigned char> flips_of_;
    std::vector<char> is_waiting_; ///< By half-edge.
    std::vector<int> waiting_;     ///< Half-edges around flips, the lower of two twins.
    int flips_ = 0;
};

} // namespace

int flip_edges(HalfEdgeMesh& mesh, const EdgeFlipOptions& options, const std::vector<char>* changed)
{
    return Flipper(mesh, options).run(changed);
}

} // namespace recon
