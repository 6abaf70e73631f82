#include <recon/parallel.h>

#include <recon/errors.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace recon
{

int resolve_threads(int threads)
{
    if (threads < 0)
        throw InvalidInput("The number of threads must be 0 (all cores) or more.");
    constexpr int most = 256; // every thread that is started costs time and memory, work or not
    return std::clamp(threads > 0 ? threads : int(std::thread::hardware_concurrency()), 1, most);
}

void parallel_chunks(std::size_t n, int threads, std::size_t grain, const Progress& progress,
                     const std::function<void(std::size_t begin, std::size_t end)>& body)
{
    const std::size_t chunks = (n + grain - 1) / grain;
    std::atomic<std::size_t> next{0};
    std::atomic<bool> stop{false};
    std::mutex mutex;
    std::size_t failed_chunk = chunks;
    std::exception_ptr failure;

    const auto work = [&](bool is_caller)
    {
        while (!stop)
        {
            const std::size_t chunk = next++;
            if (chunk >= chunks)
                return;
            try
            {
                body(chunk * grain, std::min(n, (chunk + 1) * grain));
                if (is_caller)
                    progress.report(double(std::min(next.load(), chunks)) / double(chunks));
            }
            catch (...)
            {
                const std::lock_guard<std::mutex> lock(mutex);
                if (chunk < failed_chunk)
                {
                    failed_chunk = chunk;
                    failure = std::current_exception();
                }
                stop = true;
            }
        }
    };

    const std::size_t helpers = std::min<std::size_t>(std::max(threads, 1) - 1, chunks > 0 ? chunks - 1 : 0);
    std::vector<std::thread> pool;
    pool.reserve(helpers);
    try
    {
        for (std::size_t i = 0; i < helpers; ++i)
            pool.emplace_back(work, false);
    }
    catch (const std::system_error&)
    {
        // The system gives no more threads: those that have started do the work.
    }
    work(true);
    for (std::thread& thread : pool)
        thread.join();
    if (failure)
        std::rethrow_exception(failure);
    if (chunks > 0)
        progress.report(1); // also where the helpers took every chunk: whoever wants to stop is asked
}

void parallel_shares(std::size_t n, int threads, const std::function<void(const Share& share)>& body)
{
    constexpr int most = 8;
    const std::size_t shares = std::size_t(std::clamp(threads, 1, most));
    parallel_chunks(n, threads, std::max<std::size_t>(1, (n + shares - 1) / shares), {},
                    [&](std::size_t begin, std::size_t end) {
                        body({begin, end});
                    });
}

void parallel_invoke(int threads, const std::function<void()>& first, const std::function<void()>& second)
{
    if (threads < 2)
    {
        first();
        second();
        return;
    }
    std::exception_ptr failure;
    std::thread beside(
        [&]
        {
            try
            {
                second();
            }
            catch (...)
            {
                failure = std::current_exception();
            }
        });
    try
    {
        first();
    }
    catch (...)
    {
        beside.join();
        throw;
    }
    beside.join();
    if (failure)
        std::rethrow_exception(failure);
}

} // namespace recon
