#include "filter_pn_refine/step/level.h"

#include <gtest/gtest.h>

using namespace recon;
using namespace recon::pn;

namespace
{

TEST(ChildrenMemory, ListsKeepWhatTheyHoldWhenTheyOutgrowIt)
{
    std::vector<WorkPoint> points(20000); // several blocks of memory
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        points[i].position = Point(double(i % 141), double(i / 141), 0);
        points[i].normal = Vector::UnitZ();
        points[i].radius = points[i].spacing = 1;
        points[i].id = int(i);
        points[i].flags = i < 18000 ? std::uint32_t(WorkPoint::refined) : 0u;
    }
    const Level level = make_level(std::move(points));
    ChildrenMemory memory;
    for (int use = 0; use < 2; ++use)
    {
        std::vector<LeafChildren> lists = memory.lists_for(level);
        ASSERT_EQ(lists.size(), level.leaves.size());
        for (const LeafChildren& list : lists)
            EXPECT_EQ(list.count(), 0);
        // Side by side, so that lists that share memory would spoil each other.
        const int most = 3 * leaf_capacity;
        const auto value = [&](std::size_t leaf, int k, int r) { return float(k + 200 * r) + 0.0001f * float(leaf); };
        for (int k = 0; k < most; ++k)
            for (std::size_t i = 0; i < lists.size(); ++i)
            {
                LeafChildren::Row row;
                for (int r = 0; r < 8; ++r)
                    row[std::size_t(r)] = value(i, k, r);
                lists[i].append({int(i), k, use}, row);
            }
        for (std::size_t i = 0; i < lists.size(); ++i)
        {
            const RowsView rows = lists[i].rows();
            ASSERT_EQ(rows.count, most);
            const float* const all[] = {rows.x,  rows.y,  rows.z,      rows.nx,
                                        rows.ny, rows.nz, rows.radius, rows.largest_radius};
            for (int k = 0; k < most; ++k)
            {
                ASSERT_EQ(lists[i].corners()[k], (std::array<int, 3>{int(i), k, use}));
                for (int r = 0; r < 8; ++r)
                    ASSERT_EQ(all[r][k], value(i, k, r));
            }
        }
    }
}

} // namespace
