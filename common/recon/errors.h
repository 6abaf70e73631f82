#pragma once

#include <stdexcept>
#include <string>

namespace recon
{

/// The input or an option cannot be used. The message names the cause and the remedy, in words for the user.
class InvalidInput : public std::invalid_argument
{
public:
    using std::invalid_argument::invalid_argument;
};

/// The input is valid but the method found no result. The message says which step failed and what to try.
class AlgorithmFailure : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// The caller asked to stop; there is no result.
class Cancelled : public std::runtime_error
{
public:
    Cancelled() : std::runtime_error("cancelled") {}
};

} // namespace recon
