#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace recon
{

/// Disjoint sets of 0..size - 1 (union-find with path halving). The representative of a set is its lowest member, so results do
/// not depend on the order of joining.
class DisjointSets
{
public:
    explicit DisjointSets(std::size_t size = 0) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0); }

    /// Appends a set of one. \returns its member.
    int add()
    {
        parent_.push_back(int(parent_.size()));
        return parent_.back();
    }
    void clear() { parent_.clear(); }

    /// Representative of the set of `i`.
    int find(int i)
    {
        while (parent_[i] != i)
            i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    /// \returns whether they were in different sets.
    bool join(int a, int b)
    {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
        return a != b;
    }

private:
    std::vector<int> parent_;
};

} // namespace recon
