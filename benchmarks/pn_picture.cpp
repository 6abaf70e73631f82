// Clouds of the picture in filter_pn_refine/README.md, before and after: eight files of points and normals in double.
// Usage: pn_picture <folder of models> <folder for the files>; then pn_picture.py <folder of the files> <picture>.
#include "pn_models.h"

#include "tests/shapes.h"

#include <cstdio>
#include <fstream>

using namespace benchmarks;
using namespace recon;

namespace
{

void save(const std::string& file, const OrientedSamples& cloud)
{
    std::ofstream out(file, std::ios::binary);
    for (std::size_t i = 0; i < cloud.points.size(); ++i)
        for (const Vector* v : {&cloud.points[i], &cloud.normals[i]})
            out.write(reinterpret_cast<const char*>(v->data()), 3 * sizeof(double));
}

/// A grid on each face, so that the points on edges and corners have several normals.
OrientedSamples cube(int side)
{
    OrientedSamples samples;
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0})
            for (int i = 0; i < side * side; ++i)
            {
                Vector p, normal = Vector::Zero();
                p[axis] = normal[axis] = sign;
                p[(axis + 1) % 3] = -1 + 2.0 * (i / side) / (side - 1);
                p[(axis + 2) % 3] = -1 + 2.0 * (i % side) / (side - 1);
                samples.points.push_back(p);
                samples.normals.push_back(normal);
            }
    return samples;
}

OrientedSamples sphere_with_hole(double radius)
{
    const Point middle = Point(0.6, -0.6, 0.53).normalized();
    const OrientedSamples sphere = shapes::sphere(3500, 1, 2);
    OrientedSamples samples;
    for (const Point& p : sphere.points)
        if ((p - middle).norm() >= radius)
        {
            samples.points.push_back(p);
            samples.normals.push_back(p);
        }
    return samples;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3)
        return std::fprintf(stderr, "usage: %s <folder of models> <folder for the files>\n", argv[0]), 2;
    const std::string models = argv[1], folder = argv[2];
    const auto refine = [&](const std::string& name, const OrientedSamples& samples, int steps, double hole_radius)
    {
        PnRefineOptions options;
        options.steps = steps;
        options.hole_radius = hole_radius;
        const PnRefinement refined = refine_points(samples, options);
        save(folder + "/" + name + ".before", samples);
        save(folder + "/" + name + ".after", join(samples, refined));
        std::printf("%s: %zu points, radii at most %.4g\n", name.c_str(), samples.points.size() + refined.points.size(),
                    refined.steps.back().largest_radius);
    };
    for (const auto& [name, samples, steps] :
         {std::tuple("igea", 600, 6), std::tuple("rocker_arm", 3500, 4), std::tuple("bunny_closed", 3500, 4)})
        refine(name, sample_mesh(load_model(models + "/" + name + ".ply").mesh, samples, 1), steps, 0);
    refine("cube", cube(8), 5, 0);
    refine("sphere", sphere_with_hole(0.42), 4, 0.44);
}
