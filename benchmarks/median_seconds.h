#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <vector>

namespace benchmarks
{

/// Median wall-clock time of so many runs [s].
inline double median_seconds(int repetitions, const std::function<void()>& run)
{
    std::vector<double> seconds;
    for (int i = 0; i < repetitions; ++i)
    {
        const auto begin = std::chrono::steady_clock::now();
        run();
        seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    std::sort(seconds.begin(), seconds.end());
    return seconds[seconds.size() / 2];
}

} // namespace benchmarks
