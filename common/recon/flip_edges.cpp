#include <recon/flip_edges.h>

#include <recon/parallel.h>

#include <Eigen/Geometry>

#include <cmath>
#include <vector>

namespace recon
{
namespace
{

class Flipper
{
public:
    Flipper(HalfEdgeMesh& mesh, const EdgeFlipOptions& options)
        : mesh_(mesh), options_(options), faces_(std::size_t(mesh.triangles())), flips_of_(faces_.size(), 0)
    {
        parallel_for(faces_.size(), options.threads, {},
                     [&](std::size_t t) { faces_[t] = face(mesh.area_vector(int(t))); });
    }

    int run()
    {
        std::vector<char> promising(4 * faces_.size(), 0); // by half-edge
        parallel_for(faces_.size(), options_.threads, {},
                     [&](std::size_t t)
                     {
                         for (int h = 4 * int(t); h < 4 * int(t) + 3; ++h)
                             promising[h] = h < mesh_.twin(h) && !is_settled(look_at(h));
                     });
        for (int h = 0; h < int(promising.size()); ++h)
            if (promising[h])
                waiting_.push_back(h);
        // By index: a flip appends the edges around it.
        for (std::size_t i = 0; i < waiting_.size(); ++i)
            visit(waiting_[i]);
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
    static bool is_settled(const Surroundings& e) { return e.is_delaunay && e.bending <= e.least_gain; }

    void visit(int h)
    {
        const int t = h >> 2, u = mesh_.twin(h) >> 2;
        if (flips_of_[t] >= options_.most_flips || flips_of_[u] >= options_.most_flips)
            return;
        const Surroundings e = look_at(h);
        if (is_settled(e))
            return;
        const Face at_a = face(e.c, e.a, e.d), at_b = face(e.d, e.b, e.c);
        const Vector mean = e.left->area * e.left->normal + e.right->area * e.right->normal;
        const double least = 0.2 * mean.norm();
        if (!(at_a.normal.dot(mean) > least) || !(at_b.normal.dot(mean) > least))
            return;
        const double after = distance(e.c, e.d) * (at_a.normal - at_b.normal).norm() +
                             e.bc_length * (at_b.normal - *e.bc).norm() + e.ca_length * (at_a.normal - *e.ca).norm() +
                             e.ad_length * (at_a.normal - *e.ad).norm() + e.db_length * (at_b.normal - *e.db).norm();
        const double gain = e.bending - after;
        if (gain <= e.least_gain && (e.is_delaunay || gain < -e.least_gain))
            return;
        if (!mesh_.can_flip(h))
            return;
        mesh_.flip(h);
        ++flips_;
        faces_[t] = at_a;
        faces_[u] = at_b;
        ++flips_of_[t];
        ++flips_of_[u];
        for (int k = 0; k < 3; ++k)
        {
            waiting_.push_back(4 * t + k);
            waiting_.push_back(4 * u + k);
        }
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
    std::vector<int> waiting_;
    int flips_ = 0;
};

} // namespace

int flip_edges(HalfEdgeMesh& mesh, const EdgeFlipOptions& options)
{
    return Flipper(mesh, options).run();
}

} // namespace recon
