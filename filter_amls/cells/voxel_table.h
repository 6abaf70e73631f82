#pragma once

#include <recon/geometry.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace recon
{

/// Numbers voxels of several sizes in the order in which they are first asked for.
class VoxelTable
{
public:
    explicit VoxelTable(std::size_t expected)
    {
        std::size_t slots = 64;
        while (slots < 2 * expected)
            slots *= 2;
        slots_.assign(slots, -1);
    }

    /// Number of the voxel that holds `p` on the grid of edge 2^(level / 2). \param inverse_edge inverse_edge(level).
    int find_or_add(const Point& p, int level, double inverse_edge)
    {
        const Key key{std::int64_t(std::floor(p.x() * inverse_edge)), std::int64_t(std::floor(p.y() * inverse_edge)),
                      std::int64_t(std::floor(p.z() * inverse_edge)), level};
        if (2 * keys_.size() >= slots_.size())
            grow();
        std::size_t slot = hash(key) & (slots_.size() - 1);
        while (slots_[slot] >= 0 && !(keys_[slots_[slot]] == key))
            slot = (slot + 1) & (slots_.size() - 1);
        if (slots_[slot] < 0)
        {
            slots_[slot] = int(keys_.size());
            keys_.push_back(key);
        }
        return slots_[slot];
    }

    /// The half octave nearest to an edge.
    static int level_of(double edge) { return int(std::lround(2 * std::log2(edge))); }
    static double inverse_edge(int level) { return std::exp2(-0.5 * level); }

private:
    struct Key
    {
        std::int64_t x, y, z;
        int level;
        bool operator==(const Key& o) const { return x == o.x && y == o.y && z == o.z && level == o.level; }
    };
    static std::size_t hash(const Key& k)
    {
        std::uint64_t h = std::uint64_t(k.x) * 0x9e3779b97f4a7c15ULL;
        h = (h ^ h >> 32 ^ std::uint64_t(k.y)) * 0xc2b2ae3d27d4eb4fULL;
        h = (h ^ h >> 29 ^ std::uint64_t(k.z)) * 0x165667b19e3779f9ULL;
        h = (h ^ h >> 32 ^ std::uint64_t(k.level)) * 0x9e3779b97f4a7c15ULL;
        return std::size_t(h ^ h >> 31);
    }
    void grow()
    {
        slots_.assign(2 * slots_.size(), -1);
        for (std::size_t i = 0; i < keys_.size(); ++i)
        {
            std::size_t slot = hash(keys_[i]) & (slots_.size() - 1);
            while (slots_[slot] >= 0)
                slot = (slot + 1) & (slots_.size() - 1);
            slots_[slot] = int(i);
        }
    }

    std::vector<int> slots_;
    std::vector<Key> keys_;
};

} // namespace recon
