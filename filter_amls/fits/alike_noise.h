#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace recon
{

/// Factor by which the noise of two places may differ for what is best at one to say something about the other. Clean
/// parts of a cloud want another width, and other weights, than noisy ones beside them.
constexpr double alike_noise = 3;

inline bool is_alike_noise(double a, double b)
{
    return a <= alike_noise * b && b <= alike_noise * a;
}

/// What is known at some places, averaged over all those in alike noise.
template <std::size_t n>
class AlikeMeans
{
public:
    using Values = std::array<double, n>;

    /// \param noise per place, in one unit. \param fewest places that are averaged, the next ones if too few are alike.
    AlikeMeans(const std::vector<double>& noise, const std::vector<Values>& values, std::size_t fewest)
        : sums_(noise.size() + 1, Values{}), fewest_(std::min(fewest, noise.size()))
    {
        for (std::size_t i = 0; i < noise.size(); ++i)
            by_noise_.emplace_back(noise[i], i);
        std::sort(by_noise_.begin(), by_noise_.end());
        for (std::size_t k = 0; k < noise.size(); ++k)
            for (std::size_t j = 0; j < n; ++j)
                sums_[k + 1][j] = sums_[k][j] + values[by_noise_[k].second][j];
    }

    /// Zeros if nothing is known.
    Values around(double noise) const
    {
        std::size_t begin = count_below(noise / alike_noise), end = count_below(noise * alike_noise);
        for (bool is_low = true; end - begin < fewest_; is_low = !is_low)
            if (is_low && begin > 0)
                --begin;
            else if (end < by_noise_.size())
                ++end;
        Values result{};
        for (std::size_t j = 0; j < n && begin < end; ++j)
            result[j] = (sums_[end][j] - sums_[begin][j]) / double(end - begin);
        return result;
    }

private:
    std::size_t count_below(double noise) const
    {
        return std::size_t(std::lower_bound(by_noise_.begin(), by_noise_.end(), std::pair(noise, std::size_t(0))) -
                           by_noise_.begin());
    }

    std::vector<std::pair<double, std::size_t>> by_noise_; ///< With the index of the place.
    std::vector<Values> sums_;                             ///< Of so many by noise.
    std::size_t fewest_;
};

} // namespace recon
