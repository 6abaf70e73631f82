#include <filter_amls/thin.h>

#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace recon;

namespace
{

struct Cloud
{
    Points points;
    Vectors normals;
    std::vector<double> radii;
};

/// Two parallel walls closer to each other than the radius, facing away from each other.
Cloud thin_wall(int n)
{
    shapes::Random random(5);
    Cloud cloud;
    for (int i = 0; i < n; ++i)
    {
        const double side = i % 2 == 0 ? 1 : -1;
        const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
        cloud.points.emplace_back(uniform(), uniform(), 0.005 * side);
        cloud.normals.emplace_back(0, 0, side);
        cloud.radii.push_back(0.03);
    }
    return cloud;
}

} // namespace

TEST(ThinToPoissonDisks, ChosenPointsKeepTheirDistanceAndCoverTheRest)
{
    const Cloud cloud = thin_wall(6000);
    const std::vector<int> chosen = thin_to_poisson_disks(cloud.points, cloud.normals, cloud.radii, 1);
    ASSERT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
    int too_close = 0;
    std::vector<char> covered(cloud.points.size(), 0);
    for (const int i : chosen)
        for (std::size_t j = 0; j < cloud.points.size(); ++j)
            if (cloud.normals[i].dot(cloud.normals[j]) > 0 && (cloud.points[i] - cloud.points[j]).norm() <= 0.03)
            {
                covered[j] = 1;
                too_close += int(j) != i && std::binary_search(chosen.begin(), chosen.end(), int(j));
            }
    EXPECT_EQ(too_close, 0);
    EXPECT_EQ(std::count(covered.begin(), covered.end(), 0), 0);
    // Each wall has its own.
    EXPECT_GT(std::count_if(chosen.begin(), chosen.end(), [](int i) { return i % 2 == 0; }), 500);
    EXPECT_GT(std::count_if(chosen.begin(), chosen.end(), [](int i) { return i % 2 == 1; }), 500);
}

TEST(ThinToPoissonDisks, DoesNotDependOnThreads)
{
    const Cloud cloud = thin_wall(20000);
    EXPECT_EQ(thin_to_poisson_disks(cloud.points, cloud.normals, cloud.radii, 1),
              thin_to_poisson_disks(cloud.points, cloud.normals, cloud.radii, 3));
    EXPECT_TRUE(thin_to_poisson_disks({}, {}, {}, 2).empty());
}
