// Grid B with defaults only: RMS and largest distance to the true mesh after projection, orientation, CPU time.
// amls_grid <model folder> [--seeds 11,12] [--models a,b] [--sigmas 0.1,0.2] [--threads 1] [--noise factor] [--outliers
// percent] [--save folder] [--peers folder] [--phases] [--delaunay]: with --peers also how many points of the clouds
// that amls_peers.py --save wrote lie farther off than before by more than a spacing; with --delaunay the last column
// is the CPU time over that of CGAL's Delaunay triangulation
#include "bare_delaunay.h"
#include "mesh_distance.h"
#include "models.h"

#include <filter_amls/project.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>

using namespace recon;

namespace
{

/// Means of the triangles' normals, weighted by angle.
Vectors vertex_normals(const TriangleMesh& mesh)
{
    Vectors normals(mesh.vertices.size(), Vector::Zero());
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
        {
            const Vector a = mesh.vertices[t[(k + 1) % 3]] - mesh.vertices[t[k]],
                         b = mesh.vertices[t[(k + 2) % 3]] - mesh.vertices[t[k]];
            const Vector cross = a.cross(b);
            if (cross.norm() > 0)
                normals[t[k]] += cross.normalized() * std::atan2(cross.norm(), a.dot(b));
        }
    return normals;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2)
    {
        std::fprintf(stderr,
                     "usage: %s <model folder> [--seeds s,...] [--models m,...] [--sigmas percent,...] "
                     "[--threads n] [--save folder] [--phases] [--delaunay]\n",
                     argv[0]);
        return 2;
    }
    const std::string folder = argv[1];
    std::vector<std::string> names = benchmarks::grid_b, sigmas = {"0.1", "0.2", "0.4"}, seeds = {"11"};
    std::string save, peers;
    bool phases = false, with_delaunay = false;
    double outliers = 0;     // percent of the points
    double noise_factor = 0; // of the true sigma, given to the filter; 0 = the filter estimates
    int threads = 1;
    for (int i = 2; i < argc; ++i)
    {
        const std::string option = argv[i];
        if (option == "--phases")
            phases = true;
        else if (option == "--delaunay")
            with_delaunay = true;
        else if (i + 1 < argc)
        {
            const std::string value = argv[++i];
            if (option == "--seeds")
                seeds = benchmarks::split_at_commas(value);
            else if (option == "--models")
                names = benchmarks::split_at_commas(value);
            else if (option == "--sigmas")
                sigmas = benchmarks::split_at_commas(value);
            else if (option == "--threads")
                threads = std::stoi(value);
            else if (option == "--noise")
                noise_factor = std::stod(value);
            else if (option == "--outliers")
                outliers = std::stod(value);
            else if (option == "--save")
                save = value;
            else if (option == "--peers")
                peers = value;
        }
    }

    std::printf(
        "model                 sigma%% seed  points  rms1e-6   max1e-3  input   oriented  noise%%  rho_e  width%%  "
        "outl  fell  noconv  iter  neigh  worse  (vertices)   cpu   x Delaunay\n");
    for (const std::string& name : names)
    {
        const benchmarks::Model model = benchmarks::load_model(folder + "/" + name + ".ply");
        const benchmarks::MeshDistance truth(model.mesh);
        const Vectors truth_normals = vertex_normals(model.mesh);
        for (const std::string& sigma : sigmas)
            for (const std::string& seed : seeds)
            {
                Points points = benchmarks::noisy_cloud(model, std::stod(sigma), unsigned(std::stoi(seed)));
                for (Point& p : points) // as amls_clouds writes them for the peers
                    p = p.cast<float>().cast<double>();
                const std::size_t genuine = points.size();
                if (outliers > 0)
                    points = benchmarks::with_outliers(points, outliers / 100, unsigned(std::stoi(seed)));
                const double delaunay = with_delaunay ? benchmarks::time_bare_delaunay(points) : 0;
                double cpu = benchmarks::cpu_seconds();
                AmlsOptions options;
                options.threads = threads;
                if (noise_factor > 0)
                    options.noise = noise_factor * std::stod(sigma) / 100 * model.diagonal;
                const AmlsSurface surface = build_amls_surface(points, options);
                const double built = benchmarks::cpu_seconds();
                AmlsProjectionOptions project_options;
                project_options.threads = threads;
                const AmlsProjection projection = project_to_amls(points, surface, project_options);
                const double projected = benchmarks::cpu_seconds() - built;
                cpu = benchmarks::cpu_seconds() - cpu;

                double squares = 0, largest = 0, before = 0, iterations = 0, neighbours = 0;
                int right = 0, worse = 0, worse_by_vertices = 0;
                for (std::size_t i = 0; i < genuine; ++i)
                {
                    const auto nearest = truth.nearest(projection.points[i]);
                    const double was = truth.nearest(points[i]).distance;
                    squares += nearest.distance * nearest.distance;
                    before += was * was;
                    largest = std::max(largest, nearest.distance);
                    // The normal of the vertex of which the point is a copy.
                    const std::size_t vertices = model.mesh.vertices.size();
                    right += truth_normals[i < vertices ? i : (i - vertices) / 4].dot(projection.normals[i]) > 0;
                    worse += nearest.distance > was + projection.spacings[i];
                    // Copies of one vertex lie over the same patch: the spacing of the surface's samples.
                    const double copies = double(genuine) / double(vertices);
                    worse_by_vertices += nearest.distance > was + std::sqrt(copies) * projection.spacings[i];
                    iterations += projection.iterations[i];
                    neighbours += projection.neighbours[i];
                }
                const double n = double(genuine), d = model.diagonal;
                const AmlsSurfaceReport& report = surface.report();
                std::printf("%-22s %4s %4s %8zu %7.0f %8.2f %8.0f  %.5f  %.4f  %.2f  %.3f  %5d %5d %5d  %.2f  %4.0f  "
                            "%4d  %4d  %5.2f  %5.2f\n",
                            name.c_str(), sigma.c_str(), seed.c_str(), points.size(), 1e6 * std::sqrt(squares / n) / d,
                            1e3 * largest / d, 1e6 * std::sqrt(before / n) / d, right / n, 100 * report.noise / d,
                            report.rho_e, 100 * report.width / d, projection.count(ProjectionStatus::outlier),
                            projection.count(ProjectionStatus::fell_back),
                            projection.count(ProjectionStatus::not_converged), iterations / n, neighbours / n, worse,
                            worse_by_vertices, cpu, with_delaunay ? cpu / delaunay : 0);
                if (outliers > 0)
                {
                    int found = 0, mistaken = 0, far = 0, far_found = 0;
                    for (std::size_t i = 0; i < points.size(); ++i)
                    {
                        const bool flagged = projection.status[i] == ProjectionStatus::outlier;
                        found += i >= genuine && flagged;
                        mistaken += i < genuine && flagged;
                        // Within the surface's noise and width an outlier cannot be told.
                        if (i >= genuine && truth.nearest(points[i]).distance > 2 * report.width)
                        {
                            ++far;
                            far_found += flagged;
                        }
                    }
                    std::printf("    outliers found %d of %zu, of those farther than 2 widths %d of %d; genuine points "
                                "taken for outliers %d\n",
                                found, points.size() - genuine, far_found, far, mistaken);
                }
                if (phases)
                {
                    for (const auto& phase : report.seconds)
                        std::printf("    %s %.3f", phase.first.c_str(), phase.second);
                    std::printf("    projection %.3f   cells %d anchors %d contradicted %.3f open %d\n", projected,
                                report.cells, report.anchors, report.contradicted, int(report.open));
                }
                for (const char* peer : {"apss_2", "apss_4", "apss_8", "rimls_2", "rimls_4", "rimls_8"})
                {
                    const std::string path = peers + "/" + name + "_" + sigma + "_" + peer + ".ply";
                    if (peers.empty() || !std::filesystem::exists(path))
                        continue;
                    const Points moved = benchmarks::load_model(path).mesh.vertices;
                    double sum = 0;
                    int farther = 0;
                    for (std::size_t i = 0; i < genuine; ++i)
                    {
                        const double distance = truth.nearest(moved[i]).distance;
                        sum += distance * distance;
                        farther += distance > truth.nearest(points[i]).distance + projection.spacings[i];
                    }
                    std::printf("    %s: RMS %.0f, worse %d\n", peer, 1e6 * std::sqrt(sum / n) / d, farther);
                }
                std::fflush(stdout);
                if (!save.empty())
                    benchmarks::save_ply(save + "/" + name + "_" + sigma + ".ply", projection.points,
                                         projection.normals);
            }
    }
}
