#pragma once

#include <algorithm>
#include <vector>

namespace recon
{

/// Union-find in which each node knows whether its label equals its representative's.
class ParityForest
{
public:
    explicit ParityForest(int n) : parent_(std::size_t(n)), parity_(std::size_t(n), 0)
    {
        for (int i = 0; i < n; ++i)
            parent_[i] = i;
    }
    /// Representative; `parity` is turned over for each difference on the way.
    int find(int i, int& parity)
    {
        int root = i, total = 0;
        while (parent_[root] != root)
        {
            total ^= parity_[root];
            root = parent_[root];
        }
        parity ^= total;
        while (parent_[i] != root && i != root)
        {
            const int next = parent_[i], rest = total ^ parity_[i];
            parent_[i] = root;
            parity_[i] = char(total);
            total = rest;
            i = next;
        }
        return root;
    }
    /// Makes the labels of a and b equal, if they are in different clusters.
    void join(int a, int b)
    {
        int ignored = 0;
        a = find(a, ignored);
        b = find(b, ignored);
        if (a != b)
            hang(std::max(a, b), std::min(a, b), 0);
    }
    /// Both must be representatives.
    void hang(int child, int parent, int parity)
    {
        parent_[child] = parent;
        parity_[child] = char(parity);
    }

private:
    std::vector<int> parent_;
    std::vector<char> parity_;
};

} // namespace recon
