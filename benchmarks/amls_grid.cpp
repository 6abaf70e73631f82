// Grid B with defaults only: RMS and largest distance to the true mesh after projection, orientation, CPU time.
// amls_grid <model folder> [--seeds 11,12] [--models a,b] [--sigmas 0.1,0.2] [--threads 1] [--noise factor] [--outliers
// percent] [--save folder] [--peers folder] [--phases] [--delaunay] [--normals]: with --peers also how many points of
// the clouds that amls_peers.py --save wrote lie farther off than before by more than a spacing; with --delaunay the
// last column is the CPU time over that of CGAL's Delaunay triangulation; with --normals the normals filter in place of
// the projection
#include "bare_delaunay.h"
#include "mesh_distance.h"
#include "models.h"

#include "filter_amls/normals/outward_normals.h"
#include "filter_amls/surface/project.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>

using namespace recon;

namespace
{

struct Options
{
    std::string folder, save, peers;
    std::vector<std::string> names = benchmarks::grid_b, sigmas = {"0.1", "0.2", "0.4"}, seeds = {"11"};
    bool phases = false, with_delaunay = false, normals_only = false;
    double outliers = 0;     ///< Percent of the points.
    double noise_factor = 0; ///< Of the true sigma, given to the filter; 0 = the filter estimates.
    int threads = 1;
};

Options parse(int argc, char** argv)
{
    Options options;
    options.folder = argv[1];
    for (int i = 2; i < argc; ++i)
    {
        const std::string option = argv[i];
        if (option == "--phases")
            options.phases = true;
        else if (option == "--delaunay")
            options.with_delaunay = true;
        else if (option == "--normals")
            options.normals_only = true;
        else if (i + 1 < argc)
        {
            const std::string value = argv[++i];
            if (option == "--seeds")
                options.seeds = benchmarks::split_at_commas(value);
            else if (option == "--models")
                options.names = benchmarks::split_at_commas(value);
            else if (option == "--sigmas")
                options.sigmas = benchmarks::split_at_commas(value);
            else if (option == "--threads")
                options.threads = std::stoi(value);
            else if (option == "--noise")
                options.noise_factor = std::stod(value);
            else if (option == "--outliers")
                options.outliers = std::stod(value);
            else if (option == "--save")
                options.save = value;
            else if (option == "--peers")
                options.peers = value;
        }
    }
    return options;
}

/// A model with what is known of it.
struct Truth
{
    explicit Truth(const std::string& path)
        : model(benchmarks::load_model(path)), distance(model.mesh), normals(benchmarks::vertex_normals(model.mesh))
    {
    }
    benchmarks::Model model;
    benchmarks::MeshDistance distance;
    Vectors normals; ///< Per vertex.
};

/// One cloud of a model. The genuine points come first.
struct Cell
{
    const Truth& truth;
    std::string name, sigma, seed;
    Points points;
    std::size_t genuine;
};

Cell make_cell(const Truth& truth, const std::string& name, const std::string& sigma, const std::string& seed,
               double outliers)
{
    Points points = benchmarks::noisy_cloud(truth.model, std::stod(sigma), unsigned(std::stoi(seed)));
    for (Point& p : points) // as amls_clouds writes them for the peers
        p = p.cast<float>().cast<double>();
    const std::size_t genuine = points.size();
    if (outliers > 0)
        points = benchmarks::with_outliers(points, outliers / 100, unsigned(std::stoi(seed)));
    return {truth, name, sigma, seed, std::move(points), genuine};
}

/// Shares of the genuine points whose normal turns to the true side [0..1].
struct Oriented
{
    double of_origin = 0;  ///< By the normal of the vertex of which the point is a copy.
    double of_nearest = 0; ///< By that of the true surface where it is nearest to the point, wherever it came from.
};

/// Interpolated from the corners of the nearest triangle, not of unit length.
Vector normal_at(const Truth& truth, const benchmarks::MeshDistance::Nearest& nearest)
{
    const TriangleMesh& mesh = truth.model.mesh;
    const std::array<int, 3>& face = mesh.triangles[nearest.triangle];
    Vector normal = Vector::Zero();
    for (int k = 0; k < 3; ++k)
    {
        const Point &next = mesh.vertices[face[(k + 1) % 3]], &last = mesh.vertices[face[(k + 2) % 3]];
        // Twice the area opposite the corner: its barycentric coordinate, not yet divided by that of the triangle.
        normal += (next - nearest.point).cross(last - nearest.point).norm() * truth.normals[face[k]];
    }
    return normal;
}

Oriented measure_orientation(const Cell& cell, const Vectors& normals)
{
    const TriangleMesh& mesh = cell.truth.model.mesh;
    const std::size_t vertices = mesh.vertices.size();
    Oriented right;
    for (std::size_t i = 0; i < cell.genuine; ++i)
    {
        right.of_origin += cell.truth.normals[i < vertices ? i : (i - vertices) / 4].dot(normals[i]) > 0;
        right.of_nearest += normal_at(cell.truth, cell.truth.distance.nearest(cell.points[i])).dot(normals[i]) > 0;
    }
    right.of_origin /= double(cell.genuine);
    right.of_nearest /= double(cell.genuine);
    return right;
}

/// The row of the table.
void print_row(const Cell& cell, const AmlsSurfaceReport& report, const AmlsProjection& projection, double cpu,
               double delaunay)
{
    const benchmarks::Model& model = cell.truth.model;
    double squares = 0, largest = 0, before = 0, iterations = 0, neighbours = 0;
    int worse = 0, worse_by_vertices = 0;
    for (std::size_t i = 0; i < cell.genuine; ++i)
    {
        const double now = cell.truth.distance.nearest(projection.points[i]).distance;
        const double was = cell.truth.distance.nearest(cell.points[i]).distance;
        squares += now * now;
        before += was * was;
        largest = std::max(largest, now);
        worse += now > was + projection.spacings[i];
        // Copies of one vertex lie over the same patch: the spacing of the surface's samples.
        const double copies = double(cell.genuine) / double(model.mesh.vertices.size());
        worse_by_vertices += now > was + std::sqrt(copies) * projection.spacings[i];
        iterations += projection.iterations[i];
        neighbours += projection.neighbours[i];
    }
    const Oriented right = measure_orientation(cell, projection.normals);
    const double n = double(cell.genuine), d = model.diagonal;
    std::printf("%-22s %4s %4s %8zu %7.0f %8.2f %8.0f  %.5f  %.5f  %.4f  %.2f  %.3f  %5d %5d %5d  %.2f  %4.0f  "
                "%4d  %4d  %5.2f  %5.2f\n",
                cell.name.c_str(), cell.sigma.c_str(), cell.seed.c_str(), cell.points.size(),
                1e6 * std::sqrt(squares / n) / d, 1e3 * largest / d, 1e6 * std::sqrt(before / n) / d, right.of_origin,
                right.of_nearest, 100 * report.noise / d, report.rho_e, 100 * report.width / d,
                projection.count(ProjectionStatus::outlier), projection.count(ProjectionStatus::fell_back),
                projection.count(ProjectionStatus::not_converged), iterations / n, neighbours / n, worse,
                worse_by_vertices, cpu, delaunay > 0 ? cpu / delaunay : 0);
}

void print_outliers(const Cell& cell, const AmlsSurfaceReport& report, const AmlsProjection& projection)
{
    int found = 0, mistaken = 0, far = 0, far_found = 0;
    for (std::size_t i = 0; i < cell.points.size(); ++i)
    {
        const bool flagged = projection.status[i] == ProjectionStatus::outlier;
        found += i >= cell.genuine && flagged;
        mistaken += i < cell.genuine && flagged;
        // Within the surface's noise and width an outlier cannot be told.
        if (i >= cell.genuine && cell.truth.distance.nearest(cell.points[i]).distance > 2 * report.width)
        {
            ++far;
            far_found += flagged;
        }
    }
    std::printf("    outliers found %d of %zu, of those farther than 2 widths %d of %d; genuine points "
                "taken for outliers %d\n",
                found, cell.points.size() - cell.genuine, far_found, far, mistaken);
}

void print_phases(const AmlsSurfaceReport& report, double projected)
{
    for (const auto& phase : report.seconds)
        std::printf("    %s %.3f", phase.first.c_str(), phase.second);
    std::printf("    projection %.3f   cells %d anchors %d contradicted %.3f open %d\n", projected, report.cells,
                report.anchors, report.contradicted, int(report.open));
}

/// What amls_peers.py --save wrote for this cloud, by the spacings that the filter found.
void print_peers(const Cell& cell, const std::string& folder, const AmlsProjection& projection)
{
    for (const char* peer : {"apss_2", "apss_4", "apss_8", "rimls_2", "rimls_4", "rimls_8"})
    {
        const std::string path = folder + "/" + cell.name + "_" + cell.sigma + "_" + peer + ".ply";
        if (!std::filesystem::exists(path))
            continue;
        const Points moved = benchmarks::load_model(path).mesh.vertices;
        double sum = 0;
        int farther = 0;
        for (std::size_t i = 0; i < cell.genuine; ++i)
        {
            const double distance = cell.truth.distance.nearest(moved[i]).distance;
            sum += distance * distance;
            farther += distance > cell.truth.distance.nearest(cell.points[i]).distance + projection.spacings[i];
        }
        std::printf("    %s: RMS %.0f, worse %d\n", peer,
                    1e6 * std::sqrt(sum / double(cell.genuine)) / cell.truth.model.diagonal, farther);
    }
}

void run(const Cell& cell, const Options& options)
{
    const double delaunay = options.with_delaunay ? benchmarks::time_bare_delaunay(cell.points) : 0;
    const double begun = benchmarks::cpu_seconds();
    AmlsOptions surface_options;
    surface_options.threads = options.threads;
    if (options.noise_factor > 0)
        surface_options.noise = options.noise_factor * std::stod(cell.sigma) / 100 * cell.truth.model.diagonal;
    const AmlsSurface surface = build_amls_surface(cell.points, surface_options);
    const double built = benchmarks::cpu_seconds();
    AmlsProjectionOptions project_options;
    project_options.threads = options.threads;
    const AmlsProjection projection = project_to_amls(cell.points, surface, project_options);
    const double ended = benchmarks::cpu_seconds();

    print_row(cell, surface.report(), projection, ended - begun, delaunay);
    if (options.outliers > 0)
        print_outliers(cell, surface.report(), projection);
    if (options.phases)
        print_phases(surface.report(), ended - built);
    if (!options.peers.empty())
        print_peers(cell, options.peers, projection);
    std::fflush(stdout);
    if (!options.save.empty())
        benchmarks::save_ply(options.save + "/" + cell.name + "_" + cell.sigma + ".ply", projection.points,
                             projection.normals);
}

void run_normals(const Cell& cell, const Options& options)
{
    const double begun = benchmarks::cpu_seconds();
    AmlsOptions surface_options;
    surface_options.threads = options.threads;
    const OutwardNormals found = find_outward_normals(cell.points, surface_options);
    const double cpu = benchmarks::cpu_seconds() - begun;
    const Oriented right = measure_orientation(cell, found.normals);
    std::printf("%-22s %4s %4s %8zu  %.5f  %.5f  %5.2f\n", cell.name.c_str(), cell.sigma.c_str(), cell.seed.c_str(),
                cell.points.size(), right.of_origin, right.of_nearest, cpu);
    std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2)
    {
        std::fprintf(stderr,
                     "usage: %s <model folder> [--seeds s,...] [--models m,...] [--sigmas percent,...] "
                     "[--threads n] [--noise factor] [--outliers percent] [--save folder] [--peers folder] "
                     "[--phases] [--delaunay] [--normals]\n",
                     argv[0]);
        return 2;
    }
    const Options options = parse(argc, argv);
    if (options.normals_only)
        std::printf("model                 sigma%% seed  points  oriented  nearest   cpu\n");
    else
        std::printf(
            "model                 sigma%% seed  points  rms1e-6   max1e-3  input   oriented  nearest  noise%%  "
            "rho_e  width%%  outl  fell  noconv  iter  neigh  worse  (vertices)   cpu   x Delaunay\n");
    for (const std::string& name : options.names)
    {
        const Truth truth(options.folder + "/" + name + ".ply");
        for (const std::string& sigma : options.sigmas)
            for (const std::string& seed : options.seeds)
            {
                const Cell cell = make_cell(truth, name, sigma, seed, options.outliers);
                if (options.normals_only)
                    run_normals(cell, options);
                else
                    run(cell, options);
            }
    }
}
