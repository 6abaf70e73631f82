#pragma once

#include <recon/progress.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace recon
{

/// Number of threads to use for the option `threads`: 0 = one per core; 256 at most.
/// \throws InvalidInput below 0.
int resolve_threads(int threads);

/// While one lives, the loops that its thread runs share helpers, which sleep between loops: a reconstruction runs a
/// hundred loops and more, and to start threads for each costs more than it saves where cores are many. Within
/// another's life it does nothing.
class ThreadTeam
{
public:
    ThreadTeam();
    ~ThreadTeam(); ///< Ends the helpers.
    ThreadTeam(const ThreadTeam&) = delete;
    ThreadTeam& operator=(const ThreadTeam&) = delete;

    class Helpers;

private:
    std::unique_ptr<Helpers> helpers_; ///< None within another's life.
};

/// Calls body(begin, end) for consecutive chunks of [0, n) of `grain` items (the last may be shorter), on up to
/// `threads` threads, the caller's among them. Chunks do not depend on the number of threads, so a body that writes
/// only what belongs to its items, or one partial sum per chunk, gives the same bits for any number. `progress` is
/// reported on the caller's thread only. \throws what the body throws (of several, that of the lowest chunk among those
/// run), Cancelled.
void parallel_chunks(std::size_t n, int threads, std::size_t grain, const Progress& progress,
                     const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Calls body(i) for every i in [0, n), as parallel_chunks().
template <class Body>
void parallel_for(std::size_t n, int threads, const Progress& progress, Body&& body, std::size_t grain = 256)
{
    parallel_chunks(n, threads, grain, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        for (std::size_t i = begin; i < end; ++i)
                            body(i);
                    });
}

/// What body(i, found) appends to `found` for every i in [0, n), in their order.
template <class Item, class Body>
std::vector<Item> parallel_collect(std::size_t n, int threads, const Progress& progress, Body&& body,
                                   std::size_t grain = 256)
{
    std::vector<std::vector<Item>> parts((n + grain - 1) / grain);
    parallel_chunks(n, threads, grain, progress,
                    [&](std::size_t begin, std::size_t end)
                    {
                        for (std::size_t i = begin; i < end; ++i)
                            body(i, parts[begin / grain]);
                    });
    std::size_t size = 0;
    for (const auto& part : parts)
        size += part.size();
    std::vector<Item> all;
    all.reserve(size);
    for (const auto& part : parts)
        all.insert(all.end(), part.begin(), part.end());
    return all;
}

/// Part of [0, n).
struct Share
{
    std::size_t begin, end;
    bool has(int i) const { return std::size_t(i) - begin < end - begin; } ///< False for what is negative.
};

/// Calls body(share) for one share of [0, n) per thread (eight at most): for work in which each thread goes through all
/// input and keeps what belongs to its share. The result must not depend on how the shares are cut.
void parallel_shares(std::size_t n, int threads, const std::function<void(const Share& share)>& body);

/// Adds to what several threads add to at once. \returns what it was before.
inline int fetch_add(int& sum, int value)
{
    return __atomic_fetch_add(&sum, value, __ATOMIC_RELAXED);
}

/// Runs `first` on the caller's thread and, with more than one thread, `second` beside it; otherwise one after the
/// other. \throws what `first` throws, else what `second` throws, after both have ended.
void parallel_invoke(int threads, const std::function<void()>& first, const std::function<void()>& second);

} // namespace recon
