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

/// That of which a share of the others is smaller, the lower of two; 0 of nothing. \param share 0 to 1.
inline double quantile(std::vector<double> values, double share)
{
    if (values.empty())
        return 0;
    const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

} // namespace recon
