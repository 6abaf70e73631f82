#pragma once

#include <recon/median.h>
#include <recon/parallel.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace recon::pn
{

/// Extremes of many radii and, from some 16,384 of them, their median.
class RadiusSummary
{
public:
    /// For about so many radii in all.
    explicit RadiusSummary(std::size_t expected) : each_(expected / 16384 + 1) {}

    /// Adds n radii, times `unit`.
    template <class Radius>
    void add(const Radius* radii, std::size_t n, double unit, int threads)
    {
        constexpr std::size_t grain = 65536;
        std::vector<Part> parts((n + grain - 1) / grain);
        parallel_chunks(n, threads, grain, {},
                        [&](std::size_t begin, std::size_t end)
                        { parts[begin / grain].take(radii + begin, end - begin, each_, unit); });
        for (const Part& part : parts)
        {
            all_.smallest = std::min(all_.smallest, part.smallest);
            all_.largest = std::max(all_.largest, part.largest);
            all_.picked.insert(all_.picked.end(), part.picked.begin(), part.picked.end());
        }
    }

    double smallest() const { return all_.smallest; }
    double largest() const { return all_.largest; }
    /// \pre a radius was added.
    double median() const { return recon::median(all_.picked); }

private:
    struct Part
    {
        double smallest = std::numeric_limits<double>::infinity(), largest = 0;
        std::vector<double> picked;

        template <class Radius>
        void take(const Radius* radii, std::size_t n, std::size_t each, double unit)
        {
            Radius least = radii[0], most = radii[0];
            for (std::size_t k = 1; k < n; ++k)
            {
                least = radii[k] < least ? radii[k] : least;
                most = radii[k] > most ? radii[k] : most;
            }
            smallest = double(least) * unit;
            largest = double(most) * unit;
            for (std::size_t k = 0; k < n; k += each)
                picked.push_back(double(radii[k]) * unit);
        }
    };

    const std::size_t each_;
    Part all_;
};

} // namespace recon::pn
