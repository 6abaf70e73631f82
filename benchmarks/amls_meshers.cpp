// What to mesh projected, thinned points with: the crust of filter 4, Cocone on CGAL's Delaunay triangulation (what the
// paper calls), and CGAL's surface mesher on the implicit function I. One line per mesher, model and noise.
// amls_meshers <folder of models> <seed> [model...] [--sigmas 0,0.1,...]
#include "mesh_distance.h"
#include "models.h"

#include "filter_amls/mesh/reconstruct_amls.h"
#include "filter_amls/surface/project.h"
#include "filter_amls/surface/sample_surface.h"
#include "filter_amls/surface/surface_data.h"

#include <recon/search/neighbours.h>

#include "tests/checks.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/facets_in_complex_2_to_triangle_mesh.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/make_surface_mesh.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <set>

using namespace benchmarks;
using recon::Point;
using recon::Points;
using recon::Vector;

namespace
{

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// I(x), continued by the planes of the nearest cells where no anchor is near. In the surface's unit frame.
double evaluate(const recon::AmlsSurface::Data& data, const Point& x)
{
    const int cell = data.cell_search.nearest(x);
    const double h = data.cells.scales[cell].width;
    const Vector side = data.cell_normals.normals[cell];
    constexpr double narrowing = 0.7, cut = 2.2; // as project.cpp has them
    thread_local std::vector<int> near;
    data.anchor_search.within(x, narrowing * cut * 1.25 * h, near);
    double weight = 0, sum = 0;
    for (const int a : near)
    {
        const recon::Anchor& anchor = data.anchors[a];
        const Vector u = x - anchor.position;
        const double e = u.squaredNorm() / (narrowing * narrowing * h * anchor.width);
        if (e > cut * cut || anchor.normal.dot(side) <= 0)
            continue;
        const auto& q = anchor.bending;
        const double bend = q[0] * u.x() * u.x() + q[1] * u.y() * u.y() + q[2] * u.z() * u.z() +
                            2 * (q[3] * u.x() * u.y() + q[4] * u.x() * u.z() + q[5] * u.y() * u.z());
        const double w = anchor.confidence * std::exp(-e);
        weight += w;
        sum += w * (u.dot(anchor.normal) - bend);
    }
    if (weight > 1e-6)
        return sum / weight;
    // One plane alone has a wrong side beyond ridges and tips.
    constexpr int planes = 24;
    int cells[planes];
    double squared[planes], reach = 0, height = 0;
    const int count = data.cell_search.nearest(x, planes, cells, squared, reach);
    for (int k = 0; k < count; ++k)
        height += data.cell_normals.normals[cells[k]].dot(x - data.cell_normals.feet[cells[k]]) / count;
    return height;
}

/// A point far inside: among points below samples, the one farthest from all cells.
Point find_inside(const recon::AmlsSurface::Data& data)
{
    Point best = Point::Zero();
    double farthest = 0;
    for (std::size_t a = 0; a < data.anchors.size(); a += 1 + data.anchors.size() / 200)
        for (double depth = 0.01; depth < 0.5; depth *= 1.25)
        {
            const Point p = data.anchors[a].position - depth * data.anchors[a].normal;
            const double distance = (data.cells.means[data.cell_search.nearest(p)] - p).norm();
            // Nothing nearer than where it came from: the ball touches the surface there.
            if (distance > farthest && distance > 0.95 * depth && evaluate(data, p) < 0)
            {
                farthest = distance;
                best = p;
            }
        }
    return best;
}

recon::TriangleMesh mesh_implicitly(const recon::AmlsSurface& surface, double spacing)
{
    using Mesher = CGAL::Surface_mesh_default_triangulation_3;
    using Traits = Mesher::Geom_traits;
    const recon::AmlsSurface::Data& data = surface.data();
    const auto function = [&](const Traits::Point_3& p) { return evaluate(data, Point(p.x(), p.y(), p.z())); };
    const Point inside = find_inside(data);
    using Surface = CGAL::Implicit_surface_3<Traits, decltype(function)>;
    const Traits::Sphere_3 sphere(Traits::Point_3(inside.x(), inside.y(), inside.z()), 4.0);
    const Surface zero(function, sphere, 1e-3 * spacing);
    Mesher triangulation;
    CGAL::Surface_mesh_complex_2_in_triangulation_3<Mesher> complex(triangulation);
    const CGAL::Surface_mesh_default_criteria_3<Mesher> criteria(20, 1.5 * spacing, 0.15 * spacing);
    CGAL::make_surface_mesh(complex, zero, criteria, CGAL::Manifold_with_boundary_tag(), 200);
    CGAL::Surface_mesh<Traits::Point_3> flat;
    CGAL::facets_in_complex_2_to_triangle_mesh(complex, flat);
    recon::TriangleMesh mesh;
    for (const auto v : flat.vertices())
        mesh.vertices.push_back(data.frame.from_unit(Point(flat.point(v).x(), flat.point(v).y(), flat.point(v).z())));
    for (const auto f : flat.faces())
    {
        std::array<int, 3> corners{};
        int k = 0;
        for (const auto v : flat.vertices_around_face(flat.halfedge(f)))
            corners[k++] = int(v.idx());
        mesh.triangles.push_back(corners);
    }
    return mesh;
}

/// Cocone (Amenta, Choi, Dey, Leekha 2002): triangles whose dual Voronoi edges meet the cocone (the complement of a
/// double cone around the normal) of all three corners; dangling ones are pruned, and a walk along the outside keeps
/// one sheet. Normals are given, where Cocone takes poles.
class Cocone
{
public:
    Cocone(const Points& points, const recon::Vectors& normals) : normals_(normals)
    {
        std::vector<std::pair<Kernel::Point_3, int>> with_index;
        for (std::size_t i = 0; i < points.size(); ++i)
            with_index.emplace_back(Kernel::Point_3(points[i].x(), points[i].y(), points[i].z()), int(i));
        delaunay_ = Delaunay(with_index.begin(), with_index.end());
        for (auto f = delaunay_.finite_facets_begin(); f != delaunay_.finite_facets_end(); ++f)
            if (is_candidate(*f))
                set(*f, true);
        prune();
    }

    recon::TriangleMesh walk_outside() const
    {
        recon::TriangleMesh mesh;
        std::set<Facet> visited;
        std::vector<Facet> stack;
        // From the outermost triangle, seen from where its normals point.
        double highest = -1e300;
        Facet first(nullptr, 0);
        for (const Facet& f : kept_)
            for (int k = 1; k < 4; ++k)
            {
                const auto v = f.first->vertex((f.second + k) & 3);
                const double height = v->point().z() + 1e-3 * f.first->vertex((f.second + 1) & 3)->point().z();
                if (height > highest && sees_outside(f))
                {
                    highest = height;
                    first = f;
                }
            }
        if (first.first == nullptr)
            return mesh;
        stack.push_back(first);
        visited.insert(first);
        while (!stack.empty())
        {
            const Facet f = stack.back();
            stack.pop_back();
            std::array<int, 3> corners{};
            for (int k = 0; k < 3; ++k) // outward
                corners[k] = f.first->vertex(CGAL::Triangulation_utils_3::vertex_triple_index(f.second, k))->info();
            mesh.triangles.push_back(corners);
            for (int k = 1; k < 4; ++k)
            {
                const Facet next = rotate(f, (f.second + k) & 3);
                if (next == delaunay_.mirror_facet(f))
                    continue; // the rim of a hole
                if (!sees_outside(next))
                    continue; // through a hole to the other side
                if (visited.insert(next).second)
                    stack.push_back(next);
            }
        }
        return mesh;
    }

private:
    using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<int, Kernel>;
    using Delaunay = CGAL::Delaunay_triangulation_3<
        Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>>;
    using Facet = Delaunay::Facet; ///< A triangle, seen from its cell.

    static constexpr double cone = 0.38268343236508977; // sin of 22.5 degrees

    bool is_candidate(const Facet& f) const
    {
        const Facet mirror = delaunay_.mirror_facet(f);
        const Facet finite = delaunay_.is_infinite(f.first) ? mirror : f;
        if (delaunay_.is_infinite(finite.first))
            return false;
        const Kernel::Point_3 a = delaunay_.dual(finite.first);
        const Facet other = finite == f ? mirror : f;
        Point begin(a.x(), a.y(), a.z()), end;
        if (delaunay_.is_infinite(other.first))
        {
            // The ray leaves through the facet, away from the fourth corner.
            const auto at = [&](int k) { return to_point(finite.first->vertex(k)->point()); };
            const Point p = at((finite.second + 1) & 3), q = at((finite.second + 2) & 3),
                        r = at((finite.second + 3) & 3);
            Vector out = (q - p).cross(r - p).normalized();
            if (out.dot(at(finite.second) - p) > 0)
                out = -out;
            end = begin + 100 * out;
        }
        else
        {
            const Kernel::Point_3 b = delaunay_.dual(other.first);
            end = Point(b.x(), b.y(), b.z());
        }
        for (int k = 1; k < 4; ++k)
        {
            const auto v = f.first->vertex((f.second + k) & 3);
            const Point p = to_point(v->point());
            const Vector& n = normals_[std::size_t(v->info())];
            const double s = (begin - p).normalized().dot(n), t = (end - p).normalized().dot(n);
            if (std::min(s, t) > cone || std::max(s, t) < -cone)
                return false;
        }
        return true;
    }

    static Point to_point(const Kernel::Point_3& p) { return Point(p.x(), p.y(), p.z()); }

    void set(const Facet& f, bool keep)
    {
        const Facet mirror = delaunay_.mirror_facet(f);
        for (const Facet& side : {f, mirror})
            keep ? void(kept_.insert(side)) : void(kept_.erase(side));
    }
    bool is_kept(const Facet& f) const { return kept_.count(f) > 0; }

    /// The cell of the facet lies where the corners' normals point.
    bool sees_outside(const Facet& f) const
    {
        Vector mean = Vector::Zero();
        for (int k = 1; k < 4; ++k)
            mean += normals_[std::size_t(f.first->vertex((f.second + k) & 3)->info())];
        const auto at = [&](const Facet& g, int k) { return to_point(g.first->vertex((g.second + k) & 3)->point()); };
        const Facet mirror = delaunay_.mirror_facet(f);
        const bool here = !delaunay_.is_infinite(f.first);
        const Facet& known = here ? f : mirror;
        Vector towards = (at(known, 2) - at(known, 1)).cross(at(known, 3) - at(known, 1));
        if (towards.dot(at(known, 0) - at(known, 1)) < 0)
            towards = -towards;
        const double side = mean.dot(towards);
        return here ? side > 0 : side < 0;
    }

    /// The next kept triangle around the edge opposite to corner `k` of a facet, on the side of its cell, seen from
    /// there.
    Facet rotate(const Facet& f, int k) const
    {
        auto cell = f.first;
        int leave = k, enter = f.second;
        while (!is_kept({cell, leave}))
        {
            // The edge has the two vertices of the cell that are neither `leave` nor `enter`.
            const auto next = cell->neighbor(leave);
            const auto stays = cell->vertex(enter);
            enter = next->index(cell);
            leave = next->index(stays);
            cell = next;
        }
        return {cell, leave};
    }

    /// Removes triangles with two free edges, until none is left. The paper removes all triangles at sharp edges, but
    /// one hole then unravels the whole surface.
    void prune()
    {
        std::vector<Facet> asked(kept_.begin(), kept_.end());
        while (!asked.empty())
        {
            std::vector<Facet> again;
            for (const Facet& f : asked)
            {
                if (!is_kept(f))
                    continue;
                int free_edges = 0;
                std::vector<Facet> around;
                for (int k = 1; k < 4; ++k)
                {
                    const Facet next = rotate(f, (f.second + k) & 3);
                    free_edges += next == delaunay_.mirror_facet(f);
                    around.push_back(next);
                }
                if (free_edges < 2)
                    continue;
                set(f, false);
                for (const Facet& g : around)
                    if (is_kept(g))
                        again.push_back(g);
            }
            asked.swap(again);
        }
    }

    const recon::Vectors& normals_;
    Delaunay delaunay_;
    std::set<Facet> kept_;
};

/// Leaves out vertices without triangles.
recon::TriangleMesh compact(const recon::TriangleMesh& mesh)
{
    recon::TriangleMesh result;
    std::map<int, int> renamed;
    for (auto triangle : mesh.triangles)
    {
        for (int& v : triangle)
        {
            const auto [entry, is_new] = renamed.emplace(v, int(renamed.size()));
            if (is_new)
                result.vertices.push_back(mesh.vertices[std::size_t(v)]);
            v = entry->second;
        }
        result.triangles.push_back(triangle);
    }
    return result;
}

void print_row(const char* mesher, const std::string& name, const std::string& sigma, const recon::TriangleMesh& mesh,
               const Model& model, const MeshDistance& truth, double seconds)
{
    const checks::MeshReport report = checks::examine_mesh(mesh);
    const double volume = report.volume / model.volume;
    const bool manifold = report.is_closed_oriented_manifold();
    const bool right =
        manifold && report.components == 1 && report.genus() == model.genus && std::abs(volume - 1) < 0.02;
    Points centroids;
    for (const auto& t : mesh.triangles)
        centroids.push_back((mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3);
    std::printf("| %s | %s | %s | %s | %s | %d | %d / %d | %.3f | %zu | %.0f | %.0f | %.2f |\n", name.c_str(),
                sigma.c_str(), mesher, right ? "yes" : "no", manifold ? "yes" : "no", report.components, report.genus(),
                model.genus, volume, mesh.vertices.size(), 1e6 * truth.summarise(mesh.vertices).rms / model.diagonal,
                1e6 * truth.summarise(centroids).rms / model.diagonal, seconds);
    std::fflush(stdout);
}

double median_spacing(const Points& points)
{
    const recon::NeighbourSearch search(points);
    std::vector<double> distances;
    for (const Point& p : points)
    {
        int near[2];
        double squared[2];
        search.nearest(p, 2, near, squared);
        distances.push_back(std::sqrt(squared[1]));
    }
    std::nth_element(distances.begin(), distances.begin() + std::ptrdiff_t(distances.size() / 2), distances.end());
    return distances[distances.size() / 2];
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3)
    {
        std::fprintf(stderr, "usage: %s <folder of models> <seed> [model...] [--sigmas 0,0.1,...]\n", argv[0]);
        return 2;
    }
    const std::string folder = argv[1];
    const unsigned seed = unsigned(std::atoi(argv[2]));
    std::vector<std::string> models, sigmas = {"0.1", "0.2", "0.4"};
    for (int i = 3; i < argc; ++i)
    {
        const std::string word = argv[i];
        if (word == "--sigmas" && i + 1 < argc)
            sigmas = split_at_commas(argv[++i]);
        else
            models.push_back(word);
    }
    if (models.empty())
        models = {"rocker_arm", "fertility", "bunny_closed", "horse"};
    std::printf(
        "| model | sigma %% | mesher | right | closed manifold | components | genus | volume | vertices | RMS of "
        "vertices | of centroids | CPU s |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const std::string& name : models)
    {
        const Model model = load_model(folder + "/" + name + ".ply");
        const MeshDistance truth(model.mesh);
        for (const std::string& sigma : sigmas)
        {
            const Points cloud = noisy_cloud(model, std::atof(sigma.c_str()), seed);
            recon::AmlsReconstructionOptions options;
            recon::AmlsOptions surface_options;
            options.threads = surface_options.threads = 1;
            double begin = cpu_seconds();
            const recon::AmlsSurface surface = recon::build_amls_surface(cloud, surface_options);
            const recon::SurfaceSamples sampled = recon::sample_amls_surface(cloud, surface, 1);
            const double shared = cpu_seconds() - begin; // what all three begin with
            const auto run = [&](const char* mesher, double before, auto&& make)
            {
                try
                {
                    const double start = cpu_seconds();
                    const recon::TriangleMesh mesh = make();
                    print_row(mesher, name, sigma, mesh, model, truth, cpu_seconds() - start - before);
                }
                catch (const std::exception& e)
                {
                    std::printf("| %s | %s | %s | failed: %s |\n", name.c_str(), sigma.c_str(), mesher, e.what());
                }
            };
            run("crust", shared, [&] { return recon::reconstruct_amls(cloud, options).mesh; });
            run("Cocone", 0,
                [&]
                {
                    recon::TriangleMesh mesh = Cocone(sampled.samples.points, sampled.samples.normals).walk_outside();
                    mesh.vertices = sampled.samples.points;
                    return compact(mesh);
                });
            const double spacing = median_spacing(sampled.samples.points) / surface.data().frame.scale();
            run("surface mesher", 0, [&] { return mesh_implicitly(surface, spacing); });
        }
    }
}
