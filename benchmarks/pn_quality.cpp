// Refinement of sparse samples against the mesh they were taken from, plain centroid insertion and CGAL's edge-aware
// upsampling. Usage: pn_quality <folder of models> [-n samples] [-l steps] [-s seeds] [-b first seed] [-c] [-o folder]
// [-m mode] [-f] [-e] [-a] [model...]. -f: samples with the normals of their faces, as of parts with edges; -e:
// creases are not detected; -a: no normals but those that the filter computes.
#include "mesh_distance.h"
#include "pn_models.h"

#include "filter_amls/normals/outward_normals.h"
#include "filter_pn_refine/sharpen_normals.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

using namespace benchmarks;

namespace
{

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

recon::Vector face_normal(const recon::TriangleMesh& mesh, int triangle)
{
    const auto& t = mesh.triangles[std::size_t(triangle)];
    const auto corner = [&](std::size_t k) -> const recon::Point& { return mesh.vertices[std::size_t(t[k])]; };
    return (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2)
        return std::fprintf(stderr,
                            "usage: %s <folder> [-n samples] [-l steps] [-s seeds] [-b first seed] [-c] [-o folder] "
                            "[-m mode] [-f] [-e] [-a] [model...]\n",
                            argv[0]),
               2;
    int samples = 3500, seeds = 5, first_seed = 1;
    bool with_cgal = false, with_face_normals = false, with_computed_normals = false;
    std::string output;
    recon::PnRefineOptions options;
    options.threads = 1;
    std::vector<std::string> models;
    for (int i = 2; i < argc; ++i)
    {
        const std::string word = argv[i];
        if (word == "-n")
            samples = std::atoi(argv[++i]);
        else if (word == "-l")
            options.steps = std::atoi(argv[++i]);
        else if (word == "-s")
            seeds = std::atoi(argv[++i]);
        else if (word == "-b")
            first_seed = std::atoi(argv[++i]);
        else if (word == "-c")
            with_cgal = true;
        else if (word == "-f")
            with_face_normals = true;
        else if (word == "-a")
            with_computed_normals = true;
        else if (word == "-e")
            options.detect_creases = false;
        else if (word == "-o")
            output = argv[++i];
        else if (word == "-m")
        {
            const int mode = std::atoi(argv[++i]);
            options.fast = mode == 3;
            options.neighbourhood = recon::PnNeighbourhood(mode % 3);
        }
        else
            models.push_back(word);
    }
    if (models.empty())
        models = {"igea", "rocker_arm", "bunny_closed", "horse", "elephant_refined", "maxplanck_closed_10k"};

    std::printf("%-20s %8s | %7s %7s %6s %5s %5s | %7s %6s | %7s\n", "model", "points", "RMS %", "max %", ">0.5%",
                "gap", "pair", "plain", "ratio", "CGAL %");
    for (const std::string& name : models)
    {
        const Model model = load_model(std::string(argv[1]) + "/" + name + ".ply");
        const MeshDistance distance(model.mesh);
        const recon::OrientedSamples surface = sample_mesh(model.mesh, 100000, 99);
        const double area = surface_area(model.mesh), percent = 100 / model.diagonal;
        std::vector<double> count, rms, largest, beyond, gap, pair, plain, cgal;
        for (int seed = first_seed; seed < first_seed + seeds; ++seed)
        {
            recon::OrientedSamples input = sample_mesh(model.mesh, samples, std::uint64_t(seed));
            if (with_face_normals)
                for (std::size_t i = 0; i < input.points.size(); ++i)
                    input.normals[i] = face_normal(model.mesh, distance.nearest(input.points[i]).triangle);
            if (with_computed_normals)
            {
                input.normals = recon::find_outward_normals(input.points).normals;
                if (options.detect_creases)
                    input.normals = recon::pn::sharpen_normals(input, options);
            }
            const recon::PnRefinement refined = recon::refine_points(input, options);
            const recon::OrientedSamples all = join(input, refined);
            const double spacing = std::sqrt(area / double(all.points.size()));
            const auto summary = distance.summarise(refined.points);
            count.push_back(double(all.points.size()));
            rms.push_back(summary.rms * percent);
            largest.push_back(summary.largest * percent);
            int far = 0;
            for (const recon::Point& p : refined.points)
                far += distance.nearest(p).distance * percent > 0.5;
            beyond.push_back(far);
            gap.push_back(largest_gap(surface, all, 1) / spacing);
            pair.push_back(closest_pair(input, refined.points) / spacing);
            plain.push_back(distance.summarise(recon::interpolate(refined, input.points)).rms * percent);
            if (with_cgal)
                cgal.push_back(
                    distance.summarise(upsample_edge_aware(input, int(all.points.size())).appended.points).rms *
                    percent);
            if (seed == first_seed && !output.empty())
                save_ply(output + "/" + name + ".ply", all.points, all.normals);
        }
        std::printf("%-20s %8.0f | %7.4f %7.3f %6.0f %5.2f %5.3f | %7.4f %6.3f |", name.c_str(), median(count),
                    median(rms), median(largest), median(beyond), median(gap), median(pair), median(plain),
                    median(rms) / median(plain));
        if (with_cgal)
            std::printf(" %7.4f", median(cgal));
        std::printf("\n");
        std::fflush(stdout);
    }
}
