#include "filter_amls/cells/thin.h"

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
    std::vector<double> radii, expected;
};

/// Two parallel walls closer to each other than the radius, facing away from each other.
Cloud thin_wall(int n)
{
    shapes::Random random(5);
    Cloud cloud;
    for (int i = 0; i < n; ++i)
    {
        const double side = i % 2 == 0 ? 1 : -1;
        const auto uniform = [&] { return shapes::uniform(random); };
        const Eigen::Vector2d place = shapes::draw_pair(uniform);
        cloud.points.emplace_back(place.x(), place.y(), 0.005 * side);
        cloud.normals.emplace_back(0, 0, side);
        cloud.radii.push_back(0.03);
        cloud.expected.push_back(M_PI * 0.03 * 0.03 * n / 2);
    }
    return cloud;
}

} // namespace

TEST(ThinToPoissonDisks, ChosenPointsKeepTheirDistanceAndCoverTheRest)
{
    const Cloud cloud = thin_wall(6000);
    const std::vector<int> chosen = thin_to_poisson_disks(cloud.points, cloud.normals, cloud.radii, cloud.expected, 1);
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

TEST(ThinToPoissonDisks, LeavesStraysOutButNotSparsePieces)
{
    // Of the walls' half y > 0.5 one point in ten; beyond the edge x = 1 a few strays.
    Cloud cloud;
    const Cloud all = thin_wall(20000);
    for (std::size_t i = 0; i < all.points.size(); ++i)
        if (all.points[i].y() < 0.5 || i / 2 % 10 == 0)
        {
            cloud.points.push_back(all.points[i]);
            cloud.normals.push_back(all.normals[i]);
        }
    const std::size_t genuine = cloud.points.size();
    for (int k = 0; k < 8; ++k)
    {
        cloud.points.emplace_back(1.06, 0.05 * k + 0.05, 0.005);
        cloud.normals.push_back(Vector::UnitZ());
    }
    cloud.radii.assign(cloud.points.size(), 0.03);
    cloud.expected.assign(cloud.points.size(), all.expected[0]);
    const std::vector<int> chosen = thin_to_poisson_disks(cloud.points, cloud.normals, cloud.radii, cloud.expected, 1);
    EXPECT_LT(chosen.back(), int(genuine));
    int far = 0;
    for (std::size_t i = 0; i < genuine; ++i)
        far += std::none_of(chosen.begin(), chosen.end(),
                            [&](int j) {
                                return cloud.normals[i].dot(cloud.normals[j]) > 0 &&
                                       (cloud.points[i] - cloud.points[j]).norm() <= 0.06;
                            });
    EXPECT_EQ(far, 0);
}

TEST(ThinToPoissonDisks, DoesNotDependOnThreads)
{
    const Cloud cloud = thin_wall(20000);
    EXPECT_EQ(thin_to_poisson_disks(cloud.points, cloud.normals, cloud.radii, cloud.expected, 1),
              thin_to_poisson_disks(cloud.points, cloud.normals, cloud.radii, cloud.expected, 3));
    EXPECT_TRUE(thin_to_poisson_disks({}, {}, {}, {}, 2).empty());
}
