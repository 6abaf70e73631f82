#pragma once

#include <recon/geometry.h>

#include <algorithm>
#include <cstdint>
#include <unordered_map>

namespace recon::pn
{

/// Points no two of which are nearer than a distance, in a hashed grid of that size.
class SparseSet
{
public:
    explicit SparseSet(double distance) : distance_(distance) {}

    bool has_near(const Point& p) const { return has_near(p, distance_); }

    /// Whether one is nearer than `distance`, or than that of the set if it is less.
    bool has_near(const Point& p, double distance) const
    {
        const double squared = std::min(distance, distance_) * std::min(distance, distance_);
        const Eigen::Array3i cell = cell_of(p);
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    if (const auto found = cells_.find(key(cell + Eigen::Array3i(x, y, z))); found != cells_.end())
                        for (const Point& q : found->second)
                            if ((p - q).squaredNorm() < squared)
                                return true;
        return false;
    }
    void add(const Point& p) { cells_[key(cell_of(p))].push_back(p); }

private:
    Eigen::Array3i cell_of(const Point& p) const { return (p / distance_).array().floor().cast<int>(); }
    static std::uint64_t key(const Eigen::Array3i& c)
    {
        return (std::uint64_t(std::uint32_t(c.x())) * 0x9E3779B97F4A7C15u) ^
               (std::uint64_t(std::uint32_t(c.y())) * 0xC2B2AE3D27D4EB4Fu) ^
               (std::uint64_t(std::uint32_t(c.z())) * 0x165667B19E3779F9u);
    }

    double distance_;
    std::unordered_map<std::uint64_t, Points> cells_;
};

} // namespace recon::pn
