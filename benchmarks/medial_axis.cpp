// How far the medial axes of a torus, a capsule and two boxes lie from the true ones: medial_axis <seed>
// One Markdown row per shape and kind of cloud, a column per noise [spacings]: how far it strays from the true axis /
// the farthest place of that it does not reach [spacings].
#include "filter_noisy_powercrust/medial_axis.h"
#include "tests/medial_shapes.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iterator>

using namespace shapes;

int main(int argc, char** argv)
{
    if (argc < 2)
    {
        std::fprintf(stderr, "usage: %s <seed>\n", argv[0]);
        return 2;
    }
    const std::uint64_t seed = std::strtoull(argv[1], nullptr, 10);
    constexpr double noises[] = {0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.8};
    std::printf("| shape | a spot |");
    for (const double noise : noises)
        std::printf(" %g |", noise);
    std::printf("\n|---|---|");
    for (std::size_t i = 0; i < std::size(noises); ++i)
        std::printf("---|");
    for (const MedialShape& shape :
         {medial_torus(6000, seed), medial_capsule(5000, seed), medial_box(20000, seed), medial_box(5000, seed)})
        for (const bool with_copies : {false, true})
        {
            std::printf("\n| %s, %zu | %d |", shape.name.c_str(), shape.points.size(), with_copies ? 5 : 1);
            for (const double noise : noises)
            {
                const recon::PowerShape found = recon::compute_power_shape(shape.noisy(noise, with_copies, seed + 5));
                const MedialError error = measure_medial_error(shape, found.centres, found.edges, found.triangles);
                std::printf(" %.2f / %.2f |", error.strays, error.unreached);
                std::fflush(stdout);
            }
        }
    std::printf("\n");
}
