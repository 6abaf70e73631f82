#pragma once

#include <cstdint>

namespace recon
{

/// Finaliser of splitmix64: a number that shows no pattern of its argument, the same on every machine.
inline std::uint64_t mix_bits(std::uint64_t z)
{
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/// Step and finaliser of splitmix64: a fixed random number for each index.
constexpr std::uint64_t splitmix_step = 0x9e3779b97f4a7c15u;
inline std::uint64_t scramble(std::uint64_t z)
{
    return mix_bits(z + splitmix_step);
}

/// The same, uniform in [0, 1).
inline double scramble_to_unit(std::uint64_t z)
{
    return double(scramble(z) >> 11) * 0x1p-53;
}

} // namespace recon
