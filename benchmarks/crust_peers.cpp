// One step of crust_peers.py, which runs each in a process of its own:
//   crust_peers clouds <models> <seed> <folder> <sigma,...> <model>...   <model>_<sigma>.ply with the true normals
//   crust_peers crust <cloud.ply> <mesh.ply> [raw]    defaults; raw: no denoising, smoothing, simplification
//   crust_peers normals <cloud.ply> <out.ply>         CGAL's pca30 + spanning tree in place of the normals
//   crust_peers judge <model.ply> <mesh.ply>          what the mesh is and how far from the model
// Each prints "name value" lines; seconds are CPU seconds of the step alone, without reading and writing.
#include "bare_delaunay.h"
#include "mesh_distance.h"
#include "models.h"
#include "oriented_normals.h"

#include "filter_noisy_powercrust/reconstruct.h"
#include "tests/checks.h"

#include <Eigen/Geometry>

#include <sys/resource.h>

#include <cstdio>
#include <exception>
#include <string>

using namespace benchmarks;

namespace
{

/// Area-weighted vertex normals of the model, copied to each vertex's noisy copies in the order noisy_cloud() makes
/// them.
recon::Vectors true_normals(const Model& model, std::size_t cloud_size)
{
    const std::size_t n = model.mesh.vertices.size();
    recon::Vectors normals(n, recon::Vector::Zero());
    for (const auto& t : model.mesh.triangles)
    {
        const auto& v = model.mesh.vertices;
        const recon::Vector area = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]);
        for (const int i : t)
            normals[i] += area;
    }
    for (recon::Vector& normal : normals)
        normal.normalize();
    const std::size_t copies = cloud_size / n - 1;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t c = 0; c < copies; ++c)
            normals.push_back(normals[i]);
    return normals;
}

void judge(const std::string& model_path, const std::string& mesh_path)
{
    const Model model = load_model(model_path);
    const recon::TriangleMesh mesh = load_model(mesh_path).mesh;
    const checks::MeshReport report = checks::examine_mesh(mesh);
    const double volume = report.volume / model.volume;
    std::printf("closed_manifold %d\ncomponents %d\ngenus %d\ntrue_genus %d\nvolume %.4f\n",
                report.is_closed_oriented_manifold(), report.components, report.genus(), model.genus, volume);
    std::printf("right %d\n", is_right(report, model.genus, volume));
    std::printf("rms %.1f\ntriangles %zu\n",
                1e6 * MeshDistance(model.mesh).summarise(mesh.vertices).rms / model.diagonal, mesh.triangles.size());
}

} // namespace

int main(int argc, char** argv)
try
{
    const std::string step = argc > 3 ? argv[1] : "";
    if (step == "clouds" && argc > 6)
    {
        for (const std::string& sigma : split_at_commas(argv[5]))
            for (int i = 6; i < argc; ++i)
            {
                const Model model = load_model(argv[2] + std::string("/") + argv[i] + ".ply");
                const recon::Points cloud = noisy_cloud(model, std::stod(sigma), unsigned(std::stoi(argv[3])));
                save_ply(argv[4] + std::string("/") + argv[i] + "_" + sigma + ".ply", cloud,
                         true_normals(model, cloud.size()));
            }
        return 0;
    }
    if (step == "judge")
    {
        judge(argv[2], argv[3]);
        return 0;
    }
    if (step != "crust" && step != "normals")
    {
        std::fprintf(stderr, "usage: see the head of crust_peers.cpp\n");
        return 2;
    }
    const Model cloud = load_model(argv[2]);
    const recon::Points& points = cloud.mesh.vertices;
    if (step == "normals")
    {
        const double begin = cpu_seconds();
        const recon::Vectors normals = pca30_spanning_tree_normals(points);
        std::printf("seconds %.3f\n", cpu_seconds() - begin);
        save_ply(argv[3], points, normals);
        return 0;
    }
    recon::NoisyPowerCrustOptions options;
    options.threads = 1;
    if (argc > 4)
    {
        options.denoise = recon::Denoise::off;
        options.smooth = options.simplify = false;
    }
    std::printf("delaunay %.3f\n", time_bare_delaunay(points));
    const double begin = cpu_seconds();
    const recon::NoisyPowerCrust crust = recon::reconstruct_noisy_power_crust(points, options);
    std::printf("seconds %.3f\nviolated %.4f\npoints %zu\n", cpu_seconds() - begin, crust.violated_votes,
                points.size());
    rusage use;
    getrusage(RUSAGE_SELF, &use);
    std::printf("peak_bytes_per_point %.0f\n", 1024.0 * double(use.ru_maxrss) / double(points.size()));
    save_ply(argv[3], crust.mesh);
    return 0;
}
catch (const std::exception& e)
{
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
}
