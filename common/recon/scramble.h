#pragma once

#include <cstdint>

namespace recon
{

/// Step and finaliser of splitmix64: a fixed random number for each index, the same on every machine.
constexpr std::uint64_t splitmix_step = 0x9e3779b97f4a7c15u;
inline std::uint64_t scramble(std::uint64_t z)
{
    z += splitmix_step;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

} // namespace recon
