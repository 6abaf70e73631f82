#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace recon
{

/// The upper of the two in the middle; 0 of nothing.
inline double median(std::vector<double> values)
{
    if (values.empty())
        return 0;
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace recon
