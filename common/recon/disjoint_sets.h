#pragma once

#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace recon
{

/// Disjoint sets of 0..size - 1 (union-find with path halving). The representative of a set is its lowest member, so
/// results do not depend on the order of joining, and many threads may join and find at once (Anderson and Woll 1991).
class DisjointSets
{
public:
    explicit DisjointSets(std::size_t size = 0) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0); }

    /// Representative of the set of `i`.
    int find(int i)
    {
        for (;;)
        {
            const int parent = load(i);
            if (parent == i)
                return i;
            // Whoever has an ancestor for a parent keeps all its ancestors, so it does not matter who writes last.
            const int grandparent = load(parent);
            if (grandparent != parent)
                __atomic_store_n(&parent_[i], grandparent, __ATOMIC_RELAXED);
            i = grandparent;
        }
    }
    /// \returns whether they were in different sets.
    bool join(int a, int b)
    {
        for (;;)
        {
            a = find(a);
            b = find(b);
            if (a == b)
                return false;
            if (a < b)
                std::swap(a, b);
            int root = a; // unless another thread hangs it elsewhere
            if (__atomic_compare_exchange_n(&parent_[a], &root, b, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
                return true;
        }
    }

private:
    int load(int i) const { return __atomic_load_n(&parent_[i], __ATOMIC_RELAXED); }

    std::vector<int> parent_;
};

} // namespace recon
